//! The thesis's identification on the device itself, without a PC (ch. 3.5).
//!
//! While the handle is driven, [`Recorder`] accumulates sums in the control step: 26 compensated `f32` sums, no
//! recording is kept. [`Sums::solve`] makes the five parameters of eq. 3.5 of them, least squares (3.8) and Fuller's
//! correction (3.9), in `f64`, *outside* the interrupt.
//!
//! Two things the thesis did with a recording are done on the sums:
//! * the accelerometer's scale and offset per run (3.5.3) come from its covariance with four-point central differences
//!   of velocity; the normal equations are bilinear in them and are transformed afterwards. The regression is of the
//!   accelerometer on the differences: M/T velocity makes those the cleaner of the two, and the other way
//!   round the noise of the accelerometer would shrink the scale and enlarge the mass;
//! * velocity is an average over the last period, so the mean of two neighbours is taken for the sample between
//!   them: half a period of delay would add b·T/2 to the mass.

mod recorder;
mod solve;
mod sum;

pub use recorder::{Procedure, Recorder, Sums};
pub use solve::{Estimate, Identified, Unidentified};
