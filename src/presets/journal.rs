//! A journal of erasures, so that each one completes.
//!
//! A page with an interrupted erasure may look used, half used or empty, and would corrupt the map. Before an erasure the
//! number of the page is written to the journal, and struck out afterwards. [`Journaled::recover`] repeats open erasures.
//!
//! A torn journal page holds no valid entry by chance (64 bits) and is erased again. It is erased only without open entries.

use embedded_storage_async::nor_flash::{ErrorType, NorFlash, ReadNorFlash};

/// Bytes programmed at a time.
const WORD: usize = 8;
const BLANK: [u8; WORD] = [0xff; WORD];
const STRUCK: [u8; WORD] = [0; WORD];

/// A flash of double words that can be overwritten with zeros. Its last page is the journal.
#[allow(async_fn_in_trait)] // polled by one task, never sent
pub trait Medium: NorFlash {
    /// Whether a double word is torn: interrupted while programmed or erased, with a wrong error-correcting code and an unstable
    /// value.
    ///
    /// # Errors
    /// As for reading.
    async fn is_torn(&mut self, offset: u32) -> Result<bool, Self::Error>;
}

/// A flash with a journal of its erasures.
pub struct Journaled<F> {
    flash: F,
}

impl<F: Medium> Journaled<F> {
    const PAGE: u32 = F::ERASE_SIZE as u32;

    /// A flash that is not yet recovered.
    pub fn new(flash: F) -> Self {
        Self { flash }
    }

    /// The underlying flash.
    pub fn into_inner(self) -> F {
        self.flash
    }

    /// Size without the journal, bytes.
    pub fn map_bytes(&self) -> u32 {
        (self.flash.capacity() as u32).saturating_sub(Self::PAGE)
    }

    fn entry(page: u32) -> [u8; WORD] {
        let page = page as u8;
        [b'e', b'r', page, !page, b'a', b's', page, !page]
    }

    /// Offsets of the entries.
    fn entries(&self) -> impl Iterator<Item = u32> + use<F> {
        let from = self.map_bytes();
        (from..from + Self::PAGE).step_by(WORD)
    }

    async fn word(&mut self, offset: u32) -> Result<[u8; WORD], F::Error> {
        let mut word = [0; WORD];
        self.flash.read(offset, &mut word).await?;
        Ok(word)
    }

    /// Completes interrupted operations: repeats open erasures, and sets torn double words to zero, which readers of the map
    /// ignore.
    ///
    /// # Errors
    /// The flash fails.
    pub async fn recover(&mut self) -> Result<(), F::Error> {
        let mut damaged = false;
        for at in self.entries() {
            let word = if self.flash.is_torn(at).await? { None } else { Some(self.word(at).await?) };
            match word {
                Some(BLANK | STRUCK) => {}
                Some(word) if word == Self::entry(u32::from(word[2])) && self.holds(word[2]) => {
                    let from = u32::from(word[2]) * Self::PAGE;
                    self.flash.erase(from, from + Self::PAGE).await?;
                    self.flash.write(at, &STRUCK).await?;
                }
                _ => damaged = true,
            }
        }
        if damaged {
            self.erase_journal().await?;
        }
        for at in (0..self.map_bytes()).step_by(WORD) {
            if self.flash.is_torn(at).await? {
                self.flash.write(at, &STRUCK).await?;
            }
        }
        Ok(())
    }

    fn holds(&self, page: u8) -> bool {
        u32::from(page) * Self::PAGE < self.map_bytes()
    }

    async fn erase_journal(&mut self) -> Result<(), F::Error> {
        let from = self.map_bytes();
        self.flash.erase(from, from + Self::PAGE).await
    }

    async fn free_entry(&mut self) -> Result<u32, F::Error> {
        for at in self.entries() {
            if self.word(at).await? == BLANK {
                return Ok(at);
            }
        }
        self.erase_journal().await?;
        Ok(self.map_bytes())
    }
}

impl<F: ErrorType> ErrorType for Journaled<F> {
    type Error = F::Error;
}

impl<F: Medium> ReadNorFlash for Journaled<F> {
    const READ_SIZE: usize = F::READ_SIZE;

    async fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), Self::Error> {
        self.flash.read(offset, bytes).await
    }

    fn capacity(&self) -> usize {
        self.map_bytes() as usize
    }
}

impl<F: Medium> NorFlash for Journaled<F> {
    const WRITE_SIZE: usize = F::WRITE_SIZE;
    const ERASE_SIZE: usize = F::ERASE_SIZE;

    async fn erase(&mut self, from: u32, to: u32) -> Result<(), Self::Error> {
        for page in from / Self::PAGE..to / Self::PAGE {
            let at = self.free_entry().await?;
            self.flash.write(at, &Self::entry(page)).await?;
            self.flash.erase(page * Self::PAGE, (page + 1) * Self::PAGE).await?;
            self.flash.write(at, &STRUCK).await?;
        }
        Ok(())
    }

    async fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), Self::Error> {
        self.flash.write(offset, bytes).await
    }
}
