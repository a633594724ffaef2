//! The application on the board: embassy tasks below the control interrupt.
//!
//! | what | where | every |
//! | --- | --- | --- |
//! | [`ControlLoop`] | interrupt, priority 0 ([`nucleo_g474re`]) | 1 ms |
//! | serial line in and out of its buffers | interrupt, priority 6 | byte |
//! | [`console`]: commands, answers, frames | task | 1 ms |
//! | [`keeper`]: presets into the flash | task | when asked |
//! | [`supervisor`]: watchdog, alive lamp | task | 10 ms |
//!
//! Between interrupt and tasks there are only the lock-free queues of [`tribos_firmware::app`].

mod console;
mod keeper;
mod supervisor;

use cortex_m_rt as _;
use defmt_rtt as _;
use embassy_executor::Spawner;
use static_cell::StaticCell;
use tribos_firmware::app::{ControlLoop, Desk, Queues};
use tribos_firmware::board::Board;
use tribos_firmware::board::nucleo_g474re::{self, Nucleo, Peripherals};
use tribos_firmware::presets::Library;

static QUEUES: StaticCell<Queues> = StaticCell::new();
static DESK: StaticCell<Desk> = StaticCell::new();

#[embassy_executor::main]
async fn main(spawner: Spawner) {
    let mut peripherals = Peripherals::boot();
    defmt::info!("tribos {=str}, started by {}", env!("CARGO_PKG_VERSION"), peripherals.reset_cause);
    let desk = DESK.init_with(|| Desk::new(Nucleo.device()));
    let library = Library::open(peripherals.pages(), &mut |key, item| desk.load(key, item)).await;
    desk.loaded(library.as_ref().err().copied(), &mut Nucleo);
    // the first preset suits the device of this board: tests/elf sees it run. If it ever did not, nothing would
    // run and nothing be driven.
    let Ok(config) = desk.config() else { panic!("the first preset does not suit this device") };
    let (control, ends) = QUEUES.init_with(Queues::default).split();
    let rest = peripherals.start(ControlLoop::new(config), control);
    // each task is started once, which is all a spawn token asks
    if let (Ok(console), Ok(supervisor), Ok(keeper)) = (
        console::run(desk, ends, rest.console),
        supervisor::run(rest.watchdog, rest.led),
        keeper::run(library),
    ) {
        spawner.spawn(supervisor);
        spawner.spawn(keeper);
        spawner.spawn(console);
    }
}

#[panic_handler]
fn panic(info: &core::panic::PanicInfo<'_>) -> ! {
    nucleo_g474re::make_safe();
    if let Some(place) = info.location() {
        nucleo_g474re::black_box::panicked_at(place);
    }
    defmt::error!("{}", defmt::Display2Format(info));
    nucleo_g474re::restart(haptics::FaultKind::Panic)
}
