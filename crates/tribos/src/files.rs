//! Output to files, complete or absent, or to standard output.

use crate::failure::{Failure, Result};
use signals::files::{self, FileError};
use std::io::Write;
use std::path::Path;

pub(crate) use signals::files::reason;

/// Checks that a path can be written, before any work.
///
/// # Errors
/// The file and the reason.
pub(crate) fn check_writable(path: &Path) -> Result<()> {
    if path == Path::new("-") {
        return Ok(());
    }
    Ok(files::check_writable(path)?)
}

/// "cannot be written", with the operating system's reason.
pub(crate) fn unwritable(path: &Path, error: &std::io::Error) -> Failure {
    FileError::unwritable(path, error).into()
}

/// Writes `contents` to `path` at once; `-` is standard output.
///
/// # Errors
/// The file and the reason of the operating system. An old file remains.
pub(crate) fn write(path: &Path, contents: &[u8]) -> Result<()> {
    if path == Path::new("-") {
        let mut out = std::io::stdout().lock();
        return match out.write_all(contents).and_then(|()| out.flush()) {
            // a reader that ends early (`| head`) is no error
            Err(e) if e.kind() != std::io::ErrorKind::BrokenPipe => Err(unwritable(path, &e)),
            _ => Ok(()),
        };
    }
    Ok(files::write(path, contents)?)
}

/// Writes `value` as indented JSON with a line end; `-` is standard output.
///
/// # Errors
/// Those of [`write`].
pub(crate) fn write_json(path: &Path, value: &impl serde::Serialize) -> Result<()> {
    let text = serde_json::to_string_pretty(value).map_err(Failure::new)?;
    write(path, format!("{text}\n").as_bytes())
}
