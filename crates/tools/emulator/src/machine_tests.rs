//! The emulated core and its workarounds.

use super::run::IT_STATE;
use super::*;
use std::collections::BTreeMap;

const CODE: u32 = 0x100;
/// ```text
/// 100  ldr  r0, =0xe000e100     NVIC_ISER0
/// 102  ldr  r1, =1 << 18
/// 104  str  r1, [r0]
/// 106  movs r0, #0
/// 108  movs r1, #1
/// 10a  cmp  r1, #0
/// 10c  it   eq
/// 10e  moveq r0, #1             never
/// 110  b    10a
/// 112  bx   lr                  the handler
/// ```
const PROGRAM: [u16; 16] = [
    0x4805, 0x4906, 0x6001, 0x2000, 0x2101, 0x2900, 0xbf08, 0x2001, 0xe7fb, 0x4770, 0xbf00, 0xbf00, 0xe100,
    0xe000, 0x0000, 0x0004,
];

fn image() -> Image {
    let mut flash = vec![0; 0x100];
    let mut vector = |index: usize, value: u32| {
        flash[4 * index..4 * index + 4].copy_from_slice(&value.to_le_bytes());
    };
    vector(0, RAM_BASE + 0x1000);
    vector(1, FLASH_BASE + CODE + 1);
    vector(16 + usize::from(IRQ_ADC1_2), FLASH_BASE + CODE + 0x13);
    flash.extend(PROGRAM.iter().flat_map(|half| half.to_le_bytes()));
    Image {
        flash_bytes: flash.len(),
        ram_bytes: 0,
        flash: vec![(FLASH_BASE, flash)],
        ccm: Vec::new(),
        symbols: BTreeMap::new(),
        functions: Vec::new(),
        code: Vec::new(),
    }
}

#[test]
fn a_store_to_reserved_bits_is_seen() {
    let mut image = image();
    // ldr r0, =PWR_CR5 · mov r1, #0x101 · str r1, [r0] · b to itself
    let program = [0x4802_u16, 0xf240, 0x1101, 0x6001, 0xe7fe, 0xbf00, 0x7080, 0x4000];
    let code: Vec<u8> = program.iter().flat_map(|half| half.to_le_bytes()).collect();
    let at = CODE as usize;
    image.flash[0].1[at..at + code.len()].copy_from_slice(&code);
    let mut machine = Machine::free_handle(&image, 1);
    machine.watch_reserved_bits(&crate::svd::registers().expect("the sources"));
    machine.shared.soc().write(0x4002_1058, 1 << 28, 0); // PWREN
    machine.run_for(0.01);
    let why = "reserved bits 0x1 of PWR CR5 (0x40007080) changed by 0x101 at pc 0x8000106";
    assert_eq!(machine.violations().into_iter().collect::<Vec<_>>(), [why]);
}

#[test]
fn an_interrupt_within_an_it_block_keeps_its_conditions() {
    let mut machine = Machine::free_handle(&image(), 1);
    let (mut interrupted, mut served) = (0, false);
    for _ in 0..4_000 {
        let handler = machine.cpu.current_exception().0 != 0;
        let within = machine.cpu.xpsr() & IT_STATE != 0;
        // once per loop, so that the block continues afterwards
        machine.cpu.set_irq(IRQ_ADC1_2, within && !handler && !served);
        let mut regs = machine.cpu.regs();
        machine.step(&mut regs);
        let entered = !handler && machine.cpu.current_exception().0 != 0;
        interrupted += u32::from(entered);
        served = entered || served && (handler || within);
    }
    println!("interrupted {interrupted} times between `it eq` and `moveq`");
    assert!(interrupted > 300 && !machine.locked_up(), "{interrupted}, {}", machine.whereabouts());
    assert_eq!(machine.cpu.reg(0), 0, "`moveq` was executed");
}
