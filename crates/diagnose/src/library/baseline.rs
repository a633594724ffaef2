//! The baseline: mass, and Coulomb and viscous friction by direction.

use friction::effects::Parameter;
use friction::parameters::{COULOMB_N, COULOMB_P, MASS, VISCOUS_N, VISCOUS_P};

/// The baseline's columns.
pub const BASELINE: [Parameter; 5] = [MASS, COULOMB_P, COULOMB_N, VISCOUS_P, VISCOUS_N];

/// A value for each of [`BASELINE`].
pub type Physics = [f64; BASELINE.len()];

/// Columns of a body that moves forward only, and backward only.
pub const FORWARD: [usize; 3] = [0, 1, 3];
pub const BACKWARD: [usize; 3] = [0, 2, 4];
