//! Builds the firmware of this workspace with a toolchain that has the target.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// The target of the firmware.
pub const TARGET: &str = "thumbv7em-none-eabihf";
const PACKAGE: &str = "tribos-firmware";
/// A toolchain linked under this name is tried when the current one lacks the target (.ci/thumb-toolchain.sh).
const FALLBACK: &str = "thumb";

/// Reason why there is no image.
#[derive(Debug, thiserror::Error)]
pub enum BuildError {
    /// Neither the current toolchain nor the fallback can build for the target.
    #[error(
        "no toolchain for {TARGET}: `rustup target add {TARGET}`, or link one as `{FALLBACK}` (.ci/thumb-toolchain.sh)"
    )]
    NoToolchain,
    /// The build failed, with messages of cargo.
    #[error("the firmware did not build (cargo's messages are above)")]
    Failed,
}

/// The reason why the firmware cannot be built here, if there is one.
#[must_use]
pub fn missing(root: &Path) -> Option<String> {
    toolchain(root).err().map(|why| why.to_string())
}

/// The first toolchain that has the target; `None` is the current one.
fn toolchain(root: &Path) -> Result<Option<&'static str>, BuildError> {
    [None, Some(FALLBACK)].into_iter().find(|t| has_target(root, *t)).ok_or(BuildError::NoToolchain)
}

/// Builds the firmware of the workspace at `root` in release, below `target`, and returns the path of the ELF.
///
/// Uses its own build directory (`target/thumb`), because the outer `cargo test` holds the lock of `target`.
///
/// # Errors
/// No toolchain has the target, or the build fails.
pub fn build(root: &Path, target: &Path) -> Result<PathBuf, BuildError> {
    build_bin(root, target, PACKAGE)
}

/// Builds another binary of the firmware's package.
///
/// # Errors
/// No toolchain has the target, or the build fails.
pub fn build_bin(root: &Path, target: &Path, bin: &str) -> Result<PathBuf, BuildError> {
    Ok(build_one(root, target, &["--bin", bin])?.join(bin))
}

/// Builds the firmware with cargo features, comma between. It has the path of the one without.
///
/// # Errors
/// No toolchain has the target, or the build fails.
pub fn build_with(root: &Path, target: &Path, features: &str) -> Result<PathBuf, BuildError> {
    Ok(build_one(root, target, &["--bin", PACKAGE, "--features", features])?.join(PACKAGE))
}

/// Builds an example of the firmware's package.
///
/// # Errors
/// No toolchain has the target, or the build fails.
pub fn build_example(root: &Path, target: &Path, example: &str) -> Result<PathBuf, BuildError> {
    Ok(build_one(root, target, &["--example", example])?.join("examples").join(example))
}

/// Builds with these cargo arguments. Returns the directory of the profile.
fn build_one(root: &Path, target: &Path, what: &[&str]) -> Result<PathBuf, BuildError> {
    let toolchain = toolchain(root)?;
    let target = target.join("thumb");
    let built = command(root, "cargo", toolchain)
        .args(["build", "--release", "--target", TARGET, "--package", PACKAGE])
        .args(what)
        .env("CARGO_TARGET_DIR", &target)
        .status()
        .is_ok_and(|status| status.success());
    if !built {
        return Err(BuildError::Failed);
    }
    Ok(target.join(TARGET).join("release"))
}

/// A tool of a toolchain, without the environment variables of the outer cargo.
fn command(root: &Path, tool: &str, toolchain: Option<&str>) -> Command {
    let mut command = Command::new(tool);
    command.current_dir(root).stdin(Stdio::null());
    for (key, _) in std::env::vars_os() {
        let name = key.to_string_lossy();
        let of_cargo = name.starts_with("CARGO") && name != "CARGO_HOME" && name != "CARGO_BUILD_JOBS";
        if of_cargo || name.starts_with("RUSTC") || name.starts_with("RUSTFLAGS") || name == "RUSTDOC" {
            command.env_remove(&key);
        }
    }
    if let Some(toolchain) = toolchain {
        command.env("RUSTUP_TOOLCHAIN", toolchain);
    }
    command
}

fn has_target(root: &Path, toolchain: Option<&str>) -> bool {
    let asked = command(root, "rustc", toolchain)
        .args(["--print", "target-libdir", "--target", TARGET])
        .stderr(Stdio::null())
        .output();
    asked.is_ok_and(|output| {
        let path = String::from_utf8_lossy(&output.stdout);
        output.status.success()
            && std::fs::read_dir(path.trim()).is_ok_and(|mut files| files.next().is_some())
    })
}
