//! Where an error of the force sits that is known sample by sample, such as what a motion channel does to a simulation that
//! is driven by it: nothing has to be told from noise, only to be found.

use crate::library::design_matrix::DesignMatrix;
use crate::preparation::track::Track;
use crate::result::Location;
use friction::{Dimension, Geometry};
use signals::quantile;

/// Bins over one coordinate.
const BINS: usize = 24;
/// Coordinates that are told, those that gather it most.
const TOLD: usize = 2;
/// Regions of each.
const REGIONS: usize = 3;

/// The error of every sample of every track, where there is one.
pub type Errors = Vec<Vec<Option<f64>>>;

/// The regions that hold more of the squared error than of the samples, those of the coordinate that gathers it most first.
/// `p`: of the effect the error is of.
pub fn regions(design: &DesignMatrix, errors: &Errors, geometry: Geometry, p: f64) -> Vec<Location> {
    type Values = fn(&Track) -> &[f64];
    let coordinates: [(&str, Dimension, Values); 4] = [
        ("time_since_reversal", Dimension::TIME, |t| &t.since),
        ("acceleration", Dimension::ACCELERATION, |t| &t.a),
        ("velocity", Dimension::VELOCITY, |t| &t.v),
        ("position", Dimension::LENGTH, |t| &t.x),
    ];
    let step = design.tracks.iter().map(|t| t.raw.dt).fold(0.0, f64::max);
    let mut gathered: Vec<(f64, Vec<Location>)> = Vec::new();
    for (name, dimension, values) in coordinates {
        let rows: Vec<(f64, f64)> = design
            .tracks
            .iter()
            .zip(errors)
            .flat_map(|(t, e)| values(t).iter().zip(e))
            .filter_map(|(value, e)| Some((*value, (*e)?.powi(2))))
            .filter(|(value, _)| value.is_finite())
            .collect();
        let Some(edges) = edges(&rows, (name == "time_since_reversal").then_some(step)) else { continue };
        let (mut held, mut count) = (vec![0.0; BINS], vec![0.0; BINS]);
        for (value, square) in &rows {
            let bin = edges.partition_point(|e| e <= value).saturating_sub(1).min(BINS - 1);
            held[bin] += square;
            count[bin] += 1.0;
        }
        let (all, samples) = (held.iter().sum::<f64>(), rows.len() as f64);
        if !(all > 0.0) {
            continue;
        }
        let more = |bin: usize| held[bin] / all - count[bin] / samples;
        let mut found = Vec::new();
        let mut bin = 0;
        while bin < BINS {
            let from = bin;
            // times come in samples: what is empty between two bins parts nothing
            while bin < BINS && (more(bin) > 0.0 || bin > from && count[bin] == 0.0) {
                bin += 1;
            }
            if bin > from {
                found.push(Location {
                    coordinate: name.into(),
                    from: edges[from],
                    to: edges[bin],
                    unit: dimension.unit(geometry).to_string(),
                    share_of_mismatch: held[from..bin].iter().sum::<f64>() / all,
                    p,
                });
            }
            bin += 1;
        }
        found.sort_by(|a, b| b.share_of_mismatch.total_cmp(&a.share_of_mismatch));
        found.truncate(REGIONS);
        gathered.push(((0..BINS).map(|b| more(b).max(0.0)).sum(), found));
    }
    gathered.sort_by(|a, b| b.0.total_cmp(&a.0));
    gathered.into_iter().take(TOLD).flat_map(|(_, regions)| regions).collect()
}

/// Edges of the bins, even; in the logarithm from `finest` on, and from 0 to it, where there is a finest.
fn edges(rows: &[(f64, f64)], finest: Option<f64>) -> Option<Vec<f64>> {
    let values: Vec<f64> = rows.iter().map(|r| r.0).collect();
    let (low, high) = (quantile(&values, 0.002), quantile(&values, 0.998));
    let share = |i: usize, count: usize| i as f64 / count as f64;
    match finest {
        Some(finest) if finest > 0.0 && high > finest => {
            let ratio = high / finest;
            Some(
                (0..=BINS)
                    .map(|i| if i == 0 { 0.0 } else { finest * ratio.powf(share(i - 1, BINS - 1)) })
                    .collect(),
            )
        }
        None if low < high => Some((0..=BINS).map(|i| low + (high - low) * share(i, BINS)).collect()),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::preparation::track::Reversals;
    use signals::Channels;

    #[test]
    fn an_error_after_reversals_is_found_there_and_one_of_the_acceleration_at_its_ends() {
        let at = |i: usize| 0.01 * (i as f64 * 5e-3).sin() + 2e-3 * (i as f64 * 0.0171).sin();
        let channels = Channels {
            dt: 1e-3,
            position: (0..8000).map(at).collect(),
            force: vec![0.0; 8000],
            ..Channels::default()
        };
        let design = DesignMatrix::new(&[channels], 50.0, Reversals::default(), false).expect("a design");
        let of = |error: &dyn Fn(&Track, usize) -> Option<f64>| -> Errors {
            design.tracks.iter().map(|t| (0..t.len()).map(|i| error(t, i)).collect()).collect()
        };
        let late = of(&|t, i| (t.since[i] < 4.5e-3).then_some(if i % 2 == 0 { 3.0 } else { -3.0 }));
        let everywhere = late.iter().map(|t| t.iter().map(|e| Some(e.unwrap_or(0.01))).collect()).collect();
        let first = &regions(&design, &everywhere, Geometry::Linear, 1e-3)[0];
        println!("{first:?}");
        assert_eq!(
            (first.coordinate.as_str(), first.unit.as_str(), first.from),
            ("time_since_reversal", "s", 0.0)
        );
        assert!(first.to < 8e-3 && first.share_of_mismatch > 0.95);
        let scale = regions(&design, &of(&|t, i| Some(0.1 * t.a[i])), Geometry::Rotary, 1e-3);
        println!("{scale:?}");
        let ends: Vec<_> = scale.iter().filter(|l| l.coordinate == "acceleration").collect();
        assert!(ends.len() == 2 && ends[0].from * ends[1].from < 0.0 && ends[0].unit == "rad/s²");
        assert!(regions(&design, &of(&|_, _| None), Geometry::Linear, 1e-3).is_empty());
    }
}
