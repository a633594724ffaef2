//! MATLAB v5 writer: one column of doubles per signal, named with its unit, so that reading back needs no map.
//!
//! Layout [matlab-5]: a 128-byte header, then one `miMATRIX` element per variable.

use crate::columns::columns;
use crate::failure::{Failure, Result};
use crate::files;
use signals::{Geometry, Recording};
use std::path::Path;

const INT8: u32 = 1;
const INT32: u32 = 5;
const UINT32: u32 = 6;
const DOUBLE: u32 = 9;
const MATRIX: u32 = 14;
/// Array class of doubles.
const DOUBLE_CLASS: u32 = 6;

/// Writes `recording` to `path`.
///
/// # Errors
/// The file, if it cannot be written or exceeds the format (2 GB per variable).
pub(crate) fn write(path: &Path, recording: &Recording) -> Result<()> {
    if recording.len() > (i32::MAX as usize) / 8 - 64 {
        return Err(
            Failure::in_file(path, "too long for a MATLAB v5 file").help("accepted are .csv and .mcap")
        );
    }
    let about = format!(
        "MATLAB 5.0 MAT-file, written by tribos {}, {}, SI units",
        env!("CARGO_PKG_VERSION"),
        if recording.geometry == Geometry::Rotary { "rotary" } else { "linear" }
    );
    let mut out = vec![b' '; 116];
    for (to, from) in out.iter_mut().zip(about.bytes()) {
        *to = from;
    }
    out.extend([0; 8]);
    out.extend([0x00, 0x01, b'I', b'M']);
    variable(&mut out, "time_s", &recording.time);
    for column in columns(recording) {
        variable(&mut out, column.name, column.values);
    }
    files::write(path, &out)
}

fn variable(out: &mut Vec<u8>, name: &str, values: &[f64]) {
    let mut body = Vec::with_capacity(8 * values.len() + 64);
    element(&mut body, UINT32, &[DOUBLE_CLASS.to_le_bytes(), [0; 4]].concat());
    element(&mut body, INT32, &[(values.len() as i32).to_le_bytes(), 1_i32.to_le_bytes()].concat());
    element(&mut body, INT8, name.as_bytes());
    element(&mut body, DOUBLE, &values.iter().flat_map(|v| v.to_le_bytes()).collect::<Vec<u8>>());
    element(out, MATRIX, &body);
}

/// Tag, data, and zeros up to the next multiple of 8.
fn element(out: &mut Vec<u8>, kind: u32, data: &[u8]) {
    out.extend(kind.to_le_bytes());
    out.extend((data.len() as u32).to_le_bytes());
    out.extend(data);
    out.resize(out.len().next_multiple_of(8), 0);
}

#[cfg(test)]
mod tests {
    use super::*;
    use signals::ReadOptions;

    #[test]
    fn what_is_written_comes_back_bit_for_bit_without_a_map() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.mat");
        for n in [1_usize, 2, 1001] {
            let column = |f: f64| (0..n).map(|k| f * k as f64).collect::<Vec<f64>>();
            let recording = Recording {
                time: column(1e-3),
                position: column(0.1),
                force: column(-1.0 / 3.0),
                velocity: Some(column(100.0)),
                ..Recording::default()
            };
            write(&path, &recording).unwrap();
            let back = Recording::read(&path, &ReadOptions::default()).unwrap();
            println!("{n} samples: {} bytes", std::fs::metadata(&path).unwrap().len());
            assert_eq!(back.time, recording.time);
            assert_eq!(back.position, recording.position);
            assert_eq!(back.force, recording.force);
            assert_eq!(back.velocity, recording.velocity);
            assert_eq!(back.acceleration, None);
        }
    }
}
