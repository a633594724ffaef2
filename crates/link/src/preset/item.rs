//! One item of the map that lasts: a format number and the content in postcard.

use super::{MAX_SAVED, ShortName, long, short};
use haptics::Settings;
use serde::{Deserialize, Serialize};

/// Format of the items; those of another one are not read.
const FORMAT: u8 = 1;
/// Longest item, bytes.
pub const MAX_ITEM: usize = 256;
/// Key of the item that names the default; the presets have the keys below.
pub const DEFAULT_KEY: u8 = MAX_SAVED as u8;

/// What is kept under a key.
#[derive(Debug, Clone, Copy, PartialEq)]
#[allow(clippy::large_enum_variant)] // no heap; one at a time
pub(super) enum Item {
    /// No preset is saved here any more.
    Empty,
    /// A preset.
    Saved(ShortName, Settings),
    /// Which preset is used after a start.
    Default(Option<ShortName>),
}

/// [`Item`] as it is written.
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

    /// Reads one; `None` if it is in another format or is none.
    pub(super) fn decode(bytes: &[u8]) -> Option<Self> {
        let (&FORMAT, content) = bytes.split_first()? else { return None };
        Some(match postcard::from_bytes(content).ok()? {
            Written::Empty => Self::Empty,
            Written::Saved(name, settings) => Self::Saved(short(name)?, settings),
            Written::Default(None) => Self::Default(None),
            Written::Default(Some(name)) => Self::Default(Some(short(name)?)),
        })
    }
}

/// What a command about presets needs stored.
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

    /// Key of the item.
    #[must_use]
    pub fn key(&self) -> u8 {
        self.key
    }

    /// The item as bytes; empty only if it did not fit, which a preset with all its effects does.
    pub fn encode<'b>(&self, buffer: &'b mut [u8; MAX_ITEM]) -> &'b [u8] {
        self.item.encode(buffer).unwrap_or(&[])
    }
}
