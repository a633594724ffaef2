//! Blows: the force, or the acceleration, jumps between two samples. When it jumped within them is not recorded, and how high it was
//! is not either where it is over before the next one. Where that is more than the noise leaves, the moment says nothing of any law.

use signals::{Channels, FaultKind, Noise, RecordingFault, differentiated, dot, quantile};

/// Largest fourth difference beside a step of one. What is quick but sampled well has a much smaller one.
const OF_A_STEP: f64 = 3.0;
/// Fourth difference of white noise, in its standard deviations, and the sixth: roots of the sums of their squared coefficients.
const FOURTH: f64 = 8.367;
const SIXTH: f64 = 30.4;
/// Standard deviations that chance does not reach in tens of thousands of samples.
const SURE: f64 = 8.0;
/// Error behind the filter that counts, in standard deviations of what noise of the force leaves there.
const LARGE: f64 = 3.0;

/// Samples beside jumps that leave more than noise does behind a low-pass at `cutoff` Hz.
#[derive(Debug)]
pub struct Unresolved {
    /// Of the force.
    pub force: Vec<usize>,
    /// Of the force, where it jumps farther than friction does that changes its sign.
    pub beyond_friction: Vec<usize>,
    /// Of the acceleration of the position.
    pub motion: Vec<usize>,
}

/// Jumps of the channels; `acceleration` is a smooth one.
pub fn unresolved(channels: &Channels, noise: &Noise, acceleration: &[f64], cutoff: f64) -> Unresolved {
    let Channels { dt, position, force, .. } = channels;
    // a moment that is even in a sample has a deviation of dt/√12, and the response of the filter to an impulse a height of 2·cutoff
    let error_of_a_step = 2.0 * cutoff * dt / 12f64.sqrt();
    let large = LARGE * noise.force * differentiated(0, cutoff, *dt) / error_of_a_step;
    let mass = dot(force, acceleration).abs() / dot(acceleration, acceleration).max(1e-300);
    let bends: Vec<f64> =
        position.windows(3).map(|x| mass * (x[0] - 2.0 * x[1] + x[2]) / (dt * dt)).collect();
    let of_bends = mass * SIXTH * noise.position / (dt * dt);
    let least = (SURE * FOURTH * noise.force).max(OF_A_STEP * large);
    // an upper bound: friction acts all the time, so it cannot exceed the median force
    let friction = quantile(&force.iter().map(|f| f.abs()).collect::<Vec<_>>(), 0.5);
    Unresolved {
        force: steps(force, least, 0),
        beyond_friction: steps(force, least + OF_A_STEP * 2.0 * friction, 0),
        motion: steps(&bends, (SURE * of_bends).max(OF_A_STEP * large), 1),
    }
}

/// Middles of the fourth differences above a limit, in a series that begins `offset` samples late.
fn steps(series: &[f64], limit: f64, offset: usize) -> Vec<usize> {
    let steps = |w: &[f64]| (w[0] - 4.0 * (w[1] + w[3]) + 6.0 * w[2] + w[4]).abs() > limit;
    series.windows(5).enumerate().filter(|(_, w)| steps(w)).map(|(i, _)| i + 2 + offset).collect()
}

/// Time within which jumps are one blow, s.
const ONE: f64 = 0.1;
/// Most blows whose times are listed.
const LISTED: usize = 4;

/// What is said of blows at these times, s, in one gap-free stretch after the other.
pub fn fault(stretches: impl Iterator<Item = Vec<f64>>) -> Option<RecordingFault> {
    let mut times: Vec<f64> = Vec::new();
    for mut at in stretches {
        at.sort_by(f64::total_cmp);
        at.dedup_by(|later, earlier| *later - *earlier < ONE);
        times.extend(at);
    }
    let first = *times.first()?;
    let listed: Vec<String> = times.iter().take(LISTED).map(|t| format!("{t:.2}")).collect();
    let more = match times.len() - listed.len() {
        0 => String::new(),
        more => format!(" and {more} more"),
    };
    let why = format!(
        "the force or the speed jumps between two samples, at {} s{more}: what acted between them is not recorded, and these \
         moments are set aside; move more smoothly, or record faster",
        listed.join(", ")
    );
    Some(RecordingFault::new(FaultKind::UnresolvedBlow, Some(first), why))
}

#[cfg(test)]
mod tests {
    use super::*;
    use signals::derived_noise;

    const DT: f64 = 0.002;
    const SAMPLES: usize = 5000;

    /// What is found where the position and the force are these.
    fn found(position: Vec<f64>, force: Vec<f64>, acceleration: &[f64], cutoff: f64) -> Unresolved {
        let channels = Channels { dt: DT, position, force, ..Channels::default() };
        unresolved(&channels, &derived_noise(&channels, cutoff), acceleration, cutoff)
    }

    fn noise(i: usize) -> f64 {
        0.02 * (1e4 * (i * i) as f64).sin()
    }

    #[test]
    fn a_blow_within_a_sample_is_told_from_what_is_quick() {
        let rest = vec![0.0; SAMPLES];
        let of_force = |force: &[f64], cutoff: f64| found(rest.clone(), force.to_vec(), &rest, cutoff).force;
        let quick: Vec<f64> = (0..SAMPLES).map(|i| 3.0 * (0.3 * i as f64).sin() + noise(i)).collect();
        assert!(of_force(&quick, 25.0).is_empty());
        let blow: Vec<f64> = (0..SAMPLES)
            .map(|i| noise(i) + if i < 2000 { 0.0 } else { 20.0 * (-(i as f64 - 2000.0) / 4.0).exp() })
            .collect();
        let at = of_force(&blow, 25.0);
        println!("{at:?}");
        assert!(at.contains(&2000) && at.iter().all(|i| (1998..2003).contains(i)));
        // behind a filter that takes out what it does, it does no harm
        assert!(of_force(&blow, 0.002).is_empty());
    }

    #[test]
    fn a_drive_that_turned_round_at_once_was_taken_for_friction() {
        // 0.5 either way, then a body at constant speed is thrown back within a sample
        let thrown = |by: f64| {
            let force: Vec<f64> = (0..SAMPLES)
                .map(|i| {
                    let (since, way) = (i % 1000, if (i / 1000) % 2 == 0 { 1.0 } else { -1.0 });
                    way * (0.5 + by * (-(since as f64) / 20.0).exp()) + noise(i)
                })
                .collect();
            found(vec![0.0; SAMPLES], force, &[0.0; SAMPLES], 25.0)
        };
        let (friction, drive) = (thrown(0.0), thrown(4.0));
        println!("{:?}, {:?}", friction.beyond_friction, drive.beyond_friction);
        assert!(friction.force.contains(&1000) && friction.beyond_friction.is_empty());
        assert!([1000, 2000, 3000, 4000].iter().all(|i| drive.beyond_friction.contains(i)));
    }

    #[test]
    fn a_stop_within_a_sample_shows_in_the_position_alone() {
        let stops = |i: usize| 1e-3 * (i.min(2000) as f64 + 300.0 * (0.01 * i as f64).sin());
        let position: Vec<f64> = (0..SAMPLES).map(|i| stops(i) + 1e-4 * noise(i)).collect();
        let acceleration: Vec<f64> = (0..SAMPLES).map(|i| -7.5 * (0.01 * i as f64).sin()).collect();
        // the force of the stop came and went between two samples
        let force: Vec<f64> = acceleration.iter().enumerate().map(|(i, a)| 0.1 * a + noise(i)).collect();
        let at = found(position, force, &acceleration, 25.0).motion;
        println!("{at:?}");
        assert!(at.contains(&2000) && at.iter().all(|i| (1998..2003).contains(i)));
    }
}
