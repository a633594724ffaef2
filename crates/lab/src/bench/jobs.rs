//! Jobs that compute while the device runs.

use super::{Bench, ToBench};
use crate::known::{Done, Job};
use crate::tools::Found;
use std::ops::ControlFlow;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// Shortest interval between two progress messages.
const STEP: Duration = Duration::from_millis(100);

impl Bench {
    /// Starts an analysis of these recordings.
    pub(super) fn analyse(&mut self, kind: &'static str, names: &[String]) -> Result<(), String> {
        self.start_job(kind, names, false)
    }

    /// Starts an analysis; that of a handover is of a body on the handle.
    pub(super) fn start_job(
        &mut self,
        kind: &'static str,
        names: &[String],
        handover: bool,
    ) -> Result<(), String> {
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
        // each job has its own flag: cancelling one does not cancel the next
        let cancel = Arc::new(AtomicBool::new(false));
        self.cancel = cancel.clone();
        let (tools, own, file) = (self.tools.clone(), self.own.clone(), self.folder.join(&report));
        let work = move || {
            let told = std::cell::Cell::new(Instant::now());
            let progress = |share: f32, says: &str| {
                if told.get().elapsed() > STEP {
                    told.set(Instant::now());
                    // nobody listens at the end
                    let _ = own.send(ToBench::Progress(share, says.to_owned()));
                }
                if cancel.load(Ordering::Relaxed) {
                    ControlFlow::Break(())
                } else {
                    ControlFlow::Continue(())
                }
            };
            let not_a_body = || paths.iter().find_map(|path| tools.not_a_body(path).transpose());
            let refused = if handover { not_a_body() } else { None };
            let found = match kind {
                _ if refused.is_some() => refused.unwrap_or_else(|| Ok(String::new())).and_then(Err),
                "identify" => tools.identify(&paths, &file, &progress),
                "analyse" => tools.analyse(&paths, &file, &progress),
                _ => tools.diagnose(&paths, &file, &progress),
            };
            let cancelled = || Err("cancelled: nothing was found and nothing was changed".to_owned());
            let found = if cancel.load(Ordering::Relaxed) { cancelled() } else { found };
            let failed = found.is_err();
            let handed = handover.then(|| Box::new(found.clone()));
            let done = found.unwrap_or_else(|text| Found { text, ..Found::default() });
            let Found { text, preset, tables, .. } = done;
            let report = (!failed).then_some(report);
            let done = Done { kind, of, text, failed, report, preset, tables };
            let _ = own.send(ToBench::Finished(Box::new(done), handed));
        };
        std::thread::Builder::new().name(kind.into()).spawn(work).map(|_| ()).map_err(|e| {
            self.shared.known(|known| known.job = None);
            format!("no thread for it: {e}")
        })
    }

    /// Asks the job that runs to end without a result.
    pub(super) fn cancel(&mut self) -> Result<(), String> {
        let running = self.shared.known(|known| {
            if let Some(job) = &mut known.job {
                job.says = "cancelling".into();
            }
            known.job.is_some()
        });
        self.cancel.store(true, Ordering::Relaxed);
        self.dirty = true;
        if running { Ok(()) } else { Err("no analysis is running".into()) }
    }
}
