//! Core, memories, chip and rig, in virtual time.

use crate::bus::{Bank2, Shared, Window};
use crate::flash::{BANK_2, BANK_BYTES};
use crate::image::{FLASH_BASE, RAM_BASE, RAM_SIZE};
use crate::inject::Injector;
use crate::rcc::ResetCause;
use crate::soc::{IRQ_ADC1_2, Soc};
use crate::stats::Statistics;
use crate::world::World;
use crate::{Image, Injected, UNITS_PER_MS, units_per_cycle};
use friction::FrictionLaw;
use plant::{Bench, Hand, RigConfig, Truth, Wiring};
use rsemu::core::space::{AddressSpace, RamStore, Region, RomStore, RomWrite};
use rsemu::cpu::arm::v7m::{ArmV7m, Config};
use std::collections::BTreeSet;
use std::sync::Arc;
use std::sync::atomic::Ordering::Relaxed;

/// RAM before power-on, to see how deep the stack went.
const PAINT: u8 = 0xc5;

/// Instructions of another handler after which a pending control interrupt is one that waits.
const HELD_UP: u32 = 4;

/// Where xPSR keeps ITSTATE.
const IT_STATE: u32 = 0x0600_fc00;
/// Offset of xPSR in an exception frame.
const FRAME_XPSR: u64 = 28;

/// A board with the rig on it.
pub struct Machine {
    cpu: ArmV7m,
    space: Arc<AddressSpace>,
    shared: Arc<Shared>,
    ram: Arc<RamStore>,
    image: Image,
    now: u64,
    /// Next time the chip has something to say.
    next: u64,
    cycle: u64,
    /// Cycles at entry of the control interrupt, while it runs.
    entered: Option<u64>,
    control_pending: bool,
    handler: u32,
    /// Instructions of another handler while the control interrupt was pending.
    held_up: u32,
    resets: Vec<(f64, ResetCause)>,
    /// Observed here because it is touched with every instruction.
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
    /// Programs an image and powers the board up, with a rig of this configuration on it.
    ///
    /// Of `config`, the sub-stepping and the actuation delay are replaced: time and delay are the board's.
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
        let space = Arc::new(address_space(&shared, bank_1, Arc::clone(&ram)));
        Ok(Self {
            cpu: core(&space),
            space,
            shared,
            ram,
            handler: image.vector(16 + u32::from(IRQ_ADC1_2)) & !1,
            image: image.clone(),
            now: 0,
            next: 0,
            cycle: 1,
            entered: None,
            control_pending: false,
            held_up: 0,
            resets: Vec::new(),
            elapsed: 0,
            asleep: 0,
            busy_cycles: 0,
        })
    }

    /// A board with the thesis's rig and nothing on its handle but what the firmware renders.
    #[must_use]
    pub fn free_handle(image: &Image, seed: u64) -> Self {
        let no_block = friction::Custom(|_: &friction::Motion<f64>| 0.0);
        // built here, not by the caller, so that the rig is optimised as this crate is
        Self::boot(image, RigConfig::free_handle(), no_block, seed)
            .expect("the thesis's rig is within its ranges")
    }

    /// Runs for this many virtual milliseconds.
    pub fn run_for(&mut self, ms: f64) {
        self.run_until(self.now + (ms * UNITS_PER_MS as f64) as u64, |_| false);
    }

    /// Runs until the terminal has shown `text`, at most `ms`. What came before stays readable.
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

    fn run_until(&mut self, end: u64, stop: impl Fn(&Self) -> bool) {
        let mut asleep = self.is_idle();
        while self.now < end && !stop(self) {
            if self.now >= self.next || self.shared.touched.swap(false, Relaxed) {
                self.attend();
                asleep = self.is_idle();
            }
            self.shared.now.store(self.now, Relaxed);
            let before = self.now;
            let was_asleep = asleep;
            let cycles = self.step();
            asleep = self.is_idle();
            if was_asleep && asleep {
                // nothing but an event can wake it
                self.now = self.next.clamp(self.now + self.cycle, end.max(self.now + self.cycle));
            } else {
                self.now += cycles * self.cycle;
                self.watch_control();
                self.watch_priority();
            }
            self.account(before, was_asleep, cycles);
            if self.cpu.reset_requested() {
                self.cpu.clear_reset_request();
                self.reset(ResetCause::Software);
                asleep = self.is_idle();
            }
        }
    }

    /// Asleep, or locked up after a fault within a fault.
    fn is_idle(&self) -> bool {
        self.cpu.is_asleep() || self.cpu.is_locked_up()
    }

    /// One instruction, or the entry of one exception.
    ///
    /// rsemu 0.0.7 stacks xPSR without ITSTATE: after an interrupt within an IT block the rest of the block would run
    /// whatever its condition. A core keeps it (ARMv7-M, B1.5.6), so it is put back into the frame here.
    fn step(&mut self) -> u64 {
        let it = self.cpu.xpsr() & IT_STATE;
        if it == 0 {
            return self.cpu.step();
        }
        let (stack, exception) = (self.cpu.msp(), self.cpu.current_exception());
        let cycles = self.cpu.step();
        let frame = self.cpu.msp();
        if frame < stack && self.cpu.current_exception() != exception {
            let at = u64::from(frame.wrapping_sub(RAM_BASE)) + FRAME_XPSR;
            let mut word = [0; 4];
            if self.ram.read_at(at, &mut word).is_ok() {
                let _ = self.ram.write_at(at, &(u32::from_le_bytes(word) | it).to_le_bytes());
            }
        }
        cycles
    }

    fn account(&mut self, before: u64, asleep: bool, cycles: u64) {
        let elapsed = self.now - before;
        self.elapsed += elapsed;
        if asleep {
            self.asleep += elapsed;
        } else {
            self.busy_cycles += cycles;
        }
    }

    /// Brings the chip up to date and its interrupts to the core.
    fn attend(&mut self) {
        let mut soc = self.shared.soc();
        soc.advance(self.now);
        for (irq, level) in soc.interrupts() {
            self.cpu.set_irq(irq, level);
            if irq == IRQ_ADC1_2 {
                self.control_pending = level;
            }
        }
        self.cycle = units_per_cycle(soc.rcc.hclk());
        self.next = soc.next_event();
        let due = soc.watchdog_due(self.now);
        let (nmi, power_lost) = (std::mem::take(&mut soc.flash.nmi), soc.flash.power_lost);
        drop(soc);
        // a pulse: rsemu would take a level again as long as the handler has not cleared it
        self.cpu.set_nmi(nmi);
        if nmi {
            self.shared.touched.store(true, Relaxed);
        }
        if power_lost {
            let _ = self.ram.fill(0, u64::from(RAM_SIZE), PAINT);
            self.reset(ResetCause::PowerOn);
        } else if due {
            self.reset(ResetCause::Watchdog);
        }
    }

    /// A pending control interrupt preempts every handler, unless a critical section masks it.
    fn watch_priority(&mut self) {
        if !self.control_pending || self.entered.is_some() {
            self.held_up = 0;
            return;
        }
        let exception = self.cpu.current_exception().0;
        let waits = exception > 15 && exception != 16 + IRQ_ADC1_2 && self.cpu.execution_priority() > 0;
        self.held_up = if waits { self.held_up + 1 } else { 0 };
        if self.held_up == HELD_UP {
            let why = format!(
                "the control interrupt waits for interrupt {}: its priority is too low",
                exception - 16
            );
            self.shared.soc().violations.insert(why);
        }
    }

    /// Cycles of the control interrupt, from its first instruction to its return.
    fn watch_control(&mut self) {
        match self.entered {
            None if self.control_pending && self.cpu.pc() == self.handler => {
                self.entered = Some(self.cpu.cycles());
            }
            Some(at) if self.cpu.current_exception().0 != 16 + IRQ_ADC1_2 => {
                self.entered = None;
                let cycles = self.cpu.cycles() - at;
                self.shared.soc().stats.step_cycles.add(cycles as f64);
            }
            _ => {}
        }
    }

    fn reset(&mut self, cause: ResetCause) {
        self.resets.push((self.milliseconds(), cause));
        self.shared.soc().reset(cause, self.now);
        // a reset of rsemu's leaves the NVIC's settings and a lazy FPU context behind; the chip's does not
        self.cpu = core(&self.space);
        self.shared.touched.store(true, Relaxed);
        self.entered = None;
    }

    /// Types at the terminal on the serial line.
    pub fn serial_write(&mut self, bytes: &[u8]) {
        self.shared.soc().lpuart.type_bytes(bytes, self.now);
        self.shared.touched.store(true, Relaxed);
    }

    /// Bytes typed that are not yet on the wire.
    #[must_use]
    pub fn serial_waiting(&self) -> usize {
        self.shared.soc().lpuart.waiting()
    }

    /// Takes what the terminal has shown.
    pub fn serial_read(&mut self) -> Vec<u8> {
        self.shared.soc().lpuart.shown.drain(..).collect()
    }

    /// Puts a hand on the handle.
    pub fn set_hand(&mut self, hand: impl Hand + Send + 'static) {
        self.shared.soc().world.set_hand(Box::new(hand));
    }

    /// Wires the rig's signals otherwise, from now on.
    pub fn rewire(&mut self, wiring: Wiring) {
        self.shared.soc().world.rewire(wiring);
    }

    /// Puts something on the sensors for a calibration.
    ///
    /// # Errors
    /// A weight or a gravity that is out of range.
    pub fn put_on_bench(&mut self, bench: Bench) -> Result<(), friction::Invalid> {
        self.shared.soc().world.put_on_bench(bench)
    }

    /// From now on the sensors say what `source` gives, asked once at the end of every conversion.
    pub fn inject(&mut self, source: impl FnMut() -> Injected + Send + 'static) {
        self.shared.soc().injector = Some(Injector(Box::new(source)));
    }

    /// Presses or releases the emergency stop.
    pub fn press_stop(&mut self, pressed: bool) {
        self.shared.soc().press_stop(pressed);
    }

    /// Writes a register as a fault of the hardware would, behind the firmware's back.
    pub fn poke(&mut self, address: u32, value: u32) {
        self.shared.soc().write(address, value, self.now);
        self.shared.touched.store(true, Relaxed);
    }

    /// Sets the supply of the chip, mV; 3300 is right. Too low a one resets it.
    pub fn set_supply(&mut self, millivolt: u32) {
        let too_low = self.shared.soc().supply.set(millivolt);
        self.shared.touched.store(true, Relaxed);
        if too_low {
            self.reset(ResetCause::PowerOn);
        }
    }

    /// Makes the core panic where it is, as a division by zero would: it calls a panic of the core library that takes
    /// nothing but a location, here in RAM that nothing uses. False when the image has no such function.
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

    /// Runs until the control interrupt has been running for some instructions; false when it does not within 2 ms.
    pub fn run_into_control(&mut self) -> bool {
        let end = self.now + 2 * UNITS_PER_MS;
        self.run_until(end, |machine| machine.entered.is_some_and(|at| machine.cpu.cycles() - at > 300));
        self.now < end
    }

    /// Runs until a task is being executed: no interrupt, not asleep; false when none is within 5 ms.
    pub fn run_into_task(&mut self) -> bool {
        let end = self.now + 5 * UNITS_PER_MS;
        self.run_until(end, |machine| machine.cpu.current_exception().0 == 0 && !machine.cpu.is_asleep());
        self.now < end
    }

    /// Overwrites every aligned word of RAM that has one value by another, as a stray pointer would; how many there were.
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

    /// The words of RAM from a static of the image on, by a part of its name; `None` when the image has none of it.
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

    /// Address of the first halfword of the image with this value that is code's to have.
    #[must_use]
    pub fn find_code(&self, halfword: u16) -> Option<u32> {
        self.image.flash.iter().find_map(|(address, data)| {
            let at = data.chunks_exact(2).position(|pair| pair == halfword.to_le_bytes())?;
            Some(address + 2 * at as u32)
        })
    }

    /// Cuts power at the n-th erasure or programming of the flash from now on, half done as `seed` says; the board
    /// starts again at once, its RAM lost.
    pub fn cut_power_at(&mut self, n: u64, seed: u64) {
        self.shared.soc().flash.cut_at(Some(n), seed);
    }

    /// Erasures and programmings of the flash since power-on or since [`Self::cut_power_at`].
    #[must_use]
    pub fn flash_operations(&self) -> u64 {
        self.shared.soc().flash.operations()
    }

    /// What is in bank 2 of the flash, from an address on.
    #[must_use]
    pub fn flash(&self, address: u32) -> Vec<u8> {
        self.shared.soc().flash.contents(address.saturating_sub(BANK_2)).to_vec()
    }

    /// Writes into bank 2 as a programmer does.
    pub fn program_flash(&mut self, address: u32, bytes: &[u8]) {
        self.shared.soc().flash.load(address.saturating_sub(BANK_2), bytes);
    }

    /// Sends the core to an address, as a stray bit in a return address would.
    pub fn derail(&mut self, address: u32) {
        self.cpu.set_pc(address);
    }

    /// What really happened at the rig, up to 10 µs ahead.
    #[must_use]
    pub fn truth(&self) -> Truth {
        self.shared.soc().world.truth()
    }

    /// Force the amplifier was told, N; 0 while it is off.
    #[must_use]
    pub fn force(&self) -> f64 {
        self.shared.soc().world.force()
    }

    /// The amplifier enable pin is high.
    #[must_use]
    pub fn amplifier_on(&self) -> bool {
        self.shared.soc().amplifier_on()
    }

    /// What was observed.
    #[must_use]
    pub fn statistics(&self) -> Statistics {
        let observed = self.shared.soc().stats.clone();
        let (elapsed, asleep, busy_cycles) = (self.elapsed, self.asleep, self.busy_cycles);
        Statistics { elapsed, asleep, busy_cycles, ..observed }
    }

    /// Starts observing afresh.
    pub fn reset_statistics(&mut self) {
        self.shared.soc().stats = Statistics::default();
        (self.elapsed, self.asleep, self.busy_cycles) = (0, 0, 0);
    }

    /// What the data sheet forbids and the firmware did.
    #[must_use]
    pub fn violations(&self) -> BTreeSet<String> {
        self.shared.soc().violations.clone()
    }

    /// Bytes typed that the receiver lost.
    #[must_use]
    pub fn serial_overruns(&self) -> u64 {
        self.shared.soc().lpuart.overruns
    }

    /// Resets since power-on: when in ms, and why.
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

    /// The core gave up: a fault inside a fault.
    #[must_use]
    pub fn locked_up(&self) -> bool {
        self.cpu.is_locked_up()
    }

    /// Where the core is, for a person.
    #[must_use]
    pub fn whereabouts(&self) -> String {
        let pc = self.cpu.pc();
        let near = self.image.symbols.iter().filter(|(_, a)| **a & !1 <= pc).max_by_key(|(_, a)| **a & !1);
        format!("pc {pc:#010x} in {}", near.map_or("?", |(name, _)| name))
    }

    /// Most bytes of stack that were ever used.
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

fn address_space(shared: &Arc<Shared>, bank_1: Vec<u8>, ram: Arc<RamStore>) -> AddressSpace {
    let space = AddressSpace::new("cpu", 32);
    let mut map = space.topology();
    let window = |base| Arc::new(Window { shared: Arc::clone(shared), base });
    // constants that do not overlap
    let regions = [
        (Region::rom("bank 1", Arc::new(RomStore::new(bank_1)), RomWrite::Fault), u64::from(FLASH_BASE)),
        (Region::io("bank 2", u64::from(BANK_BYTES), Arc::new(Bank2(Arc::clone(shared)))), u64::from(BANK_2)),
        (Region::ram("ram", ram), u64::from(RAM_BASE)),
        (Region::ram("system", Arc::new(RamStore::new(0x1_0000))), 0x1fff_0000),
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
