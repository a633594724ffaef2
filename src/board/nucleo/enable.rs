//! The amplifier's enable line: the output of a one-pulse timer that every good step rearms.
//!
//! TIM3 counts up once and stops [rm0440, "One-pulse mode"]. Its channel 2 is high from count 1 to the reload value (PWM mode 2
//! with CCR2 = 1) and low at 0, where the counter stops. A step that wants the amplifier sets the count to 1; a loop that stops,
//! hangs or crashes lets the pulse end, and the line falls by hardware after 1.75 periods, whatever the processor does.
//! A debugger that halts the core has the same effect.
//!
//! [`drop_now`] forces the output low by one write, which lasts until a good step begins a new pulse.

use embassy_stm32::gpio::{AfType, Flex, OutputType, Speed};
use embassy_stm32::peripherals::{PB5, TIM3};
use embassy_stm32::{Peri, pac, rcc};
use pac::timer::vals::{Ocm, Urs};

/// Length of the pulse, quarters of a control period. More than the 1.5 periods after which a sample counts as missed, so that
/// a pulse never ends without a fault; less than two periods.
const PULSE_QUARTERS: u32 = 7;
/// Timer clocks per count, so that the longest pulse fits 16 bits.
const DIVIDER: u32 = 8;
/// Alternate function of the pin for TIM3 channel 2.
const FUNCTION: u8 = 2;
/// Index of the channel.
const CHANNEL: usize = 1;

/// Connects the pin to the timer, low, for this control period, ticks.
pub(super) fn start(pin: Peri<'static, PB5>, period_ticks: u32) {
    rcc::enable_and_reset::<TIM3>();
    let timer = pac::TIM3;
    timer.psc().write_value((DIVIDER - 1) as u16);
    set_period(period_ticks);
    timer.ccr(CHANNEL).write(|w| w.set_ccr(1));
    timer.egr().write(|w| w.set_ug(true)); // loads the prescaler
    drop_now();
    timer.ccer().write(|w| w.set_cce(CHANNEL, true));
    let mut pin = Flex::new(pin);
    pin.set_as_af_unchecked(FUNCTION, AfType::output(OutputType::PushPull, Speed::Low));
    core::mem::forget(pin); // dropping it would disconnect the pin
}

/// Sets the length of the pulse for a control period, ticks.
pub(super) fn set_period(period_ticks: u32) {
    // `as` cannot truncate: the longest pulse is 37 187 counts
    let counts = (period_ticks * PULSE_QUARTERS / (4 * DIVIDER)) as u16;
    pac::TIM3.arr().write(|w| w.set_arr(counts));
}

/// Holds the line high for one pulse from now on. Called by a good step, with whether the step before did the same: a pulse
/// that has ended in between is not started again.
#[inline]
pub(super) fn rearm(again: bool) {
    let timer = pac::TIM3;
    timer.cnt().write(|w| w.set_cnt(1));
    if !again {
        timer.cr1().write(|w| {
            w.set_opm(true);
            w.set_urs(Urs::COUNTER_ONLY);
            w.set_cen(true);
        });
        timer.ccmr_output(0).write(|w| w.set_ocm(CHANNEL, Ocm::PWM_MODE2));
    }
}

/// Forces the line low until the next [`rearm`]. For any context.
#[inline]
pub fn drop_now() {
    pac::TIM3.ccmr_output(0).write(|w| w.set_ocm(CHANNEL, Ocm::FORCE_INACTIVE));
}
