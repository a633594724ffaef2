//! The load cell on the converter of the chip.

use haptics::FaultKind;

/// The force from the converter of the chip.
pub struct Analog;

impl Analog {
    /// It needs no trigger of its own.
    pub const fn follow() {}

    /// Code of the force: that of the converter.
    #[inline(always)]
    pub const fn sample(&mut self, code: u16) -> u16 {
        code
    }

    /// What is wrong with it shows in its codes.
    #[inline(always)]
    pub const fn trouble(&self) -> Option<FaultKind> {
        None
    }
}
