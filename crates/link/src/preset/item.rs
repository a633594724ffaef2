//! An item of persistent memory: a format number and the content in postcard.

use super::name::{MAX_SAVED, ShortName, long, short};
use haptics::Settings;
use serde::{Deserialize, Serialize};

/// Format of the items. 2 has `passivity` behind what 1 has, 3 has what only some laws take behind that. Items of a later
/// format are not read.
const FORMAT: u8 = 3;
/// Bytes that an item lacks which was saved in the format 1 or 2. They stand at the end of a preset.
const LACKS: [(u8, usize); 2] = [(1, 1 + OF_LAWS), (2, OF_LAWS)];
/// Bytes of the five numbers and the one choice that only some laws take.
const OF_LAWS: usize = 5 * 4 + 1;
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
        let lacks = match LACKS.iter().find(|(earlier, _)| earlier == format) {
            Some((_, lacks)) => *lacks,
            None if *format == FORMAT => 0,
            None => return None,
        };
        let mut padded = [0; MAX_ITEM];
        padded.get_mut(..content.len())?.copy_from_slice(content);
        let (written, rest) =
            postcard::take_from_bytes(padded.get(..content.len().checked_add(lacks)?)?).ok()?;
        Some(match written {
            Written::Empty => Self::Empty,
            // of an earlier format exactly what it lacks is added
            Written::Saved(..) if !rest.is_empty() => return None,
            Written::Saved(name, saved) if lacks == 0 => Self::Saved(short(name)?, saved),
            Written::Saved(name, saved) => Self::Saved(short(name)?, of_an_earlier_format(saved)),
            Written::Default(None) => Self::Default(None),
            Written::Default(Some(name)) => Self::Default(Some(short(name)?)),
        })
    }
}

/// The preset with what its format lacked: no passivity controller is zero, the others are what a built-in preset has.
fn of_an_earlier_format(saved: Settings) -> Settings {
    let Settings { elastic, attraction, memory, dwell, steepness, adhesion, .. } = Settings::default();
    Settings { elastic, attraction, memory, dwell, steepness, adhesion, ..saved }
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
