//! The items of [`link::PresetStore`] in a flash, by `sequential-storage`: what was saved outlives power, and power
//! that goes in the middle of saving leaves the old item or the new one.
//!
//! ```text
//! page 0 … n-2   map of sequential-storage: items one behind the other, a full page is copied on and erased
//! page n-1       journal of erasures ([`Journaled`])
//! ```
//!
//! `sequential-storage` takes care of items written in part. Three things of a real flash are taken care of here and by
//! [`Journaled`]: an erasure that was cut short, after which any bit of the page may read 0 or 1; a double word that
//! was cut short and has a wrong error-correcting code; and a flash that refuses.

mod journal;

pub use journal::{Journaled, Medium};

use core::fmt;
use embedded_storage_async::nor_flash::NorFlashError;
use link::MAX_ITEM;
use sequential_storage::Error;
use sequential_storage::cache::{Cache, Uncached};
use sequential_storage::map::{MapConfig, MapStorage};

/// Room for an item with its key, whole double words.
const BUFFER: usize = MAX_ITEM + 8;

type Map<F> = MapStorage<u8, Journaled<F>, Cache<Uncached, Uncached, Uncached, u8>>;

/// Why an item was not stored; what was stored before is still there.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum NotStored {
    /// No room, whatever is erased.
    Full,
    /// The flash refused to erase or program.
    Refused,
    /// There is no flash, or its contents make no sense.
    Unusable,
}

impl fmt::Display for NotStored {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Full => "the flash has no room left; `preset delete NAME` makes room",
            Self::Refused => {
                "the flash refused to be erased or programmed; what was saved before is still there"
            }
            Self::Unusable => "the flash for presets cannot be used; presets last until the device restarts",
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

/// The items in a flash.
pub struct Library<F: Medium> {
    map: Map<F>,
}

impl<F: Medium> Library<F> {
    /// Opens what the flash holds, and first finishes what power cut short. `each` gets every item that was stored, the
    /// newest of a key last. Contents of which nothing can be read are erased.
    ///
    /// # Errors
    /// The flash cannot be read or refuses the repair, or is smaller than three pages.
    pub async fn open(flash: F, each: &mut dyn FnMut(u8, &[u8])) -> Result<Self, NotStored> {
        let mut flash = Journaled::new(flash);
        flash.recover().await.map_err(|_| NotStored::Refused)?;
        let config = MapConfig::try_new(0..flash.map_bytes()).map_err(|_| NotStored::Unusable)?;
        let mut library = Self { map: MapStorage::new(flash, config, Cache::new_uncached()) };
        match library.load(each).await {
            Ok(()) => {}
            // nothing of ours, and nothing to be read of it: what another firmware has left
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

    /// Stores an item, at most [`MAX_ITEM`] bytes; an earlier one of that key is replaced.
    ///
    /// # Errors
    /// There is no room, or the flash refuses; the earlier item is still there.
    pub async fn store(&mut self, key: u8, item: &[u8]) -> Result<(), NotStored> {
        let mut buffer = [0; BUFFER];
        Ok(self.map.store_item(&mut buffer, &key, &item).await?)
    }

    /// Gives the flash back.
    pub fn close(self) -> F {
        self.map.destroy().0.into_inner()
    }
}

/// A flash that refused.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Refused;

impl NorFlashError for Refused {
    fn kind(&self) -> embedded_storage_async::nor_flash::NorFlashErrorKind {
        embedded_storage_async::nor_flash::NorFlashErrorKind::Other
    }
}
