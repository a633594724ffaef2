//! Which effects, with which shapes, explain a recording.

pub mod applied_force;
pub mod beam;
pub mod catalogue;
pub mod extra_columns;
pub mod hypothesis;
pub mod joint;
pub mod judgement;
pub mod lasting;
pub mod overlap;
pub mod refine;
pub mod regression;
pub mod significance;
pub mod simplify;
pub mod transport;
