//! Signals with everything a fit needs: error variances of the regressors, a smoothed velocity, and the rows.

use crate::Signals;
use crate::errors::{Errors, Variances};
use crate::identification::Estimate;
use crate::moves::Moves;
use signals::{Error, Geometry, Measured, RecordingFault, Smoothed, implausible_mass, smooth};
use std::collections::BTreeMap;

/// How well a residual fits.
pub(crate) struct Goodness {
    pub relative_error: f64,
    pub residual_rms: f64,
    pub r_squared: f64,
}

/// Signals with what every fit needs of them.
pub(crate) struct Ready<'a> {
    pub signals: &'a Signals,
    pub geometry: Geometry,
    pub dt: f64,
    /// Velocity behind the noise, every sample, and its standard deviation.
    pub velocity: Vec<f64>,
    pub velocity_std: f64,
    /// Distance slid up to each sample from the one before, m.
    pub displacement: Vec<f64>,
    /// Standard deviation of the position it is the difference of, m.
    pub position_std: f64,
    /// Regressors and force behind the filter of the force: the rows.
    pub acceleration_rows: Vec<f64>,
    pub velocity_rows: Vec<f64>,
    pub force_rows: Vec<f64>,
    /// What is known of the errors in the regressors of the rows. Zero for least squares.
    pub errors: Variances,
    /// Number of each row.
    pub at: Vec<usize>,
    /// Length of the stroke, m, and root mean square step, m.
    pub travel: f64,
    pub step_rms: f64,
}

/// Smooths each stretch by itself: over a gap position and velocity jump. Outside of them the velocity is not known, and 0.
fn smoothed(signals: &Signals, errors: Variances) -> Smoothed {
    let of_position = signals::noise_variance(&signals.position);
    let mut whole = Smoothed {
        position: signals.position.clone(),
        velocity: vec![0.0; signals.len()],
        ..Smoothed::default()
    };
    let mut longest = 0;
    for range in signals.ranges() {
        let part = smooth(&Measured {
            position: (&signals.position[range.clone()], of_position),
            velocity: (&signals.velocity[range.clone()], errors.velocity),
            acceleration: (&signals.acceleration[range.clone()], errors.acceleration),
            dt: signals.dt,
        });
        whole.position[range.clone()].copy_from_slice(&part.position);
        whole.velocity[range.clone()].copy_from_slice(&part.velocity);
        if range.len() > longest {
            longest = range.len();
            (whole.position_std, whole.velocity_std) = (part.position_std, part.velocity_std);
        }
    }
    whole
}

/// Fewest rows a law is fitted to.
const FEWEST: usize = 30;

impl<'a> Ready<'a> {
    /// # Errors
    /// Too few samples, or numbers that are not finite.
    pub fn new(signals: &'a Signals, errors: Errors) -> Result<Self, Error> {
        let refuse = |why: String| Err(Error::Recording { recording: signals.name.clone(), why });
        let (measured, rows) = signals.error_variances();
        let errors = match errors {
            Errors::LeastSquares => Variances::default(),
            Errors::Fuller => rows,
            Errors::Declared { velocity, acceleration } => {
                for (name, std) in [("velocity", velocity), ("acceleration", acceleration)] {
                    if !(std.is_finite() && std >= 0.0) {
                        return Err(Error::Parameter {
                            parameter: format!("error std of {name}"),
                            value: std.to_string(),
                            accepted: "accepted is a finite number from 0".into(),
                        });
                    }
                }
                Variances { velocity: velocity * velocity, acceleration: acceleration * acceleration, ..rows }
            }
        };
        let dt = signals.dt;
        let smoothed = smoothed(signals, measured);
        let force_rows = signals.condition(&signals.force);
        let finite = [&signals.position, &signals.velocity, &signals.acceleration, &signals.force]
            .iter()
            .all(|s| s.iter().all(|x| x.is_finite()));
        if force_rows.len() < FEWEST || !(dt > 0.0 && dt.is_finite()) {
            return refuse(format!("{} samples to fit, at least {FEWEST} are needed", force_rows.len()));
        }
        if !finite {
            return refuse("a signal holds values that are not numbers".into());
        }
        let mut displacement: Vec<f64> = vec![0.0];
        displacement.extend(smoothed.position.windows(2).map(|w| w[1] - w[0]));
        let (low, high) = signals
            .position
            .iter()
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), x| (l.min(*x), h.max(*x)));
        let step_rms = (displacement.iter().map(|d| d * d).sum::<f64>() / displacement.len() as f64).sqrt();
        Ok(Self {
            signals,
            geometry: signals.geometry,
            dt,
            acceleration_rows: signals.condition(&signals.acceleration),
            velocity_rows: signals.condition(&signals.velocity),
            at: (0..force_rows.len()).collect(),
            force_rows,
            velocity: smoothed.velocity,
            // of the longest stretch, halfway
            velocity_std: smoothed.velocity_std.get(smoothed.velocity_std.len() / 2).copied().unwrap_or(0.0),
            position_std: smoothed.position_std,
            displacement,
            errors,
            travel: high - low,
            step_rms,
        })
    }

    /// A column over every sample, as rows behind the filter of the force.
    pub fn rows(&self, series: &[f64]) -> Vec<f64> {
        self.signals.condition(series)
    }

    pub fn moves(&self) -> Moves {
        Moves::of(&self.signals.position, &self.velocity, self.dt)
    }

    /// Samples in which a body that reverses at its usual acceleration crosses `distance`.
    pub fn samples_to_cross(&self, distance: f64) -> usize {
        let n = self.signals.acceleration.len().max(1) as f64;
        let rms = (self.signals.acceleration.iter().map(|a| a * a).sum::<f64>() / n).sqrt();
        ((2.0 * distance / rms.max(1e-12)).sqrt() / self.dt).ceil().clamp(1.0, 1e9) as usize
    }

    /// Faults of the recording: what the audit found, and what only the fit could see.
    pub fn faults(&self, parameters: &BTreeMap<String, Estimate>) -> Vec<RecordingFault> {
        let mass = parameters.get("mass").and_then(|m| implausible_mass(m.value, m.std, self.geometry));
        self.signals.recording_faults().into_iter().chain(mass).collect()
    }

    /// Relative error, rms and R² of a residual of the rows `at`.
    pub fn goodness(force: &[f64], residual: &[f64]) -> Goodness {
        let n = residual.len().max(1) as f64;
        let squares = |s: &[f64]| s.iter().map(|x| x * x).sum::<f64>();
        let (error, size) = (squares(residual), squares(force));
        let mean = force.iter().sum::<f64>() / n;
        let spread = size - n * mean * mean;
        let share = |top: f64, bottom: f64| if bottom > 0.0 { top / bottom } else { 0.0 };
        Goodness {
            relative_error: share(error, size).sqrt(),
            residual_rms: (error / n).sqrt(),
            r_squared: 1.0 - share(error, spread),
        }
    }
}
