//! Stores of the firmware against the vendor's description of the registers, which neither the firmware nor the emulator was
//! written from.

use emulator::Machine;
use emulator::svd::{self, Field, Register};
use std::sync::LazyLock;

/// Registers whose reserved bits embassy-stm32 0.6 sets, without an effect: its clock clears flags of TIM4 that are cleared by 0
/// with ones in all other bits, as the vendor's own library does; its serial line writes the flags that it has read into the
/// register that clears them.
const HARMLESS: [(&str, &str); 2] = [("TIM4", "SR"), ("LPUART1", "ICR")];

/// Registers of the DMA, which the description gives as arrays: offset in a channel and its fields [rm0440, "DMA register map",
/// "DMAMUX register map"].
const CHANNEL: [(u32, u32); 4] = [(0x00, 0x7fff), (0x04, 0xffff), (0x08, u32::MAX), (0x0c, u32::MAX)];
const MULTIPLEXER: u32 = 0x1f1f_037f;

fn of_the_dma() -> Vec<Register> {
    let register = |name: String, address, mask| Register {
        peripheral: "DMA".into(),
        name,
        address,
        reset: 0,
        fields: vec![Field { name: "ALL".into(), mask }],
    };
    let mut registers = Vec::new();
    for k in 0..8 {
        registers.extend(CHANNEL.map(|(offset, mask)| {
            register(format!("channel {}, {offset:#x}", k + 1), 0x4002_0008 + 0x14 * k + offset, mask)
        }));
        registers.push(register(format!("multiplexer {k}"), 0x4002_0800 + 4 * k, MULTIPLEXER));
    }
    registers
}

/// Registers of the chip. Of those that are listed every bit may be set.
fn registers() -> &'static [Register] {
    static REGISTERS: LazyLock<Vec<Register>> = LazyLock::new(|| {
        let mut registers = svd::registers().unwrap_or_else(|why| panic!("{why}"));
        for register in &mut registers {
            if HARMLESS.contains(&(register.peripheral.as_str(), register.name.as_str())) {
                register.fields.push(Field { name: "RESERVED".into(), mask: u32::MAX });
            }
        }
        registers.extend(of_the_dma());
        registers
    });
    &REGISTERS
}

/// From now on a store to reserved bits, or to no register at all, is a violation.
pub fn watch(machine: &mut Machine) {
    machine.watch_reserved_bits(registers());
}

/// Fails after a store to reserved bits or to no register.
pub fn check(machine: &Machine) {
    let mut stores = machine.violations();
    stores.retain(|why| why.contains("reserved bits") || why.contains("no register"));
    assert!(stores.is_empty(), "{stores:#?}");
}
