//! From prepared recordings to filtered tracks.

pub mod blows;
pub mod drift;
pub mod intake;
pub mod static_branch;
pub mod track;
