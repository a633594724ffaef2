//! An item of persistent memory: a format number and the content in postcard.

use super::name::{MAX_SAVED, ShortName, long, short};
use haptics::Settings;
use serde::{Deserialize, Serialize};

/// Format of the items. 2 has `passivity` behind what 1 has. Items of a later format are not read.
const FORMAT: u8 = 2;
/// Formats that are read. What an earlier one lacks stands at the end of the item, and is off where it is zero.
const READ: core::ops::RangeInclusive<u8> = 1..=FORMAT;
/// Longest item, bytes.
pub const MAX_ITEM: usize = 256;
/// Key of the item that names the default. Presets have the smaller keys.
pub const DEFAULT_KEY: u8 = MAX_SAVED as u8;

/// Key of the item with the calibration of the sensors, which the device reads and writes itself.
pub const CALIBRATION_KEY: u8 = DEFAULT_KEY + 1;
/// Key of the item with the angle of an absolute encoder in the middle of the stroke, which the board reads and writes itself.
pub const ORIGIN_KEY: u8 = CALIBRATION_KEY + 1;

/// Content of an item.
#[derive(Debug, Clone, Copy, PartialEq)]
#[allow(clippy::large_enum_variant)] // no heap; one at a time
pub(super) enum Item {
    /// A free place.
    Empty,
    /// A preset.
    Saved(ShortName, Settings),
    /// Name of the preset used after a restart.
    Default(Option<ShortName>),
}

/// [`Item`] in its stored form.
#[derive(Serialize, Deserialize)]
enum Written<'a> {
    Empty,
    Saved(&'a str, Settings),
    Default(Option<&'a str>),
}

impl Item {
    fn encode<'b>(&self, buffer: &'b mut [u8; MAX_ITEM]) -> Option<&'b [u8]> {
        let written = match self {
            Self::Empty => Written::Empty,
            Self::Saved(name, settings) => Written::Saved(long(name), *settings),
            Self::Default(name) => Written::Default(name.as_ref().map(long)),
        };
        let (format, content) = buffer.split_first_mut()?;
        *format = FORMAT;
        let length = postcard::to_slice(&written, content).ok()?.len();
        buffer.get(..=length)
    }

    /// Decodes an item. `None` for another format or invalid bytes.
    pub(super) fn decode(bytes: &[u8]) -> Option<Self> {
        let (format, content) = bytes.split_first()?;
        let mut padded = [0; MAX_ITEM];
        padded.get_mut(..content.len())?.copy_from_slice(content);
        let content = if *format == FORMAT { content } else { padded.get(..=content.len())? };
        if !READ.contains(format) {
            return None;
        }
        Some(match postcard::from_bytes(content).ok()? {
            Written::Empty => Self::Empty,
            Written::Saved(name, settings) => Self::Saved(short(name)?, settings),
            Written::Default(None) => Self::Default(None),
            Written::Default(Some(name)) => Self::Default(Some(short(name)?)),
        })
    }
}

/// Item that a preset command needs stored.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Change {
    key: u8,
    item: Item,
}

impl Change {
    pub(super) fn save(at: usize, name: ShortName, settings: Settings) -> Self {
        Self { key: at as u8, item: Item::Saved(name, settings) }
    }

    pub(super) fn delete(at: usize) -> Self {
        Self { key: at as u8, item: Item::Empty }
    }

    pub(super) fn default(name: Option<ShortName>) -> Self {
        Self { key: DEFAULT_KEY, item: Item::Default(name) }
    }

    pub(super) fn into_parts(self) -> (u8, Item) {
        (self.key, self.item)
    }

    /// Key of the item to store.
    #[must_use]
    pub fn key(&self) -> u8 {
        self.key
    }

    /// The item as bytes. Empty only if it did not fit; a preset with all its effects fits.
    pub fn encode<'b>(&self, buffer: &'b mut [u8; MAX_ITEM]) -> &'b [u8] {
        self.item.encode(buffer).unwrap_or(&[])
    }
}
