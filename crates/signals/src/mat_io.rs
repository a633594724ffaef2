//! Recordings from MATLAB files of version 5 (also 6 and 7, which compress).
//!
//! Read here rather than by a library: the one there is prints on standard output, stops silently at the first
//! element it does not understand, and unpacks without limit. Real numeric arrays are read; of everything else the
//! name and the kind are kept for messages.

use crate::columns;
use crate::error::Place;
use crate::{Error, Map, Recording};
use std::borrow::Cow;

/// Largest variable that is unpacked, bytes.
const LARGEST: usize = 512 << 20;

const MATRIX: u32 = 14;
const COMPRESSED: u32 = 15;

pub(crate) fn read<'m>(
    file: &str,
    bytes: &[u8],
    map: impl Fn(&dyn Fn(&str) -> bool) -> Option<&'m Map>,
) -> Result<Recording, Error> {
    let variables = variables(bytes).map_err(|why| Error::File { file: file.into(), why })?;
    assemble(file, &variables, map)
}

/// The recording of columns in memory, by a map or by their own names.
pub(crate) fn of_columns(
    name: &str,
    columns: Vec<(String, Vec<f64>)>,
    maps: &[Map],
) -> Result<Recording, Error> {
    let variable = |(name, values): (String, Vec<f64>)| Variable {
        name,
        kind: "column",
        size: vec![i32::try_from(values.len()).unwrap_or(i32::MAX)],
        values: Some(values),
    };
    let variables: Vec<Variable> = columns.into_iter().map(variable).collect();
    let mut mapped = false;
    let mut recording = assemble(name, &variables, |has| {
        let map = Map::needed(maps, has);
        mapped = map.is_some();
        map
    })?;
    if !mapped {
        for Variable { name: column, values, .. } in variables {
            if columns::find(&column).is_some() {
                continue;
            }
            if !columns::meant(&column).is_empty() {
                return Err(Error::Input {
                    file: name.into(),
                    place: Place::default(),
                    value: column.clone(),
                    accepted: format!("is an unknown column; {}", columns::advice(&column)),
                });
            }
            recording.extra.insert(column, values.unwrap_or_default());
        }
        recording.check_lengths()?;
    }
    Ok(recording)
}

/// The recording that the variables of a file make, by a map or by their own names.
pub(crate) fn assemble<'m>(
    file: &str,
    variables: &[Variable],
    map: impl FnOnce(&dyn Fn(&str) -> bool) -> Option<&'m Map>,
) -> Result<Recording, Error> {
    let has = variables.iter().map(Variable::says).collect::<Vec<_>>().join(", ");
    let Some(map) = map(&|name| variables.iter().any(|v| v.name == name && v.values.is_some())) else {
        return named(file, variables, &has);
    };
    let lookup = |name: &str| variables.iter().find(|v| v.name == name)?.values.as_deref();
    let made = map.apply(lookup, &has)?;
    columns::assemble(made).map_err(|missing| Error::Map {
        map: map.text().into(),
        column: 1,
        why: format!("no {missing}; a recording needs time, position and force; the file has {has}"),
    })
}

/// Without a map, variables may have the names of columns.
fn named(file: &str, variables: &[Variable], has: &str) -> Result<Recording, Error> {
    let fail = |why: String| Error::Input {
        file: file.into(),
        place: Place::default(),
        value: String::new(),
        accepted: format!(
            "{why}; the file has {has}; say what they are with a map such as time_s=t,position_m=x,force_n=k*u"
        ),
    };
    let mut found: Vec<(&'static columns::Named, Vec<f64>)> = Vec::new();
    for variable in variables {
        let (Some(column), Some(values)) = (columns::find(&variable.name), &variable.values) else {
            continue;
        };
        if let Some((other, _)) =
            found.iter().find(|(o, _)| o.slot == column.slot || columns::contradict(o, column))
        {
            return Err(fail(format!("{} beside {}", column.name, other.name)));
        }
        found.push((column, values.clone()));
    }
    let recording = columns::assemble(found).map_err(|missing| fail(format!("no variable {missing}")))?;
    match recording.check_lengths() {
        Err(Error::Recording { why, .. }) => Err(fail(why)),
        _ if recording.is_empty() => Err(fail("no samples".into())),
        _ => Ok(recording),
    }
}

/// A variable of the file.
pub(crate) struct Variable {
    pub name: String,
    /// `double`, `struct`, …
    pub kind: &'static str,
    pub size: Vec<i32>,
    /// Elements in the file's order, if it is a real numeric array.
    pub values: Option<Vec<f64>>,
}

impl Variable {
    fn says(&self) -> String {
        let size = self.size.iter().map(i32::to_string).collect::<Vec<_>>().join("x");
        format!("{} ({size} {})", self.name, self.kind)
    }
}

fn variables(bytes: &[u8]) -> Result<Vec<Variable>, String> {
    let big = match bytes.get(126..128) {
        _ if bytes.starts_with(b"\x89HDF") || bytes.starts_with(b"MATLAB 7.3") => {
            return Err("MATLAB 7.3 (HDF5) is not read; save it with `save -v7`".into());
        }
        Some(b"IM") => false,
        Some(b"MI") => true,
        _ => return Err("not a MATLAB file of version 5 to 7; save it with `save -v7`".into()),
    };
    let mut reader = Reader { bytes: &bytes[128..], big, offset: 128 };
    let mut out = Vec::new();
    while !reader.bytes.is_empty() {
        let place = reader.offset;
        let at = |why: String| format!("byte {place}: {why}");
        let (kind, data) = reader.element(false).map_err(at)?;
        let inner: Cow<[u8]> = match kind {
            MATRIX => data.into(),
            COMPRESSED => {
                let unpacked = miniz_oxide::inflate::decompress_to_vec_zlib_with_limit(data, LARGEST)
                    .map_err(|e| at(format!("a variable cannot be unpacked: {e}")))?;
                let mut one = Reader { bytes: &unpacked, big, offset: place };
                match one.element(false).map_err(at)? {
                    (MATRIX, data) => data.to_vec().into(),
                    _ => continue,
                }
            }
            _ => continue,
        };
        let mut one = Reader { bytes: &inner, big, offset: place };
        out.push(matrix(&mut one).map_err(at)?);
    }
    Ok(out)
}

fn matrix(reader: &mut Reader) -> Result<Variable, String> {
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
    let size: Vec<i32> = size
        .chunks_exact(4)
        .map(|c| {
            let c = [c[0], c[1], c[2], c[3]];
            if reader.big { i32::from_be_bytes(c) } else { i32::from_le_bytes(c) }
        })
        .collect();
    let (_, name) = reader.element(true)?;
    let name = String::from_utf8_lossy(name).trim_end_matches('\0').to_string();
    let complex = word & 0x0800 != 0;
    if complex || !(6..=15).contains(&(word & 0xff)) {
        return Ok(Variable { name, kind: if complex { "complex" } else { kind }, size, values: None });
    }
    let (stored, data) = reader.element(true)?;
    let values = numbers(stored, data, reader.big)
        .ok_or_else(|| format!("`{name}` has numbers of unknown type {stored}"))?;
    let expected = size.iter().try_fold(1usize, |n, d| n.checked_mul(usize::try_from(*d).ok()?));
    if expected != Some(values.len()) {
        return Err(format!("`{name}` is said to be {size:?} and has {} elements", values.len()));
    }
    Ok(Variable { name, kind, size, values: Some(values) })
}

/// The numbers as they are stored: MATLAB shrinks a double to the smallest integer type that holds it.
fn numbers(kind: u32, data: &[u8], big: bool) -> Option<Vec<f64>> {
    fn all<const N: usize>(data: &[u8], big: bool, make: impl Fn([u8; N]) -> f64) -> Vec<f64> {
        data.chunks_exact(N)
            .filter_map(|c| c.first_chunk::<N>())
            .map(|c| {
                let mut little = *c;
                if big {
                    little.reverse();
                }
                make(little)
            })
            .collect()
    }
    Some(match kind {
        1 => all(data, big, |c: [u8; 1]| f64::from(c[0] as i8)),
        2 => all(data, big, |c: [u8; 1]| f64::from(c[0])),
        3 => all(data, big, |c| f64::from(i16::from_le_bytes(c))),
        4 => all(data, big, |c| f64::from(u16::from_le_bytes(c))),
        5 => all(data, big, |c| f64::from(i32::from_le_bytes(c))),
        6 => all(data, big, |c| f64::from(u32::from_le_bytes(c))),
        7 => all(data, big, |c| f64::from(f32::from_le_bytes(c))),
        9 => all(data, big, f64::from_le_bytes),
        12 => all(data, big, |c| i64::from_le_bytes(c) as f64),
        13 => all(data, big, |c| u64::from_le_bytes(c) as f64),
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
