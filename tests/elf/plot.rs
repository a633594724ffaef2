//! Pictures of the ELF tests: into the directory `PLOTS` names, else below the target directory.

use report::picture::{Panel, Picture, svg};
use std::path::{Path, PathBuf};

/// Writes panels side by side; where to.
pub fn write(name: &str, panels: Vec<Panel>) -> PathBuf {
    let directory = std::env::var_os("PLOTS").map_or_else(
        || PathBuf::from(env!("CARGO_TARGET_TMPDIR")),
        |plots| Path::new(env!("CARGO_MANIFEST_DIR")).join(plots),
    );
    std::fs::create_dir_all(&directory).expect("a directory for the plots");
    let path = directory.join(format!("{name}.svg"));
    std::fs::write(&path, svg(&Picture::of(panels)).expect("a drawing")).expect("room for a plot");
    path
}
