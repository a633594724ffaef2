//! The channels of one gap-free stretch on an even grid.

use crate::smoother::{Motion, Observation, Observed, estimate_motion};
use crate::stretches::Stretch;
use crate::{Recording, central_difference, noise_std, rms, spread};
use std::cell::LazyCell;
use std::f64::consts::PI;

/// Channels of one gap-free stretch at one rate, equal lengths, all of them numbers.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Channels {
    /// Index of the recording the stretch belongs to, where several are looked at together.
    pub recording: usize,
    /// Sample period, s.
    pub dt: f64,
    /// Time of the first sample, s.
    pub start: f64,
    /// Position, m or rad.
    pub position: Vec<f64>,
    /// Measured velocity, m/s or rad/s, where the recording has one that is to be trusted.
    pub velocity: Option<Vec<f64>>,
    /// Speed below which the measured velocity lags more than above it, m/s or rad/s, where there is one.
    pub late_below: Option<f64>,
    /// Measured acceleration, m/s² or rad/s², likewise.
    pub acceleration: Option<Vec<f64>>,
    /// Force, N or N·m.
    pub force: Vec<f64>,
    /// Normal load, N.
    pub normal: Option<Vec<f64>>,
    /// What the motion was asked to be, m or rad.
    pub reference: Option<Vec<f64>>,
}

/// Longest average over which a position is looked at as a motion, s, unless its noise asks for a longer one.
const COARSE: f64 = 0.05;

impl Channels {
    /// A part of it, as a stretch of its own.
    #[must_use]
    pub fn part(&self, range: std::ops::Range<usize>) -> Self {
        let of = |column: &Option<Vec<f64>>| column.as_ref().map(|c| c[range.clone()].to_vec());
        Self {
            recording: self.recording,
            dt: self.dt,
            start: self.start + range.start as f64 * self.dt,
            position: self.position[range.clone()].to_vec(),
            velocity: of(&self.velocity),
            late_below: self.late_below,
            acceleration: of(&self.acceleration),
            force: self.force[range.clone()].to_vec(),
            normal: of(&self.normal),
            reference: of(&self.reference),
        }
    }

    /// The columns of a recording over one of its stretches.
    pub(super) fn of(recording: &Recording, stretch: &Stretch) -> Self {
        let grid = |column: &Vec<f64>| stretch.grid(column);
        Self {
            recording: 0,
            dt: stretch.dt,
            start: recording.time[stretch.range.start],
            position: grid(&recording.position),
            velocity: recording.velocity.as_ref().map(grid),
            late_below: None,
            acceleration: recording.acceleration.as_ref().map(grid),
            force: grid(&recording.force),
            normal: recording.normal_force.as_ref().map(grid),
            reference: recording.reference.as_ref().filter(|c| c.iter().all(|x| x.is_finite())).map(grid),
        }
    }

    /// The motion behind the channels.
    #[must_use]
    pub fn motion(&self) -> Motion {
        let time: Vec<f64> = (0..self.len()).map(|i| i as f64 * self.dt).collect();
        let position = Some(Observation::new(Observed::Position, &self.position));
        let velocity = self.velocity.as_ref().map(|v| Observation::new(Observed::Velocity, v));
        let acceleration = self.acceleration.as_ref().map(|a| Observation::new(Observed::Acceleration, a));
        let observations: Vec<_> = [position, velocity, acceleration].into_iter().flatten().collect();
        // finite channels on an even grid are never refused
        estimate_motion(&time, &observations).unwrap_or_default()
    }

    /// Number of samples.
    #[must_use]
    pub fn len(&self) -> usize {
        self.position.len()
    }

    /// No samples at all.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.position.is_empty()
    }

    /// The first `n` samples.
    #[must_use]
    pub fn first(&self, n: usize) -> Self {
        let part = |column: &Vec<f64>| column[..n.min(column.len())].to_vec();
        Self {
            recording: self.recording,
            dt: self.dt,
            start: self.start,
            position: part(&self.position),
            velocity: self.velocity.as_ref().map(part),
            late_below: self.late_below,
            acceleration: self.acceleration.as_ref().map(part),
            force: part(&self.force),
            normal: self.normal.as_ref().map(part),
            reference: self.reference.as_ref().map(part),
        }
    }

    /// Frequency of a sine with the same ratio of velocity to position, Hz.
    #[must_use]
    pub fn dominant_frequency(&self) -> f64 {
        let (n, dt) = (self.len(), self.dt);
        let noise = LazyCell::new(|| noise_std(&self.position));
        let coarse = |step: usize| -> Vec<f64> {
            self.position.chunks(step).map(|c| c.iter().sum::<f64>() / c.len() as f64).collect()
        };
        let speed = |step: usize| rms(&central_difference(&coarse(step), step as f64 * dt));
        let of_noise = |step: usize| *noise / ((2 * step) as f64).sqrt() / (step as f64 * dt);
        // A coarse derivative, so that noise does not count as motion, but not over whole strokes of a long recording.
        let coarsest = (n / 400).max(1);
        let mut step = ((COARSE / dt) as usize).clamp(1, coarsest);
        while 2 * step <= coarsest && of_noise(step) > 0.1 * speed(step) {
            step *= 2;
        }
        let size = spread(&coarse(step));
        if size > 0.0 { speed(step) / (2.0 * PI * size) } else { 0.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frequency_of_a_long_recording_is_that_of_its_motion() {
        for (samples, hz) in [(16_000, 0.8), (1_000_000, 0.8), (1_000_000, 0.002)] {
            let noise = |i: usize| 1e-6 * ((i * 7_919 % 1_009) as f64 / 1_009.0 - 0.5);
            let at = |i: usize| 8e-3 * (2.0 * PI * hz * i as f64 * 1e-3).sin() + noise(i);
            let channels =
                Channels { dt: 1e-3, position: (0..samples).map(at).collect(), ..Channels::default() };
            let found = channels.dominant_frequency();
            println!("{samples} samples at {hz} Hz: {found:.4} Hz");
            assert!((found / hz - 1.0).abs() < 0.05, "{found}");
        }
    }
}
