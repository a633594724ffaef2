//! How far a prediction is determined by the motion: what is not known of direction and acceleration, as a force.

use crate::model::Model;
use crate::preprocess::{Signals, Uncertain};
use friction::{FrictionLaw, Law, Motion};
use signals::{Error, Recording};

/// 1 − E\[sgn v\]² up to which the direction counts as known.
const KNOWN: f64 = 0.05;

/// A predicted force, one entry for each sample of the recording.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Predicted {
    /// N or N·m; NaN where the motion is not known.
    pub force: Vec<f64>,
    /// Standard deviation of it by what is not known of the motion, N or N·m; NaN where the force is. At rest friction
    /// balances anything between its static levels, and this is half of what lies between them.
    pub std: Vec<f64>,
    /// Whether the direction of sliding is known: the body is not at rest, and not within the noise of the velocity of it.
    pub is_sliding: Vec<bool>,
}

impl Model {
    /// [`Model::predict`] with the standard deviation that the motion leaves.
    ///
    /// # Errors
    /// As [`Model::predict`].
    pub fn predict_with_std(&self, recording: &Recording) -> Result<Predicted, Error> {
        let signals = self.signals_of(recording)?;
        let Uncertain { unknown, velocity, acceleration } = signals.uncertain();
        let band = self.band(&signals);
        let delta_v = if let Law::Karnopp(k) = self.law { k.delta_v } else { 0.0 };
        let rests = |i: usize| signals.velocity[i].abs() < delta_v;
        let unknown = |i: usize| if rests(i) { 1.0 } else { unknown[i] };
        let std: Vec<f64> = (0..signals.len())
            .map(|i| {
                let direction = band[i] * unknown(i).sqrt();
                direction.hypot(self.mass * acceleration[i]).hypot(self.slope() * velocity[i])
            })
            .collect();
        let sliding: Vec<f64> =
            (0..signals.len()).map(|i| if unknown(i) < KNOWN { 1.0 } else { 0.0 }).collect();
        let is_sliding = signals.at_recorded(&sliding).iter().map(|s| *s > 0.5).collect();
        let force = self.predict_recorded(&signals);
        Ok(Predicted { force, std: signals.at_recorded(&signals.known(&std)), is_sliding })
    }

    /// Viscous friction, N·s/m, the larger of both directions.
    fn slope(&self) -> f64 {
        match self.law {
            Law::Karnopp(k) => k.b_p.abs().max(k.b_n.abs()),
            Law::Coulomb(c) => c.viscous_p.abs().max(c.viscous_n.abs()),
            _ => 0.0,
        }
    }

    /// Half of what the force differs by between the two directions at each sample, static levels included.
    fn band(&self, signals: &Signals) -> Vec<f64> {
        let motion = signals.kinematics();
        let mut memory = self.memory(signals.velocity.first().copied());
        let (least, raised) = match self.law {
            Law::Karnopp(k) => (k.delta_v * 1.001, 0.5 * ((k.d_p - k.c_p) + (k.d_n - k.c_n)).max(0.0)),
            Law::Coulomb(c) => (0.0, 0.5 * ((c.static_p - c.level_p) + (c.static_n - c.level_n)).max(0.0)),
            _ => (0.0, 0.0),
        };
        (0..signals.len())
            .map(|i| {
                let step = motion.at(i);
                let speed = step.velocity.abs().max(least).max(1e-12);
                let step = Motion { velocity: if step.velocity < 0.0 { -speed } else { speed }, ..step };
                let turned = Motion { velocity: -step.velocity, ..step };
                let mut other = memory.clone();
                let other = self.law.step(&mut other.law, &turned) + self.added(&mut other, &turned);
                let own = self.law.step(&mut memory.law, &step) + self.added(&mut memory, &step);
                0.5 * (own - other).abs() + raised
            })
            .collect()
    }
}
