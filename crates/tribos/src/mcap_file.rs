//! MCAP writer, for PlotJuggler, Foxglove and Rerun: one channel per signal, JSON messages with a schema that names the unit.

use crate::columns::columns;
use crate::failure::{Failure, Result};
use crate::files;
use mcap::records::{MessageHeader, Metadata};
use serde_json::json;
use signals::Recording;
use std::collections::BTreeMap;
use std::fs::File;
use std::io::BufWriter;
use std::path::Path;

/// Writes `recording` to `path`.
///
/// # Errors
/// The file, if it cannot be written, or a time stamp out of range (MCAP counts nanoseconds from zero).
pub(crate) fn write(path: &Path, recording: &Recording) -> Result<()> {
    let start = recording.time.first().copied().unwrap_or(0.0).min(0.0);
    let stamps: Vec<u64> = recording
        .time
        .iter()
        .enumerate()
        .map(|(i, t)| {
            let ns = (t - start) * 1e9;
            if ns.is_finite() && ns < u64::MAX as f64 {
                Ok(ns.round() as u64)
            } else {
                Err(Failure::in_file(path, format!("sample {i} has time {t} s, which MCAP cannot hold")))
            }
        })
        .collect::<Result<_>>()?;
    files::through(path, |part| write_part(part, recording, &stamps)).map_err(|e: mcap::McapError| match e {
        mcap::McapError::Io(e) => files::unwritable(path, &e),
        e => Failure::in_file(path, e),
    })
}

fn write_part(path: &Path, recording: &Recording, stamps: &[u64]) -> mcap::McapResult<()> {
    let mut writer = mcap::WriteOptions::new()
        .library(format!("tribos {}", env!("CARGO_PKG_VERSION")))
        .create(BufWriter::new(File::create(path)?))?;
    writer.write_metadata(&Metadata { name: "recording".into(), metadata: recording.metadata.clone() })?;
    let mut channels = Vec::new();
    for column in columns(recording) {
        let schema = json!({
            "title": column.name,
            "type": "object",
            "properties": { column.name: { "type": "number", "description": format!("{}, {}", column.signal, column.unit) } },
            "required": [column.name],
        });
        let schema = writer.add_schema(column.name, "jsonschema", schema.to_string().as_bytes())?;
        let metadata = BTreeMap::from([("unit".to_owned(), column.unit.to_owned())]);
        let channel = writer.add_channel(schema, &format!("/{}", column.signal), "json", &metadata)?;
        channels.push((channel, column));
    }
    for (sequence, &at) in stamps.iter().enumerate() {
        for (channel, column) in &channels {
            // JSON has no NaN: a missing sample is a missing message
            let Some(value) = column.values.get(sequence).filter(|v| v.is_finite()) else { continue };
            let header = MessageHeader {
                channel_id: *channel,
                sequence: sequence as u32,
                log_time: at,
                publish_time: at,
            };
            writer.write_to_known_channel(&header, json!({ column.name: value }).to_string().as_bytes())?;
        }
    }
    writer.finish()?;
    Ok(())
}
