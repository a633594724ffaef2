//! Recordings: written to disk as they grow, listed when complete.

use super::Bench;
use super::recording_in_progress::{Recording, begin_file};
use crate::handover::Handover;
use crate::known::Listed;
use crate::say::Tone;
use client::Sample;
use std::path::{Path, PathBuf};

/// An unused name: `rec-001.csv`.
fn free_name(folder: &Path) -> String {
    (1..).map(|k| format!("rec-{k:03}.csv")).find(|name| !folder.join(name).exists()).unwrap_or_default()
}

/// Whether this is a plain file name, not a path.
pub(crate) fn is_name(name: &str, extension: &str) -> bool {
    let stem = name.strip_suffix(extension).unwrap_or("");
    let fits = |b: u8| b.is_ascii_alphanumeric() || matches!(b, b'-' | b'_');
    !stem.is_empty() && name.len() <= 80 && stem.bytes().all(fits)
}

impl Bench {
    pub(super) fn begin_recording(&mut self, notes: &[(String, String)]) -> Result<(), String> {
        if self.recording.is_some() {
            return Err("one recording is running: end it first".into());
        }
        let Some(header) = &self.header else { return Err("no samples come from the device".into()) };
        std::fs::create_dir_all(&self.folder).map_err(|e| format!("{}: {e}", self.folder.display()))?;
        let name = free_name(&self.folder);
        let mut all = self.shared.known(|known| {
            let changed = if known.changed { " (changed)" } else { "" };
            vec![
                ("device".to_owned(), known.version.clone()),
                ("preset".to_owned(), format!("{}{changed}", known.preset)),
            ]
        });
        all.extend_from_slice(notes);
        let file = begin_file(&self.folder.join(&name), header, all)?;
        let bins = self.bins();
        let (motion, length) = (None, None);
        self.recording =
            Some(Recording { name, file, samples: 0, lost: 0, from: None, to: 0.0, motion, length, bins });
        self.shared.known(|known| known.recording = Some(0));
        self.dirty = true;
        Ok(())
    }

    pub(super) fn record(&mut self, sample: &Sample) {
        let Some(recording) = &mut self.recording else { return };
        let driven = matches!(
            haptics::ModeId::from_code(sample.mode),
            Some(haptics::ModeId::Exciting | haptics::ModeId::Identifying)
        );
        let mut over = false;
        if let Some(motion) = &mut recording.motion {
            match (motion.driven, driven) {
                (None, false) => return,
                (None, true) => {
                    motion.driven = Some(sample.time);
                    return;
                }
                (Some(since), true) => {
                    let warm = f64::from(haptics::excitation::RAMP_IN_S) + 0.5;
                    if sample.time - since < warm - 1e-9 {
                        return;
                    }
                    over = sample.time - since - warm >= motion.seconds - 0.5e-3;
                }
                (Some(_), false) => over = true,
            }
        }
        if over {
            return self.end_recording();
        }
        let from = *recording.from.get_or_insert(sample.time);
        if recording.length.is_some_and(|length| sample.time - from >= length - 0.5e-3) {
            return self.end_recording();
        }
        recording.to = sample.time;
        recording.samples += 1;
        recording.bins.push(sample, sample.force);
        let count = recording.samples;
        if let Err(why) = recording.file.write(&Sample { time: sample.time - from, ..*sample }) {
            self.say(Tone::Error, "record", why.to_string());
            self.recording = None;
            self.shared.known(|known| known.recording = None);
            self.dirty = true;
        } else if count.is_multiple_of(200) {
            self.shared.known(|known| known.recording = Some(count));
            self.dirty = true;
        }
    }

    pub(super) fn end_recording(&mut self) {
        let Some(recording) = self.recording.take() else { return };
        self.shared.known(|known| known.recording = None);
        self.dirty = true;
        let (name, lost) = (recording.name.clone(), recording.lost);
        let seconds = recording.to - recording.from.unwrap_or(recording.to);
        let identify = recording.motion.as_ref().is_some_and(|motion| motion.identify);
        if recording.samples == 0 {
            recording.file.discard();
            return self.say(Tone::Refused, "record", "nothing was recorded");
        }
        let bins = recording.bins;
        match recording.file.finish(lost) {
            Ok(samples) => {
                let listed = Listed { name: name.clone(), samples, lost, seconds };
                self.found = None;
                self.recorded = Some(bins);
                self.shared.known(|known| {
                    known.recordings.insert(0, listed);
                    known.handover = Handover::recorded(name.clone(), &known.device);
                });
                if identify && let Err(why) = self.analyse("identify", &[name]) {
                    self.say(Tone::Refused, "identify", why);
                }
            }
            Err(why) => self.say(Tone::Error, "record", why.to_string()),
        }
    }

    /// Lists the recordings in the folder.
    pub(super) fn list_recordings(&mut self) {
        let Ok(entries) = std::fs::read_dir(&self.folder) else { return };
        let mut names: Vec<PathBuf> = entries.filter_map(|entry| entry.ok().map(|e| e.path())).collect();
        names.sort();
        let listed: Vec<Listed> = names.iter().rev().filter_map(|path| listed(path)).collect();
        self.shared.known(|known| known.recordings = listed);
    }

    /// Files of these recordings or sessions.
    pub(super) fn paths(&self, names: &[String]) -> Result<Vec<PathBuf>, String> {
        if names.is_empty() {
            return Err("choose at least one".into());
        }
        let known: Vec<String> = self.shared.known(|known| {
            let recordings = known.recordings.iter().map(|listed| &listed.name);
            recordings.chain(known.sessions.iter().map(|begun| &begun.name)).cloned().collect()
        });
        names
            .iter()
            .map(|name| {
                let there = known.contains(name);
                there
                    .then(|| self.folder.join(name))
                    .ok_or_else(|| format!("no recording or session `{name}`"))
            })
            .collect()
    }
}

/// A recording in the folder, by its lines.
fn listed(path: &Path) -> Option<Listed> {
    let name = path.file_name()?.to_str().filter(|name| name.starts_with("rec-") && is_name(name, ".csv"))?;
    let text = std::fs::read_to_string(path).ok()?;
    let rows: Vec<&str> =
        text.lines().filter(|line| line.starts_with(|c: char| c.is_ascii_digit() || c == '-')).collect();
    let lost = text.lines().find_map(|line| line.strip_prefix("# lost_samples: ")?.parse().ok()).unwrap_or(0);
    let seconds = rows.last()?.split(',').next()?.parse().ok()?;
    Some(Listed { name: name.to_owned(), samples: rows.len() as u64, lost, seconds })
}

#[cfg(test)]
mod tests {
    use super::is_name;

    #[test]
    fn only_plain_names_are_files() {
        assert!(is_name("rec-001.csv", ".csv"));
        for bad in ["../rec.csv", "a/b.csv", ".csv", "rec.csv.csv", "rec.txt", "rec%2f.csv", ""] {
            assert!(!is_name(bad, ".csv"), "{bad}");
        }
    }
}
