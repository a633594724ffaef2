//! Sets of parameters by name, and the items they are kept as.
//!
//! The store is what a device works with; what lasts is a map of small items beside it, one per place for a preset and
//! one for the default. A command first gives the [`Change`] it needs, the device stores that item, and only then the
//! change is [`PresetStore::commit`]ted: what is told is what a restart will find.

mod item;

use item::Item;
pub use item::{Change, DEFAULT_KEY, MAX_ITEM};

use core::fmt;
use haptics::Settings;
use heapless::String;

/// Name of a preset: 1 to 24 of `a-z`, `0-9`, `_`, `-`.
pub type Name = String<24>;
/// Presets a user can save.
pub const MAX_SAVED: usize = 8;
/// Preset made of what the device identified; kept in memory until it is saved.
pub const IDENTIFIED: &str = "identified";

/// Why a preset command was not obeyed; nothing has changed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PresetError<'a> {
    /// No preset of this name.
    NotThere(&'a str),
    /// The preset is only in memory.
    NotSaved(&'a str),
    /// The preset is part of the firmware.
    BuiltIn(&'a str),
    /// Not a name.
    BadName(&'a str),
    /// No room left.
    Full,
}

impl PresetError<'_> {
    /// Code of the `err` answer.
    #[must_use]
    pub fn code(&self) -> &'static str {
        match self {
            Self::NotThere(_) => "NO_PRESET",
            Self::NotSaved(_) => "NOT_SAVED",
            Self::BuiltIn(_) => "BUILT_IN",
            Self::BadName(_) => "NAME",
            Self::Full => "FULL",
        }
    }
}

impl fmt::Display for PresetError<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NotThere(name) => write!(f, "no preset `{name}`; `preset list` names them"),
            Self::NotSaved(name) => write!(f, "`{name}` is not saved: `preset save {name}` first"),
            Self::BuiltIn(name) => write!(f, "`{name}` is built in; save under another name"),
            Self::BadName(name) => {
                write!(f, "`{name}`: accepted are 1 to 24 of a-z, 0-9, _ and -")
            }
            Self::Full => write!(f, "{MAX_SAVED} presets are saved; `preset delete NAME` makes room"),
        }
    }
}

impl core::error::Error for PresetError<'_> {}

/// A place for a saved preset.
#[derive(Debug, Clone, Copy, Default)]
enum Place {
    #[default]
    Free,
    /// Something is kept here that this firmware cannot read. A new preset takes the place when no other is free.
    Unreadable,
    Saved(ShortName, Settings),
}

/// [`Name`] that can be copied.
type ShortName = ([u8; 24], u8);

fn short(name: &str) -> Option<ShortName> {
    let good = |b: u8| matches!(b, b'a'..=b'z' | b'0'..=b'9' | b'_' | b'-');
    let mut bytes = [0; 24];
    bytes.get_mut(..name.len())?.copy_from_slice(name.as_bytes());
    (!name.is_empty() && name.bytes().all(good)).then_some((bytes, name.len() as u8))
}

fn long((bytes, length): &ShortName) -> &str {
    bytes.get(..usize::from(*length)).and_then(|bytes| core::str::from_utf8(bytes).ok()).unwrap_or("")
}

impl Place {
    fn name(&self) -> Option<&str> {
        match self {
            Self::Saved(name, _) => Some(long(name)),
            Self::Free | Self::Unreadable => None,
        }
    }
}

/// The built-in presets, the saved ones, and the one that was identified.
#[derive(Debug, Clone, Default)]
pub struct PresetStore {
    places: [Place; MAX_SAVED],
    default: Option<ShortName>,
    identified: Option<Settings>,
}

impl PresetStore {
    /// Only the built-in ones.
    #[must_use]
    pub const fn new() -> Self {
        Self { places: [Place::Free; MAX_SAVED], default: None, identified: None }
    }

    /// All names, the built-in ones first.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        let built_in = Settings::PRESETS.iter().map(|(name, _)| *name);
        let saved = self.places.iter().filter_map(Place::name);
        let identified = self.identified.is_some() && self.place(IDENTIFIED).is_none();
        built_in.chain(saved).chain(identified.then_some(IDENTIFIED))
    }

    /// Places that hold something this firmware cannot read.
    #[must_use]
    pub fn unreadable(&self) -> usize {
        self.places.iter().filter(|place| matches!(place, Place::Unreadable)).count()
    }

    fn place(&self, name: &str) -> Option<usize> {
        self.places.iter().position(|place| place.name() == Some(name))
    }

    /// The preset of this name.
    ///
    /// # Errors
    /// There is none.
    pub fn find<'a>(&self, name: &'a str) -> Result<Settings, PresetError<'a>> {
        if let (IDENTIFIED, Some(settings)) = (name, self.identified) {
            return Ok(settings);
        }
        let saved = self.place(name).and_then(|at| self.places.get(at));
        match saved {
            Some(Place::Saved(_, settings)) => Ok(*settings),
            _ => Settings::preset(name).ok_or(PresetError::NotThere(name)),
        }
    }

    /// Keeps what was identified, under the name [`IDENTIFIED`], until the device restarts.
    pub fn set_identified(&mut self, settings: &Settings) {
        self.identified = Some(*settings);
    }

    /// To save under a name; an earlier preset of that name is replaced.
    ///
    /// # Errors
    /// The name is built in or is no name, or there is no room.
    pub fn save<'a>(&self, name: &'a str, settings: &Settings) -> Result<Change, PresetError<'a>> {
        if Settings::preset(name).is_some() {
            return Err(PresetError::BuiltIn(name));
        }
        let key = short(name).ok_or(PresetError::BadName(name))?;
        let with = |wanted: fn(&Place) -> bool| self.places.iter().position(wanted);
        let at = self.place(name).or_else(|| with(|place| matches!(place, Place::Free)));
        let at = at.or_else(|| with(|place| matches!(place, Place::Unreadable)));
        Ok(Change::save(at.ok_or(PresetError::Full)?, key, *settings))
    }

    /// To delete a saved preset. One that is only in memory is gone at once, and there is no change to store.
    ///
    /// # Errors
    /// It is built in, or not there.
    pub fn delete<'a>(&mut self, name: &'a str) -> Result<Option<Change>, PresetError<'a>> {
        if Settings::preset(name).is_some() {
            return Err(PresetError::BuiltIn(name));
        }
        match self.place(name) {
            Some(at) => Ok(Some(Change::delete(at))),
            None if name == IDENTIFIED && self.identified.take().is_some() => Ok(None),
            None => Err(PresetError::NotThere(name)),
        }
    }

    /// To use a built-in or saved preset after a start.
    ///
    /// # Errors
    /// There is no such preset, or it is not saved.
    pub fn set_default<'a>(&self, name: &'a str) -> Result<Change, PresetError<'a>> {
        self.find(name)?;
        let lasts = self.place(name).is_some() || Settings::preset(name).is_some();
        let key = short(name).filter(|_| lasts).ok_or(PresetError::NotSaved(name))?;
        Ok(Change::default(Some(key)))
    }

    /// Name of the preset used after a start.
    #[must_use]
    pub fn default_name(&self) -> Option<&str> {
        self.default.as_ref().map(long)
    }

    /// A change is stored. Another one may have to follow: the default is gone when its preset is.
    pub fn commit(&mut self, change: Change) -> Option<Change> {
        let (at, item) = change.into_parts();
        match (item, at) {
            (Item::Default(name), _) => self.default = name,
            (Item::Saved(name, settings), at) => {
                if long(&name) == IDENTIFIED {
                    self.identified = None;
                }
                self.put(at, Place::Saved(name, settings));
            }
            (Item::Empty, at) => {
                if self.places.get(usize::from(at)).and_then(Place::name) == Some(IDENTIFIED) {
                    self.identified = None;
                }
                self.put(at, Place::Free);
            }
        }
        self.dangling()
    }

    fn put(&mut self, at: u8, new: Place) {
        if let Some(place) = self.places.get_mut(usize::from(at)) {
            *place = new;
        }
    }

    /// The default names no preset: power went between the two steps of deleting it.
    fn dangling(&self) -> Option<Change> {
        let name = self.default_name()?;
        (self.place(name).is_none() && Settings::preset(name).is_none()).then(|| Change::default(None))
    }

    /// Takes over an item that was stored before the restart; a later one of the same key replaces it. What cannot be
    /// read is counted by [`Self::unreadable`].
    pub fn load(&mut self, key: u8, bytes: &[u8]) {
        match (Item::decode(bytes), key) {
            (Some(Item::Default(name)), DEFAULT_KEY) => self.default = name,
            (Some(Item::Saved(name, settings)), key) if Settings::preset(long(&name)).is_none() => {
                self.put(key, Place::Saved(name, settings));
            }
            (Some(Item::Empty), key) => self.put(key, Place::Free),
            // a default in another format is none
            (_, DEFAULT_KEY) => self.default = None,
            (_, key) => self.put(key, Place::Unreadable),
        }
    }

    /// Everything is loaded. What has to be stored now, if power went in the middle of deleting the default preset;
    /// until then that default is none.
    pub fn loaded(&mut self) -> Option<Change> {
        let change = self.dangling();
        if change.is_some() {
            self.default = None;
        }
        change
    }
}

#[cfg(test)]
mod tests;
