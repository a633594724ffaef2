//! Physics no law of the catalogue fits: described by its mean over the coordinate where it sits, and only
//! claimed when that description holds on blocks it was not fitted to.

use crate::findings::locate::Located;
use crate::regression::linear::FOLDS;
use crate::regression::linear::fit;
use crate::regression::sign_flips::gain_interval;
use crate::result::{Location, Missing, Quantity};
use crate::search::extra_columns::Followed;
use crate::search::hypothesis::Hypothesis;
use crate::search::judgement::{LEVEL, Search};
use friction::effects::{Describe, Unnamed};
use friction::{Dimension, Geometry};
use std::collections::BTreeMap;

/// Steps of the description.
const STEPS: usize = 8;

/// Error over the noise floor from which on something is missing even where nothing says what: where what is left follows a
/// coordinate, and where it does not.
pub const SEVERAL: f64 = 3.0;
const MANY: f64 = 10.0;

/// What is left where it is several floors and nothing that was tried holds: a statement about the recording, not a model.
pub fn elsewhere(search: &Search, found: &Hypothesis, p: f64, geometry: Geometry) -> Option<Missing> {
    let rows: f64 = search.design.block_weight().iter().sum();
    let rms = (found.fit.heldout_sum() / rows).sqrt();
    let floor = (search.floor / rows).sqrt();
    let unit = Dimension::FORCE.unit(geometry);
    (rms > if p <= LEVEL { SEVERAL } else { MANY } * floor).then(|| Missing {
        effect: Unnamed::ABOUT.id.into(),
        says: format!(
            "the error is {:.0} times the noise floor, and nothing in this recording explains it: it depends on \
             something that is not in the recording",
            rms / floor
        ),
        equation: String::new(),
        parameters: BTreeMap::new(),
        rms_heldout_before: rms,
        rms_heldout_after: rms,
        gain_ci95: [0.0, 0.0],
        p,
        indistinguishable_from: Vec::new(),
        experiment: format!(
            "record what may act on this body beside its own motion (other joints, a temperature, a supply, a load) as \
             further columns: {} {unit} are left",
            crate::findings::words::short(rms)
        ),
    })
}

/// The further columns that the error follows.
pub fn follows(all: &[Followed]) -> Option<Missing> {
    let (first, last) = (all.first()?, all.last()?);
    let list = |of: &dyn Fn(&Followed) -> String| all.iter().map(of).collect::<Vec<_>>().join(", ");
    let names = list(&|f| f.name.clone());
    Some(Missing {
        effect: Unnamed::ABOUT.id.into(),
        says: format!("the mismatch follows {names}: what acts there is not in the model"),
        equation: list(&|f| {
            format!("{}curve of {}", if f.with_direction { "sgn(v) times a " } else { "" }, f.name)
        }),
        parameters: BTreeMap::new(),
        rms_heldout_before: first.rms.0,
        rms_heldout_after: last.rms.1,
        gain_ci95: [all.iter().map(|f| f.gain[0]).sum(), all.iter().map(|f| f.gain[1]).sum()],
        p: LEVEL,
        indistinguishable_from: Vec::new(),
        experiment: format!("repeat the move with {} held still", first.name),
    })
}

/// Where it follows them: over the whole range of each column.
pub fn where_it_follows(all: &[Followed]) -> Vec<Location> {
    let whole = all.first().map_or(1.0, |f| f.rms.0 * f.rms.0);
    let of = |f: &Followed| Location {
        coordinate: f.name.clone(),
        from: f.range().0,
        to: f.range().1,
        unit: unit_of(&f.name).into(),
        share_of_mismatch: (f.rms.0 * f.rms.0 - f.rms.1 * f.rms.1) / whole,
        p: LEVEL,
    };
    all.iter().map(of).collect()
}

/// Unit at the end of the name of a column, empty where there is none.
fn unit_of(name: &str) -> &'static str {
    let units = [
        ("_rad_s", "rad/s"),
        ("_m_s", "m/s"),
        ("_rad_s2", "rad/s²"),
        ("_m_s2", "m/s²"),
        ("_nm", "N·m"),
        ("_rad", "rad"),
        ("_n", "N"),
        ("_m", "m"),
        ("_v", "V"),
        ("_a", "A"),
        ("_c", "°C"),
        ("_s", "s"),
        ("_pa", "Pa"),
    ];
    units.iter().find(|(end, _)| name.ends_with(end)).map_or("", |(_, unit)| unit)
}

/// The most telling coordinate of what is left, if a step function of it gains on held-out blocks.
pub fn find(
    search: &Search,
    found: &Hypothesis,
    left: &Located,
    start: f64,
    geometry: Geometry,
) -> Option<Missing> {
    let design = search.design;
    if left.p > LEVEL {
        return None;
    }
    let region = left.regions.iter().find(|r| r.p <= LEVEL)?;
    let (name, unit, values, edges) = left.tables.iter().find(|t| t.0 == region.coordinate)?;
    let base = Hypothesis::columns(design, &found.atoms);
    let directed = ["low_speed", "distance_since_reversal", "time_since_reversal", "time", "load"]
        .contains(&name.as_str());
    let sign = design.rows(|t| t.sign.clone());
    let mut steps = vec![vec![0.0; design.y.len()]; STEPS];
    let per = edges.len().saturating_sub(1).div_ceil(STEPS).max(1);
    for (row, v) in values.iter().enumerate() {
        if !v.is_finite() || design.share[row] <= 0.5 {
            continue;
        }
        let bin = edges.partition_point(|e| e <= v).saturating_sub(1).min(edges.len().saturating_sub(2));
        let way = if directed && sign[row] < 0.0 { -1.0 } else { 1.0 };
        if let Some(step) = steps.get_mut(bin / per) {
            step[row] = way * design.share[row];
        }
    }
    let mut columns: Vec<&[f64]> = base.clone();
    let mut basis = signals::Basis::of(&base);
    for step in &steps {
        let size = signals::dot(step, step);
        let rest = basis.project_out(step);
        if signals::dot(&rest, &rest) > 0.05 * size && basis.push(step) {
            columns.push(step);
        }
    }
    if columns.len() == base.len() {
        return None;
    }
    let described = fit(&columns, &design.y, &design.blocks, FOLDS)?;
    let interval = gain_interval(
        &found.fit.heldout,
        &described.heldout,
        &design.block_weight(),
        &design.blocks.recordings,
        2000,
        search.seed,
    );
    let gained = found.fit.heldout_sum() - described.heldout_sum();
    if interval[0] <= 0.0 || gained < (0.05 * (start - search.floor)).max(search.systematic) {
        return None;
    }
    let rows: f64 = design.block_weight().iter().sum();
    let force = Dimension::FORCE.unit(geometry);
    let parameters: BTreeMap<String, Quantity> = (base.len()..columns.len())
        .map(|c| {
            let quantity = Quantity {
                value: described.coefficients[c],
                std: described.std_errors[c],
                unit: force.to_string(),
            };
            (format!("step_{}", c - base.len() + 1), quantity)
        })
        .collect();
    Some(Missing {
        effect: Unnamed::ABOUT.id.into(),
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
