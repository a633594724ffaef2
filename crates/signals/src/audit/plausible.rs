//! Numbers in another unit than the header says, where they are so far off that no bench gives them, or where another column
//! says which.

use super::fault::{FaultKind, RecordingFault};
use crate::noise::quantum;
use crate::{Geometry, Recording};
use friction::Dimension;
use std::f64::consts::{PI, TAU};

/// Rates of sampling, Hz.
const RATES: std::ops::RangeInclusive<f64> = 2.0..=200_000.0;
/// Speeds of a slide, m/s; an axis may turn as fast as it likes.
const FASTEST: f64 = 30.0;

/// Longest stroke of a slide, m.
const LONGEST: f64 = 10.0;
/// Widest swing of an axis that goes to and fro, rad.
const WIDEST: f64 = 5.0 * TAU;

/// Factors between a column and what it should be that are a unit, and which.
const UNITS: [(f64, &str); 8] = [
    (PI / 180.0, "the position is in degrees"),
    (180.0 / PI, "the velocity is in degrees per second"),
    (1e-3, "the position is in mm"),
    (1e3, "the velocity is in mm/s, or the time in ms"),
    (60.0 / TAU, "the velocity is in turns per minute"),
    (TAU / 60.0, "the position is in turns, and the velocity in turns per minute"),
    (1.0 / TAU, "the velocity is in turns per second"),
    (TAU, "the position is in turns"),
];

/// The unit that a factor between two columns points to.
pub(super) fn unit_of(factor: f64) -> Option<&'static str> {
    UNITS.iter().find(|(unit, _)| (factor / unit - 1.0).abs() < 0.03).map(|(_, what)| *what)
}

/// Reports a fitted mass below zero: the recorded force does not accelerate this body. `mass` and its standard error are in kg or
/// kg·m².
#[must_use]
pub fn implausible_mass(mass: f64, std: f64, geometry: Geometry) -> Option<RecordingFault> {
    if !(mass < 0.0) {
        return None;
    }
    let unit = Dimension::MASS.unit(geometry);
    let what = if geometry == Geometry::Rotary { "inertia" } else { "mass" };
    let because = if mass + 3.0 * std < 0.0 {
        "the force has the wrong sign, or is mostly something else than what accelerates this body (a pressure, a \
         preload, a spring)"
    } else {
        "the motion is too slow, or the channels too noisy, for inertia to show"
    };
    // two digits of the error
    let places = (1.0 - std.log10().floor()).clamp(0.0, 12.0) as usize;
    let why = format!("the {what} that fits best is {mass:.places$} ± {std:.places$} {unit}: {because}");
    Some(RecordingFault::new(FaultKind::Implausible, None, why))
}

/// A position in counts, in degrees or in millimetres, as far as its own values tell.
fn position(recording: &Recording, out: &mut Vec<RecordingFault>) {
    let finite = || recording.position.iter().copied().filter(|x| x.is_finite());
    let (low, high) = finite().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), x| (l.min(x), h.max(x)));
    let span = high - low;
    let path: f64 =
        recording.position.windows(2).map(|w| (w[1] - w[0]).abs()).filter(|d| d.is_finite()).sum();
    let is_rotary = recording.geometry == Geometry::Rotary;
    let name = if is_rotary { "position_rad" } else { "position_m" };
    let is_whole = (quantum(&recording.position) - 1.0).abs() < 1e-9 && finite().all(|x| x == x.round());
    let what = if is_whole && span > 20.0 {
        format!("{name} goes in whole steps of 1: is it in counts of an encoder?")
    } else if is_rotary && span > WIDEST && path > 1.5 * span {
        format!("the axis goes to and fro over {:.0} turns: is {name} in degrees?", span / TAU)
    } else if !is_rotary && span > LONGEST {
        format!("the body moves over {span:.0} m: is {name} in mm?")
    } else {
        return;
    };
    out.push(RecordingFault::new(FaultKind::Implausible, None, what));
}

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
    position(recording, out);
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
