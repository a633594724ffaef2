//! Rates of the clock and of the control loop, and what the timers count of them.

use crate::board::chip::LATCH_NS;
pub use crate::board::chip::TICK_HZ;

/// Rate of the control loop after a start, Hz.
pub const LOOP_HZ: u32 = haptics::RATES[0];
/// TIM6 and TIM7 count at a quarter of the clock, so that one period fits 16 bits.
pub(super) const PACE_DIVIDER: u32 = 4;
pub(super) const LATCH_COUNTS: u32 = TICK_HZ / PACE_DIVIDER / 1_000 * (LATCH_NS / 100) / 10_000;
/// Ticks of a control period after a start.
pub(super) const PERIOD_TICKS: u32 = TICK_HZ / LOOP_HZ;
