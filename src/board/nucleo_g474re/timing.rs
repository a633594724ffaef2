//! Rates of the clock and of the control loop, and what the timers count of them.

/// Rate of core, timers and time stamps, Hz.
pub const TICK_HZ: u32 = 170_000_000;
/// Rate of the control loop after a start, Hz.
pub const LOOP_HZ: u32 = haptics::RATES[0];
/// From the start of conversion to the change of the force, ns. The conversions take 21.5 µs.
const LATCH_NS: u32 = 40_600;
/// TIM6 and TIM7 count at a quarter of the clock, so that one period fits 16 bits.
pub(super) const PACE_DIVIDER: u32 = 4;
pub(super) const LATCH_COUNTS: u32 = TICK_HZ / PACE_DIVIDER / 1_000 * (LATCH_NS / 100) / 10_000;
/// Ticks of a control period after a start.
pub(super) const PERIOD_TICKS: u32 = TICK_HZ / LOOP_HZ;
