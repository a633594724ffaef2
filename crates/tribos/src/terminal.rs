//! Terminal side of a procedure: progress bars, and Ctrl-C, which ends and keeps a recording.

use crate::failure::{Failure, Result};
use crate::progress::Progress;
use client::{Error, Plan, Recorded, Session};
use procedures::{Activity, Watch};
use std::io::{BufRead, IsTerminal, Write};
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

/// Makes sure that the device knows the middle of its stroke before it moves. A real device searches its stops if `yes`, or if
/// the person at the terminal says so.
///
/// # Errors
/// Nobody allows the search, or it fails.
pub(crate) fn reference(session: &mut Session, yes: bool) -> Result<()> {
    let name = session.name().to_owned();
    match client::reference(session, &mut || yes || is_allowed(&name)) {
        Ok(None) => Ok(()),
        Ok(Some(told)) => {
            eprintln!("{name}: {told}");
            Ok(())
        }
        Err(error @ Error::Unreferenced { .. }) => {
            let by_hand = error.help().unwrap_or_default();
            Err(Failure::new(error).help(format!("--yes lets it search both stops, hands off; or {by_hand}")))
        }
        Err(error) => Err(error.into()),
    }
}

/// Asks the person at the terminal, if there is one.
fn is_allowed(name: &str) -> bool {
    if !(std::io::stdin().is_terminal() && std::io::stderr().is_terminal()) {
        return false;
    }
    eprint!(
        "{name} does not know the middle of its stroke since it started.\n\
         It can search both stops: slowly, with limited force, hands off. Search now? [y/N] "
    );
    let _ = std::io::stderr().flush();
    let mut answer = String::new();
    std::io::stdin()
        .lock()
        .read_line(&mut answer)
        .is_ok_and(|_| matches!(answer.trim().to_ascii_lowercase().as_str(), "y" | "yes"))
}

/// Tells the person at the terminal what to do, and waits for Enter.
///
/// # Errors
/// Nobody is there.
pub(crate) fn enter(what: &str) -> Result<()> {
    if !(std::io::stdin().is_terminal() && std::io::stderr().is_terminal()) {
        return Err(Failure::new(format!("{what}: nobody at the terminal to say that it is so")));
    }
    eprint!("{what}; then Enter ");
    let _ = std::io::stderr().flush();
    std::io::stdin().lock().read_line(&mut String::new()).map_err(Failure::new)?;
    Ok(())
}
