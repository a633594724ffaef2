//! Measurement errors of the regressors.

/// Treatment of measurement errors in velocity and acceleration.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Errors {
    /// Least squares [thesis, eq. 3.8]. Shrinks the mass by the share of noise in the acceleration.
    LeastSquares,
    /// Fuller's estimator [thesis, eq. 3.9] with variances from how far samples scatter about their neighbours.
    #[default]
    Fuller,
    /// Fuller's estimator with standard deviations that are known, of the rows that are fitted.
    Declared {
        /// m/s.
        velocity: f64,
        /// m/s².
        acceleration: f64,
    },
}

/// Error variances of the regressors: of every sample, or of the rows behind the filter.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Variances {
    /// (m/s)².
    pub velocity: f64,
    /// (m/s²)².
    pub acceleration: f64,
    /// Of the rate of the force, (N/s)².
    pub force_rate: f64,
}
