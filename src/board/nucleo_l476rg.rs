//! NUCLEO-L476RG: pins, timing contract, and the registers that only its STM32L476 has. The rest is in [`super::nucleo`].
//!
//! It has not run yet, neither on a board nor in the emulator, which has the peripherals of the STM32G474.
//!
//! # Pins
//!
//! Those of the NUCLEO-G474RE, on the same connectors, and each line of the encoder on a second one.
//!
//! | signal | pin | connector | how |
//! | --- | --- | --- | --- |
//! | encoder A, B, for the time of an edge | PA0, PA1 | A0, A1 | TIM5 channels 1, 2, pull-up, 3.3 V |
//! | encoder A, B, for the count | PA15, PB3 | CN7-17, D3 | TIM2 channels 1, 2, pull-up, 3.3 V |
//! | force command | PA4 | A2 | DAC1 channel 1, 0.2 V … 3.1 V: 1.65 V is no force, 1 V is 6.67 N |
//! | load cell | PC0 | A5 | ADC1 input 1, 0 V … 3.3 V, from at most 250 Ω |
//! | accelerometer | PC1 | A4 | ADC1 input 2, likewise |
//! | amplifier enable | PB5 | D4 | TIM3 channel 2, high: on. **Fit 10 kΩ to ground**: the pin floats while the chip is in reset |
//! | emergency stop | PC7 | D9 | closed to ground: run. Open, pressed or broken wire: fault. Without a switch fit a bridge |
//! | amplifier fault | PB10 | D6 | closed to ground: healthy. Open or broken wire: fault while force is on. Without one fit a bridge |
//! | serial line | PA2, PA3 | ST-LINK | USART2, 921 600 baud, the virtual COM port of the board |
//! | alive | PA5 | LD2 | blinks while the loop is healthy |
//!
//! # What differs from the NUCLEO-G474RE
//!
//! | what | here | there |
//! | --- | --- | --- |
//! | clock | 80 MHz, from the 8 MHz that the ST-LINK gives on MCO (boards MB1136 C-02 and later), else from the internal oscillator | 170 MHz from the crystal X3 |
//! | time of an edge | TIM5 captures the exclusive or of both lines, because TIM2 has no encoder clock output | TIM5 captures on TIM2's encoder clock |
//! | filter of the encoder | 100 ns | 94 ns |
//! | conversions | 15 µs, set up through registers: the HAL has no injected conversions for this chip | 21.5 µs |
//! | from sample to force | 25.6 µs, 2 048 cycles: law and effects may take 330 cycles beyond a step | 20 µs, 3 400 cycles: 1 200 |
//! | flash for the code | 512 KiB | 256 KiB |
//! | measured cycles | none; the core and the memory of the control path, SRAM2 without wait states, are alike | `tests/elf` |
//!
//! # Timing contract
//!
//! ```text
//! TIM6 update (1 to 20 kHz)                          JEOS                TIM7 update   TIM6 update
//!   |- one 16× for nothing, load cell 16×, accel 16× -|-- control step --|    |             |
//!   0                                               15 µs              40.6 µs        1 ms … 50 µs
//!   ADC1 triggered            interrupt, encoder    DHR    DAC output changes
//! ```

use embassy_stm32::adc::Adc;
use embassy_stm32::gpio::{AfType, Flex, Pull};
use embassy_stm32::interrupt::{Interrupt, Priority};
use embassy_stm32::peripherals::{self, ADC1, PA0, PA1, PA15, PB3, PC0, PC1, TIM2, TIM5};
use embassy_stm32::{Config, Peri, bind_interrupts, dma, pac, rcc, usart};
use pac::adc::vals::{OversamplingRatio, OversamplingShift, SampleTime};
use pac::timer::vals::{CcmrInputCcs, FilterValue, Sms};

/// Name for people.
pub const NAME: &str = "NUCLEO-L476RG";
/// Rate of core, timers and time stamps, Hz.
pub const TICK_HZ: u32 = 80_000_000;
/// From the start of conversion to the change of the force, ns. The conversions take 15 µs.
pub const LATCH_NS: u32 = 40_600;
/// Time from the encoder reading, after the conversions, to the change of the force, s.
pub const DELAY_S: f32 = 25.6e-6;
/// Cycles that effects may take: with the worst step, 1 685 cycles, they end before the force is latched.
pub const EFFECT_CYCLES: u32 = 330;
/// Address of bank 2 of the flash. The code is in bank 1.
pub const BANK_2: u32 = 0x0808_0000;
/// Address of the presets, the last 10 KiB.
pub const PRESETS: u32 = 0x080f_d800;
/// Clock that the ST-LINK gives, Hz.
const CLOCK_HZ: u32 = 8_000_000;
/// Number of TIM6's trigger output among the triggers of injected conversions [rm0351, "External triggers for injected channels"].
const TIM6_TRGO: u8 = 14;
/// Inputs of load cell and accelerometer.
const LOAD: u8 = 1;
const ACCEL: u8 = 2;

/// The injected conversions, which run for good.
pub struct Converter {
    _adc: Adc<'static, ADC1>,
    _pins: (Flex<'static>, Flex<'static>),
}

/// The serial line of the ST-LINK.
pub type Serial = peripherals::USART2;
/// Its interrupt.
pub const SERIAL_INTERRUPT: Interrupt = Interrupt::USART2;

bind_interrupts!(pub struct Irqs {
    USART2 => usart::BufferedInterruptHandler<peripherals::USART2>;
    DMA1_CHANNEL7 => dma::InterruptHandler<peripherals::DMA1_CH7>;
});

/// What the clocks need first.
pub fn before_clocks() {
    pac::RCC.apb1enr1().modify(|w| w.set_pwren(true));
}

/// Switches the clock of the ST-LINK on. It comes in in place of a crystal.
pub fn start_crystal() {
    pac::RCC.cr().modify(|w| w.set_hsebyp(true));
    pac::RCC.cr().modify(|w| w.set_hseon(true));
}

/// Clocks: 80 MHz from the clock of the ST-LINK, or from the internal oscillator without it.
pub fn clocks(external: bool) -> Config {
    use rcc::{Hse, HseMode, Pll, PllMul, PllPreDiv, PllRDiv, PllSource, Sysclk, mux};
    let mut config = Config::default();
    config.rcc.hsi = true;
    config.rcc.msi = None;
    let freq = embassy_stm32::time::Hertz(CLOCK_HZ);
    config.rcc.hse = external.then_some(Hse { freq, mode: HseMode::Bypass });
    config.rcc.pll = Some(Pll {
        source: if external { PllSource::HSE } else { PllSource::HSI },
        prediv: if external { PllPreDiv::DIV1 } else { PllPreDiv::DIV2 },
        mul: PllMul::MUL20,
        divp: None,
        divq: None,
        divr: Some(PllRDiv::DIV2),
    });
    config.rcc.sys = Sysclk::PLL1_R;
    config.rcc.mux.adcsel = mux::Adcsel::SYS;
    config.rcc.mux.usart2sel = mux::Usartsel::SYS;
    // every interrupt starts at 0, the highest; that belongs to the control step
    config.bdma_interrupt_priority = Priority::P6;
    config
}

/// The clock security system, if the external clock runs.
pub fn full_speed(external: bool) {
    if external {
        pac::RCC.cr().modify(|w| w.set_csson(true));
    }
}

/// Whether the flash is two banks: with 1 MB it always is.
pub fn has_two_banks() -> bool {
    true
}

/// Starts the erasure of the page that FLASH_CR has.
pub fn start_erasure() {
    pac::FLASH.cr().modify(|w| w.set_start(true));
}

/// Stops the watchdog while a debugger halts the core. The pulse of the enable line runs on.
pub fn freeze_watchdog_for_debuggers() {
    pac::DBGMCU.apb1fzr1().modify(|w| w.set_iwdg(true));
}

/// Sets the voltage detector to 2.9 V: below it a 3.3 V regulator has failed.
pub fn start_voltage_detector() {
    pac::PWR.cr2().modify(|w| {
        w.set_pls(pac::pwr::vals::Pls::V2_9);
        w.set_pvde(true);
    });
}

/// Suits the DAC to the rate of the bus, which every rate of this chip does.
pub fn set_dac_speed() {}

/// TIM2 counts all four quadrature edges of a period through a filter of 100 ns. TIM5 captures its own count when the exclusive
/// or of both lines, through the same filter, changes: at each of them.
pub fn start_encoder(
    a: Peri<'static, PA0>,
    b: Peri<'static, PA1>,
    a_again: Peri<'static, PA15>,
    b_again: Peri<'static, PB3>,
) {
    rcc::enable_and_reset::<TIM2>();
    rcc::enable_and_reset::<TIM5>();
    let (of_tim2, of_tim5) = (1, 2);
    for (mut pin, function) in [
        (Flex::new(a), of_tim5),
        (Flex::new(b), of_tim5),
        (Flex::new(a_again), of_tim2),
        (Flex::new(b_again), of_tim2),
    ] {
        pin.set_as_af_unchecked(function, AfType::input(Pull::Up));
        core::mem::forget(pin); // dropping it would disconnect the pin
    }
    let (tim2, tim5) = (pac::TIM2, pac::TIM5);
    let filter = FilterValue::FCK_INT_N8;
    tim2.ccmr_input(0).write(|w| {
        for channel in 0..2 {
            w.set_ccs(channel, CcmrInputCcs::TI4); // its own input
            w.set_icf(channel, filter);
        }
    });
    tim2.smcr().write(|w| w.set_sms(Sms::ENCODER_MODE_3));
    tim2.arr().write_value(u32::MAX);

    tim5.arr().write_value(u32::MAX);
    tim5.cr2().write(|w| w.set_ti1s(pac::timer::vals::Ti1s::XOR));
    tim5.ccmr_input(0).write(|w| {
        w.set_ccs(0, CcmrInputCcs::TI4);
        w.set_icf(0, filter);
    });
    tim5.ccer().write(|w| {
        w.set_ccp(0, true); // both of its edges
        w.set_ccnp(0, true);
        w.set_cce(0, true);
    });
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
    let mut adc = Adc::new(adc);
    let mut pins = (Flex::new(load), Flex::new(accel));
    pins.0.set_as_analog();
    pins.1.set_as_analog();
    let regs = pac::ADC1;
    regs.cfgr2().modify(|w| {
        w.set_rovse(true);
        w.set_jovse(true);
        w.set_ovsr(OversamplingRatio::RATIO16);
        w.set_ovss(OversamplingShift::SHIFT0); // summed, not shifted: 16 bit
    });
    regs.smpr(0).modify(|w| {
        for input in [LOAD, ACCEL] {
            w.set_smp(usize::from(input), SampleTime::CYCLES12_5);
        }
    });
    // switched on, and the converter with it; 8 µs: at least 4 [ds12288, "Embedded internal voltage reference"]
    let mut reference = adc.enable_vrefint();
    let sum = adc.blocking_read(&mut reference, embassy_stm32::adc::SampleTime::CYCLES640_5).into();
    regs.cfgr2().modify(|w| w.set_rovse(false));
    regs.jsqr().write(|w| {
        w.set_jl(2); // three conversions
        for (rank, input) in [LOAD, LOAD, ACCEL].into_iter().enumerate() {
            w.set_jsq(rank, input);
        }
        w.set_jextsel(TIM6_TRGO);
        w.set_jexten(1); // rising edge
    });
    regs.ier().modify(|w| w.set_jeosie(true));
    regs.cr().modify(|w| w.set_jadstart(true));
    (Converter { _adc: adc, _pins: pins }, sum)
}
