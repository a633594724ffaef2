//! Least squares on blocks of rows, and tests by flipping the signs of whole blocks.

pub mod linear;
pub mod sign_flips;
