//! What tests need from outside the repository.

use std::path::{Path, PathBuf};
use std::sync::OnceLock;

/// Something outside the repository, looked for once a run.
#[derive(Debug)]
pub struct Need {
    probe: fn() -> Option<String>,
    missing: OnceLock<Option<String>>,
    spared_in_ci: bool,
}

impl Need {
    /// `probe` gives the reason why the tests cannot run here, in few words.
    #[must_use]
    pub const fn new(probe: fn() -> Option<String>) -> Self {
        Self { probe, missing: OnceLock::new(), spared_in_ci: false }
    }

    /// Its tests are ignored without it even with `CI` set, because not every machine can install it.
    #[must_use]
    pub const fn spared_in_ci(mut self) -> Self {
        self.spared_in_ci = true;
        self
    }

    pub(crate) fn is_spared_in_ci(&self) -> bool {
        self.spared_in_ci
    }

    /// The reason why the tests cannot run here.
    #[must_use]
    pub fn missing(&self) -> Option<&str> {
        self.missing.get_or_init(self.probe).as_deref()
    }
}

/// A file or folder of recordings, beside the repository in `../shared/data`.
///
/// # Errors
/// Why tests of it cannot run.
pub fn recordings(name: &str) -> Result<PathBuf, String> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../../shared/data").join(name);
    if path.exists() { Ok(path) } else { Err(format!("no recordings in ../shared/data/{name}")) }
}
