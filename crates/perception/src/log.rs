//! A session's file: a header line, then one JSON line per finished trial, on disk before the next trial begins.

use crate::record::{Experiment, Header, Record, SCHEMA};
use std::fs::{File, OpenOptions};
use std::io::{Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

/// Reason why a session's file is unusable.
#[derive(Debug, thiserror::Error)]
pub enum LogError {
    /// Error of the file system.
    #[error("{path}: {source}")]
    Io {
        /// File.
        path: PathBuf,
        /// Reason.
        source: std::io::Error,
    },
    /// Invalid line.
    #[error("{path}:{line}: {why}")]
    Line {
        /// File.
        path: PathBuf,
        /// Number of the trial from 1.
        line: usize,
        /// Error, and what would be accepted.
        why: String,
    },
}

/// Contents of a session's file.
#[derive(Debug, Clone, PartialEq)]
pub struct Session {
    /// Header, the first line.
    pub header: Header,
    /// Records, one per finished trial.
    pub records: Vec<Record>,
    /// Whether the last line was cut off, for example by a power cut. It was no finished trial and is left out.
    pub cut_off: bool,
}

/// An open session's file.
#[derive(Debug)]
pub struct Log {
    path: PathBuf,
    file: File,
}

impl Log {
    /// Creates the file of a new session. File and directory entry are on disk when this returns.
    ///
    /// # Errors
    /// The file exists already, or cannot be written.
    pub fn create(path: &Path, header: &Header) -> Result<Self, LogError> {
        let io = |source| LogError::Io { path: path.to_owned(), source };
        let file = OpenOptions::new().write(true).create_new(true).open(path).map_err(io)?;
        let mut log = Self { path: path.to_owned(), file };
        log.write(&serde_json::to_string(header).map_err(|e| io(e.into()))?)?;
        #[cfg(unix)]
        if let Some(folder) = path.parent() {
            let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
            File::open(folder).and_then(|folder| folder.sync_all()).map_err(io)?;
        }
        Ok(log)
    }

    /// Resumes a session: its contents, and the open file. Removes a line that was cut off.
    ///
    /// # Errors
    /// The file cannot be read or written, or is not a session's.
    pub fn resume(path: &Path) -> Result<(Self, Session), LogError> {
        let io = |source| LogError::Io { path: path.to_owned(), source };
        let mut file = OpenOptions::new().read(true).write(true).open(path).map_err(io)?;
        let mut bytes = Vec::new();
        file.read_to_end(&mut bytes).map_err(io)?;
        let session = parse(path, &bytes)?;
        if session.cut_off {
            file.set_len(whole(&bytes) as u64).map_err(io)?;
        }
        file.seek(SeekFrom::End(0)).map_err(io)?;
        Ok((Self { path: path.to_owned(), file }, session))
    }

    /// Writes a finished trial. It is on disk when this returns.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn append(&mut self, record: &Record) -> Result<(), LogError> {
        let line = serde_json::to_string(record)
            .map_err(|e| LogError::Io { path: self.path.clone(), source: e.into() })?;
        self.write(&line)
    }

    /// Path of the file.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }

    fn write(&mut self, line: &str) -> Result<(), LogError> {
        let line = format!("{line}\n");
        self.file
            .write_all(line.as_bytes())
            .and_then(|()| self.file.sync_data())
            .map_err(|source| LogError::Io { path: self.path.clone(), source })
    }
}

impl Session {
    /// Reads a session's file.
    ///
    /// # Errors
    /// The file cannot be read, or a line is not a session's: file, line and why.
    pub fn read(path: &Path) -> Result<Self, LogError> {
        let bytes = std::fs::read(path).map_err(|source| LogError::Io { path: path.to_owned(), source })?;
        parse(path, &bytes)
    }
}

/// Bytes up to the last line break, inclusive. The rest was not written completely and may end within a character.
fn whole(bytes: &[u8]) -> usize {
    bytes.iter().rposition(|&b| b == b'\n').map_or(0, |end| end + 1)
}

fn parse(path: &Path, bytes: &[u8]) -> Result<Session, LogError> {
    let wrong = |line: usize, why: String| LogError::Line { path: path.to_owned(), line, why };
    let (whole, rest) = bytes.split_at(whole(bytes));
    let mut lines = whole.split_inclusive(|&b| b == b'\n');
    let first =
        lines.next().ok_or_else(|| wrong(1, "no header: not a session, or none that began".into()))?;
    let header: Header =
        serde_json::from_slice(first).map_err(|e| wrong(1, format!("not the header of a session: {e}")))?;
    if header.schema != SCHEMA {
        return Err(wrong(1, format!("schema `{}`: `{SCHEMA}` is accepted", header.schema)));
    }
    let checked = match &header.experiment {
        Experiment::Targeting(plan) => plan.validate(),
        Experiment::ForcedChoice(plan) => plan.validate(),
        Experiment::Ring(plan) => plan.validate(),
    };
    checked.map_err(|why| wrong(1, why))?;
    let mut records = Vec::new();
    for (k, line) in lines.enumerate() {
        let record: Record =
            serde_json::from_slice(line).map_err(|e| wrong(k + 2, format!("not a finished trial: {e}")))?;
        let fits = matches!(
            (&header.experiment, &record),
            (Experiment::Targeting(_), Record::Targeting(_))
                | (Experiment::ForcedChoice(_), Record::ForcedChoice(_))
                | (Experiment::Ring(_), Record::Ring(_))
        );
        if !fits {
            return Err(wrong(k + 2, "a trial of another experiment than the header's".into()));
        }
        records.push(record);
    }
    Ok(Session { header, records, cut_off: !rest.is_empty() })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::record::Subject;
    use crate::{Event, Targeting, TargetingPlan};

    fn header(plan: TargetingPlan) -> Header {
        Header {
            schema: SCHEMA.into(),
            subject: Subject { id: "subject é".into(), simulated: None },
            began: String::new(),
            device: "sim".into(),
            experiment: Experiment::Targeting(plan),
        }
    }

    fn trials(task: &mut Targeting, count: usize) -> Vec<Record> {
        let mut records = Vec::new();
        while records.len() < count {
            task.start(0.0);
            for k in 1..=8 {
                let at = task.target_m().expect("a target");
                if let Some(Event::Finished(trial)) = task.click(f64::from(k) * 0.6, at) {
                    records.push(Record::Targeting(trial));
                }
            }
        }
        records
    }

    #[test]
    fn a_cut_file_keeps_every_complete_trial() {
        let dir = tempfile::tempdir().expect("a folder");
        let path = dir.path().join("session.jsonl");
        let plan = TargetingPlan::thesis(2);
        let mut task = Targeting::new(plan.clone());
        let records = trials(&mut task, 3);
        let mut log = Log::create(&path, &header(plan.clone())).expect("created");
        assert!(Log::create(&path, &header(plan.clone())).is_err(), "nothing is overwritten");
        records.iter().for_each(|record| log.append(record).expect("kept"));
        let all = std::fs::read(&path).expect("bytes");
        let first = all.iter().position(|&b| b == b'\n').expect("a header");
        // around the end of every line, and elsewhere
        let near_an_end = |cut: usize| all[cut.saturating_sub(2)..all.len().min(cut + 2)].contains(&b'\n');
        for cut in (0..=all.len()).rev().filter(|&cut| near_an_end(cut) || cut % 41 == 0) {
            std::fs::write(&path, &all[..cut]).expect("written");
            if cut <= first {
                assert!(Session::read(&path).is_err(), "no header at {cut}");
                continue;
            }
            let whole = all[..cut].iter().filter(|&&b| b == b'\n').count() - 1;
            let (mut log, session) = Log::resume(&path).expect("resumed");
            assert_eq!(session.records, records[..whole], "cut at {cut}");
            assert_eq!(session.cut_off, all[cut - 1] != b'\n');
            let mut again = Targeting::resume(plan.clone(), &session.records);
            assert_eq!(again.progress().0, whole);
            if cut % 410 == 0 {
                let next = trials(&mut again, 1).remove(0);
                log.append(&next).expect("kept");
                assert_eq!(Session::read(&path).expect("read").records.len(), whole + 1);
            }
        }
        println!("{} bytes, cut around each line's end and at each 41st", all.len());
    }

    #[test]
    fn invalid_sessions_are_reported_with_their_line() {
        let dir = tempfile::tempdir().expect("a folder");
        let path = dir.path().join("s.jsonl");
        let head = serde_json::to_string(&header(TargetingPlan::thesis(1))).expect("text");
        for (text, line, says) in [
            ("nonsense\n".to_owned(), 1, "not the header"),
            (head.replace("session/1", "session/9") + "\n", 1, "tribos.session/1"),
            (head.replace("\"cursor_px\":6.0", "\"cursor_px\":-6.0") + "\n", 1, "cursor_px"),
            (format!("{head}\n{{}}\n"), 2, "not a finished trial"),
        ] {
            std::fs::write(&path, text).expect("written");
            let why = Session::read(&path).expect_err("refused").to_string();
            println!("{why}");
            assert!(why.contains(&format!("s.jsonl:{line}: ")) && why.contains(says), "{why}");
        }
    }
}
