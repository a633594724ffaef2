//! Files that are complete or absent: written under a temporary name, then renamed.

use std::fs::{self, File};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// A file that cannot be written.
#[derive(Debug, thiserror::Error)]
#[error("{}: {what}", path.display())]
pub struct FileError {
    path: PathBuf,
    what: String,
}

impl FileError {
    /// "cannot be written", with the operating system's reason.
    #[must_use]
    pub fn unwritable(path: &Path, error: &io::Error) -> Self {
        Self { path: path.to_owned(), what: format!("cannot be written: {}", reason(error)) }
    }
}

/// An I/O error without its number: `No such file or directory`.
#[must_use]
pub fn reason(error: &io::Error) -> String {
    let text = error.to_string();
    match text.find(" (os error") {
        Some(at) => text[..at].to_owned(),
        None => text,
    }
}

/// Where a file grows before it takes its name: `rec.csv` → `rec.csv.part`.
#[must_use]
pub fn part(path: &Path) -> PathBuf {
    let mut name = path.file_name().unwrap_or_default().to_owned();
    name.push(".part");
    path.with_file_name(name)
}

/// Refuses a path that cannot be written, before any work is spent on its contents.
///
/// # Errors
/// Names the file and what is in the way.
pub fn check_writable(path: &Path) -> Result<(), FileError> {
    if path.is_dir() {
        let what = "is a directory, not a file to write".to_owned();
        return Err(FileError { path: path.to_owned(), what });
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
        Err(e) => Err(FileError::unwritable(path, &e)),
    }
}

/// Writes `contents` to `path` at once.
///
/// # Errors
/// Names the file and the operating system's reason; the old file, if any, is then still there.
pub fn write(path: &Path, contents: &[u8]) -> Result<(), FileError> {
    through(path, |part| {
        let mut file = File::create(part)?;
        file.write_all(contents)?;
        file.sync_all()
    })
    .map_err(|e| FileError::unwritable(path, &e))
}

/// Lets `make` write a file of another name in the same folder, then renames it to `path`.
///
/// # Errors
/// Those of `make` and of the renaming; the unfinished file is removed.
pub fn through<E: From<io::Error>>(path: &Path, make: impl FnOnce(&Path) -> Result<(), E>) -> Result<(), E> {
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
    fn failed_write_keeps_the_old_file() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.txt");
        write(&path, b"old").unwrap();
        let failed: io::Result<()> = through(&path, |p| {
            fs::write(p, b"half")?;
            Err(io::Error::other("power cut"))
        });
        assert!(failed.is_err());
        assert_eq!(fs::read(&path).unwrap(), b"old");
        assert_eq!(fs::read_dir(dir.path()).unwrap().count(), 1);
        assert!(check_writable(&path).is_ok());
        assert_eq!(fs::read_dir(dir.path()).unwrap().count(), 1);
        let nowhere = dir.path().join("no/such/dir/a.txt");
        let said = check_writable(&nowhere).unwrap_err().to_string();
        assert!(said.contains("cannot be written: No such file or directory"), "{said}");
    }
}
