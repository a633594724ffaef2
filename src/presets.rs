//! Storage of [`link::PresetStore`] items in flash with `sequential-storage`. A power cut while saving leaves the old item or
//! the new one.
//!
//! ```text
//! page 0 … n-2   map of sequential-storage: items in sequence; a full page is copied and erased
//! page n-1       journal of erasures ([`Journaled`])
//! ```
//!
//! `sequential-storage` handles partially written items. This module and [`Journaled`] handle three more properties of real
//! flash: an interrupted erasure, after which any bit may read 0 or 1; a torn double word with a wrong error-correcting code;
//! and a flash that fails.

mod journal;

pub use journal::{Journaled, Medium};

use core::fmt;
use embedded_storage_async::nor_flash::NorFlashError;
use link::MAX_ITEM;
use sequential_storage::Error;
use sequential_storage::cache::{Cache, Uncached};
use sequential_storage::map::{MapConfig, MapStorage};

/// Buffer for an item with its key, in whole double words.
const BUFFER: usize = MAX_ITEM + 8;

type Map<F> = MapStorage<u8, Journaled<F>, Cache<Uncached, Uncached, Uncached, u8>>;

/// Reason why an item was not stored. Earlier items are unchanged.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum NotStored {
    /// No room, even after erasing.
    Full,
    /// Erasing or programming failed.
    Refused,
    /// No flash, or invalid contents.
    Unusable,
    /// The flash of the chip is one bank.
    SingleBank,
}

impl fmt::Display for NotStored {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Full => "the flash is full; `preset delete NAME` makes room",
            Self::Refused => "the flash could not be erased or programmed; earlier presets are unchanged",
            Self::SingleBank => {
                "option byte DBANK = 0: accepted 1, because writing a single bank would stall the control loop; set it with a programmer and restart. Presets last until then"
            }
            Self::Unusable => "the flash for presets is unusable; presets last until the device restarts",
        })
    }
}

impl core::error::Error for NotStored {}

impl<E> From<Error<E>> for NotStored {
    fn from(error: Error<E>) -> Self {
        match error {
            Error::FullStorage | Error::ItemTooBig => Self::Full,
            Error::Storage { .. } => Self::Refused,
            _ => Self::Unusable,
        }
    }
}

/// Items in a flash.
pub struct Library<F: Medium> {
    map: Map<F>,
}

impl<F: Medium> Library<F> {
    /// Opens a flash and completes interrupted operations. `each` receives every stored item, the newest of a key last.
    /// Unreadable contents are erased.
    ///
    /// # Errors
    /// The flash cannot be read or repaired, or is smaller than three pages.
    pub async fn open(flash: F, each: &mut dyn FnMut(u8, &[u8])) -> Result<Self, NotStored> {
        let mut flash = Journaled::new(flash);
        flash.recover().await.map_err(|_| NotStored::Refused)?;
        let config = MapConfig::try_new(0..flash.map_bytes()).map_err(|_| NotStored::Unusable)?;
        let mut library = Self { map: MapStorage::new(flash, config, Cache::new_uncached()) };
        match library.load(each).await {
            Ok(()) => {}
            // unreadable: left by another firmware
            Err(NotStored::Unusable) => library.map.erase_all().await?,
            Err(why) => return Err(why),
        }
        Ok(library)
    }

    async fn load(&mut self, each: &mut dyn FnMut(u8, &[u8])) -> Result<(), NotStored> {
        let mut buffer = [0; BUFFER];
        let mut items = self.map.fetch_all_items(&mut buffer).await?;
        while let Some((key, item)) = items.next::<&[u8]>(&mut buffer).await? {
            each(key, item);
        }
        Ok(())
    }

    /// Stores an item of at most [`MAX_ITEM`] bytes, replacing an earlier one with its key.
    ///
    /// # Errors
    /// No room, or the flash fails. The earlier item is unchanged.
    pub async fn store(&mut self, key: u8, item: &[u8]) -> Result<(), NotStored> {
        let mut buffer = [0; BUFFER];
        Ok(self.map.store_item(&mut buffer, &key, &item).await?)
    }

    /// Returns the flash.
    pub fn close(self) -> F {
        self.map.destroy().0.into_inner()
    }
}

/// A failed flash operation.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Refused;

impl NorFlashError for Refused {
    fn kind(&self) -> embedded_storage_async::nor_flash::NorFlashErrorKind {
        embedded_storage_async::nor_flash::NorFlashErrorKind::Other
    }
}
