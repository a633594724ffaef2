//! From a model to the joint that a format can hold, one step after the other.

use crate::error::Error;
use crate::format::Format;
use crate::part::{Falling, Part, Presliding, Sum, Wave};
use friction::effects::Effect;
use friction::{Coulomb, Dahl, Dimension, Law, LawKind, LuGre, Surface};
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
    /// Bristles that bend before the contact slides; a stiffness of 0 is none.
    pub bristle: Bristle,
    /// Bristles of the friction that falls with the speed, where `bristle` does not carry it.
    pub fall: Bristle,
}

/// The spring and damper of a contact that does not slide yet.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Bristle {
    /// Friction that they carry, N or N·m; the rest of `friction` turns round at once.
    pub level: f64,
    /// σ₀, N/m or N·m/rad.
    pub stiffness: f64,
    /// σ₁, N·s/m or N·m·s/rad.
    pub damping: f64,
    /// What they carry beside `level`.
    pub falling: Falling,
}

/// Frequency of a body on bristles that stand for a contact without presliding, rad/s. Stiffer ones bend less and ask for shorter
/// time steps.
const STIFF: f64 = 1_000.0;
/// Share of a falling friction that stays at high speed: LuGre's law has none without.
const REST: f64 = 1e-3;

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
    /// Waves over the position that it holds.
    pub waves: Vec<Wave>,
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
        self.replace(what, simpler, predicted);
        Ok(())
    }

    /// As [`Self::simplify`], by a model and what the joint predicts on the recording.
    fn replace(&mut self, what: String, simpler: Model, predicted: Option<Vec<f64>>) {
        let lost =
            predicted.as_ref().zip(self.predicted.as_ref()).map(|(after, before)| difference(after, before));
        self.dropped.push(Dropped { what, rms: lost });
        (self.model, self.predicted) = (simpler, predicted);
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
    let (law, bristle) = law(&mut reduction, format)?;
    if format.has_bristles() {
        joint.bristle = bent(&mut reduction, &held, &law, bristle)?;
        if let Some(falls) = held.falls {
            joint.fall = fall(&mut reduction, held.falling, &falls)?;
        }
    }
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
        waves: held.waves,
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
    /// The effect that falls.
    falls: Option<Effect<f64>>,
    /// The effect of bristles, and what it is.
    bends: Option<(Effect<f64>, Presliding)>,
    by_speed: Vec<Effect<f64>>,
    by_place: Vec<Effect<f64>>,
    waves: Vec<Wave>,
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
            simpler.effects.iter_mut().filter(|e| **e == effect).for_each(|e| *e = even);
            reduction.simplify(what, simpler)?;
        }
    }
    let parts = parts(reduction);
    let stiffness = parts.iter().filter_map(|(_, part)| part.as_ref()?.sum()).map(|sum| sum.stiffness).sum();
    let has_constant = format.has_constant() || 0.0 < stiffness;
    // of several lengths of bristles a format holds one
    let bristles = parts.iter().filter_map(|(effect, part)| match part {
        Some(Part::Presliding(bristles)) => Some((bristles.force, *effect)),
        _ => None,
    });
    let strongest = bristles.max_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, effect)| effect);
    let mut held = Held::default();
    for (effect, part) in parts {
        let about = effect.kind.about();
        match part {
            Some(Part::Sum(sum)) if sum.constant == 0.0 || has_constant => held.sum = held.sum.plus(sum),
            Some(Part::Falling(falling)) if held.falling.force == 0.0 => {
                (held.falling, held.falls) = (falling, Some(effect));
            }
            Some(Part::Presliding(bristles))
                if strongest == Some(effect) && !has_bristles(&reduction.model) =>
            {
                held.bends = Some((effect, bristles));
            }
            Some(Part::Waves(waves)) => held.waves.extend(waves.iter().filter(|w| w.amplitude > 0.0)),
            Some(Part::Speed) => held.by_speed.push(effect),
            Some(Part::Place) if has_stroke => held.by_place.push(effect),
            other => {
                let wanted = if other == Some(Part::Place) {
                    "; held with --recording, whose stroke its table covers"
                } else {
                    ""
                };
                let mut simpler = reduction.model.clone();
                simpler.effects.retain(|e| *e != effect);
                reduction.simplify(format!("{} ({}){wanted}", about.id, about.equation), simpler)?;
            }
        }
    }
    Ok(held)
}

/// Whether the law has bristles.
fn has_bristles(model: &Model) -> bool {
    model.law.kind().takes("sigma")
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

/// What sliding takes, and the bristles of a law that has them.
type OfLaw = (Coulomb<f64>, Option<Bristle>);

/// The law of a joint: one level, one damping, and nothing more at rest, or what the format holds of that.
fn law(reduction: &mut Reduction<'_>, format: Format) -> Result<OfLaw, Error> {
    if format.has_bristles()
        && let Some(held) = bristles(reduction)?
    {
        return Ok(held);
    }
    let unit = Dimension::FORCE.unit(reduction.model.geometry);
    let kind = reduction.model.law.kind();
    let surface = Surface::of(&reduction.model.law);
    let full = Coulomb {
        level_p: surface.dynamic_p,
        level_n: surface.dynamic_n,
        static_p: surface.static_p.max(surface.dynamic_p),
        static_n: surface.static_n.max(surface.dynamic_n),
        viscous_p: surface.damping_p,
        viscous_n: surface.damping_n,
    };
    let presliding = kind.takes("sigma").then_some(surface.sigma);
    let with = |reduction: &Reduction<'_>, law| Model { law: Law::Coulomb(law), ..reduction.model.clone() };
    if let Some(sigma) = presliding {
        let stiffness = Dimension::STIFFNESS.unit(reduction.model.geometry);
        let what = format!("presliding: the contact is a spring of {sigma:.4e} {stiffness} before it slides");
        let simpler = with(reduction, full);
        reduction.simplify(what, simpler)?;
    } else if kind.takes("stribeck_velocity") {
        let what = format!("{}: friction near rest is a curve of speed; held is a level", kind.id());
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
    Ok((even, None))
}

/// A law of bristles as LuGre's with one level.
fn bristles(reduction: &mut Reduction<'_>) -> Result<Option<OfLaw>, Error> {
    let even = |level: f64, viscous: f64| Coulomb {
        level_p: level,
        level_n: level,
        static_p: level,
        static_n: level,
        viscous_p: viscous,
        viscous_n: viscous,
    };
    let kind = reduction.model.law.kind();
    if kind.takes("sigma") && !matches!(kind, LawKind::Dahl | LawKind::LuGre) {
        let nearest = if kind.takes("stribeck_velocity") { LawKind::LuGre } else { LawKind::Dahl };
        let law = Surface::of(&reduction.model.law).law(nearest);
        let what = format!("{}: held are the bristles of {}", kind.id(), nearest.id());
        let simpler = Model { law, ..reduction.model.clone() };
        reduction.simplify(what, simpler)?;
    }
    Ok(match reduction.model.law {
        Law::LuGre(l) => {
            let falling = Falling {
                force: (l.stiction - l.coulomb).max(0.0),
                speed: l.stribeck_velocity,
                exponent: 2.0,
            };
            let bristle = Bristle { level: l.coulomb, stiffness: l.sigma_0, damping: l.sigma_1, falling };
            Some((even(l.coulomb, l.sigma_2), Some(bristle)))
        }
        Law::Dahl(d) => {
            let with =
                |reduction: &Reduction<'_>, law| Model { law: Law::Dahl(law), ..reduction.model.clone() };
            let level = 0.5 * (d.limit_p + d.limit_n);
            let mean = friction::Dahl { limit_p: level, limit_n: level, ..d };
            if mean != d {
                let unit = Dimension::FORCE.unit(reduction.model.geometry);
                let what = format!(
                    "direction: friction {:.4} and {:.4} {unit}; held is the mean {level:.4}",
                    d.limit_p, d.limit_n
                );
                let simpler = with(reduction, mean);
                reduction.simplify(what, simpler)?;
            }
            if mean.exponent != 1.0 {
                let what = format!("presliding: exponent {}; held is 1", mean.exponent);
                let simpler = with(reduction, friction::Dahl { exponent: 1.0, ..mean });
                reduction.simplify(what, simpler)?;
            }
            Some((even(level, d.viscous), Some(Bristle { level, stiffness: d.sigma, ..Bristle::default() })))
        }
        _ => None,
    })
}

/// The bristles of law or effect. More of them than there is friction are held as friction on bristles alone.
fn bent(
    reduction: &mut Reduction<'_>,
    held: &Held,
    law: &Coulomb<f64>,
    bristle: Option<Bristle>,
) -> Result<Bristle, Error> {
    let Some((effect, b)) = held.bends else { return Ok(bristle.unwrap_or_default()) };
    let of_effect = |level: f64| Bristle { level, stiffness: level / b.distance, ..Bristle::default() };
    let level = law.level_p;
    if b.force > level {
        let unit = Dimension::FORCE.unit(reduction.model.geometry);
        let dahl = Dahl {
            limit_p: level,
            limit_n: level,
            sigma: level / b.distance,
            exponent: 1.0,
            viscous: law.viscous_p,
        };
        let mut simpler = Model { law: Law::Dahl(dahl), ..reduction.model.clone() };
        simpler.effects.retain(|e| *e != effect);
        let id = effect.kind.about().id;
        reduction
            .simplify(format!("{id} of {:.4} {unit}: held is the friction, {level:.4}", b.force), simpler)?;
    }
    Ok(of_effect(b.force.min(level)))
}

/// Friction that falls with the speed, on stiff bristles of its own: beside friction that turns round at once it turns round over a
/// distance.
fn fall(reduction: &mut Reduction<'_>, falling: Falling, effect: &Effect<f64>) -> Result<Bristle, Error> {
    let bristle = Bristle {
        level: REST * falling.force,
        stiffness: reduction.model.mass * STIFF * STIFF,
        damping: 0.0,
        falling: Falling { force: (1.0 - REST) * falling.force, ..falling },
    };
    let exponent = if falling.exponent == 2.0 {
        String::new()
    } else {
        format!(", and the exponent is 2 instead of {}", falling.exponent)
    };
    let unit = Dimension::STIFFNESS.unit(reduction.model.geometry);
    let what = format!(
        "reversal of {}: bristles of {:.4e} {unit} bend first{exponent}",
        effect.kind.about().id,
        bristle.stiffness
    );
    // the force of these bristles alone, of a body without a mass
    let lugre = LuGre {
        sigma_0: bristle.stiffness,
        sigma_1: 0.0,
        sigma_2: 0.0,
        coulomb: bristle.level,
        stiction: falling.force,
        stribeck_velocity: falling.speed,
    };
    let alone = Model {
        law: Law::LuGre(lugre),
        mass: f64::MIN_POSITIVE,
        effects: Vec::new(),
        ..reduction.model.clone()
    };
    let mut rest = reduction.model.clone();
    rest.effects.retain(|e| e != effect);
    let predicted = reduction
        .recording
        .map(|r| {
            let (rest, alone) = (rest.predict(r)?, alone.predict(r)?);
            Ok::<_, Error>(rest.iter().zip(&alone).map(|(a, b)| a + b).collect::<Vec<f64>>())
        })
        .transpose()?;
    reduction.replace(what, rest, predicted);
    Ok(bristle)
}
