//! Channels that should be derivatives of each other.

use super::fault::{FaultKind, RecordingFault};
use crate::noise::filter_variance_gain;
use crate::noise::noise_variance;
use crate::stretches::{Stretch, rms_frequency};
use crate::{Filter, Geometry, Recording, four_point_difference, zero_phase};

/// A channel as scale·(reference − lag·reference').
struct Fit {
    scale: f64,
    scale_std: f64,
    /// s.
    lag: f64,
    lag_std: f64,
    r_squared: f64,
    /// Of the reference alone, without lag.
    direct: f64,
}

/// Least squares of `channel` on `reference`, its derivative, and a constant. All are behind the same filter; `noise`
/// is the variance of the reference's error there.
fn fit(channel: &[f64], reference: &[f64], slope: &[f64], noise: f64, independent: f64) -> Option<Fit> {
    let n = channel.len() as f64;
    let mean = |s: &[f64]| s.iter().sum::<f64>() / n;
    let (mc, mr, ms) = (mean(channel), mean(reference), mean(slope));
    let [mut rr, mut ss, mut rs, mut rc, mut sc, mut cc] = [0.0; 6];
    for ((c, r), s) in channel.iter().zip(reference).zip(slope) {
        let (c, r, s) = (c - mc, r - mr, s - ms);
        rr += r * r;
        ss += s * s;
        rs += r * s;
        rc += r * c;
        sc += s * c;
        cc += c * c;
    }
    let clean = rr - n * noise;
    let determinant = clean * ss - rs * rs;
    if !(clean > 0.5 * rr && determinant > 1e-9 * clean * ss && cc > 0.0) {
        return None;
    }
    let scale = (ss * rc - rs * sc) / determinant;
    let by_slope = (clean * sc - rs * rc) / determinant;
    let explained = (scale * rc + by_slope * sc).clamp(0.0, cc);
    let left = (cc - explained) / independent.max(4.0);
    Some(Fit {
        scale,
        scale_std: (left * ss / determinant).sqrt(),
        lag: -by_slope / scale,
        lag_std: (left * clean / determinant).sqrt() / scale.abs().max(1e-300),
        r_squared: explained / cc,
        direct: rc * rc / (clean * cc),
    })
}

/// Compares the velocity column with the derivative of the position, and the acceleration with that of the velocity.
pub(super) fn check(recording: &Recording, stretch: &Stretch, out: &mut Vec<RecordingFault>) {
    let dt = stretch.dt;
    let position = stretch.grid(&recording.position);
    let n = position.len();
    let moving = rms_frequency(&position, dt);
    let cutoff = (6.0 * moving).clamp(10.0 / (n as f64 * dt), 0.2 / dt);
    let Ok(filter) = Filter::butterworth(4, cutoff, dt) else { return };
    let trim = filter.settle().min(n / 8);
    let inner = trim..n - trim;
    let gain = filter_variance_gain(&filter);
    let low = |series: &[f64]| zero_phase(&filter, series);
    let slope = |series: &[f64]| four_point_difference(series, dt);
    let independent = 2.0 * cutoff * dt * inner.len() as f64;
    let v = slope(&low(&position));
    let a = slope(&v);
    let jerk = slope(&a);
    let pick = |linear, rotary| if recording.geometry == Geometry::Rotary { rotary } else { linear };
    let mut factors: [Option<Fit>; 2] = [None, None];
    let noise = noise_variance(&position)
        * crate::filter::white_gain(|f| filter.gain(f).powi(2) * crate::filter::four_point_gain(f, dt));
    if let Some(column) = &recording.velocity {
        let given = low(&stretch.grid(column));
        factors[0] = fit(&given[inner.clone()], &v[inner.clone()], &a[inner.clone()], noise, independent);
        // The column's own noise is not a disagreement.
        let own = noise_variance(column) * gain;
        let all = variance(&given[inner.clone()]);
        let name = pick("velocity_m_s", "velocity_rad_s");
        if let Some(fit) = &factors[0]
            && 1.0 - fit.direct > 0.1 + 3.0 * own / all
            && variance(&v[inner.clone()]) > 4.0 * noise
        {
            let why =
                format!("{name} is not the derivative of the position: {:.0} % of it is", 100.0 * fit.direct);
            out.push(RecordingFault::new(FaultKind::VelocityMismatch, None, why));
            factors[0] = None;
        }
        if let Some(fit) = &factors[0] {
            late(fit, name, "position", dt, out);
        }
    }
    if let Some(column) = &recording.acceleration {
        let given = low(&stretch.grid(column));
        let found =
            fit(&given[inner.clone()], &a[inner.clone()], &jerk[inner], f64::MIN_POSITIVE, independent);
        factors[1] = found.filter(|f| f.r_squared > 0.8);
        if let Some(fit) = &factors[1] {
            late(fit, pick("acceleration_m_s2", "acceleration_rad_s2"), "position", dt, out);
        }
    }
    scale(&factors, pick("velocity_m_s", "velocity_rad_s"), out);
}

/// A column that is behind what it is the derivative of was low-passed by something that delays.
fn late(fit: &Fit, name: &str, of: &str, dt: f64, out: &mut Vec<RecordingFault>) {
    if fit.lag.abs() > 2.0 * dt && fit.lag.abs() > 5.0 * fit.lag_std {
        let (by, way) = (1e3 * fit.lag.abs(), if fit.lag > 0.0 { "behind" } else { "ahead of" });
        let why =
            format!("{name} is {by:.2} ms {way} the {of}: a filter or a delay that the other does not have");
        out.push(RecordingFault::new(FaultKind::HiddenFilter, None, why));
    }
}

/// A factor between velocity and derivative of the position; if the acceleration has its square, it is the clock's.
fn scale(factors: &[Option<Fit>; 2], name: &str, out: &mut Vec<RecordingFault>) {
    let [Some(velocity), acceleration] = factors else { return };
    let off = (velocity.scale - 1.0).abs();
    if off < 0.03 || off < 5.0 * velocity.scale_std {
        return;
    }
    let squared = acceleration.as_ref().is_some_and(|a| {
        let clock = a.scale / (velocity.scale * velocity.scale) - 1.0;
        clock.abs() < 0.02 + 4.0 * a.scale_std / a.scale.abs().max(1e-300) && (a.scale - 1.0).abs() > 0.05
    });
    if squared {
        let why = format!(
            "velocity is {:.4} times the derivative of the position and acceleration {:.4} times its second: the time \
             between samples is {:.4} times what time_s says",
            velocity.scale,
            acceleration.as_ref().map_or(f64::NAN, |a| a.scale),
            1.0 / velocity.scale
        );
        out.push(RecordingFault::new(FaultKind::TimeBase, None, why));
    } else {
        let why = format!(
            "{name} is {:.4} (std {:.4}) times the derivative of the position{}",
            velocity.scale,
            velocity.scale_std,
            match (super::plausible::unit_of(velocity.scale), acceleration) {
                (Some(unit), _) => format!(": {unit}"),
                (None, Some(_)) => String::new(),
                (None, None) => ", or the clock is off by that factor".into(),
            }
        );
        out.push(RecordingFault::new(FaultKind::VelocityScale, None, why));
    }
}

fn variance(series: &[f64]) -> f64 {
    let n = series.len().max(1) as f64;
    let mean = series.iter().sum::<f64>() / n;
    series.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / n
}
