//! Task that feeds the watchdog while the loop is healthy.

use embassy_stm32::gpio::Output;
use embassy_stm32::peripherals::IWDG;
use embassy_stm32::wdg::IndependentWatchdog;
use embassy_time::{Duration, Ticker};
use tribos_firmware::app::Lamp;
use tribos_firmware::board::nucleo as board;

/// Period of the check, ms.
const LOOK_MS: u64 = 10;
/// Checks per half period of the LED: 1 Hz.
const BLINK: u32 = 50;

#[embassy_executor::task]
pub async fn run(mut watchdog: IndependentWatchdog<'static, IWDG>, mut lamp: Lamp<Output<'static>>) {
    watchdog.unleash();
    let mut tick = Ticker::every(Duration::from_millis(LOOK_MS));
    let mut last = board::steps();
    let mut late = 0;
    loop {
        tick.next().await;
        let steps = board::steps();
        // expected steps since the last check, up to the phase of the two clocks
        if steps.wrapping_sub(last) >= board::steps_in_ms(LOOK_MS as u32 - 1) {
            watchdog.pet();
            lamp.look(BLINK);
        }
        last = steps;
        let now_late = board::late_steps();
        if now_late != late {
            defmt::warn!(
                "{=u32} forces came out late, worst step {=u32} cycles",
                now_late,
                board::worst_cycles()
            );
            late = now_late;
        }
    }
}
