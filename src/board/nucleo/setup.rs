//! Setup of the core, force output and pace; reason of the start.

use super::last_words;
use super::stop::DAC_ZERO;
use super::timing::{LATCH_COUNTS, PACE_DIVIDER, PERIOD_TICKS, TICK_HZ};
use crate::board::chip;
use embassy_stm32::peripherals::{self, TIM6, TIM7};
use embassy_stm32::{pac, rcc};
use haptics::FaultKind;
use pac::timer::vals::Mms;

/// Polls of a crystal that starts, each at least 10 cycles of the 16 MHz after a reset: 30 ms. It takes 2 ms [ds12288, "HSE
/// oscillator characteristics"].
const CRYSTAL_POLLS: u32 = 50_000;

/// Starts the crystal. False if it does not oscillate; embassy would wait for it for ever.
pub(super) fn start_crystal() -> bool {
    chip::start_crystal();
    (0..CRYSTAL_POLLS).any(|_| pac::RCC.cr().read().hserdy())
}

/// Lets the flash read ahead of the core: sequential code of the tasks waits half as long.
pub(super) fn prefetch() {
    pac::FLASH.acr().modify(|w| w.set_prften(true));
}

/// Stacks the FPU registers with every exception instead of lazily (FPCCR.LSPEN [armv7-m, ch. B3.2.21]). The control step begins
/// with floating point, and so costs the same whatever it interrupts.
///
/// Lazy stacking would also fail in the emulator: rsemu 0.0.7 then clears the condition flags of an interrupted comparison,
/// and one `set` in about 400 was refused.
pub(super) fn stack_floats_at_once() {
    const LSPEN: u32 = 1 << 30;
    // SAFETY: the only writer of the register; no exception is enabled yet, so no stacking is pending
    unsafe { (*cortex_m::peripheral::FPU::PTR).fpccr.modify(|w| w & !LSPEN) };
}

/// Size of the guard below the stack, bytes: more than the frame that overflows into it and what the fault handler needs.
const GUARD: u32 = 256;

/// Forbids access to the memory between the static data and the stack: a stack that grows into the data is a crash, not a
/// silent change. The handler of the crash runs without this rule (HFNMIENA = 0 [armv7-m, ch. B3.5.3]), within the guard.
pub(super) fn guard_stack() {
    unsafe extern "C" {
        static __sheap: u32;
    }
    const ENABLE: u32 = 1;
    const DEFAULT_MAP: u32 = 1 << 2;
    const NO_EXECUTION: u32 = 1 << 28;
    // no access: AP = 0. SIZE = log2 of the bytes − 1
    const ATTRIBUTES: u32 = NO_EXECUTION | (GUARD.trailing_zeros() - 1) << 1 | ENABLE;
    let end_of_data = (&raw const __sheap).addr() as u32;
    // SAFETY: the only writer of the registers. Nothing lives between the data and the stack.
    unsafe {
        let mpu = &*cortex_m::peripheral::MPU::PTR;
        mpu.rnr.write(0);
        mpu.rbar.write(end_of_data.next_multiple_of(GUARD));
        mpu.rasr.write(ATTRIBUTES);
        mpu.ctrl.write(DEFAULT_MAP | ENABLE);
    }
    cortex_m::asm::dsb();
    cortex_m::asm::isb();
}

/// DAC1 channel 1 on its pin, at zero force, latched by TIM7.
pub(super) fn start_dac() {
    rcc::enable_and_reset::<peripherals::DAC1>();
    chip::set_dac_speed();
    pac::DAC1.dhr12r(0).write(|w| w.set_dhr(DAC_ZERO));
    // without a trigger the holding register acts at once: zero force before the loop runs
    pac::DAC1.cr().write(|w| w.set_en(0, true));
    cortex_m::asm::delay(TICK_HZ / 100_000); // 10 µs: wake-up of the output stage
    pac::DAC1.cr().modify(|w| {
        w.set_tsel(0, 2); // TIM7_TRGO
        w.set_ten(0, true);
    });
}

/// TIM6 starts the conversions, TIM7 latches the force. Same clock and period keep them in phase.
pub(super) fn start_pace() {
    rcc::enable_and_reset::<TIM6>();
    rcc::enable_and_reset::<TIM7>();
    for timer in [pac::TIM6, pac::TIM7] {
        timer.psc().write_value((PACE_DIVIDER - 1) as u16);
        timer.arr().write(|w| w.set_arr(reload(PERIOD_TICKS)));
        timer.egr().write(|w| w.set_ug(true)); // loads both; before the trigger output is connected
        timer.cr2().write(|w| w.set_mms(Mms::UPDATE));
    }
    // their updates are LATCH_COUNTS apart
    pac::TIM7.cnt().write(|w| w.set_cnt((PERIOD_TICKS / PACE_DIVIDER - LATCH_COUNTS) as u16));
    critical_section::with(|_| {
        pac::TIM6.cr1().write(|w| w.set_cen(true));
        pac::TIM7.cr1().write(|w| w.set_cen(true));
    });
}

/// Reload value of a control period, ticks.
fn reload(period_ticks: u32) -> u16 {
    // `as` cannot truncate: the longest period is 42 500 counts
    (period_ticks / PACE_DIVIDER).saturating_sub(1) as u16
}

/// Changes the control period from the present one on. Called by the control interrupt within its step: TIM6 is then before
/// [`LATCH_COUNTS`] or shortly after it, and always before the end of the shortest period.
pub(super) fn change_pace(period_ticks: u32) {
    let (tim6, tim7) = (pac::TIM6, pac::TIM7);
    tim6.cr1().modify(|w| w.set_cen(false));
    tim7.cr1().modify(|w| w.set_cen(false));
    let since = tim6.cnt().read().cnt();
    for timer in [tim6, tim7] {
        timer.arr().write(|w| w.set_arr(reload(period_ticks)));
    }
    // as in `start_pace`: the update of TIM7 comes LATCH_COUNTS after the one of TIM6
    let latch = LATCH_COUNTS as u16;
    let phase = if since < latch { since.wrapping_add(reload(period_ticks) + 1) } else { since };
    tim7.cnt().write(|w| w.set_cnt(phase.wrapping_sub(latch)));
    tim6.cr1().modify(|w| w.set_cen(true));
    tim7.cr1().modify(|w| w.set_cen(true));
}

/// EXTI line of the voltage detector.
pub(super) const PVD_LINE: usize = 16;

/// Voltage detector: interrupts when the supply falls and when it is back.
pub(super) fn start_voltage_detector() {
    pac::EXTI.rtsr(0).modify(|w| w.set_line(PVD_LINE, true));
    pac::EXTI.ftsr(0).modify(|w| w.set_line(PVD_LINE, true));
    pac::EXTI.imr(0).modify(|w| w.set_line(PVD_LINE, true));
    chip::start_voltage_detector();
}

/// Reads and clears the reset flags.
///
/// Flags add up until they are cleared, which each start does. The firmware keeps a reason before it resets itself, so a software
/// reset without one is a debugger's, also beside the flag of a watchdog that ran out while the debugger held the core.
pub(super) fn reset_cause() -> ResetCause {
    let flags = pac::RCC.csr().read();
    pac::RCC.csr().modify(|w| w.set_rmvf(true));
    let kept = last_words::take();
    if flags.sftrstf() {
        match kept {
            Some(FaultKind::Panic) => ResetCause::Panic,
            Some(FaultKind::Crash) => ResetCause::Crash,
            Some(FaultKind::MissedDeadline) => ResetCause::Stopped,
            Some(FaultKind::BrownOut) => ResetCause::BrownOut,
            Some(FaultKind::Clock) => ResetCause::Clock,
            _ => ResetCause::Debugger,
        }
    } else if flags.iwdgrstf() || flags.wwdgrstf() {
        ResetCause::Watchdog
    } else if kept == Some(FaultKind::BrownOut) {
        ResetCause::BrownOut
    } else if flags.lpwrrstf() {
        ResetCause::LowPower
    } else if flags.borrstf() {
        ResetCause::Power
    } else if flags.oblrstf() {
        ResetCause::OptionBytes
    } else {
        ResetCause::Button
    }
}

/// Reason of the start, from the reset flags.
#[derive(Debug, Clone, Copy, PartialEq, Eq, defmt::Format)]
pub enum ResetCause {
    /// Power came up.
    Power,
    /// Reset button, or a programmer on the reset pin.
    Button,
    /// A debugger, after flashing or on request.
    Debugger,
    /// The option bytes were loaded.
    OptionBytes,
    /// A watchdog: the loop had stopped.
    Watchdog,
    /// A panic.
    Panic,
    /// A fault exception of the processor.
    Crash,
    /// No control step came for two periods.
    Stopped,
    /// The supply broke down.
    BrownOut,
    /// The crystal stopped.
    Clock,
    /// The firmware entered a low-power mode that the option bytes forbid.
    LowPower,
}

impl ResetCause {
    /// Fault with which the loop starts: after an unexpected reset a person must look first.
    pub(super) fn fault(self) -> Option<FaultKind> {
        match self {
            Self::Power | Self::Button | Self::Debugger | Self::OptionBytes => None,
            Self::Watchdog => Some(FaultKind::Watchdog),
            Self::Panic => Some(FaultKind::Panic),
            Self::Crash => Some(FaultKind::Crash),
            Self::Stopped => Some(FaultKind::MissedDeadline),
            Self::BrownOut => Some(FaultKind::BrownOut),
            Self::Clock => Some(FaultKind::Clock),
            Self::LowPower => Some(FaultKind::Hardware),
        }
    }
}
