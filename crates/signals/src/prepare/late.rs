//! Columns that are late. A velocity is an average over the last moment, which is a delay. An accelerometer has a low-pass in
//! front of its converter, or only a delay: a motion as slow as most looks the same through both, a jerk does not.

use super::channels::Channels;
use crate::{LowPass, four_point_difference};
use friction::effects::delayed;

/// Advances the velocity of stretches by `lag` seconds.
pub(super) fn velocity(stretches: &mut [Channels], lag: f64) -> &'static str {
    for s in stretches {
        s.velocity = s.velocity.take().map(|v| advanced(&v, lag, s.dt));
    }
    "advanced by that"
}

/// Advances the acceleration by `lag` seconds or undoes a low-pass with that time constant, whichever agrees better with the
/// position.
pub(super) fn acceleration(stretches: &mut [Channels], lag: f64) -> &'static str {
    let [advanced, restored] = [advanced, restored].map(|mend| {
        let mended = |s: &Channels| s.acceleration.as_ref().map(|a| mend(a, lag, s.dt));
        stretches.iter().map(mended).collect::<Vec<_>>()
    });
    let away = |mended: &[Option<Vec<f64>>]| -> f64 {
        let of =
            |(s, a): (&Channels, &Option<Vec<f64>>)| a.as_ref().map_or(0.0, |a| away(&s.position, a, s.dt));
        stretches.iter().zip(mended).map(of).sum()
    };
    let (mended, done) = if away(&restored) < away(&advanced) {
        (restored, "its low-pass is undone")
    } else {
        (advanced, "advanced by that")
    };
    stretches.iter_mut().zip(mended).for_each(|(s, a)| s.acceleration = a);
    done
}

/// The column `lag` seconds earlier.
fn advanced(column: &[f64], lag: f64, dt: f64) -> Vec<f64> {
    delayed(column, -lag, dt)
}

/// What a low-pass of first order with the time constant `lag` made the column of.
fn restored(column: &[f64], lag: f64, dt: f64) -> Vec<f64> {
    column.iter().zip(four_point_difference(column, dt)).map(|(x, rate)| x + lag * rate).collect()
}

/// Squared difference between an acceleration and the second derivative of the position, up to a tenth of the sampling rate.
fn away(position: &[f64], acceleration: &[f64], dt: f64) -> f64 {
    let filter = LowPass::new(0.1 / dt, dt);
    let derived = four_point_difference(&four_point_difference(&filter.apply(position), dt), dt);
    let settle = filter.settle().min(acceleration.len() / 4);
    let difference = derived.iter().zip(filter.apply(acceleration)).map(|(a, b)| (a - b).powi(2));
    difference.skip(settle).take(acceleration.len() - 2 * settle).sum()
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
        let a = four_point_difference(&four_point_difference(&x, dt), dt);
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
            let [early, undone] = [advanced, restored].map(|mend| away(&x, &mend(&column, lag, dt), dt));
            println!("low-pass {low_pass}: {early:.3e} advanced, {undone:.3e} restored");
            assert_eq!(undone < early, low_pass);
        }
    }
}
