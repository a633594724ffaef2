//! The motion behind noisy channels: mean and covariance of position, velocity and acceleration at every stamp.
//!
//! A Rauch-Tung-Striebel smoother \[rauch-1965\] of a body whose jerk is white noise, on the true clock. Every channel is an
//! [`Observation`] of one of the three with its own noise, quantum, lag, scale and zero. Lost samples are long steps,
//! a stamp written twice is a step of no length, a slow servo has few stamps: none needs a path of its own. The density
//! of the jerk is estimated from the recording, and rises where the motion jerks.
//!
//! The cost is proportional to the number of stamps.

mod chain;
mod denoise;
mod jerk;
mod kalman;
mod observation;

pub use denoise::{Measured, Smoothed, smooth};
pub use observation::{Observation, Observed};

use crate::Error;
use chain::Chain;
use std::f64::consts::FRAC_1_SQRT_2;

/// Smoothed motion of a body, one entry for each stamp.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Motion {
    /// m or rad.
    pub position: Vec<f64>,
    /// m/s or rad/s.
    pub velocity: Vec<f64>,
    /// m/s² or rad/s².
    pub acceleration: Vec<f64>,
    /// Covariance of the errors of the three: xx, xv, xa, vv, va, aa, in the squares of their units.
    pub covariance: Vec<[f64; 6]>,
    /// Spectral density of the jerk in the step that ends at each stamp, m²/s⁵ or rad²/s⁵.
    pub jerk_density: Vec<f64>,
}

impl Motion {
    /// Number of stamps.
    #[must_use]
    pub fn len(&self) -> usize {
        self.position.len()
    }

    /// Whether there is no stamp.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.position.is_empty()
    }

    /// Standard deviation of the position at stamp `i`; NaN past the end.
    #[must_use]
    pub fn position_std(&self, i: usize) -> f64 {
        self.std(i, 0)
    }

    /// Standard deviation of the velocity at stamp `i`; NaN past the end.
    #[must_use]
    pub fn velocity_std(&self, i: usize) -> f64 {
        self.std(i, 3)
    }

    /// Standard deviation of the acceleration at stamp `i`; NaN past the end.
    #[must_use]
    pub fn acceleration_std(&self, i: usize) -> f64 {
        self.std(i, 5)
    }

    fn std(&self, i: usize, entry: usize) -> f64 {
        self.covariance.get(i).map_or(f64::NAN, |c| c[entry].max(0.0).sqrt())
    }

    /// Posterior mean of the direction at every stamp, E\[sgn v\] = erf(v/(√2 s_v)), from −1 to 1.
    ///
    /// 1 − E² is the variance of the direction that is left.
    #[must_use]
    pub fn direction(&self) -> Vec<f64> {
        (0..self.len()).map(|i| direction(self.velocity[i], self.velocity_std(i))).collect()
    }
}

/// E\[sgn v\] of a normal velocity of mean `v` and standard deviation `std`; the sign itself where `std` is 0.
#[must_use]
pub fn direction(v: f64, std: f64) -> f64 {
    if v == 0.0 {
        0.0
    } else if std > 0.0 {
        libm::erf(v / std * FRAC_1_SQRT_2)
    } else {
        v.signum()
    }
}

/// Estimates the motion at the stamps `time`, s, which do not decrease, from all channels.
///
/// # Errors
/// A stamp that is not finite or before the one ahead of it, a channel with another number of values than stamps, a
/// parameter of a channel outside its range, or no reading at all.
///
/// # Example
/// ```
/// use signals::{Observation, Observed, estimate_motion};
///
/// let time: Vec<f64> = (0..200).map(|i| 1e-3 * f64::from(i)).collect();
/// let position: Vec<f64> = time.iter().map(|t| 0.5 * t - 2.0 * t * t).collect();
/// let motion = estimate_motion(&time, &[Observation::new(Observed::Position, &position)])?;
/// assert!((motion.velocity[150] - (0.5 - 4.0 * 0.15)).abs() < 1e-6);
/// # Ok::<(), signals::Error>(())
/// ```
pub fn estimate_motion(time: &[f64], observations: &[Observation<'_>]) -> Result<Motion, Error> {
    validate(time, observations)?;
    if time.is_empty() {
        return Ok(Motion::default());
    }
    let chain = Chain::new(time, observations);
    let (density, states) = jerk::estimate(&chain);
    let mut out = Motion {
        position: vec![0.0; time.len()],
        velocity: vec![0.0; time.len()],
        acceleration: vec![0.0; time.len()],
        covariance: vec![[0.0; 6]; time.len()],
        jerk_density: vec![0.0; time.len()],
    };
    let units = chain.units;
    let [x, v, a] = [0, 1, 2].map(|c| units.of(c));
    for (k, state) in states.iter().enumerate() {
        let Some(i) = chain.stamp(k) else { continue };
        out.position[i] = state.mean[0] * x;
        out.velocity[i] = state.mean[1] * v;
        out.acceleration[i] = state.mean[2] * a;
        let products = [x * x, x * v, x * a, v * v, v * a, a * a];
        out.covariance[i] = std::array::from_fn(|e| state.cov[e] * products[e]);
        out.jerk_density[i] = density[k] * x * x / units.time.powi(5);
    }
    Ok(out)
}

fn validate(time: &[f64], observations: &[Observation<'_>]) -> Result<(), Error> {
    if u32::try_from(time.len()).is_err() {
        return Err(Error::Parameter {
            parameter: "number of stamps".into(),
            value: time.len().to_string(),
            accepted: format!("accepted are at most {}", u32::MAX),
        });
    }
    let mut before = f64::NEG_INFINITY;
    for (i, t) in time.iter().enumerate() {
        if !(t.is_finite() && *t >= before) {
            return Err(Error::Parameter {
                parameter: format!("time[{i}]"),
                value: t.to_string(),
                accepted: "accepted are finite stamps, none before the one ahead of it".into(),
            });
        }
        before = *t;
    }
    for o in observations {
        o.validate(time.len())?;
    }
    let readings = |o: &Observation<'_>| (0..time.len()).any(|i| o.quantity(i).is_some());
    if !time.is_empty() && !observations.iter().any(readings) {
        return Err(Error::Parameter {
            parameter: "observations".into(),
            value: "no reading".into(),
            accepted: "accepted are channels with at least one finite value".into(),
        });
    }
    Ok(())
}
