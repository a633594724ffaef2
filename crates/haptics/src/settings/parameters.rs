//! Parameters by name, for console and files.

use super::{LawKind, RendererKind, Settings};
use crate::number::{self, Text};
use core::fmt;
use friction::effects::{EffectKind, EffectName};
use friction::{Adhesion, Dimension, Geometry, Unit, directions};

/// Description of a parameter, as in `help`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Parameter {
    /// Name as typed.
    pub name: &'static str,
    /// Dimension of a number. None for a choice.
    pub dimension: Option<Dimension>,
    /// One line.
    pub what: &'static str,
}

impl Parameter {
    pub(crate) const fn number(name: &'static str, dimension: Dimension, what: &'static str) -> Self {
        Self { name, dimension: Some(dimension), what }
    }

    /// Its SI unit on a device of this geometry. None for a choice and for a pure number.
    #[must_use]
    pub fn unit(&self, geometry: Geometry) -> Option<Unit> {
        let dimension = self.dimension.filter(|dimension| *dimension != Dimension::NUMBER);
        dimension.map(|dimension| dimension.unit(geometry))
    }
}

/// A parameter's value.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Value {
    /// A number in the parameter's unit.
    Number(f32),
    /// Both values of an alias whose directions differ.
    Pair(f32, f32),
    /// A name from a list.
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

/// A rejected `set`. Nothing has changed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SetError<'a> {
    /// Given name.
    pub name: &'a str,
    /// Given value.
    pub value: &'a str,
    /// Reason.
    pub why: SetWhy,
}

/// Reason why a `set` was rejected.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum SetWhy {
    /// Unknown parameter.
    UnknownParameter,
    /// Unknown setting of the device.
    UnknownDeviceSetting,
    /// Not a finite number.
    NotANumber,
    /// A word that is not accepted, with those that are.
    NotOneOf(&'static str),
    /// Unknown parameter of a known effect.
    UnknownOfEffect(
        EffectName,
        &'static [friction::effects::Parameter],
        &'static [friction::effects::Parameter],
    ),
    /// The number of an effect skips one; this would be the next.
    NextIs(EffectName),
    /// All places for effects are in use.
    EffectsFull,
    /// Unknown parameter of the compensation.
    UnknownOfCompensation,
    /// All places for effects of the device are in use.
    FedFull,
}

impl fmt::Display for SetError<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { name, value, .. } = self;
        match self.why {
            SetWhy::UnknownParameter => write!(f, "unknown parameter `{name}`; `help` lists all"),
            SetWhy::UnknownDeviceSetting => write!(f, "unknown setting `{name}`; `device` lists all"),
            SetWhy::NotANumber => write!(f, "{name} = `{value}`: expected a finite number"),
            SetWhy::NotOneOf(words) => write!(f, "{name} = `{value}`: expected one of {words}"),
            SetWhy::UnknownOfEffect(effect, gains, shape) => {
                write!(f, "unknown parameter `{name}`; {effect} has")?;
                gains.iter().chain(shape).try_for_each(|p| write!(f, " {}", p.name))
            }
            SetWhy::NextIs(next) => write!(f, "{name}: set {next}.PARAMETER first"),
            SetWhy::UnknownOfCompensation => {
                write!(f, "unknown parameter `{name}`; accepted are")?;
                crate::Compensation::PARAMETERS.iter().try_for_each(|p| write!(f, " {}", p.name))?;
                f.write_str(", and EFFECT.PARAMETER of")?;
                let of_position = EffectKind::ALL.iter().filter(|kind| kind.is_of_position());
                of_position.into_iter().try_for_each(|kind| write!(f, " {}", kind.id()))
            }
            SetWhy::FedFull => {
                write!(
                    f,
                    "{name}: at most {} effects; `compensate off` begins again",
                    crate::compensation::MAX_FED
                )
            }
            SetWhy::EffectsFull => {
                write!(f, "{name}: at most {} effects; `set EFFECT off` frees a place", super::MAX_EFFECTS)
            }
        }
    }
}

impl core::error::Error for SetError<'_> {}

/// Entry of the table: description and field of a number.
type Place = fn(&mut Settings) -> &mut f32;

/// Names of the renderers.
#[cfg(not(feature = "admittance"))]
const RENDERERS: &str = "virtual_coupling, stopping_force, impedance";
/// Names of the renderers.
#[cfg(feature = "admittance")]
const RENDERERS: &str = "virtual_coupling, stopping_force, admittance, impedance";

/// What a renderer is, in `help`.
#[cfg(not(feature = "admittance"))]
const RENDERER: &str = "friction on a block: virtual_coupling or stopping_force; on the handle: impedance";
/// What a renderer is, in `help`.
#[cfg(feature = "admittance")]
const RENDERER: &str = "friction on a block: virtual_coupling, stopping_force or, by the load cell, admittance; on the handle: impedance";

macro_rules! table {
    ($($name:literal, $dimension:ident, $field:ident, $what:literal;)*) => {
        /// Every stored parameter, in the order for users.
        pub const PARAMETERS: &[Parameter] = &[
            Parameter { name: "law", dimension: None, what: LawKind::WHAT },
            Parameter { name: "renderer", dimension: None, what: RENDERER },
            $(Parameter::number($name, Dimension::$dimension, $what),)*
            Parameter { name: "adhesion", dimension: None, what: "way a contact yields (hayward_armstrong): stick_slide, stick_slip_slide, stick_creep_slip_slide" },
            Parameter { name: "passivity", dimension: None, what: "on: energy given to the hand that nothing stored is taken back; off" },
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
    "f_static_p", FORCE, f_static_p, "static friction against positive motion";
    "f_static_n", FORCE, f_static_n, "static friction against negative motion";
    "f_dynamic_p", FORCE, f_dynamic_p, "dynamic friction against positive motion (Dahl: limit)";
    "f_dynamic_n", FORCE, f_dynamic_n, "dynamic friction against negative motion (Dahl: limit)";
    "damping_p", DAMPING, damping_p, "viscous damping against positive motion";
    "damping_n", DAMPING, damping_n, "viscous damping against negative motion";
    "dv", VELOCITY, dv, "speed treated as zero (karnopp), or at which static friction is reached (classic)";
    "mass", MASS, mass, "mass of the virtual block";
    "k_vc", STIFFNESS, k_vc, "stiffness of the virtual coupling (impedance: K_p)";
    "b_vc", DAMPING, b_vc, "damping of the virtual coupling (impedance: of the stuck spring)";
    "sigma", STIFFNESS, sigma, "stiffness before sliding (laws with bristles: dahl to armstrong, bristle)";
    "sigma_1", DAMPING, sigma_1, "bristle damping (lugre, elasto_plastic)";
    "stribeck_velocity", VELOCITY, stribeck_velocity, "speed at which static friction falls to dynamic (lugre to majd_simaan)";
    "elastic", NUMBER, elastic, "elastic range, share of f_dynamic (elasto_plastic)";
    "attraction", FORCE_RATE, attraction, "rate at which a slipping element follows the level (maxwell_slip)";
    "memory", TIME, memory, "time constant of the frictional memory (armstrong)";
    "dwell", TIME, dwell, "time at rest after which static friction has risen by half (armstrong)";
    "steepness", NUMBER, steepness, "steepness at rest (majd_simaan)";
}

/// The words of a switch.
const ON: &str = "on";
const OFF: &str = "off";

/// Aliases for both directions.
pub const ALIASES: &[Parameter] = &[
    Parameter::number("f_static", Dimension::FORCE, "static friction, both directions"),
    Parameter::number("f_dynamic", Dimension::FORCE, "dynamic friction, both directions"),
    Parameter::number("damping", Dimension::DAMPING, "viscous damping, both directions"),
];

impl Settings {
    /// Every stored parameter. Effects have theirs as `EFFECT.PARAMETER`.
    pub const PARAMETERS: &'static [Parameter] = PARAMETERS;

    /// Value of a parameter, an alias, or a parameter of an effect (`stribeck.force_p`).
    #[must_use]
    pub fn get(&self, name: &str) -> Option<Value> {
        let mut copy = *self;
        match name {
            "law" => Some(Value::Word(self.law.id())),
            "renderer" => Some(Value::Word(self.renderer.id())),
            "adhesion" => Some(Value::Word(self.adhesion.id())),
            "passivity" => Some(Value::Word(if self.passivity { ON } else { OFF })),
            _ => {
                if let Some([p, n]) = directions(name) {
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

    /// Sets a parameter from text. [`Settings::validate`] decides whether the result may run.
    ///
    /// `EFFECT.PARAMETER` adds the effect if needed; `EFFECT off` removes it. `EFFECT_2` is a second one
    /// of the same kind; `EFFECT_2 off` removes it and those after it.
    ///
    /// # Errors
    /// [`SetError`]: one line that says what would be accepted. Nothing has changed.
    pub fn set<'a>(&mut self, name: &'a str, value: &'a str) -> Result<(), SetError<'a>> {
        let fail = |why| SetError { name, value, why };
        match name {
            "law" => {
                let words = SetWhy::NotOneOf(LawKind::IDS);
                self.law = LawKind::from_id(value).ok_or(fail(words))?;
            }
            "renderer" => {
                let words = SetWhy::NotOneOf(RENDERERS);
                self.renderer = RendererKind::from_id(value).ok_or(fail(words))?;
            }
            "adhesion" => {
                let words = SetWhy::NotOneOf(Adhesion::IDS);
                self.adhesion = Adhesion::from_id(value).ok_or(fail(words))?;
            }
            "passivity" => {
                self.passivity = match value {
                    ON => true,
                    OFF => false,
                    _ => return Err(fail(SetWhy::NotOneOf("on, off"))),
                };
            }
            _ => {
                let [p, n] = directions(name).unwrap_or([name_of(name), ""]);
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

/// The stored name equal to the typed one, or an empty name.
fn name_of(name: &str) -> &'static str {
    PARAMETERS.iter().map(|p| p.name).find(|known| *known == name).unwrap_or("")
}
