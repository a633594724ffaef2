//! From a model to the joint that a format can hold, one step after the other.

use crate::error::Error;
use crate::format::Format;
use crate::part::{Falling, Part, Sum};
use friction::effects::Effect;
use friction::{Coulomb, Dimension, Law};
use identify::{Model, Nuisances};
use signals::{Geometry, Recording, rms};

/// A joint as simulators have it.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Joint {
    /// Moving mass, kg, or inertia, kg·m².
    pub mass: f64,
    /// Dry friction in both directions, N or N·m.
    pub friction: f64,
    /// N·s/m or N·m·s/rad.
    pub damping: f64,
    /// N/m or N·m/rad.
    pub stiffness: f64,
    /// Where the spring is at rest, m or rad.
    pub spring_rest: f64,
    /// Dry friction that a resting body must overcome, N or N·m; `friction` in a format that has one level.
    pub break_away: f64,
    /// Constant force against positive motion, N or N·m, beside that of the spring.
    pub constant: f64,
    /// Dry friction per applied force.
    pub per_load: f64,
    /// Dry friction that falls with the speed.
    pub falling: Falling,
}

/// One thing that the format cannot hold.
#[derive(Debug, Clone, PartialEq)]
pub struct Dropped {
    /// The part of the model that is left out, and what the format has in its place.
    pub what: String,
    /// Root mean square of the force that is lost on the recording, N or N·m; None without a recording.
    pub rms: Option<f64>,
}

/// A model in a format.
#[derive(Debug, Clone, PartialEq)]
pub struct Exported {
    /// The file.
    pub text: String,
    /// What it holds.
    pub joint: Joint,
    /// Effects that it holds as a table over the speed.
    pub by_speed: Vec<Effect<f64>>,
    /// Effects that it holds as a table over the position.
    pub by_place: Vec<Effect<f64>>,
    /// What it does not hold.
    pub dropped: Vec<Dropped>,
    /// Error of the force on the recording, unfiltered root mean square: of the model, and of the joint.
    pub error: Option<(f64, f64)>,
    /// Slide or axis.
    pub geometry: Geometry,
}

impl Exported {
    /// What is dropped, one line each, and what all of it costs on the recording.
    #[must_use]
    pub fn lines(&self) -> Vec<String> {
        let unit = Dimension::FORCE.unit(self.geometry);
        let line = |d: &Dropped| match d.rms {
            Some(rms) => format!("{}: {rms:.3e} {unit} rms on the recording", d.what),
            None => d.what.clone(),
        };
        let mut lines: Vec<String> = self.dropped.iter().map(line).collect();
        if let Some((model, joint)) = self.error {
            lines.push(format!(
                "on the recording the model errs by {model:.3e} {unit} rms, this joint by {joint:.3e}"
            ));
        }
        if lines.is_empty() {
            lines.push("nothing: the joint is the model".into());
        }
        lines
    }
}

/// A model that loses one thing after the other.
struct Reduction<'a> {
    model: Model,
    recording: Option<&'a Recording>,
    predicted: Option<Vec<f64>>,
    dropped: Vec<Dropped>,
}

impl<'a> Reduction<'a> {
    fn new(model: Model, recording: Option<&'a Recording>) -> Result<Self, Error> {
        let predicted = recording.map(|r| model.predict(r)).transpose()?;
        Ok(Self { model, recording, predicted, dropped: Vec::new() })
    }

    /// Replaces the model by a simpler one, and notes what that loses.
    fn simplify(&mut self, what: String, simpler: Model) -> Result<(), Error> {
        let predicted = self.recording.map(|r| simpler.predict(r)).transpose()?;
        let lost =
            predicted.as_ref().zip(self.predicted.as_ref()).map(|(after, before)| difference(after, before));
        self.dropped.push(Dropped { what, rms: lost });
        (self.model, self.predicted) = (simpler, predicted);
        Ok(())
    }

    /// Error of the force on the recording.
    fn error(&self) -> Option<f64> {
        self.recording.zip(self.predicted.as_ref()).map(|(r, predicted)| difference(&r.force, predicted))
    }
}

/// Root mean square of a difference, where both are numbers.
fn difference(one: &[f64], other: &[f64]) -> f64 {
    let both = one.iter().zip(other).map(|(a, b)| a - b);
    rms(&both.filter(|d| d.is_finite()).collect::<Vec<f64>>())
}

pub(crate) fn reduce(
    model: &Model,
    format: Format,
    recording: Option<&Recording>,
) -> Result<Exported, Error> {
    model.validate().map_err(|refused| Error::Parameter {
        parameter: refused.parameter,
        value: refused.value,
        accepted: format!("accepted from {} to {}", refused.min, refused.max),
    })?;
    if !(model.mass > 0.0) {
        let accepted = "a moving body with a mass above 0 is accepted".into();
        return Err(Error::Parameter { parameter: "mass", value: model.mass, accepted });
    }
    let mut reduction = Reduction::new(model.clone(), recording)?;
    let of_model = reduction.error();
    let mut joint = Joint { mass: model.mass, ..Joint::default() };

    instruments(&mut reduction)?;
    let held = effects(&mut reduction, format, recording.is_some())?;
    if !model.curves.is_empty() {
        let what = format!("{} of physics without a name", count(model.curves.len(), "curve"));
        let simpler = Model { curves: Vec::new(), ..reduction.model.clone() };
        reduction.simplify(what, simpler)?;
    }
    let law = law(&mut reduction, format)?;
    // half the difference of the directions is a constant
    let constant = held.sum.constant + 0.5 * (law.level_p - law.level_n);
    joint.friction = 0.5 * (law.level_p + law.level_n) + held.sum.friction;
    joint.break_away = 0.5 * (law.static_p + law.static_n) + held.sum.friction;
    joint.damping = law.viscous_p + held.sum.damping;
    joint.stiffness = held.sum.stiffness;
    joint.per_load = held.sum.per_load;
    joint.falling = held.falling;
    if format.has_constant() {
        joint.constant = constant;
    } else if held.sum.stiffness > 0.0 {
        // k·(x − rest) = k·x + constant; 0 − 0 has no sign
        joint.spring_rest = 0.0 - constant / held.sum.stiffness;
    }
    if joint.damping < 0.0 {
        return Err(Error::Parameter {
            parameter: "damping",
            value: joint.damping,
            accepted: "from 0 is accepted: with less a simulator gains energy from friction".into(),
        });
    }
    Ok(Exported {
        text: String::new(),
        joint,
        by_speed: held.by_speed,
        by_place: held.by_place,
        error: of_model.zip(reduction.error()),
        dropped: reduction.dropped,
        geometry: model.geometry,
    })
}

/// What the joint holds of the effects.
#[derive(Default)]
struct Held {
    sum: Sum,
    falling: Falling,
    by_speed: Vec<Effect<f64>>,
    by_place: Vec<Effect<f64>>,
}

/// What the format holds of the effects, as a sum, over the speed, and over the position; drops the others.
fn effects(reduction: &mut Reduction<'_>, format: Format, has_stroke: bool) -> Result<Held, Error> {
    let parts = |reduction: &Reduction<'_>| -> Vec<(Effect<f64>, Option<Part>)> {
        reduction.model.effects.iter().map(|e| (*e, Part::of(format, e))).collect()
    };
    // what is not the same in both directions is held as its mean
    for (effect, part) in parts(reduction) {
        let even = even(&effect);
        if part.is_none() && even != effect && Part::of(format, &even).is_some() {
            let what =
                format!("direction of {}: held is the mean of both directions", effect.kind.about().id);
            let mut simpler = reduction.model.clone();
            simpler.set_effect(even);
            reduction.simplify(what, simpler)?;
        }
    }
    let parts = parts(reduction);
    let stiffness = parts.iter().filter_map(|(_, part)| part.as_ref()?.sum()).map(|sum| sum.stiffness).sum();
    let has_constant = format.has_constant() || 0.0 < stiffness;
    let mut held = Held::default();
    for (effect, part) in parts {
        let about = effect.kind.about();
        match part {
            Some(Part::Sum(sum)) if sum.constant == 0.0 || has_constant => held.sum = held.sum.plus(sum),
            Some(Part::Falling(falling)) if held.falling.force == 0.0 => held.falling = falling,
            Some(Part::Speed) => held.by_speed.push(effect),
            Some(Part::Place) if has_stroke => held.by_place.push(effect),
            other => {
                let wanted = if other == Some(Part::Place) {
                    "; held with --recording, whose stroke its table covers"
                } else {
                    ""
                };
                let mut simpler = reduction.model.clone();
                simpler.effects.retain(|e| e.kind != effect.kind);
                reduction.simplify(format!("{} ({}){wanted}", about.id, about.equation), simpler)?;
            }
        }
    }
    Ok(held)
}

/// The effect with the mean of those gains that belong to one direction each.
fn even(effect: &Effect<f64>) -> Effect<f64> {
    let mut even = *effect;
    for together in effect.kind.about().groups.first().copied().unwrap_or_default() {
        let mean = together.iter().map(|i| effect.gains[*i]).sum::<f64>() / together.len() as f64;
        together.iter().for_each(|i| even.gains[*i] = mean);
    }
    even
}

fn count(n: usize, what: &str) -> String {
    format!("{n} {what}{}", if n == 1 { "" } else { "s" })
}

/// Drops what the measurement adds: a joint has no sensors.
fn instruments(reduction: &mut Reduction<'_>) -> Result<(), Error> {
    let n = reduction.model.nuisances.clone();
    let mut names: Vec<String> = Vec::new();
    if n.offset != 0.0 {
        let unit = Dimension::FORCE.unit(reduction.model.geometry);
        names.push(format!("offset of the force channel {:.4} {unit}", n.offset));
    }
    if n.delay_s != 0.0 {
        names.push(format!("delay of the force channel {:.3e} s", n.delay_s));
    }
    names.extend(n.sensors.iter().map(|s| s.kind.about().id.to_owned()));
    if names.is_empty() {
        return Ok(());
    }
    let simpler = Model { nuisances: Nuisances::default(), ..reduction.model.clone() };
    reduction.simplify(format!("sensors and drive: {}", names.join(", ")), simpler)
}

/// The law of a joint: one level, one damping, and nothing more at rest, or what the format holds of that.
fn law(reduction: &mut Reduction<'_>, format: Format) -> Result<Coulomb<f64>, Error> {
    let unit = Dimension::FORCE.unit(reduction.model.geometry);
    let (full, presliding) = match reduction.model.law {
        Law::Coulomb(c) => (c, None),
        Law::Karnopp(k) => {
            let c = Coulomb {
                level_p: k.c_p,
                level_n: k.c_n,
                static_p: k.d_p.max(k.c_p),
                static_n: k.d_n.max(k.c_n),
                viscous_p: k.b_p,
                viscous_n: k.b_n,
            };
            (c, None)
        }
        Law::Dahl(d) => {
            let c = Coulomb {
                level_p: d.limit_p,
                level_n: d.limit_n,
                static_p: d.limit_p,
                static_n: d.limit_n,
                viscous_p: d.viscous,
                viscous_n: d.viscous,
            };
            (c, Some(d.sigma))
        }
        Law::LuGre(l) => {
            let c = Coulomb {
                level_p: l.coulomb,
                level_n: l.coulomb,
                static_p: l.stiction,
                static_n: l.stiction,
                viscous_p: l.sigma_2,
                viscous_n: l.sigma_2,
            };
            (c, Some(l.sigma_0))
        }
    };
    let with = |reduction: &Reduction<'_>, law| Model { law: Law::Coulomb(law), ..reduction.model.clone() };
    if let Some(sigma) = presliding {
        let stiffness = Dimension::STIFFNESS.unit(reduction.model.geometry);
        let what = format!("presliding: the contact is a spring of {sigma:.4e} {stiffness} before it slides");
        let simpler = with(reduction, full);
        reduction.simplify(what, simpler)?;
    }
    let flat = if format.has_break_away() {
        full
    } else {
        Coulomb { static_p: full.level_p, static_n: full.level_n, ..full }
    };
    if flat != full {
        let what = format!(
            "static friction {:.4} and {:.4} {unit}: held is sliding friction",
            full.static_p, full.static_n
        );
        let simpler = with(reduction, flat);
        reduction.simplify(what, simpler)?;
    }
    let mean = |p: f64, n: f64| 0.5 * (p + n);
    let (level, damping) = (mean(flat.level_p, flat.level_n), mean(flat.viscous_p, flat.viscous_n));
    let constant = if format.has_constant() { 0.5 * (flat.level_p - flat.level_n) } else { 0.0 };
    // break-away is at least the friction of its direction
    let rise = (mean(flat.static_p, flat.static_n) - level).max(0.0);
    let even = Coulomb {
        level_p: level + constant,
        level_n: level - constant,
        static_p: level + constant + rise,
        static_n: level - constant + rise,
        viscous_p: damping,
        viscous_n: damping,
    };
    let differs = [even.level_p - flat.level_p, even.level_n - flat.level_n]
        .into_iter()
        .chain([even.static_p - flat.static_p, even.static_n - flat.static_n])
        .any(|d| d.abs() > 1e-12 * level);
    if differs || even.viscous_p != flat.viscous_p || even.viscous_n != flat.viscous_n {
        let d = Dimension::DAMPING.unit(reduction.model.geometry);
        let friction = format!("friction {:.4} and {:.4} {unit}", flat.level_p, flat.level_n);
        let dampings = format!("damping {:.4} and {:.4} {d}", flat.viscous_p, flat.viscous_n);
        let what = match (format.has_constant(), format.has_break_away()) {
            (true, _) => format!(
                "direction: break-away {:.4} and {:.4} {unit}, {dampings}; held are {:.4} and {:.4} {unit}, {damping:.4} {d}",
                flat.static_p, flat.static_n, even.static_p, even.static_n
            ),
            _ => format!("direction: {friction}, {dampings}; held are the means {level:.4} and {damping:.4}"),
        };
        let simpler = with(reduction, even);
        reduction.simplify(what, simpler)?;
    }
    Ok(even)
}
