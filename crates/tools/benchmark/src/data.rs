//! A benchmark's recording, ready to be run.

use crate::drive::{Between, Drive};
use crate::error::Error;
use signals::{Map, ReadOptions, Recording};
use std::ops::Range;
use std::path::{Path, PathBuf};

/// Force and position of a benchmark, without gaps.
#[derive(Debug, Clone, PartialEq)]
pub struct Record {
    /// File, as it was found.
    pub file: String,
    /// As it was read, on an even clock.
    pub recording: Recording,
    /// The force between its samples.
    pub drive: Drive,
    /// Measured position, m.
    pub position: Vec<f64>,
    /// Where a free run that goes astray is ended, m.
    pub bound: f64,
}

/// Free runs beyond this multiple of the largest measured position are astray.
const ASTRAY: f64 = 20.0;

impl Record {
    /// A record of a recording on an even clock.
    ///
    /// # Errors
    /// A sample that is not a number, or fewer than two.
    pub fn new(file: &str, mut recording: Recording, between: Between) -> Result<Self, Error> {
        let wrong = |why: String| Error::Wrong { file: file.to_owned(), why };
        recording.check_lengths()?;
        let samples = recording.len();
        let (first, last) = match recording.time.as_slice() {
            [first, .., last] if last > first => (*first, *last),
            _ => {
                return Err(wrong(format!(
                    "{samples} samples on a clock that does not advance; expected is an even clock"
                )));
            }
        };
        for (name, values) in recording.columns() {
            if let Some(at) = values.iter().position(|x| !x.is_finite()) {
                return Err(wrong(format!(
                    "sample {at} of {name} is {}; expected are finite numbers",
                    values[at]
                )));
            }
        }
        // stamps rounded to 1e-8 s would look like jitter
        let dt = (last - first) / (samples - 1) as f64;
        if let Some(at) = recording.time.windows(2).position(|w| !((w[1] - w[0] - dt).abs() < 0.01 * dt)) {
            return Err(wrong(format!(
                "the clock is uneven behind sample {at}; expected is a step of {dt:.6} s"
            )));
        }
        recording.time = (0..samples).map(|i| i as f64 * dt).collect();
        let reach = recording.position.iter().fold(0.0f64, |m, x| m.max(x.abs()));
        Ok(Self {
            file: file.to_owned(),
            drive: Drive::new(&recording.force, dt, between),
            position: recording.position.clone(),
            bound: ASTRAY * reach.max(f64::MIN_POSITIVE),
            recording,
        })
    }

    /// Number of samples.
    #[must_use]
    pub fn len(&self) -> usize {
        self.position.len()
    }

    /// No samples at all; [`Record::new`] never returns that.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.position.is_empty()
    }

    /// A part as a recording of its own.
    #[must_use]
    pub fn part(&self, range: &Range<usize>) -> Recording {
        Recording {
            name: format!("{} {}:{}", self.recording.name, range.start, range.end),
            geometry: self.recording.geometry,
            time: self.recording.time[range.clone()].to_vec(),
            position: self.position[range.clone()].to_vec(),
            force: self.recording.force[range.clone()].to_vec(),
            ..Recording::default()
        }
    }
}

/// Reads the first of `names` that is in `dir` or in one of its folders `inside`; None where there is none.
pub(crate) fn read(
    dir: &Path,
    inside: &[&str],
    names: &[&str],
    maps: &[&str],
    between: Between,
) -> Result<Option<Record>, Error> {
    let folders = std::iter::once(dir.to_path_buf()).chain(inside.iter().map(|f| dir.join(f)));
    let places: Vec<PathBuf> = folders.flat_map(|f| names.iter().map(move |n| f.join(n))).collect();
    let Some(path) = places.iter().find(|p| p.is_file()) else { return Ok(None) };
    let file = path.display().to_string();
    // a file has the variables of one of the maps
    let mut refused = None;
    for map in maps {
        let map: Map = map.parse()?;
        match Recording::read(path, &ReadOptions { map: Some(map), ..ReadOptions::default() }) {
            Ok(recording) => return Record::new(&file, recording, between).map(Some),
            Err(e) => refused = refused.or(Some(e)),
        }
    }
    let why = refused.map_or_else(String::new, |e| e.to_string());
    let why = why.strip_prefix(&format!("{file}: ")).map_or(why.clone(), str::to_owned);
    Err(Error::Wrong { file, why })
}
