//! Physics no law of the catalogue fits: described by its mean over the coordinate where it sits, and only
//! claimed when that description holds on blocks it was not fitted to.

use crate::flips::gain_interval;
use crate::linear::fit;
use crate::locate::Located;
use crate::result::{Missing, Quantity};
use crate::search::{FOLDS, Hypothesis, LEVEL, Search};
use std::collections::BTreeMap;

/// Steps of the description.
const STEPS: usize = 8;

/// The most telling coordinate of what is left, if a step function of it gains on held-out blocks.
pub fn find(search: &Search, found: &Hypothesis, left: &Located, start: f64) -> Option<Missing> {
    let stage = search.stage;
    if left.p > LEVEL {
        return None;
    }
    let region = left.regions.iter().find(|r| r.p <= LEVEL)?;
    let (name, unit, values, edges) = left.tables.iter().find(|t| t.0 == region.coordinate)?;
    let base = Hypothesis::columns(stage, &found.atoms);
    let directed = ["low_speed", "distance_since_reversal", "time_since_reversal", "time", "load"]
        .contains(&name.as_str());
    let sign = stage.rows(|t| t.sign.clone());
    let mut steps = vec![vec![0.0; stage.y.len()]; STEPS];
    let per = edges.len().saturating_sub(1).div_ceil(STEPS).max(1);
    for (row, v) in values.iter().enumerate() {
        if !v.is_finite() || stage.share[row] <= 0.5 {
            continue;
        }
        let bin = edges.partition_point(|e| e <= v).saturating_sub(1).min(edges.len().saturating_sub(2));
        let way = if directed && sign[row] < 0.0 { -1.0 } else { 1.0 };
        if let Some(step) = steps.get_mut(bin / per) {
            step[row] = way * stage.share[row];
        }
    }
    let mut columns: Vec<&[f64]> = base.clone();
    let mut basis = crate::linear::Basis::of(&base);
    for step in &steps {
        let size = crate::linear::dot(step, step);
        let rest = basis.project_out(step);
        if crate::linear::dot(&rest, &rest) > 0.05 * size && basis.push(step) {
            columns.push(step);
        }
    }
    if columns.len() == base.len() {
        return None;
    }
    let described = fit(&columns, &stage.y, &stage.blocks, FOLDS)?;
    let interval = gain_interval(
        &found.fit.heldout,
        &described.heldout,
        &stage.block_weight(),
        &stage.blocks.recordings,
        2000,
        search.seed,
    );
    let gained = found.fit.heldout_sum() - described.heldout_sum();
    if interval[0] <= 0.0 || gained < (0.05 * (start - search.floor)).max(search.systematic) {
        return None;
    }
    let rows: f64 = stage.block_weight().iter().sum();
    let force = if unit.contains("rad") { "N·m" } else { "N" };
    let parameters: BTreeMap<String, Quantity> = (base.len()..columns.len())
        .map(|c| {
            let quantity = Quantity {
                value: described.coefficients[c],
                std: described.deviations[c],
                unit: force.into(),
            };
            (format!("step_{}", c - base.len() + 1), quantity)
        })
        .collect();
    Some(Missing {
        effect: "unnamed".into(),
        says: format!(
            "something repeats over {} between {:.4} and {:.4} {unit} that no law of the catalogue fits",
            name.replace('_', " "),
            region.from,
            region.to
        ),
        equation: format!("step function of {}", name.replace('_', " ")),
        parameters,
        rms_heldout_before: (found.fit.heldout_sum() / rows).sqrt(),
        rms_heldout_after: (described.heldout_sum() / rows).sqrt(),
        gain_ci95: interval,
        p: region.p,
        indistinguishable_from: Vec::new(),
        experiment: format!(
            "repeat the move at another amplitude and another frequency: does it stay at the same {}?",
            name.replace('_', " ")
        ),
    })
}
