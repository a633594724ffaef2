//! The chip: peripherals by address, and their connections.

use crate::adc::{Adc, FACTORY_REFERENCE, REFERENCE, Triggered};
use crate::ads131m02::Ads131m02;
use crate::dac::Dac;
use crate::dma::{self, Dma, Transfer};
use crate::flash::Flash;
use crate::gpio::Gpio;
use crate::inject::{Injector, Pulses};
use crate::iwdg::Iwdg;
use crate::lpuart::{self, Lpuart};
use crate::mt6835::Mt6835;
use crate::rcc::{Gate, Rcc, ResetCause};
use crate::spi::{Chip, Spi};
use crate::stats::{Statistics, us};
use crate::supply::Supply;
use crate::tim::{CAPTURE_LAG_CYCLES, Tim};
use crate::units_per_cycle;
use crate::world::World;
use std::cell::Cell;
use std::collections::{BTreeSet, HashMap};

const TIM2: u32 = 0x4000_0000;
const TIM7_END: u32 = 0x4000_1800;
const IWDG: u32 = 0x4000_3000;
const SPI2: u32 = 0x4000_3800;
const SPI3: u32 = 0x4000_3c00;
const PWR: u32 = 0x4000_7000;
const LPUART1: u32 = 0x4000_8000;
const EXTI: u32 = 0x4001_0400;
const DMA1: u32 = 0x4002_0000;
const DMAMUX_END: u32 = DMA1 + dma::MUX + 0x40;
const RCC: u32 = 0x4002_1000;
const FLASH: u32 = 0x4002_2000;
const GPIOA: u32 = 0x4800_0000;
const ADC1: u32 = 0x5000_0000;
const DAC1: u32 = 0x5000_0800;

const AHB1ENR: u32 = 0x48;
const AHB2ENR: u32 = 0x4c;
const APB1ENR1: u32 = 0x58;
const APB1ENR2: u32 = 0x5c;
const ADC_GATE: Gate = (AHB2ENR, 13);
const DAC_GATE: Gate = (AHB2ENR, 16);
const LPUART_GATE: Gate = (APB1ENR2, 0);
const PWR_GATE: Gate = (APB1ENR1, 28);
const APB1RSTR1: u32 = 0x38;
const SPI2_GATE: Gate = (APB1ENR1, 14);
const SPI3_GATE: Gate = (APB1ENR1, 15);
const DMA_GATE: Gate = (AHB1ENR, 0);
const DMAMUX_GATE: Gate = (AHB1ENR, 2);

/// Requests of the DMAMUX: updates of TIM6 and TIM7; receive and transmit of SPI2 and SPI3; transmit of LPUART1.
const UPDATE_REQUESTS: [(usize, u32); 2] = [(4, 8), (5, 9)];
const SPI2_REQUESTS: [u32; 2] = [12, 13];
const SPI3_REQUESTS: [u32; 2] = [14, 15];
const LPUART1_TX_REQUEST: u32 = 35;
/// Alternate functions of SPI2 and SPI3, and their pins: ports and numbers of NSS, SCK, MISO, MOSI.
const SPI2_FUNCTION: u32 = 5;
const SPI2_PINS: [(usize, u32); 4] = [(1, 12), (1, 13), (1, 14), (1, 15)];
const SPI3_FUNCTION: u32 = 6;
const SPI3_PINS: [(usize, u32); 4] = [(0, 15), (2, 10), (2, 11), (2, 12)];

/// Numbers of the driven interrupt lines.
pub(crate) const IRQ_ADC1_2: u16 = 18;
const IRQ_TIMERS: [u16; 6] = [28, 29, 30, 50, 54, 55];
const IRQ_PVD: u16 = 1;
const IRQ_LPUART1: u16 = 91;
/// Channel of DMA1, from 0, whose interrupt is driven.
const DMA_CHANNEL: usize = 6;
const IRQ_DMA1_CHANNEL7: u16 = 17;
pub(crate) const IRQS: usize = 10;

const ENABLE_PIN: u32 = 5;
/// Alternate function of the enable pin, and the timer and channel behind it.
const ENABLE_FUNCTION: u32 = 2;
const ENABLE_TIMER: usize = 1;
const ENABLE_CHANNEL: u32 = 2;
const STOP_PIN: u32 = 7;
/// Pin of the encoder's index, and its alternate function.
const INDEX_PIN: u32 = 9;
const INDEX_FUNCTION: u32 = 10;
const AMPLIFIER_FAULT_PIN: u32 = 10;

/// Indices of timers: TIM2 is 0.
const ENCODER: usize = 0;
const EDGE_CLOCK: usize = 3;

#[derive(Debug)]
pub(crate) struct Soc {
    pub rcc: Rcc,
    tims: [Tim; 6],
    adc: Adc,
    dac: Dac,
    pub dma: Dma,
    pub spi2: Spi<Mt6835>,
    pub spi3: Spi<Ads131m02>,
    pub lpuart: Lpuart,
    iwdg: Iwdg,
    pub flash: Flash,
    gpio: [Gpio; 7],
    pub supply: Supply,
    other: HashMap<u32, u32>,
    pub world: World,
    stop_pressed: bool,
    /// The amplifier's fault output is open.
    pub amplifier_fault: bool,
    pub injector: Option<Injector>,
    /// Edges of the encoder at an even pace, instead of those of the rig.
    pub pulses: Option<Pulses>,
    /// Delay from a count in TIM2 to the capture in TIM5, timer cycles.
    pub capture_lag: u64,
    pub stats: Statistics,
    pub violations: BTreeSet<String>,
    /// End of the sequence whose step is pending.
    sampled_at: Option<u64>,
    encoder_read: bool,
    /// Time of the force that the converter on SPI3 has for the pending step.
    load_used: Option<u64>,
    /// Times of the write of the force and of the end of its sample, until the output.
    awaiting_output: Option<u64>,
    last_output: Option<u64>,
    last_fed: Option<u64>,
    pub first_step_at: Option<u64>,
    /// Time of the next event, unless something has changed since.
    next: Cell<Option<u64>>,
}

impl Soc {
    pub fn new(world: World) -> Self {
        Self {
            rcc: Rcc::new(ResetCause::PowerOn),
            tims: [2, 3, 4, 5, 6, 7].map(Tim::new),
            adc: Adc::new(),
            dac: Dac::new(),
            dma: Dma::default(),
            spi2: Spi::new(Mt6835::new()),
            spi3: Spi::new(Ads131m02::new()),
            lpuart: Lpuart::new(),
            iwdg: Iwdg::new(),
            flash: Flash::new(),
            gpio: std::array::from_fn(Gpio::new),
            supply: Supply::new(),
            other: HashMap::new(),
            world,
            stop_pressed: false,
            amplifier_fault: false,
            injector: None,
            pulses: None,
            capture_lag: CAPTURE_LAG_CYCLES,
            stats: Statistics::default(),
            violations: BTreeSet::new(),
            sampled_at: None,
            encoder_read: false,
            load_used: None,
            awaiting_output: None,
            last_output: None,
            last_fed: None,
            first_step_at: None,
            next: Cell::new(None),
        }
    }

    /// Resets all registers. The rig is unchanged.
    pub fn reset(&mut self, cause: ResetCause, now: u64) {
        if self.flash.power_lost {
            self.flash.power_up();
        } else {
            self.flash.reset(now);
        }
        self.violations.extend(self.flash.violation.take());
        let shown = std::mem::take(&mut self.lpuart.shown);
        let overruns = self.lpuart.overruns;
        self.rcc.reset(cause);
        self.tims = [2, 3, 4, 5, 6, 7].map(Tim::new);
        self.adc = Adc::new();
        self.dac = Dac::new();
        self.dma.reset();
        self.spi2.reset();
        self.spi3.reset();
        self.lpuart = Lpuart::new();
        self.lpuart.shown = shown;
        self.lpuart.overruns = overruns;
        self.iwdg = Iwdg::new();
        self.gpio = std::array::from_fn(Gpio::new);
        self.supply.reset();
        self.other.clear();
        (self.sampled_at, self.awaiting_output, self.last_output, self.last_fed) = (None, None, None, None);
    }

    pub fn press_stop(&mut self, pressed: bool) {
        self.stop_pressed = pressed;
    }

    /// Whether the enable pin is high: as a plain output, or as the output of its timer.
    pub fn amplifier_on(&self, now: u64) -> bool {
        let port = &self.gpio[1];
        let pulse = port.alternate(ENABLE_PIN, ENABLE_FUNCTION)
            && self.tims[ENABLE_TIMER].output_high(ENABLE_CHANNEL, now);
        port.output_high(ENABLE_PIN) || pulse
    }

    /// Input of the amplifier: a code at 3.3 V while it is enabled and the DAC drives its pin.
    fn force_code(&self, now: u64) -> Option<f64> {
        let driven = self.gpio[0].analog(4);
        self.dac.output_code(self.supply.millivolt()).filter(|_| self.amplifier_on(now) && driven)
    }

    pub fn watchdog_due(&self, now: u64) -> bool {
        self.iwdg.deadline.is_some_and(|at| now >= at)
    }

    fn gate(&mut self, gate: Gate, what: &str) -> bool {
        let on = self.rcc.enabled(gate);
        if !on {
            self.violations.insert(format!("{what} used without its clock"));
        }
        on
    }

    pub fn read(&mut self, address: u32, now: u64) -> u32 {
        self.advance(now);
        self.forget_next_event();
        let offset = address & 0x3ff;
        match address {
            TIM2..TIM7_END => {
                let index = ((address - TIM2) / 0x400) as usize;
                if !self.gate((APB1ENR1, index as u32), "a timer") {
                    return 0;
                }
                if index == ENCODER && offset == 0x24 {
                    self.encoder_was_read(now);
                }
                let value = self.tims[index].read(offset, now);
                if Tim::is_capture(offset) {
                    self.tims[index].was_read(offset);
                }
                value
            }
            IWDG..0x4000_3400 => self.iwdg.read(offset),
            SPI2..0x4000_3c00 => {
                if self.gate(SPI2_GATE, "SPI2") {
                    self.spi2.read(offset)
                } else {
                    0
                }
            }
            SPI3..0x4000_4000 => {
                if self.gate(SPI3_GATE, "SPI3") {
                    self.spi3.read(offset)
                } else {
                    0
                }
            }
            DMA1..DMAMUX_END => {
                if self.gate(DMA_GATE, "DMA1") && self.gate(DMAMUX_GATE, "DMAMUX1") {
                    self.dma.read(address - DMA1)
                } else {
                    0
                }
            }
            PWR..0x4000_7400 => {
                if self.gate(PWR_GATE, "PWR") {
                    self.supply.read_pwr(offset)
                } else {
                    0
                }
            }
            EXTI..0x4001_0800 => self.supply.read_exti(offset),
            LPUART1..0x4000_8400 => {
                if self.gate(LPUART_GATE, "LPUART1") {
                    self.lpuart.read(offset)
                } else {
                    0
                }
            }
            RCC..0x4002_1400 => self.rcc.read(offset),
            FLASH..0x4002_2400 => self.flash.read(offset, now),
            GPIOA..0x4800_1c00 => {
                self.gpio[2].drive(STOP_PIN, self.stop_pressed);
                self.gpio[1].drive(AMPLIFIER_FAULT_PIN, self.amplifier_fault);
                self.gpio[((address - GPIOA) / 0x400) as usize].read(offset)
            }
            ADC1..DAC1 => {
                if self.gate(ADC_GATE, "ADC1") {
                    self.adc.read(address - ADC1)
                } else {
                    0
                }
            }
            DAC1..0x5000_0c00 => {
                if self.gate(DAC_GATE, "DAC1") {
                    self.dac.read(offset)
                } else {
                    0
                }
            }
            _ => self.other.get(&address).copied().unwrap_or(0),
        }
    }

    pub fn write(&mut self, address: u32, value: u32, now: u64) {
        self.advance(now);
        self.forget_next_event();
        let offset = address & 0x3ff;
        match address {
            TIM2..TIM7_END => {
                let index = ((address - TIM2) / 0x400) as usize;
                if self.gate((APB1ENR1, index as u32), "a timer") {
                    let cycle = units_per_cycle(self.rcc.timer1());
                    self.tims[index].write(offset, value, now, cycle);
                }
            }
            IWDG..0x4000_3400 => self.feed(offset, value, now),
            SPI2..0x4000_3c00 => {
                if self.gate(SPI2_GATE, "SPI2") {
                    self.write_spi(address, value, now);
                    self.serve(now);
                }
            }
            SPI3..0x4000_4000 => {
                if self.gate(SPI3_GATE, "SPI3") {
                    self.write_spi(address, value, now);
                    self.serve(now);
                }
            }
            DMA1..DMAMUX_END => {
                if self.gate(DMA_GATE, "DMA1") && self.gate(DMAMUX_GATE, "DMAMUX1") {
                    self.dma.write(address - DMA1, value);
                    self.serve(now);
                }
            }
            PWR..0x4000_7400 => {
                if self.gate(PWR_GATE, "PWR") {
                    self.supply.write_pwr(offset, value);
                }
            }
            EXTI..0x4001_0800 => self.supply.write_exti(offset, value),
            LPUART1..0x4000_8400 => {
                if self.gate(LPUART_GATE, "LPUART1") {
                    let hz = self.rcc.lpuart1();
                    self.lpuart.write(offset, value, now, hz);
                    self.serve(now);
                }
            }
            RCC..0x4002_1400 => {
                self.rcc.write(offset, value);
                if offset == APB1RSTR1 {
                    self.reset_spi(value);
                }
                self.clock_timers(now);
                self.check_clock();
            }
            FLASH..0x4002_2400 => {
                self.flash.write(offset, value, now);
                self.violations.extend(self.flash.violation.take());
            }
            GPIOA..0x4800_1c00 => {
                let port = ((address - GPIOA) / 0x400) as usize;
                if self.gate((AHB2ENR, port as u32), "a GPIO port") {
                    self.gpio[port].write(offset, value);
                }
            }
            ADC1..DAC1 => {
                if self.gate(ADC_GATE, "ADC1") {
                    self.adc.write(address - ADC1, value);
                    let millivolt = self.supply.millivolt();
                    self.adc.convert(self.rcc.adc12(), |channel| level(&self.world, millivolt, channel));
                    self.violations.extend(self.adc.violation.take());
                }
            }
            DAC1..0x5000_0c00 => {
                if self.gate(DAC_GATE, "DAC1") && self.dac.write(offset, value) {
                    self.force_was_written(now);
                }
            }
            _ => {
                self.other.insert(address, value);
            }
        }
    }

    /// The other peripherals are not reset one by one.
    fn reset_spi(&mut self, bits: u32) {
        if bits >> SPI2_GATE.1 & 1 != 0 {
            self.spi2.reset();
        }
        if bits >> SPI3_GATE.1 & 1 != 0 {
            self.spi3.reset();
        }
    }

    fn write_spi(&mut self, address: u32, value: u32, now: u64) {
        let wired = |gpio: &[Gpio; 7], pins: [(usize, u32); 4], function| {
            pins.into_iter().all(|(port, pin)| gpio[port].alternate(pin, function))
        };
        let (offset, hz) = (address & 0x3ff, self.rcc.pclk1());
        if address < SPI3 {
            self.spi2.wired = wired(&self.gpio, SPI2_PINS, SPI2_FUNCTION);
            self.spi2.write(offset, value, now, hz, &self.world);
        } else {
            self.spi3.wired = wired(&self.gpio, SPI3_PINS, SPI3_FUNCTION);
            self.spi3.write(offset, value, now, hz, &self.world);
        }
        self.violations.extend(self.spi2.violation.take());
        self.violations.extend(self.spi3.violation.take());
    }

    /// Makes the transfers that SPI2, SPI3 and LPUART1 ask the DMA for.
    fn serve(&mut self, now: u64) {
        loop {
            let buses = [wants(&self.spi2, SPI2_REQUESTS), wants(&self.spi3, SPI3_REQUESTS)];
            let serial = self.lpuart.wants_to_send().then_some(LPUART1_TX_REQUEST);
            let mut asked = buses.into_iter().flatten().chain([serial]).flatten();
            if !asked.any(|request| self.transfer(request, now)) {
                break;
            }
        }
    }

    /// Makes the transfer of a request. False if no channel waits for it.
    fn transfer(&mut self, request: u32, now: u64) -> bool {
        let Some(transfer) = self.dma.request(request) else { return false };
        let (Transfer::ToRegister { address, .. } | Transfer::FromRegister { address, .. }) = transfer;
        let of_spi = (SPI2..SPI3 + 0x400).contains(&address);
        match transfer {
            Transfer::ToRegister { value, .. } if of_spi => self.write_spi(address, value, now),
            Transfer::ToRegister { value, .. } if address == LPUART1 + lpuart::TDR => {
                let hz = self.rcc.lpuart1();
                self.lpuart.write(lpuart::TDR, value, now, hz);
            }
            Transfer::FromRegister { channel, .. } if of_spi => {
                let offset = address & 0x3ff;
                let value = if address < SPI3 { self.spi2.read(offset) } else { self.spi3.read(offset) };
                self.dma.received(channel, value);
            }
            _ => {
                self.violations.insert(format!("DMA1 at {address:#x}, which is not modelled"));
                return false;
            }
        }
        self.violations.extend(self.dma.violation.take());
        true
    }

    fn clock_timers(&mut self, now: u64) {
        let cycle = units_per_cycle(self.rcc.timer1());
        for tim in &mut self.tims {
            tim.set_clock(cycle, now);
        }
    }

    /// The crystal stops, or oscillates again.
    pub fn set_crystal(&mut self, oscillates: bool, now: u64) {
        self.advance(now);
        self.rcc.set_crystal(oscillates);
        self.clock_timers(now);
    }

    fn check_clock(&mut self) {
        self.violations.extend(self.rcc.violation.take());
        let (hz, wait_states) = (self.rcc.hclk(), self.flash.wait_states());
        // the internal oscillator is off by up to 1 %
        let (per_state, most) = (34_340_000, 171_700_000);
        if hz > per_state * (wait_states + 1) {
            self.violations.insert(format!("{hz} Hz with {wait_states} flash wait states"));
        }
        if hz > 150_000_000 && !self.supply.boosted() {
            self.violations.insert(format!("{hz} Hz without boost"));
        }
        if hz > most {
            self.violations.insert(format!("core at {hz} Hz, more than 170 MHz"));
        }
    }

    fn feed(&mut self, offset: u32, value: u32, now: u64) {
        let fed = self.iwdg.fed;
        self.iwdg.write(offset, value, now);
        if self.iwdg.fed != fed
            && let Some(last) = self.last_fed.replace(now)
        {
            self.stats.watchdog_gap_ms.add(us(now - last) / 1e3);
        }
    }

    fn encoder_was_read(&mut self, now: u64) {
        if let Some(at) = self.sampled_at
            && !self.encoder_read
        {
            self.encoder_read = true;
            self.stats.sampling_us.add(us(now - at));
        }
    }

    fn force_was_written(&mut self, now: u64) {
        // DAC_MCR.HFSEL: 1 above 80 MHz, 2 above 160 MHz [rm0440, 22.7.16]
        let (hz, hfsel) = (self.rcc.hclk(), self.dac.read(0x3c) >> 14 & 3);
        if hz > 160_000_000 && hfsel != 2 || hz > 80_000_000 && hfsel == 0 {
            self.violations.insert(format!("DAC1 with HFSEL = {hfsel} on a bus of {hz} Hz"));
        }
        if let Some(at) = self.sampled_at.take() {
            self.stats.steps += 1;
            self.stats.compute_us.add(us(now - at));
            self.awaiting_output = Some(at);
            self.first_step_at.get_or_insert(now);
        }
    }

    fn force_was_put_out(&mut self, fresh: bool, at: u64) {
        match self.awaiting_output.take() {
            Some(sampled) if fresh => {
                self.stats.latency_us.add(us(at - sampled));
                if let Some(seen) = self.spi2.chip.seen_at {
                    self.stats.angle_us.add(us(at - seen));
                }
                if let Some(seen) = self.load_used.take() {
                    self.stats.load_us.add(us(at - seen));
                }
            }
            _ if self.stats.steps > 0 => self.stats.stale_outputs += 1,
            _ => {}
        }
        if let Some(last) = self.last_output.replace(at) {
            self.stats.output_period_us.add(us(at - last));
        }
    }

    /// Advances everything to `now`, in order of time.
    pub fn advance(&mut self, now: u64) {
        loop {
            let next = self.next_event();
            if next > now {
                break;
            }
            self.advance_to(next);
        }
        for tim in &mut self.tims {
            if !tim.is_quiet(now) {
                self.next.set(None);
                tim.advance(now);
            }
        }
    }

    fn advance_to(&mut self, at: u64) {
        self.forget_next_event();
        let code = self.force_code(at);
        self.world.advance(at, code);
        while let Some((when, up)) = self.world.edge(at) {
            if self.pulses.is_none() {
                self.encoder_edge(when, up);
                if self.world.at_index() && self.gpio[0].alternate(INDEX_PIN, INDEX_FUNCTION) {
                    self.tims[ENCODER].index_edge();
                }
            }
        }
        while let Some((when, up)) = self.pulses.as_mut().and_then(|pulses| pulses.due(at)) {
            self.encoder_edge(when, up);
        }
        for index in 0..self.tims.len() {
            if self.tims[index].advance(at) == 0 {
                continue;
            }
            if self.tims[index].updates_trigger() {
                self.trigger(index as u8 + 2, at);
            }
            if let Some((_, request)) = UPDATE_REQUESTS.into_iter().find(|(timer, _)| *timer == index)
                && self.tims[index].updates_request()
            {
                self.transfer(request, at);
                self.serve(at);
            }
        }
        self.spi2.advance(at, &self.world);
        self.spi3.advance(at, &self.world);
        self.lpuart.advance(at);
        self.serve(at);
        if let Some(lost) = self.adc.advance(at) {
            self.stats.missed += u64::from(lost || self.sampled_at.is_some());
            self.sampled_at = Some(at);
            self.encoder_read = false;
            self.load_used = self.spi3.chip.seen_at;
            self.inject(at);
        }
    }

    /// Replaces measurements by injected readings.
    fn inject(&mut self, at: u64) {
        if let Some(Injector(source)) = &mut self.injector {
            let readings = source();
            self.adc.replace([readings.load_code, readings.accel_code]);
            self.tims[ENCODER].replace_count(readings.count);
            self.tims[EDGE_CLOCK].replace_capture(at, readings.skew_ticks, readings.edge_age);
        }
    }

    fn encoder_edge(&mut self, at: u64, up: bool) {
        if self.injector.is_some() {
            return;
        }
        let wired = self.gpio[0].alternate(0, 1) && self.gpio[0].alternate(1, 1);
        if wired && self.tims[ENCODER].encoder_edge(up) {
            for tim in &mut self.tims {
                tim.trigger_input(2, at, self.capture_lag);
            }
        }
    }

    /// The encoder loses counts or makes them up.
    pub fn slip_encoder(&mut self, counts: i32) {
        self.tims[ENCODER].slip(counts);
    }

    /// Handles a pulse on the trigger output of a timer.
    fn trigger(&mut self, timer: u8, at: u64) {
        let wired = self.gpio[2].analog(0) && self.gpio[2].analog(1);
        let (world, millivolt) = (&self.world, self.supply.millivolt());
        let level = |channel| if wired { level(world, millivolt, channel) } else { 0 };
        match self.adc.trigger(timer, at, self.rcc.adc12(), level) {
            Triggered::Started => self.stats.triggers += 1,
            Triggered::Busy => {
                self.stats.triggers += 1;
                self.stats.missed += 1;
            }
            Triggered::Ignored => {}
        }
        self.violations.extend(self.adc.violation.take());
        let fresh = self.dac.fresh;
        if self.dac.trigger(timer) {
            self.force_was_put_out(fresh, at);
        }
    }

    /// Time of the next spontaneous event.
    pub fn next_event(&self) -> u64 {
        let next = self.next.get().unwrap_or_else(|| self.earliest_event());
        self.next.set(Some(next));
        next
    }

    /// Forgets the time of the next event, before a change.
    pub fn forget_next_event(&mut self) {
        self.next.set(None);
    }

    fn earliest_event(&self) -> u64 {
        let tims = self.tims.iter().map(Tim::next_event).min().unwrap_or(u64::MAX);
        let pulse = self.pulses.as_ref().map_or(u64::MAX, |pulses| pulses.next);
        tims.min(pulse)
            .min(self.spi2.next_event())
            .min(self.spi3.next_event())
            .min(self.adc.next_event())
            .min(self.lpuart.next_event())
            .min(self.world.next_event())
    }

    /// Interrupt lines and their levels.
    pub fn interrupts(&mut self) -> [(u16, bool); IRQS] {
        let tims: [bool; 6] = std::array::from_fn(|k| self.tims[k].interrupt());
        let tx_rx_wired = self.gpio[0].alternate(2, 12) && self.gpio[0].alternate(3, 12);
        std::array::from_fn(|k| match k {
            0..6 => (IRQ_TIMERS[k], tims[k]),
            6 => (IRQ_ADC1_2, self.adc.interrupt()),
            7 => (IRQ_PVD, self.supply.interrupt()),
            8 => (IRQ_DMA1_CHANNEL7, self.dma.interrupt(DMA_CHANNEL)),
            _ => (IRQ_LPUART1, tx_rx_wired && self.lpuart.interrupt()),
        })
    }
}

/// The requests of a bus: receive, transmit.
fn wants<C: Chip>(spi: &Spi<C>, [receive, send]: [u32; 2]) -> [Option<u32>; 2] {
    [spi.wants_to_receive().then_some(receive), spi.wants_to_send().then_some(send)]
}

/// 16-bit level of an ADC input with this supply, mV.
fn level(world: &World, millivolt: u32, channel: u32) -> u16 {
    let (code, at) = match channel {
        REFERENCE => (u32::from(FACTORY_REFERENCE) << 4, 3000),
        _ => (u32::from(world.level(channel)), 3300),
    };
    (code * at).checked_div(millivolt).unwrap_or(u32::MAX).min(u32::from(u16::MAX)) as u16
}

#[cfg(test)]
#[path = "soc_tests.rs"]
mod tests;
#[cfg(test)]
#[path = "witness_tests.rs"]
mod witness;
