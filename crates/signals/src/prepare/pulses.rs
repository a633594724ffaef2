//! A velocity that is late where the body is slow. One that measures the time between two pulses of an encoder shows the mean
//! since the last but one: the slower, the longer ago. What friction does at a reversal is then seen too late, while the
//! pulses themselves tell the position in time.

use super::channels::Channels;
use super::cutoff::differentiated;
use crate::{Geometry, LowPass, four_point_difference, noise_std, quantile};
use friction::Dimension;

/// Filter behind which the two are compared, as a share of the sampling rate.
const FILTER: f64 = 0.1;
/// Slow is what is below this share of quick motion.
const SLOW: f64 = 1.0 / 16.0;
/// Standard errors of the lag, and samples, from which on there is one.
const SURE: f64 = 5.0;
const LATE: f64 = 0.25;

/// A velocity column that is later where the body is slow.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct LateWhereSlow {
    /// How much later, s.
    lag: f64,
    /// Speeds below which it is, m/s or rad/s.
    pub below: f64,
}

impl LateWhereSlow {
    /// Of a column whose lag is undone; None where what is left makes less of an error than the position's own derivative has.
    pub fn of(stretches: &[Channels]) -> Option<Self> {
        // Σa², −Σa·d, Σd² and samples over the slow part, Σa⁴ and Σa² times the square of the position's own error: a body that
        // rests says nothing
        let [mut aa, mut ad, mut dd, mut samples, mut aaaa, mut own] = [0.0; 6];
        let (mut below, mut dt): (f64, f64) = (0.0, 0.0);
        for c in stretches {
            let Some(column) = &c.velocity else { continue };
            let filter = LowPass::new(FILTER / c.dt, c.dt);
            let v = four_point_difference(&filter.apply(&c.position), c.dt);
            let a = four_point_difference(&v, c.dt);
            let column = filter.apply(column);
            let of_position = (noise_std(&c.position) * differentiated(1, filter.cutoff(), c.dt)).powi(2);
            let slow = SLOW * quantile(&v.iter().map(|v| v.abs()).collect::<Vec<_>>(), 0.95);
            let settle = filter.settle().min(v.len() / 4);
            for i in (settle..v.len() - settle).filter(|i| v[*i].abs() < slow) {
                let (d, square) = (column[i] - v[i], a[i] * a[i]);
                (aa, ad, dd, samples) = (aa + square, ad - a[i] * d, dd + d * d, samples + 1.0);
                (aaaa, own) = (aaaa + square * square, own + square * of_position);
            }
            (below, dt) = (below.max(slow), dt.max(c.dt));
        }
        let lag = ad / aa;
        let independent = (2.0 * FILTER * samples).max(4.0);
        let std = ((dd - lag * ad).max(0.0) / (independent * aa)).sqrt();
        let late = lag > SURE * std && lag > LATE * dt;
        (late && lag * lag * aaaa > own).then_some(Self { lag, below })
    }

    /// As a fault of the recording.
    pub fn says(&self, geometry: Geometry) -> String {
        format!(
            "the velocity column is {:.3} ms later than elsewhere below {:.1e} {}, as one of the time between pulses is: what is \
             slower is looked at through the position",
            1e3 * self.lag,
            self.below,
            Dimension::VELOCITY.unit(geometry)
        )
    }
}
