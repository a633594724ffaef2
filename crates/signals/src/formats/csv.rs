//! Recordings as text: a header whose names carry units, `#` lines of metadata, SI.
//!
//! Cells are separated by commas, semicolons, tabs or spaces. A second line may give units (`ms;mm;N`): then the names are
//! quantities (`time;position;force`), and the numbers become SI. Where cells are not separated by commas, a comma may be the
//! decimal sign, in all of them.

use super::columns;
use super::naming::{self, Heading, Role};
use super::units::{self, Unread};
use super::variables::{NOT_USED, Wanted, one_line, units_of_map};
use crate::error::Place;
use crate::{Error, Recording};
use std::borrow::Cow;
use std::cell::Cell;
use std::collections::BTreeMap;
use std::fmt::Write;

pub(crate) fn read(file: &str, bytes: &[u8], wanted: &Wanted) -> Result<Recording, Error> {
    if bytes.starts_with(&[0xff, 0xfe]) || bytes.starts_with(&[0xfe, 0xff]) {
        return Err(Error::File { file: file.into(), why: "UTF-16 text; accepted is UTF-8".into() });
    }
    let mut table = Table::read(file, bytes)?;
    let column = |name: &str| {
        let labelled = |n: &String| wanted.joint.is_some_and(|j| naming::is_of_joint(n, name, j));
        let names = &table.names;
        names.iter().position(|n| n == name).or_else(|| names.iter().position(labelled))
    };
    let mut recording = match (wanted.map)(&|name| column(name).is_some()) {
        Some(map) => {
            let has = table.names.join(", ");
            let variables = table.numbers(|_| true)?;
            let made = map.apply(|name| column(name).map(|i| variables[i].as_slice()), &has)?;
            let of_map = |why: String| Error::Map { map: map.text().into(), column: 1, why };
            let mut made = columns::assemble(made)
                .map_err(|m| of_map(format!("no {m}; a recording needs time, position and force")))?;
            let units = |name: &str| column(name).and_then(|i| table.unit(i));
            made.remarks.extend(units_of_map(map, units));
            made
        }
        None => table.named(wanted.joint)?,
    };
    recording.metadata = table.metadata;
    Ok(recording)
}

/// What separates cells.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Separator {
    Character(u8),
    /// Any number of spaces and tabs.
    Spaces,
}

/// Cells as text, with the line each row is on.
struct Table<'a> {
    file: &'a str,
    names: Vec<String>,
    /// Of the second line; empty without one.
    units: Vec<String>,
    separator: Separator,
    /// Decimal sign that a cell had, and its line.
    decimal: Cell<Option<(char, u64)>>,
    /// 0 for a file without header.
    header_line: u64,
    rows: Vec<(u64, Vec<Cow<'a, str>>)>,
    metadata: BTreeMap<String, String>,
}

impl<'a> Table<'a> {
    fn read(file: &'a str, bytes: &'a [u8]) -> Result<Self, Error> {
        let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
        let mut table = Self {
            file,
            names: Vec::new(),
            units: Vec::new(),
            separator: Separator::Spaces,
            decimal: Cell::default(),
            header_line: 0,
            rows: Vec::new(),
            metadata: BTreeMap::new(),
        };
        let mut separator = None;
        for (line, text) in (1u64..).zip(bytes.split(|b| *b == b'\n')) {
            let text = text.strip_suffix(b"\r").unwrap_or(text);
            if text.trim_ascii().is_empty() {
                continue;
            }
            if let Some(comment) = text.trim_ascii_start().strip_prefix(b"#") {
                table.comment(&String::from_utf8_lossy(comment));
                continue;
            }
            table.separator = *separator.get_or_insert_with(|| {
                let count = |d: u8| text.iter().filter(|b| **b == d).count();
                match [b',', b'\t', b';'].into_iter().max_by_key(|d| count(*d)) {
                    Some(d) if count(d) > 0 => Separator::Character(d),
                    _ => Separator::Spaces,
                }
            });
            let cells = split(text, table.separator);
            if table.names.is_empty() {
                if cells.iter().all(|c| table.number(c).is_some()) {
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
            if table.header_line > 0 && table.rows.is_empty() && table.units.is_empty() && are_units(&cells) {
                table.units = cells.iter().map(|c| c.trim().to_string()).collect();
                continue;
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

    /// The unit that the second line gives a column.
    fn unit(&self, i: usize) -> Option<&str> {
        self.units.get(i).map(String::as_str).filter(|unit| !unit.is_empty())
    }

    /// A recording by the names in the header.
    fn named(&mut self, joint: Option<&str>) -> Result<Recording, Error> {
        let header = Some(self.header_line).filter(|line| *line > 0);
        if header.is_none() {
            let why = "no header: the first line is numbers; accepted is a header such as time_s,position_m,force_n, \
                       or a map of the columns c1, c2, … such as time_s=c1,position_m=c2,force_n=c3";
            return Err(self.error(Some(self.rows[0].0), None, "", why.into()));
        }
        let headings: Vec<Heading> =
            self.names.iter().enumerate().map(|(i, name)| Heading { name, unit: self.unit(i) }).collect();
        let naming::Roles { roles, remarks } =
            naming::roles(&headings, joint).map_err(|r| match r.heading {
                Some(i) => self.error(header, Some(i), &self.names[i], r.why),
                None => self.error(
                    header,
                    None,
                    "",
                    format!("{}; the header has {}", r.why, self.names.join(", ")),
                ),
            })?;
        let numbers = self.numbers(|i| matches!(roles[i], Role::Column(..)))?;
        let columns = roles.iter().zip(numbers).filter_map(|(role, values)| match role {
            Role::Column(column, unit) => Some((*column, unit.all_to_si(values))),
            Role::Extra => None,
        });
        let mut recording = columns::assemble(columns.collect()).map_err(|missing| {
            let why = format!("no column {missing}; the header has {}", self.names.join(", "));
            self.error(header, None, "", why)
        })?;
        let mut text = Vec::new();
        for (i, name) in self.names.iter().enumerate().filter(|(i, _)| roles[*i] == Role::Extra) {
            match self.extra(i) {
                Some(values) => drop(recording.extra.insert(name.clone(), values)),
                None => text.push(name.clone()),
            }
        }
        if !text.is_empty() {
            self.metadata.insert(NOT_USED.into(), text.join(", "));
        }
        recording.remarks = remarks;
        Ok(recording)
    }

    /// A column whose every cell is a number or empty.
    fn extra(&self, i: usize) -> Option<Vec<f64>> {
        let values: Option<Vec<f64>> = self.rows.iter().map(|(_, cells)| self.number(&cells[i])).collect();
        values.filter(|v| v.iter().any(|x| x.is_finite()))
    }

    /// An empty cell is a value that is not there: NaN, which the audit reports.
    fn number(&self, cell: &str) -> Option<f64> {
        let cell = cell.trim();
        if cell.is_empty() {
            return Some(f64::NAN);
        }
        let comma = || self.separator != Separator::Character(b',') && !cell.contains('.');
        cell.parse().ok().or_else(|| if comma() { cell.replacen(',', ".", 1).parse().ok() } else { None })
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
                let value = self.number(cell).ok_or_else(|| {
                    let comma = self.separator == Separator::Character(b',') && cell.contains(',');
                    let hint = if comma { "; the decimal sign is a point" } else { "" };
                    let accepted = format!(
                        "is not a number; accepted is one such as -0.25 or 1e-3, or an empty cell{hint}"
                    );
                    self.error(Some(*line), Some(i), cell.trim(), accepted)
                })?;
                if self.separator != Separator::Character(b',')
                    && let Some(sign) = cell.chars().find(|c| matches!(c, '.' | ','))
                {
                    match self.decimal.get() {
                        None => self.decimal.set(Some((sign, *line))),
                        Some((other, at)) if other != sign => {
                            let accepted = format!(
                                "has another decimal sign than line {at}; accepted is a point or a comma, one in all cells"
                            );
                            return Err(self.error(Some(*line), Some(i), cell.trim(), accepted));
                        }
                        Some(_) => {}
                    }
                }
                out[i].push(value);
            }
        }
        Ok(out)
    }
}

/// Whether a line is units: no numbers, and at least one unit that is known.
fn are_units(cells: &[Cow<'_, str>]) -> bool {
    let texts = || cells.iter().map(|c| c.trim()).filter(|c| !c.is_empty());
    texts().all(|c| c.parse::<f64>().is_err()) && texts().any(|c| units::parse(c) != Err(Unread::Unknown))
}

/// Cells of one line. Quotes keep a separator, doubled quotes are one; a cell does not go on in the next line.
fn split(line: &[u8], separator: Separator) -> Vec<Cow<'_, str>> {
    let delimiter = match separator {
        Separator::Character(delimiter) => delimiter,
        Separator::Spaces => {
            let mut quoted = false;
            let cells = line.split(move |b| {
                quoted ^= *b == b'"';
                !quoted && b.is_ascii_whitespace()
            });
            let unquoted = |cell| match String::from_utf8_lossy(cell) {
                Cow::Borrowed(text) => Cow::Borrowed(text.trim_matches('"')),
                Cow::Owned(text) => text.trim_matches('"').to_owned().into(),
            };
            return cells.filter(|cell| !cell.is_empty()).map(unquoted).collect();
        }
    };
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

/// The text of a recording; every number reads back as itself.
pub(crate) fn write(recording: &Recording) -> Result<String, Error> {
    recording.check_lengths()?;
    let columns = recording.all_columns();
    let mut text = String::with_capacity(recording.len() * columns.len() * 20 + 256);
    for (key, value) in &recording.metadata {
        // One line each, and the first colon ends the key.
        let key = one_line(key).trim().replace(':', "_");
        let _ = writeln!(text, "# {key}: {}", one_line(value).trim());
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
