//! Effects as columns of the regression.

pub mod applied_force;
pub mod baseline;
pub mod design_matrix;
pub mod kept;
pub mod lines;
pub mod quick;
pub mod scales;
pub mod series;
pub mod term;
