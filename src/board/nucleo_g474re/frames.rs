//! One SPI frame a control period, without the processor: a timer starts it, DMA moves its bytes.
//!
//! ```text
//! timer update --DMAMUX--> START channel: SPE = 1 --> NSS falls, SCK runs
//!                          TX channel: frame -> SPI;  RX channel: SPI -> answer
//! control step:            takes the answer, SPE = 0 (NSS rises), arms both channels again
//! ```
//!
//! The instant of the frame has no jitter of software, and the step waits for nothing. With SSOE = 1 a master holds NSS low
//! from SPE = 1 to SPE = 0 [rm0440, "Slave select (NSS) pin management"]; between frames a pull-up holds it high. The order of
//! the settings is that of [rm0440, "Communication using DMA (direct memory addressing)"].

use core::cell::UnsafeCell;
use core::marker::PhantomData;
use embassy_stm32::gpio::{AfType, AnyPin, Flex, OutputType, Pull, Speed};
use embassy_stm32::pac::bdma::vals::{Dir, Pl, Size};
use embassy_stm32::pac::spi::{Spi, vals};
use embassy_stm32::pac::{self, bdma::regs::Cr, spi::regs::Cr1, spi::regs::Cr2};
use embassy_stm32::{Peri, rcc};
use embedded_hal::spi::{Error, ErrorKind, ErrorType, Mode, Operation, Phase, Polarity, SpiDevice};

/// What of the chip a sensor has for itself.
pub trait Line<const N: usize>: 'static {
    /// The bus, on which the sensor is alone, with its clock.
    type Clock: rcc::RccPeripheral;
    /// Its registers.
    const SPI: Spi;
    /// Division of the clock of its registers, 170 MHz, to that of the line.
    const RATE: vals::Br;
    /// Mode of the line.
    const MODE: Mode;
    /// Channels of DMA1, from 0: start, receive, transmit.
    const CHANNELS: [usize; 3];
    /// Requests of the DMAMUX: update of the timer, receive, transmit [rm0440, "DMAMUX1 mapping"].
    const REQUESTS: [u8; 3];
    /// Memory of the frames.
    fn memory() -> &'static Memory<N>;
}

/// Bytes that the DMA reads and writes.
pub struct Memory<const N: usize>(UnsafeCell<Bytes<N>>);

/// Words of the longest frame.
const WORDS: usize = 3;

#[repr(C)]
struct Bytes<const N: usize> {
    /// In words, which take a third of the loads.
    answer: [u32; WORDS],
    frame: [u8; N],
    /// SPI_CR1 that starts a frame.
    start: u32,
}

// SAFETY: accessed by volatile reads and writes, by the one `Frames` of its line, and by the DMA between its
// `arm` and `take`.
unsafe impl<const N: usize> Sync for Memory<N> {}

impl<const N: usize> Memory<N> {
    /// Nothing received.
    pub const fn new() -> Self {
        const { assert!(N <= 4 * WORDS) };
        Self(UnsafeCell::new(Bytes { answer: [0; WORDS], frame: [0; N], start: 0 }))
    }
}

/// No answer in this period: the frame has not ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Unfinished;

impl Error for Unfinished {
    fn kind(&self) -> ErrorKind {
        ErrorKind::Other
    }
}

/// The frames of a sensor.
pub struct Frames<L, const N: usize>(PhantomData<L>);

impl<L: Line<N>, const N: usize> Frames<L, N> {
    /// Takes the pins NSS, SCK, MISO and MOSI. Each period sends `frame` once [`Self::follow`] is called.
    pub fn new(pins: [Peri<'static, AnyPin>; 4], function: u8, frame: [u8; N]) -> Self {
        pac::RCC.ahb1enr().modify(|w| {
            w.set_dma1en(true);
            w.set_dmamux1en(true);
        });
        // an open line reads ones
        let kinds = [
            AfType::output_pull(OutputType::PushPull, Speed::High, Pull::Up),
            AfType::output(OutputType::PushPull, Speed::High),
            AfType::input(Pull::Up),
            AfType::output(OutputType::PushPull, Speed::High),
        ];
        for (pin, kind) in pins.into_iter().zip(kinds) {
            let mut pin = Flex::new(pin);
            pin.set_as_af_unchecked(function, kind);
            core::mem::forget(pin); // dropping it would disconnect the pin
        }
        let memory = L::memory().0.get();
        // SAFETY: the only `Frames` of this memory; the DMA is not yet on
        unsafe { (&raw mut (*memory).start).write_volatile(Self::control(true).0) };
        let [start, receive, transmit] = L::CHANNELS;
        for (channel, request) in L::CHANNELS.into_iter().zip(L::REQUESTS) {
            pac::DMAMUX1.ccr(channel).write(|w| w.set_dmareq_id(request));
        }
        let address = |at: *const u8| at.addr() as u32;
        let (start, receive, transmit) = (pac::DMA1.ch(start), pac::DMA1.ch(receive), pac::DMA1.ch(transmit));
        start.par().write_value(L::SPI.cr1().as_ptr().addr() as u32);
        receive.par().write_value(L::SPI.dr8().as_ptr().addr() as u32);
        transmit.par().write_value(L::SPI.dr8().as_ptr().addr() as u32);
        // SAFETY: addresses only
        unsafe {
            start.mar().write_value(address((&raw const (*memory).start).cast()));
            receive.mar().write_value(address((&raw const (*memory).answer).cast()));
            transmit.mar().write_value(address((&raw const (*memory).frame).cast()));
        }
        start.ndtr().write(|w| w.set_ndt(1));
        let mut frames = Self(PhantomData);
        frames.send(frame);
        frames
    }

    /// SPI_CR1, which starts a frame or ends it.
    #[inline(always)]
    fn control(on: bool) -> Cr1 {
        let mut cr1 = Cr1(0);
        cr1.set_mstr(vals::Mstr::MASTER);
        cr1.set_br(L::RATE);
        if L::MODE.polarity == Polarity::IdleHigh {
            cr1.set_cpol(vals::Cpol::IDLE_HIGH);
        }
        if L::MODE.phase == Phase::CaptureOnSecondTransition {
            cr1.set_cpha(vals::Cpha::SECOND_EDGE);
        }
        cr1.set_spe(on);
        cr1
    }

    /// From now on each period sends this frame. What was prepared of another one is discarded.
    pub fn send(&mut self, frame: [u8; N]) {
        let [_, receive, transmit] = L::CHANNELS;
        pac::DMA1.ch(receive).cr().write_value(Self::channel(false, false));
        pac::DMA1.ch(transmit).cr().write_value(Self::channel(true, false));
        // empties the FIFOs
        rcc::enable_and_reset::<L::Clock>();
        let memory = L::memory().0.get();
        // SAFETY: the only `Frames` of this memory, and the DMA is off
        unsafe { (&raw mut (*memory).frame).write_volatile(frame) };
        self.arm();
    }

    /// Starts a frame with every update of the timer.
    pub fn follow() {
        pac::DMA1.ch(L::CHANNELS[0]).cr().write(|w| {
            w.set_dir(Dir::FROM_MEMORY);
            w.set_circ(true);
            w.set_psize(Size::BITS32);
            w.set_msize(Size::BITS32);
            w.set_pl(Pl::HIGH);
            w.set_en(true);
        });
    }

    /// Starts a frame now. For the time before the timer.
    pub fn start(&mut self) {
        L::SPI.cr1().write_value(Self::control(true));
    }

    fn bytes_by_dma(on: bool) -> Cr2 {
        let mut cr2 = Cr2(0);
        cr2.set_ds(vals::Ds::BITS8);
        cr2.set_frxth(vals::Frxth::QUARTER);
        cr2.set_ssoe(true);
        cr2.set_rxdmaen(on);
        cr2.set_txdmaen(on);
        cr2
    }

    fn channel(from_memory: bool, on: bool) -> Cr {
        let mut cr = Cr(0);
        cr.set_dir(if from_memory { Dir::FROM_MEMORY } else { Dir::FROM_PERIPHERAL });
        cr.set_minc(true);
        cr.set_pl(Pl::HIGH);
        cr.set_en(on);
        cr
    }

    /// Ends the last frame and prepares the next.
    #[inline(always)]
    fn arm(&mut self) {
        let [_, receive, transmit] = L::CHANNELS;
        let (receive, transmit) = (pac::DMA1.ch(receive), pac::DMA1.ch(transmit));
        receive.cr().write_value(Self::channel(false, false));
        transmit.cr().write_value(Self::channel(true, false));
        L::SPI.cr1().write_value(Self::control(false));
        L::SPI.cr2().write_value(Self::bytes_by_dma(false));
        receive.ndtr().write(|w| w.set_ndt(N as u16));
        transmit.ndtr().write(|w| w.set_ndt(N as u16));
        receive.cr().write_value(Self::channel(false, true));
        transmit.cr().write_value(Self::channel(true, true));
        L::SPI.cr2().write_value(Self::bytes_by_dma(true));
    }

    /// Discards bytes of a frame that did not end.
    fn drain(&mut self) {
        // the FIFO holds four
        for _ in 0..4 {
            if L::SPI.sr().read().rxne() {
                let _ = L::SPI.dr8().read();
            }
        }
    }
}

impl<L: Line<N>, const N: usize> ErrorType for Frames<L, N> {
    type Error = Unfinished;
}

/// A transfer of the whole frame takes the answer of this period and prepares the next; it does not wait. What is sent is always
/// the frame of [`Frames::new`].
impl<L: Line<N>, const N: usize> SpiDevice for Frames<L, N> {
    #[inline(always)]
    fn transaction(&mut self, operations: &mut [Operation<'_, u8>]) -> Result<(), Unfinished> {
        let [Operation::TransferInPlace(bytes)] = operations else { return Err(Unfinished) };
        let Ok(bytes) = <&mut [u8; N]>::try_from(&mut **bytes) else { return Err(Unfinished) };
        let ended = pac::DMA1.ch(L::CHANNELS[1]).ndtr().read().ndt() == 0;
        let answer: *const u32 = L::memory().0.get().cast();
        for (k, part) in bytes.chunks_mut(4).enumerate() {
            // SAFETY: one of the words of `answer`, which is first. What the DMA still writes is not used.
            let word = unsafe { answer.add(k).read_volatile() };
            // a word at a time: by bytes it takes 100 cycles more with two sensors
            match <&mut [u8; 4]>::try_from(&mut *part) {
                Ok(whole) => *whole = word.to_le_bytes(),
                Err(_) => part.iter_mut().zip(word.to_le_bytes()).for_each(|(to, from)| *to = from),
            }
        }
        self.arm();
        if ended {
            Ok(())
        } else {
            self.drain();
            Err(Unfinished)
        }
    }
}
