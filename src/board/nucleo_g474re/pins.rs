//! Pins that the control step reads: one load each, from an address that is known when it is compiled.

use core::convert::Infallible;
use embassy_stm32::gpio::{Input, Pull};
use embassy_stm32::pac::gpio::vals::Idr;
use embassy_stm32::peripherals::{PB10, PC7};
use embassy_stm32::{Peri, pac};
use embedded_hal::digital::{ErrorType, InputPin};

/// Emergency stop: PC7, with a pull-up.
pub struct EmergencyStop(());

/// Fault output of the amplifier: PB10, with a pull-up.
pub struct AmplifierFault(());

impl EmergencyStop {
    pub(super) fn new(pin: Peri<'static, PC7>) -> Self {
        // dropping it would disconnect the pin
        core::mem::forget(Input::new(pin, Pull::Up));
        Self(())
    }
}

impl AmplifierFault {
    pub(super) fn new(pin: Peri<'static, PB10>) -> Self {
        core::mem::forget(Input::new(pin, Pull::Up));
        Self(())
    }
}

impl ErrorType for EmergencyStop {
    type Error = Infallible;
}

impl InputPin for EmergencyStop {
    #[inline]
    fn is_high(&mut self) -> Result<bool, Infallible> {
        Ok(pac::GPIOC.idr().read().idr(7) == Idr::HIGH)
    }

    fn is_low(&mut self) -> Result<bool, Infallible> {
        self.is_high().map(|high| !high)
    }
}

impl ErrorType for AmplifierFault {
    type Error = Infallible;
}

impl InputPin for AmplifierFault {
    #[inline]
    fn is_high(&mut self) -> Result<bool, Infallible> {
        Ok(pac::GPIOB.idr().read().idr(10) == Idr::HIGH)
    }

    fn is_low(&mut self) -> Result<bool, Infallible> {
        self.is_high().map(|high| !high)
    }
}
