//! Long work on a thread of its own, without the GIL: the interpreter goes on, shows progress and hears Ctrl-C.

use procedures::{Activity, Watch};
use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use std::ops::ControlFlow;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

/// How long Ctrl-C may wait, and how often progress is shown.
const POLL: Duration = Duration::from_millis(50);

/// What work tells the interpreter, and hears from it.
#[derive(Debug, Clone, Default)]
pub(crate) struct Watched(Arc<Shared>);

#[derive(Debug, Default)]
struct Shared {
    stop: AtomicBool,
    progress: Mutex<Option<(f32, String)>>,
}

impl Watched {
    /// Notes progress; `Break` after Ctrl-C.
    pub fn tell(&self, share: f32, what: &str) -> ControlFlow<()> {
        let mut progress = self.0.progress.lock().unwrap_or_else(PoisonError::into_inner);
        let what = match (what, progress.take()) {
            ("", Some((_, held))) => held,
            _ => what.to_owned(),
        };
        *progress = Some((share, what));
        if self.is_interrupted() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }

    fn latest(&self) -> Option<(f32, String)> {
        self.0.progress.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }
}

impl Watch for Watched {
    fn begin(&self, what: &str) -> Box<dyn Activity> {
        let _ = self.tell(0.0, what);
        Box::new(self.clone())
    }

    fn listen(&self) {}

    fn is_interrupted(&self) -> bool {
        self.0.stop.load(Ordering::Relaxed)
    }
}

impl Activity for Watched {
    fn set(&self, share: f32, what: &str) {
        let _ = self.tell(share, what);
    }
}

/// Runs `job` without the GIL and returns what it returns. `progress` is called with the share done, 0 to 1, and what is being
/// done. Ctrl-C, or an exception of `progress`, is raised at once; the job is told and ends at its next step.
///
/// # Errors
/// What was raised meanwhile. A panic of the job, which is a bug, is a `RuntimeError`.
pub(crate) fn run<T: Send + 'static>(
    py: Python<'_>,
    progress: Option<&Bound<'_, PyAny>>,
    job: impl FnOnce(&Watched) -> T + Send + 'static,
) -> PyResult<T> {
    let watched = Watched::default();
    let (send, mut receive) = channel();
    let told = watched.clone();
    std::thread::Builder::new()
        .name("tribos".into())
        .spawn(move || {
            let _ = send.send(catch_unwind(AssertUnwindSafe(|| job(&told))));
        })
        .map_err(|e| PyRuntimeError::new_err(format!("no thread to work on: {e}")))?;
    let mut shown = None;
    let show = |last: &mut Option<(f32, String)>| -> PyResult<()> {
        let latest = watched.latest();
        if let (Some(progress), Some((share, what))) = (progress, &latest)
            && *last != latest
        {
            progress.call1((*share, what))?;
            *last = latest;
        }
        Ok(())
    };
    loop {
        let answer;
        (receive, answer) = py.detach(move || {
            let answer = receive.recv_timeout(POLL);
            (receive, answer)
        });
        let heard = py.check_signals().and_then(|()| show(&mut shown));
        if let Err(raised) = heard {
            watched.0.stop.store(true, Ordering::Relaxed);
            return Err(raised);
        }
        match answer {
            Ok(Ok(value)) => return Ok(value),
            Ok(Err(_)) | Err(RecvTimeoutError::Disconnected) => {
                return Err(PyRuntimeError::new_err(
                    "a bug in tribos ended the work; please report it with the recording",
                ));
            }
            Err(RecvTimeoutError::Timeout) => {}
        }
    }
}
