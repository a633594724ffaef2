//! Flash of the virtual device for presets, in memory or in a file.

use crate::presets::{Medium, Refused};
use embedded_storage_async::nor_flash::{ErrorType, NorFlash, ReadNorFlash};
use std::fs::{File, OpenOptions};
use std::io::{Read, Seek, SeekFrom, Write};
use std::path::Path;

/// Size of a page, bytes.
pub const PAGE: usize = 2048;
/// Size of the flash for presets, bytes, as on the board.
pub const BYTES: usize = 5 * PAGE;

/// Pages of erasable double words.
#[derive(Debug)]
pub struct SimulatedFlash {
    bytes: Vec<u8>,
    file: Option<(File, String)>,
}

impl Default for SimulatedFlash {
    /// Erased, in memory.
    fn default() -> Self {
        Self { bytes: vec![0xff; BYTES], file: None }
    }
}

impl SimulatedFlash {
    /// With these contents, in memory. The rest is erased.
    #[must_use]
    pub fn of(contents: &[u8]) -> Self {
        let mut flash = Self::default();
        for (to, from) in flash.bytes.iter_mut().zip(contents) {
            *to = *from;
        }
        flash
    }

    /// In a file, which is created if needed.
    ///
    /// # Errors
    /// The file cannot be opened for reading and writing, or is not a flash.
    pub fn open(path: &Path) -> std::io::Result<Self> {
        let mut file = OpenOptions::new().read(true).write(true).create(true).truncate(false).open(path)?;
        let mut bytes = Vec::new();
        (&mut file).take(BYTES as u64 + 1).read_to_end(&mut bytes)?;
        match bytes.len() {
            0 => {
                bytes.resize(BYTES, 0xff);
                file.write_all(&bytes)?;
            }
            BYTES => {}
            other => {
                return Err(std::io::Error::other(format!(
                    "{} bytes: expected a file of the virtual device, {BYTES} bytes, or a new name",
                    if other > BYTES { "too many".into() } else { other.to_string() }
                )));
            }
        }
        Ok(Self { bytes, file: Some((file, path.display().to_string())) })
    }

    /// Lifetime of stored presets.
    pub(super) fn lasting(&self) -> String {
        match &self.file {
            Some((_, name)) => format!("in {name}"),
            None => "until the device restarts".into(),
        }
    }

    /// All contents.
    #[must_use]
    pub fn contents(&self) -> &[u8] {
        &self.bytes
    }

    fn change(&mut self, offset: u32, new: impl Fn(usize, &mut u8), count: usize) -> Result<(), Refused> {
        let from = offset as usize;
        let bytes = self.bytes.get_mut(from..from + count).ok_or(Refused)?;
        bytes.iter_mut().enumerate().for_each(|(at, byte)| new(at, byte));
        let Some((file, _)) = &mut self.file else { return Ok(()) };
        let written = file.seek(SeekFrom::Start(u64::from(offset))).and_then(|_| file.write_all(bytes));
        written.and_then(|()| file.flush()).map_err(|_| Refused)
    }
}

impl ErrorType for SimulatedFlash {
    type Error = Refused;
}

impl ReadNorFlash for SimulatedFlash {
    const READ_SIZE: usize = 8;

    async fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), Refused> {
        let from = offset as usize;
        bytes.copy_from_slice(self.bytes.get(from..from + bytes.len()).ok_or(Refused)?);
        Ok(())
    }

    fn capacity(&self) -> usize {
        self.bytes.len()
    }
}

impl NorFlash for SimulatedFlash {
    const WRITE_SIZE: usize = 8;
    const ERASE_SIZE: usize = PAGE;

    async fn erase(&mut self, from: u32, to: u32) -> Result<(), Refused> {
        let count = to.checked_sub(from).ok_or(Refused)? as usize;
        if !(from as usize).is_multiple_of(PAGE) || !count.is_multiple_of(PAGE) {
            return Err(Refused);
        }
        self.change(from, |_, byte| *byte = 0xff, count)
    }

    async fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), Refused> {
        if !offset.is_multiple_of(8) || !bytes.len().is_multiple_of(8) {
            return Err(Refused);
        }
        // like the board: a programmed double word accepts only zeros
        for (at, word) in bytes.chunks_exact(8).enumerate() {
            let held =
                self.bytes.get(offset as usize + 8 * at..).and_then(|rest| rest.get(..8)).ok_or(Refused)?;
            if held.iter().any(|byte| *byte != 0xff) && word.iter().any(|byte| *byte != 0) {
                return Err(Refused);
            }
        }
        self.change(offset, |at, byte| *byte &= bytes[at], bytes.len())
    }
}

impl Medium for SimulatedFlash {
    /// Writes the file completely or not at all.
    async fn is_torn(&mut self, _: u32) -> Result<bool, Refused> {
        Ok(false)
    }
}
