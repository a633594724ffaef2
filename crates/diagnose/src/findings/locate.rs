//! Where the model goes wrong: the conditional mean of the residual over every coordinate a mechanism could
//! depend on, with bands that hold for all bins of all coordinates at once.

use crate::library::design_matrix::DesignMatrix;
use crate::preparation::track::Track;
use crate::regression::sign_flips::{Family, block_scores, family};
use crate::result::{Bin, Curve, Location};
use friction::{Dimension, Geometry, Unit};
use signals::{Basis, LowPass, central_difference, dot, quantile};

/// Bins over one coordinate.
const BINS: usize = 24;
/// Bins over time: over it a mismatch can only drift. What comes and goes faster is the motion's own programme, and
/// finer bins would find every mismatch in the parts that excite it.
const TIMES: usize = 6;

/// A coordinate of the plane in which the residual may show a pattern.
struct Coordinate {
    name: &'static str,
    unit: Unit,
    subset: &'static str,
    values: Vec<f64>,
    /// Bins even in the logarithm: for distances and times since an event.
    logarithmic: bool,
}

/// One coordinate's bins and what was found in them.
struct Cut {
    coordinate: usize,
    edges: Vec<f64>,
    /// Rows of each bin.
    members: Vec<Vec<usize>>,
    /// Index of each bin's test in the family, where it was tested.
    tests: Vec<Option<usize>>,
}

/// Everything the location step found.
#[derive(Debug, Clone, Default)]
pub struct Located {
    /// Regions outside the band, most telling first.
    pub regions: Vec<Location>,
    /// Conditional means, most telling first.
    pub curves: Vec<Curve>,
    /// Smallest family-wise p over all bins of all coordinates.
    pub p: f64,
    /// Coordinate values by row and its bins, for describing what no law fits: name, unit, values, edges.
    pub tables: Vec<(String, String, Vec<f64>, Vec<f64>)>,
}

/// Mean over the used samples of each row of a series.
fn row_means(design: &DesignMatrix, of: impl Fn(&Track) -> Vec<f64>) -> Vec<f64> {
    let mut out = Vec::with_capacity(design.share.len());
    for track in &design.tracks {
        let series = of(track);
        for r in 0..track.row_count() {
            let rows = r * track.stride..(r + 1) * track.stride;
            let (sum, weight) =
                rows.fold((0.0, 0.0), |(s, w), i| (s + series[i] * track.mask[i], w + track.mask[i]));
            out.push(if weight > 0.0 { sum / weight } else { f64::NAN });
        }
    }
    out
}

/// Time of each row, s.
pub fn row_times(design: &DesignMatrix) -> Vec<f64> {
    let mut out = Vec::with_capacity(design.share.len());
    for track in &design.tracks {
        for r in 0..track.row_count() {
            out.push(track.time(r * track.stride) + 0.5 * (track.stride - 1) as f64 * track.raw.dt);
        }
    }
    out
}

/// Position and velocity of each row.
pub fn row_motion(design: &DesignMatrix) -> (Vec<f64>, Vec<f64>) {
    (row_means(design, |t| t.x.clone()), row_means(design, |t| t.v.clone()))
}

/// A coordinate must not carry the residual's own noise: sorted by the measured force, noise alone has a slope. So
/// force and acceleration are the model's, and slower than what is being located.
fn smooth(track: &Track, series: &[f64]) -> Vec<f64> {
    LowPass::new(0.25 * track.filter.cutoff(), track.raw.dt).apply(series)
}

fn coordinates(design: &DesignMatrix, geometry: Geometry) -> Vec<Coordinate> {
    let (length, speed, force) = (Dimension::LENGTH, Dimension::VELOCITY, Dimension::FORCE);
    let make = |name, dimension: Dimension, values| Coordinate {
        name,
        unit: dimension.unit(geometry),
        subset: "",
        values,
        logarithmic: false,
    };
    let position = row_means(design, |t| t.x.clone());
    let velocity = row_means(design, |t| t.v.clone());
    let direction = |want: f64| -> Vec<f64> {
        position.iter().zip(&velocity).map(|(x, v)| if v * want > 0.0 { *x } else { f64::NAN }).collect()
    };
    let finite = |series: Vec<f64>| -> Vec<f64> {
        series.into_iter().map(|x| if x.is_finite() { x } else { f64::NAN }).collect()
    };
    let mut all = vec![
        make("velocity", speed, velocity.clone()),
        Coordinate {
            logarithmic: true,
            ..make("low_speed", speed, velocity.iter().map(|v| v.abs()).collect())
        },
        make("position", length, position.clone()),
        Coordinate { subset: "moving forward", ..make("position_forward", length, direction(1.0)) },
        Coordinate { subset: "moving backward", ..make("position_backward", length, direction(-1.0)) },
        make("acceleration", Dimension::ACCELERATION, row_means(design, |t| smooth(t, &t.a))),
        Coordinate {
            logarithmic: true,
            ..make("distance_since_reversal", length, finite(row_means(design, |t| t.distance.clone())))
        },
        Coordinate {
            logarithmic: true,
            ..make("time_since_reversal", Dimension::TIME, finite(row_means(design, |t| t.since.clone())))
        },
        make("time", Dimension::TIME, row_times(design)),
        make("force", force, row_means(design, |t| smooth(t, &t.force_model))),
        make(
            "jerk",
            force.per(Dimension::TIME),
            row_means(design, |t| central_difference(&smooth(t, &t.force_model), t.raw.dt)),
        ),
    ];
    if design.tracks.iter().all(|t| t.normal.is_some()) {
        all.push(make("load", Dimension::LOAD, row_means(design, |t| t.normal.clone().unwrap_or_default())));
    }
    all
}

fn cut(index: usize, coordinate: &Coordinate, design: &DesignMatrix) -> Option<Cut> {
    let used: Vec<f64> = coordinate
        .values
        .iter()
        .zip(&design.share)
        .filter(|(v, s)| v.is_finite() && **s > 0.5)
        .map(|(v, _)| *v)
        .collect();
    if used.len() < 60 {
        return None;
    }
    let (mut low, mut high) = (quantile(&used, 0.002), quantile(&used, 0.998));
    if coordinate.logarithmic {
        low = quantile(&used, 0.01).max(1e-4 * high).max(1e-300);
        high = high.max(low * 1.0001);
    }
    if !(low < high) {
        return None;
    }
    let count = if coordinate.name == "time" { TIMES } else { BINS };
    let edges: Vec<f64> = (0..=count)
        .map(|i| {
            let share = i as f64 / count as f64;
            if coordinate.logarithmic { low * (high / low).powf(share) } else { low + (high - low) * share }
        })
        .collect();
    let mut members = vec![Vec::new(); count];
    for (row, v) in coordinate.values.iter().enumerate() {
        if !v.is_finite() || design.share[row] <= 0.5 {
            continue;
        }
        let bin = edges.partition_point(|e| e <= v).saturating_sub(1).min(count - 1);
        members[bin].push(row);
    }
    Some(Cut { coordinate: index, edges, members, tests: vec![None; count] })
}

/// Odd coordinates fold onto themselves when the residual's sign follows the direction of motion; this tells
/// which sign a bin's residual is read with.
fn signs(design: &DesignMatrix, coordinate: &Coordinate) -> Vec<f64> {
    let velocity = row_means(design, |t| t.sign.clone());
    match coordinate.name {
        // Friction is odd: over |v| or x_r it would average out between the two directions.
        "low_speed" | "distance_since_reversal" | "time_since_reversal" | "time" | "load" => {
            velocity.iter().map(|v| if *v < 0.0 { -1.0 } else { 1.0 }).collect()
        }
        _ => vec![1.0; velocity.len()],
    }
}

/// Finds the regions of `residual`; `columns` are what was fitted, `noise` the residual taken as noise, and
/// `after` the residual of the final model for the curves.
#[allow(clippy::too_many_arguments)] // residuals of three kinds; a struct would name them once more
pub fn locate(
    design: &DesignMatrix,
    columns: &[&[f64]],
    residual: &[f64],
    noise: &[f64],
    after: &[f64],
    floor: f64,
    geometry: Geometry,
    seed: u64,
) -> Located {
    let basis = Basis::of(columns);
    let spread = (dot(noise, noise) / noise.len().max(1) as f64).sqrt();
    let all = coordinates(design, geometry);
    let mut cuts: Vec<Cut> = all.iter().enumerate().filter_map(|(i, c)| cut(i, c, design)).collect();
    let (mut observed, mut noises, mut scale) = (Vec::new(), Vec::new(), Vec::new());
    for c in &mut cuts {
        let sign = signs(design, &all[c.coordinate]);
        for (bin, rows) in c.members.iter().enumerate() {
            if rows.len() < 6 {
                continue;
            }
            let mut indicator = vec![0.0; residual.len()];
            for &r in rows {
                indicator[r] = sign[r];
            }
            let rest = basis.project_out(&indicator);
            let size = dot(&rest, &rest).sqrt();
            if size < 0.1 * dot(&indicator, &indicator).sqrt() {
                continue;
            }
            c.tests[bin] = Some(observed.len());
            observed.push(block_scores(&rest, residual, &design.blocks));
            noises.push(block_scores(&rest, noise, &design.blocks));
            scale.push(size * spread);
        }
    }
    let outcome = family(&observed, &noises, &scale, 999, seed);
    let total = (dot(residual, residual) - floor).max(1e-300);
    let mut located = Located { p: outcome.p.iter().copied().fold(1.0, f64::min), ..Located::default() };
    let mut scored: Vec<(f64, Vec<Location>, Curve)> = Vec::new();
    for c in &cuts {
        let coordinate = &all[c.coordinate];
        let sign = signs(design, coordinate);
        let bins = describe(design, c, &sign, residual, after, &outcome, noise);
        let (score, regions) = regions(design, c, coordinate, residual, &sign, &outcome, floor, total);
        let curve = Curve {
            coordinate: coordinate.name.into(),
            unit: coordinate.unit.to_string(),
            subset: coordinate.subset.into(),
            bins,
        };
        located.tables.push((
            coordinate.name.into(),
            coordinate.unit.to_string(),
            coordinate.values.clone(),
            c.edges.clone(),
        ));
        scored.push((score, regions, curve));
    }
    scored.sort_by(|a, b| b.0.total_cmp(&a.0));
    for (_, regions, curve) in scored {
        located.regions.extend(regions);
        located.curves.push(curve);
    }
    located
}

fn describe(
    design: &DesignMatrix,
    cut: &Cut,
    sign: &[f64],
    before: &[f64],
    after: &[f64],
    outcome: &Family,
    noise: &[f64],
) -> Vec<Bin> {
    cut.members
        .iter()
        .enumerate()
        .filter(|(_, rows)| rows.len() >= 6)
        .map(|(bin, rows)| {
            let mean = |series: &[f64]| {
                let (mut sum, mut weight) = (0.0, 0.0);
                for &r in rows {
                    sum += series[r] * sign[r];
                    weight += design.share[r];
                }
                if weight > 0.0 { sum / weight } else { 0.0 }
            };
            let mut by_block = vec![0.0; design.blocks.len()];
            let mut weight = 0.0;
            for &r in rows {
                let block = design.blocks.edges.partition_point(|e| *e <= r).saturating_sub(1);
                if let Some(b) = by_block.get_mut(block) {
                    *b += noise[r];
                }
                weight += design.share[r];
            }
            let deviation = dot(&by_block, &by_block).sqrt() / weight.max(1e-300);
            Bin {
                at: if cut.edges[0] > 0.0 && cut.edges[1] / cut.edges[0] > 1.05 {
                    (cut.edges[bin] * cut.edges[bin + 1]).sqrt()
                } else {
                    0.5 * (cut.edges[bin] + cut.edges[bin + 1])
                },
                before: mean(before),
                after: mean(after),
                band: outcome.critical_95 * deviation,
            }
        })
        .collect()
}

/// Stretches of neighbouring bins outside the band, and how much of the residual the coordinate organises.
#[allow(clippy::too_many_arguments)]
fn regions(
    design: &DesignMatrix,
    cut: &Cut,
    coordinate: &Coordinate,
    residual: &[f64],
    sign: &[f64],
    outcome: &Family,
    floor: f64,
    total: f64,
) -> (f64, Vec<Location>) {
    let rows_all: f64 = design.share.iter().sum();
    let significant = |bin: usize| cut.tests[bin].is_some_and(|t| outcome.p[t] <= 0.05);
    let mut organised = 0.0;
    let mut out = Vec::new();
    let mut bin = 0;
    while bin < cut.members.len() {
        if !significant(bin) {
            bin += 1;
            continue;
        }
        let start = bin;
        let (mut squared, mut weight, mut p) = (0.0, 0.0, 1f64);
        while bin < cut.members.len() && significant(bin) {
            let (mut sum, mut size) = (0.0, 0.0);
            for &r in &cut.members[bin] {
                sum += residual[r] * sign[r];
                size += design.share[r];
                squared += residual[r].powi(2);
            }
            weight += size;
            if size > 0.0 {
                organised += sum * sum / size;
            }
            p = p.min(cut.tests[bin].map_or(1.0, |t| outcome.p[t]));
            bin += 1;
        }
        let share = ((squared - floor * weight / rows_all.max(1e-300)) / total).clamp(0.0, 1.0);
        out.push(Location {
            coordinate: coordinate.name.into(),
            from: cut.edges[start],
            to: cut.edges[bin],
            unit: coordinate.unit.to_string(),
            share_of_mismatch: share,
            p,
        });
    }
    out.sort_by(|a, b| b.share_of_mismatch.total_cmp(&a.share_of_mismatch));
    out.truncate(3);
    (organised / total, out)
}
