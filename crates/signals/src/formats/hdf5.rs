//! Recordings from and to HDF5, and from MATLAB 7.3, which is HDF5 behind 512 bytes of text.
//!
//! A variable is a dataset of numbers; its name is its path (`j1/position_rad`), in MATLAB's files with points (`rig.qd`). A
//! two-dimensional dataset is one column a joint, `q[1]`, `q[2]`, …; a compound dataset is a column a field, `table.q`. The
//! attribute `units` or `unit` of a dataset is its unit. Attributes of the root are metadata.

use super::stored::Stored;
use super::variables::{Variable, Wanted, assemble};
use super::{columns, limits};
use crate::{Error, Recording};
use hdf5_pure::{AttrValue, DType, Dataset, Datatype, DatatypeByteOrder, File, FileBuilder, Group};

/// Groups within each other.
const DEEPEST: usize = 16;
/// Most datasets that are looked at.
const MOST: usize = 4096;
/// Attribute with the name of a column, where HDF5 cannot have it as a dataset's.
const NAME: &str = "name";

pub(crate) fn read(file: &str, bytes: Vec<u8>, wanted: &Wanted) -> Result<Recording, Error> {
    let matlab = bytes.starts_with(b"MATLAB");
    let size = bytes.len();
    let fail = |why: String| Error::File { file: file.into(), why };
    let opened = File::from_bytes(bytes).map_err(|e| fail(format!("HDF5 that cannot be read: {e}")))?;
    let root = opened.root();
    let mut found = Found { matlab, variables: Vec::new(), left: limits::total(size), size };
    found.group(&root, "", 0).map_err(fail)?;
    let mut recording = assemble(file, found.variables, wanted)?;
    let attributes = root.attrs().map_err(|e| fail(format!("attributes: {e}")))?;
    recording
        .metadata
        .extend(attributes.iter().filter_map(|(name, value)| Some((name.clone(), text(value)?))));
    Ok(recording)
}

/// Variables that were found in a file so far, and the memory that is left for more.
struct Found {
    matlab: bool,
    variables: Vec<Variable>,
    /// Bytes that may still be unpacked.
    left: usize,
    /// Of the file, bytes.
    size: usize,
}

impl Found {
    fn group(&mut self, group: &Group, path: &str, depth: usize) -> Result<(), String> {
        let at = |e: hdf5_pure::Error| format!("group `/{path}`: {e}");
        for name in group.datasets().map_err(at)? {
            if self.variables.len() >= MOST {
                return Err(format!("more than {MOST} datasets"));
            }
            let full = self.join(path, &name);
            let named = |e: hdf5_pure::Error| format!("dataset `{full}`: {e}");
            let dataset = group.dataset(&name).map_err(named)?;
            self.dataset(&full, &dataset).map_err(|why| format!("dataset `{full}`: {why}"))?;
        }
        for name in group.groups().map_err(at)? {
            // where MATLAB keeps what cells refer to
            if self.matlab && name.starts_with('#') {
                continue;
            }
            let full = self.join(path, &name);
            if depth >= DEEPEST {
                return Err(format!("group `{full}`: deeper than {DEEPEST} groups"));
            }
            let inner = group.group(&name).map_err(|e| format!("group `{full}`: {e}"))?;
            self.group(&inner, &full, depth + 1)?;
        }
        Ok(())
    }

    fn join(&self, path: &str, name: &str) -> String {
        let between = if self.matlab { "." } else { "/" };
        if path.is_empty() { name.to_owned() } else { format!("{path}{between}{name}") }
    }

    fn dataset(&mut self, path: &str, dataset: &Dataset) -> Result<(), String> {
        let words = |e: hdf5_pure::Error| e.to_string();
        let attributes = dataset.attrs().map_err(words)?;
        let attribute = |name: &str| attributes.get(name).and_then(AttrValue::as_str).map(str::to_owned);
        let name = attribute(NAME).filter(|_| path.starts_with("column_")).unwrap_or_else(|| path.to_owned());
        let unit = attribute("units").or_else(|| attribute("unit"));
        let mut shape = Vec::new();
        for n in dataset.shape().map_err(words)? {
            shape.push(usize::try_from(n).map_err(|e| e.to_string())?);
        }
        let samples = shape.iter().try_fold(1usize, |n, d| n.checked_mul(*d));
        let class = attribute("MATLAB_class");
        let kind = match dataset.dtype().map_err(words)? {
            DType::F64 => "double",
            DType::F32 => "single",
            DType::String | DType::VariableLengthString => "text",
            DType::Compound(_) => "compound",
            DType::Enum(_) => "enumeration",
            DType::I8 | DType::I16 | DType::I32 | DType::I64 => "integer",
            DType::U8 | DType::U16 | DType::U32 | DType::U64 => "integer",
            _ => "of another type",
        };
        let char = self.matlab && class.as_deref().is_some_and(|c| matches!(c, "char" | "cell" | "struct"));
        let empty = attributes.contains_key("MATLAB_empty");
        if kind == "compound" && shape.len() == 1 {
            return self.compound(&name, dataset, shape[0]);
        }
        // MATLAB's sizes run the other way round
        let size: Vec<usize> =
            if self.matlab { shape.iter().rev().copied().collect() } else { shape.clone() };
        if char
            || empty
            || shape.len() > 2
            || !matches!(kind, "double" | "single" | "integer" | "enumeration")
        {
            self.variables.push(Variable::other(name, if char { "char" } else { kind }, size));
            return Ok(());
        }
        let width = usize::try_from(dataset.element_size().map_err(words)?).map_err(|e| e.to_string())?;
        self.take(dataset, samples, width, 8)?;
        let values = dataset.read_f64().map_err(words)?;
        if Some(values.len()) != samples {
            return Err(format!("is said to be {shape:?} and has {} elements", values.len()));
        }
        self.variables.push(Variable {
            name,
            kind,
            size,
            last_fastest: !self.matlab,
            values: Some(values),
            unit,
        });
        Ok(())
    }

    /// Checks what a dataset is said to take, before it is read: `samples` of `width` bytes, and of `memory` once read.
    fn take(
        &mut self,
        dataset: &Dataset,
        samples: Option<usize>,
        width: usize,
        memory: usize,
    ) -> Result<(), String> {
        let bytes = |width: usize| samples.and_then(|n| n.checked_mul(width)).unwrap_or(usize::MAX);
        if let Some(chunk) = dataset.chunk_shape().map_err(|e| e.to_string())? {
            let elements = chunk.iter().try_fold(width as u64, |n, d| n.checked_mul(*d)).unwrap_or(u64::MAX);
            let most = limits::stated(self.size);
            if elements > most as u64 {
                return Err(limits::too_much("a chunk", elements, most));
            }
            let chunks = dataset.chunks().map_err(|e| e.to_string())?.len() as u64;
            if chunks.saturating_mul(elements) < bytes(width) as u64 {
                return Err(format!(
                    "{chunks} chunks of {elements} bytes do not hold the {} bytes it has",
                    bytes(width)
                ));
            }
        } else if bytes(width) > self.size {
            return Err(format!("is said to take {} bytes, the file has {}", bytes(width), self.size));
        }
        let most = limits::total(self.size);
        self.left = self
            .left
            .checked_sub(bytes(memory))
            .ok_or_else(|| limits::too_much("it", bytes(memory), most))?;
        Ok(())
    }

    /// The numbers of a table of records, as PyTables and structured arrays of NumPy write it.
    fn compound(&mut self, name: &str, dataset: &Dataset, rows: usize) -> Result<(), String> {
        let words = |e: hdf5_pure::Error| e.to_string();
        let Datatype::Compound { members, size } = dataset.datatype().map_err(words)? else {
            return Ok(());
        };
        let width = usize::try_from(size).map_err(|e| e.to_string())?;
        self.take(dataset, Some(rows), width, width.saturating_mul(2))?;
        let raw = dataset.read_raw().map_err(words)?;
        for member in members {
            let Some((number, big)) = stored(&member.datatype) else {
                self.variables.push(Variable::other(
                    format!("{name}.{}", member.name),
                    "of another type",
                    vec![rows],
                ));
                continue;
            };
            let at = usize::try_from(member.byte_offset).map_err(|e| e.to_string())?;
            let values: Option<Vec<f64>> =
                raw.chunks_exact(width.max(1)).map(|record| number.read(record.get(at..)?, big)).collect();
            let values =
                values.ok_or_else(|| format!("its field {} lies outside of a record", member.name))?;
            self.variables.push(Variable::column(format!("{name}.{}", member.name), "field", values));
        }
        Ok(())
    }
}

/// Type of plain numbers, and whether its bytes are big-endian; `None` for any other type.
fn stored(datatype: &Datatype) -> Option<(Stored, bool)> {
    let big = |order: &DatatypeByteOrder| *order == DatatypeByteOrder::BigEndian;
    match datatype {
        Datatype::FloatingPoint { size: 8, byte_order, .. } => Some((Stored::F64, big(byte_order))),
        Datatype::FloatingPoint { size: 4, byte_order, .. } => Some((Stored::F32, big(byte_order))),
        Datatype::FixedPoint { size, byte_order, layout } => {
            Some((Stored::integer(*size, layout.signed)?, big(byte_order)))
        }
        Datatype::Enumeration { base_type, .. } => stored(base_type),
        _ => None,
    }
}

/// An attribute as metadata: texts and single numbers.
fn text(value: &AttrValue) -> Option<String> {
    if let Some(text) = value.as_str() {
        return Some(text.to_owned());
    }
    Some(match value {
        AttrValue::F64(x) => x.to_string(),
        AttrValue::F32(x) => x.to_string(),
        AttrValue::I8(x) => x.to_string(),
        AttrValue::I16(x) => x.to_string(),
        AttrValue::I32(x) => x.to_string(),
        AttrValue::I64(x) => x.to_string(),
        AttrValue::U8(x) => x.to_string(),
        AttrValue::U16(x) => x.to_string(),
        AttrValue::U32(x) => x.to_string(),
        AttrValue::U64(x) => x.to_string(),
        _ => return None,
    })
}

/// The bytes of a file: one dataset a column, metadata as attributes of the root.
pub(crate) fn write(file: &str, recording: &Recording) -> Result<Vec<u8>, Error> {
    let mut out = FileBuilder::new();
    for (k, (name, values)) in recording.all_columns().into_iter().enumerate() {
        let plain =
            !name.starts_with("column_") && !name.contains(['/', '\0']) && !matches!(name, "" | "." | "..");
        let path = if plain { name.to_owned() } else { format!("column_{k}") };
        let dataset = out.create_dataset(&path);
        dataset.with_f64_data(values).with_shape(&[values.len() as u64]);
        if !plain {
            dataset.set_attr(NAME, AttrValue::String(name.to_owned()));
        }
        if let Some(column) = columns::find(name) {
            dataset.set_attr("units", AttrValue::String(columns::si(column)));
        }
    }
    for (key, value) in &recording.metadata {
        out.set_attr(key, AttrValue::String(value.clone()));
    }
    out.finish()
        .map_err(|e| Error::File { file: file.into(), why: format!("cannot be written as HDF5: {e}") })
}
