//! Reads recordings named on the command line, with `--map` and `--joint`, and writes them.

use crate::failure::{Failure, Result};
use crate::files;
use crate::options::Mapping;
use procedures::{planar, recordings};
use signals::Recording;
use std::path::Path;

/// Reads one recording.
///
/// # Errors
/// As [`read_all`].
pub(crate) fn read(path: &Path, mapping: &Mapping) -> Result<Recording> {
    read_all(&[path], mapping).map(|mut all| all.remove(0))
}

/// Reads all recordings, each with the map that its file needs, and prints what reading did to the numbers.
///
/// # Errors
/// Those of [`recordings::read_all`].
pub(crate) fn read_all(paths: &[impl AsRef<Path>], mapping: &Mapping) -> Result<Vec<Recording>> {
    let read = recordings::read_all(paths, &mapping.maps, mapping.joint.as_deref())?;
    print_remarks(&read);
    Ok(read)
}

fn print_remarks(recordings: &[Recording]) {
    for recording in recordings {
        for remark in &recording.remarks {
            // standard output may be JSON
            eprintln!("{}: {remark}", recording.name);
        }
    }
}

/// Reads all recordings, on a line or in the plane.
///
/// # Errors
/// Those of [`planar::read_all`].
pub(crate) fn read_any(paths: &[impl AsRef<Path>], mapping: &Mapping) -> Result<planar::Recordings> {
    let read = planar::read_all(paths, &mapping.maps, mapping.joint.as_deref())?;
    if let planar::Recordings::Line(read) = &read {
        print_remarks(read);
    }
    Ok(read)
}

/// Writes a recording completely or not at all.
///
/// # Errors
/// The file and the reason.
pub(crate) fn write_csv(path: &Path, recording: &Recording) -> Result<()> {
    let text = recording.to_csv().map_err(|e| Failure::in_file(path, e))?;
    files::write(path, text.as_bytes())
}
