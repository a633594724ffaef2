//! Jobs that compute while the device runs.

use super::{Bench, ToBench};
use crate::known::{Done, Job};
use std::time::{Duration, Instant};

/// Shortest interval between two progress messages.
const STEP: Duration = Duration::from_millis(100);

impl Bench {
    /// Starts an analysis of these recordings.
    pub(super) fn analyse(&mut self, kind: &'static str, names: &[String]) -> Result<(), String> {
        if self.shared.known(|known| known.job.is_some()) {
            return Err("one analysis is running: wait for it".into());
        }
        let paths = self.paths(names)?;
        let first = names.first().map_or("", |name| name.trim_end_matches(".csv").trim_end_matches(".jsonl"));
        let more = if names.len() > 1 { format!("-and-{}", names.len() - 1) } else { String::new() };
        let report = format!("{kind}-{first}{more}.html");
        let of = names.join(", ");
        let job = Job { kind, of: of.clone(), share: 0.0, says: "reading".into() };
        self.shared.known(|known| known.job = Some(job));
        self.dirty = true;
        let (tools, own, file) = (self.tools.clone(), self.own.clone(), self.folder.join(&report));
        let work = move || {
            let told = std::cell::Cell::new(Instant::now());
            let progress = |share: f32, says: &str| {
                if told.get().elapsed() > STEP {
                    told.set(Instant::now());
                    // nobody listens at the end
                    let _ = own.send(ToBench::Progress(share, says.to_owned()));
                }
            };
            let found = match kind {
                "identify" => tools.identify(&paths, &file, &progress),
                "analyse" => tools.analyse(&paths, &file, &progress),
                _ => tools.diagnose(&paths, &file, &progress),
            };
            let done = match found {
                Ok(found) => Done {
                    kind,
                    of,
                    text: found.text,
                    failed: false,
                    report: Some(report),
                    preset: found.preset,
                    tables: found.tables,
                },
                Err(why) => Done {
                    kind,
                    of,
                    text: why,
                    failed: true,
                    report: None,
                    preset: Vec::new(),
                    tables: Vec::new(),
                },
            };
            let _ = own.send(ToBench::Finished(Box::new(done)));
        };
        std::thread::Builder::new().name(kind.into()).spawn(work).map(|_| ()).map_err(|e| {
            self.shared.known(|known| known.job = None);
            format!("no thread for it: {e}")
        })
    }
}
