//! Recordings from files, each by the map it needs, and several as one.

use crate::error::{Error, Result};
use crate::watch::{Unwatched, Watch};
use signals::{Map, Preparation, ReadOptions, Recording, Settings};
use std::path::Path;

/// Time between two joined recordings, sampling periods: more than any bridged gap.
const GAP: f64 = 1000.0;

/// Reads all recordings, each with the map that its file needs: `SIGNAL=VARIABLE,…`; of files with several joints, `joint`.
///
/// # Errors
/// File, line, column, value and what would be accepted, for the first failure; a map that no file needs.
pub fn read_all(paths: &[impl AsRef<Path>], maps: &[String], joint: Option<&str>) -> Result<Vec<Recording>> {
    read_all_watched(paths, maps, joint, &Unwatched)
}

/// As [`read_all`]. Ends early, between two files, when `watch` is interrupted.
///
/// # Errors
/// As [`read_all`]; [`Error::Cancelled`].
pub fn read_all_watched(
    paths: &[impl AsRef<Path>],
    maps: &[String],
    joint: Option<&str>,
    watch: &dyn Watch,
) -> Result<Vec<Recording>> {
    let files: Vec<Content> = paths.iter().map(|path| Content::OnDisk(path.as_ref())).collect();
    read_each(&files, maps, joint, watch)
}

/// As [`read_all`], of files in memory: name and content.
///
/// # Errors
/// As [`read_all`].
pub fn read_bytes(
    files: &[(String, Vec<u8>)],
    maps: &[String],
    joint: Option<&str>,
) -> Result<Vec<Recording>> {
    let files: Vec<Content> = files.iter().map(|(name, bytes)| Content::InMemory(name, bytes)).collect();
    read_each(&files, maps, joint, &Unwatched)
}

/// Where a file is.
#[derive(Clone, Copy)]
enum Content<'a> {
    OnDisk(&'a Path),
    InMemory(&'a str, &'a [u8]),
}

impl<'a> Content<'a> {
    fn path(self) -> &'a Path {
        match self {
            Self::OnDisk(path) => path,
            Self::InMemory(name, _) => Path::new(name),
        }
    }

    /// Reads it with the map that it needs, of several.
    fn read<'m>(self, maps: &'m [Map], joint: Option<&str>) -> Result<(Recording, Option<&'m Map>)> {
        match self {
            Self::OnDisk(path) if path.is_dir() && !signals::is_bag(path) => {
                return Err(Error::in_file(path, &"is a directory, not a recording"));
            }
            Self::OnDisk(path) => Recording::read_with_maps(path, maps, joint),
            Self::InMemory(name, bytes) => Recording::from_bytes_with_maps(name, bytes, maps, joint),
        }
        .map_err(|e| Error::in_file(self.path(), &e))
    }

    /// Reads it with this map, needed or not.
    fn read_by(self, map: Map, joint: Option<&str>) -> Result<Recording> {
        let options = ReadOptions { map: Some(map), joint: joint.map(str::to_owned) };
        match self {
            Self::OnDisk(path) => Recording::read(path, &options),
            Self::InMemory(name, bytes) => Recording::from_bytes(name, bytes, &options),
        }
        .map_err(|e| Error::in_file(self.path(), &e))
    }
}

fn read_each(
    files: &[Content],
    maps: &[String],
    joint: Option<&str>,
    watch: &dyn Watch,
) -> Result<Vec<Recording>> {
    let mut used = vec![false; maps.len()];
    let mut recordings = Vec::with_capacity(files.len());
    for file in files {
        if watch.is_interrupted() {
            return Err(Error::Cancelled);
        }
        let parsed = maps_of(file.path(), maps)?;
        let (recording, map) = file.read(&parsed, joint)?;
        if let Some(index) = map.and_then(|map| parsed.iter().position(|m| m == map)) {
            used[index] = true;
        }
        recordings.push(recording);
    }
    if let (Some(index), Some(first)) = (used.iter().position(|used| !used), files.first()) {
        // a map with a slip is refused with what the file has
        first.read_by(maps_of(first.path(), maps)?.swap_remove(index), joint)?;
        return Err(Error::option("map", format!("no file needs `{}`", maps[index]))
            .with_help("the map of a file is the first whose variables it has"));
    }
    Ok(recordings)
}

/// The maps for a file.
fn maps_of(path: &Path, maps: &[String]) -> Result<Vec<Map>> {
    let parsed = |text: &String| with_time(path, text).parse::<Map>();
    let maps: std::result::Result<_, _> = maps.iter().map(parsed).collect();
    maps.map_err(|e: signals::Error| Error::option("map", e.to_string()))
}

/// The map, with `time_s=t` if it does not map the time: the usual name in MATLAB files. A file without `t` is refused with that
/// name.
fn with_time(path: &Path, map: &str) -> String {
    let says =
        map.split(',').any(|entry| entry.split('=').next().is_some_and(|name| name.trim() == "time_s"));
    let matlab = path.extension().is_some_and(|e| e.eq_ignore_ascii_case("mat"));
    if says || !matlab || map.trim().is_empty() { map.to_owned() } else { format!("{map},time_s=t") }
}

/// Joins recordings into one with gaps, for one set of parameters, with the preparation of each where there are several.
///
/// # Errors
/// Recordings of different geometry or sampling period.
pub fn joined(recordings: &[Recording]) -> Result<(Recording, Vec<Preparation>)> {
    let Some((first, rest)) = recordings.split_first() else {
        return Err(Error::input("no recording: give at least one"));
    };
    let mut all = first.clone();
    let period = |r: &Recording| r.sample_period().unwrap_or(f64::NAN);
    for r in rest {
        if r.geometry != first.geometry {
            return Err(Error::input(format!(
                "{}: linear and rotary recordings cannot be fitted together",
                r.name
            )));
        }
        if ((period(r) - period(first)) / period(first)).abs() > 1e-3 {
            let why = format!("is sampled every {} s, {} every {} s", period(r), first.name, period(first));
            return Err(Error::input(format!("{}: {why}", r.name))
                .with_help("recordings of one rate are accepted together"));
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
    let preparations = each.iter().map(prepared).collect::<std::result::Result<_, _>>()?;
    Ok((all, preparations))
}

/// Name of the model of these recordings: a preset's, from the first file's.
#[must_use]
pub fn model_name(recordings: &[Recording]) -> String {
    let name = recordings.first().map_or("", |r| r.name.as_str());
    let stem = Path::new(name).file_stem().map(|s| s.to_string_lossy().to_lowercase()).unwrap_or_default();
    let clean: String =
        stem.chars().map(|c| if c.is_ascii_alphanumeric() || c == '-' { c } else { '_' }).take(24).collect();
    if clean.is_empty() { "identified".into() } else { clean }
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
        let maps = |maps: &[&str]| maps.iter().map(|m| (*m).to_owned()).collect::<Vec<_>>();
        let map = "time_s=t,position_m=x,force_n=10*f";
        let both = read_all(&[&own, &foreign], &maps(&[map]), None).expect("both are read");
        assert_eq!((&both[0].force[..], &both[1].force[..]), (&[2.0, 3.0][..], &[20.0, 30.0][..]));
        let says = |paths: &[&PathBuf], given: &[&str]| {
            read_all(paths, &maps(given), None).expect_err("refused").to_string()
        };
        // a map that nothing needs is a slip, and is refused with what the file has
        assert!(says(&[&own], &[map]).contains("no variable `t`; it has time_s, position_m, force_n"));
        assert!(says(&[&foreign], &[map, map]).contains("no file needs"));
        // the same files in memory: the same numbers, the same words
        let content = |name: &str| {
            let bytes = std::fs::read(dir.path().join(name)).expect("read");
            vec![(dir.path().join(name).display().to_string(), bytes)]
        };
        let in_memory = read_bytes(&content("foreign.csv"), &maps(&[map]), None).expect("read");
        assert_eq!(in_memory[0].force, both[1].force);
        let refused = read_bytes(&content("own.csv"), &maps(&[map]), None).expect_err("refused");
        assert_eq!(refused.to_string(), says(&[&own], &[map]));
        assert!(
            says(&[&own, &foreign], &["time_s=t,position_m=y,force_n=f"])
                .contains("no variable `y`; it has t, x, f")
        );
    }
}
