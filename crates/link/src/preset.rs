//! Sets of parameters by name.

use core::fmt;
use haptics::Settings;
use heapless::{String, Vec};

/// Name of a preset: 1 to 24 of `a-z`, `0-9`, `_`, `-`.
pub type Name = String<24>;
/// Presets a user can save.
const MAX_SAVED: usize = 8;

/// Why a preset command was not obeyed; nothing has changed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PresetError<'a> {
    /// No preset of this name.
    NotThere(&'a str),
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
            Self::BuiltIn(name) => write!(f, "`{name}` is built in; save under another name"),
            Self::BadName(name) => {
                write!(f, "`{name}`: accepted are 1 to 24 of a-z, 0-9, _ and -")
            }
            Self::Full => write!(f, "{MAX_SAVED} presets are saved; `preset delete NAME` makes room"),
        }
    }
}

impl core::error::Error for PresetError<'_> {}

/// The built-in presets and the saved ones.
#[derive(Debug, Clone, Default)]
pub struct PresetStore {
    saved: Vec<(Name, Settings), MAX_SAVED>,
    default: Option<Name>,
}

impl PresetStore {
    /// Only the built-in ones.
    #[must_use]
    pub const fn new() -> Self {
        Self { saved: Vec::new(), default: None }
    }

    /// All names, the built-in ones first.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        Settings::PRESETS
            .iter()
            .map(|(name, _)| *name)
            .chain(self.saved.iter().map(|(name, _)| name.as_str()))
    }

    /// The preset of this name.
    ///
    /// # Errors
    /// There is none.
    pub fn find<'a>(&self, name: &'a str) -> Result<Settings, PresetError<'a>> {
        let saved = self.saved.iter().find(|(known, _)| known == name).map(|(_, settings)| *settings);
        saved.or_else(|| Settings::preset(name)).ok_or(PresetError::NotThere(name))
    }

    /// Saves under a name; an earlier one of that name is replaced.
    ///
    /// # Errors
    /// The name is built in or is no name, or there is no room.
    pub fn save<'a>(&mut self, name: &'a str, settings: &Settings) -> Result<(), PresetError<'a>> {
        if Settings::preset(name).is_some() {
            return Err(PresetError::BuiltIn(name));
        }
        let good = |b: u8| matches!(b, b'a'..=b'z' | b'0'..=b'9' | b'_' | b'-');
        let key = Name::try_from(name).ok().filter(|n| !n.is_empty() && n.bytes().all(good));
        let key = key.ok_or(PresetError::BadName(name))?;
        if let Some((_, place)) = self.saved.iter_mut().find(|(known, _)| *known == key) {
            *place = *settings;
            return Ok(());
        }
        self.saved.push((key, *settings)).map_err(|_| PresetError::Full)
    }

    /// Deletes a saved preset.
    ///
    /// # Errors
    /// It is built in, or not there.
    pub fn delete<'a>(&mut self, name: &'a str) -> Result<(), PresetError<'a>> {
        if Settings::preset(name).is_some() {
            return Err(PresetError::BuiltIn(name));
        }
        let at = self.saved.iter().position(|(known, _)| known == name).ok_or(PresetError::NotThere(name))?;
        self.saved.remove(at);
        if self.default.as_deref() == Some(name) {
            self.default = None;
        }
        Ok(())
    }

    /// The preset used after a start.
    ///
    /// # Errors
    /// There is no such preset.
    pub fn set_default<'a>(&mut self, name: &'a str) -> Result<(), PresetError<'a>> {
        self.find(name)?;
        self.default = Name::try_from(name).ok();
        Ok(())
    }

    /// Name of the preset used after a start.
    #[must_use]
    pub fn default_name(&self) -> Option<&str> {
        self.default.as_deref()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn saved_presets_come_and_go_and_the_built_in_stay() {
        let mut store = PresetStore::new();
        let mut mine = Settings::rubber();
        mine.set("f_dynamic", "1.5").unwrap();
        store.save("mine-2", &mine).unwrap();
        assert_eq!(store.find("mine-2"), Ok(mine));
        assert_eq!(store.save("rubber", &mine), Err(PresetError::BuiltIn("rubber")));
        assert_eq!(store.find("rubber"), Ok(Settings::rubber()));
        for bad in ["", "Mine", "a b", "näme", "abcdefghijklmnopqrstuvwxy"] {
            assert_eq!(store.save(bad, &mine), Err(PresetError::BadName(bad)));
        }
        store.set_default("mine-2").unwrap();
        store.delete("mine-2").unwrap();
        assert_eq!(store.default_name(), None);
        assert_eq!(store.delete("mine-2"), Err(PresetError::NotThere("mine-2")));
        assert_eq!(store.delete("brass"), Err(PresetError::BuiltIn("brass")));
    }

    #[test]
    fn a_full_store_still_replaces() {
        let mut store = PresetStore::new();
        for name in ["a", "b", "c", "d", "e", "f", "g", "h"] {
            store.save(name, &Settings::brass()).unwrap();
        }
        assert_eq!(store.save("i", &Settings::brass()), Err(PresetError::Full));
        store.save("h", &Settings::teflon()).unwrap();
        assert_eq!(store.find("h"), Ok(Settings::teflon()));
        assert_eq!(store.names().count(), Settings::PRESETS.len() + 8);
    }
}
