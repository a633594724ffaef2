//! Files that are whole or not there: written beside their place and renamed into it.

use crate::failure::{Failure, Result};
use std::fs::{self, File};
use std::io::Write;
use std::path::{Path, PathBuf};

/// Where a file grows before it takes its name: `rec.csv` → `rec.csv.part`.
pub(crate) fn part(path: &Path) -> PathBuf {
    let mut name = path.file_name().unwrap_or_default().to_owned();
    name.push(".part");
    path.with_file_name(name)
}

/// Refuses a path that cannot be written, before any work is spent on what would go into it.
///
/// # Errors
/// Names the file and what is in the way.
pub(crate) fn check_writable(path: &Path) -> Result<()> {
    if path == Path::new("-") {
        return Ok(());
    }
    if path.is_dir() {
        return Err(Failure::in_file(path, "is a directory, not a file to write"));
    }
    let part = part(path);
    let existed = part.exists();
    match fs::OpenOptions::new().create(true).append(true).open(&part) {
        Ok(_) => {
            if !existed {
                let _ = fs::remove_file(&part);
            }
            Ok(())
        }
        Err(e) => Err(unwritable(path, &e)),
    }
}

/// "cannot be written", with the operating system's reason.
pub(crate) fn unwritable(path: &Path, error: &std::io::Error) -> Failure {
    Failure::in_file(path, format!("cannot be written: {}", reason(error)))
}

/// An I/O error without its number: `No such file or directory`.
pub(crate) fn reason(error: &std::io::Error) -> String {
    let text = error.to_string();
    match text.find(" (os error") {
        Some(at) => text[..at].to_owned(),
        None => text,
    }
}

/// Writes `contents` to `path` at once; `-` is standard output.
///
/// # Errors
/// Names the file and the operating system's reason; the old file, if any, is then still there.
pub(crate) fn write(path: &Path, contents: &[u8]) -> Result<()> {
    if path == Path::new("-") {
        let mut out = std::io::stdout().lock();
        return match out.write_all(contents).and_then(|()| out.flush()) {
            // A reader that has seen enough (`| head`) is no error of ours.
            Err(e) if e.kind() != std::io::ErrorKind::BrokenPipe => Err(unwritable(path, &e)),
            _ => Ok(()),
        };
    }
    through(path, |part| {
        let mut file = File::create(part)?;
        file.write_all(contents)?;
        file.sync_all()
    })
    .map_err(|e| unwritable(path, &e))
}

/// Writes `value` as indented JSON with a line end; `-` is standard output.
///
/// # Errors
/// Those of [`write`].
pub(crate) fn write_json(path: &Path, value: &impl serde::Serialize) -> Result<()> {
    let text = serde_json::to_string_pretty(value).map_err(Failure::new)?;
    write(path, format!("{text}\n").as_bytes())
}

/// Lets `make` write a file of another name in the same folder, then renames it to `path`.
///
/// # Errors
/// Those of `make` and of the renaming; the unfinished file is removed.
pub(crate) fn through<E: From<std::io::Error>>(
    path: &Path,
    make: impl FnOnce(&Path) -> std::result::Result<(), E>,
) -> std::result::Result<(), E> {
    let part = part(path);
    let made = make(&part).and_then(|()| fs::rename(&part, path).map_err(E::from));
    if made.is_err() {
        let _ = fs::remove_file(&part);
    }
    made
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_failed_write_leaves_the_old_file_and_no_litter() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.txt");
        write(&path, b"old").unwrap();
        let failed: std::io::Result<()> = through(&path, |p| {
            fs::write(p, b"half")?;
            Err(std::io::Error::other("power cut"))
        });
        assert!(failed.is_err());
        assert_eq!(fs::read(&path).unwrap(), b"old");
        assert_eq!(fs::read_dir(dir.path()).unwrap().count(), 1);
        assert!(check_writable(&path).is_ok());
        assert_eq!(fs::read_dir(dir.path()).unwrap().count(), 1);
        let nowhere = dir.path().join("no/such/dir/a.txt");
        let said = check_writable(&nowhere).unwrap_err();
        assert!(said.message().contains("cannot be written: No such file or directory"), "{said}");
    }
}
