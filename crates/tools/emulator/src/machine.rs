//! Core, memories, chip and rig, in virtual time.

mod run;

use crate::bus::{Bank1, Bank2, Shared, Window};
use crate::code;
use crate::flash::{BANK_2, BANK_BYTES};
use crate::image::{CCM_BASE, FLASH_BASE, RAM_BASE, RAM_SIZE, SYSTEM_BASE, SYSTEM_SIZE, system_memory};
use crate::inject::{Injector, Pulses};
use crate::quick::Quick;
use crate::rcc::ResetCause;
use crate::recording::Recording;
use crate::soc::{IRQ_ADC1_2, IRQS, Soc};
use crate::stats::Statistics;
use crate::svd::Register;
use crate::wait::{Literals, Waits};
use crate::world::World;
use crate::{ConverterFault, EncoderFault, Image, Injected, UNITS_PER_MS, units_per_cycle};
use friction::FrictionLaw;
use plant::{Bench, Hand, RigConfig, Truth, Wiring};
use rsemu::core::space::{AddressSpace, DispatchPolicy, RamStore, Region, RomStore};
use rsemu::cpu::arm::v7m::{ArmV7m, Config};
use std::collections::{BTreeSet, HashMap};
use std::sync::Arc;
use std::sync::atomic::Ordering::Relaxed;

/// Content of RAM before power-on, which shows the depth of the stack.
const PAINT: u8 = 0xc5;

/// A board with its rig.
pub struct Machine {
    cpu: ArmV7m,
    space: Arc<AddressSpace>,
    shared: Arc<Shared>,
    bank_1: Arc<RomStore>,
    ram: Arc<RamStore>,
    ccm: Arc<RamStore>,
    image: Image,
    now: u64,
    /// Time of the next event of the chip.
    next: u64,
    cycle: u64,
    quick: Quick,
    /// Only rsemu executes.
    reference: bool,
    /// Waits for instructions in flash.
    waits: Waits,
    /// Cycles of rsemu since the last reset.
    slow_cycles: u64,
    /// Cycles that the core waited for memories and buses.
    waited: u64,
    /// Cycle count at entry of the running control interrupt.
    entered: Option<u64>,
    /// Cycles that every control interrupt loses at its entry.
    control_delay: u64,
    /// Loads from flash up to that entry.
    loads_at_entry: u64,
    control_pending: bool,
    /// Interrupt lines as the core was last told.
    lines: [(u16, bool); IRQS],
    handler: u32,
    /// Instructions of another handler while the control interrupt was pending.
    held_up: u32,
    resets: Vec<(f64, ResetCause)>,
    /// Statistics, here because every instruction updates them.
    elapsed: u64,
    asleep: u64,
    busy_cycles: u64,
}

impl std::fmt::Debug for Machine {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Machine").field("now", &self.now).field("pc", &self.cpu.pc()).finish_non_exhaustive()
    }
}

impl Machine {
    /// Programs an image and powers up the board with a rig of this configuration.
    ///
    /// Sub-stepping and actuation delay of `config` are replaced by those of the board.
    ///
    /// # Errors
    /// The first parameter of the rig out of range.
    pub fn boot<L>(image: &Image, config: RigConfig, law: L, seed: u64) -> Result<Self, friction::Invalid>
    where
        L: FrictionLaw<f64> + Send + 'static,
        L::State: Send,
    {
        let shared = Arc::new(Shared::new(Soc::new(World::new(config, law, seed)?)));
        let mut bank_1 = vec![0xff; BANK_BYTES as usize];
        let ram = Arc::new(RamStore::new(u64::from(RAM_SIZE)));
        let _ = ram.fill(0, u64::from(RAM_SIZE), PAINT);
        for (address, data) in &image.flash {
            // inside the flash: the image was checked
            for (at, byte) in (address - FLASH_BASE..).zip(data) {
                match bank_1.get_mut(at as usize) {
                    Some(to) => *to = *byte,
                    None => shared.soc().flash.load(at - BANK_BYTES, &[*byte]),
                }
            }
        }
        let code_bytes = image.flash.iter().map(|(address, data)| address - FLASH_BASE + data.len() as u32);
        let quick = Quick::new(code_bytes.max().unwrap_or(0).min(BANK_BYTES));
        shared.soc().dma.attach(Arc::clone(&ram));
        let bank_1 = Arc::new(RomStore::new(bank_1));
        let ccm = Arc::new(code::ccm_store());
        let space = Arc::new(address_space(&shared, Arc::clone(&bank_1), Arc::clone(&ram), Arc::clone(&ccm)));
        Ok(Self {
            cpu: core(&space),
            space,
            shared,
            bank_1,
            ram,
            ccm,
            handler: image.vector(16 + u32::from(IRQ_ADC1_2)) & !1,
            image: image.clone(),
            now: 0,
            next: 0,
            cycle: 1,
            quick,
            reference: false,
            waits: Waits::new(),
            slow_cycles: 0,
            waited: 0,
            entered: None,
            loads_at_entry: 0,
            control_delay: 0,
            control_pending: false,
            lines: Default::default(),
            held_up: 0,
            resets: Vec::new(),
            elapsed: 0,
            asleep: 0,
            busy_cycles: 0,
        })
    }

    /// A board with the rig of [thesis, table 3-1] and a free handle.
    #[must_use]
    pub fn free_handle(image: &Image, seed: u64) -> Self {
        let no_block = friction::Custom(|_: &friction::Motion<f64>| 0.0);
        // instantiated here, so that the rig is optimised like this crate
        Self::boot(image, RigConfig::free_handle(), no_block, seed)
            .expect("the default rig is within its ranges")
    }

    /// Runs for this many virtual milliseconds.
    pub fn run_for(&mut self, ms: f64) {
        self.run_until(self.now + (ms * UNITS_PER_MS as f64) as u64, |_| false);
    }

    /// Runs until the terminal has shown `text`, at most `ms`. Earlier output stays readable.
    pub fn run_until_shown(&mut self, text: &str, ms: f64) -> bool {
        let end = self.now + (ms * UNITS_PER_MS as f64) as u64;
        while self.now < end {
            self.run_for(0.2);
            let soc = self.shared.soc();
            let shown: Vec<u8> = soc.lpuart.shown.iter().copied().collect();
            if shown.windows(text.len()).any(|window| window == text.as_bytes()) {
                return true;
            }
        }
        false
    }

    /// Disables the quick core: rsemu executes everything. Slower, with the same result.
    pub fn set_reference(&mut self, reference: bool) {
        self.reference = reference;
    }

    fn reset(&mut self, cause: ResetCause) {
        self.resets.push((self.milliseconds(), cause));
        self.shared.soc().reset(cause, self.now);
        // unlike the chip, a reset of rsemu keeps NVIC settings and a lazy FPU context
        self.cpu = core(&self.space);
        // its cycles begin at 0 again: a line that was read ahead would be there only when they are where they were
        self.waits = Waits::new();
        *self.shared.literals() = Literals::new();
        self.slow_cycles = 0;
        self.quick.reset();
        self.lines = Default::default();
        self.shared.touched.store(true, Relaxed);
        self.entered = None;
    }

    /// Types at the terminal on the serial line.
    pub fn serial_write(&mut self, bytes: &[u8]) {
        self.shared.soc().lpuart.type_bytes(bytes, self.now);
        self.shared.touched.store(true, Relaxed);
    }

    /// Number of typed bytes that are not yet on the wire.
    #[must_use]
    pub fn serial_waiting(&self) -> usize {
        self.shared.soc().lpuart.waiting()
    }

    /// Takes the output of the terminal.
    pub fn serial_read(&mut self) -> Vec<u8> {
        self.shared.soc().lpuart.shown.drain(..).collect()
    }

    /// Puts a hand on the handle.
    pub fn set_hand(&mut self, hand: impl Hand + Send + 'static) {
        self.shared.soc().world.set_hand(Box::new(hand));
    }

    /// Changes the wiring of the rig.
    pub fn rewire(&mut self, wiring: Wiring) {
        self.shared.soc().world.rewire(wiring);
    }

    /// Replaces the amplifier by one whose gain is this share of the normal one, and that gives this force, N, without a command.
    pub fn set_amplifier(&mut self, gain: f64, at_zero: f64) {
        self.shared.soc().world.set_amplifier(gain, at_zero);
    }

    /// Loads the sensors for a calibration.
    ///
    /// # Errors
    /// A weight or a gravity that is out of range.
    pub fn put_on_bench(&mut self, bench: Bench) -> Result<(), friction::Invalid> {
        self.shared.soc().world.put_on_bench(bench)
    }

    /// Resets the chip as this cause does. Power takes the contents of the RAM away.
    pub fn reset_by(&mut self, cause: ResetCause) {
        if cause == ResetCause::PowerOn {
            let _ = self.ram.fill(0, u64::from(RAM_SIZE), PAINT);
        }
        self.reset(cause);
    }

    /// Sets the option byte DBANK, as a programmer does: two banks of flash, or one.
    pub fn set_dual_bank(&mut self, dual: bool) {
        self.shared.soc().flash.set_dual_bank(dual);
    }

    /// Sets the option byte BOR_LEV, as a programmer does: 0 to 4.
    pub fn set_brown_out_level(&mut self, level: u32) {
        let mut soc = self.shared.soc();
        soc.flash.set_brown_out_level(level);
        soc.supply.set_brown_out_level(level);
    }

    /// Replaces sensor readings by those of `source`, called once at the end of every conversion.
    pub fn inject(&mut self, source: impl FnMut() -> Injected + Send + 'static) {
        self.shared.soc().injector = Some(Injector(Box::new(source)));
    }

    /// Turns the encoder at an even pace instead of the rig: an edge every `interval` ticks of 170 MHz, the first after `first`.
    pub fn turn_encoder(&mut self, first: u64, interval: u64, up: bool) {
        let tick = units_per_cycle(170_000_000);
        let pulses = Pulses { next: self.now + first * tick, interval: interval * tick, up };
        self.shared.soc().pulses = Some(pulses);
        self.shared.touched.store(true, Relaxed);
    }

    /// Puts the encoder's index pulse to a place of the stroke, m.
    pub fn set_index(&mut self, position: f64) {
        self.shared.soc().world.set_index(position);
    }

    /// The encoder loses counts, or makes them up.
    pub fn slip_encoder(&mut self, counts: i32) {
        self.shared.soc().slip_encoder(counts);
    }

    /// Sets the delay from a count of the encoder to the capture of its time, timer cycles.
    pub fn set_capture_lag(&mut self, cycles: u64) {
        self.shared.soc().capture_lag = cycles;
    }

    /// Takes this many cycles from every control interrupt, like a busy bus.
    pub fn delay_control(&mut self, cycles: u64) {
        self.control_delay = cycles;
    }

    /// Presses or releases the emergency stop.
    pub fn press_stop(&mut self, pressed: bool) {
        self.shared.soc().press_stop(pressed);
    }

    /// The amplifier reports a fault, or is healthy again.
    pub fn set_amplifier_fault(&mut self, faulty: bool) {
        self.shared.soc().amplifier_fault = faulty;
    }

    /// Breaks or repairs the absolute encoder.
    pub fn set_encoder_fault(&mut self, fault: EncoderFault) {
        self.shared.soc().spi2.chip.fault = fault;
    }

    /// Breaks or repairs the converter of the load cell on SPI3.
    pub fn set_converter_fault(&mut self, fault: ConverterFault) {
        self.shared.soc().spi3.chip.set_fault(fault, self.now);
    }

    /// Restarts the converter of the load cell on SPI3, which loses its settings.
    pub fn restart_converter(&mut self) {
        self.shared.soc().spi3.chip.restart();
    }

    /// Breaks or repairs the wire of the force command. Without it the amplifier's input is at 0 V: the full negative force.
    pub fn break_command(&mut self, broken: bool) {
        self.shared.soc().world.command_broken = broken;
    }

    /// From now on a store that changes reserved bits of these registers is a violation, and so is one to any other address of the
    /// peripherals.
    pub fn watch_reserved_bits(&mut self, registers: &[Register]) {
        let mut watched = HashMap::new();
        for register in registers {
            // several registers may share an address
            let name = format!("{} {}", register.peripheral, register.name);
            let (_, _, fields) = watched.entry(register.address).or_insert((name, register.reset, 0));
            *fields |= register.mask();
        }
        let _ = self.shared.watched.set(watched);
    }

    /// Records the run from here on, which is before the first instruction.
    pub fn record(&mut self) {
        let _ = self.shared.recording.set(Recording::default());
    }

    /// The recording so far, as the module `recording` describes it. Empty without one.
    #[must_use]
    pub fn recording(&self) -> Vec<u8> {
        self.shared.recording.get().map(Recording::bytes).unwrap_or_default()
    }

    /// Writes a register like a hardware fault.
    pub fn poke(&mut self, address: u32, value: u32) {
        self.shared.soc().write(address, value, self.now);
        self.shared.touched.store(true, Relaxed);
    }

    /// The crystal stops, or oscillates again.
    pub fn set_crystal(&mut self, oscillates: bool) {
        self.shared.soc().set_crystal(oscillates, self.now);
        self.shared.touched.store(true, Relaxed);
    }

    /// Deviation of the internal oscillator, parts in 10 000: 100 is 1 %.
    pub fn set_internal_clock_error(&mut self, parts: i64) {
        self.shared.soc().rcc.set_hsi_error(parts);
        self.shared.touched.store(true, Relaxed);
    }

    /// Sets the supply of the chip, mV, nominally 3300. A low supply resets it.
    pub fn set_supply(&mut self, millivolt: u32) {
        let too_low = self.shared.soc().supply.set(millivolt);
        self.shared.touched.store(true, Relaxed);
        if too_low {
            self.reset(ResetCause::PowerOn);
        }
    }

    /// Makes the core panic at its present place, like a division by zero: calls a panic of the core library that takes only a
    /// location, placed in unused RAM. False if the image has no such function.
    pub fn panic_here(&mut self) -> bool {
        let called = self.image.symbols.iter().find(|(name, _)| name.contains("panic_const_"));
        let Some(function) = called.map(|(_, address)| *address & !1) else { return false };
        let location = self.image.symbol("__sheap").unwrap_or(RAM_BASE) + 64;
        // the text, its length, line, column
        for (k, word) in [FLASH_BASE, 4, 7, 1].into_iter().enumerate() {
            let _ = self.ram.write_at(u64::from(location - RAM_BASE) + 4 * k as u64, &u32::to_le_bytes(word));
        }
        self.cpu.set_reg(0, location);
        self.cpu.set_pc(function);
        true
    }

    /// Sends the core into a branch to itself, in unused RAM: what looks like one in flash may be data. Four `nop` precede
    /// it, because the core may be within an IT block, which allows no branch.
    pub fn hang(&mut self) {
        let at = self.image.symbol("__sheap").unwrap_or(RAM_BASE) + 96;
        for (k, halfword) in [0xbf00_u16, 0xbf00, 0xbf00, 0xbf00, 0xe7fe].into_iter().enumerate() {
            let _ = self.ram.write_at(u64::from(at - RAM_BASE) + 2 * k as u64, &halfword.to_le_bytes());
        }
        self.cpu.set_pc(at);
    }

    /// Runs to the first instruction of the control interrupt. False if it does not begin within 2 ms.
    pub fn run_to_control(&mut self) -> bool {
        let end = self.now + 2 * UNITS_PER_MS;
        self.run_until(end, |machine| machine.entered.is_some());
        self.now < end
    }

    /// Runs into the control interrupt. False if it does not run within 2 ms.
    pub fn run_into_control(&mut self) -> bool {
        let end = self.now + 2 * UNITS_PER_MS;
        self.run_until(end, |machine| machine.entered.is_some_and(|at| machine.cycles() - at > 300));
        self.now < end
    }

    /// Runs into a task: no interrupt, not asleep. False if none runs within 5 ms.
    pub fn run_into_task(&mut self) -> bool {
        let end = self.now + 5 * UNITS_PER_MS;
        self.run_until(end, |machine| machine.cpu.current_exception().0 == 0 && !machine.cpu.is_asleep());
        self.now < end
    }

    /// Replaces every aligned word of RAM with one value by another, like a stray pointer. Returns their number.
    pub fn corrupt_ram(&mut self, from: u32, to: u32) -> usize {
        let mut changed = 0;
        for at in (0..u64::from(RAM_SIZE)).step_by(4) {
            let mut word = [0; 4];
            if self.ram.read_at(at, &mut word).is_ok() && u32::from_le_bytes(word) == from {
                changed += usize::from(self.ram.write_at(at, &to.to_le_bytes()).is_ok());
            }
        }
        changed
    }

    /// Words of RAM from a static of the image on, found by a part of its name. `None` without such a static.
    #[must_use]
    pub fn static_words(&self, name: &str, words: usize) -> Option<Vec<u32>> {
        let (_, address) = self.image.symbols.iter().find(|(symbol, _)| symbol.contains(name))?;
        let begin = u64::from(address.checked_sub(RAM_BASE)?);
        let word = |k: usize| {
            let mut word = [0; 4];
            self.ram.read_at(begin + 4 * k as u64, &mut word).ok()?;
            Some(u32::from_le_bytes(word))
        };
        (0..words).map(word).collect()
    }

    /// Cuts power at the n-th erasure or programming of the flash from now on, half done, depending on `seed`. The board restarts
    /// at once without its RAM.
    pub fn cut_power_at(&mut self, n: u64, seed: u64) {
        self.shared.soc().flash.cut_at(Some(n), seed);
    }

    /// Number of erasures and programmings of the flash since power-on or [`Self::cut_power_at`].
    #[must_use]
    pub fn flash_operations(&self) -> u64 {
        self.shared.soc().flash.operations()
    }

    /// Contents of bank 2 of the flash from an address on.
    #[must_use]
    pub fn flash(&self, address: u32) -> Vec<u8> {
        self.shared.soc().flash.contents(address.saturating_sub(BANK_2)).to_vec()
    }

    /// Writes into bank 2 like a programmer.
    pub fn program_flash(&mut self, address: u32, bytes: &[u8]) {
        self.shared.soc().flash.load(address.saturating_sub(BANK_2), bytes);
    }

    /// Sends the core to an address, like a flipped bit in a return address.
    pub fn derail(&mut self, address: u32) {
        self.cpu.set_pc(address);
    }

    /// True state of the rig, up to 10 µs ahead.
    #[must_use]
    pub fn truth(&self) -> Truth {
        self.shared.soc().world.truth()
    }

    /// Force commanded to the amplifier, N. 0 while it is off.
    #[must_use]
    pub fn force(&self) -> f64 {
        self.shared.soc().world.force()
    }

    /// Whether the amplifier enable pin is high.
    #[must_use]
    pub fn amplifier_on(&self) -> bool {
        self.shared.soc().amplifier_on(self.now)
    }

    /// Statistics.
    #[must_use]
    pub fn statistics(&self) -> Statistics {
        let observed = self.shared.soc().stats.clone();
        let (elapsed, asleep, busy_cycles) = (self.elapsed, self.asleep, self.busy_cycles);
        Statistics { elapsed, asleep, busy_cycles, ..observed }
    }

    /// Resets the statistics.
    pub fn reset_statistics(&mut self) {
        self.shared.soc().stats = Statistics::default();
        (self.elapsed, self.asleep, self.busy_cycles) = (0, 0, 0);
    }

    /// Violations of the data sheet by the firmware.
    #[must_use]
    pub fn violations(&self) -> BTreeSet<String> {
        self.shared.soc().violations.clone()
    }

    /// Number of typed bytes that the receiver lost.
    #[must_use]
    pub fn serial_overruns(&self) -> u64 {
        self.shared.soc().lpuart.overruns
    }

    /// Resets since power-on: time, ms, and reason.
    #[must_use]
    pub fn resets(&self) -> &[(f64, ResetCause)] {
        &self.resets
    }

    /// Time from power-on to the first control step, ms.
    #[must_use]
    pub fn first_step_ms(&self) -> Option<f64> {
        self.shared.soc().first_step_at.map(|at| at as f64 / UNITS_PER_MS as f64)
    }

    /// Virtual time since power-on, ms.
    #[must_use]
    pub fn milliseconds(&self) -> f64 {
        self.now as f64 / UNITS_PER_MS as f64
    }

    /// Whether the core is locked up by a nested fault.
    #[must_use]
    pub fn locked_up(&self) -> bool {
        self.cpu.is_locked_up()
    }

    /// Position of the core, for a person.
    #[must_use]
    pub fn whereabouts(&self) -> String {
        let pc = self.cpu.pc();
        let near = self.image.symbols.iter().filter(|(_, a)| **a & !1 <= pc).max_by_key(|(_, a)| **a & !1);
        format!("pc {pc:#010x} in {}", near.map_or("?", |(name, _)| name))
    }

    /// Largest stack use, bytes.
    #[must_use]
    pub fn stack_bytes(&self) -> u32 {
        let top = self.image.symbol("_stack_start").unwrap_or(RAM_BASE + RAM_SIZE);
        let bottom = self.image.symbol("__sheap").or(self.image.symbol("__ebss")).unwrap_or(RAM_BASE);
        let mut free = 0;
        while bottom + free < top && self.ram.read_u8(u64::from(bottom + free - RAM_BASE)).ok() == Some(PAINT)
        {
            free += 1;
        }
        top - bottom - free
    }
}

fn core(space: &Arc<AddressSpace>) -> ArmV7m {
    let core = ArmV7m::new(Config::CORTEX_M4F.with_priority_bits(4).with_reset_vtor(FLASH_BASE));
    core.attach_space(Arc::clone(space));
    core
}

fn address_space(
    shared: &Arc<Shared>,
    bank_1: Arc<RomStore>,
    ram: Arc<RamStore>,
    ccm: Arc<RamStore>,
) -> AddressSpace {
    // of pages of 32 KiB, which divide the memories, up to the end of the peripherals
    let pages = DispatchPolicy::Dense { page_bits: 15, cover: 0x6000_0000 };
    let space = AddressSpace::new("cpu", 32).with_dispatch(pages);
    let mut map = space.topology();
    let window = |base| Arc::new(Window { shared: Arc::clone(shared), base });
    let code = Bank1 { shared: Arc::clone(shared), store: bank_1, base: FLASH_BASE };
    let system = Arc::new(RamStore::new(u64::from(SYSTEM_SIZE)));
    // as large as it is, so this cannot fail
    let _ = system.write_at(0, &system_memory());
    // constants that do not overlap
    let regions = [
        (Region::io("bank 1", u64::from(BANK_BYTES), Arc::new(code)), u64::from(FLASH_BASE)),
        (Region::ram("ccm", ccm), u64::from(CCM_BASE)),
        (Region::io("bank 2", u64::from(BANK_BYTES), Arc::new(Bank2(Arc::clone(shared)))), u64::from(BANK_2)),
        (Region::ram("ram", ram), u64::from(RAM_BASE)),
        (Region::ram("system", system), u64::from(SYSTEM_BASE)),
        (Region::ram("dbgmcu", Arc::new(RamStore::new(0x1000))), 0xe004_2000),
        (Region::io("apb", 0x1000_0000, window(0x4000_0000)), 0x4000_0000),
        (Region::io("ahb2", 0x1000_0000, window(0x5000_0000)), 0x5000_0000),
    ];
    for (region, base) in regions {
        map.map(region, base).expect("the memory map has no overlap");
    }
    drop(map);
    space
}

#[cfg(test)]
#[path = "machine_tests.rs"]
mod tests;
