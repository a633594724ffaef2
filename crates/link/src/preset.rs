//! Named sets of parameters, and the items they are stored as.
//!
//! The store is in memory. Persistent memory is a map of small items: one per place for a preset and one for the default.
//! A command returns the [`Change`] it needs, the device stores that item, and only then is the change
//! [`PresetStore::commit`]ted: the store always shows what a restart would find.

mod item;
mod name;

use item::Item;
pub use item::{CALIBRATION_KEY, Change, DEFAULT_KEY, MAX_ITEM, ORIGIN_KEY};
pub use name::{MAX_SAVED, Name};
use name::{ShortName, long, short};

use core::fmt;
use haptics::Settings;

/// Name of the preset that the device identified. In memory until it is saved.
pub const IDENTIFIED: &str = "identified";

/// Reason why a preset command was rejected. Nothing has changed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PresetError<'a> {
    /// Unknown preset.
    NotThere(&'a str),
    /// The preset is only in memory.
    NotSaved(&'a str),
    /// The preset is part of the firmware.
    BuiltIn(&'a str),
    /// Invalid name.
    BadName(&'a str),
    /// No free place.
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
            Self::NotThere(name) => write!(f, "unknown preset `{name}`; `preset list` shows all"),
            Self::NotSaved(name) => write!(f, "`{name}` is not saved: `preset save {name}` first"),
            Self::BuiltIn(name) => write!(f, "`{name}` is built in; use another name"),
            Self::BadName(name) => {
                write!(f, "`{name}`: a name has 1 to 24 of a-z, 0-9, _ and -")
            }
            Self::Full => write!(f, "all {MAX_SAVED} places are in use; `preset delete NAME` frees one"),
        }
    }
}

impl core::error::Error for PresetError<'_> {}

/// A place for a saved preset.
#[derive(Debug, Clone, Copy, Default)]
#[allow(clippy::large_enum_variant)] // no heap
enum Place {
    #[default]
    Free,
    /// An item that this firmware cannot read. A new preset replaces it when no other place is free.
    Unreadable,
    Saved(ShortName, Settings),
}

impl Place {
    fn name(&self) -> Option<&str> {
        match self {
            Self::Saved(name, _) => Some(long(name)),
            Self::Free | Self::Unreadable => None,
        }
    }
}

/// Built-in presets, saved presets, and the identified one.
#[derive(Debug, Clone, Default)]
pub struct PresetStore {
    places: [Place; MAX_SAVED],
    default: Option<ShortName>,
    identified: Option<Settings>,
}

impl PresetStore {
    /// A store with the built-in presets only.
    #[must_use]
    pub const fn new() -> Self {
        Self { places: [Place::Free; MAX_SAVED], default: None, identified: None }
    }

    /// All names, built-in presets first.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        let built_in = Settings::PRESETS.iter().map(|(name, _)| *name);
        let saved = self.places.iter().filter_map(Place::name);
        let identified = self.identified.is_some() && self.place(IDENTIFIED).is_none();
        built_in.chain(saved).chain(identified.then_some(IDENTIFIED))
    }

    /// Number of places with an item that this firmware cannot read.
    #[must_use]
    pub fn unreadable(&self) -> usize {
        self.places.iter().filter(|place| matches!(place, Place::Unreadable)).count()
    }

    fn place(&self, name: &str) -> Option<usize> {
        self.places.iter().position(|place| place.name() == Some(name))
    }

    /// The preset with this name.
    ///
    /// # Errors
    /// [`PresetError::NotThere`] for an unknown name.
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

    /// Keeps identified settings under the name [`IDENTIFIED`] until the device restarts.
    pub fn set_identified(&mut self, settings: &Settings) {
        self.identified = Some(*settings);
    }

    /// The change that saves settings under a name, replacing an earlier preset of that name.
    ///
    /// # Errors
    /// The name is built in or invalid, or no place is free.
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

    /// The change that deletes a saved preset. A preset in memory is deleted at once, without a change.
    ///
    /// # Errors
    /// The preset is built in or unknown.
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

    /// The change that makes a built-in or saved preset the default.
    ///
    /// # Errors
    /// The preset is unknown or not saved.
    pub fn set_default<'a>(&self, name: &'a str) -> Result<Change, PresetError<'a>> {
        self.find(name)?;
        let lasts = self.place(name).is_some() || Settings::preset(name).is_some();
        let key = short(name).filter(|_| lasts).ok_or(PresetError::NotSaved(name))?;
        Ok(Change::default(Some(key)))
    }

    /// Name of the preset used after a restart.
    #[must_use]
    pub fn default_name(&self) -> Option<&str> {
        self.default.as_ref().map(long)
    }

    /// Applies a change that was stored. Returns a change that must follow: a deleted preset cannot be the default.
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

    /// Whether the default names a missing preset: power was cut between the two steps of a deletion.
    fn dangling(&self) -> Option<Change> {
        let name = self.default_name()?;
        (self.place(name).is_none() && Settings::preset(name).is_none()).then(|| Change::default(None))
    }

    /// Loads an item stored before the restart. A later item with the same key replaces it. [`Self::unreadable`] counts
    /// items that cannot be read.
    pub fn load(&mut self, key: u8, bytes: &[u8]) {
        match (Item::decode(bytes), key) {
            (Some(Item::Default(name)), DEFAULT_KEY) => self.default = name,
            (Some(Item::Saved(name, settings)), key) if Settings::preset(long(&name)).is_none() => {
                self.put(key, Place::Saved(name, settings));
            }
            (Some(Item::Empty), key) => self.put(key, Place::Free),
            // a default in another format is ignored
            (_, DEFAULT_KEY) => self.default = None,
            (_, key) => self.put(key, Place::Unreadable),
        }
    }

    /// Ends loading. Returns a change to store if power was cut during the deletion of the default preset; until it is
    /// stored there is no default.
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
