//! Recordings from and to MATLAB files of version 5 (also 6 and 7, which compress) [matlab-5].
//!
//! Read here rather than by a library: the one there is prints on standard output, stops silently at the first
//! element it does not understand, and unpacks without limit. Real numeric arrays are read; of everything else the
//! name and the kind are kept for messages.
//!
//! Written is a column of doubles per signal, named with its unit, so that reading back needs no map. MATLAB has no place for
//! metadata and no names such as `j1/position_rad`: both are in one more variable, `tribos_about`, as JSON text.

use super::limits;
use super::stored::Stored;
use super::variables::{Variable, Wanted, assemble};
use crate::{Error, Geometry, Recording};
use miniz_oxide::inflate::TINFLStatus;
use serde::{Deserialize, Serialize};
use std::borrow::Cow;
use std::collections::BTreeMap;

const INT8: u32 = 1;
const UINT16: u32 = 4;
const INT32: u32 = 5;
const UINT32: u32 = 6;
const DOUBLE: u32 = 9;
const MATRIX: u32 = 14;
const COMPRESSED: u32 = 15;
/// Array classes.
const CHAR_CLASS: u32 = 4;
const DOUBLE_CLASS: u32 = 6;

/// The variable that holds what MATLAB has no place for.
const ABOUT: &str = "tribos_about";
/// MATLAB's longest name.
const LONGEST_NAME: usize = 63;

/// What MATLAB has no place for.
#[derive(Serialize, Deserialize)]
struct About {
    /// Of the recording.
    metadata: BTreeMap<String, String>,
    /// Names of columns by those of their variables, where they differ.
    names: BTreeMap<String, String>,
}

pub(crate) fn read(file: &str, bytes: &[u8], wanted: &Wanted) -> Result<Recording, Error> {
    let fail = |why: String| Error::File { file: file.into(), why };
    let (mut variables, about) = variables(bytes).map_err(fail)?;
    let about: Option<About> = match about {
        Some(text) => {
            Some(serde_json::from_str(&text).map_err(|e| fail(format!("{ABOUT}: is not JSON: {e}")))?)
        }
        None => None,
    };
    for variable in &mut variables {
        if let Some(name) = about.as_ref().and_then(|about| about.names.get(&variable.name)) {
            variable.name.clone_from(name);
        }
    }
    let mut recording = assemble(file, variables, wanted)?;
    recording.metadata.extend(about.map(|about| about.metadata).unwrap_or_default());
    Ok(recording)
}

/// The bytes of a file.
pub(crate) fn write(file: &str, recording: &Recording) -> Result<Vec<u8>, Error> {
    if recording.len() > (i32::MAX as usize) / 8 - 64 {
        let why = "too long for a MATLAB v5 file; accepted are .csv, .mcap, .parquet and .h5".into();
        return Err(Error::File { file: file.into(), why });
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
    let mut about = About { metadata: recording.metadata.clone(), names: BTreeMap::new() };
    for (name, values) in recording.all_columns() {
        let variable =
            if is_matlab_name(name) { name.into() } else { format!("column_{}", about.names.len() + 1) };
        if variable != name {
            about.names.insert(variable.clone(), name.into());
        }
        let data: Vec<u8> = values.iter().flat_map(|v| v.to_le_bytes()).collect();
        matrix_out(&mut out, &variable, DOUBLE_CLASS, (values.len(), 1), DOUBLE, &data);
    }
    if !about.metadata.is_empty() || !about.names.is_empty() {
        let text = serde_json::to_string(&about)
            .map_err(|e| Error::File { file: file.into(), why: e.to_string() })?;
        let units: Vec<u16> = text.encode_utf16().collect();
        let data: Vec<u8> = units.iter().flat_map(|u| u.to_le_bytes()).collect();
        matrix_out(&mut out, ABOUT, CHAR_CLASS, (1, units.len()), UINT16, &data);
    }
    Ok(out)
}

fn is_matlab_name(name: &str) -> bool {
    name.starts_with(|c: char| c.is_ascii_alphabetic())
        && name.len() <= LONGEST_NAME
        && name.chars().all(|c| c.is_ascii_alphanumeric() || c == '_')
        && !name.starts_with("column_")
        && name != ABOUT
}

fn matrix_out(out: &mut Vec<u8>, name: &str, class: u32, size: (usize, usize), kind: u32, data: &[u8]) {
    let mut body = Vec::with_capacity(data.len() + 128);
    element_out(&mut body, UINT32, &[class.to_le_bytes(), [0; 4]].concat());
    element_out(&mut body, INT32, &[(size.0 as i32).to_le_bytes(), (size.1 as i32).to_le_bytes()].concat());
    element_out(&mut body, INT8, name.as_bytes());
    element_out(&mut body, kind, data);
    element_out(out, MATRIX, &body);
}

/// Tag, data, and zeros up to the next multiple of 8.
fn element_out(out: &mut Vec<u8>, kind: u32, data: &[u8]) {
    out.extend(kind.to_le_bytes());
    out.extend((data.len() as u32).to_le_bytes());
    out.extend(data);
    out.resize(out.len().next_multiple_of(8), 0);
}

/// The variables, and the text of [`ABOUT`].
fn variables(bytes: &[u8]) -> Result<(Vec<Variable>, Option<String>), String> {
    let big = match bytes.get(126..128) {
        Some(b"IM") => false,
        Some(b"MI") => true,
        _ => return Err("not a MATLAB file of version 5 to 7.3; save it with `save -v7`".into()),
    };
    let mut reader = Reader { bytes: &bytes[128..], big, offset: 128 };
    let mut out = Vec::new();
    let mut about = None;
    // what is unpacked in all stays within this, whatever a variable says of its size
    let mut left = limits::total(bytes.len());
    while !reader.bytes.is_empty() {
        let place = reader.offset;
        let at = |why: String| format!("byte {place}: {why}");
        let (kind, data) = reader.element(false).map_err(at)?;
        let inner: Cow<[u8]> = match kind {
            MATRIX => data.into(),
            COMPRESSED => {
                let unpacked = miniz_oxide::inflate::decompress_to_vec_zlib_with_limit(data, left)
                    .map_err(|e| at(cannot_unpack(e.status, left)))?;
                left -= unpacked.len();
                let mut one = Reader { bytes: &unpacked, big, offset: place };
                match one.element(false).map_err(at)? {
                    (MATRIX, data) => data.to_vec().into(),
                    _ => continue,
                }
            }
            _ => continue,
        };
        let mut one = Reader { bytes: &inner, big, offset: place };
        match matrix(&mut one).map_err(at)? {
            Array::Numbers(variable) => out.push(variable),
            Array::Text(name, text) if name == ABOUT => about = Some(text),
            Array::Text(name, text) => out.push(Variable::other(name, "char", vec![1, text.chars().count()])),
        }
    }
    Ok((out, about))
}

fn cannot_unpack(status: TINFLStatus, left: usize) -> String {
    match status {
        TINFLStatus::HasMoreOutput => limits::too_much("a variable", format!("more than {left}"), left),
        status => format!("a variable cannot be unpacked: {status:?}"),
    }
}

enum Array {
    Numbers(Variable),
    /// Name and characters.
    Text(String, String),
}

fn matrix(reader: &mut Reader) -> Result<Array, String> {
    let (_, flags) = reader.element(true)?;
    let word = flags.first_chunk::<4>().ok_or("a variable without class")?;
    let word = if reader.big { u32::from_be_bytes(*word) } else { u32::from_le_bytes(*word) };
    let kind = match word & 0xff {
        1 => "cell",
        2 => "struct",
        3 => "object",
        4 => "char",
        5 => "sparse",
        6 => "double",
        7 => "single",
        8..=15 => "integer",
        _ => "of an unknown class",
    };
    let (_, size) = reader.element(true)?;
    let size: Vec<usize> = size
        .chunks_exact(4)
        .map(|c| {
            let c = [c[0], c[1], c[2], c[3]];
            usize::try_from(if reader.big { i32::from_be_bytes(c) } else { i32::from_le_bytes(c) })
                .unwrap_or(0)
        })
        .collect();
    let (_, name) = reader.element(true)?;
    let name = String::from_utf8_lossy(name).trim_end_matches('\0').to_string();
    let complex = word & 0x0800 != 0;
    if word & 0xff == CHAR_CLASS
        && let Ok((UINT16, data)) = reader.element(true)
    {
        let unit = |c: &[u8]| {
            if reader.big { u16::from_be_bytes([c[0], c[1]]) } else { u16::from_le_bytes([c[0], c[1]]) }
        };
        let units: Vec<u16> = data.chunks_exact(2).map(unit).collect();
        return Ok(Array::Text(name, String::from_utf16_lossy(&units)));
    }
    if complex || !(6..=15).contains(&(word & 0xff)) {
        return Ok(Array::Numbers(Variable::other(name, if complex { "complex" } else { kind }, size)));
    }
    let (kind_of_data, data) = reader.element(true)?;
    let values = stored(kind_of_data)
        .ok_or_else(|| format!("`{name}` has numbers of unknown type {kind_of_data}"))?
        .read_all(data, reader.big);
    let expected = size.iter().try_fold(1usize, |n, d| n.checked_mul(*d));
    if expected != Some(values.len()) {
        return Err(format!("`{name}` is said to be {size:?} and has {} elements", values.len()));
    }
    Ok(Array::Numbers(Variable { name, kind, size, values: Some(values), ..Variable::default() }))
}

/// Type of the numbers of an element: MATLAB shrinks a double to the smallest integer type that holds it.
fn stored(kind: u32) -> Option<Stored> {
    Some(match kind {
        1 => Stored::I8,
        2 => Stored::U8,
        3 => Stored::I16,
        4 => Stored::U16,
        5 => Stored::I32,
        6 => Stored::U32,
        7 => Stored::F32,
        9 => Stored::F64,
        12 => Stored::I64,
        13 => Stored::U64,
        _ => return None,
    })
}

/// Elements one after the other.
struct Reader<'a> {
    bytes: &'a [u8],
    big: bool,
    /// Of `bytes`, in the file.
    offset: usize,
}

impl<'a> Reader<'a> {
    fn take(&mut self, n: usize) -> Result<&'a [u8], String> {
        let Some((taken, rest)) = self.bytes.split_at_checked(n) else {
            return Err(format!("the file ends {} bytes too early", n - self.bytes.len()));
        };
        self.bytes = rest;
        self.offset += n;
        Ok(taken)
    }

    fn word(&mut self) -> Result<u32, String> {
        let w = self.take(4)?;
        let w = [w[0], w[1], w[2], w[3]];
        Ok(if self.big { u32::from_be_bytes(w) } else { u32::from_le_bytes(w) })
    }

    /// Type and data of the next element. Parts of a variable are padded to eight bytes.
    fn element(&mut self, part: bool) -> Result<(u32, &'a [u8]), String> {
        let kind = self.word()?;
        if kind > 0xffff {
            let n = (kind >> 16) as usize;
            let data = self.take(4)?;
            let data = data.get(..n).ok_or_else(|| format!("a small element of {n} bytes"))?;
            return Ok((kind & 0xffff, data));
        }
        let n = self.word()? as usize;
        let data = self.take(n)?;
        if part || kind == MATRIX {
            let padding = (8 - n % 8) % 8;
            let there = padding.min(self.bytes.len());
            self.take(there)?;
        }
        Ok((kind, data))
    }
}
