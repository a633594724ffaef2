//! Where the model goes wrong in the plane: the residual along the motion and across it, over the direction of motion, the
//! speed and the places of the axes.

use super::design::Design;
use crate::regression::sign_flips::{block_scores, family};
use crate::result::{Bin, Curve, Location};
use identify::planar::Track;
use signals::{Basis, dot, quantile};
use std::f64::consts::PI;

/// Bins over a turn, and over another coordinate.
const BINS: usize = 16;
/// Bins over time.
const TIMES: usize = 6;
/// Fewest rows of a bin.
const FEWEST: usize = 12;

/// A coordinate, and how the residual is read over it.
struct Coordinate {
    name: &'static str,
    unit: &'static str,
    subset: &'static str,
    values: Vec<f64>,
    /// Part of each row's residual that counts.
    weight: Vec<f64>,
}

/// Everything the location step found.
pub(super) struct Located {
    pub regions: Vec<Location>,
    pub curves: Vec<Curve>,
    /// Smallest family-wise p.
    pub p: f64,
}

fn coordinates(design: &Design) -> Vec<Coordinate> {
    let both = |of: &dyn Fn(&Track, usize) -> f64| {
        design.means(|t| {
            let all: Vec<f64> = (0..t.len()).map(|i| of(t, i)).collect();
            [all.clone(), all]
        })
    };
    let direction: Vec<[f64; 2]> = {
        let [x, y] = [0, 1].map(|axis| both(&|t, i| t.direction[axis][i]));
        x.into_iter().zip(y).map(|(x, y)| [x, y]).collect()
    };
    let turned: Vec<f64> = direction.iter().map(|[x, y]| y.atan2(*x)).collect();
    let along = |row: usize| direction[row][design.rows[row].axis];
    let across = |row: usize| if design.rows[row].axis == 0 { -direction[row][1] } else { direction[row][0] };
    let of_axis = |axis: usize| move |row: usize| f64::from(u8::from(design.rows[row].axis == axis));
    let read = |by: &dyn Fn(usize) -> f64| -> Vec<f64> {
        (0..design.rows.len()).map(by).map(|w| if w.is_finite() { w } else { 0.0 }).collect()
    };
    let time: Vec<f64> = design.rows.iter().map(|row| design.tracks[row.track].row_time(row.r)).collect();
    let make = |name, unit, subset, values: &[f64], weight| Coordinate {
        name,
        unit,
        subset,
        values: values.to_vec(),
        weight,
    };
    let speed = both(&|t, i| t.speed[i]);
    let [x, y] = [0, 1].map(|axis| both(&|t, i| t.x[axis][i]));
    vec![
        make("direction_of_motion", "rad", "along the motion", &turned, read(&along)),
        make("direction_of_motion_across", "rad", "across the motion", &turned, read(&across)),
        make("speed", "m/s", "along the motion", &speed, read(&along)),
        make("position_x", "m", "x axis", &x, read(&of_axis(0))),
        make("position_y", "m", "y axis", &y, read(&of_axis(1))),
        make("time", "s", "along the motion", &time, read(&along)),
    ]
}

/// Rows of a bin, and which of the tests is its.
type Tested = (Vec<usize>, Option<usize>);

/// Finds the regions of `residual` beside `columns`; `after` is the residual of the final model.
pub(super) fn locate(
    design: &Design,
    columns: &[Vec<f64>],
    residual: &[f64],
    after: &[f64],
    floor: f64,
    seed: u64,
) -> Located {
    let basis = Basis::of(columns);
    let spread = (dot(after, after) / after.len().max(1) as f64).sqrt();
    let all = coordinates(design);
    let (mut observed, mut noises, mut scale) = (Vec::new(), Vec::new(), Vec::new());
    // coordinate, edges and bins
    let mut cuts: Vec<(usize, Vec<f64>, Vec<Tested>)> = Vec::new();
    for (index, c) in all.iter().enumerate() {
        let used = |row: &usize| design.share[*row] > 0.5 && c.values[*row].is_finite();
        let values: Vec<f64> = (0..design.rows.len()).filter(used).map(|row| c.values[row]).collect();
        if values.len() < 10 * FEWEST {
            continue;
        }
        let turn = c.unit == "rad";
        let (low, high) = if turn { (-PI, PI) } else { (quantile(&values, 0.002), quantile(&values, 0.998)) };
        if !(low < high) {
            continue;
        }
        let count = if c.name == "time" { TIMES } else { BINS };
        let edges: Vec<f64> = (0..=count).map(|i| low + (high - low) * i as f64 / count as f64).collect();
        let mut members = vec![Vec::new(); count];
        for row in (0..design.rows.len()).filter(used) {
            let bin = edges.partition_point(|e| *e <= c.values[row]).saturating_sub(1).min(count - 1);
            members[bin].push(row);
        }
        let bins = members
            .into_iter()
            .map(|rows| {
                let mut indicator = vec![0.0; residual.len()];
                rows.iter().for_each(|row| indicator[*row] = c.weight[*row]);
                let rest = basis.project_out(&indicator);
                let size = dot(&rest, &rest).sqrt();
                if rows.len() < FEWEST || size < 0.1 * dot(&indicator, &indicator).sqrt() || size == 0.0 {
                    return (rows, None);
                }
                observed.push(block_scores(&rest, residual, &design.blocks));
                noises.push(block_scores(&rest, after, &design.blocks));
                scale.push(size * spread);
                (rows, Some(observed.len() - 1))
            })
            .collect();
        cuts.push((index, edges, bins));
    }
    let outcome = family(&observed, &noises, &scale, 999, seed);
    let total = (dot(residual, residual) - floor).max(1e-300);
    let rows_all: f64 = design.share.iter().sum::<f64>().max(1e-300);
    let mut scored: Vec<(f64, Vec<Location>, Curve)> = Vec::new();
    for (index, edges, bins) in &cuts {
        let c = &all[*index];
        let sums = |rows: &[usize], series: &[f64]| {
            let (mut sum, mut weight) = (0.0, 0.0);
            for row in rows {
                sum += c.weight[*row] * series[*row];
                weight += c.weight[*row].powi(2) * design.share[*row];
            }
            (sum, weight)
        };
        let mean = |rows: &[usize], series: &[f64]| {
            let (sum, weight) = sums(rows, series);
            if weight > 0.0 { sum / weight } else { 0.0 }
        };
        let curve = Curve {
            coordinate: c.name.into(),
            unit: c.unit.into(),
            subset: c.subset.into(),
            bins: bins
                .iter()
                .enumerate()
                .filter(|(_, (rows, _))| rows.len() >= FEWEST)
                .map(|(bin, (rows, _))| {
                    let mut by_block = vec![0.0; design.blocks.len()];
                    for row in rows {
                        let block = design.blocks.edges.partition_point(|e| e <= row).saturating_sub(1);
                        if let Some(sum) = by_block.get_mut(block) {
                            *sum += c.weight[*row] * after[*row];
                        }
                    }
                    let (_, weight) = sums(rows, after);
                    Bin {
                        at: 0.5 * (edges[bin] + edges[bin + 1]),
                        before: mean(rows, residual),
                        after: mean(rows, after),
                        band: outcome.critical_95 * dot(&by_block, &by_block).sqrt() / weight.max(1e-300),
                    }
                })
                .collect(),
        };
        let (mut organised, mut regions) = (0.0, Vec::new());
        let p = |bin: usize| bins[bin].1.map_or(1.0, |test| outcome.p[test]);
        let mut bin = 0;
        while bin < bins.len() {
            let start = bin;
            let (mut explained, mut least) = (0.0, 1.0_f64);
            while bin < bins.len() && p(bin) <= 0.05 {
                let (sum, weight) = sums(&bins[bin].0, residual);
                explained += if weight > 0.0 { sum * sum / weight } else { 0.0 };
                least = least.min(p(bin));
                bin += 1;
            }
            if bin == start {
                bin += 1;
                continue;
            }
            organised += explained;
            regions.push(Location {
                coordinate: c.name.into(),
                from: edges[start],
                to: edges[bin],
                unit: c.unit.into(),
                share_of_mismatch: ((explained - floor / rows_all) / total).clamp(0.0, 1.0),
                p: least,
            });
        }
        regions.sort_by(|a, b| b.share_of_mismatch.total_cmp(&a.share_of_mismatch));
        regions.truncate(3);
        scored.push((organised / total, regions, curve));
    }
    scored.sort_by(|a, b| b.0.total_cmp(&a.0));
    Located {
        p: outcome.p.iter().copied().fold(1.0, f64::min),
        regions: scored.iter().flat_map(|(_, regions, _)| regions.clone()).collect(),
        curves: scored.into_iter().map(|(_, _, curve)| curve).collect(),
    }
}
