//! Density of the jerk, the smoother's process noise: its level by maximum likelihood, and where it rises.
//!
//! A reversal of dry friction, a break-away or a hard stop jerks a body orders of magnitude harder than the drive
//! between them. The density is therefore a scale mixture (the jerk has heavy tails), constant over a short window:
//! each window's density is pulled to the common level as by [`PRIOR`] observations of it. Few make the density follow a
//! reversal closely, at the price of a standard deviation of the acceleration a fifth too small on a jerk that really is
//! white everywhere. A step of the iteration
//! is a fixed point of the likelihood: the power of the smoothed jerk over its expectation.

use super::chain::Chain;
use super::kalman::{Gaussian, JerkPower};

/// Observations of the jerk that the common level counts for in every window: degrees of freedom of the tails.
const PRIOR: f64 = 0.5;
/// Observations of the jerk in a window over which one density holds, and fewest nodes on either side: the noisier the
/// channels, the fewer of them each node has.
const IN_WINDOW: f64 = 3.0;
const NARROWEST: f64 = 3.0;
/// Iterations of filter, smoother and density.
const ITERATIONS: usize = 6;
/// Densities considered, powers of ten in the smoother's units.
const LOWEST: i32 = -16;
const HIGHEST: i32 = 8;
/// Nodes from which the level is estimated first, in runs of [`RUN`].
const LOOKED_AT: usize = 16_384;
const RUN: usize = 2_048;

/// Density of the step that ends at each node, with the smoothed states.
pub(super) fn estimate(chain: &Chain<'_>) -> (Vec<f64>, Vec<Gaussian>) {
    let n = chain.len();
    let mut level = level(chain);
    let mut density = vec![level; n];
    let mut power = vec![JerkPower::default(); n];
    let mut states = Vec::with_capacity(n);
    for iteration in 0.. {
        states.clear();
        chain.filter(0..n, |k| density[k], |s| states.push(s));
        chain.smooth(&mut states, &density, &mut power);
        if iteration == ITERATIONS {
            break;
        }
        level = renew(&mut density, &power, level);
    }
    (density, states)
}

/// One step of the fixed point in every window; returns the new common level.
fn renew(density: &mut [f64], power: &[JerkPower], level: f64) -> f64 {
    let n = density.len();
    let each = power.iter().map(|p| p.expected).sum::<f64>() / n as f64;
    let half = (0.5 * (IN_WINDOW / each.max(1e-9) - 1.0)).clamp(NARROWEST, 1e6).round() as usize;
    // The square of the jerk in units of density, and the number of its observations.
    let seen = windowed(power, density, half, |p, d| p.seen * d);
    let expected = windowed(power, density, half, |p, _| p.expected);
    let (mut inverse, mut weight) = (0.0, 0.0);
    for k in 1..n {
        density[k] = ((PRIOR * level + seen[k]) / (PRIOR + expected[k])).clamp(floor(), ceiling());
        inverse += power[k].expected / density[k];
        weight += power[k].expected;
    }
    if inverse > 0.0 { (weight / inverse).clamp(floor(), ceiling()) } else { level }
}

fn floor() -> f64 {
    10f64.powi(LOWEST)
}

fn ceiling() -> f64 {
    10f64.powi(HIGHEST)
}

/// Sums over `half` nodes on either side.
fn windowed(
    power: &[JerkPower],
    density: &[f64],
    half: usize,
    of: impl Fn(&JerkPower, f64) -> f64,
) -> Vec<f64> {
    let n = power.len();
    let mut sums = Vec::with_capacity(n + 1);
    let mut sum = 0.0;
    sums.push(sum);
    for (p, d) in power.iter().zip(density) {
        sum += of(p, *d);
        sums.push(sum);
    }
    (0..n).map(|k| sums[(k + half + 1).min(n)] - sums[k.saturating_sub(half)]).collect()
}

/// The one density that fits the whole recording best.
fn level(chain: &Chain<'_>) -> f64 {
    let n = chain.len();
    let runs: Vec<_> = if n <= LOOKED_AT {
        std::iter::once(0..n).collect()
    } else {
        let count = LOOKED_AT / RUN;
        (0..count).map(|r| r * (n - RUN) / (count - 1)).map(|from| from..from + RUN).collect()
    };
    let surprise = |exponent: f64| -> f64 {
        let density = 10f64.powf(exponent);
        runs.iter().map(|run| chain.filter(run.clone(), |_| density, |_| {})).sum()
    };
    let coarse = (LOWEST..=HIGHEST).map(|e| (surprise(f64::from(e)), f64::from(e)));
    let Some((_, best)) = coarse.min_by(|a, b| a.0.total_cmp(&b.0)) else { return 1.0 };
    let fine = (-3..=3).map(|i| best + 0.25 * f64::from(i)).map(|e| (surprise(e), e));
    fine.min_by(|a, b| a.0.total_cmp(&b.0)).map_or(1.0, |(_, e)| 10f64.powf(e))
}
