//! Effects that sit in a sensor, an estimator or the drive rather than in the contact: what they would add to
//! the force the model predicts, to first order. One file each, listed once below.

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

/// A sensor or drive effect: its description, and its force per unit gain over a filtered stretch.
#[derive(Debug, Clone, Copy)]
pub struct Sensor {
    /// Catalogue id.
    pub id: &'static str,
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

/// A first-order lag with time constant `tau`, started in its steady state.
pub(crate) fn lag(series: &[f64], tau: f64, dt: f64) -> Vec<f64> {
    let keep = (-dt / tau.max(1e-300)).exp();
    let mut state = series.first().copied().unwrap_or(0.0);
    series
        .iter()
        .map(|x| {
            state = x + (state - x) * keep;
            state
        })
        .collect()
}

/// `series` delayed by `delay` seconds, interpolated, held at the start.
pub(crate) fn delayed(series: &[f64], delay: f64, dt: f64) -> Vec<f64> {
    let last = series.len().saturating_sub(1) as f64;
    (0..series.len())
        .map(|i| {
            let at = (i as f64 - delay / dt).clamp(0.0, last);
            let low = at.floor() as usize;
            let high = (low + 1).min(series.len() - 1);
            let share = at - low as f64;
            series[low] * (1.0 - share) + series[high] * share
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
}
