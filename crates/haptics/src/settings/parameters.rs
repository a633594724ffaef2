//! Parameters by name, as a console and a file know them.

use super::{LawKind, RendererKind, Settings};
use crate::number::{self, Text};
use core::fmt;

/// One parameter as `help` shows it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Parameter {
    /// Name as typed.
    pub name: &'static str,
    /// SI unit, `-` for none.
    pub unit: &'static str,
    /// One line.
    pub what: &'static str,
}

/// A parameter's value.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Value {
    /// A number in the parameter's unit.
    Number(f32),
    /// Both directions of an alias whose directions differ.
    Pair(f32, f32),
    /// A choice.
    Word(&'static str),
}

impl fmt::Display for Value {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Number(x) => write!(f, "{}", Text(x)),
            Self::Pair(p, n) => write!(f, "{} / {}", Text(p), Text(n)),
            Self::Word(word) => f.write_str(word),
        }
    }
}

/// A `set` that could not be understood; nothing has changed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SetError<'a> {
    /// Name that was given.
    pub name: &'a str,
    /// Value that was given.
    pub value: &'a str,
    /// What is wrong with it.
    pub why: SetWhy,
}

/// What is wrong with a `set`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum SetWhy {
    /// No such parameter.
    UnknownParameter,
    /// Not a finite number.
    NotANumber,
    /// None of the words accepted here.
    NotOneOf(&'static str),
    /// The effect exists, but not this parameter; the names it has follow.
    UnknownOfEffect(
        &'static str,
        &'static [friction::effects::Parameter],
        &'static [friction::effects::Parameter],
    ),
    /// All places for effects are taken.
    EffectsFull,
}

impl fmt::Display for SetError<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { name, value, .. } = self;
        match self.why {
            SetWhy::UnknownParameter => write!(f, "no parameter `{name}`; `help` lists them"),
            SetWhy::NotANumber => write!(f, "{name} = `{value}`: accepted is a finite number"),
            SetWhy::NotOneOf(words) => write!(f, "{name} = `{value}`: accepted are {words}"),
            SetWhy::UnknownOfEffect(effect, gains, shape) => {
                write!(f, "no parameter `{name}`; {effect} has")?;
                gains.iter().chain(shape).try_for_each(|p| write!(f, " {}", p.name))
            }
            SetWhy::EffectsFull => {
                write!(f, "{name}: {} effects at most; `set EFFECT off` frees a place", super::MAX_EFFECTS)
            }
        }
    }
}

impl core::error::Error for SetError<'_> {}

/// What the table says of one number: how to read it and where it lives.
type Place = fn(&mut Settings) -> &mut f32;

macro_rules! table {
    ($($name:literal, $unit:literal, $field:ident, $what:literal;)*) => {
        /// Every parameter that is stored, in the order people expect.
        pub const PARAMETERS: &[Parameter] = &[
            Parameter { name: "law", unit: "-", what: "friction law: karnopp, dahl, coulomb or lugre" },
            Parameter { name: "renderer", unit: "-", what: "what rubs: virtual_coupling or stopping_force (a block), impedance (the handle)" },
            $(Parameter { name: $name, unit: $unit, what: $what },)*
        ];

        fn place(name: &str) -> Option<Place> {
            match name {
                $($name => Some(|settings| &mut settings.$field),)*
                _ => None,
            }
        }
    };
}

table! {
    "f_static_p", "N", f_static_p, "static friction against positive motion";
    "f_static_n", "N", f_static_n, "static friction against negative motion";
    "f_dynamic_p", "N", f_dynamic_p, "dynamic friction against positive motion (Dahl: limit)";
    "f_dynamic_n", "N", f_dynamic_n, "dynamic friction against negative motion (Dahl: limit)";
    "damping_p", "N·s/m", damping_p, "viscous damping against positive motion";
    "damping_n", "N·s/m", damping_n, "viscous damping against negative motion";
    "dv", "m/s", dv, "speed taken for zero (karnopp)";
    "mass", "kg", mass, "mass of the virtual block";
    "k_vc", "N/m", k_vc, "stiffness of the virtual coupling (impedance: K_p)";
    "b_vc", "N·s/m", b_vc, "damping of the virtual coupling (impedance: of the stuck spring)";
    "sigma", "N/m", sigma, "bristle stiffness (dahl, lugre)";
    "sigma_1", "N·s/m", sigma_1, "bristle damping (lugre)";
    "stribeck_velocity", "m/s", stribeck_velocity, "speed over which static friction falls to dynamic (lugre)";
}

/// Names that stand for both directions.
pub const ALIASES: &[Parameter] = &[
    Parameter { name: "f_static", unit: "N", what: "static friction, both directions" },
    Parameter { name: "f_dynamic", unit: "N", what: "dynamic friction, both directions" },
    Parameter { name: "damping", unit: "N·s/m", what: "viscous damping, both directions" },
];

/// The two names an alias stands for.
fn directions(name: &str) -> Option<(&'static str, &'static str)> {
    match name {
        "f_static" => Some(("f_static_p", "f_static_n")),
        "f_dynamic" => Some(("f_dynamic_p", "f_dynamic_n")),
        "damping" => Some(("damping_p", "damping_n")),
        _ => None,
    }
}

impl Settings {
    /// Every parameter that is stored; effects come besides, as `EFFECT.PARAMETER`.
    pub const PARAMETERS: &'static [Parameter] = PARAMETERS;

    /// The value of a parameter, an alias or an effect's parameter (`stribeck.force_p`).
    #[must_use]
    pub fn get(&self, name: &str) -> Option<Value> {
        let mut copy = *self;
        match name {
            "law" => Some(Value::Word(self.law.id())),
            "renderer" => Some(Value::Word(self.renderer.id())),
            _ => {
                if let Some((p, n)) = directions(name) {
                    let (p, n) = (*place(p)?(&mut copy), *place(n)?(&mut copy));
                    return Some(if p == n { Value::Number(p) } else { Value::Pair(p, n) });
                }
                match place(name) {
                    Some(place) => Some(Value::Number(*place(&mut copy))),
                    None => self.get_effect(name),
                }
            }
        }
    }

    /// Sets a parameter from text. It is only understood here; whether it may run, [`Settings::validate`] says.
    ///
    /// `EFFECT.PARAMETER` adds the effect if it is not there; `EFFECT off` takes it out.
    ///
    /// # Errors
    /// [`SetError`], one line with what would be accepted; nothing has changed then.
    pub fn set<'a>(&mut self, name: &'a str, value: &'a str) -> Result<(), SetError<'a>> {
        let fail = |why| SetError { name, value, why };
        match name {
            "law" => {
                let words = SetWhy::NotOneOf("karnopp, dahl, coulomb, lugre");
                self.law = LawKind::from_id(value).ok_or(fail(words))?;
            }
            "renderer" => {
                let words = SetWhy::NotOneOf("virtual_coupling, stopping_force, impedance");
                self.renderer = RendererKind::from_id(value).ok_or(fail(words))?;
            }
            _ => {
                let (p, n) = directions(name).unwrap_or((name_of(name), ""));
                if let Some(place_p) = place(p) {
                    let x = number::parse(value).ok_or(fail(SetWhy::NotANumber))?;
                    *place_p(self) = x;
                    if let Some(place_n) = place(n) {
                        *place_n(self) = x;
                    }
                } else {
                    self.set_effect(name, value).map_err(fail)?;
                }
            }
        }
        Ok(())
    }
}

/// The stored name equal to what was typed, or nothing that is stored.
fn name_of(name: &str) -> &'static str {
    PARAMETERS.iter().map(|p| p.name).find(|known| *known == name).unwrap_or("")
}
