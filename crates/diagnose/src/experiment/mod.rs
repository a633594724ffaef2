//! Which move would tell rival explanations apart.

pub mod answers;
pub mod design;
pub mod evidence;
pub mod moves;
pub mod other_means;
pub mod proposal;
