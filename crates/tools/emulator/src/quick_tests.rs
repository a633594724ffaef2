//! The quick core beside rsemu's: one instruction, the same state before, the same after.

use super::*;
use crate::bus::Window;
use crate::code;
use crate::image::{CCM_SIZE, RAM_SIZE};
use crate::random::Random;
use crate::soc::Soc;
use crate::world::World;
use plant::RigConfig;
use rsemu::core::space::{Region, RomWrite};
use rsemu::cpu::arm::v7m::Config;
use rsemu::cpu::arm::v7m::isa::{HintOp, decode, is_32bit};
use std::sync::Arc;

/// Place of the instruction.
const AT: u32 = CCM_BASE + 0x400;
/// Bytes of flash, which are random.
const FLASH_BYTES: usize = crate::flash::BANK_BYTES as usize;

/// Two cores with memories of their own.
struct Pair {
    quick: Quick,
    cpus: [ArmV7m; 2],
    rams: [Arc<RamStore>; 2],
    ccms: [Arc<RamStore>; 2],
    spaces: [Arc<AddressSpace>; 2],
    bank_1: Arc<RomStore>,
    shared: [Arc<Shared>; 2],
}

impl Pair {
    fn new(random: &mut Random) -> Self {
        let flash: Vec<u8> = (0..FLASH_BYTES).map(|_| word(random) as u8).collect();
        let bank_1 = Arc::new(RomStore::new(flash));
        let rams = [(); 2].map(|()| Arc::new(RamStore::new(u64::from(RAM_SIZE))));
        let ccms = [(); 2].map(|()| Arc::new(code::ccm_store()));
        let shared = [(); 2].map(|()| {
            let law = friction::Custom(|_: &friction::Motion<f64>| 0.0);
            let world = World::new(RigConfig::free_handle(), law, 1).expect("the default rig");
            Arc::new(Shared::new(Soc::new(world)))
        });
        let spaces = [0, 1].map(|k| {
            let space = AddressSpace::new("cpu", 32);
            let mut map = space.topology();
            for (region, base) in [
                (Region::rom("flash", Arc::clone(&bank_1), RomWrite::Fault), FLASH_BASE),
                (Region::ram("ccm", Arc::clone(&ccms[k])), CCM_BASE),
                (Region::ram("ram", Arc::clone(&rams[k])), RAM_BASE),
            ] {
                map.map(region, u64::from(base)).expect("no overlap");
            }
            let window = Window { shared: Arc::clone(&shared[k]), base: PERIPHERALS };
            let bytes = u64::from(PERIPHERALS_END - PERIPHERALS);
            map.map(Region::io("peripherals", bytes, Arc::new(window)), u64::from(PERIPHERALS))
                .expect("no overlap");
            drop(map);
            Arc::new(space)
        });
        let cpus = [0, 1].map(|k: usize| {
            let cpu = ArmV7m::new(Config::CORTEX_M4F.with_priority_bits(4).with_reset_vtor(FLASH_BASE));
            cpu.attach_space(Arc::clone(&spaces[k]));
            cpu.step();
            cpu.with_sys(|sys| {
                sys.cpacr = 0xf << 20;
                sys.demcr = 1 << 24;
                sys.dwt_ctrl |= 1;
                // the top 32 bytes of the RAM are guarded
                sys.mpu_rbar[0] = RAM_BASE + RAM_SIZE - 32;
                sys.mpu_rasr[0] = 4 << 1 | 1;
                sys.mpu_ctrl = MPU_ON | MPU_DEFAULT_MAP;
            });
            cpu
        });
        let mut quick = Quick::new(0);
        quick.started = true;
        Self { quick, cpus, rams, ccms, spaces, bank_1, shared }
    }

    fn write(&self, address: u32, bytes: &[u8]) {
        for (ram, ccm) in self.rams.iter().zip(&self.ccms) {
            let _ = match address {
                RAM_BASE.. => ram.write_at(u64::from(address - RAM_BASE), bytes),
                _ => ccm.write_at(u64::from(address - CCM_BASE), bytes),
            };
        }
    }

    /// Executes one instruction on both, from the same state. False if the quick core leaves it to rsemu.
    fn agree(&mut self, halves: [u16; 2], regs: Regs, s: [u32; 32], status: u32) -> bool {
        let code: Vec<u8> = halves.iter().flat_map(|half| half.to_le_bytes()).collect();
        self.write(AT, &code);
        for cpu in &self.cpus {
            cpu.set_regs(regs);
            for (k, s) in (0..).zip(s) {
                cpu.set_s(k, s);
            }
            cpu.set_fpscr(status);
        }
        let regs = self.cpus[0].regs();
        let mut after = regs;
        self.quick.forget_floats();
        self.quick.code.forget_written(&self.ccms[0]);
        let [quick, reference] = &self.cpus;
        assert!(quick.with_sys(|sys| self.quick.can_run(sys, &regs)));
        let before = quick.with_sys(|sys| sys.dwt_cyccnt);
        let mut core = Core {
            quick: &mut self.quick,
            regs: &mut after,
            cpu: quick,
            bank_1: &self.bank_1,
            ram: &self.rams[0],
            ccm: &self.ccms[0],
            space: &self.spaces[0],
            shared: &self.shared[0],
        };
        let Some((fetch, cycles)) = core.step() else {
            assert_eq!((after, self.quick.floats_changed), (regs, 0), "{halves:x?} half done");
            return false;
        };
        assert_eq!(fetch, Fetch::of(halves[0]));
        self.quick.give(quick, &after);
        self.quick.give_floats(quick);
        let counted = reference.with_sys(|sys| sys.dwt_cyccnt);
        let reference_cycles = reference.step();
        let what = || {
            let insn = decode(halves[0], halves[1]);
            format!("{halves:x?} {insn:?} from {regs:x?} {s:x?} {status:x}")
        };
        assert_eq!(quick.regs(), reference.regs(), "{}", what());
        assert_eq!(cycles, reference_cycles, "{}", what());
        assert_eq!(
            quick.with_sys(|sys| sys.dwt_cyccnt).wrapping_sub(before),
            reference.with_sys(|sys| sys.dwt_cyccnt).wrapping_sub(counted)
        );
        for k in 0..32 {
            assert_eq!(quick.s(k), reference.s(k), "s{k} {}", what());
        }
        assert_eq!(quick.fpscr(), reference.fpscr(), "{}", what());
        true
    }

    fn memories(&self, k: usize) -> [Vec<u8>; 2] {
        let (mut ram, mut ccm) = (vec![0; RAM_SIZE as usize], vec![0; CCM_SIZE as usize]);
        self.rams[k].read_at(0, &mut ram).expect("in range");
        self.ccms[k].read_at(0, &mut ccm).expect("in range");
        [ram, ccm]
    }
}

fn word(random: &mut Random) -> u32 {
    random.draw() as u32
}

/// Values at which carries, shifts and addresses differ.
fn value(random: &mut Random) -> u32 {
    let bits = word(random);
    match word(random) % 12 {
        0 => bits & 3,
        1 => u32::MAX - (bits & 3),
        2 => 0x7fff_ffff_u32.wrapping_add(bits & 3),
        3 => bits & 0x3f,
        4 | 5 => RAM_BASE + bits % RAM_SIZE,
        6 => (RAM_BASE + bits % RAM_SIZE) & !3,
        7 => RAM_BASE + RAM_SIZE - 64 + bits % 72,
        8 => (CCM_BASE + 0x800 + bits % 0x1000) & !3,
        9 => (FLASH_BASE + bits % FLASH_BYTES as u32) & !3,
        10 => peripheral(bits),
        _ => bits,
    }
}

/// A register of a peripheral, mostly of one that is modelled.
fn peripheral(bits: u32) -> u32 {
    let bases = [0x4000_0000, 0x4000_8000, 0x4002_0000, 0x4800_0000, 0x5000_0000];
    bases[bits as usize % bases.len()] + (bits >> 8 & 0x1ffc)
}

/// Floats of all kinds: of like size mostly, so that sums cancel.
fn float(random: &mut Random) -> u32 {
    let bits = word(random);
    match word(random) % 10 {
        0 => bits & 0x8000_0000,
        1 => bits & 0x807f_ffff,
        2 => bits | 0x7f80_0000,
        3 => bits & 0x8000_0000 | 0x7f80_0000,
        4 => bits,
        5 => bits & 0x80ff_ffff | 0x0080_0000,
        6 => (bits as i32 >> 16) as f32 as i32 as u32,
        7 => (((bits as i32) >> 20) as f32 * 0.25).to_bits(),
        _ => bits & 0x80ff_ffff | 0x3f00_0000,
    }
}

fn registers(random: &mut Random, within_it: bool) -> Regs {
    let mut regs = Regs::new();
    regs.r = std::array::from_fn(|_| value(random));
    regs.r[15] = AT;
    regs.msp = RAM_BASE + 0x4000 + 8 * (word(random) % 0x400);
    regs.r[13] = regs.msp;
    regs.xpsr = 0x0100_0000 | word(random) & 0xf80f_0000;
    regs.primask = word(random) & 1 == 0;
    regs.control = control::FPCA;
    if within_it {
        let it = word(random) as u8 | 1 << (word(random) % 4);
        regs.xpsr |= u32::from(it) >> 2 << 10 | (u32::from(it) & 3) << 25;
    }
    regs
}

fn floats(random: &mut Random) -> ([u32; 32], u32) {
    let status = word(random) & fpscr::WRITABLE;
    let quiet = fpscr::IXC | status & fpscr::FLAGS;
    (std::array::from_fn(|_| float(random)), if word(random).is_multiple_of(4) { status } else { quiet })
}

#[test]
fn narrow_instructions_do_what_they_do_on_rsemu() {
    let mut random = Random(1);
    let mut pair = Pair::new(&mut random);
    let (mut quick, mut all) = (0, 0);
    for round in 0..3 {
        for half in 0..0xe800_u16 {
            let regs = registers(&mut random, round == 1);
            quick += u32::from(pair.agree([half, 0xbf00], regs, [0; 32], 0));
            all += 1;
        }
    }
    println!("{quick} of {all} by the quick core");
    assert!(quick > all / 2, "{quick} of {all}");
    assert!(pair.memories(0) == pair.memories(1));
}

#[test]
fn wide_instructions_do_what_they_do_on_rsemu() {
    let mut random = Random(2);
    let mut pair = Pair::new(&mut random);
    let (mut quick, mut all) = (0, 0);
    for k in 0..300_000 {
        let bits = word(&mut random);
        let first = 0xe800 | (bits >> 16) as u16 & 0x1fff;
        if !is_32bit(first) {
            continue;
        }
        let regs = registers(&mut random, k % 4 == 0);
        let (s, status) = floats(&mut random);
        quick += u32::from(pair.agree([first, bits as u16], regs, s, status));
        all += 1;
    }
    println!("{quick} of {all} by the quick core");
    assert!(quick > all / 8, "{quick} of {all}");
    assert!(pair.memories(0) == pair.memories(1));
}

#[test]
fn floats_do_what_they_do_on_rsemu() {
    let mut random = Random(3);
    let mut pair = Pair::new(&mut random);
    let (mut quick, mut all) = (0, 0);
    for _ in 0..400_000 {
        // two in three: arithmetic of s0 to s31; else loads, stores and moves
        let bits = word(&mut random);
        let (top, rest) =
            if bits & 3 != 0 { (0xee00, 0x0a00) } else { (0xec00 | bits >> 2 & 0x0100, 0x0a00) };
        let first = (top | word(&mut random) & if top == 0xee00 { 0xff } else { 0x1ff }) as u16;
        let second = (rest | word(&mut random) & 0xf0ff) as u16;
        let regs = registers(&mut random, false);
        let (s, status) = floats(&mut random);
        quick += u32::from(pair.agree([first, second], regs, s, status));
        all += 1;
    }
    println!("{quick} of {all} by the quick core");
    assert!(quick > all / 4, "{quick} of {all}");
    assert!(pair.memories(0) == pair.memories(1));
}

#[test]
fn only_these_leave_the_floats_alone() {
    assert!(without_floats(Some(Insn::Hint { op: HintOp::Wfe })));
    assert!(!without_floats(Some(Insn::Bx { rm: 14 })) && !without_floats(None));
}
