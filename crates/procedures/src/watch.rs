//! How a procedure shows its progress, and is interrupted.

#[cfg(feature = "device")]
use client::{Error, Plan, Recorded, Session};
#[cfg(feature = "device")]
use std::{ops::ControlFlow, path::Path};

/// Who watches a procedure: a terminal, a page, or nobody.
pub trait Watch {
    /// Something begins that may take over a second; it ends when the returned value is dropped.
    fn begin(&self, what: &str) -> Box<dyn Activity>;

    /// From now on an interruption is asked for with [`Watch::is_interrupted`]; earlier ones are forgotten.
    fn listen(&self);

    /// Whether to end early and keep what there is.
    fn is_interrupted(&self) -> bool;
}

/// Something that takes its time.
pub trait Activity {
    /// The share that is done, 0 to 1, and what is being done; without words it is what it was.
    fn set(&self, share: f32, what: &str);
}

/// Nobody watches, and nobody interrupts.
#[derive(Debug, Clone, Copy, Default)]
pub struct Unwatched;

impl Watch for Unwatched {
    fn begin(&self, _: &str) -> Box<dyn Activity> {
        Box::new(Self)
    }

    fn listen(&self) {}

    fn is_interrupted(&self) -> bool {
        false
    }
}

impl Activity for Unwatched {
    fn set(&self, _: f32, _: &str) {}
}

/// Records a device, watched; see [`client::record`].
///
/// # Errors
/// Those of [`client::record`].
#[cfg(feature = "device")]
pub fn record(session: &mut Session, plan: &Plan, path: &Path, watch: &dyn Watch) -> Result<Recorded, Error> {
    watch.listen();
    let activity = watch.begin("recording");
    client::record(session, plan, path, &mut |share| {
        activity.set(share, "");
        if watch.is_interrupted() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    })
}
