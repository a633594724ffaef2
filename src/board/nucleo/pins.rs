//! Pins that the control step reads: one load each, from an address that is known when it is compiled.

use core::convert::Infallible;
use core::marker::PhantomData;
use embassy_stm32::gpio::{Input, Pin, Pull};
use embassy_stm32::pac::gpio::{Gpio, vals::Idr};
use embassy_stm32::peripherals::{PB10, PC7};
use embassy_stm32::{Peri, pac};
use embedded_hal::digital::{ErrorType, InputPin};

/// A pin of a port.
pub trait Place {
    /// Its port.
    const PORT: Gpio;
    /// Its number in the port.
    const NUMBER: usize;
}

impl Place for PC7 {
    const PORT: Gpio = pac::GPIOC;
    const NUMBER: usize = 7;
}

impl Place for PB10 {
    const PORT: Gpio = pac::GPIOB;
    const NUMBER: usize = 10;
}

/// An input with a pull-up.
pub struct PulledUp<P>(PhantomData<P>);

/// Emergency stop.
pub type EmergencyStop = PulledUp<PC7>;
/// Fault output of the amplifier.
pub type AmplifierFault = PulledUp<PB10>;

impl<P: Pin + Place> PulledUp<P> {
    pub(super) fn new(pin: Peri<'static, P>) -> Self {
        // dropping it would disconnect the pin
        core::mem::forget(Input::new(pin, Pull::Up));
        Self(PhantomData)
    }
}

impl<P> ErrorType for PulledUp<P> {
    type Error = Infallible;
}

impl<P: Place> InputPin for PulledUp<P> {
    #[inline]
    fn is_high(&mut self) -> Result<bool, Infallible> {
        Ok(P::PORT.idr().read().idr(P::NUMBER) == Idr::HIGH)
    }

    fn is_low(&mut self) -> Result<bool, Infallible> {
        self.is_high().map(|high| !high)
    }
}
