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

/// Constant force and levels of friction forward and backward. Where one level lies below zero there is a constant in the force,
/// which while sliding is half their difference.
pub fn levels(physics: &Physics) -> (f64, f64, f64) {
    let [_, c_p, c_n, ..] = *physics;
    let offset = if c_p < 0.0 || c_n < 0.0 { 0.5 * (c_p - c_n) } else { 0.0 };
    (offset, (c_p - offset).max(0.0), (c_n + offset).max(0.0))
}

/// Whether friction opposes the motion up to a speed. A law has none below zero, so a model would not be what was fitted.
pub fn opposes(physics: &Physics, speed: f64) -> bool {
    let (_, c_p, c_n) = levels(physics);
    c_p + physics[3] * speed >= 0.0 && c_n + physics[4] * speed >= 0.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn friction_that_ends_below_the_speeds_of_the_motion_was_put_into_a_model() {
        assert!(!opposes(&[100.2, 29.4, 30.4, -481.5, -402.6], 0.125));
        assert!(opposes(&[100.2, 30.4, 31.6, -79.2, -0.4], 0.125));
        assert!(!opposes(&[100.2, 30.4, 31.6, -0.4, -300.0], 0.125), "backward only");
        // a weight of 5 N beside friction of 3 N
        let hanging = [1.0, 8.0, -2.0, -20.0, 1.0];
        assert_eq!(levels(&hanging), (5.0, 3.0, 3.0));
        assert!(opposes(&hanging, 0.1) && !opposes(&hanging, 0.2));
    }
}
