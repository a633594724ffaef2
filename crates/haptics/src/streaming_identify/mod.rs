//! The identification of [thesis, ch. 3.5] on the device itself, without a PC.
//!
//! While the handle is driven, [`Recorder`] accumulates moments in the control step; no recording is kept.
//! [`Solver`] makes the parameters of [thesis, eq. 3.5] of them, least squares [thesis, eq. 3.8] with the correction for errors in the
//! regressors [thesis, eq. 3.9], *outside* the interrupt. Three things that [thesis, ch. 3.5] does by hand with a recording are done on the
//! moments:
//! * which samples slide: they are kept apart by speed, in [`BANDS`] bands. Sliding friction is fitted to the fastest;
//!   from there down band after band is added until one does not slide as the others do. The samples that leave rest
//!   then tell Δv and static friction;
//! * the accelerometer's scale and offset per run (3.5.3) come from its covariance with four-point central differences
//!   of velocity. Both then measure one acceleration, and the fit takes their mean, weighted by their noise;
//! * velocity is an average over the last period, so the mean of two neighbours is taken for the velocity at the
//!   sample between them: half a period of delay would add b·T/2 to the mass. Acceleration is the slope of these
//!   averages *within* the last period: the force that drives the handle is held over it, so what load cell and
//!   accelerometer see at its end is the middle's. Half a period of delay there would add m·ω²·T/2 to b.
//!
//! Moments are integers: exact, in any order, one instruction each in the interrupt, and centred without
//! cancellation, so that the solution needs no more than `f32`.

mod break_away;
mod fit;
mod identified;
mod moments;
mod recorder;
mod solve;

pub use identified::{Estimate, Identified, Unidentified};
pub use recorder::{BANDS, NUMBERS, Number, Procedure, Recorder};
pub use solve::Solver;
