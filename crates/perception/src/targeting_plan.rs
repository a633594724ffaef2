//! Plan of the targeting task: targets, resistances and their order.

use crate::stimulus::Resistance;
use rand::SeedableRng;
use rand::seq::SliceRandom;
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};

/// Valid clicks that complete a segment [thesis, ch. 5.3.1].
pub const CLICKS: usize = 8;

/// Distance and width of two targets.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Difficulty {
    /// Number in [thesis, table 5-1], from 1.
    pub index: u32,
    /// Distance between the targets' centres A, pixels.
    pub distance_px: f64,
    /// Width within which the *centre* of the cursor hits, W_s = W − D [thesis, eq. 5.1], pixels: the cursor is then
    /// completely inside. [thesis, table 5-1] prints it as W_c.
    pub width_px: f64,
}

impl Difficulty {
    /// Index of difficulty I_d = −log₂(W_s/2A), bits [thesis, eq. 5.1].
    #[must_use]
    pub fn bits(&self) -> f64 {
        -(self.width_px / (2.0 * self.distance_px)).log2()
    }
}

const fn difficulty(index: u32, distance_px: f64, width_px: f64) -> Difficulty {
    Difficulty { index, distance_px, width_px }
}

/// The nine indices of difficulty [thesis, table 5-1].
pub const TABLE_5_1: [Difficulty; 9] = [
    difficulty(1, 228.0, 12.0),
    difficulty(2, 228.0, 40.0),
    difficulty(3, 228.0, 68.0),
    difficulty(4, 300.0, 12.0),
    difficulty(5, 300.0, 40.0),
    difficulty(6, 300.0, 68.0),
    difficulty(7, 380.0, 12.0),
    difficulty(8, 380.0, 40.0),
    difficulty(9, 380.0, 68.0),
];

/// A segment: eight valid clicks at one difficulty under one resistance.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Segment {
    /// Whether the segment is practice: recorded, but not analysed.
    pub practice: bool,
    /// Resistance.
    pub resistance: Resistance,
    /// Targets.
    pub difficulty: Difficulty,
}

/// Plan of a session. Stored completely in the session's file, so that a session resumes as it began.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TargetingPlan {
    /// Seed of the order.
    pub seed: u64,
    /// Whether practice comes first: one segment of middle difficulty at the baseline, one with real friction.
    pub practice: bool,
    /// Handle travel of a pixel, m.
    pub metre_per_px: f64,
    /// Diameter of the cursor D, pixels; targets are drawn W_s + D wide.
    pub cursor_px: f64,
    /// Order of the segments. Drawn from the seed if empty.
    #[serde(default)]
    pub order: Vec<Segment>,
}

impl TargetingPlan {
    /// Handle travel of a pixel, m. The printed 1.5 mm (228 px are "342 mm") exceeds the travel of the device. This value fits
    /// the widest pair of targets, plus the width of a cursor, into the 32 mm of [thesis, table 3-1].
    pub const METRE_PER_PX: f64 = 0.06e-3;

    /// The plan of [thesis, ch. 5.3.1]: 45 segments after practice, baseline first, the rest in random order.
    #[must_use]
    pub fn thesis(seed: u64) -> Self {
        let mut plan = Self {
            seed,
            practice: true,
            metre_per_px: Self::METRE_PER_PX,
            cursor_px: 6.0,
            order: Vec::new(),
        };
        plan.order = plan.drawn();
        plan
    }

    /// Order from the seed: nine segments at the baseline, then nine of each other resistance, with resistances and indices
    /// in random order [thesis, ch. 5.3.1].
    #[must_use]
    pub fn drawn(&self) -> Vec<Segment> {
        let mut rng = ChaCha8Rng::seed_from_u64(self.seed);
        let [baseline, rest @ ..] = Resistance::ALL;
        let mut rest = rest.to_vec();
        rest.shuffle(&mut rng);
        let mut order = Vec::new();
        if self.practice {
            let middle = TABLE_5_1[4];
            for resistance in [Resistance::Baseline, Resistance::Real] {
                order.push(Segment { practice: true, resistance, difficulty: middle });
            }
        }
        for resistance in std::iter::once(baseline).chain(rest) {
            let mut nine = TABLE_5_1;
            nine.shuffle(&mut rng);
            order.extend(nine.map(|difficulty| Segment { practice: false, resistance, difficulty }));
        }
        order
    }

    /// Checks that everything can be presented.
    ///
    /// # Errors
    /// Parameter, value and accepted range.
    pub fn validate(&self) -> Result<(), String> {
        let above_zero = |name: &str, value: f64| {
            if value.is_finite() && value > 0.0 {
                Ok(())
            } else {
                Err(format!("{name} = {value}: a finite number above 0 is accepted"))
            }
        };
        above_zero("metre_per_px", self.metre_per_px)?;
        if !(self.cursor_px.is_finite() && self.cursor_px >= 0.0) {
            return Err(format!("cursor_px = {}: a finite number from 0 on is accepted", self.cursor_px));
        }
        for (k, segment) in self.order.iter().enumerate() {
            let d = &segment.difficulty;
            above_zero(&format!("order[{k}].difficulty.distance_px"), d.distance_px)?;
            above_zero(&format!("order[{k}].difficulty.width_px"), d.width_px)?;
            if d.width_px >= 2.0 * d.distance_px {
                return Err(format!(
                    "order[{k}].difficulty.width_px = {}: below twice the distance of {} is accepted",
                    d.width_px, d.distance_px
                ));
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    // 3.14 is printed in [thesis, table 5-1]
    #[allow(clippy::approx_constant)]
    #[test]
    fn indices_of_difficulty_are_exactly_table_5_1() {
        let printed = [5.25, 3.51, 2.75, 5.64, 3.91, 3.14, 5.98, 4.25, 3.48];
        for (d, id) in TABLE_5_1.iter().zip(printed) {
            println!("{}: A {} px, W {} px: {:.4} bits ({id})", d.index, d.distance_px, d.width_px, d.bits());
            assert_eq!((d.bits() * 100.0).round() / 100.0, id);
        }
        // I_d(7) = log₂(2·380/12): log₂ of 63 and a third
        assert!((TABLE_5_1[6].bits() - (190.0_f64 / 3.0).ln() / 2.0_f64.ln()).abs() < 1e-12);
    }

    #[test]
    fn each_segment_comes_once_baseline_first() {
        let mut orders = BTreeSet::new();
        for seed in 0..50 {
            let plan = TargetingPlan::thesis(seed);
            assert_eq!(plan.order.len(), 47);
            let (practice, main) = plan.order.split_at(2);
            assert!(practice.iter().all(|s| s.practice) && main.iter().all(|s| !s.practice));
            assert!(main[..9].iter().all(|s| s.resistance == Resistance::Baseline));
            let each: BTreeSet<_> = main.iter().map(|s| (s.resistance, s.difficulty.index)).collect();
            assert_eq!(each.len(), 45);
            // the nine segments of a resistance stay together
            for nine in main.chunks(9) {
                assert!(nine.iter().all(|s| s.resistance == nine[0].resistance));
            }
            assert_eq!(plan.order, TargetingPlan::thesis(seed).order);
            orders.insert(main.iter().map(|s| (s.resistance, s.difficulty.index)).collect::<Vec<_>>());
        }
        println!("50 seeds: {} different orders", orders.len());
        assert!(orders.len() > 45);
    }
}
