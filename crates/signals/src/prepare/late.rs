//! A column that is late is a delayed one, or one behind a low-pass of first order: a motion as slow as most looks the same
//! through both, a jerk does not.

use crate::{LowPass, central_difference};
use friction::effects::delayed;

/// The column `lag` seconds earlier.
pub(super) fn advanced(column: &[f64], lag: f64, dt: f64) -> Vec<f64> {
    delayed(column, -lag, dt)
}

/// What a low-pass of first order with the time constant `lag` made the column of.
pub(super) fn restored(column: &[f64], lag: f64, dt: f64) -> Vec<f64> {
    column.iter().zip(central_difference(column, dt)).map(|(x, rate)| x + lag * rate).collect()
}

/// Squared difference between a column and the derivative of the position of this order, up to a tenth of the sampling rate.
pub(super) fn away(position: &[f64], column: &[f64], order: usize, dt: f64) -> f64 {
    let filter = LowPass::new(0.1 / dt, dt);
    let derivative = (0..order).fold(filter.apply(position), |x, _| central_difference(&x, dt));
    let settle = filter.settle().min(column.len() / 4);
    let difference = derivative.iter().zip(filter.apply(column)).map(|(a, b)| (a - b).powi(2));
    difference.skip(settle).take(column.len() - 2 * settle).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A motion with a kick now and then.
    fn position(i: usize) -> f64 {
        let t = i as f64 * 1e-3;
        0.01 * (9.0 * t).sin() + 2e-5 * (260.0 * t).sin() * (-((t % 0.7) / 0.05).powi(2)).exp()
    }

    #[test]
    fn a_delay_and_a_low_pass_are_told_apart() {
        let (dt, lag) = (1e-3, 1.5e-3);
        let x: Vec<f64> = (0..6000).map(position).collect();
        let a = central_difference(&central_difference(&x, dt), dt);
        let delayed = delayed(&a, lag, dt);
        let mut shown = 0.0;
        let share = 1.0 / (1.0 + lag / dt);
        let low_passed: Vec<f64> = a
            .iter()
            .map(|a| {
                shown += share * (a - shown);
                shown
            })
            .collect();
        for (column, low_pass) in [(delayed, false), (low_passed, true)] {
            let [early, undone] = [advanced, restored].map(|mend| away(&x, &mend(&column, lag, dt), 2, dt));
            println!("low-pass {low_pass}: {early:.3e} advanced, {undone:.3e} restored");
            assert_eq!(undone < early, low_pass);
        }
    }
}
