//! Reads recordings from files, and joins several.

use crate::failure::{Failure, Result};
use crate::files;
use crate::options::Mapping;
use signals::{Map, Preparation, ReadOptions, Recording, Settings};
use std::path::Path;

/// Reads one recording.
///
/// # Errors
/// As [`read_all`].
pub(crate) fn read(path: &Path, mapping: &Mapping) -> Result<Recording> {
    read_all(&[path], mapping).map(|mut all| all.remove(0))
}

/// Reads all recordings, each with the map that its file needs.
///
/// # Errors
/// File, line, column, value and what would be accepted, for the first failure; a map that no file needs.
pub(crate) fn read_all(paths: &[impl AsRef<Path>], mapping: &Mapping) -> Result<Vec<Recording>> {
    let mut used = vec![false; mapping.maps.len()];
    let mut recordings = Vec::with_capacity(paths.len());
    for path in paths.iter().map(AsRef::as_ref) {
        let maps = maps_of(path, mapping)?;
        if path.is_dir() {
            return Err(Failure::in_file(path, "is a directory, not a recording"));
        }
        let (recording, map) =
            Recording::read_with_maps(path, &maps).map_err(|e| Failure::in_file(path, e))?;
        if let Some(index) = map.and_then(|map| maps.iter().position(|m| m == map)) {
            used[index] = true;
        }
        recordings.push(recording);
    }
    if let (Some(index), Some(first)) = (used.iter().position(|used| !used), paths.first()) {
        let (first, map) = (first.as_ref(), maps_of(first.as_ref(), mapping)?.swap_remove(index));
        // a map with a slip is refused with what the file has
        Recording::read(first, &ReadOptions { map: Some(map) }).map_err(|e| Failure::in_file(first, e))?;
        return Err(Failure::new(format!("--map: no file needs `{}`", mapping.maps[index]))
            .help("the map of a file is the first whose variables it has"));
    }
    Ok(recordings)
}

/// The maps for a file.
fn maps_of(path: &Path, mapping: &Mapping) -> Result<Vec<Map>> {
    let parsed = |text: &String| with_time(path, text).parse::<Map>();
    let maps: std::result::Result<_, _> = mapping.maps.iter().map(parsed).collect();
    maps.map_err(|e| Failure::new(format!("--map: {e}")))
}

/// The map, with `time_s=t` if it does not map the time: the usual name in MATLAB files. A file without `t` is refused with that
/// name.
fn with_time(path: &Path, map: &str) -> String {
    let says =
        map.split(',').any(|entry| entry.split('=').next().is_some_and(|name| name.trim() == "time_s"));
    let matlab = path.extension().is_some_and(|e| e.eq_ignore_ascii_case("mat"));
    if says || !matlab || map.trim().is_empty() { map.to_owned() } else { format!("{map},time_s=t") }
}

/// Writes a recording completely or not at all.
///
/// # Errors
/// The file and the reason.
pub(crate) fn write_csv(path: &Path, recording: &Recording) -> Result<()> {
    let text = recording.to_csv().map_err(|e| Failure::in_file(path, e))?;
    files::write(path, text.as_bytes())
}

/// Time between two joined recordings, sampling periods: more than any bridged gap.
const GAP: f64 = 1000.0;

/// Joins recordings into one with gaps, for one set of parameters, with the preparation of each where there are several.
///
/// # Errors
/// Recordings of different geometry or sampling period.
pub(crate) fn joined(recordings: &[Recording]) -> Result<(Recording, Vec<Preparation>)> {
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
            // a column that only some recordings have is not used
            match (mine.as_mut(), theirs) {
                (Some(mine), Some(theirs)) => mine.extend(theirs),
                _ => *mine = None,
            }
        }
        all.extra.retain(|name, _| r.extra.contains_key(name));
        for (name, mine) in &mut all.extra {
            mine.extend(&r.extra[name]);
        }
    }
    let prepared = |r: &Recording| signals::prepare(r, &Settings::default()).map(|p| p.report);
    let each: &[Recording] = if rest.is_empty() { &[] } else { recordings };
    let preparations =
        each.iter().map(prepared).collect::<std::result::Result<_, _>>().map_err(Failure::new)?;
    Ok((all, preparations))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::PathBuf;

    #[test]
    fn a_map_was_asked_of_files_that_need_none() {
        let dir = tempfile::tempdir().expect("a folder");
        let file = |name: &str, text: &str| {
            let path = dir.path().join(name);
            std::fs::write(&path, text).expect("written");
            path
        };
        let own = file("own.csv", "time_s,position_m,force_n\n0,1,2\n1,2,3\n");
        let foreign = file("foreign.csv", "t,x,f\n0,1,2\n1,2,3\n");
        let mapping = |maps: &[&str]| Mapping { maps: maps.iter().map(|m| (*m).to_owned()).collect() };
        let map = "time_s=t,position_m=x,force_n=10*f";
        let both = read_all(&[&own, &foreign], &mapping(&[map])).expect("both are read");
        assert_eq!((&both[0].force[..], &both[1].force[..]), (&[2.0, 3.0][..], &[20.0, 30.0][..]));
        let says = |paths: &[&PathBuf], maps: &[&str]| {
            read_all(paths, &mapping(maps)).expect_err("refused").to_string()
        };
        // a map that nothing needs is a slip, and is refused with what the file has
        assert!(says(&[&own], &[map]).contains("no variable `t`; it has time_s, position_m, force_n"));
        assert!(says(&[&foreign], &[map, map]).contains("no file needs"));
        assert!(
            says(&[&own, &foreign], &["time_s=t,position_m=y,force_n=f"])
                .contains("no variable `y`; it has t, x, f")
        );
    }
}
