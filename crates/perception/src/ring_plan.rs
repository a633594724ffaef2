//! Plan of the targeting task in the plane: circles of targets, surfaces and their order.

use rand::SeedableRng;
use rand::seq::SliceRandom;
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};

/// A circle of targets on a surface.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RingCase {
    /// Name of the surface.
    pub surface: String,
    /// Diameter of the circle, m.
    pub diameter_m: f64,
    /// Diameter of a target, m.
    pub width_m: f64,
}

impl RingCase {
    /// Index of difficulty log₂(D/W + 1), bits [iso-9241-411, annex B].
    ///
    /// ```
    /// let case = perception::RingCase { surface: "brass".into(), diameter_m: 0.06, width_m: 0.004 };
    /// assert_eq!(case.bits(), 4.0);
    /// ```
    #[must_use]
    pub fn bits(&self) -> f64 {
        (self.diameter_m / self.width_m + 1.0).log2()
    }
}

/// Plan of a session. Stored completely in the session's file, so that a session resumes as it began.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RingPlan {
    /// Seed of the order.
    pub seed: u64,
    /// Number of targets on the circle; odd, 3 to 51.
    pub targets: usize,
    /// The circles, in order.
    pub order: Vec<RingCase>,
}

impl RingPlan {
    /// Every width on every surface: 13 targets on a circle of 70 mm; surfaces and widths in random order, those of a surface
    /// together.
    #[must_use]
    pub fn new(surfaces: &[&str], seed: u64) -> Self {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut surfaces = surfaces.to_vec();
        surfaces.shuffle(&mut rng);
        let mut order = Vec::new();
        for surface in surfaces {
            let mut widths = [0.012, 0.006, 0.003];
            widths.shuffle(&mut rng);
            let case = |width_m| RingCase { surface: surface.to_owned(), diameter_m: 0.07, width_m };
            order.extend(widths.map(case));
        }
        Self { seed, targets: 13, order }
    }

    /// Checks that everything can be presented.
    ///
    /// # Errors
    /// Parameter, value and accepted range.
    pub fn validate(&self) -> Result<(), String> {
        if !(3..=51).contains(&self.targets) || self.targets.is_multiple_of(2) {
            return Err(format!("targets = {}: an odd number from 3 to 51 is accepted", self.targets));
        }
        for (k, case) in self.order.iter().enumerate() {
            for (name, value, most) in
                [("diameter_m", case.diameter_m, 10.0), ("width_m", case.width_m, case.diameter_m)]
            {
                if !(value > 0.0 && value <= most) {
                    return Err(format!("order[{k}].{name} = {value}: above 0 to {most} is accepted"));
                }
            }
        }
        Ok(())
    }

    /// Centre of the target of selection `k` of a case, m from the centre of the circle. Each lies across from the one before;
    /// selection 0 and the last are the same target.
    #[must_use]
    pub fn target(&self, case: &RingCase, k: usize) -> [f64; 2] {
        let place = k * self.targets.div_ceil(2) % self.targets;
        let angle = std::f64::consts::TAU * place as f64 / self.targets as f64;
        let radius = 0.5 * case.diameter_m;
        // the first one is at the top
        [radius * libm::sin(angle), radius * libm::cos(angle)]
    }
}
