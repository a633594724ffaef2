//! Preset commands and the storage of their items.

use super::storing::{Done, Saving, outcome};
use super::{Desk, Line, Listing, Named};
use crate::app::{DeskEnds, calibrate};
use crate::board::Board;
use crate::presets::NotStored;
use core::fmt::Write;
use haptics::NOMINAL_SUPPLY;
use link::{CALIBRATION_KEY, Change, MAX_ITEM, Name, PresetCommand, PresetError};

impl Desk {
    /// Loads an item stored before the restart. The newest item of a key comes last.
    pub fn load(&mut self, key: u8, item: &[u8]) {
        if key != CALIBRATION_KEY {
            self.presets.load(key, item);
        } else if let Some(device) = calibrate::decode(item, &self.device.at_supply(NOMINAL_SUPPLY)) {
            self.replaced(device.at_supply(self.device.supply));
        }
    }

    /// Ends loading, successful or not. Activates the default preset if this device can render it.
    pub fn loaded(&mut self, unusable: Option<NotStored>, board: &mut impl Board) {
        self.unusable = unusable;
        if let Some(change) = self.presets.loaded() {
            // power was cut during a command; if refused now, it is completed at the next start
            store(&change, board);
            let (name, since) = (Name::new(), board.now_ms());
            self.saving = Some(Saving { change, name, done: Done::Repaired, since });
        }
        if let Some(name) = self.presets.default_name()
            && let Ok(settings) = self.presets.find(name)
            // `preset list` reports an invalid preset
            && settings.validate(&self.device).is_ok()
        {
            self.preset = Name::try_from(name).unwrap_or_default();
            self.settings = settings;
        }
        if let Some(scaled) = self.stand_in(&self.device) {
            (self.settings, self.changed) = (scaled, true);
        }
    }

    pub(super) fn preset_command(
        &mut self,
        command: PresetCommand<'_>,
        now: u32,
        ends: &mut DeskEnds<'_>,
        board: &mut impl Board,
    ) {
        let done = match command {
            PresetCommand::List => return self.list_presets(),
            PresetCommand::Show(name) => match self.presets.find(name) {
                Ok(settings) => {
                    return self.begin_list(format_args!("{name}"), Listing::Parameters(settings), board);
                }
                Err(e) => Err(e),
            },
            PresetCommand::Use(name) => match self.presets.find(name) {
                Ok(settings) => {
                    let key = Name::try_from(name).unwrap_or_default();
                    return self.configure(settings, Named::Preset(key), now, ends);
                }
                Err(e) => Err(e),
            },
            PresetCommand::Save(name) => {
                self.presets.save(name, &self.settings).map(|c| (c, name, Done::Saved))
            }
            PresetCommand::Default(name) => self.presets.set_default(name).map(|c| (c, name, Done::Default)),
            PresetCommand::Delete(name) => match self.presets.delete(name) {
                Ok(Some(change)) => Ok((change, name, Done::Deleted)),
                Ok(None) => return self.ok(format_args!("{name} deleted")),
                Err(e) => Err(e),
            },
        };
        match done {
            Ok((change, name, done)) => {
                store(&change, board);
                let name = Name::try_from(name).unwrap_or_default();
                self.saving = Some(Saving { change, name, done, since: now });
            }
            Err(e) => self.refuse(e),
        }
    }

    fn refuse(&mut self, e: PresetError<'_>) {
        self.err(e.code(), e);
    }

    /// Handles the result of the last store.
    pub(super) fn poll_saving(&mut self, board: &mut impl Board) {
        let Some(saving) = &mut self.saving else { return };
        let Some(outcome) = outcome(saving.since, board) else { return };
        let (name, done) = (saving.name.clone(), saving.done);
        if matches!(done, Done::Repaired) {
            self.saving = None;
            return;
        }
        if let Err(why) = outcome {
            self.saving = None;
            return self.err(if why == NotStored::Full { "FULL" } else { "FLASH" }, why);
        }
        if let Some(next) = self.presets.commit(saving.change) {
            // the preset is deleted; if power is cut before its default is deleted, that default is ignored
            store(&next, board);
            saving.change = next;
            return;
        }
        self.saving = None;
        match done {
            Done::Saved => self.ok(format_args!("{name} saved {}", board.lasting())),
            Done::Deleted => self.ok(format_args!("{name} deleted")),
            Done::Default => self.ok(format_args!("{name} is the default {}", board.lasting())),
            Done::Repaired => {}
        }
    }

    fn list_presets(&mut self) {
        let mut line = Line::new();
        // a long line is truncated
        let _ = line.write_str("ok");
        for name in self.presets.names() {
            let _ = write!(line, " {name}");
        }
        let _ = write!(line, "; active {}{}", self.preset, if self.changed { " (changed)" } else { "" });
        if let Some(name) = self.presets.default_name() {
            let _ = write!(line, "; default {name}");
        }
        let unfit = |name: &&str| self.presets.find(name).is_ok_and(|s| s.validate(&self.device).is_err());
        let unfit = self.presets.names().filter(unfit).count();
        if unfit > 0 {
            let _ = write!(line, "; {unfit} not valid on this device: `preset use` says why");
        }
        if self.presets.unreadable() > 0 {
            let count = self.presets.unreadable();
            let _ = write!(
                line,
                "; {count} saved by another version: not readable, kept until the place is needed"
            );
        }
        if let Some(why) = self.unusable {
            let _ = write!(line, "; {why}");
        }
        self.say(&line);
    }
}

/// Passes the item of a change to the board.
fn store(change: &Change, board: &mut impl Board) {
    let mut buffer = [0; MAX_ITEM];
    board.store(change.key(), change.encode(&mut buffer));
}
