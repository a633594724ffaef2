//! The noise floor: what of the residual does not repeat when the motion does.

use crate::library::design_matrix::DesignMatrix;
use crate::preparation::track::Track;
use signals::{differentiated, dot, quantum};

/// A floor behind the filter and the row average.
#[derive(Debug, Clone, PartialEq)]
pub struct Floor {
    /// Root mean square, in the unit of force.
    pub rms: f64,
    /// `repeats`, `declared`, `local differences` or `quantum`.
    pub how: &'static str,
    /// Period of the motion where it repeats, s.
    pub period: Option<f64>,
}

/// What the steps of the force channel leave behind the filter. Rounding averages out if noise or motion takes the channel
/// over many steps from sample to sample. If one value stands for many samples, it does not, and repeats with the motion.
fn rounding(design: &DesignMatrix) -> f64 {
    let (mut square, mut weight) = (0.0, 0.0);
    for track in &design.tracks {
        let force = &track.raw.force;
        let changes = force.windows(2).filter(|w| w[0] != w[1]).count().max(1);
        let stands = force.len() as f64 / changes as f64;
        let white = track.filter.white_gain(track.stride);
        let rows = track.row_count() as f64;
        square += rows * quantum(force).powi(2) / 12.0 * (stands * white * white).min(1.0);
        weight += rows;
    }
    (square / f64::max(weight, 1.0)).sqrt()
}

/// Estimates the floor: the largest that applies. `residual` holds, per track, the baseline's residual at every sample; `mass` is the
/// baseline's, for the share of the force noise that comes from the acceleration.
pub fn floor(design: &DesignMatrix, residual: &[Vec<f64>], mass: f64, declared: Option<f64>) -> Floor {
    let found = scatter(design, residual, mass, declared);
    let steps = rounding(design);
    if steps > found.rms { Floor { rms: steps, how: "quantum", ..found } } else { found }
}

/// The floor by what differs between repeats or from sample to sample, or as declared.
fn scatter(design: &DesignMatrix, residual: &[Vec<f64>], mass: f64, declared: Option<f64>) -> Floor {
    let mut repeats = (0.0, 0.0);
    let mut found = None;
    for (track, e) in design.tracks.iter().zip(residual) {
        if let Some(period) = period(track) {
            found.get_or_insert(period);
            let (sum, weight) = pure_error(track, e, period);
            repeats = (repeats.0 + sum, repeats.1 + weight);
        }
    }
    if repeats.1 >= 50.0 {
        return Floor { rms: (repeats.0 / repeats.1).sqrt(), how: "repeats", period: found };
    }
    let mut square = 0.0;
    let mut weight = 0.0;
    let mut from = 0;
    for track in &design.tracks {
        let white = track.filter.white_gain(track.stride);
        let force = declared.unwrap_or(track.noise.force) * white;
        let rows: f64 = design.share[from..from + track.row_count()].iter().sum();
        from += track.row_count();
        square += rows * force * force;
        weight += rows;
    }
    // as drawn behind the filter, the mask and the average of a row, all of which take from it
    square += mass * mass * design.blocks.noise.iter().sum::<f64>();
    let how = if declared.is_some() { "declared" } else { "local differences" };
    Floor { rms: (square / f64::max(weight, 1.0)).sqrt(), how, period: None }
}

/// Share of the noise floor taken for regular.
pub const REGULAR: f64 = 0.3;

/// Force, rms, below which nothing is named although a long recording resolves it: there sit the sensors' own regular
/// errors. The moment of a sample and the like are taken for a share of the floor; quantisation repeats with a motion
/// that repeats, and then all of it looks like physics.
pub fn systematic(design: &DesignMatrix, mass: f64, cutoff: f64, floor: f64) -> f64 {
    let rounding = |series: &[f64]| quantum(series) / 12f64.sqrt();
    let of = |track: &Track| {
        let dt = track.raw.dt;
        // other sources of the acceleration dilute it
        let acceleration =
            (rounding(&track.raw.position) * differentiated(2, cutoff, dt)).min(track.noise.acceleration);
        let force = rounding(&track.raw.force) * differentiated(0, cutoff, dt);
        (mass * acceleration).hypot(force)
    };
    design.tracks.iter().map(of).fold(REGULAR * floor, f64::max)
}

/// Half the mean square of what differs between one period and the next, over rows in use in both.
fn pure_error(track: &Track, residual: &[f64], period: f64) -> (f64, f64) {
    let shift = period / track.raw.dt;
    let whole = shift.floor() as usize;
    let share = shift - whole as f64;
    let (mut sum, mut weight) = (0.0, 0.0);
    for r in 0..track.row_count() {
        let rows = r * track.stride..(r + 1) * track.stride;
        if rows.end + whole + 1 >= track.len() {
            break;
        }
        let mut difference = 0.0;
        let mut used = true;
        for i in rows {
            let (a, b) = (i + whole, i + whole + 1);
            used &= track.mask[i] == 1.0 && track.mask[a] == 1.0 && track.mask[b] == 1.0;
            difference += residual[i] - (residual[a] * (1.0 - share) + residual[b] * share);
        }
        if used {
            let mean = difference / track.stride as f64;
            sum += 0.5 * mean * mean;
            weight += 1.0;
        }
    }
    (sum, weight)
}

/// Period with which the motion repeats at least twice, s; from the reference where there is one.
pub fn period(track: &Track) -> Option<f64> {
    let from = track.raw.reference.as_ref().map_or(track.x.as_slice(), Vec::as_slice);
    let n = from.len();
    let step = (n / 1500).max(1);
    let mean = from.iter().sum::<f64>() / n.max(1) as f64;
    let coarse: Vec<f64> = from.iter().step_by(step).map(|x| x - mean).collect();
    let m = coarse.len();
    let power = dot(&coarse, &coarse) / m.max(1) as f64;
    if m < 64 || !(power > 0.0) {
        return None;
    }
    let mismatch = |series: &[f64], lag: usize| -> f64 {
        let count = series.len() - lag;
        series[..count].iter().zip(&series[lag..]).map(|(a, b)| (a - b).powi(2)).sum::<f64>()
            / (2.0 * power * count as f64)
    };
    let curve: Vec<f64> = (0..=m / 2).map(|lag| mismatch(&coarse, lag)).collect();
    // The motion must have gone elsewhere before it counts as having come back.
    let away = curve.iter().position(|d| *d > 0.2)?;
    let best = (away + 1..curve.len().saturating_sub(1))
        .filter(|&l| curve[l] <= curve[l - 1] && curve[l] <= curve[l + 1])
        .find(|&l| curve[l] < 0.02)?;
    let centred: Vec<f64> = from.iter().map(|x| x - mean).collect();
    let low = (best.saturating_sub(1) * step).max(1);
    let high = ((best + 1) * step).min(n / 2);
    let fine = (low..=high).min_by(|a, b| mismatch(&centred, *a).total_cmp(&mismatch(&centred, *b)))?;
    let at = mismatch(&centred, fine);
    if at > 1e-3 || fine + 1 >= n || fine == 0 {
        return None;
    }
    let (left, right) = (mismatch(&centred, fine - 1), mismatch(&centred, fine + 1));
    let curvature = left - 2.0 * at + right;
    let offset = if curvature > 0.0 { (0.5 * (left - right) / curvature).clamp(-0.5, 0.5) } else { 0.0 };
    Some((fine as f64 + offset) * track.raw.dt)
}
