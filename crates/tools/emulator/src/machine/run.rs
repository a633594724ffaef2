//! Runs the core: instructions of the quick core in a row, and one step of rsemu where it must.

use super::{Machine, PAINT};
use crate::flash::BANK_2;
use crate::image::{CCM_BASE, CCM_END, FLASH_BASE, RAM_BASE, RAM_END, RAM_SIZE};
use crate::quick::{self, Core};
use crate::rcc::ResetCause;
use crate::soc::{IRQ_ADC1_2, IRQS};
use crate::wait::Fetch;
use rsemu::core::value::{Endian, Width};
use rsemu::cpu::arm::v7m::Regs;
use rsemu::cpu::arm::v7m::sys::{Exception, Sys};
use std::sync::atomic::Ordering::Relaxed;

/// Instructions of another handler after which a pending control interrupt counts as waiting.
const HELD_UP: u32 = 4;

/// Bits of ITSTATE in xPSR.
pub(super) const IT_STATE: u32 = 0x0600_fc00;
/// Where xPSR keeps the number of the exception.
const EXCEPTION: u32 = 0x1ff;
/// First half of WFE.W, WFI.W and the other hints of 32 bits.
const WIDE_HINT: u16 = 0xf3af;
/// Offset of xPSR in an exception frame.
const FRAME_XPSR: u64 = 28;

/// How a row of instructions ended.
#[derive(Default)]
struct Run {
    /// There was an instruction.
    any: bool,
    /// The next one need not be rsemu's.
    goes_on: bool,
}

impl Machine {
    // Each question to the core takes a lock, which costs as much as an instruction: they are asked only where the answer can
    // have changed.
    pub(super) fn run_until(&mut self, end: u64, stop: impl Fn(&Self) -> bool) {
        let mut asleep = self.is_idle();
        let mut regs = self.cpu.regs();
        // registers are newer than those of rsemu; no exception is due; nothing wakes the core
        let (mut ahead, mut calm, mut dozes) = (false, false, false);
        while self.now < end && !stop(self) {
            if self.is_due() {
                self.shared.touched.store(false, Relaxed);
                let resets = self.resets.len();
                if self.attend() {
                    (calm, dozes) = (false, false);
                }
                if self.resets.len() != resets {
                    regs = self.cpu.regs();
                    ahead = false;
                    asleep = self.is_idle();
                }
            }
            dozes = asleep && !self.reference && (dozes || self.sleeps_on());
            if dozes {
                self.doze(end);
                ahead = true;
                continue;
            }
            calm = !asleep && !self.reference && (calm || self.is_calm(&regs));
            let run = if calm { self.quick_run(&mut regs, end, &stop) } else { Run::default() };
            ahead |= run.any;
            if run.goes_on {
                calm = !std::mem::take(&mut self.quick.masked);
            } else {
                asleep = self.slow_run(&mut regs, end, asleep, ahead, calm);
                (ahead, calm) = (false, false);
            }
        }
        if ahead {
            self.quick.give(&self.cpu, &regs);
        }
        self.quick.give_floats(&self.cpu);
    }

    /// Whether the chip must be looked at before the next instruction.
    fn is_due(&self) -> bool {
        self.now >= self.next || self.shared.touched.load(Relaxed)
    }

    /// Instructions of the quick core in a row, until something else may be next: an event, an exception, or one that is rsemu's.
    fn quick_run(&mut self, regs: &mut Regs, end: u64, stop: &impl Fn(&Self) -> bool) -> Run {
        let before = self.now;
        // only then can an instruction without an exception change what the watches see
        let watched = self.control_pending && self.entered.is_none();
        let mut run = Run::default();
        let mut sum = 0;
        loop {
            let pc = regs.r[15];
            self.tell(pc);
            let Some((fetch, cycles)) = self.quick_step(regs) else { break };
            let cycles = cycles + self.waits(pc, fetch);
            sum += cycles;
            self.now += cycles * self.cycle;
            run.any = true;
            if self.now >= end || self.is_due() || self.quick.masked || watched || stop(self) {
                run.goes_on = true;
                break;
            }
        }
        if run.any {
            self.watch(regs);
            self.account(before, false, sum);
        }
        run
    }

    /// One step of rsemu, at this time. `ahead`: its registers are old; `calm`: no exception is due. Whether the core sleeps then.
    fn slow_run(&mut self, regs: &mut Regs, end: u64, was_asleep: bool, ahead: bool, calm: bool) -> bool {
        let (before, pc) = (self.now, regs.r[15]);
        self.tell(pc);
        let first = if was_asleep { None } else { self.first_half(pc) };
        let mut cycles = self.slow_step(regs, ahead, calm);
        if let Some(first) = first {
            cycles += self.waits(pc, Fetch::of(first));
        }
        let may_idle = matches!(first, None | Some(0xbf20 | 0xbf30 | WIDE_HINT));
        // a core that has locked up shows an address outside the memories
        let asleep = (may_idle || regs.r[15] >= RAM_END) && self.is_idle();
        if was_asleep && asleep {
            self.skip_to_event(end);
        } else {
            self.now += cycles * self.cycle;
            self.watch(regs);
        }
        self.account(before, was_asleep, cycles);
        asleep
    }

    /// A cycle of a core that sleeps on, as rsemu counts it.
    fn doze(&mut self, end: u64) {
        let before = self.now;
        self.quick.count(1);
        self.skip_to_event(end);
        self.account(before, true, 1);
    }

    /// Only an event can wake a core that sleeps.
    fn skip_to_event(&mut self, end: u64) {
        self.now = self.next.clamp(self.now + self.cycle, end.max(self.now + self.cycle));
    }

    /// Tells the chip when and where an instruction runs.
    fn tell(&self, pc: u32) {
        self.shared.now.store(self.now, Relaxed);
        self.shared.pc.store(pc, Relaxed);
    }

    /// Whether the core would execute an instruction next, not take an exception, with settings that the quick core knows.
    fn is_calm(&mut self, regs: &Regs) -> bool {
        if self.cpu.nmi_asserted() {
            return false;
        }
        let (lines, quick) = (&self.lines, &mut self.quick);
        self.cpu.with_sys(|sys| {
            latch(lines, sys);
            // can_run allows no other mask
            let running = if regs.primask { sys.active_priority().min(0) } else { sys.active_priority() };
            quick.can_run(sys, regs) && sys.highest_pending().is_none_or(|(_, priority)| priority >= running)
        })
    }

    /// Whether a core that is idle does nothing but count a cycle next, unseen by a recording.
    fn sleeps_on(&self) -> bool {
        self.quick.started
            && self.shared.recording.get().is_none()
            && !self.cpu.nmi_asserted()
            && !self.cpu.is_locked_up()
            && self.cpu.with_sys(|sys| {
                latch(&self.lines, sys);
                sys.syst_csr & 1 == 0 && !sys.reset_requested && sys.highest_pending().is_none()
            })
    }

    #[inline(always)]
    fn quick_core<'a>(&'a mut self, regs: &'a mut Regs) -> Core<'a> {
        Core {
            quick: &mut self.quick,
            regs,
            cpu: &self.cpu,
            bank_1: &self.bank_1,
            ram: &self.ram,
            ccm: &self.ccm,
            space: &self.space,
            shared: &self.shared,
        }
    }

    /// One instruction of the quick core, if it knows it: how it was fetched, and its cycles.
    #[inline(always)]
    fn quick_step(&mut self, regs: &mut Regs) -> Option<(Fetch, u64)> {
        if self.shared.recording.get().is_none() {
            return self.quick_core(regs).step();
        }
        let before = *regs;
        let stepped = self.quick_core(regs).step()?;
        if let Some(recording) = self.shared.recording.get() {
            recording.step(&before, regs, [false; 2], |exception| self.image.vector(exception));
        }
        Some(stepped)
    }

    /// One step of rsemu. `ahead`: its registers are old; `calm`: no exception is due.
    fn slow_step(&mut self, regs: &mut Regs, ahead: bool, calm: bool) -> u64 {
        let keeps = calm && quick::without_floats(self.quick_core(regs).next());
        if ahead {
            self.quick.give(&self.cpu, regs);
        }
        if !keeps {
            self.quick.give_floats(&self.cpu);
            self.quick.forget_floats();
        }
        let cycles = self.step(regs);
        self.quick.started = true;
        self.quick.code.forget_written(&self.ccm);
        cycles
    }

    /// Whether the core sleeps, or is locked up after a nested fault.
    fn is_idle(&self) -> bool {
        self.cpu.is_asleep() || self.cpu.is_locked_up()
    }

    /// First half-word of the instruction at an address; none outside the memories.
    fn first_half(&self, pc: u32) -> Option<u16> {
        let read = |at| self.bank_1.read_value(at, Width::U16, Endian::Little).ok();
        let first = match pc {
            FLASH_BASE..BANK_2 => read(u64::from(pc - FLASH_BASE)),
            CCM_BASE..CCM_END => {
                self.ccm.read_value(u64::from(pc - CCM_BASE), Width::U16, Endian::Little).ok()
            }
            RAM_BASE..RAM_END => {
                self.ram.read_value(u64::from(pc - RAM_BASE), Width::U16, Endian::Little).ok()
            }
            _ => None,
        };
        first.map(|first| first as u16)
    }

    /// Cycles that the instruction at an address has waited, with its loads and stores; counted.
    #[inline(always)]
    fn waits(&mut self, pc: u32, fetch: Fetch) -> u64 {
        let of_bus = self.shared.waited.load(Relaxed);
        if of_bus != 0 {
            self.shared.waited.store(0, Relaxed);
        }
        let of_code = match pc {
            FLASH_BASE..BANK_2 => self.waits.fetch(pc, fetch.bytes, self.cycles()),
            CCM_BASE..CCM_END => u64::from(fetch.literal),
            _ => 0,
        };
        self.waited += of_bus + of_code;
        of_bus + of_code
    }

    /// Core cycles since the start, with those that it waited.
    pub(super) fn cycles(&self) -> u64 {
        self.slow_cycles + self.quick.cycles + self.waited
    }

    /// One instruction, or the entry of one exception; `regs` are those before it, and then those after.
    ///
    /// rsemu 0.0.7 stacks xPSR without ITSTATE: after an interrupt within an IT block the rest of the block would run
    /// whatever its condition. A core keeps it [armv7-m, ch. B1.5.6], so it is restored in the frame here.
    pub(super) fn step(&mut self, regs: &mut Regs) -> u64 {
        let before = std::mem::take(regs);
        let records = self.shared.recording.get().is_some();
        let slept = records && self.cpu.is_asleep();
        let cycles = self.cpu.step();
        self.slow_cycles += cycles;
        *regs = self.cpu.regs();
        if let Some(recording) = self.shared.recording.get() {
            recording
                .step(&before, regs, [slept, self.cpu.is_asleep()], |exception| self.image.vector(exception));
        }
        let it = before.xpsr & IT_STATE;
        if it != 0 && regs.msp < before.msp && (regs.xpsr ^ before.xpsr) & EXCEPTION != 0 {
            let at = u64::from(regs.msp.wrapping_sub(RAM_BASE)) + FRAME_XPSR;
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

    /// Updates the chip and passes its interrupts to the core. Whether the core may do something else than before.
    fn attend(&mut self) -> bool {
        let mut soc = self.shared.running();
        soc.advance(self.now);
        let lines = soc.interrupts();
        for ((irq, level), told) in lines.into_iter().zip(self.lines) {
            if (irq, level) != told {
                self.cpu.set_irq(irq, level);
            }
            if irq == IRQ_ADC1_2 {
                self.control_pending = level;
            }
        }
        let changed = lines != self.lines;
        self.lines = lines;
        self.cycle = soc.rcc.units_per_cycle();
        self.next = soc.next_event();
        let acr = soc.flash.acr();
        if self.waits.set(acr) {
            self.shared.literals().set(acr);
        }
        let due = soc.watchdog_due(self.now);
        let nmi = std::mem::take(&mut soc.flash.nmi) | std::mem::take(&mut soc.rcc.nmi);
        let power_lost = soc.flash.power_lost;
        drop(soc);
        // a pulse: rsemu would take a level again until the handler clears it
        self.cpu.set_nmi(nmi);
        if nmi {
            self.shared.touched.store(true, Relaxed);
        }
        if self.cpu.reset_requested() {
            self.cpu.clear_reset_request();
            self.reset(ResetCause::Software);
        } else if power_lost {
            let _ = self.ram.fill(0, u64::from(RAM_SIZE), PAINT);
            self.reset(ResetCause::PowerOn);
        } else if due {
            self.reset(ResetCause::Watchdog);
        } else {
            return changed || nmi;
        }
        true
    }

    /// Looks at what an instruction has changed.
    fn watch(&mut self, regs: &Regs) {
        self.watch_control(regs);
        self.watch_priority(regs);
    }

    /// Priority of what runs, with these registers.
    fn execution_priority(&self, regs: &Regs) -> i32 {
        let masked = match (regs.primask, regs.faultmask) {
            (_, true) => -1,
            (true, false) => 0,
            _ => i32::MAX,
        };
        self.cpu.with_sys(|sys| {
            let base = match regs.basepri {
                0 => i32::MAX,
                base => i32::from(base & sys.group_mask()),
            };
            sys.active_priority().min(masked).min(base)
        })
    }

    /// A pending control interrupt preempts every handler, unless a critical section masks it.
    fn watch_priority(&mut self, regs: &Regs) {
        if !self.control_pending || self.entered.is_some() {
            self.held_up = 0;
            return;
        }
        let exception = (regs.xpsr & EXCEPTION) as u16;
        let waits = exception > 15 && exception != 16 + IRQ_ADC1_2 && self.execution_priority(regs) > 0;
        self.held_up = if waits { self.held_up + 1 } else { 0 };
        if self.held_up == HELD_UP {
            let why = format!(
                "the control interrupt waits for interrupt {}: its priority is too low",
                exception - 16
            );
            self.shared.running().violations.insert(why);
        }
    }

    /// Measures the cycles of the control interrupt, from its first instruction to its return.
    fn watch_control(&mut self, regs: &Regs) {
        match self.entered {
            None if self.control_pending && regs.r[15] == self.handler => {
                self.entered = Some(self.cycles());
                self.loads_at_entry = self.shared.flash_loads.load(Relaxed);
                self.waited += self.control_delay;
                self.now += self.control_delay * self.cycle;
            }
            Some(at) if regs.xpsr & EXCEPTION != 16 + u32::from(IRQ_ADC1_2) => {
                self.entered = None;
                let cycles = self.cycles() - at;
                let loads = self.shared.flash_loads.load(Relaxed) - self.loads_at_entry;
                let stats = &mut self.shared.running().stats;
                stats.step_cycles.add(cycles as f64);
                stats.step_flash_loads = stats.step_flash_loads.max(loads);
            }
            _ => {}
        }
    }
}

/// Does what rsemu does before each instruction: a level is pending until its handler runs.
fn latch(lines: &[(u16, bool); IRQS], sys: &mut Sys) {
    for (irq, level) in lines {
        let exception = Exception(irq + 16);
        if *level && !sys.is_active(exception) {
            sys.set_pending(exception, true);
        }
    }
}
