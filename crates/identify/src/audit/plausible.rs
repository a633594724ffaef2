//! Numbers in another unit than the header says, where they are so far off that no bench gives them.

use super::{FaultKind, RecordingFault};
use crate::{Geometry, Recording};

/// Rates of sampling, Hz.
const RATES: std::ops::RangeInclusive<f64> = 2.0..=200_000.0;
/// Speeds of a slide, m/s; an axis may turn as fast as it likes.
const FASTEST: f64 = 30.0;

/// Milliseconds for seconds, millimetres for metres.
pub(super) fn units(recording: &Recording, dt: f64, out: &mut Vec<RecordingFault>) {
    let rate = 1.0 / dt;
    if recording.len() < crate::stretches::SHORTEST {
        return;
    }
    if !RATES.contains(&rate) {
        let why = format!("time_s goes on by {dt:.4e} s a sample, {rate:.4e} Hz: is it in s?");
        out.push(RecordingFault::new(FaultKind::Implausible, None, why));
    }
    if recording.geometry == Geometry::Linear {
        // over a four-hundredth of the recording, so that neither noise nor outliers count as motion
        let lag = (recording.len() / 400).max(1);
        let pairs = recording.position.iter().zip(recording.position.iter().skip(lag));
        let mut speeds: Vec<f64> =
            pairs.map(|(a, b)| (b - a).abs() / (lag as f64 * dt)).filter(|v| v.is_finite()).collect();
        speeds.sort_by(f64::total_cmp);
        let speed = speeds.get(speeds.len() / 2).copied().unwrap_or(0.0);
        if speed > FASTEST {
            let why = format!(
                "the body goes {speed:.0} m/s half of the time or faster: is position_m in m and time_s in s?"
            );
            out.push(RecordingFault::new(FaultKind::Implausible, None, why));
        }
    }
}
