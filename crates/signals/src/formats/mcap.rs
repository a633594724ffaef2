//! Recordings from and to MCAP [mcap].
//!
//! Written is one channel per signal, with JSON messages and a schema that names the unit, for PlotJuggler, Foxglove and Rerun.
//! Read are these, the two messages of ROS 2 that hold a motion, and numbers of other JSON messages. Records are read one at a time:
//! a log with hours of video takes no more memory than its largest chunk.

use super::columns;
use super::topics::{self, Topics};
use super::variables::{Variable, Wanted, assemble};
use super::{json, limits, signatures};
use crate::{Error, Recording, files};
use mcap::records::{MessageHeader, Metadata};
use serde_json::{Value, json};
use std::collections::{BTreeMap, HashMap};
use std::fs::File;
use std::io::{BufReader, Cursor, Read, Seek, SeekFrom};
use std::path::Path;

/// Operation codes of the records that are read.
const FOOTER: u8 = 0x02;
const SCHEMA: u8 = 0x03;
const CHANNEL: u8 = 0x04;
const MESSAGE: u8 = 0x05;
const CHUNK: u8 = 0x06;
const METADATA: u8 = 0x0c;

/// Name of the metadata record of a recording of ours.
const RECORDING: &str = "recording";
/// Bytes of the window of a small frame of zstd, at most.
const SMALL_WINDOW: u64 = 4 << 20;
/// Most numbers of a JSON message that become series.
const MOST: usize = 64;

pub(crate) fn read(file: &str, path: &Path, wanted: &Wanted) -> Result<Recording, Error> {
    let mut log = Log::default();
    log.read(path).map_err(|why| Error::File { file: file.into(), why })?;
    match log.metadata.take() {
        Some(metadata) if !log.columns.is_empty() => {
            let mut recording = assemble(file, log.variables(), wanted)?;
            recording.metadata.extend(metadata);
            Ok(recording)
        }
        _ => log.topics.assemble(file, wanted),
    }
}

/// Reads the messages of a log into `topics`.
pub(crate) fn read_topics(path: &Path, topics: Topics) -> Result<Topics, String> {
    let mut log = Log { topics, ..Log::default() };
    log.read(path)?;
    Ok(log.topics)
}

struct Channel {
    topic: String,
    encoding: String,
    /// Name of the schema.
    kind: String,
}

/// Contents of a log, collected record by record.
#[derive(Default)]
struct Log {
    schemas: HashMap<u16, String>,
    channels: HashMap<u16, Channel>,
    topics: Topics,
    /// Of a recording of ours.
    metadata: Option<BTreeMap<String, String>>,
    /// Columns of a recording of ours: sequence and value of each message.
    columns: BTreeMap<u16, Vec<(u32, f64)>>,
    /// Of the file, bytes.
    size: usize,
}

impl Log {
    fn read(&mut self, path: &Path) -> Result<(), String> {
        let words = |e: std::io::Error| files::reason(&e);
        let mut file = BufReader::new(File::open(path).map_err(words)?);
        let size = file.get_ref().metadata().map_err(words)?.len();
        self.size = usize::try_from(size).map_err(|e| e.to_string())?;
        let mut at = signatures::MCAP.len() as u64;
        file.seek(SeekFrom::Start(at)).map_err(words)?;
        loop {
            let cut =
                || format!("MCAP that is cut off at byte {at}; accepted once `mcap recover` has mended it");
            let mut head = [0; 9];
            file.read_exact(&mut head).map_err(|_| cut())?;
            let (operation, length) =
                (head[0], u64::from_le_bytes(*head[1..].first_chunk().ok_or_else(cut)?));
            if length > size.saturating_sub(at + 9) {
                return Err(cut());
            }
            let damaged = |why: String| format!("MCAP, byte {at}: {why}");
            match operation {
                FOOTER => return Ok(()),
                SCHEMA..=CHUNK | METADATA => {
                    let mut body = vec![0; usize::try_from(length).map_err(|e| e.to_string())?];
                    file.read_exact(&mut body).map_err(words)?;
                    self.record(operation, &body, true).map_err(damaged)?;
                }
                _ => file.seek_relative(length.cast_signed()).map_err(words)?,
            }
            at += 9 + length;
        }
    }

    fn record(&mut self, operation: u8, body: &[u8], outside: bool) -> Result<(), String> {
        if operation == MESSAGE {
            return self.message(body);
        }
        let mut fields = Fields(body);
        match operation {
            SCHEMA => {
                let id = fields.number::<2>()? as u16;
                self.schemas.insert(id, fields.text()?.to_owned());
            }
            CHANNEL => {
                let (id, schema) = (fields.number::<2>()? as u16, fields.number::<2>()? as u16);
                let (topic, encoding) = (fields.text()?.to_owned(), fields.text()?);
                let kind = self.schemas.get(&schema).cloned().unwrap_or_default();
                let read = match encoding {
                    "cdr" => topics::is_read(&kind),
                    encoding => encoding == "json",
                };
                if !read {
                    self.topics.other(&topic, if kind.is_empty() { encoding } else { &kind });
                }
                let encoding = if read { encoding.to_owned() } else { String::new() };
                self.channels.insert(id, Channel { topic, encoding, kind });
            }
            METADATA => {
                let name = fields.text()?;
                let metadata = fields.map()?;
                self.metadata = if name == RECORDING { Some(metadata) } else { self.metadata.take() };
            }
            CHUNK if outside => {
                let (_start, _end) = (fields.number::<8>()?, fields.number::<8>()?);
                let (size, checksum, compression) =
                    (fields.number::<8>()?, fields.number::<4>()?, fields.text()?);
                let length = fields.number::<8>()?;
                let packed = usize::try_from(length).ok().and_then(|n| fields.0.get(..n)).ok_or(SHORT)?;
                let chunk = self.unpacked(size, compression, packed)?;
                if checksum != 0 && u64::from(crc32fast::hash(&chunk)) != checksum {
                    return Err("a chunk whose checksum does not fit its bytes".into());
                }
                let mut rest = &chunk[..];
                while let Some((head, behind)) = rest.split_first_chunk::<9>() {
                    let length = u64::from_le_bytes(*head[1..].first_chunk().unwrap_or(&[0; 8]));
                    let body = usize::try_from(length).ok().and_then(|n| behind.split_at_checked(n));
                    let (body, behind) = body.ok_or("a record that is longer than its chunk")?;
                    if matches!(head[0], SCHEMA..=MESSAGE) {
                        self.record(head[0], body, false)?;
                    }
                    rest = behind;
                }
            }
            _ => {}
        }
        Ok(())
    }

    /// The records of a chunk. Memory grows with what is unpacked, not with what is stated.
    fn unpacked(&self, stated: u64, compression: &str, data: &[u8]) -> Result<Vec<u8>, String> {
        let most = limits::total(self.size);
        if usize::try_from(stated).is_ok_and(|n| n > most) {
            return Err(limits::too_much("a chunk", stated, most));
        }
        let damaged = |why: String| format!("a chunk cannot be unpacked: {why}");
        let words = |e: std::io::Error| damaged(e.to_string());
        let mut chunk = Vec::new();
        match compression {
            "" => chunk.extend(data),
            "zstd" => {
                let mut decoder = zstd::Decoder::with_buffer(data).map_err(words)?;
                // no frame needs a window larger than what it unpacks to; encoders take some MiB for small ones
                decoder.window_log_max(stated.max(SMALL_WINDOW).ilog2() + 1).map_err(words)?;
                decoder.take(stated + 1).read_to_end(&mut chunk).map_err(words)?;
            }
            "lz4" => {
                let decoder = lz4_flex::frame::FrameDecoder::new(data);
                decoder.take(stated + 1).read_to_end(&mut chunk).map_err(words)?;
            }
            other => return Err(format!("a chunk compressed by `{other}`; accepted are zstd, lz4 and none")),
        }
        if chunk.len() as u64 == stated {
            Ok(chunk)
        } else {
            Err(damaged(format!("{} bytes, {stated} are stated", chunk.len())))
        }
    }

    fn message(&mut self, body: &[u8]) -> Result<(), String> {
        // channel, sequence, time of the log, time of the publisher
        let (head, data) = body.split_first_chunk::<22>().ok_or("a message without header")?;
        let id = u16::from_le_bytes([head[0], head[1]]);
        let sequence = u32::from_le_bytes([head[2], head[3], head[4], head[5]]);
        let logged = head[6..].first_chunk().map_or(0, |b| u64::from_le_bytes(*b));
        let logged = i64::try_from(logged).map_err(|_| format!("a message at {logged} ns"))?;
        let channel =
            self.channels.get(&id).ok_or_else(|| format!("a message of the unknown channel {id}"))?;
        let of_topic = |why: String| format!("topic {}: {why}", channel.topic);
        match channel.encoding.as_str() {
            "cdr" => self.topics.message(&channel.topic, &channel.kind, logged, data).map_err(of_topic),
            "json" => {
                let value: Value =
                    serde_json::from_slice(data).map_err(|e| of_topic(format!("is not JSON: {e}")))?;
                if self.metadata.is_some() {
                    let value = value.get(&channel.kind).and_then(Value::as_f64);
                    let value = value.ok_or_else(|| of_topic(format!("no number `{}`", channel.kind)))?;
                    self.columns.entry(id).or_default().push((sequence, value));
                } else {
                    let mut numbers = Vec::new();
                    flatten("", &value, 0, &mut numbers);
                    self.topics.numbers(&channel.topic, logged, &numbers);
                }
                Ok(())
            }
            _ => Ok(()),
        }
    }

    /// The columns of a recording of ours. A value that is not a number is a message that is not there.
    fn variables(self) -> Vec<Variable> {
        let samples = self.columns.values().map(Vec::len).max().unwrap_or(0);
        let mut channels: Vec<(u16, Channel)> =
            self.channels.into_iter().filter(|(_, channel)| channel.encoding == "json").collect();
        channels.sort_unstable_by_key(|(id, _)| *id);
        let column = |(id, channel): (u16, Channel)| {
            let mut values = vec![f64::NAN; samples];
            for &(sequence, value) in self.columns.get(&id).into_iter().flatten() {
                if let Some(at) = values.get_mut(sequence as usize) {
                    *at = value;
                }
            }
            Variable::column(channel.kind, "signal", values)
        };
        channels.into_iter().map(column).collect()
    }
}

/// Said of a record that ends within a field.
const SHORT: &str = "a record that is shorter than its fields";

/// The fields of a record. Read here: the library reserves what a damaged length says before it reads.
struct Fields<'a>(&'a [u8]);

impl<'a> Fields<'a> {
    fn take(&mut self, n: usize) -> Result<&'a [u8], String> {
        let (taken, rest) = self.0.split_at_checked(n).ok_or(SHORT)?;
        self.0 = rest;
        Ok(taken)
    }

    /// A number of `N` bytes.
    fn number<const N: usize>(&mut self) -> Result<u64, String> {
        Ok(self.take(N)?.iter().rev().fold(0, |value, byte| value << 8 | u64::from(*byte)))
    }

    fn text(&mut self) -> Result<&'a str, String> {
        let length = self.number::<4>()? as usize;
        std::str::from_utf8(self.take(length)?).map_err(|_| "a text that is not UTF-8".into())
    }

    fn map(&mut self) -> Result<BTreeMap<String, String>, String> {
        let length = self.number::<4>()? as usize;
        let mut pairs = Fields(self.take(length)?);
        let mut out = BTreeMap::new();
        while !pairs.0.is_empty() {
            out.insert(pairs.text()?.to_owned(), pairs.text()?.to_owned());
        }
        Ok(out)
    }
}

/// Numbers of a JSON value, by their paths.
fn flatten(path: &str, value: &Value, depth: usize, out: &mut Vec<(String, f64)>) {
    if let Some(number) = json::number(value).filter(|_| out.len() < MOST) {
        out.push((path.to_owned(), number));
    }
    if let Some(members) = value.as_object().filter(|_| depth < 8) {
        for (name, value) in members {
            let path = if path.is_empty() { name.clone() } else { format!("{path}.{name}") };
            flatten(&path, value, depth + 1, out);
        }
    }
}

/// The bytes of a file. What JSON cannot hold, infinities, is left out and said.
pub(crate) fn write(file: &str, recording: &Recording) -> Result<(Vec<u8>, Option<String>), Error> {
    let fail = |why: String| Error::File { file: file.into(), why };
    let start = recording.time.first().copied().unwrap_or(0.0).min(0.0);
    let stamp = |(i, t): (usize, &f64)| {
        let ns = (t - start) * 1e9;
        let fits = ns.is_finite() && ns >= 0.0 && ns < i64::MAX as f64;
        fits.then(|| ns.round() as u64)
            .ok_or_else(|| fail(format!("sample {i} has time {t} s, which MCAP cannot hold")))
    };
    let stamps = recording.time.iter().enumerate().map(stamp).collect::<Result<Vec<u64>, Error>>()?;
    let bytes = written(recording, &stamps).map_err(|e| fail(e.to_string()))?;
    let infinite = |(_, values): &(&str, &[f64])| values.iter().filter(|x| x.is_infinite()).count();
    let lost: usize = recording.all_columns().iter().map(infinite).sum();
    Ok((bytes, (lost > 0).then(|| format!("{lost} infinite values are left out: JSON has none"))))
}

fn written(recording: &Recording, stamps: &[u64]) -> mcap::McapResult<Vec<u8>> {
    let mut writer = mcap::WriteOptions::new()
        .library(format!("tribos {}", env!("CARGO_PKG_VERSION")))
        .compression(None)
        .create(Cursor::new(Vec::new()))?;
    writer.write_metadata(&Metadata { name: RECORDING.into(), metadata: recording.metadata.clone() })?;
    let mut channels = Vec::new();
    for (name, values) in recording.all_columns() {
        let signal = columns::quantity(name);
        let unit = columns::find(name).map(columns::si).unwrap_or_default();
        let schema = json!({
            "title": name,
            "type": "object",
            "properties": { name: { "type": "number", "description": format!("{signal}, {unit}") } },
            "required": [name],
        });
        let schema = writer.add_schema(name, "jsonschema", schema.to_string().as_bytes())?;
        let metadata = BTreeMap::from([("unit".to_owned(), unit)]);
        let topic = if columns::find(name).is_some() { signal } else { name };
        let channel = writer.add_channel(schema, &format!("/{topic}"), "json", &metadata)?;
        channels.push((channel, name, values));
    }
    for (sequence, &at) in stamps.iter().enumerate() {
        for (channel, name, values) in &channels {
            // JSON has no NaN: a missing sample is a missing message
            let Some(value) = values.get(sequence).filter(|v| v.is_finite()) else { continue };
            let header = MessageHeader {
                channel_id: *channel,
                sequence: sequence as u32,
                log_time: at,
                publish_time: at,
            };
            writer.write_to_known_channel(&header, json!({ *name: value }).to_string().as_bytes())?;
        }
    }
    writer.finish()?;
    Ok(writer.into_inner().into_inner())
}
