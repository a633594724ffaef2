//! The boards and their common traits: [`RealTime`] for the control interrupt, [`Board`] for the tasks.
//!
//! [`nucleo`](self) is what the NUCLEO-64 boards share; the feature of a board chooses the file of its chip.

#[cfg(target_os = "none")]
#[allow(unsafe_code)] // registers; the only place, with the two below
pub mod nucleo;
#[cfg(all(target_os = "none", feature = "nucleo-g474re"))]
#[allow(unsafe_code)]
mod nucleo_g474re;
#[cfg(all(target_os = "none", feature = "nucleo-l476rg"))]
#[allow(unsafe_code)]
mod nucleo_l476rg;
mod real_time;
#[cfg(not(target_os = "none"))]
pub mod simulated;

#[cfg(all(target_os = "none", feature = "nucleo-g474re"))]
use nucleo_g474re as chip;
#[cfg(all(target_os = "none", feature = "nucleo-l476rg"))]
use nucleo_l476rg as chip;
pub use real_time::{RealTime, RealTimeLoop};

use crate::app::Earlier;
use crate::presets::NotStored;
use core::fmt::Write;
use haptics::Device;
use link::HelpLine;

/// What the control loop knows of the middle of the stroke.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Middle {
    /// It is at this count.
    At(u32),
    /// It is unknown, and a request that tells it is accepted.
    Unknown,
    /// It is unknown because counts may be wrong.
    InDoubt,
}

/// What an encoder tells of the middle of the stroke.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MiddleNews {
    /// Nothing new.
    None,
    /// An item for [`link::ORIGIN_KEY`], by which the next start finds it.
    Keep([u8; 4]),
    /// It is at this count.
    Is(u32),
    /// Counts were lost or made up: it is no longer where the control loop has it.
    Moved,
}

/// A board, as the tasks see it.
pub trait Board {
    /// Name for people.
    fn name(&self) -> &'static str;

    /// Constants of the device on this board.
    fn device(&self) -> Device;

    /// Time since the start, ms. Wraps.
    fn now_ms(&self) -> u32;

    /// Source of the clock of all times, and its error if that is large.
    fn clock(&self) -> &'static str;

    /// Whether that error enters velocity and time.
    fn clock_is_off(&self) -> bool {
        false
    }

    /// Level of the brown-out reset, if it is lower than advised.
    fn weak_brown_out(&self) -> Option<u8> {
        None
    }

    /// Disables the amplifier at once, ahead of the control loop, which keeps it off.
    fn off(&mut self) {}

    /// Number of control steps with a late force.
    fn late_steps(&self) -> u32;

    /// Starts to store an item of the presets. One at a time.
    fn store(&mut self, key: u8, item: &[u8]);

    /// Result of the last store; returned once.
    fn stored(&mut self) -> Option<Result<(), NotStored>>;

    /// What the encoder knows of the middle of the stroke beyond its counts. Counts are those of the control loop: negative where
    /// the encoder is reversed.
    fn middle(&mut self, _now: Middle, _reversed: bool) -> MiddleNews {
        MiddleNews::None
    }

    /// Lifetime of stored presets, such as “in flash”.
    fn lasting(&self) -> &str;

    /// Fault kept over the last reset, until it is cleared.
    fn earlier(&self) -> Option<Earlier> {
        None
    }

    /// Clears the kept fault. The next fault is the first again.
    fn forget(&mut self) {}

    /// Commands of this board.
    fn help(&self) -> &'static [HelpLine] {
        &[]
    }

    /// Executes a command of this board. `None` if the line is not one. The answer goes to `out`; the error is its code.
    fn command(&mut self, _line: &str, _out: &mut dyn Write) -> Option<Result<(), &'static str>> {
        None
    }
}
