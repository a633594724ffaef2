//! The ELF as a programmer sees it: contents of the flash, and a few symbols.

use crate::adc::FACTORY_REFERENCE;
use object::read::elf::ProgramHeader;
use object::{Object, ObjectSection, ObjectSymbol, SectionKind, SymbolKind};
use std::collections::BTreeMap;

pub(crate) const FLASH_BASE: u32 = 0x0800_0000;
pub(crate) const FLASH_SIZE: u32 = 512 * 1024;
/// CCM SRAM, as the core fetches from it.
pub(crate) const CCM_BASE: u32 = 0x1000_0000;
pub(crate) const CCM_SIZE: u32 = 32 * 1024;
pub(crate) const CCM_END: u32 = CCM_BASE + CCM_SIZE;
pub(crate) const RAM_BASE: u32 = 0x2000_0000;
pub(crate) const RAM_SIZE: u32 = 96 * 1024;
pub(crate) const RAM_END: u32 = RAM_BASE + RAM_SIZE;
/// Memory that the factory writes, of the bank that the chip boots from.
pub(crate) const SYSTEM_BASE: u32 = 0x1fff_0000;
pub(crate) const SYSTEM_SIZE: u32 = 64 * 1024;
/// Where it holds the reading of the internal reference [ds12288, "Embedded internal voltage reference"].
const FACTORY_REFERENCE_AT: usize = 0x75aa;

/// What the factory writes: of its calibrations the one that the firmware reads.
pub fn system_memory() -> Vec<u8> {
    let mut memory = vec![0; SYSTEM_SIZE as usize];
    memory[FACTORY_REFERENCE_AT..][..2].copy_from_slice(&FACTORY_REFERENCE.to_le_bytes());
    memory
}

/// An image that cannot be run.
#[derive(Debug, thiserror::Error)]
pub enum ImageError {
    /// Not an ELF.
    #[error("not an ELF file: {0}")]
    NotElf(#[from] object::Error),
    /// An ELF for another target.
    #[error("an ELF, but not a 32-bit one for ARM")]
    WrongMachine,
    /// Part of it lies outside the flash of the STM32G474RE.
    #[error("{size} bytes at {address:#010x} are outside the flash (0x08000000, 512 KiB)")]
    OutsideFlash {
        /// Physical address.
        address: u32,
        /// Bytes.
        size: usize,
    },
    /// No vector table.
    #[error("no vector table at 0x08000000")]
    NoVectors,
}

/// A parsed firmware image.
#[derive(Debug, Clone)]
pub struct Image {
    pub(crate) flash: Vec<(u32, Vec<u8>)>,
    /// Contents of CCM SRAM once the firmware has copied them.
    pub(crate) ccm: Vec<(u32, Vec<u8>)>,
    pub(crate) symbols: BTreeMap<String, u32>,
    /// Addresses of the functions, in order.
    pub(crate) functions: Vec<(u32, String)>,
    /// Addresses at which code begins or continues after data, in order.
    pub(crate) code: Vec<u32>,
    /// Number of programmed bytes.
    pub flash_bytes: usize,
    /// Bytes of static data in RAM.
    pub ram_bytes: usize,
}

impl Image {
    /// Parses an ELF.
    ///
    /// # Errors
    /// Not an ELF for this chip.
    pub fn parse(elf: &[u8]) -> Result<Self, ImageError> {
        let object::File::Elf32(file) = object::File::parse(elf)? else {
            return Err(ImageError::WrongMachine);
        };
        if file.architecture() != object::Architecture::Arm {
            return Err(ImageError::WrongMachine);
        }
        let endian = file.endian();
        let (mut flash, mut ccm) = (Vec::new(), Vec::new());
        for header in file.elf_program_headers() {
            let size = header.p_filesz(endian) as usize;
            if header.p_type(endian) != object::elf::PT_LOAD || size == 0 {
                continue;
            }
            let address = header.p_paddr(endian);
            let end = u64::from(address) + size as u64;
            if address < FLASH_BASE || end > u64::from(FLASH_BASE + FLASH_SIZE) {
                return Err(ImageError::OutsideFlash { address, size });
            }
            let data = header.data(endian, elf).map_err(|()| ImageError::OutsideFlash { address, size })?;
            flash.push((address, data.to_vec()));
            let runs_at = header.p_vaddr(endian);
            if (CCM_BASE..CCM_BASE + CCM_SIZE).contains(&runs_at) {
                ccm.push((runs_at, data.to_vec()));
            }
        }
        if !flash.iter().any(|(address, data)| *address == FLASH_BASE && data.len() > 140) {
            return Err(ImageError::NoVectors);
        }
        let ram_bytes = file
            .sections()
            .filter(|s| {
                matches!(s.kind(), SectionKind::Data | SectionKind::UninitializedData)
                    && (u64::from(RAM_BASE)..u64::from(RAM_BASE + RAM_SIZE)).contains(&s.address())
            })
            .map(|s| s.size() as usize)
            .sum();
        let symbols =
            file.symbols().filter_map(|s| Some((s.name().ok()?.to_string(), s.address() as u32))).collect();
        let mut functions: Vec<(u32, String)> = file
            .symbols()
            .filter(|s| s.kind() == SymbolKind::Text && s.address() != 0)
            .filter_map(|s| Some((s.address() as u32 & !1, s.name().ok()?.to_string())))
            .filter(|(_, name)| !name.starts_with('$'))
            .collect();
        functions.sort();
        let mut code: Vec<u32> = file
            .symbols()
            .filter(|s| s.name().is_ok_and(|name| name == "$t" || name.starts_with("$t.")))
            .map(|s| s.address() as u32)
            .collect();
        code.sort_unstable();
        let flash_bytes = flash.iter().map(|(_, data)| data.len()).sum();
        Ok(Self { flash, ccm, symbols, functions, code, flash_bytes, ram_bytes })
    }

    /// Contents of the flash from its first address on.
    #[must_use]
    pub fn flash_contents(&self) -> Vec<u8> {
        let mut contents = Vec::new();
        for (address, data) in &self.flash {
            let begin = (address - FLASH_BASE) as usize;
            contents.resize(contents.len().max(begin + data.len()), 0xff);
            contents[begin..begin + data.len()].copy_from_slice(data);
        }
        contents
    }

    /// Word of the vector table.
    pub(crate) fn vector(&self, index: u32) -> u32 {
        let word = |data: &Vec<u8>| {
            let at = 4 * index as usize;
            data.get(at..at + 4).and_then(|b| b.try_into().ok()).map(u32::from_le_bytes)
        };
        self.flash.iter().find(|(address, _)| *address == FLASH_BASE).and_then(|(_, d)| word(d)).unwrap_or(0)
    }

    pub(crate) fn symbol(&self, name: &str) -> Option<u32> {
        self.symbols.get(name).copied()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn invalid_images_are_refused() {
        for (bytes, says) in
            [(&b""[..], "not an ELF"), (&b"\x7fELF"[..], "not an ELF"), (&[0; 512][..], "not an ELF")]
        {
            let error = Image::parse(bytes).expect_err("refused").to_string();
            assert!(error.contains(says), "{error}");
        }
    }
}
