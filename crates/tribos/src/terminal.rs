//! Terminal side of a procedure: progress bars, and Ctrl-C, which ends and keeps a recording.

use crate::failure::Result;
use crate::progress::Progress;
use client::{Plan, Recorded, Session};
use procedures::{Activity, Watch};
use std::path::Path;
use std::sync::OnceLock;
use std::sync::atomic::{AtomicBool, Ordering};

/// Ctrl-C was pressed since [`Terminal::listen`].
static INTERRUPTED: AtomicBool = AtomicBool::new(false);

/// Standard error and Ctrl-C.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Terminal;

impl Watch for Terminal {
    fn begin(&self, what: &str) -> Box<dyn Activity> {
        Box::new(Progress::new(what))
    }

    fn listen(&self) {
        static HANDLER: OnceLock<()> = OnceLock::new();
        HANDLER.get_or_init(|| {
            // without a handler Ctrl-C still ends the process, and the .part file remains readable
            let _ = ctrlc::set_handler(|| INTERRUPTED.store(true, Ordering::SeqCst));
        });
        INTERRUPTED.store(false, Ordering::SeqCst);
    }

    fn is_interrupted(&self) -> bool {
        INTERRUPTED.load(Ordering::SeqCst)
    }
}

impl Activity for Progress {
    fn set(&self, share: f32, what: &str) {
        Self::set(self, share, what);
    }
}

/// Runs the plan and writes `path`.
///
/// # Errors
/// Those of [`client::record`].
pub(crate) fn record(session: &mut Session, plan: &Plan, path: &Path) -> Result<Recorded> {
    Ok(procedures::record(session, plan, path, &Terminal)?)
}
