//! Recordings from and to Parquet: a variable a column, key-value metadata as metadata.
//!
//! A column of time stamps is in seconds from its first. What is missing is NaN. Columns of texts and lists are not read.

use super::guarded::guarded;
use super::thrift::Walk;
use super::variables::{TIME_ZERO, Variable, Wanted, assemble};
use super::{limits, signatures};
use crate::{Error, Recording};
use bytes::Bytes;
use parquet::basic::{Compression, LogicalType, Repetition, TimeUnit, Type as Physical, ZstdLevel};
use parquet::column::reader::{ColumnReader, ColumnReaderImpl};
use parquet::data_type::{DataType, DoubleType};
use parquet::errors::ParquetError;
use parquet::file::metadata::{ColumnChunkMetaData, KeyValue};
use parquet::file::properties::WriterProperties;
use parquet::file::reader::{FileReader, SerializedFileReader};
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::types::{ColumnDescriptor, Type};
use std::sync::Arc;

/// Records that are decoded at once.
const BATCH: usize = 8192;
/// Key-value metadata that describe the table to the software that wrote it.
const OF_SOFTWARE: [&str; 2] = ["ARROW:schema", "pandas"];

pub(crate) fn read(file: &str, bytes: Vec<u8>, wanted: &Wanted) -> Result<Recording, Error> {
    let fail = |why: String| Error::File { file: file.into(), why };
    check_footer(&bytes).map_err(fail)?;
    let size = bytes.len();
    let bytes = Bytes::from(bytes);
    let broken = |e: ParquetError| fail(format!("Parquet that cannot be read: {e}"));
    let reader = SerializedFileReader::new(bytes.clone()).map_err(broken)?;
    let metadata = reader.metadata();
    let rows = usize::try_from(metadata.file_metadata().num_rows()).unwrap_or(0);
    let schema = metadata.file_metadata().schema_descr();
    let mut variables = Vec::new();
    let mut zero = None;
    let mut left = limits::total(size);
    for (i, column) in schema.columns().iter().enumerate() {
        let name = column.path().parts().join(".");
        let at = |why: String| fail(format!("column {} ({name}): {why}", i + 1));
        let kind = match kind(column) {
            Ok(kind) => kind,
            Err(kind) => {
                variables.push(Variable::other(name, kind, vec![rows]));
                continue;
            }
        };
        let stated = rows.saturating_mul(8);
        left = left
            .checked_sub(stated)
            .ok_or_else(|| at(limits::too_much("it", stated, limits::total(size))))?;
        let mut values = Values::default();
        for group in 0..metadata.num_row_groups() {
            let about = metadata.row_group(group);
            check_pages(&bytes, about.column(i)).map_err(at)?;
            let records = usize::try_from(about.num_rows()).ok().filter(|n| values.numbers.len() + n <= rows);
            let records = records.ok_or_else(|| at(format!("more than the {rows} rows of the file")))?;
            // it panics where a dictionary is missing, and on numbers of more bytes than a number has
            let read = guarded(|| {
                let reader = reader.get_row_group(group)?.get_column_reader(i)?;
                values.read(reader, records, column.max_def_level(), kind)
            });
            read.map_err(|said| at(format!("damaged ({said})")))?.map_err(|e| at(e.to_string()))?;
        }
        if values.numbers.len() != rows {
            return Err(at(format!("has {} rows, the file has {rows}", values.numbers.len())));
        }
        let mut variable = Variable::column(name, kind.name(), values.numbers);
        if let Kind::Stamp { per_second, .. } = kind {
            variable.unit = Some("s".into());
            let first = values.first.unwrap_or_default();
            zero = zero.or(Some(i128::from(first) * i128::from(1_000_000_000 / per_second)));
        }
        variables.push(variable);
    }
    let mut recording = assemble(file, variables, wanted)?;
    for KeyValue { key, value } in metadata.file_metadata().key_value_metadata().into_iter().flatten() {
        if let Some(value) = value
            && !OF_SOFTWARE.contains(&key.as_str())
        {
            recording.metadata.insert(key.clone(), value.clone());
        }
    }
    if let Some(zero) = zero {
        recording.metadata.insert(TIME_ZERO.into(), zero.to_string());
        recording.remarks.push(format!("time stamps: seconds from the first ({TIME_ZERO} = {zero})"));
    }
    Ok(recording)
}

/// Refuses a footer that does not fit its bytes.
fn check_footer(bytes: &[u8]) -> Result<(), String> {
    let (rest, end) = bytes.split_last_chunk::<8>().ok_or("Parquet that is cut off")?;
    if &end[4..] != signatures::PARQUET {
        return Err("Parquet that is cut off: it does not end with PAR1".into());
    }
    let length = u32::from_le_bytes([end[0], end[1], end[2], end[3]]) as usize;
    let footer = rest.len().checked_sub(length).map(|at| &rest[at..]);
    if footer.is_some_and(|footer| Walk::new(footer).fits()) {
        Ok(())
    } else {
        Err("Parquet with a damaged footer".into())
    }
}

/// Refuses a page that unpacks to more than is believed, from what its header says.
fn check_pages(bytes: &[u8], column: &ColumnChunkMetaData) -> Result<(), String> {
    let most = limits::stated(bytes.len());
    // `ColumnChunkMetaData::byte_range` panics where one is negative
    let start = usize::try_from(column.dictionary_page_offset().unwrap_or_else(|| column.data_page_offset()));
    let length = usize::try_from(column.compressed_size());
    let range = start.ok().zip(length.ok()).and_then(|(start, n)| Some(start..start.checked_add(n)?));
    let end = range.as_ref().map_or(0, |range| range.end);
    let mut chunk = range.and_then(|range| bytes.get(range)).ok_or("its data lie outside of the file")?;
    while !chunk.is_empty() {
        let at = end - chunk.len();
        let page = Walk::new(chunk).page().ok_or_else(|| format!("byte {at}: a damaged page header"))?;
        if page.unpacked > most {
            return Err(limits::too_much(&format!("byte {at}: a page"), page.unpacked, most));
        }
        chunk = page
            .header
            .checked_add(page.packed)
            .and_then(|n| chunk.get(n..))
            .ok_or_else(|| format!("byte {at}: a page longer than its column"))?;
    }
    Ok(())
}

/// Type of the numbers of a column.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Kind {
    Boolean,
    Integer { unsigned: bool, over: f64 },
    Float,
    Stamp { per_second: i64 },
}

impl Kind {
    const fn name(self) -> &'static str {
        match self {
            Self::Boolean => "boolean",
            Self::Integer { .. } => "integer",
            Self::Float => "double",
            Self::Stamp { .. } => "time stamp",
        }
    }
}

/// The kind of a column of numbers, or what it is instead.
fn kind(column: &ColumnDescriptor) -> Result<Kind, &'static str> {
    if column.max_rep_level() > 0 {
        return Err("list");
    }
    let integer = Kind::Integer { unsigned: false, over: 1.0 };
    match (column.physical_type(), column.logical_type_ref()) {
        (Physical::BOOLEAN, _) => Ok(Kind::Boolean),
        (Physical::FLOAT | Physical::DOUBLE, _) => Ok(Kind::Float),
        (Physical::INT32 | Physical::INT64, None) => Ok(integer),
        (Physical::INT32 | Physical::INT64, Some(logical)) => match logical {
            LogicalType::Integer(about) => Ok(Kind::Integer { unsigned: !about.is_signed, over: 1.0 }),
            LogicalType::Decimal(about) => {
                Ok(Kind::Integer { unsigned: false, over: 10f64.powi(about.scale.clamp(0, 300)) })
            }
            LogicalType::Timestamp(about) => Ok(Kind::Stamp {
                per_second: match about.unit {
                    TimeUnit::MILLIS => 1000,
                    TimeUnit::MICROS => 1_000_000,
                    TimeUnit::NANOS => 1_000_000_000,
                },
            }),
            _ => Err("of another type"),
        },
        (Physical::BYTE_ARRAY, _) => Err("text"),
        _ => Err("of another type"),
    }
}

/// Numbers of a column, collected group by group.
#[derive(Default)]
struct Values {
    numbers: Vec<f64>,
    /// First time stamp.
    first: Option<i64>,
}

impl Values {
    fn read(
        &mut self,
        reader: ColumnReader,
        records: usize,
        optional: i16,
        kind: Kind,
    ) -> Result<(), ParquetError> {
        let (unsigned, over) = match kind {
            Kind::Integer { unsigned, over } => (unsigned, over),
            _ => (false, 1.0),
        };
        match reader {
            ColumnReader::BoolColumnReader(r) => {
                self.of(r, records, optional, |x, _| f64::from(u8::from(*x)))
            }
            ColumnReader::FloatColumnReader(r) => self.of(r, records, optional, |x, _| f64::from(*x)),
            ColumnReader::DoubleColumnReader(r) => self.of(r, records, optional, |x, _| *x),
            ColumnReader::Int32ColumnReader(r) if unsigned => {
                self.of(r, records, optional, |x, _| f64::from(x.cast_unsigned()))
            }
            ColumnReader::Int32ColumnReader(r) => {
                self.of(r, records, optional, move |x, _| f64::from(*x) / over)
            }
            ColumnReader::Int64ColumnReader(r) => match kind {
                Kind::Stamp { per_second } => self.of(r, records, optional, move |x, first| {
                    let zero = *first.get_or_insert(*x);
                    x.saturating_sub(zero) as f64 / per_second as f64
                }),
                _ if unsigned => self.of(r, records, optional, |x, _| x.cast_unsigned() as f64),
                _ => self.of(r, records, optional, move |x, _| *x as f64 / over),
            },
            _ => Err(ParquetError::General("is of another type than its header says".into())),
        }
    }

    fn of<T: DataType>(
        &mut self,
        mut reader: ColumnReaderImpl<T>,
        records: usize,
        optional: i16,
        number: impl Fn(&T::T, &mut Option<i64>) -> f64,
    ) -> Result<(), ParquetError> {
        let mut left = records;
        let (mut values, mut levels) = (Vec::with_capacity(left.min(BATCH)), Vec::new());
        while left > 0 {
            values.clear();
            levels.clear();
            let wanted = (optional > 0).then_some(&mut levels);
            let (read, _, _) = reader.read_records(left.min(BATCH), wanted, None, &mut values)?;
            if read == 0 {
                break;
            }
            left -= read.min(left);
            let mut there = values.iter();
            if optional > 0 {
                for level in &levels {
                    let value = if *level == optional { there.next() } else { None };
                    self.numbers.push(value.map_or(f64::NAN, |value| number(value, &mut self.first)));
                }
            } else {
                self.numbers.extend(there.map(|value| number(value, &mut self.first)));
            }
        }
        Ok(())
    }
}

/// The bytes of a file.
pub(crate) fn write(file: &str, recording: &Recording) -> Result<Vec<u8>, Error> {
    let fail = |e: ParquetError| Error::File {
        file: file.into(),
        why: format!("cannot be written as Parquet: {e}"),
    };
    let columns = recording.all_columns();
    let field = |(name, _): &(&str, &[f64])| {
        let field =
            Type::primitive_type_builder(name, Physical::DOUBLE).with_repetition(Repetition::REQUIRED);
        field.build().map(Arc::new)
    };
    let fields = columns.iter().map(field).collect::<Result<Vec<_>, _>>().map_err(fail)?;
    let schema = Type::group_type_builder("recording").with_fields(fields).build().map_err(fail)?;
    let metadata = recording.metadata.iter().map(|(k, v)| KeyValue::new(k.clone(), v.clone())).collect();
    let properties = WriterProperties::builder()
        .set_compression(Compression::ZSTD(ZstdLevel::default()))
        .set_dictionary_enabled(false)
        .set_created_by(format!("tribos {}", env!("CARGO_PKG_VERSION")))
        .set_key_value_metadata(Some(metadata))
        .build();
    let mut out = Vec::new();
    let mut write = || -> Result<(), ParquetError> {
        let mut writer =
            SerializedFileWriter::new(&mut out, Arc::new(schema.clone()), Arc::new(properties.clone()))?;
        let mut group = writer.next_row_group()?;
        for (_, values) in &columns {
            if let Some(mut column) = group.next_column()? {
                column.typed::<DoubleType>().write_batch(values, None, None)?;
                column.close()?;
            }
        }
        group.close()?;
        writer.close()?;
        Ok(())
    };
    write().map_err(fail)?;
    Ok(out)
}
