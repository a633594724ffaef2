//! The file of a new session.

use crate::experiment::rfc3339;
use perception::{Experiment, Header, Log, SCHEMA, Subject};
use std::path::Path;
use std::time::SystemTime;

/// A label that can be part of a file's name.
fn label(text: &str) -> Result<String, String> {
    let text = text.trim();
    let fits = |b: u8| b.is_ascii_alphanumeric() || matches!(b, b'-' | b'_');
    if (1..=32).contains(&text.len()) && text.bytes().all(fits) {
        Ok(text.to_owned())
    } else {
        Err("subject: a label of 1 to 32 letters, digits, - and _ is accepted".into())
    }
}

/// Why another session, or another surface, is refused.
pub(crate) const OPEN: &str = "a session is open: leave it first";

/// # Errors
/// [`OPEN`] while a session is open.
pub(crate) fn none_open(open: bool) -> Result<(), String> {
    if open { Err(OPEN.into()) } else { Ok(()) }
}

/// Creates `KIND-SUBJECT-N.jsonl` with the first free N, and its name without `.jsonl`.
///
/// # Errors
/// The subject is not a label; the file cannot be created.
pub(crate) fn create(
    folder: &Path,
    kind: &str,
    subject: &str,
    device: String,
    experiment: Experiment,
) -> Result<(Log, String), String> {
    let subject = label(subject)?;
    std::fs::create_dir_all(folder).map_err(|e| format!("{}: {e}", folder.display()))?;
    let now = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH).map_or(0, |d| d.as_secs());
    let free = (1..1_000).map(|k| format!("{kind}-{subject}-{k}")).find_map(|name| {
        let path = folder.join(format!("{name}.jsonl"));
        (!path.exists()).then_some((name, path))
    });
    let (name, path) = free.ok_or("a thousand sessions of this subject: another label is accepted")?;
    let header = Header {
        schema: SCHEMA.into(),
        subject: Subject { id: subject, simulated: None },
        began: rfc3339(now),
        device,
        experiment,
    };
    let log = Log::create(&path, &header).map_err(|e| e.to_string())?;
    Ok((log, name))
}
