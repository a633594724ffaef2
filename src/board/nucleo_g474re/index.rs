//! The quadrature encoder with its index pulse on channel 3 of TIM2, which captures the count at the edge, see [`crate::sensors::IndexPulse`].

use crate::board::nucleo::Quadrature;
use crate::board::{Middle, MiddleNews};
use crate::sensors::IndexPulse;
use core::cell::RefCell;
use embassy_stm32::gpio::{AfType, Flex, Pull};
use embassy_stm32::pac::timer::vals::{CcmrInputCcs, FilterValue};
use embassy_stm32::peripherals::PA9;
use embassy_stm32::{Peri, pac};
use embassy_sync::blocking_mutex::ThreadModeMutex;
use haptics::{Device, FaultKind};
use link::ORIGIN_KEY;

/// Alternate function of TIM2 on PA9.
const FUNCTION: u8 = 10;
/// Channel 3, from 0, among the flags and the registers of the channels.
const CHANNEL: usize = 2;

static INDEX: ThreadModeMutex<RefCell<IndexPulse>> = ThreadModeMutex::new(RefCell::new(IndexPulse::new()));

/// The position of the handle from the quadrature encoder, with its index.
pub struct Indexed(Quadrature);

impl Indexed {
    /// Takes the pin of Z. TIM2 counts already.
    pub fn new(z: Peri<'static, PA9>) -> Self {
        let mut pin = Flex::new(z);
        pin.set_as_af_unchecked(FUNCTION, AfType::input(Pull::Up));
        core::mem::forget(pin); // dropping it would disconnect the pin
        let tim2 = pac::TIM2;
        tim2.ccmr_input(1).modify(|w| {
            w.set_ccs(CHANNEL - 2, CcmrInputCcs::TI4); // its own input
            w.set_icf(CHANNEL - 2, FilterValue::FDTS_DIV2_N8); // as late as the edges of A and B
        });
        tim2.ccer().modify(|w| w.set_cce(CHANNEL, true));
        Self(Quadrature)
    }

    /// Travel in a count, m: that of the default device.
    pub const fn metre_per_count(default: f32) -> f32 {
        Quadrature::metre_per_count(default)
    }

    /// Reads an item of the flash.
    pub fn load(key: u8, item: &[u8]) {
        if key == ORIGIN_KEY {
            INDEX.lock(|index| index.borrow_mut().load(item));
        }
    }

    /// It counts since the boot. False: the index has yet to pass.
    pub const fn begin(&mut self, device: &Device) -> bool {
        self.0.begin(device)
    }

    /// It needs no trigger.
    pub const fn follow() {}

    /// Time of the sample, count, and time of the count's last edge.
    #[inline(always)]
    pub fn sample(&mut self) -> (u32, u32, u32) {
        self.0.sample()
    }

    /// What is wrong with it shows in its counts.
    #[inline(always)]
    pub const fn trouble(&self) -> Option<FaultKind> {
        self.0.trouble()
    }

    /// What the last pulse tells of the middle of the stroke.
    pub fn middle(now: Middle) -> MiddleNews {
        let tim2 = pac::TIM2;
        // reading the count clears the flag
        let pulse = tim2.sr().read().ccif(CHANNEL).then(|| tim2.ccr(CHANNEL).read());
        INDEX.lock(|index| index.borrow_mut().update(pulse, now))
    }
}
