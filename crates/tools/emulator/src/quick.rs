//! A quick core for the instructions that firmware mostly executes, beside rsemu's.
//!
//! rsemu takes a lock, asks the MPU and decodes at every instruction. This core keeps decoded instructions and registers, and does
//! what rsemu would do, cycle by cycle; the tests compare the two. Everything else is rsemu's: exceptions, sleep, the private
//! peripherals, exclusive accesses, faults, and every operation on floats whose flags a host does not show.

use crate::alu::{alu, is_normal_or_zero, on_host, product_signs, shift_imm, shift_reg};
use crate::bus::{PERIPHERALS, PERIPHERALS_END, Shared};
use crate::code::{Code, Decoded};
use crate::flash::BANK_2;
use crate::image::{CCM_BASE, CCM_END, FLASH_BASE, RAM_BASE, RAM_END};
use crate::wait::Fetch;
use rsemu::core::space::{AddressSpace, MemAttrs, RamStore, RomStore};
use rsemu::core::value::{Endian, Width};
use rsemu::cpu::arm::v7m::fp::{self, fpscr};
use rsemu::cpu::arm::v7m::fpisa::{DataOp, FpInsn, UnaryOp};
use rsemu::cpu::arm::v7m::isa::{BitfieldOp, Cond, ExtendOp, Insn, MemOffset, MiscOp, Operand, Size};
use rsemu::cpu::arm::v7m::sys::{Sys, control, fpccr};
use rsemu::cpu::arm::v7m::{ArmV7m, Regs};

const N: u32 = 1 << 31;
const Z: u32 = 1 << 30;
const C: u32 = 1 << 29;
const V: u32 = 1 << 28;
const Q: u32 = 1 << 27;
const IT_STATE: u32 = 0x0600_fc00;

/// Private peripherals, and exception returns.
const PRIVATE: u32 = 0xe000_0000;
/// Branch targets from here on end an exception.
const RETURNS: u32 = 0xf000_0000;
/// SYSm of PRIMASK.
const PRIMASK: u8 = 16;

/// MPU_CTRL: enabled, with the default map behind the regions.
const MPU_ON: u32 = 1;
const MPU_DEFAULT_MAP: u32 = 4;

/// State that is rsemu's while rsemu executes.
#[derive(Debug)]
pub(crate) struct Quick {
    pub code: Code,
    /// Copy of S0 to S31 and FPSCR, if it is valid, and registers in which it is newer than rsemu's.
    s: [u32; 32],
    fpscr: u32,
    floats_known: bool,
    floats_changed: u64,
    /// A floating-point instruction needs nothing but its execution.
    floats_ready: bool,
    /// Addresses that the MPU guards, up to the second.
    guard: (u32, u32),
    /// Cycles executed here since the last reset, and those that DWT_CYCCNT has not counted.
    pub cycles: u64,
    uncounted: u64,
    /// PRIMASK has changed.
    pub masked: bool,
    /// rsemu has loaded the first stack pointer.
    pub started: bool,
}

/// What executes an instruction.
pub(crate) struct Core<'a> {
    pub quick: &'a mut Quick,
    pub regs: &'a mut Regs,
    pub cpu: &'a ArmV7m,
    pub bank_1: &'a RomStore,
    pub ram: &'a RamStore,
    pub ccm: &'a RamStore,
    pub space: &'a AddressSpace,
    pub shared: &'a Shared,
}

impl Quick {
    pub fn new(flash_bytes: u32) -> Self {
        Self {
            code: Code::new(flash_bytes),
            s: [0; 32],
            fpscr: 0,
            floats_known: false,
            floats_changed: 0,
            floats_ready: false,
            guard: (0, 0),
            cycles: 0,
            uncounted: 0,
            masked: false,
            started: false,
        }
    }

    /// Forgets what a reset changes.
    pub fn reset(&mut self) {
        (self.cycles, self.uncounted) = (0, 0);
        (self.floats_known, self.floats_changed) = (false, 0);
        self.started = false;
    }

    /// Whether the settings of the core are those that this one knows.
    pub fn can_run(&mut self, sys: &Sys, regs: &Regs) -> bool {
        use rsemu::cpu::arm::v7m::{sys::ccr, xpsr};
        let plain = self.started
            && regs.xpsr & xpsr::T != 0
            && !regs.faultmask
            && regs.basepri == 0
            && regs.control & (control::NPRIV | control::SPSEL) == 0
            && sys.ccr & ccr::UNALIGN_TRP == 0
            && sys.syst_csr & 1 == 0
            && !sys.reset_requested;
        let ready = fpccr::ASPEN | fpccr::LSPACT;
        self.floats_ready = sys.fpccr & ready == fpccr::ASPEN && sys.fp_enabled(true);
        self.guard = (0, 0);
        if sys.mpu_ctrl & MPU_ON != 0 {
            for (base, attributes) in sys.mpu_rbar.into_iter().zip(sys.mpu_rasr) {
                if attributes & 1 != 0 {
                    let size = 2_u64 << (attributes >> 1 & 31);
                    let from = u64::from(base) & !(size - 1);
                    if from < u64::from(RAM_BASE) || from + size > u64::from(RAM_END) {
                        return false;
                    }
                    let (from, to) = (from as u32, (from + size) as u32);
                    self.guard = match self.guard {
                        (0, 0) => (from, to),
                        (first, last) => (first.min(from), last.max(to)),
                    };
                }
            }
        }
        plain && sys.mpu_ctrl & (MPU_ON | MPU_DEFAULT_MAP) != MPU_ON
    }

    /// Counts cycles.
    pub fn count(&mut self, cycles: u64) {
        self.cycles += cycles;
        self.uncounted += cycles;
    }

    /// Gives registers and cycles to rsemu.
    pub fn give(&mut self, cpu: &ArmV7m, regs: &Regs) {
        cpu.set_regs(*regs);
        let cycles = std::mem::take(&mut self.uncounted);
        cpu.with_sys(|sys| sys.tick_cyccnt(cycles));
    }

    /// Gives the floats that have changed to rsemu.
    pub fn give_floats(&mut self, cpu: &ArmV7m) {
        let mut changed = std::mem::take(&mut self.floats_changed);
        if changed >> 32 != 0 {
            cpu.set_fpscr(self.fpscr);
        }
        changed &= u64::from(u32::MAX);
        while changed != 0 {
            let k = changed.trailing_zeros();
            changed &= changed - 1;
            cpu.set_s(k as u8, self.s[k as usize]);
        }
    }

    /// Forgets the floats, which rsemu may have changed.
    pub fn forget_floats(&mut self) {
        self.floats_known = false;
    }

    fn take_floats(&mut self, cpu: &ArmV7m) {
        if !self.floats_known {
            for (k, s) in (0..).zip(&mut self.s) {
                *s = cpu.s(k);
            }
            self.fpscr = cpu.fpscr();
            self.floats_known = true;
        }
    }
}

/// Whether rsemu neither looks at floats nor changes them for this instruction, which it executes without an exception.
pub(crate) fn without_floats(insn: Option<Insn>) -> bool {
    matches!(
        insn,
        Some(
            Insn::LoadStoreExclusive { .. }
                | Insn::ClearExclusive
                | Insn::Hint { .. }
                | Insn::Mrs { .. }
                | Insn::Msr { .. }
                | Insn::Simd { .. }
        )
    )
}

impl Core<'_> {
    /// The instruction at the program counter.
    #[inline]
    fn decoded(&mut self) -> Option<Decoded> {
        self.quick.code.at(self.regs.r[15], self.bank_1, self.ccm)
    }

    /// The instruction at the program counter.
    pub fn next(&mut self) -> Option<Insn> {
        self.decoded().map(|decoded| decoded.insn)
    }

    /// Executes one instruction: how it was fetched, and its cycles without waits. `None` leaves everything as it was: rsemu must execute it.
    pub fn step(&mut self) -> Option<(Fetch, u64)> {
        let pc = self.regs.r[15];
        let Decoded { insn, fetch } = self.decoded()?;
        let wide = fetch.bytes == 4;
        let xpsr = self.regs.xpsr;
        let it = (xpsr >> 8 & 0xfc | xpsr >> 25 & 3) as u8;
        let mut passes = it == 0 || Cond(it >> 4).passes(xpsr);
        if let Insn::Branch { cond: Some(cond), .. } = insn {
            passes &= cond.passes(xpsr);
        }
        let mut cycles = 1;
        let after = pc.wrapping_add(fetch.bytes);
        self.regs.r[15] = pc.wrapping_add(4);
        let next = if passes {
            let flags = wide || it == 0;
            let Some((next, used)) = self.execute(insn, pc, flags) else {
                self.regs.r[15] = pc;
                return None;
            };
            cycles += used;
            next.unwrap_or(after)
        } else {
            after
        };
        if it != 0 && !matches!(insn, Insn::It { .. }) {
            let it = if it & 7 == 0 { 0 } else { it & 0xe0 | it << 1 & 0x1f };
            self.set_it(it);
        }
        self.regs.r[15] = next;
        self.regs.msp = self.regs.r[13];
        self.quick.count(cycles);
        Some((fetch, cycles))
    }

    fn set_it(&mut self, it: u8) {
        let it = u32::from(it);
        self.regs.xpsr = self.regs.xpsr & !IT_STATE | it >> 2 << 10 | (it & 3) << 25;
    }

    fn get(&self, register: u8) -> u32 {
        self.regs.r[usize::from(register & 15)]
    }

    /// A write to the program counter this way is unpredictable, and ignored.
    fn set(&mut self, register: u8, value: u32) {
        if register & 15 != 15 {
            self.regs.r[usize::from(register & 15)] = value;
        }
    }

    fn flag(&self, mask: u32) -> bool {
        self.regs.xpsr & mask != 0
    }

    fn set_flag(&mut self, mask: u32, on: bool) {
        self.regs.xpsr = if on { self.regs.xpsr | mask } else { self.regs.xpsr & !mask };
    }

    fn set_nz(&mut self, value: u32) {
        self.regs.xpsr = self.regs.xpsr & !(N | Z) | value & N | if value == 0 { Z } else { 0 };
    }

    /// A branch that may end an exception or leave Thumb state is rsemu's.
    fn target(&self, target: u32) -> Option<u32> {
        (target & 1 != 0 && target < RETURNS).then_some(target & !1)
    }

    fn is_guarded(&self, address: u32, bytes: u32) -> bool {
        address < self.quick.guard.1 && address.wrapping_add(bytes) > self.quick.guard.0
    }

    /// Whether words from an address on are all in one memory, where an access has no effect but itself.
    fn is_plain(&self, address: u32, bytes: u32, store: bool) -> bool {
        let within = |from: u32, to: u32| address >= from && address <= to - bytes;
        address & 3 == 0
            && !self.is_guarded(address, bytes)
            && (within(RAM_BASE, RAM_END)
                || within(CCM_BASE, CCM_END)
                || !store && within(FLASH_BASE, BANK_2))
    }

    fn load(&mut self, address: u32, bytes: u32) -> Option<u32> {
        if self.is_guarded(address, bytes) {
            return None;
        }
        let width = width(bytes);
        let value = match address {
            RAM_BASE..RAM_END => self.ram.read_value(u64::from(address - RAM_BASE), width, Endian::Little),
            CCM_BASE..CCM_END => self.ccm.read_value(u64::from(address - CCM_BASE), width, Endian::Little),
            _ if address & (bytes - 1) != 0 => return None,
            FLASH_BASE..BANK_2 => {
                let value =
                    self.bank_1.read_value(u64::from(address - FLASH_BASE), width, Endian::Little).ok()?;
                self.shared.load_from_flash(address);
                Ok(value)
            }
            _ if is_aliased(address) => return None,
            PERIPHERALS..PERIPHERALS_END => {
                let mut data = [0; 4];
                self.shared.load(address, &mut data[..bytes as usize]);
                Ok(u64::from(u32::from_le_bytes(data)))
            }
            _ => self.space.read(u64::from(address), width, MemAttrs::DEFAULT.with_privileged(true)),
        };
        value.ok().map(|value| value as u32)
    }

    fn store(&mut self, address: u32, bytes: u32, value: u32) -> Option<()> {
        if self.is_guarded(address, bytes) {
            return None;
        }
        let (width, value) = (width(bytes), u64::from(value));
        let stored = match address {
            RAM_BASE..RAM_END => {
                self.ram.write_value(u64::from(address - RAM_BASE), width, value, Endian::Little)
            }
            CCM_BASE..CCM_END => {
                self.quick.code.forget(address - CCM_BASE, bytes);
                self.ccm.write_value(u64::from(address - CCM_BASE), width, value, Endian::Little)
            }
            _ if address & (bytes - 1) != 0 || is_aliased(address) => return None,
            PERIPHERALS..PERIPHERALS_END => {
                self.shared.store(address, &value.to_le_bytes()[..bytes as usize]);
                Ok(())
            }
            _ => self.space.write(u64::from(address), width, value, MemAttrs::DEFAULT.with_privileged(true)),
        };
        stored.ok()
    }

    /// Executes; where it branches to, and the cycles after the first. The program counter reads four beyond the instruction.
    fn execute(&mut self, insn: Insn, pc: u32, flags: bool) -> Option<(Option<u32>, u64)> {
        let on = Some((None, 0));
        match insn {
            Insn::DataProc { op, s, rd, rn, operand } => {
                let carry = self.flag(C);
                let (b, shifted_out) = match operand {
                    Operand::Imm { value, carry: out } => (value, out.unwrap_or(carry)),
                    Operand::Reg { rm, shift } => shift_imm(shift, self.get(rm), carry),
                };
                let a = if op.is_unary() { 0 } else { self.get(rn) };
                let (result, c, v) = alu(op, a, b, carry, shifted_out, self.flag(V));
                let mut branch = (None, 0);
                if !op.is_test() {
                    if rd == 15 {
                        branch = (Some(result & !1), 2);
                    } else {
                        self.set(rd, result);
                    }
                }
                if s && (flags || op.is_test()) {
                    let others = self.regs.xpsr & !(N | Z | C | V);
                    let zero = if result == 0 { Z } else { 0 };
                    self.regs.xpsr = others | result & N | zero | (u32::from(c) * C) | (u32::from(v) * V);
                }
                Some(branch)
            }
            Insn::ShiftReg { ty, s, rd, rn, rm } => {
                let (result, c) = shift_reg(ty, self.get(rn), self.get(rm) & 0xff, self.flag(C));
                self.set(rd, result);
                if s && flags {
                    self.set_nz(result);
                    self.set_flag(C, c);
                }
                on
            }
            Insn::Adr { rd, imm, add } => {
                self.set(rd, moved(self.regs.r[15] & !3, imm, add));
                on
            }
            Insn::MovImm16 { top, rd, imm } => {
                let imm = u32::from(imm);
                self.set(rd, if top { self.get(rd) & 0xffff | imm << 16 } else { imm });
                on
            }
            Insn::Branch { offset, .. } => Some((Some(self.regs.r[15].wrapping_add(offset as u32) & !1), 2)),
            Insn::BranchLink { offset } => {
                let target = self.regs.r[15].wrapping_add(offset as u32) & !1;
                self.regs.r[14] = pc.wrapping_add(4) | 1;
                Some((Some(target), 2))
            }
            Insn::Bx { rm } => Some((Some(self.target(self.get(rm))?), 2)),
            Insn::Blx { rm } => {
                let target = self.target(self.get(rm))?;
                self.regs.r[14] = pc.wrapping_add(2) | 1;
                Some((Some(target), 2))
            }
            Insn::Cbz { nonzero, rn, offset } => {
                if (self.get(rn) != 0) == nonzero {
                    Some((Some(self.regs.r[15].wrapping_add(offset) & !1), 2))
                } else {
                    on
                }
            }
            Insn::TableBranch { rn, rm, half } => {
                let bytes = if half { 2 } else { 1 };
                let at = self.get(rn).wrapping_add(self.get(rm).wrapping_mul(bytes));
                if at & (bytes - 1) != 0 {
                    return None;
                }
                let offset = self.load(at, bytes)?;
                Some((Some(self.regs.r[15].wrapping_add(2 * offset) & !1), 3))
            }
            Insn::It { cond, mask } => {
                self.set_it(cond.0 << 4 | mask);
                on
            }
            Insn::LoadStore { load, size, signed, rt, rn, offset, index, add, wback, unpriv: false } => {
                let base = self.get(rn);
                let delta = match offset {
                    MemOffset::Imm(value) => value,
                    MemOffset::Reg { rm, lsl } => self.get(rm) << u32::from(lsl),
                };
                let moved = moved(base, delta, add);
                let address = if index { moved } else { base };
                if load && rt == 15 {
                    // what it loads decides who executes it
                    if !self.is_plain(address, 4, true) {
                        return None;
                    }
                    let target = self.load(address, 4)?;
                    let target = self.target(target)?;
                    if wback {
                        self.set(rn, moved);
                    }
                    return Some((Some(target), 3));
                }
                if load {
                    let value = extended(self.load(address, size.bytes())?, size, signed);
                    if wback {
                        self.set(rn, moved);
                    }
                    self.set(rt, value);
                } else {
                    self.store(address, size.bytes(), self.get(rt))?;
                    if wback {
                        self.set(rn, moved);
                    }
                }
                Some((None, 1))
            }
            Insn::LoadLiteral { size, signed, rt, imm, add } if rt != 15 => {
                let address = moved(self.regs.r[15] & !3, imm, add);
                let value = extended(self.load(address, size.bytes())?, size, signed);
                self.set(rt, value);
                Some((None, 1))
            }
            Insn::LoadStoreDual { load, rt, rt2, rn, imm, index, add, wback } => {
                let base = if rn == 15 { self.regs.r[15] & !3 } else { self.get(rn) };
                let moved = moved(base, imm, add);
                let address = if index { moved } else { base };
                if !self.is_plain(address, 8, !load) {
                    return None;
                }
                if load {
                    let (low, high) = (self.load(address, 4)?, self.load(address + 4, 4)?);
                    self.set(rt, low);
                    self.set(rt2, high);
                } else {
                    self.store(address, 4, self.get(rt))?;
                    self.store(address + 4, 4, self.get(rt2))?;
                }
                if wback && rn != 15 {
                    self.set(rn, moved);
                }
                Some((None, 2))
            }
            Insn::LoadStoreMultiple { load, rn, list, wback, before } => {
                self.multiple(load, rn, list, wback, before)
            }
            Insn::Mul { rd, rn, rm, ra, sub, s } => {
                let product = self.get(rn).wrapping_mul(self.get(rm));
                let result = match ra {
                    None => product,
                    Some(ra) if sub => self.get(ra).wrapping_sub(product),
                    Some(ra) => self.get(ra).wrapping_add(product),
                };
                self.set(rd, result);
                if s && flags {
                    self.set_nz(result);
                }
                on
            }
            Insn::MulLong { signed, accumulate, rdlo, rdhi, rn, rm, umaal } => {
                let (a, b) = (self.get(rn), self.get(rm));
                let (low, high) = (u64::from(self.get(rdlo)), u64::from(self.get(rdhi)));
                let product = if signed && !umaal {
                    (i64::from(a as i32) * i64::from(b as i32)) as u64
                } else {
                    u64::from(a) * u64::from(b)
                };
                let result = if umaal {
                    product + low + high
                } else if accumulate {
                    product.wrapping_add(high << 32 | low)
                } else {
                    product
                };
                self.set(rdlo, result as u32);
                self.set(rdhi, (result >> 32) as u32);
                Some((None, 1))
            }
            Insn::Div { signed, rd, rn, rm } => {
                let (a, b) = (self.get(rn), self.get(rm));
                if b == 0 {
                    return None;
                }
                self.set(rd, if signed { (a as i32).wrapping_div(b as i32) as u32 } else { a / b });
                Some((None, 2))
            }
            Insn::Extend { op, rd, rn, rm, rotate } => {
                let rotated = self.get(rm).rotate_right(u32::from(rotate));
                let value = match op {
                    ExtendOp::Sxtb => rotated as u8 as i8 as i32 as u32,
                    ExtendOp::Sxth => rotated as u16 as i16 as i32 as u32,
                    ExtendOp::Uxtb => rotated & 0xff,
                    ExtendOp::Uxth => rotated & 0xffff,
                    ExtendOp::Sxtb16 | ExtendOp::Uxtb16 => return None,
                };
                self.set(rd, if rn == 15 { value } else { self.get(rn).wrapping_add(value) });
                on
            }
            Insn::Misc { op, rd, rm } => {
                let value = self.get(rm);
                let result = match op {
                    MiscOp::Clz => value.leading_zeros(),
                    MiscOp::Rbit => value.reverse_bits(),
                    MiscOp::Rev => value.swap_bytes(),
                    MiscOp::Rev16 => value >> 8 & 0x00ff_00ff | value << 8 & 0xff00_ff00,
                    MiscOp::Revsh => (value as u16).swap_bytes() as i16 as i32 as u32,
                };
                self.set(rd, result);
                on
            }
            Insn::Bitfield { op, rd, rn, lsb, width } => {
                let lsb = u32::from(lsb) & 31;
                let width = u32::from(width).clamp(1, 32);
                let mask = u32::MAX >> (32 - width);
                let value = match op {
                    BitfieldOp::Ubfx => self.get(rn) >> lsb & mask,
                    BitfieldOp::Sbfx => {
                        let shift = 32 - width;
                        (((self.get(rn) >> lsb) << shift) as i32 >> shift) as u32
                    }
                    BitfieldOp::Bfi => self.get(rd) & !(mask << lsb) | (self.get(rn) & mask) << lsb,
                    BitfieldOp::Bfc => self.get(rd) & !(mask << lsb),
                };
                self.set(rd, value);
                on
            }
            Insn::Mrs { rd, sysm: PRIMASK } => {
                self.set(rd, u32::from(self.regs.primask));
                on
            }
            Insn::Cps { enable, i, f: false } => {
                if i {
                    self.regs.primask = !enable;
                    self.quick.masked = true;
                }
                on
            }
            Insn::Barrier { .. } => on,
            Insn::Fp(insn) => self.float(insn).map(|cycles| (None, cycles)),
            _ => None,
        }
    }

    fn multiple(
        &mut self,
        load: bool,
        rn: u8,
        list: u16,
        wback: bool,
        before: bool,
    ) -> Option<(Option<u32>, u64)> {
        let count = list.count_ones();
        let base = self.get(rn);
        let end = if before { base.wrapping_sub(4 * count) } else { base.wrapping_add(4 * count) };
        let start = if before { end } else { base };
        if count == 0 || !self.is_plain(start, 4 * count, !load) {
            return None;
        }
        let mut target = None;
        if load && list >> 15 != 0 {
            // what it loads decides who executes it; flash would count the load
            if !self.is_plain(start, 4 * count, true) {
                return None;
            }
            let loaded = self.load(start + 4 * (count - 1), 4)?;
            target = Some(self.target(loaded)?);
        }
        if load && wback {
            self.set(rn, end);
        }
        let mut address = start;
        let mut left = list & 0x7fff;
        while left != 0 {
            let register = left.trailing_zeros() as u8;
            left &= left - 1;
            if load {
                let value = self.load(address, 4)?;
                self.set(register, value);
            } else {
                self.store(address, 4, self.get(register))?;
            }
            address += 4;
        }
        if !load {
            if list >> 15 != 0 {
                self.store(address, 4, self.regs.r[15])?;
            }
            if wback {
                self.set(rn, end);
            }
        }
        Some((target, u64::from(count) + if target.is_some() { 2 } else { 0 }))
    }

    fn s(&self, register: u8) -> u32 {
        self.quick.s[usize::from(register & 31)]
    }

    fn set_s(&mut self, register: u8, value: u32) {
        self.quick.s[usize::from(register & 31)] = value;
        self.quick.floats_changed |= 1 << (register & 31);
    }

    fn set_fpscr(&mut self, value: u32) {
        if value != self.quick.fpscr {
            self.quick.fpscr = value;
            self.quick.floats_changed |= 1 << 32;
        }
    }

    /// A result of rsemu's arithmetic, with its exceptions.
    fn finish(&mut self, register: u8, (value, raised): (u32, rsemu::float::Flags)) {
        self.set_s(register, value);
        let mut status = self.quick.fpscr;
        fp::accumulate(&mut status, raised);
        self.set_fpscr(status);
    }

    /// A floating-point instruction; its cycles after the first.
    fn float(&mut self, insn: FpInsn) -> Option<u64> {
        if !self.quick.floats_ready || self.regs.control & control::FPCA == 0 {
            return None;
        }
        self.quick.take_floats(self.cpu);
        match insn {
            FpInsn::Data { op, d, n, m } => {
                let (a, b, c) = (self.s(d), self.s(n), self.s(m));
                if let Some(value) = on_host(self.quick.fpscr, op, a, b, c) {
                    self.set_s(d, value);
                } else {
                    let env = fp::env(self.quick.fpscr);
                    let result = match op {
                        DataOp::Add => fp::add(b, c, env),
                        DataOp::Sub => fp::sub(b, c, env),
                        DataOp::Mul => fp::mul(b, c, env),
                        DataOp::Div => fp::div(b, c, env),
                        DataOp::Fma => fp::mul_add(a, b, c, env),
                        DataOp::Fms => fp::mul_add(a, fp::neg(b), c, env),
                        DataOp::Fnma => fp::mul_add(fp::neg(a), fp::neg(b), c, env),
                        DataOp::Fnms => fp::mul_add(fp::neg(a), b, c, env),
                        DataOp::Nmul => {
                            let (value, raised) = fp::mul(b, c, env);
                            (fp::neg(value), raised)
                        }
                        DataOp::Mla | DataOp::Mls | DataOp::Nmla | DataOp::Nmls => {
                            let (product, raised) = fp::mul(b, c, env);
                            let (a_sign, product_sign) = product_signs(op);
                            let (sum, also) = fp::add(a ^ a_sign, product ^ product_sign, env);
                            (sum, raised | also)
                        }
                        _ => return None,
                    };
                    self.finish(d, result);
                }
                Some(match op {
                    DataOp::Div => 13,
                    DataOp::Mla | DataOp::Mls | DataOp::Nmla | DataOp::Nmls => 2,
                    DataOp::Fma | DataOp::Fms | DataOp::Fnma | DataOp::Fnms => 2,
                    _ => 0,
                })
            }
            FpInsn::Unary { op, d, m } => {
                let a = self.s(m);
                match op {
                    UnaryOp::Mov => self.set_s(d, a),
                    UnaryOp::Abs => self.set_s(d, fp::abs(a)),
                    UnaryOp::Neg => self.set_s(d, fp::neg(a)),
                    UnaryOp::Sqrt => {
                        let root = fp::sqrt(a, fp::env(self.quick.fpscr));
                        self.finish(d, root);
                        return Some(13);
                    }
                    _ => return None,
                }
                Some(0)
            }
            FpInsn::MovImm { d, imm } => {
                self.set_s(d, imm);
                Some(0)
            }
            FpInsn::Cmp { d, m, with_zero, signal_all } => {
                let (a, b) = (self.s(d), if with_zero { 0 } else { self.s(m) });
                let mut status = self.quick.fpscr & !fpscr::FLAGS;
                if is_normal_or_zero(a) && is_normal_or_zero(b) {
                    let (a, b) = (f32::from_bits(a), f32::from_bits(b));
                    status |= if a == b {
                        fpscr::Z | fpscr::C
                    } else if a < b {
                        fpscr::N
                    } else {
                        fpscr::C
                    };
                } else {
                    let (flags, raised) = fp::compare(a, b, signal_all, fp::env(self.quick.fpscr));
                    status |= flags;
                    fp::accumulate(&mut status, raised);
                }
                self.set_fpscr(status);
                Some(0)
            }
            FpInsn::CvtInt { d, m, to_int, signed, round_zero } => {
                let a = self.s(m);
                let env = fp::env(self.quick.fpscr);
                let result = if to_int {
                    let env = if round_zero { env.round(rsemu::float::Round::TowardZero) } else { env };
                    fp::to_fixed(a, 32, !signed, 0, env)
                } else {
                    fp::from_fixed(a, 32, !signed, 0, env)
                };
                self.finish(d, result);
                Some(0)
            }
            FpInsn::MovCore { to_fp, rt, n } => {
                if to_fp {
                    self.set_s(n, self.get(rt));
                } else {
                    self.set(rt, self.s(n));
                }
                Some(0)
            }
            FpInsn::MovCore2 { to_fp, rt, rt2, m, .. } => {
                let next = m.wrapping_add(1);
                if to_fp {
                    let (low, high) = (self.get(rt), self.get(rt2));
                    self.set_s(m, low);
                    self.set_s(next, high);
                } else {
                    let (low, high) = (self.s(m), self.s(next));
                    self.set(rt, low);
                    self.set(rt2, high);
                }
                Some(1)
            }
            FpInsn::Sys { to_core: true, rt: 15, reg: 1 } => {
                let flags = self.quick.fpscr & fpscr::FLAGS;
                // as rsemu: Q is kept
                self.regs.xpsr = self.regs.xpsr & !(N | Z | C | V | Q) | flags | self.regs.xpsr & Q;
                Some(0)
            }
            FpInsn::Mem { load, d, rn, imm, add, double } => {
                let base = if rn == 15 { self.regs.r[15] & !3 } else { self.get(rn) };
                let words = if double { 2 } else { 1 };
                self.floats_of_memory(load, d, moved(base, imm, add), words)?;
                Some(u64::from(words))
            }
            FpInsn::Multi { load, d, rn, count, add, writeback, .. } => {
                let (base, bytes) = (self.get(rn), 4 * u32::from(count));
                let start = if add { base } else { base.wrapping_sub(bytes) };
                self.floats_of_memory(load, d, start, u32::from(count))?;
                if writeback {
                    self.set(rn, if add { base.wrapping_add(bytes) } else { start });
                }
                Some(u64::from(count))
            }
            _ => None,
        }
    }

    fn floats_of_memory(&mut self, load: bool, d: u8, address: u32, words: u32) -> Option<()> {
        if words == 0 || !self.is_plain(address, 4 * words, !load) {
            return None;
        }
        for k in 0..words {
            let register = d.wrapping_add(k as u8);
            if load {
                let value = self.load(address + 4 * k, 4)?;
                self.set_s(register, value);
            } else {
                self.store(address + 4 * k, 4, self.s(register))?;
            }
        }
        Some(())
    }
}

/// Bit-band aliases, and everything behind the bus of the core.
fn is_aliased(address: u32) -> bool {
    matches!(address, 0x2200_0000..0x2400_0000 | 0x4200_0000..0x4400_0000 | PRIVATE..)
}

fn width(bytes: u32) -> Width {
    match bytes {
        1 => Width::U8,
        2 => Width::U16,
        _ => Width::U32,
    }
}

fn moved(base: u32, by: u32, up: bool) -> u32 {
    if up { base.wrapping_add(by) } else { base.wrapping_sub(by) }
}

fn extended(raw: u32, size: Size, signed: bool) -> u32 {
    match (size, signed) {
        (Size::Byte, true) => raw as u8 as i8 as i32 as u32,
        (Size::Half, true) => raw as u16 as i16 as i32 as u32,
        _ => raw,
    }
}

#[cfg(test)]
#[path = "quick_tests.rs"]
mod tests;
