//! Recordings from bags of ROS 2: a file of SQLite, or a folder with `metadata.yaml` and the files it names, of SQLite or MCAP.

use super::mcap;
use super::signatures::{self, BAG_METADATA};
use super::topics::{self, Topics};
use super::variables::Wanted;
use crate::{Error, Recording, files};
use rusqlite::limits::Limit;
use rusqlite::{Connection, ErrorCode, OpenFlags};
use std::collections::HashMap;
use std::io::Read;
use std::path::{Component, Path, PathBuf};

/// Operations of SQLite after which a file of no bytes is given up.
const WORK: u64 = 10_000_000;
/// The same for each byte.
const WORK_PER_BYTE: u64 = 100;
/// Operations between two looks.
const STRIDE: i32 = 1000;

/// Reads a bag's file.
pub(crate) fn read(file: &str, path: &Path, wanted: &Wanted) -> Result<Recording, Error> {
    let mut topics = Topics::default();
    storage(path, &mut topics).map_err(|why| Error::File { file: file.into(), why })?;
    topics.assemble(file, wanted)
}

/// Reads a bag's folder.
pub(crate) fn read_folder(file: &str, path: &Path, wanted: &Wanted) -> Result<Recording, Error> {
    let mut topics = Topics::default();
    for part in parts(path).map_err(|why| Error::File { file: file.into(), why })? {
        let name = part.display().to_string();
        let read = if begins_with(&part, signatures::MCAP) {
            mcap::read_topics(&part, std::mem::take(&mut topics)).map(|read| topics = read)
        } else {
            storage(&part, &mut topics)
        };
        read.map_err(|why| Error::File { file: name, why })?;
    }
    topics.assemble(file, wanted)
}

/// The files that `metadata.yaml` names.
fn parts(folder: &Path) -> Result<Vec<PathBuf>, String> {
    let text = std::fs::read_to_string(folder.join(BAG_METADATA))
        .map_err(|e| format!("{BAG_METADATA}: {}", files::reason(&e)))?;
    // a list of plain names: `relative_file_paths:` and lines that begin with a dash
    let mut lines = text.lines().map(str::trim).skip_while(|line| *line != "relative_file_paths:").skip(1);
    let name =
        |line: &str| line.strip_prefix("- ").map(|name| name.trim().trim_matches(['"', '\'']).to_owned());
    let names: Vec<String> = std::iter::from_fn(|| lines.next().and_then(name)).collect();
    if names.is_empty() {
        return Err(format!("{BAG_METADATA} names no files under relative_file_paths"));
    }
    for name in &names {
        let is_plain = |part: Component<'_>| matches!(part, Component::Normal(_) | Component::CurDir);
        if !Path::new(name).components().all(is_plain) {
            return Err(format!(
                "{BAG_METADATA}: `{name}` is outside the bag; accepted are files inside its folder"
            ));
        }
        if name.ends_with(".zstd") {
            return Err(format!(
                "{name} is compressed as a whole; accepted once `ros2 bag convert` has unpacked it"
            ));
        }
    }
    Ok(names.iter().map(|name| folder.join(name)).collect())
}

fn begins_with(path: &Path, magic: &[u8]) -> bool {
    let mut head = vec![0; magic.len()];
    std::fs::File::open(path).and_then(|mut f| f.read_exact(&mut head)).is_ok() && head == magic
}

/// Reads the messages of a file of SQLite.
fn storage(path: &Path, topics: &mut Topics) -> Result<(), String> {
    let size = std::fs::metadata(path).map_err(|e| files::reason(&e))?.len();
    if !begins_with(path, signatures::SQLITE) {
        return Err("neither SQLite nor MCAP".into());
    }
    let words = |e: rusqlite::Error| match e.sqlite_error_code() {
        Some(ErrorCode::OperationInterrupted) => {
            format!(
                "SQLite that takes more work than tables of {size} bytes; accepted is a bag's own file, undamaged"
            )
        }
        _ => format!("SQLite that cannot be read: {e}"),
    };
    let open = |uri: &str| {
        let flags =
            OpenFlags::SQLITE_OPEN_READ_ONLY | OpenFlags::SQLITE_OPEN_URI | OpenFlags::SQLITE_OPEN_NO_MUTEX;
        Connection::open_with_flags(uri, flags)
    };
    let mut log = path.as_os_str().to_owned();
    log.push("-wal");
    // nothing is written beside a file that has no write-ahead log, and its folder may be read-only
    let immutable = if Path::new(&log).exists() { "" } else { "?immutable=1" };
    let escaped: String = path.to_string_lossy().chars().map(escaped).collect();
    let mut database = open(&format!("file:{escaped}{immutable}")).map_err(words)?;
    // no message is longer than the file
    let longest = i32::try_from(size).unwrap_or(i32::MAX);
    database.set_limit(Limit::SQLITE_LIMIT_LENGTH, longest).map_err(words)?;
    // reading a table takes some ten operations a row, and no row is shorter than a byte
    let most = WORK + size.saturating_mul(WORK_PER_BYTE);
    let mut done = 0;
    let beyond = move || {
        done += STRIDE as u64;
        done > most
    };
    database.progress_handler(STRIDE, Some(beyond)).map_err(words)?;
    let mut read: HashMap<i64, (String, String)> = HashMap::new();
    let mut query = database
        .prepare("SELECT id, name, type, serialization_format FROM topics")
        .map_err(|e| format!("SQLite, but no bag of ROS 2: {e}"))?;
    let mut rows = query.query([]).map_err(words)?;
    while let Some(row) = rows.next().map_err(words)? {
        let text = |i: usize| row.get::<_, String>(i).map_err(words);
        let (topic, kind, format) = (text(1)?, text(2)?, text(3)?);
        if topics::is_read(&kind) && format == "cdr" {
            read.insert(row.get(0).map_err(words)?, (topic, kind));
        } else {
            topics.other(&topic, &kind);
        }
    }
    let mut query = database
        .prepare("SELECT topic_id, timestamp, data, id FROM messages ORDER BY id")
        .map_err(|e| format!("SQLite, but no bag of ROS 2: {e}"))?;
    let mut rows = query.query([]).map_err(words)?;
    while let Some(row) = rows.next().map_err(words)? {
        let Some((topic, kind)) = read.get(&row.get::<_, i64>(0).map_err(words)?) else { continue };
        let logged: i64 = row.get(1).map_err(words)?;
        let data = row.get_ref(2).map_err(words)?;
        let id: i64 = row.get(3).map_err(words)?;
        let data = data.as_blob().map_err(|e| format!("message {id}: {e}"))?;
        topics.message(topic, kind, logged, data).map_err(|why| format!("message {id} of {topic}: {why}"))?;
    }
    Ok(())
}

/// A character of a path in a URI.
fn escaped(c: char) -> String {
    match c {
        '?' | '#' | '%' => format!("%{:02x}", u32::from(c)),
        c => c.to_string(),
    }
}
