//! A velocity column that lags at low speed. Measured as the time between two encoder pulses, a velocity is the mean since the
//! last but one pulse, and pulses become rare as the body slows down. Around a reversal such a column is late, while the
//! position still counts every pulse in time.

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

/// The further lag of a velocity column at low speed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct LateWhereSlow {
    /// s.
    lag: f64,
    /// The speed below which there is one, m/s or rad/s.
    pub below: f64,
}

impl LateWhereSlow {
    /// The lag that remains once that at all speeds is undone. None if it is not significant, or if its error is smaller than that
    /// of differentiating the position.
    pub fn of(stretches: &[Channels]) -> Option<Self> {
        // Over the slow samples: Σa², −Σa·d, Σd², their number, Σa⁴, and Σa² times the variance of the derived velocity. The last two
        // weigh by a², or a body at rest would count.
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
            "below {:.1e} {} the velocity column lags by a further {:.3} ms, as a velocity from pulse intervals does: diagnose \
             uses the position there",
            self.below,
            Dimension::VELOCITY.unit(geometry),
            1e3 * self.lag
        )
    }
}
