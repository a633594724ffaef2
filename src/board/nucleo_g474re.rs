//! NUCLEO-G474RE: the registers of the control path, and the only `unsafe` of the firmware.
//!
//! # Pins
//!
//! | signal | pin | connector | how |
//! | --- | --- | --- | --- |
//! | encoder A, B | PA0, PA1 | A0, A1 | TIM2 channels 1, 2, pull-up, 3.3 V |
//! | force command | PA4 | A2 | DAC1 channel 1, 0.2 V … 3.1 V: 1.65 V is no force, 1 V is 6.67 N |
//! | load cell | PC0 | A5 | ADC1 input 6, 0 V … 3.3 V, from at most 250 Ω |
//! | accelerometer | PC1 | A4 | ADC1 input 7, likewise |
//! | amplifier enable | PB5 | D4 | TIM3 channel 2, high: on. **Fit 10 kΩ to ground**: the pin floats while the chip is in reset |
//! | emergency stop | PC7 | D9 | closed to ground: run. Open, pressed or broken wire: fault. Without a switch fit a bridge |
//! | amplifier fault | PB10 | D6 | closed to ground: healthy. Open or broken wire: fault while force is on. Without one fit a bridge |
//! | serial line | PA2, PA3 | ST-LINK | LPUART1, 921 600 baud, the virtual COM port of the board |
//! | alive | PA5 | LD2 | blinks while the loop is healthy |
//!
//! # Timing contract
//!
//! ```text
//! TIM6 update (1 to 20 kHz)                          JEOS                TIM7 update   TIM6 update
//!   |- one 16× for nothing, load cell 16×, accel 16× -|-- control step --|    |             |
//!   0                                             21.5 µs             31 µs  40.6 µs    1 ms … 50 µs
//!   ADC1 triggered            interrupt, encoder    DHR    DAC output changes
//! ```
//!
//! * Every encoder edge that TIM2 counts appears on its *encoder clock output* (CR2.MMS = 1000) and makes TIM5,
//!   free-running at 170 MHz, capture its count (input capture on TRC): the time of the last edge is taken in
//!   hardware, independent of the processor.
//! * The interrupt stamps the sample with TIM5, then reads time, count and time of the last edge until both times agree: see
//!   `encoder`.
//! * The step runs from CCM SRAM and takes 8 to 10 µs (tests/elf, with the waits for memories and buses), and has 19.
//! * The force is written into the DAC's holding register and put out by TIM7, in phase with TIM6 by
//!   construction: the output has no software jitter.
//! * The control interrupt has priority 0, the voltage detector 1, everything else 6 or lower. Only critical sections can delay
//!   it: those of embassy's timer queue, and one for each line of the log, which never waits.
//!
//! **Overrun.** A step that is not done when TIM7 fires gives its force one period late, and is counted ([`late_steps`]); the third in a row
//! latches the fault `late_force`. A
//! step that is still running at the next JEOS delays the next sample: the stamp shows it, and the control step latches the
//! fault `missed_deadline`. If steps stop, the enable line falls by hardware
//! within two periods, see [`mod@enable`]; the console task restarts within 5 ms, and if it cannot, the watchdog resets the
//! chip within [`WATCHDOG_US`]. After an unexpected reset the loop starts with a latched fault that gives
//! the reason: `watchdog`, `panic`, `crash`, `brown_out`.
//!
//! **Clock.** 170 MHz from the crystal X3. If it does not start, from the internal oscillator, which `version` and `status` say. If
//! it stops, the clock security system interrupts: force off, and a restart with the fault `clock`.
//!
//! **Brown-out.** When VDD falls below 2.9 V the voltage detector's interrupt drops the enable line within
//! microseconds, and the fault is raised as for the emergency stop. Below 1.7 V the chip resets (BOR), below 2.8 V with the
//! option byte BOR_LEV = 4; `version` and `status` say if it is less.
//!
//! **Emergency stop.** Open for three periods: the enable line falls in the third, independent of the control step, and the fault
//! is raised every other period while the switch is open, so that `clear` has no effect.
//!
//! **Amplifier fault.** Open for three periods in which the amplifier is enabled: likewise. It is not read while the amplifier is
//! disabled: many report a fault then, or have no supply.

pub mod black_box;
mod ccm;
pub mod enable;
pub mod flash;
mod last_words;
mod listener;
mod pins;
mod setup;
mod stop;
mod timing;

pub use setup::ResetCause;
pub use stop::{make_safe, restart};
pub use timing::{LOOP_HZ, TICK_HZ};

use super::Board;
use crate::app::{Command, Contact, ControlEnds, ControlLoop, Earlier, Lamp};
use crate::presets::NotStored;
use core::sync::atomic::{
    AtomicBool, AtomicPtr, AtomicU32, Ordering::Acquire, Ordering::Relaxed, Ordering::Release,
};
use embassy_executor::SendSpawner;
use embassy_stm32::adc::{Adc, AdcChannel, AdcConfig, Exten, InjectedAdc, SampleTime};
use embassy_stm32::gpio::{Flex, Level, Output, Speed};
use embassy_stm32::interrupt::{InterruptExt, Priority};
use embassy_stm32::peripherals::{self, ADC1, IWDG};
use embassy_stm32::usart::{self, BufferedUart};
use embassy_stm32::wdg::IndependentWatchdog;
use embassy_stm32::{bind_interrupts, interrupt, pac, triggers};
use haptics::{Device, FaultKind, Inputs};
use pins::{AmplifierFault, EmergencyStop};
use static_cell::StaticCell;
use stop::DAC_ZERO;
use timing::{LATCH_COUNTS, PERIOD_TICKS};

/// Time without a healthy loop after which the chip resets, µs.
pub const WATCHDOG_US: u32 = 50_000;
/// Baud rate of the serial line.
pub const BAUD: u32 = 921_600;
/// Bytes from the serial line that can wait for the listener: 5 ms of the line.
pub const RX_BYTES: usize = 512;
/// Bytes after which the listener is woken while the line does not fall idle: 0.35 ms.
const RX_WAKE: usize = 32;
/// Time from the encoder reading, after the conversions, to the change of the force, s.
const DELAY_S: f32 = 20e-6;
/// Longest time from the stamp of a sample to the reading of its edge, ticks: 6 µs.
const SAMPLING_TICKS: u32 = 1_000;

bind_interrupts!(struct Irqs {
    LPUART1 => usart::BufferedInterruptHandler<peripherals::LPUART1>;
});

/// Owned by the interrupt after [`Peripherals::start`]. In this order: see [`ControlLoop`].
#[repr(C)]
struct Loop {
    hardware: Hardware,
    ends: ControlEnds<'static>,
    /// Fault raised in the next step.
    pending: Option<FaultKind>,
    /// Consecutive steps whose force came out late.
    late: u32,
    /// Period of the timers, ticks.
    period_ticks: u32,
    /// Whether a fault of the board was raised in the last period.
    raised: bool,
    control: ControlLoop,
}

/// Option byte BOR_LEV that resets the chip below 2.8 V, before the core misreads anything [ds12288, "Embedded reset and power
/// control block characteristics"].
const BROWN_OUT_LEVEL: u8 = 4;
/// Consecutive late forces that are a fault: the bounds on stiffness and damping hold for [`DELAY_S`], and a late force comes a
/// period later.
const LATE_STEPS: u32 = 3;

impl Loop {
    fn step(&mut self) {
        let mut inputs = self.hardware.sample();
        let amplifier = self.hardware.amplifier_fault.is_open(self.hardware.enabled);
        let trouble = if self.hardware.emergency_stop.is_open(true) {
            Some(FaultKind::EmergencyStop)
        } else if amplifier {
            Some(FaultKind::Amplifier)
        } else if SUPPLY_LOW.load(Relaxed) {
            Some(FaultKind::BrownOut)
        } else {
            None
        };
        // the periods between handle requests, which are answered and denied while the fault lasts
        self.raised = trouble.is_some() && !self.raised;
        let raise = self.pending.take().or(if self.raised { trouble } else { None });
        let step = self.control.steps();
        let outputs = self.control.tick(&mut self.ends, &mut inputs, raise);
        self.hardware.drive(outputs.force, self.control.command(), outputs.amplifier && trouble.is_none());
        black_box::note(step, &outputs);
        let period_ticks = self.control.period_ticks();
        if period_ticks != self.period_ticks {
            setup::change_pace(period_ticks);
            enable::set_period(period_ticks);
            self.period_ticks = period_ticks;
            PERIOD.store(period_ticks, Relaxed);
        }
        let cycles = pac::TIM5.cnt().read().wrapping_sub(inputs.sample_ticks);
        if u32::from(pac::TIM6.cnt().read().cnt()) >= LATCH_COUNTS {
            LATE.store(LATE.load(Relaxed).wrapping_add(1), Relaxed);
            self.late += 1;
        } else {
            self.late = 0;
        }
        if self.late >= LATE_STEPS {
            (self.late, self.pending) = (0, Some(FaultKind::LateForce));
        }
        // no other writer
        if cycles > WORST.load(Relaxed) {
            WORST.store(cycles, Relaxed);
        }
        STEPS.store(STEPS.load(Relaxed).wrapping_add(1), Relaxed);
    }
}

/// State of the control interrupt: passed once, before it is enabled, and owned by it from then on.
static LOOP: AtomicPtr<Loop> = AtomicPtr::new(core::ptr::null_mut());
/// The crystal did not start.
static INTERNAL_CLOCK: AtomicBool = AtomicBool::new(false);
/// The supply is below the threshold of the voltage detector.
static SUPPLY_LOW: AtomicBool = AtomicBool::new(false);
static STEPS: AtomicU32 = AtomicU32::new(0);
static LATE: AtomicU32 = AtomicU32::new(0);
static WORST: AtomicU32 = AtomicU32::new(0);
static PERIOD: AtomicU32 = AtomicU32::new(PERIOD_TICKS);

/// Number of control steps in this time, ms, at the present rate.
#[must_use]
pub fn steps_in_ms(ms: u32) -> u32 {
    (TICK_HZ / 1_000 * ms).checked_div(PERIOD.load(Relaxed)).unwrap_or(0)
}

/// Control steps since boot. Wraps.
#[must_use]
pub fn steps() -> u32 {
    STEPS.load(Relaxed)
}

/// Number of steps that were not done when the DAC latched.
#[must_use]
pub fn late_steps() -> u32 {
    LATE.load(Relaxed)
}

/// Longest time from sample to the write of the force, core cycles.
#[must_use]
pub fn worst_cycles() -> u32 {
    WORST.load(Relaxed)
}

/// The control interrupt: end of the injected sequence of ADC1.
#[interrupt]
fn ADC1_2() {
    // SAFETY: null, or passed by `start` for good. No other owner, and the interrupt cannot interrupt itself.
    if let Some(control) = unsafe { LOOP.load(Acquire).as_mut() } {
        control.step();
    }
}

/// Voltage detector: VDD fell below 2.9 V or is back. A control step may run between any two lines; it sees the flag, or the
/// pin follows it.
#[interrupt]
fn PVD_PVM() {
    pac::EXTI.pr(0).write(|w| w.set_line(setup::PVD_LINE, true));
    let low = pac::PWR.sr2().read().pvdo();
    SUPPLY_LOW.store(low, Relaxed);
    if low {
        enable::drop_now();
        pac::DAC1.dhr12r(0).write(|w| w.set_dhr(DAC_ZERO));
        // if the supply keeps falling, the chip resets and only this records the reason
        last_words::keep(FaultKind::BrownOut);
    } else {
        last_words::forget();
    }
}

/// Peripherals that the control step uses through registers.
struct Hardware {
    _adc: InjectedAdc<'static, ADC1, 3>,
    emergency_stop: Contact<EmergencyStop>,
    amplifier_fault: Contact<AmplifierFault>,
    /// Whether the last step wanted the amplifier.
    enabled: bool,
}

impl Hardware {
    /// Reads the latched inputs and clears the interrupt.
    fn sample(&mut self) -> Inputs {
        let (sample_ticks, count, edge_ticks) = encoder();
        pac::ADC1.isr().write(|w| {
            w.set_jeos(true);
            w.set_jeoc(true);
        });
        // the first conversion after a pause may be wrong [es0430, "ADC: wrong result if conversion done late"]: not used
        let [load_code, accel_code] = [pac::ADC1.jdr(1).read().jdata(), pac::ADC1.jdr(2).read().jdata()];
        Inputs { sample_ticks, count, edge_ticks, load_code, accel_code }
    }

    /// Writes a force to the DAC, which TIM7 latches. Rearms the amplifier's enable line, or drops it at once.
    fn drive(&mut self, force: f32, command: &Command, amplifier: bool) {
        if amplifier {
            let code = dac_code(force, command);
            pac::DAC1.dhr12r(0).write(|w| w.set_dhr(code));
            enable::rearm(self.enabled);
        } else {
            pac::DAC1.dhr12r(0).write(|w| w.set_dhr(DAC_ZERO));
            enable::drop_now();
        }
        self.enabled = amplifier;
    }
}

/// Nearest DAC code of a force, N. Saturates; NaN is no force.
fn dac_code(force: f32, command: &Command) -> u16 {
    let code = force * command.code_per_newton + command.to_round;
    if code.is_nan() {
        return DAC_ZERO;
    }
    // `as` saturates at 0; to the 32 bits in which the processor converts, it is one instruction
    (code as u32).min(4095) as u16
}

/// Time of the sample, count, and time of the count's last edge.
///
/// The stamp comes first, so that every edge after this sample is younger than its stamp, and the next sample finds it within
/// the period. The time of the edge is read before and after the count: if both readings agree, no edge came in between, and
/// the count belongs to it. Only an edge whose capture takes longer than two reads is counted but not yet timed; the estimator
/// waits for its time ([`haptics::estimator`]). Edges are at least 1 µs apart, so the second attempt succeeds; a limit of three
/// bounds the time.
#[inline]
fn encoder() -> (u32, u32, u32) {
    let (tim2, tim5) = (pac::TIM2, pac::TIM5);
    let stamp = tim5.cnt().read();
    let mut edge = tim5.ccr(0).read();
    let mut count = tim2.cnt().read();
    for _ in 0..3 {
        let after = tim5.ccr(0).read();
        if after == edge {
            break;
        }
        edge = after;
        count = tim2.cnt().read();
    }
    // an edge since the stamp is at the sample: none is in the future
    let sample = if edge.wrapping_sub(stamp) < SAMPLING_TICKS { edge } else { stamp };
    (sample, count, edge)
}

/// The board before its loop runs.
pub struct Peripherals {
    hardware: Hardware,
    /// Serial line.
    pub console: BufferedUart<'static>,
    /// Watchdog, not yet running.
    pub watchdog: IndependentWatchdog<'static, IWDG>,
    /// LD2.
    pub led: Lamp<Output<'static>>,
    /// Reason of the start.
    pub reset_cause: ResetCause,
}

impl Peripherals {
    /// Boots the board: clocks, pins, timers, converters. The amplifier is off and the force zero throughout.
    #[must_use]
    pub fn boot() -> Self {
        setup::boost();
        setup::stack_floats_at_once();
        setup::guard_stack();
        let crystal = setup::start_crystal();
        let p = embassy_stm32::init(setup::clocks(crystal));
        setup::full_speed(crystal);
        INTERNAL_CLOCK.store(!crystal, Relaxed);
        setup::prefetch();
        setup::freeze_watchdog_for_debuggers();
        let reset_cause = setup::reset_cause();
        // first, keep the amplifier off
        enable::start(p.PB5, PERIOD_TICKS);
        setup::start_dac();
        Flex::new(p.PA4).set_as_analog();
        setup::start_encoder(p.PA0, p.PA1);

        let mut settings = usart::Config::default();
        settings.baudrate = BAUD;
        settings.eager_reads = Some(RX_WAKE);
        static TX: StaticCell<[u8; 1024]> = StaticCell::new();
        static RX: StaticCell<[u8; RX_BYTES]> = StaticCell::new();
        // pins and rate are constants: this cannot fail
        let console = BufferedUart::new(
            p.LPUART1,
            p.PA3,
            p.PA2,
            TX.init([0; 1024]),
            RX.init([0; RX_BYTES]),
            Irqs,
            settings,
        )
        .expect("LPUART1 at 921 600 baud");

        let adc = Adc::new(p.ADC1, AdcConfig::default());
        pac::ADC1.cfgr2().modify(|w| {
            w.set_jovse(true);
            w.set_ovsr(3); // 16 conversions …
            w.set_ovss(0); // … summed, not shifted: 16 bit
        });
        let time = SampleTime::CYCLES6_5;
        // SAFETY: both belong to the converter, which owns them for good
        let again = unsafe { p.PC0.clone_unchecked() };
        let adc = adc.setup_injected_conversions(
            [(again.degrade_adc(), time), (p.PC0.degrade_adc(), time), (p.PC1.degrade_adc(), time)],
            triggers::TIM6_TRGO,
            Exten::RISING_EDGE,
            true,
        );
        Self {
            hardware: Hardware {
                _adc: adc,
                emergency_stop: Contact::new(EmergencyStop::new(p.PC7)),
                amplifier_fault: Contact::new(AmplifierFault::new(p.PB10)),
                enabled: false,
            },
            console,
            watchdog: IndependentWatchdog::new(p.IWDG, WATCHDOG_US),
            led: Lamp::new(Output::new(p.PA5, Level::Low, Speed::Low)),
            reset_cause,
        }
    }

    /// Flash pages for presets.
    ///
    /// # Errors
    /// The option bytes make one bank of the flash. Pages then have other sizes and places, and the core stalls for 22 ms while
    /// one is erased, with the last force on.
    pub fn pages(&mut self) -> Result<flash::Pages, NotStored> {
        if pac::FLASH.optr().read().dbank() { Ok(flash::Pages::new()) } else { Err(NotStored::SingleBank) }
    }

    /// Starts the loop in the control interrupt. Returns the peripherals of the tasks.
    pub fn start(self, control: ControlLoop, ends: ControlEnds<'static>) -> Rest {
        let Self { hardware, console, watchdog, led, reset_cause } = self;
        let boot_fault = reset_cause.fault();
        black_box::open(boot_fault);
        static RUNNING: StaticCell<Loop> = StaticCell::new();
        let running = RUNNING.init_with(|| Loop {
            hardware,
            control,
            ends,
            pending: boot_fault,
            late: 0,
            raised: false,
            period_ticks: PERIOD_TICKS,
        });
        LOOP.store(running, Release);
        interrupt::ADC1_2.set_priority(Priority::P0);
        interrupt::PVD_PVM.set_priority(Priority::P1); // right below the control step
        interrupt::LPUART1.set_priority(Priority::P6);
        interrupt::TIM4.set_priority(Priority::P7); // embassy-time
        // SAFETY: outside any critical section.
        unsafe {
            interrupt::ADC1_2.enable();
            interrupt::PVD_PVM.enable();
        }
        setup::start_voltage_detector();
        setup::start_pace();
        Rest { console, watchdog, led, listener: listener::start() }
    }
}

/// Peripherals of the tasks while the loop runs.
pub struct Rest {
    /// Serial line.
    pub console: BufferedUart<'static>,
    /// Watchdog, not yet running.
    pub watchdog: IndependentWatchdog<'static, IWDG>,
    /// LD2.
    pub led: Lamp<Output<'static>>,
    /// Executor above the tasks.
    pub listener: SendSpawner,
}

/// The board as the tasks see it.
#[derive(Debug, Clone, Copy, Default)]
pub struct Nucleo;

impl Board for Nucleo {
    fn name(&self) -> &'static str {
        "NUCLEO-G474RE"
    }

    fn device(&self) -> Device {
        // the rig of [thesis, table 3-1] with the clock and rate of this board
        Device { tick_hz: TICK_HZ, period: 1.0 / LOOP_HZ as f32, delay: DELAY_S, ..Device::default() }
    }

    fn now_ms(&self) -> u32 {
        embassy_time::Instant::now().as_millis() as u32
    }

    fn off(&mut self) {
        enable::drop_now();
    }

    fn clock(&self) -> &'static str {
        if self.clock_is_off() {
            "internal clock, off by up to 1 %: the crystal does not start"
        } else {
            "crystal"
        }
    }

    fn clock_is_off(&self) -> bool {
        INTERNAL_CLOCK.load(Relaxed)
    }

    fn weak_brown_out(&self) -> Option<u8> {
        Some(pac::FLASH.optr().read().bor_lev()).filter(|level| *level < BROWN_OUT_LEVEL)
    }

    fn late_steps(&self) -> u32 {
        late_steps()
    }

    fn store(&mut self, key: u8, item: &[u8]) {
        flash::store(key, item);
    }

    fn stored(&mut self) -> Option<Result<(), NotStored>> {
        flash::stored()
    }

    fn lasting(&self) -> &str {
        "in flash"
    }

    fn earlier(&self) -> Option<Earlier> {
        black_box::earlier()
    }

    fn forget(&mut self) {
        black_box::forget();
    }
}

/// A fault of the processor itself.
#[cortex_m_rt::exception]
unsafe fn HardFault(frame: &cortex_m_rt::ExceptionFrame) -> ! {
    make_safe();
    // SAFETY: a read of a register that only the core writes
    let cfsr = unsafe { (*cortex_m::peripheral::SCB::PTR).cfsr.read() };
    black_box::crashed_at(frame.pc(), frame.lr(), cfsr);
    restart(FaultKind::Crash)
}

/// An unexpected interrupt.
#[cortex_m_rt::exception]
unsafe fn DefaultHandler(_: i16) {
    restart(FaultKind::Crash)
}
