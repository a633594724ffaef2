//! What every request can reach.

use crate::bench::{Shared, ToBench};
use crate::guard::Guard;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::AtomicU64;
use std::sync::mpsc::Sender;
use std::time::Instant;

/// What every request can reach.
#[derive(Clone)]
pub(crate) struct App {
    pub shared: Shared,
    pub bench: Sender<ToBench>,
    pub guard: Arc<Guard>,
    pub folder: PathBuf,
    pub tools: Arc<dyn crate::Tools>,
    pub pages: Arc<AtomicU64>,
    /// Zero of the clock that batches carry.
    pub began: Instant,
}
