//! From a model to the joint that a format can hold, one step after the other.

use crate::error::Error;
use crate::format::Format;
use friction::effects::{Effect, EffectState};
use friction::{Coulomb, Dimension, Law, Motion};
use identify::{Model, Nuisances};
use nalgebra::{DMatrix, DVector};
use signals::{Geometry, Recording, rms};
use std::f64::consts::TAU;

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
    let holdable: Vec<Option<Held>> = model.effects.iter().map(|e| held_by(format, e)).collect();
    let all = holdable.iter().flatten().fold(Held::default(), |sum, more| sum.plus(*more));
    let mut held = Held::default();
    for (effect, holdable) in model.effects.iter().zip(&holdable) {
        // a constant is held by a spring that rests elsewhere
        if let Some(more) = holdable.filter(|h| h.constant == 0.0 || all.stiffness > 0.0) {
            held = held.plus(more);
            continue;
        }
        let about = effect.kind.about();
        let mut simpler = reduction.model.clone();
        simpler.effects.retain(|e| e.kind != effect.kind);
        reduction.simplify(format!("{} ({})", about.id, about.equation), simpler)?;
    }
    if !model.curves.is_empty() {
        let what = format!("{} of physics without a name", count(model.curves.len(), "curve"));
        let simpler = Model { curves: Vec::new(), ..reduction.model.clone() };
        reduction.simplify(what, simpler)?;
    }
    let law = law(&mut reduction)?;
    joint.friction = law.level_p + held.friction;
    joint.damping = law.viscous_p + held.damping;
    joint.stiffness = held.stiffness;
    // k·(x − rest) = k·x + constant; 0 − 0 has no sign
    joint.spring_rest = if held.stiffness > 0.0 { 0.0 - held.constant / held.stiffness } else { 0.0 };
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
        error: of_model.zip(reduction.error()),
        dropped: reduction.dropped,
        geometry: model.geometry,
    })
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

/// The law of a joint: one level, one damping, nothing more at rest.
fn law(reduction: &mut Reduction<'_>) -> Result<Coulomb<f64>, Error> {
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
    let flat = Coulomb { static_p: full.level_p, static_n: full.level_n, ..full };
    if flat != full {
        let what = format!(
            "static friction {:.4} and {:.4} {unit}: held is sliding friction",
            full.static_p, full.static_n
        );
        let simpler = with(reduction, flat);
        reduction.simplify(what, simpler)?;
    }
    let (level, damping) = (0.5 * (flat.level_p + flat.level_n), 0.5 * (flat.viscous_p + flat.viscous_n));
    let even = Coulomb {
        level_p: level,
        level_n: level,
        static_p: level,
        static_n: level,
        viscous_p: damping,
        viscous_n: damping,
    };
    if even != flat {
        let d = Dimension::DAMPING.unit(reduction.model.geometry);
        let what = format!(
            "direction: friction {:.4} and {:.4} {unit}, damping {:.4} and {:.4} {d}; held are the means {level:.4} and \
             {damping:.4}",
            flat.level_p, flat.level_n, flat.viscous_p, flat.viscous_n
        );
        let simpler = with(reduction, even);
        reduction.simplify(what, simpler)?;
    }
    Ok(even)
}

/// What a format can hold of an effect: F = friction·sgn v + damping·v + stiffness·x + constant.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
struct Held {
    friction: f64,
    damping: f64,
    stiffness: f64,
    constant: f64,
}

impl Held {
    fn plus(self, more: Self) -> Self {
        Self {
            friction: self.friction + more.friction,
            damping: self.damping + more.damping,
            stiffness: self.stiffness + more.stiffness,
            constant: self.constant + more.constant,
        }
    }
}

/// Samples of the motion that shows what an effect is made of.
const PROBE: usize = 600;
/// Sizes of that motion: an effect that begins at a place or a speed is not the same at all of them.
const SIZES: [f64; 3] = [1e-2, 1.0, 1e3];
/// Share of the force, or of a term, that is rounding.
const ROUNDING: f64 = 1e-9;

/// The effect in the terms of a format, if it is nothing else, whatever the size of the motion.
fn held_by(format: Format, effect: &Effect<f64>) -> Option<Held> {
    let all: Option<Vec<Held>> = SIZES.iter().map(|size| held_at(format, effect, *size)).collect();
    let all = all?;
    let first = *all.first()?;
    let like = |a: f64, b: f64| (a - b).abs() <= 1e-6 * a.abs().max(b.abs());
    let same = |h: &Held| {
        like(h.friction, first.friction)
            && like(h.damping, first.damping)
            && like(h.stiffness, first.stiffness)
            && like(h.constant, first.constant)
    };
    let least = first.friction.min(first.damping).min(first.stiffness);
    (all.iter().all(same) && least >= 0.0).then_some(first)
}

/// As [`held_by`] in a motion of this size. The force is computed along a motion in which position, speed, direction, load and
/// applied force vary independently, and compared with the best sum of the terms.
fn held_at(format: Format, effect: &Effect<f64>, size: f64) -> Option<Held> {
    let mut state = EffectState::default();
    let (mut force, mut terms) = (Vec::with_capacity(PROBE), Vec::with_capacity(PROBE));
    let dt = 1e-2;
    let mut last = 0.0;
    for i in 0..PROBE {
        let t = dt * i as f64;
        let (slow, quick) = (TAU * 0.31 * t, TAU * 1.7 * t);
        let position = size * (0.05 * slow.sin() + 0.02 * quick.sin() + 0.004);
        let velocity = size * TAU * (0.0155 * slow.cos() + 0.034 * quick.cos());
        let motion = Motion {
            dt,
            position,
            displacement: position - last,
            velocity,
            applied: 2.0 * (TAU * 0.77 * t).sin(),
            mass: 0.0,
            normal: Some(5.0 + (TAU * 0.53 * t).sin()),
        };
        last = position;
        force.push(effect.step(&mut state, &motion));
        // terms of one size, so that each shows
        terms.push([velocity.signum(), velocity / size, position / size, 1.0]);
    }
    let used = match format {
        Format::Mujoco => 4,
        Format::Urdf => 2,
    };
    let x = DMatrix::from_fn(PROBE, used, |row, column| terms[row][column]);
    let f = DVector::from_vec(force);
    let whole = f.norm();
    let gains = x.clone().svd(true, true).solve(&f, 1e-12).ok()?;
    // an effect that is silent here acts elsewhere
    if !(whole > 0.0 && (&x * &gains - &f).norm() < ROUNDING * whole) {
        return None;
    }
    let held = |i: usize, unit: f64| {
        let share = if i < used { gains[i] * x.column(i).norm() } else { 0.0 };
        if share.abs() > ROUNDING * whole { rounded(gains[i] / unit) } else { 0.0 }
    };
    Some(Held {
        friction: held(0, 1.0),
        damping: held(1, size),
        stiffness: held(2, size),
        constant: held(3, 1.0),
    })
}

/// Without the rounding of the fit: ten significant digits.
fn rounded(x: f64) -> f64 {
    format!("{x:.9e}").parse().unwrap_or(x)
}
