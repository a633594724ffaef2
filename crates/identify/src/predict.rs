//! The force a model predicts from the motion alone. The measured force is not used, so the prediction of a recording that was not
//! fitted tests the model.

use crate::model::Model;
use crate::{Preprocess, Signals, prepare};
use friction::effects::{Acts, Effect, EffectState, Quantity, Record, delayed};
use friction::{DahlState, FreeFormState, FrictionLaw, Karnopp, Law, LawState, Motion, Scalar};
use signals::{Error, Recording};
use std::borrow::Cow;

/// Standard deviations of a velocity beyond which its direction is known, whatever the filter made of its noise.
const UNKNOWN: f64 = 8.0;
/// Share of a band of rest that stays where the velocity is exact.
const CREEP: f64 = 0.03;

/// Most rounds in which an applied force settles that effects read, and the change, as a share of it, that is none. A share of nine
/// tenths takes the first to a thousandth.
const ROUNDS: usize = 66;
const SETTLED: f64 = 1e-9;

/// A motion on an even grid; equal lengths.
pub(crate) struct Kinematics<'a> {
    /// s.
    pub dt: f64,
    /// m.
    pub position: &'a [f64],
    /// m/s.
    pub velocity: &'a [f64],
    /// m/s².
    pub acceleration: &'a [f64],
    /// N, where it is known.
    pub normal: Option<&'a [f64]>,
}

impl Kinematics<'_> {
    /// Sample `i`, without an applied force.
    pub fn at(&self, i: usize) -> Motion<f64> {
        Motion {
            dt: self.dt,
            position: self.position[i],
            displacement: self.position[i] - self.position[i.saturating_sub(1)],
            velocity: self.velocity[i],
            applied: 0.0,
            mass: 0.0,
            normal: self.normal.map(|n| n[i]),
        }
    }
}

impl Signals {
    pub(crate) fn kinematics(&self) -> Kinematics<'_> {
        Kinematics {
            dt: self.dt,
            position: &self.position,
            velocity: &self.velocity,
            acceleration: &self.acceleration,
            normal: self.normal_force.as_deref(),
        }
    }
}

/// Memory of a law, of the effects and of the free forms beside it.
#[derive(Clone)]
pub(crate) struct Memory {
    pub law: LawState<f64>,
    effects: Vec<EffectState<f64>>,
    forms: Vec<FreeFormState<f64>>,
}

impl Model {
    /// Predicts the force at every sample of a recording, N or N·m, at the recording's own times. Position, velocity and
    /// acceleration are looked at, the force is not. Gaps of at most four samples are closed; NaN where the velocity is
    /// not known, in longer gaps and in stretches between them that are too short to be filtered.
    ///
    /// # Errors
    /// A model that is not valid, a slide's model for an axis or the other way round, or a recording of which
    /// [`prepare`] can make no signals.
    pub fn predict(&self, recording: &Recording) -> Result<Vec<f64>, Error> {
        Ok(self.predict_recorded(&self.signals_of(recording)?))
    }

    /// The motion of a recording as this model looks at it; refuses what [`Model::predict`] refuses.
    pub(crate) fn signals_of(&self, recording: &Recording) -> Result<Signals, Error> {
        self.validate().map_err(|refused| Error::Parameter {
            parameter: refused.parameter.to_string(),
            value: refused.value.to_string(),
            accepted: format!("accepted from {} to {}", refused.min, refused.max),
        })?;
        if self.geometry != recording.geometry {
            return Err(Error::Recording {
                recording: recording.name.clone(),
                why: format!("a {:?} recording, and the model is {:?}", recording.geometry, self.geometry)
                    .to_lowercase(),
            });
        }
        recording.check_lengths()?;
        let motion = Recording { force: vec![0.0; recording.len()], ..recording.clone() };
        prepare(&motion, &Preprocess::Tribos { cutoff_hz: self.cutoff_hz })
    }

    /// The prediction at the samples of the recording; NaN where the motion is not known.
    pub(crate) fn predict_recorded(&self, signals: &Signals) -> Vec<f64> {
        signals.at_recorded(&signals.known(&self.predict_signals(signals)))
    }

    /// Predicts the force at every sample of prepared signals, N or N·m.
    #[must_use]
    pub fn predict_signals(&self, signals: &Signals) -> Vec<f64> {
        self.narrowed(signals.velocity_error()).force(&signals.kinematics())
    }

    /// The model with a band of rest no wider than the errors of a velocity ask for, whose deviation is `error`.
    ///
    /// A band without a static level above sliding friction stands for a direction that was not known. Where the
    /// velocity is known better than in the recording it was fitted on, so is the direction; what is left of the band
    /// is for contacts at rest, which creep.
    fn narrowed(&self, error: f64) -> Cow<'_, Self> {
        match self.law {
            Law::Karnopp(k) if k.d_p == k.c_p && k.d_n == k.c_n && k.delta_v > UNKNOWN * error => {
                let delta_v = (UNKNOWN * error).max(CREEP * k.delta_v);
                Cow::Owned(Self { law: Law::Karnopp(Karnopp { delta_v, ..k }), ..self.clone() })
            }
            _ => Cow::Borrowed(self),
        }
    }

    /// Force that the force channel would show, N or N·m, at every sample of a motion.
    ///
    /// At rest a motion does not tell the force: friction may balance anything up to its static level. There the
    /// prediction goes in a straight line from sliding friction in one direction to that in the other over the
    /// band ±Δv, which is what is expected of it not knowing more.
    pub(crate) fn force(&self, motion: &Kinematics<'_>) -> Vec<f64> {
        let mut memory = self.memory(motion.velocity.first().copied());
        let out = (0..motion.position.len())
            .map(|i| {
                let step = motion.at(i);
                let carried = self.mass * motion.acceleration[i] + self.friction(&mut memory.law, &step);
                self.applied(&mut memory, &step, carried)
            })
            .collect();
        self.sensed(out, motion)
    }

    /// The applied force of one step, N or N·m, of which mass and law alone need `carried`. A friction that is a share of the applied
    /// force is a share of what overcomes it, too.
    fn applied(&self, memory: &mut Memory, step: &Motion<f64>, carried: f64) -> f64 {
        let reads_force = |e: &Effect<f64>| e.kind.about().reads(Quantity::Force);
        let mut applied = carried;
        if self.effects.iter().any(reads_force) {
            let before = memory.clone();
            for _ in 0..ROUNDS {
                memory.clone_from(&before);
                let next = carried + self.beside(memory, &Motion { applied, ..*step });
                let change = (next - applied).abs();
                applied = next;
                if change <= SETTLED * applied.abs() {
                    break;
                }
            }
        } else {
            applied += self.beside(memory, &Motion { applied, ..*step });
        }
        applied + self.on_force(memory, &Motion { applied, ..*step })
    }

    /// A recording that begins in motion, at `velocity`, begins with the bristle bent.
    pub(crate) fn memory(&self, velocity: Option<f64>) -> Memory {
        let law = match (&self.law, velocity) {
            (Law::Dahl(law), Some(v)) if v > 0.0 => LawState::Dahl(DahlState { z: law.limit_p }),
            (Law::Dahl(law), Some(v)) if v < 0.0 => LawState::Dahl(DahlState { z: -law.limit_n }),
            _ => LawState::default(),
        };
        let effects = vec![EffectState::default(); self.effects.len()];
        Memory { law, effects, forms: vec![FreeFormState::default(); self.curves.len()] }
    }

    /// What effects and free forms add to the law in one step, N or N·m.
    pub(crate) fn added(&self, memory: &mut Memory, step: &Motion<f64>) -> f64 {
        self.beside(memory, step) + self.on_force(memory, step)
    }

    /// The same without effects that are made of the whole force.
    fn beside(&self, memory: &mut Memory, step: &Motion<f64>) -> f64 {
        let free: f64 = self.curves.iter().zip(&mut memory.forms).map(|(c, state)| c.step(state, step)).sum();
        self.effects_that(|acts| !acts.on_whole_force(), memory, step) + free
    }

    /// Those effects.
    fn on_force(&self, memory: &mut Memory, step: &Motion<f64>) -> f64 {
        self.effects_that(Acts::on_whole_force, memory, step)
    }

    fn effects_that(&self, act: impl Fn(Acts) -> bool, memory: &mut Memory, step: &Motion<f64>) -> f64 {
        let effects = self.effects.iter().zip(&mut memory.effects);
        effects.filter(|(e, _)| act(e.kind.about().acts)).map(|(e, state)| e.step(state, step)).sum()
    }

    fn friction(&self, state: &mut LawState<f64>, motion: &Motion<f64>) -> f64 {
        let between = |band: f64, up: f64, down: f64| {
            let v = motion.velocity;
            if band > 0.0 { down + (up - down) * (0.5 + 0.5 * v / band) } else { 0.5 * (up + down) }
        };
        match &self.law {
            Law::Karnopp(k) if k.is_stuck(motion.velocity) => {
                between(k.delta_v, k.c_p + k.b_p * k.delta_v, -k.c_n - k.b_n * k.delta_v)
            }
            Law::Coulomb(c) if motion.velocity == 0.0 => between(0.0, c.level_p, -c.level_n),
            // At v ≠ 0 a stopping force with nothing to stop is the sliding branch.
            Law::Coulomb(c) => {
                let v = motion.velocity;
                if v > 0.0 { c.level_p + c.viscous_p * v } else { -c.level_n + c.viscous_n * v }
            }
            law => law.step(state, motion),
        }
    }

    /// What the sensors make of the force.
    fn sensed(&self, mut force: Vec<f64>, motion: &Kinematics<'_>) -> Vec<f64> {
        let model = force.clone();
        let direction: Vec<f64> = motion.velocity.iter().map(|v| v.sgn()).collect();
        let record = Record {
            dt: motion.dt,
            position: motion.position,
            acceleration: motion.acceleration,
            direction: &direction,
            force: &model,
        };
        for sensor in &self.nuisances.sensors {
            for (f, x) in force.iter_mut().zip(sensor.added(&record)) {
                *f += x;
            }
        }
        if self.nuisances.delay_s != 0.0 {
            force = delayed(&force, self.nuisances.delay_s, motion.dt);
        }
        for f in &mut force {
            *f += self.nuisances.offset;
        }
        force
    }
}
