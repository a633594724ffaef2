//! The application on the board: embassy tasks below the control interrupt.
//!
//! | what | where | every |
//! | --- | --- | --- |
//! | [`ControlLoop`] | interrupt, priority 0 ([`nucleo`]) | 1 ms |
//! | serial line into its buffer | interrupt, priority 6 | byte |
//! | [`listener`]: bytes of the serial line, `off` | task in an interrupt, priority 7 | idle line |
//! | [`console`]: commands, answers, frames | task | 1 ms |
//! | [`sender`]: what the console hands over, by DMA | task | piece |
//! | [`keeper`]: presets into the flash | task | when asked |
//! | [`supervisor`]: watchdog, status LED | task | 10 ms |
//!
//! Interrupts and tasks share only lock-free queues and the switch of `off`, see [`tribos_firmware::app`].

mod console;
mod keeper;
mod listener;
mod sender;
mod supervisor;

use cortex_m_rt as _;
use defmt_rtt as _;
use embassy_executor::Spawner;
use heapless_spsc::spsc::Queue;
use listener::WAITING;
use sender::Sending;
use static_cell::StaticCell;
use tribos_firmware::app::{ControlLoop, Desk, Queues};
use tribos_firmware::board::Board;
use tribos_firmware::board::nucleo::{self, Nucleo, Peripherals};
use tribos_firmware::presets::Library;

static QUEUES: StaticCell<Queues> = StaticCell::new();
static DESK: StaticCell<Desk> = StaticCell::new();
static TYPED: StaticCell<Queue<u8, WAITING>> = StaticCell::new();
static SENDING: StaticCell<Sending> = StaticCell::new();

#[embassy_executor::main]
async fn main(spawner: Spawner) {
    let mut peripherals = Peripherals::boot();
    defmt::info!("tribos {=str}, started by {}", env!("CARGO_PKG_VERSION"), peripherals.reset_cause);
    let desk = DESK.init_with(|| Desk::new(Nucleo.device()));
    let library = match peripherals.pages() {
        Ok(pages) => {
            let each = &mut |key, item: &[u8]| {
                Peripherals::load(key, item);
                desk.load(key, item);
            };
            Library::open(pages, each).await
        }
        Err(why) => Err(why),
    };
    desk.loaded(library.as_ref().err().copied(), &mut Nucleo);
    // the first preset suits the device of this board, as tests/elf shows; otherwise nothing would run or be driven
    let Ok(config) = desk.config() else { panic!("the first preset does not suit this device") };
    let (control, ends) = QUEUES.init_with(Queues::default).split();
    let off = ends.off();
    let control_loop = if peripherals.begin_position(desk.device()) {
        ControlLoop::referenced(config)
    } else {
        ControlLoop::new(config)
    };
    let rest = peripherals.start(control_loop, control);
    let (typed, to_read) = TYPED.init_with(Queue::new).split();
    let (to_send, sending) = SENDING.init_with(Sending::new).split();
    // each task is started once, as a spawn token requires
    if let (Ok(listener), Ok(console), Ok(sender), Ok(supervisor), Ok(keeper)) = (
        listener::run(rest.serial.rx, typed, off),
        console::run(desk, ends, to_read, sending),
        sender::run(to_send, rest.serial.tx),
        supervisor::run(rest.watchdog, rest.led),
        keeper::run(library),
    ) {
        rest.listener.spawn(listener);
        spawner.spawn(supervisor);
        spawner.spawn(keeper);
        spawner.spawn(console);
        spawner.spawn(sender);
    }
}

#[panic_handler]
fn panic(info: &core::panic::PanicInfo<'_>) -> ! {
    nucleo::make_safe();
    if let Some(place) = info.location() {
        nucleo::black_box::panicked_at(place);
    }
    defmt::error!("{}", defmt::Display2Format(info));
    nucleo::restart(haptics::FaultKind::Panic)
}
