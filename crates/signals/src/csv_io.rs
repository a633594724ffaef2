//! Recordings as CSV: a header whose names carry units, `#` lines of metadata, SI.

use crate::columns::{self, Named};
use crate::error::Place;
use crate::{Error, Map, Recording};
use std::borrow::Cow;
use std::collections::BTreeMap;
use std::fmt::Write;

/// Metadata key of the columns of a file that are none of a recording's.
const NOT_USED: &str = "columns_not_used";

pub(crate) fn read<'m>(
    file: &str,
    bytes: &[u8],
    map: impl Fn(&dyn Fn(&str) -> bool) -> Option<&'m Map>,
) -> Result<Recording, Error> {
    if bytes.starts_with(&[0xff, 0xfe]) || bytes.starts_with(&[0xfe, 0xff]) {
        return Err(Error::File { file: file.into(), why: "UTF-16 text; accepted is UTF-8".into() });
    }
    let mut table = Table::read(file, bytes)?;
    let mut recording = match map(&|name| table.names.iter().any(|n| n == name)) {
        Some(map) => {
            let has = table.names.join(", ");
            let variables = table.numbers(|_| true)?;
            let lookup =
                |name: &str| table.names.iter().position(|n| n == name).map(|i| variables[i].as_slice());
            let made = map.apply(lookup, &has)?;
            let of_map = |why: String| Error::Map { map: map.text().into(), column: 1, why };
            columns::assemble(made)
                .map_err(|m| of_map(format!("no {m}; a recording needs time, position and force")))?
        }
        None => table.named()?,
    };
    recording.metadata = table.metadata;
    Ok(recording)
}

/// Cells as text, with the line each row is on.
struct Table<'a> {
    file: &'a str,
    names: Vec<String>,
    /// 0 for a file without header.
    header_line: u64,
    rows: Vec<(u64, Vec<Cow<'a, str>>)>,
    metadata: BTreeMap<String, String>,
}

impl<'a> Table<'a> {
    fn read(file: &'a str, bytes: &'a [u8]) -> Result<Self, Error> {
        let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
        let mut table =
            Self { file, names: Vec::new(), header_line: 0, rows: Vec::new(), metadata: BTreeMap::new() };
        let mut delimiter = None;
        for (line, text) in (1u64..).zip(bytes.split(|b| *b == b'\n')) {
            let text = text.strip_suffix(b"\r").unwrap_or(text);
            if text.trim_ascii().is_empty() {
                continue;
            }
            if let Some(comment) = text.trim_ascii_start().strip_prefix(b"#") {
                table.comment(&String::from_utf8_lossy(comment));
                continue;
            }
            let delimiter = *delimiter.get_or_insert_with(|| {
                let count = |d: u8| text.iter().filter(|b| **b == d).count();
                *[b',', b';', b'\t'].iter().rev().max_by_key(|d| count(**d)).unwrap_or(&b',')
            });
            let cells = split(text, delimiter);
            if table.names.is_empty() {
                if cells.iter().all(|c| number(c).is_some()) {
                    table.names = (1..=cells.len()).map(|i| format!("c{i}")).collect();
                } else {
                    table.names = cells.iter().map(|c| c.trim().to_string()).collect();
                    table.header_line = line;
                    continue;
                }
            }
            if cells.len() != table.names.len() {
                let found = format!("{} cells, the first line has {}", cells.len(), table.names.len());
                return Err(table.error(Some(line), None, "", found));
            }
            table.rows.push((line, cells));
        }
        if table.names.is_empty() {
            return Err(table.error(
                None,
                None,
                "",
                "no header; a recording begins with time_s,position_m,force_n".into(),
            ));
        }
        if table.rows.is_empty() {
            return Err(table.error(Some(table.header_line), None, "", "no samples below the header".into()));
        }
        Ok(table)
    }

    fn comment(&mut self, text: &str) {
        let (key, value) = text.split_once(':').or_else(|| text.split_once('=')).unwrap_or(("comment", text));
        let (key, value) = (key.trim().to_string(), value.trim());
        self.metadata
            .entry(key)
            .and_modify(|all| {
                all.push_str("; ");
                all.push_str(value);
            })
            .or_insert_with(|| value.to_string());
    }

    fn error(&self, line: Option<u64>, column: Option<usize>, value: &str, accepted: String) -> Error {
        let column = column.map(|i| (i + 1, self.names.get(i).cloned().unwrap_or_default()));
        Error::Input { file: self.file.into(), place: Place { line, column }, value: value.into(), accepted }
    }

    /// A recording by the names in the header.
    fn named(&mut self) -> Result<Recording, Error> {
        let header = Some(self.header_line).filter(|line| *line > 0);
        if header.is_none() {
            let why = "no header: the first line is numbers; accepted is a header such as time_s,position_m,force_n, \
                       or a map of the columns c1, c2, … such as time_s=c1,position_m=c2,force_n=c3";
            return Err(self.error(Some(self.rows[0].0), None, "", why.into()));
        }
        let mut used: Vec<Option<&'static Named>> = Vec::new();
        let mut unused = Vec::new();
        for (i, name) in self.names.iter().enumerate() {
            let found = columns::find(name);
            let refuse = |why: String| Err(self.error(header, Some(i), name, why));
            match found {
                None if columns::meant(name).is_empty() => unused.push(name.clone()),
                None => return refuse(format!("is an unknown column; {}", columns::advice(name))),
                Some(column) => {
                    let given = || used.iter().flatten();
                    if let Some(other) = given().find(|o| columns::contradict(o, column)) {
                        return refuse(format!(
                            "beside {}; accepted is a slide or an axis, not both",
                            other.name
                        ));
                    }
                    if let Some(other) = given().find(|o| o.slot == column.slot) {
                        return refuse(format!("is there twice (as {}); accepted is one", other.name));
                    }
                }
            }
            used.push(found);
        }
        let numbers = self.numbers(|i| used[i].is_some())?;
        let columns =
            used.into_iter().zip(numbers).filter_map(|(column, values)| Some((column?, values))).collect();
        let mut recording = columns::assemble(columns).map_err(|missing| {
            let why = format!("no column {missing}; the header has {}", self.names.join(", "));
            self.error(header, None, "", why)
        })?;
        let mut text = Vec::new();
        for name in unused {
            match self.extra(&name) {
                Some(values) => drop(recording.extra.insert(name, values)),
                None => text.push(name),
            }
        }
        if !text.is_empty() {
            self.metadata.insert(NOT_USED.into(), text.join(", "));
        }
        Ok(recording)
    }

    /// A column whose every cell is a number or empty.
    fn extra(&self, name: &str) -> Option<Vec<f64>> {
        let i = self.names.iter().position(|n| n == name)?;
        let values: Option<Vec<f64>> = self.rows.iter().map(|(_, cells)| number(&cells[i])).collect();
        values.filter(|v| v.iter().any(|x| x.is_finite()))
    }

    /// The columns that `wanted` says, as numbers; the others stay empty.
    fn numbers(&self, wanted: impl Fn(usize) -> bool) -> Result<Vec<Vec<f64>>, Error> {
        let wanted: Vec<bool> = (0..self.names.len()).map(wanted).collect();
        let mut out = vec![Vec::new(); self.names.len()];
        for (line, cells) in &self.rows {
            for (i, cell) in cells.iter().enumerate() {
                if !wanted[i] {
                    continue;
                }
                let Some(value) = number(cell) else {
                    let hint = if cell.contains(',') { "; the decimal sign is a point" } else { "" };
                    let accepted = format!(
                        "is not a number; accepted is one such as -0.25 or 1e-3, or an empty cell{hint}"
                    );
                    return Err(self.error(Some(*line), Some(i), cell.trim(), accepted));
                };
                out[i].push(value);
            }
        }
        Ok(out)
    }
}

/// Cells of one line. Quotes keep a delimiter, doubled quotes are one; a cell does not go on in the next line.
fn split(line: &[u8], delimiter: u8) -> Vec<Cow<'_, str>> {
    if !line.contains(&b'"') {
        return line.split(|b| *b == delimiter).map(String::from_utf8_lossy).collect();
    }
    let mut reader =
        csv::ReaderBuilder::new().has_headers(false).flexible(true).delimiter(delimiter).from_reader(line);
    let mut record = csv::ByteRecord::new();
    match reader.read_byte_record(&mut record) {
        Ok(true) => record.iter().map(|c| Cow::Owned(String::from_utf8_lossy(c).into_owned())).collect(),
        _ => Vec::new(),
    }
}

/// An empty cell is a value that is not there: NaN, which the audit reports.
fn number(cell: &str) -> Option<f64> {
    let cell = cell.trim();
    if cell.is_empty() { Some(f64::NAN) } else { cell.parse().ok() }
}

/// The text of a recording; every number reads back as itself.
pub(crate) fn write(recording: &Recording) -> Result<String, Error> {
    recording.check_lengths()?;
    let mut columns: Vec<(&str, &[f64])> = recording.columns();
    columns.extend(recording.extra.iter().map(|(name, values)| (name.as_str(), values.as_slice())));
    let mut text = String::with_capacity(recording.len() * columns.len() * 20 + 256);
    for (key, value) in &recording.metadata {
        // One line each, and the first colon ends the key.
        let key = one_line(key).replace(':', "_");
        let _ = writeln!(text, "# {key}: {}", one_line(value));
    }
    let names: Vec<&str> = columns.iter().map(|(name, _)| *name).collect();
    let _ = writeln!(text, "{}", names.join(","));
    for i in 0..recording.len() {
        for (k, (_, values)) in columns.iter().enumerate() {
            let comma = if k == 0 { "" } else { "," };
            let _ = write!(text, "{comma}{:?}", values[i]);
        }
        text.push('\n');
    }
    Ok(text)
}

fn one_line(text: &str) -> String {
    text.replace(['\n', '\r'], " ").trim().to_string()
}
