//! Play between drive and load.

use super::{About, Acts, Describe, Parameter, Quantity, Scale, Seat};
use crate::Dimension;

/// Play between drive and load: the load flies on freely while the play is crossed and is caught at its other end.
///
/// The load is simulated behind the measured drive: it keeps its speed inside the play, and takes on the drive's where
/// the play ends (a plastic blow).
///
/// ```
/// # #[cfg(feature = "alloc")] {
/// use friction::effects::{Record, SeriesKind};
///
/// let (still, shaken) = ([0.0; 9], [5.0; 9]);
/// let record = Record { dt: 1e-3, position: &still, acceleration: &shaken, direction: &still, force: &still };
/// // m/s²: within the play the drive does not carry the load
/// assert_eq!(SeriesKind::Backlash.added(0, &[1e-3, 0.0], &record), [-5.0; 9]);
/// # }
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Backlash;

impl Describe for Backlash {
    const ABOUT: About = About {
        id: "backlash",
        says: "a play between drive and load: for a stretch the load is out of contact",
        equation: "F = F_model + mass·(a₂ − a), a₂ = 0 within the play of length gap, v₂ = v at its ends",
        shows: "−m·a after a reversal of the force",
        confused_with: "presliding",
        told_apart_by: "an encoder on the load",
        gains: &[Parameter::gain("mass", Dimension::MASS, (0.0, 1e6), "mass of the load behind the play")],
        shape: &[Parameter::shape("gap", Scale::Distance, (1e-7, 1.0), "play, from end to end")],
        reads: &[Quantity::Displacement, Quantity::Acceleration, Quantity::Time],
        seat: Seat::Drive,
        acts: Acts::Behind,
        ..About::EFFECT
    };
}

#[cfg(feature = "alloc")]
mod operator {
    use super::Backlash;
    use crate::effects::series::{Operator, Record, difference};
    use alloc::vec::Vec;

    /// Acceleration of a free body inside a box of length `gap` that moves as `drive` (both m), with plastic blows at its
    /// ends: a load behind a play.
    fn load_in_play(drive: &[f64], gap: f64, dt: f64) -> Vec<f64> {
        let half = 0.5 * gap;
        let (mut x, mut v) = (drive.first().copied().unwrap_or(0.0), 0.0_f64);
        let mut before = x;
        drive
            .iter()
            .map(|&at| {
                let speed = (at - before) / dt;
                before = at;
                let was = v;
                x += v * dt;
                if x > at + half {
                    (x, v) = (at + half, v.min(speed));
                } else if x < at - half {
                    (x, v) = (at - half, v.max(speed));
                }
                (v - was) / dt
            })
            .collect()
    }

    impl Operator for Backlash {
        fn added(_gain: usize, &[gap, _]: &[f64; 2], record: &Record<'_>) -> Vec<f64> {
            difference(&load_in_play(record.position, gap, record.dt), record.acceleration)
        }
    }

    #[cfg(test)]
    mod tests {
        use super::*;

        #[test]
        fn a_load_flies_on_when_the_drive_turns_back() {
            let (dt, gap) = (1e-4, 0.02);
            // forward at 1 m/s for 0.1 s, then backward: the load crosses the play at 2 m/s against the drive
            let drive: Vec<f64> =
                (0..2000).map(|i| f64::from(i) * dt).map(|t| if t < 0.1 { t } else { 0.2 - t }).collect();
            let a = load_in_play(&drive, gap, dt);
            let blows: Vec<(usize, f64)> =
                a.iter().enumerate().filter(|(_, a)| a.abs() > 1.0).map(|(i, a)| (i, a * dt)).collect();
            std::println!("{blows:?}");
            // picked up after half the play, carried, caught at the other side
            assert_eq!(blows.len(), 2);
            assert!(blows[0].0.abs_diff(100) < 3 && (blows[0].1 - 1.0).abs() < 1e-6);
            assert!(blows[1].0.abs_diff(1100) < 3 && (blows[1].1 + 2.0).abs() < 1e-6);
        }
    }
}
