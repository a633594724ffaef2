//! Files of recordings.

use crate::one_line::is_one_line;
use signals::{Error, ReadOptions, Recording};
use std::cell::RefCell;
use std::path::PathBuf;
use tempfile::TempDir;

/// Without options, with a joint, and with a joint and a map: what the seeds need.
fn options() -> [ReadOptions; 3] {
    let map = "time_s=t,position_rad=q,torque_nm=tau".parse().ok();
    [
        ReadOptions::default(),
        ReadOptions { map: None, joint: Some("slider".into()) },
        ReadOptions { map, joint: Some("1".into()) },
    ]
}

fn judge(name: &str, read: Result<Recording, Error>) {
    match read {
        Ok(recording) => {
            assert!(recording.check_lengths().is_ok(), "columns of unequal length");
        }
        Err(error) => {
            let said = error.to_string();
            is_one_line(&said);
            assert!(said.contains(name) || said.starts_with("map, column "), "no place: {said:?}");
        }
    }
}

fn in_memory(name: &str, bytes: &[u8]) {
    for options in options() {
        judge(name, Recording::from_bytes(name, bytes, &options));
    }
}

thread_local! {
    static FOLDER: RefCell<Option<TempDir>> = const { RefCell::new(None) };
}

/// A path of this name in a folder of the thread.
fn path(name: &str) -> PathBuf {
    FOLDER.with_borrow_mut(|folder| {
        let folder = folder.get_or_insert_with(|| TempDir::new().expect("a folder for temporary files"));
        folder.path().join(name)
    })
}

fn on_disk(name: &str, bytes: &[u8]) {
    let path = path(name);
    std::fs::write(&path, bytes).expect("a temporary file");
    for options in options() {
        judge(name, Recording::read(&path, &options));
    }
}

/// Text.
pub(crate) fn csv(bytes: &[u8]) {
    in_memory("rec.csv", bytes);
}

/// JSON.
pub(crate) fn json(bytes: &[u8]) {
    in_memory("rec.json", bytes);
}

/// MATLAB 5 to 7.
pub(crate) fn mat5(bytes: &[u8]) {
    in_memory("rec.mat", bytes);
}

/// HDF5 and MATLAB 7.3.
pub(crate) fn hdf5(bytes: &[u8]) {
    in_memory("rec.h5", bytes);
}

/// Parquet.
pub(crate) fn parquet(bytes: &[u8]) {
    in_memory("rec.parquet", bytes);
}

/// MCAP.
pub(crate) fn mcap(bytes: &[u8]) {
    on_disk("rec.mcap", bytes);
}

/// A bag's file.
pub(crate) fn bag(bytes: &[u8]) {
    on_disk("rec.db3", bytes);
}
