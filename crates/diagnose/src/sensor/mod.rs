//! Effects that sit in a sensor, an estimator or the drive rather than in the contact: what they would add to
//! the force the model predicts, to first order. One file each, listed once below.

use crate::signal::LowPass;
use crate::track::Track;
use friction::effects::Parameter;

mod actuator_lag;
mod backlash;
mod compliance;
mod encoder_eccentricity;
mod force_gain_asymmetry;
mod saturation;
mod time_skew;
mod velocity_lag;

/// Where a sensor or drive effect acts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Acts {
    /// On what the motion is said to be.
    OnMotion,
    /// On what is moved, behind a drive that gives or has play: what it adds follows the acceleration.
    Behind,
    /// On the whole force, in time: its gain is 1 and what is sought is a time.
    InTime,
    /// On the whole force, in size.
    OnForce,
}

/// A sensor or drive effect: its description, and its force per unit gain over a filtered stretch.
#[derive(Debug, Clone, Copy)]
pub struct Sensor {
    /// Catalogue id.
    pub id: &'static str,
    /// Where it acts.
    pub acts: Acts,
    /// One plain sentence.
    pub says: &'static str,
    /// The equation.
    pub equation: &'static str,
    /// Gains, in the order of the columns.
    pub gains: &'static [Parameter],
    /// Parameters the columns depend on non-linearly.
    pub shape: &'static [Parameter],
    /// The columns, at every sample, in front of the filter.
    pub columns: fn(&Track, &[f64; 2]) -> Vec<Vec<f64>>,
}

impl PartialEq for Sensor {
    fn eq(&self, other: &Self) -> bool {
        self.id == other.id
    }
}

/// Every sensor effect.
pub const ALL: &[Sensor] = &[
    time_skew::SENSOR,
    actuator_lag::SENSOR,
    velocity_lag::SENSOR,
    force_gain_asymmetry::SENSOR,
    encoder_eccentricity::SENSOR,
    compliance::SENSOR,
    backlash::SENSOR,
    saturation::SENSOR,
];

/// Share of a transport effect above which it is another time constant that is meant.
pub(crate) const MOST_SHARE: f64 = 1.3;

/// The force that acts, at every sample; `measured` is the measured one put back in time. Where the body slides it is the
/// model's, because the measured one's noise would stand on both sides of the equation, but for what is slow: there the
/// noise is little, and physics that the model does not have yet is most. Where the body may be stuck only the
/// measurement knows.
fn true_force(track: &Track, measured: &[f64]) -> Vec<f64> {
    let left: Vec<f64> =
        (0..track.len()).map(|i| track.mask[i] * (measured[i] - track.force_model[i])).collect();
    let slow = LowPass::new(SLOW * track.filter.cutoff, track.raw.dt).apply(&left);
    (0..track.len())
        .map(|i| {
            let m = track.mask[i];
            m * (track.force_model[i] + slow[i]) + (1.0 - m) * measured[i]
        })
        .collect()
}

/// Share of the cut-off below which the force is taken from the measurement.
const SLOW: f64 = 0.2;

/// `series` delayed by `delay` seconds, between samples by the cubic through four of them, held at the ends.
pub(crate) fn delayed(series: &[f64], delay: f64, dt: f64) -> Vec<f64> {
    let last = series.len().saturating_sub(1);
    let at = |i: isize| series[i.clamp(0, last as isize) as usize];
    (0..series.len())
        .map(|i| {
            let t = (i as f64 - delay / dt).clamp(0.0, last as f64);
            let (low, s) = (t.floor() as isize, t.fract());
            // Lagrange's weights: linear interpolation would be a low-pass, strongest half-way
            let (before, after) = (s + 1.0, s - 1.0);
            let far = s - 2.0;
            at(low - 1) * (-s * after * far / 6.0)
                + at(low) * (before * after * far / 2.0)
                + at(low + 1) * (-before * s * far / 2.0)
                + at(low + 2) * (before * s * after / 6.0)
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ids_are_unique_and_described() {
        for (i, a) in ALL.iter().enumerate() {
            assert!(!a.says.is_empty() && !a.equation.is_empty() && !a.gains.is_empty());
            assert!(ALL[i + 1..].iter().all(|b| b.id != a.id));
        }
    }

    #[test]
    fn a_delay_of_whole_samples_is_exact() {
        let series: Vec<f64> = (0..20).map(|i| f64::from(i * i)).collect();
        let late = delayed(&series, 3e-3, 1e-3);
        assert!((late[10] - series[7]).abs() < 1e-9);
    }

    #[test]
    fn a_delay_between_samples_keeps_the_height_of_a_fast_wave() {
        let wave = |t: f64| (std::f64::consts::TAU * 100.0 * t).sin();
        let series: Vec<f64> = (0..2000).map(|i| wave(f64::from(i) * 1e-3)).collect();
        let late = delayed(&series, 0.5e-3, 1e-3);
        let worst = (10..1990).map(|i| (late[i] - wave(i as f64 * 1e-3 - 0.5e-3)).abs()).fold(0.0, f64::max);
        println!("100 Hz at 1 kHz, half a sample late: worst error {worst:.4}");
        assert!(worst < 0.01);
    }
}
