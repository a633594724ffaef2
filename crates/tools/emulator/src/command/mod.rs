//! The commands, and the image they run.

pub mod record;
pub mod report;
pub mod run;

use emulator::{Image, firmware};
use std::path::{Path, PathBuf};

/// The image in this file or, without one, the firmware of this workspace, built now.
///
/// # Errors
/// One line: the file cannot be read, is no image, or the build fails.
fn image(elf: Option<&Path>) -> Result<Image, String> {
    let path = match elf {
        Some(path) => path.to_owned(),
        None => build()?,
    };
    let bytes = std::fs::read(&path).map_err(|e| format!("{}: {e}", path.display()))?;
    Image::parse(&bytes).map_err(|e| format!("{}: {e}", path.display()))
}

fn build() -> Result<PathBuf, String> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../..");
    // …/target/release/emulator: below the target directory that cargo was told to use
    let own = std::env::current_exe().map_err(|e| e.to_string())?;
    let target = own.ancestors().nth(2).ok_or("this program is outside a target directory: name an ELF")?;
    eprintln!("building the firmware");
    firmware::build(&root, target).map_err(|e| e.to_string())
}
