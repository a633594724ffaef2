//! The force taken off from any context: panic, hard fault, before a reset.

use super::{black_box, enable, last_words};
use embassy_stm32::pac;
use haptics::FaultKind;

/// Code of the DAC for no force.
pub(super) const DAC_ZERO: u16 = 2048;

/// Drops the amplifier enable and sets the force to zero.
pub fn make_safe() {
    enable::drop_now();
    pac::DAC1.cr().modify(|w| w.set_ten(0, false));
    pac::DAC1.dhr12r(0).write(|w| w.set_dhr(DAC_ZERO));
}

/// Switches the force off and resets. The next start reports the reason.
pub fn restart(why: FaultKind) -> ! {
    make_safe();
    last_words::keep(why);
    black_box::keep(why);
    cortex_m::peripheral::SCB::sys_reset()
}
