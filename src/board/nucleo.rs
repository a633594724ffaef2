//! What the NUCLEO-64 boards share: the control interrupt, its peripherals and the tasks' view of them, and, with the files of
//! the chips, the only `unsafe` of the firmware.
//!
//! Timers, converter, enable line, flash and faults are the same blocks on the STM32G4 and the STM32L4. What differs is in the
//! file of the chip, `super::chip`: clocks, encoder inputs, the sequence of conversions, rates and addresses. Pins and timing
//! contract stand there.

#[cfg(not(feature = "load-cell-converter"))]
mod analog;
pub mod black_box;
pub mod enable;
mod fast_ram;
pub mod flash;
mod last_words;
mod listener;
mod pins;
#[cfg(not(feature = "absolute-encoder"))]
mod quadrature;
mod serial;
mod setup;
mod stop;
mod timing;

#[cfg(feature = "absolute-encoder")]
use super::chip::Absolute as Position;
#[cfg(feature = "index-pulse")]
use super::chip::Indexed as Position;
#[cfg(feature = "load-cell-converter")]
use super::chip::Load24 as Load;
#[cfg(not(any(feature = "absolute-encoder", feature = "index-pulse")))]
use Quadrature as Position;
#[cfg(not(feature = "load-cell-converter"))]
use analog::Analog as Load;
#[cfg(not(feature = "absolute-encoder"))]
pub use quadrature::Quadrature;
pub use serial::{RX_BYTES, SerialLine};
pub use setup::ResetCause;
pub use stop::{make_safe, restart};
pub use timing::{LOOP_HZ, TICK_HZ};

use super::{Board, Middle, MiddleNews, RealTime, RealTimeLoop, chip};
use crate::app::{Command, Contact, ControlEnds, ControlLoop, Earlier, Lamp};
use crate::presets::NotStored;
use core::sync::atomic::{
    AtomicBool, AtomicPtr, AtomicU32, Ordering::Acquire, Ordering::Relaxed, Ordering::Release,
};
use embassy_executor::SendSpawner;
use embassy_stm32::gpio::{Flex, Level, Output, Speed};
use embassy_stm32::interrupt::{InterruptExt, Priority};
use embassy_stm32::peripherals::IWDG;
use embassy_stm32::wdg::IndependentWatchdog;
use embassy_stm32::{interrupt, pac};
use haptics::{Device, FaultKind, Inputs, Outputs};
use pins::{AmplifierFault, EmergencyStop};
use static_cell::StaticCell;
use stop::DAC_ZERO;
use timing::{LATCH_COUNTS, PERIOD_TICKS};

/// Time without a healthy loop after which the chip resets, µs.
pub const WATCHDOG_US: u32 = 50_000;

/// Owned by the interrupt after [`Peripherals::start`]. In this order: see [`ControlLoop`].
#[repr(C)]
struct Loop {
    ends: ControlEnds<'static>,
    real_time: RealTimeLoop<Hardware>,
}

/// Option byte BOR_LEV that resets the chip below 2.8 V, before the core misreads anything [ds12288, "Embedded reset and power
/// control block characteristics"].
const BROWN_OUT_LEVEL: u8 = 4;

/// State of the control interrupt: passed once, before it is enabled, and owned by it from then on.
static LOOP: AtomicPtr<Loop> = AtomicPtr::new(core::ptr::null_mut());
/// The crystal did not start.
static INTERNAL_CLOCK: AtomicBool = AtomicBool::new(false);
/// Voltage of the supply at the start, which is the reference of both converters, mV.
static SUPPLY_MV: AtomicU32 = AtomicU32::new(0);
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
        control.real_time.step(&mut control.ends);
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
    _converter: chip::Converter,
    position: Position,
    load: Load,
    emergency_stop: Contact<EmergencyStop>,
    amplifier_fault: Contact<AmplifierFault>,
    /// Whether the last step wanted the amplifier.
    enabled: bool,
}

impl RealTime for Hardware {
    /// Reads the latched inputs and clears the interrupt.
    #[inline(always)]
    fn sample(&mut self) -> Inputs {
        let (sample_ticks, count, edge_ticks) = self.position.sample();
        pac::ADC1.isr().write(|w| {
            w.set_jeos(true);
            w.set_jeoc(true);
        });
        // the first conversion after a pause may be wrong [es0430, "ADC: wrong result if conversion done late"]: not used
        let [load_code, accel_code] = [pac::ADC1.jdr(1).read().jdata(), pac::ADC1.jdr(2).read().jdata()];
        let load_code = self.load.sample(load_code);
        Inputs { sample_ticks, count, edge_ticks, load_code, accel_code }
    }

    #[inline(always)]
    fn trouble(&mut self) -> Option<FaultKind> {
        let amplifier = self.amplifier_fault.is_open(self.enabled);
        if self.emergency_stop.is_open(true) {
            Some(FaultKind::EmergencyStop)
        } else if amplifier {
            Some(FaultKind::Amplifier)
        } else if SUPPLY_LOW.load(Relaxed) {
            Some(FaultKind::BrownOut)
        } else {
            self.position.trouble().or(self.load.trouble())
        }
    }

    /// Writes a force to the DAC, which TIM7 latches.
    #[inline(always)]
    fn output(&mut self, force: Option<f32>, command: &Command) {
        let code = force.map_or(DAC_ZERO, |force| dac_code(force, command));
        pac::DAC1.dhr12r(0).write(|w| w.set_dhr(code));
    }

    /// Rearms the amplifier's enable line, or drops it at once.
    #[inline(always)]
    fn enable(&mut self, on: bool) {
        if on {
            enable::rearm(self.enabled);
        } else {
            enable::drop_now();
        }
        self.enabled = on;
    }

    #[inline(always)]
    fn pace(&mut self, period_ticks: u32) {
        setup::change_pace(period_ticks);
        enable::set_period(period_ticks);
        PERIOD.store(period_ticks, Relaxed);
    }

    #[inline(always)]
    fn end(&mut self, step: u32, inputs: &Inputs, outputs: &Outputs) -> bool {
        black_box::note(step, outputs);
        let cycles = pac::TIM5.cnt().read().wrapping_sub(inputs.sample_ticks);
        let elapsed = u32::from(pac::TIM6.cnt().read().cnt());
        // no other writer
        if cycles > WORST.load(Relaxed) {
            WORST.store(cycles, Relaxed);
        }
        STEPS.store(STEPS.load(Relaxed).wrapping_add(1), Relaxed);
        let late = elapsed >= LATCH_COUNTS;
        if late {
            LATE.store(LATE.load(Relaxed).wrapping_add(1), Relaxed);
        }
        late
    }
}

/// Supply at which the factory converted the internal reference, mV [ds12288, "Internal voltage reference calibration values"].
const FACTORY_MV: u32 = 3_000;
/// Supplies with which the chip runs, mV: from the threshold of the voltage detector to the largest of the data sheet.
const SUPPLIES_MV: core::ops::RangeInclusive<u32> = 2_900..=3_600;

/// Supply, mV, from the internal reference: the sum of 16 conversions, and the one of the factory. The nominal 3.3 V if they are no
/// reading of it.
fn supply_mv(sum: u32, factory: u16) -> u32 {
    let mv = (FACTORY_MV * 16 * u32::from(factory) + sum / 2).checked_div(sum).unwrap_or(0);
    if SUPPLIES_MV.contains(&mv) { mv } else { (1_000.0 * haptics::NOMINAL_SUPPLY) as u32 }
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

/// The board before its loop runs.
pub struct Peripherals {
    hardware: Hardware,
    /// Serial line.
    pub serial: SerialLine,
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
        chip::before_clocks();
        setup::stack_floats_at_once();
        setup::guard_stack();
        let crystal = setup::start_crystal();
        let p = embassy_stm32::init(chip::clocks(crystal));
        chip::full_speed(crystal);
        INTERNAL_CLOCK.store(!crystal, Relaxed);
        setup::prefetch();
        chip::freeze_watchdog_for_debuggers();
        let reset_cause = setup::reset_cause();
        // first, keep the amplifier off
        enable::start(p.PB5, PERIOD_TICKS);
        setup::start_dac();
        Flex::new(p.PA4).set_as_analog();
        // SAFETY: the quadrature encoder of this chip leaves it alone
        #[cfg(feature = "load-cell-converter")]
        let nss = unsafe { p.PA15.clone_unchecked() };
        chip::start_encoder(p.PA0, p.PA1, p.PA15, p.PB3);
        #[cfg(feature = "absolute-encoder")]
        let position = Position::new([p.PB12.into(), p.PB13.into(), p.PB14.into(), p.PB15.into()]);
        #[cfg(feature = "index-pulse")]
        let position = Position::new(p.PA9);
        #[cfg(not(any(feature = "absolute-encoder", feature = "index-pulse")))]
        let position = Position;

        let serial = SerialLine::open(p.PA2, p.PA3, p.DMA1_CH7);

        let (converter, reference) = chip::start_converter(p.ADC1, p.PC0, p.PC1);
        SUPPLY_MV.store(supply_mv(reference, pac::VREFINTCAL.data().read()), Relaxed);
        #[cfg(feature = "load-cell-converter")]
        let load = Load::new(
            [nss.into(), p.PC10.into(), p.PC11.into(), p.PC12.into()],
            SUPPLY_MV.load(Relaxed) as f32 / 1_000.0,
        );
        #[cfg(not(feature = "load-cell-converter"))]
        let load = Load;
        Self {
            hardware: Hardware {
                _converter: converter,
                position,
                load,
                emergency_stop: Contact::new(EmergencyStop::new(p.PC7)),
                amplifier_fault: Contact::new(AmplifierFault::new(p.PB10)),
                enabled: false,
            },
            serial,
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
        if chip::has_two_banks() { Ok(flash::Pages::new()) } else { Err(NotStored::SingleBank) }
    }

    /// Reads an item of the flash that is the board's own.
    pub fn load(key: u8, item: &[u8]) {
        Position::load(key, item);
    }

    /// Begins to measure the position. True if it is from the middle of the stroke.
    pub fn begin_position(&mut self, device: &Device) -> bool {
        self.hardware.position.begin(device)
    }

    /// Starts the loop in the control interrupt. Returns the peripherals of the tasks.
    pub fn start(self, control: ControlLoop, ends: ControlEnds<'static>) -> Rest {
        let Self { hardware, serial, watchdog, led, reset_cause } = self;
        let boot_fault = reset_cause.fault();
        black_box::open(boot_fault);
        static RUNNING: StaticCell<Loop> = StaticCell::new();
        let running =
            RUNNING.init_with(|| Loop { ends, real_time: RealTimeLoop::new(hardware, control, boot_fault) });
        LOOP.store(running, Release);
        interrupt::ADC1_2.set_priority(Priority::P0);
        interrupt::PVD_PVM.set_priority(Priority::P1); // right below the control step
        chip::SERIAL_INTERRUPT.set_priority(Priority::P6);
        interrupt::TIM4.set_priority(Priority::P7); // embassy-time
        // SAFETY: outside any critical section.
        unsafe {
            interrupt::ADC1_2.enable();
            interrupt::PVD_PVM.enable();
        }
        setup::start_voltage_detector();
        setup::start_pace();
        Position::follow();
        Load::follow();
        Rest { serial, watchdog, led, listener: listener::start() }
    }
}

/// Peripherals of the tasks while the loop runs.
pub struct Rest {
    /// Serial line.
    pub serial: SerialLine,
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
        chip::NAME
    }

    fn device(&self) -> Device {
        // the rig of [thesis, table 3-1] with the clock and rate of this board
        Device {
            tick_hz: TICK_HZ,
            period: 1.0 / LOOP_HZ as f32,
            delay: chip::DELAY_S,
            effect_cycles: chip::EFFECT_CYCLES,
            metre_per_count: Position::metre_per_count(Device::default().metre_per_count),
            ..Device::default()
        }
        .at_supply(SUPPLY_MV.load(Relaxed) as f32 / 1_000.0)
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

    fn middle(&mut self, now: Middle, reversed: bool) -> MiddleNews {
        // the encoder's own counts, and back
        let own = |count: u32| if reversed { count.wrapping_neg() } else { count };
        let now = if let Middle::At(count) = now { Middle::At(own(count)) } else { now };
        let news = Position::middle(now);
        if let MiddleNews::Is(count) = news { MiddleNews::Is(own(count)) } else { news }
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
