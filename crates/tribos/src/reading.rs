//! Recordings from files, and several of them as one.

use crate::failure::{Failure, Result};
use crate::files;
use crate::options::Mapping;
use identify::{Map, ReadOptions, Recording, RecordingFault, audit};
use std::path::{Path, PathBuf};

/// Reads one recording.
///
/// # Errors
/// File, line, column, value and what would be accepted.
pub(crate) fn read(path: &Path, mapping: &Mapping) -> Result<Recording> {
    let text = mapping.map.as_deref().map(|map| with_time(path, map));
    let map = text.as_deref().map(str::parse::<Map>).transpose();
    let map = map.map_err(|e| Failure::new(format!("--map: {e}")))?;
    if path.is_dir() {
        return Err(Failure::in_file(path, "is a directory, not a recording"));
    }
    Recording::read(path, &ReadOptions { map }).map_err(|e| Failure::in_file(path, e))
}

/// The map, with `time_s=t` where it says nothing of time: the one name nearly every MATLAB file gives to it. A file
/// without a `t` is then refused by that name.
fn with_time(path: &Path, map: &str) -> String {
    let says =
        map.split(',').any(|entry| entry.split('=').next().is_some_and(|name| name.trim() == "time_s"));
    let matlab = path.extension().is_some_and(|e| e.eq_ignore_ascii_case("mat"));
    if says || !matlab || map.trim().is_empty() { map.to_owned() } else { format!("{map},time_s=t") }
}

/// Reads all of them.
///
/// # Errors
/// As [`read`], of the first that fails.
pub(crate) fn read_all(paths: &[PathBuf], mapping: &Mapping) -> Result<Vec<Recording>> {
    paths.iter().map(|path| read(path, mapping)).collect()
}

/// Writes a recording whole or not at all.
///
/// # Errors
/// Names the file and why it cannot be written.
pub(crate) fn write_csv(path: &Path, recording: &Recording) -> Result<()> {
    let text = recording.to_csv().map_err(|e| Failure::in_file(path, e))?;
    files::write(path, text.as_bytes())
}

/// Time between two recordings laid behind each other, sampling periods: more than any gap that is bridged.
const GAP: f64 = 1000.0;

/// Several recordings as one with gaps, so that one set of parameters is fitted to all; and the faults of each.
///
/// # Errors
/// Recordings of a slide and of an axis, or of different sampling periods.
pub(crate) fn joined(recordings: &[Recording]) -> Result<(Recording, Vec<RecordingFault>)> {
    let faults = recordings.iter().flat_map(|r| audit(r).faults).collect();
    let Some((first, rest)) = recordings.split_first() else {
        return Err(Failure::new("no recording: give at least one"));
    };
    let mut all = first.clone();
    let period = |r: &Recording| r.sample_period().unwrap_or(f64::NAN);
    for r in rest {
        if r.geometry != first.geometry {
            return Err(Failure::new(format!(
                "{}: linear and rotary recordings cannot be fitted together",
                r.name
            )));
        }
        if ((period(r) - period(first)) / period(first)).abs() > 1e-3 {
            let why = format!("is sampled every {} s, {} every {} s", period(r), first.name, period(first));
            return Err(Failure::new(format!("{}: {why}", r.name))
                .help("recordings of one rate are accepted together"));
        }
        let shift = all.time.last().copied().unwrap_or(0.0) + GAP * period(first)
            - r.time.first().copied().unwrap_or(0.0);
        all.name = format!("{}, {}", all.name, r.name);
        all.time.extend(r.time.iter().map(|t| t + shift));
        all.position.extend(&r.position);
        all.force.extend(&r.force);
        for (mine, theirs) in [
            (&mut all.velocity, &r.velocity),
            (&mut all.acceleration, &r.acceleration),
            (&mut all.normal_force, &r.normal_force),
            (&mut all.command, &r.command),
            (&mut all.reference, &r.reference),
            (&mut all.temperature, &r.temperature),
        ] {
            // a column only some of them have helps none
            match (mine.as_mut(), theirs) {
                (Some(mine), Some(theirs)) => mine.extend(theirs),
                _ => *mine = None,
            }
        }
    }
    Ok((all, faults))
}
