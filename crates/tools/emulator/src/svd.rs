//! Registers of the chip by the vendor's description: address, reset value and fields.
//!
//! The crate `stm32g4` is generated from the SVD file of the vendor, and shares neither tables nor code with `stm32-metapac`, by
//! which the firmware is built. Its types do not tell their fields to a program, so its sources are read as the table that they
//! are.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Module of the chip in the crate.
const CHIP: &str = "stm32g474";

/// Values after a reset that the description has wrong: of another chip, or beyond the fields of the register. Those of the register's
/// page in [rm0440] stand here.
const RESETS: [(&str, &str, u32); 4] =
    [("RCC", "CR", 0x500), ("FLASH", "ACR", 0x0004_0600), ("TIM3", "ARR", 0xffff), ("TIM4", "ARR", 0xffff)];

/// A field of a register.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Field {
    /// Name, upper case.
    pub name: String,
    /// Bits of the register.
    pub mask: u32,
}

/// A register.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Register {
    /// Name of the peripheral.
    pub peripheral: String,
    /// Name of the register, upper case.
    pub name: String,
    /// Address.
    pub address: u32,
    /// Value after a reset.
    pub reset: u32,
    /// Fields, as far as they can be read or written.
    pub fields: Vec<Field>,
}

impl Register {
    /// Bits of all fields. The others are reserved.
    #[must_use]
    pub fn mask(&self) -> u32 {
        self.fields.iter().fold(0, |mask, field| mask | field.mask)
    }
}

/// All registers that the vendor's description gives one by one, which leaves out the channels of a DMA controller; with the
/// corrected resets.
///
/// # Errors
/// Cargo does not have the crate, or its sources do not look like those of version 0.16.
pub fn registers() -> Result<Vec<Register>, String> {
    let chip = source()?.join(CHIP);
    let mut all = Vec::new();
    for line in text(&chip.join("mod.rs"))?.lines() {
        let Some((name, rest)) = between(line, "pub type ", " = crate::Periph<") else { continue };
        let (block, address) = rest.split_once("::RegisterBlock, 0x").ok_or("no address of a peripheral")?;
        let base = hexadecimal(address.trim_end_matches(">;"))?;
        peripheral(&chip, name, block, base, &mut all)?;
    }
    if all.len() < 500 {
        return Err(format!(
            "{} registers in {}: not the sources of version 0.16",
            all.len(),
            chip.display()
        ));
    }
    for (peripheral, name, reset) in RESETS {
        let wrong = all.iter_mut().find(|r| r.peripheral == peripheral && r.name == name && r.reset != reset);
        wrong
            .ok_or(format!("{peripheral} {name} has no other reset value than {reset:#x} any more"))?
            .reset = reset;
    }
    Ok(all)
}

/// Directory of the sources of the crate.
fn source() -> Result<PathBuf, String> {
    let manifest = concat!(env!("CARGO_MANIFEST_DIR"), "/Cargo.toml");
    let output = Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()))
        .args(["metadata", "--format-version", "1", "--filter-platform", "x86_64-unknown-linux-gnu"])
        .args(["--manifest-path", manifest])
        .output()
        .map_err(|why| format!("cargo metadata: {why}"))?;
    let told: serde_json::Value = serde_json::from_slice(&output.stdout)
        .map_err(|_| format!("cargo metadata: {}", String::from_utf8_lossy(&output.stderr)))?;
    let packages = told["packages"].as_array().ok_or("cargo metadata names no packages")?;
    let package = packages.iter().find(|package| package["name"] == "stm32g4").ok_or("no crate stm32g4")?;
    let manifest = package["manifest_path"].as_str().ok_or("cargo metadata names no manifest")?;
    Ok(Path::new(manifest).with_file_name("src"))
}

fn text(path: &Path) -> Result<String, String> {
    std::fs::read_to_string(path).map_err(|why| format!("{}: {why}", path.display()))
}

/// What stands between `before`, with which the line begins, and `after`; and the rest.
fn between<'a>(line: &'a str, before: &str, after: &str) -> Option<(&'a str, &'a str)> {
    line.trim_start().strip_prefix(before)?.split_once(after)
}

fn hexadecimal(digits: &str) -> Result<u32, String> {
    u32::from_str_radix(&digits.replace('_', ""), 16).map_err(|why| format!("{digits}: {why}"))
}

/// Adds the registers of a peripheral.
fn peripheral(
    chip: &Path,
    name: &str,
    block: &str,
    base: u32,
    all: &mut Vec<Register>,
) -> Result<(), String> {
    let listing = text(&chip.join(block).with_extension("rs"))?;
    // modules of registers, by type
    let mut modules = BTreeMap::new();
    for line in listing.lines() {
        if let Some((of, rest)) = between(line, "pub type ", " = crate::Reg<")
            && let Some((module, _)) = rest.split_once("::")
        {
            modules.insert(of, (block, module));
        } else if let Some(path) = line.strip_prefix("pub use crate::stm32g474::")
            && let Some((other, of)) = path.trim_end_matches(';').split_once("::")
            && of.starts_with(|c: char| c.is_uppercase())
        {
            // a register of another peripheral; its module has the name in lower case
            modules.insert(of, (other, ""));
        } else if let Some((of, alias)) = between(line, "pub use ", " as ") {
            let alias = alias.trim_end_matches(';');
            if let Some(&same) = modules.get(of) {
                modules.insert(alias, same);
            }
        }
    }
    let mut offset = None;
    for line in listing.lines() {
        if let Some((digits, _)) = between(line, "///0x", " - ") {
            // of an array, then of each of its elements
            offset = if digits.contains("..") { None } else { Some(hexadecimal(digits)?) };
        } else if let Some((function, rest)) = between(line, "pub const fn ", "(&self) -> &")
            && let Some(offset) = offset.take()
        {
            let of = rest.trim_end_matches(" {");
            let Some(&(block, module)) = modules.get(of) else { continue };
            let module = if module.is_empty() { of.to_lowercase() } else { module.to_owned() };
            let path = chip.join(block).join(module).with_extension("rs");
            let (reset, fields) =
                register(&text(&path)?).map_err(|why| format!("{}: {why}", path.display()))?;
            all.push(Register {
                peripheral: name.to_owned(),
                name: function.to_uppercase(),
                address: base + offset,
                reset,
                fields,
            });
        }
    }
    Ok(())
}

/// Reset value and fields of a register.
fn register(listing: &str) -> Result<(u32, Vec<Field>), String> {
    let mut reset = 0;
    let mut fields: Vec<Field> = Vec::new();
    let mut mask = None;
    for line in listing.lines() {
        if let Some((_, value)) = line.split_once("const RESET_VALUE: u")
            && let Some((_, value)) = value.split_once(" = ")
        {
            let value = value.trim_end_matches(';');
            reset = match value.strip_prefix("0x") {
                Some(digits) => hexadecimal(digits)?,
                None => value.parse().map_err(|why| format!("{value}: {why}"))?,
            };
        } else if let Some((bits, _)) =
            between(line, "///Bits ", " - ").or_else(|| between(line, "///Bit ", " - "))
        {
            let (low, high) = bits.split_once(':').unwrap_or((bits, bits));
            // of an array, or of one field
            mask = match (low.parse::<u32>(), high.parse::<u32>()) {
                (Ok(low), Ok(high)) if low <= high && high < 32 => {
                    Some(u32::MAX >> (31 - (high - low)) << low)
                }
                _ => None,
            };
        } else if let Some((name, _)) = between(line, "pub fn ", "(&")
            && let Some(mask) = mask.take()
        {
            let field = Field { name: name.to_uppercase(), mask };
            if !fields.contains(&field) {
                fields.push(field);
            }
        }
    }
    Ok((reset, fields))
}
