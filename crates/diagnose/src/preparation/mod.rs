//! From prepared recordings to filtered tracks.

pub mod drift;
pub mod intake;
pub mod jumps;
pub mod static_branch;
pub mod track;
