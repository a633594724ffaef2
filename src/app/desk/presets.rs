//! The preset commands, and the items that are being stored.

use super::{Desk, Line, Listing, Named};
use crate::app::DeskEnds;
use crate::board::Board;
use crate::presets::NotStored;
use core::fmt::Write;
use link::{Change, MAX_ITEM, Name, PresetCommand, PresetError};

/// How long the board may take to store an item, ms: it erases two pages at most.
const PATIENCE_MS: u32 = 2_000;

/// An item is on its way into the flash, an answer is owed.
pub(super) struct Saving {
    change: Change,
    name: Name,
    done: Done,
    since: u32,
}

/// What the answer says when it is stored.
#[derive(Clone, Copy)]
enum Done {
    Saved,
    Deleted,
    Default,
    /// Nothing: nobody asked.
    Repaired,
}

impl Desk {
    /// Takes over an item that was stored before the restart; the newest of a key last.
    pub fn load(&mut self, key: u8, item: &[u8]) {
        self.presets.load(key, item);
    }

    /// Everything is loaded, or nothing could be: the default preset is active if this device can render it.
    pub fn loaded(&mut self, unusable: Option<NotStored>, board: &mut impl Board) {
        self.unusable = unusable;
        if let Some(change) = self.presets.loaded() {
            // power went in the middle of a command. Refused, it is done at the next start
            store(&change, board);
            let (name, since) = (Name::new(), board.now_ms());
            self.saving = Some(Saving { change, name, done: Done::Repaired, since });
        }
        if let Some(name) = self.presets.default_name()
            && let Ok(settings) = self.presets.find(name)
            // one that is unfit is told of by `preset list`
            && settings.validate(&self.device).is_ok()
        {
            self.preset = Name::try_from(name).unwrap_or_default();
            self.settings = settings;
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

    /// The board has stored what it was given, or refuses.
    pub(super) fn poll_saving(&mut self, board: &mut impl Board) {
        let Some(saving) = &mut self.saving else { return };
        let outcome = match board.stored() {
            Some(outcome) => outcome,
            None if board.now_ms().wrapping_sub(saving.since) > PATIENCE_MS => Err(NotStored::Refused),
            None => return,
        };
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
            // the preset is deleted; if power goes before its default is, that default is none all the same
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
        // what does not fit is cut
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
            let _ = write!(line, "; {unfit} unfit for this device: `preset use` says why");
        }
        if self.presets.unreadable() > 0 {
            let count = self.presets.unreadable();
            let _ = write!(
                line,
                "; {count} saved by another version: not readable, kept until the room is needed"
            );
        }
        if let Some(why) = self.unusable {
            let _ = write!(line, "; {why}");
        }
        self.say(&line);
    }
}

/// Hands the item of a change to the board.
fn store(change: &Change, board: &mut impl Board) {
    let mut buffer = [0; MAX_ITEM];
    board.store(change.key(), change.encode(&mut buffer));
}
