//! Rate and noise of every recording.

/// Standard deviation of the force channel, N or N·m: what "one times the noise" means.
pub const NOISE: f64 = 0.062;
/// Samples per second of every recording.
pub(crate) const RATE: f64 = 1000.0;
