//! NUCLEO-G474RE: pins, timing contract, and the registers that only its STM32G474 has. The rest is in [`super::nucleo`].
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
//! With the feature `absolute-encoder`, in the place of the encoder's A and B: an MT6835 on SPI2, NSS PB12, SCK PB13, MISO PB14,
//! MOSI PB15. With `load-cell-converter`, in the place of the load cell's PC0: an ADS131M02 on SPI3, NSS PA15, SCK PC10, MISO PC11,
//! MOSI PC12. Their frames begin with the updates of TIM6 and of TIM7. With `index-pulse`, beside A and B: the encoder's Z on PA9 (D8),
//! TIM2 channel 3, pull-up.
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
//! * The interrupt stamps the sample with TIM5, then reads time, count and time of the last edge until both times agree.
//! * The step runs from CCM SRAM and takes 8 to 10 µs (tests/elf, with the waits for memories and buses), and has 19.
//! * The force is written into the DAC's holding register and put out by TIM7, in phase with TIM6 by
//!   construction: the output has no software jitter.
//! * The control interrupt has priority 0, the voltage detector 1, everything else 6 or lower. Only critical sections can delay
//!   it: those of embassy's timer queue, and one for each line of the log, which never waits.
//!
//! **Overrun.** A step that is not done when TIM7 fires gives its force one period late, and is counted ([`super::nucleo::late_steps`]); the third in a row
//! latches the fault `late_force`. A
//! step that is still running at the next JEOS delays the next sample: the stamp shows it, and the control step latches the
//! fault `missed_deadline`. If steps stop, the enable line falls by hardware
//! within two periods, see [`super::nucleo::enable`]; the console task restarts within 5 ms, and if it cannot, the watchdog resets the
//! chip within [`super::nucleo::WATCHDOG_US`]. After an unexpected reset the loop starts with a latched fault that gives
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

#[cfg(feature = "absolute-encoder")]
mod absolute;
#[cfg(any(feature = "absolute-encoder", feature = "load-cell-converter"))]
mod frames;
#[cfg(feature = "index-pulse")]
mod index;
#[cfg(feature = "load-cell-converter")]
mod load_cell;

#[cfg(feature = "absolute-encoder")]
pub use absolute::Absolute;
use embassy_stm32::adc::{Adc, AdcChannel, AdcConfig, Exten, InjectedAdc, SampleTime};
use embassy_stm32::gpio::{AfType, Flex, Pull};
use embassy_stm32::interrupt::{Interrupt, Priority};
use embassy_stm32::peripherals::{self, ADC1, PA0, PA1, PA15, PB3, PC0, PC1, TIM2, TIM5};
use embassy_stm32::{Config, Peri, bind_interrupts, dma, pac, rcc, triggers, usart};
#[cfg(feature = "index-pulse")]
pub use index::Indexed;
#[cfg(feature = "load-cell-converter")]
pub use load_cell::Load24;
use pac::timer::vals::{CcmrInputCcs, FilterValue, Mms, Sms, Ts, Urs};

/// Name for people.
pub const NAME: &str = "NUCLEO-G474RE";
/// Rate of core, timers and time stamps, Hz.
pub const TICK_HZ: u32 = 170_000_000;
/// From the start of conversion to the change of the force, ns. The conversions take 21.5 µs.
pub const LATCH_NS: u32 = 40_600;
/// Time from the encoder reading to the change of the force, s: after the conversions, or 3 µs after the trigger, with the 2 µs
/// that the absolute encoder takes.
pub const DELAY_S: f32 = if cfg!(feature = "absolute-encoder") { 40e-6 } else { 20e-6 };
/// Cycles that a dear law and effects may take: with the worst step they end before the force is latched. Sensors on a bus take some of them.
pub const EFFECT_CYCLES: u32 = 1_200
    - if cfg!(feature = "absolute-encoder") { 260 } else { 0 }
    - if cfg!(feature = "load-cell-converter") { 360 } else { 0 };
/// Address of bank 2 of the flash. The code is in bank 1.
pub const BANK_2: u32 = 0x0804_0000;
/// Address of the presets, the last 10 KiB.
pub const PRESETS: u32 = 0x0807_d800;
/// Crystal X3 of the board, Hz.
const CRYSTAL_HZ: u32 = 24_000_000;

/// The injected conversions, which run for good.
pub type Converter = InjectedAdc<'static, ADC1, 3>;

/// The serial line of the ST-LINK.
pub type Serial = peripherals::LPUART1;
/// Its interrupt.
pub const SERIAL_INTERRUPT: Interrupt = Interrupt::LPUART1;

bind_interrupts!(pub struct Irqs {
    LPUART1 => usart::BufferedInterruptHandler<peripherals::LPUART1>;
    DMA1_CHANNEL7 => dma::InterruptHandler<peripherals::DMA1_CH7>;
});

/// What the clocks need first.
pub fn before_clocks() {
    boost();
}

/// Switches the crystal on.
pub fn start_crystal() {
    pac::RCC.cr().modify(|w| w.set_hseon(true));
}

/// Clocks: 170 MHz from the crystal, or from the internal oscillator without one (boost mode). The AHB is divided by two until
/// [`full_speed`].
pub fn clocks(crystal: bool) -> Config {
    use rcc::{AHBPrescaler, Hse, HseMode, Pll, PllMul, PllPreDiv, PllRDiv, PllSource, Sysclk, mux};
    let mut config = Config::default();
    // the core falls back to it when the crystal stops
    config.rcc.hsi = true;
    config.rcc.boost = true;
    let freq = embassy_stm32::time::Hertz(CRYSTAL_HZ);
    config.rcc.hse = crystal.then_some(Hse { freq, mode: HseMode::Oscillator });
    config.rcc.pll = Some(Pll {
        source: if crystal { PllSource::HSE } else { PllSource::HSI },
        prediv: if crystal { PllPreDiv::DIV6 } else { PllPreDiv::DIV4 },
        mul: PllMul::MUL85,
        divp: None,
        divq: None,
        divr: Some(PllRDiv::DIV2),
    });
    config.rcc.sys = Sysclk::PLL1_R;
    config.rcc.ahb_pre = AHBPrescaler::DIV2;
    config.rcc.mux.adc12sel = mux::Adcsel::SYS;
    // not of the bus, whose rate embassy believes to stay halved
    config.rcc.mux.lpuart1sel = mux::Uartsel::SYS;
    // every interrupt starts at 0, the highest; that belongs to the control step
    config.bdma_interrupt_priority = Priority::P6;
    config
}

/// Undivided buses, and the clock security system if the crystal runs.
///
/// A switch to more than 80 MHz must run with the AHB divided by two for a microsecond [rm0440, "System clock (SYSCLK)
/// selection"]. embassy-stm32 0.6 ends that division with the write that switches, so it is told to keep it.
pub fn full_speed(crystal: bool) {
    cortex_m::asm::delay(TICK_HZ / 1_000_000); // 2 µs at half the rate
    pac::FLASH.acr().modify(|w| w.set_latency(pac::flash::vals::Latency::WS4));
    while pac::FLASH.acr().read().latency() != pac::flash::vals::Latency::WS4 {}
    pac::RCC.cfgr().modify(|w| w.set_hpre(pac::rcc::vals::Hpre::DIV1));
    // the clock of embassy-time, set for the halved bus
    let tim4 = pac::TIM4;
    tim4.psc().write_value((TICK_HZ / embassy_time::TICK_HZ as u32 - 1) as u16);
    tim4.cr1().modify(|w| w.set_urs(Urs::COUNTER_ONLY));
    tim4.egr().write(|w| w.set_ug(true)); // loads it
    tim4.cr1().modify(|w| w.set_urs(Urs::ANY_EVENT));
    if crystal {
        pac::RCC.cr().modify(|w| w.set_csson(true));
    }
}

/// Range 1 boost mode, required above 150 MHz [rm0440, "PWR_CR5"].
///
/// `Config::boost` should do this, but stm32-metapac 21 has R1MODE in bit 0 of the register; it is bit 8.
fn boost() {
    pac::RCC.apb1enr1().modify(|w| w.set_pwren(true));
    pac::PWR.cr5().modify(|w| w.0 &= !(1 << 8));
}

/// Whether the flash is two banks, as its option bytes say.
pub fn has_two_banks() -> bool {
    pac::FLASH.optr().read().dbank()
}

/// Starts the erasure of the page that FLASH_CR has.
pub fn start_erasure() {
    pac::FLASH.cr().modify(|w| w.set_strt(true));
}

/// Stops the watchdog while a debugger halts the core. The pulse of the enable line runs on.
pub fn freeze_watchdog_for_debuggers() {
    pac::DBGMCU.apb1lfzr().modify(|w| w.set_iwdg(true));
}

/// Sets the voltage detector to 2.9 V: below it a 3.3 V regulator has failed.
pub fn start_voltage_detector() {
    pac::PWR.cr2().modify(|w| {
        w.set_pls(6);
        w.set_pvde(true);
    });
}

/// Suits the DAC to the rate of the bus.
pub fn set_dac_speed() {
    pac::DAC1.mcr().write(|w| w.set_hfsel(2)); // the bus is faster than 160 MHz
}

/// TIM2 counts all four quadrature edges of a period through a filter of 94 ns. TIM5 captures its own count on each edge.
pub fn start_encoder(
    a: Peri<'static, PA0>,
    b: Peri<'static, PA1>,
    _: Peri<'static, PA15>,
    _: Peri<'static, PB3>,
) {
    rcc::enable_and_reset::<TIM2>();
    rcc::enable_and_reset::<TIM5>();
    for mut pin in [Flex::new(a), Flex::new(b)] {
        pin.set_as_af_unchecked(1, AfType::input(Pull::Up));
        core::mem::forget(pin); // dropping it would disconnect the pin
    }
    let (tim2, tim5) = (pac::TIM2, pac::TIM5);
    tim2.ccmr_input(0).write(|w| {
        for channel in 0..2 {
            w.set_ccs(channel, CcmrInputCcs::TI4); // its own input
            w.set_icf(channel, FilterValue::FDTS_DIV2_N8);
        }
    });
    tim2.smcr().write(|w| w.set_sms(Sms::ENCODER_MODE_3));
    tim2.cr2().write(|w| w.set_mms(Mms::ENCODER_CLOCK_OUTPUT));
    tim2.arr().write_value(u32::MAX);

    tim5.arr().write_value(u32::MAX);
    tim5.smcr().write(|w| w.set_ts(Ts::ITR1)); // TIM2's trigger output
    tim5.ccmr_input(0).write(|w| w.set_ccs(0, CcmrInputCcs::TRC));
    tim5.ccer().write(|w| w.set_cce(0, true));
    tim5.cr1().write(|w| w.set_cen(true));
    tim2.cr1().write(|w| w.set_cen(true));
}

/// Load cell and accelerometer: 16 conversions of each, summed, when TIM6 says so. Returns the same sum of the internal reference,
/// taken before.
pub fn start_converter(
    adc: Peri<'static, ADC1>,
    load: Peri<'static, PC0>,
    accel: Peri<'static, PC1>,
) -> (Converter, u32) {
    let mut adc = Adc::new(adc, AdcConfig::default());
    pac::ADC1.cfgr2().modify(|w| {
        w.set_rovse(true);
        w.set_jovse(true);
        w.set_ovsr(3); // 16 conversions …
        w.set_ovss(0); // … summed, not shifted: 16 bit
    });
    let mut reference = adc.enable_vrefint();
    cortex_m::asm::delay(TICK_HZ / 1_000_000 * 12); // its start
    // 5.8 µs: at least 4 [ds12288, "Embedded internal voltage reference"]
    let sum = adc.blocking_read(&mut reference, SampleTime::CYCLES247_5).into();
    pac::ADC1.cfgr2().modify(|w| w.set_rovse(false));
    let time = SampleTime::CYCLES6_5;
    // SAFETY: both belong to the converter, which owns them for good
    let again = unsafe { load.clone_unchecked() };
    let converter = adc.setup_injected_conversions(
        [(again.degrade_adc(), time), (load.degrade_adc(), time), (accel.degrade_adc(), time)],
        triggers::TIM6_TRGO,
        Exten::RISING_EDGE,
        true,
    );
    (converter, sum)
}
