//! A run as another emulator can repeat it: what the core read and wrote outside its memories, and after how many instructions
//! exceptions began and ended. An instruction of an IT block counts if its condition holds.
//!
//! ```text
//! record   4 words, little endian: kind, a, b, c
//! read     0, address, value, bytes
//! write    1, address, value, bytes
//! enter    2, exception and place, instructions since the last exception began or ended, where it returns to with bit 0 for floats
//!              place in bits 16 and 17: 1 within an IT block before an instruction whose condition holds, 2 before another
//! return   3, 0, instructions, 0
//! chain    4, exception, instructions, 0     a return straight into the next one
//! end      5, 0, instructions, 0
//! sleep    6, address, 0, 0      an instruction that waits for an event; before all others
//! ```

use rsemu::cpu::arm::v7m::Regs;
use std::collections::BTreeSet;
use std::sync::Mutex;
use std::sync::PoisonError;

const READ: u32 = 0;
const WRITE: u32 = 1;
const ENTER: u32 = 2;
const RETURN: u32 = 3;
const CHAIN: u32 = 4;
const END: u32 = 5;
const SLEEP: u32 = 6;
fn it_state(xpsr: u32) -> u32 {
    xpsr >> 8 & 0xfc | xpsr >> 25 & 3
}

/// Whether the next instruction is carried out: always, but for the conditions of an IT block [armv7-m, ch. A7.3].
fn condition_holds(xpsr: u32) -> bool {
    let it = it_state(xpsr);
    if it & 0xf == 0 {
        return true;
    }
    let [n, z, c, v] = [31, 30, 29, 28].map(|bit| xpsr >> bit & 1 != 0);
    let holds = match it >> 5 {
        0 => z,
        1 => c,
        2 => n,
        3 => v,
        4 => c && !z,
        5 => n == v,
        6 => n == v && !z,
        _ => return true,
    };
    holds == (it >> 4 & 1 == 0)
}

/// Number of the exception in xPSR.
const EXCEPTION: u32 = 0x1ff;

#[derive(Debug, Default)]
pub(crate) struct Recording(Mutex<Events>);

#[derive(Debug, Default)]
struct Events {
    records: Vec<[u32; 4]>,
    /// Addresses of instructions after which the core slept.
    sleeps: BTreeSet<u32>,
    /// Exceptions that have begun and not ended.
    active: Vec<u32>,
    /// Instructions since the last exception began or ended.
    instructions: u32,
}

impl Recording {
    fn events(&self) -> std::sync::MutexGuard<'_, Events> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    pub fn read(&self, address: u32, data: &[u8]) {
        self.events().access(READ, address, data);
    }

    pub fn write(&self, address: u32, data: &[u8]) {
        self.events().access(WRITE, address, data);
    }

    /// One step of the core; whether it slept before and after it. `vector` gives the address of a handler.
    pub fn step(&self, before: &Regs, after: &Regs, slept: [bool; 2], vector: impl Fn(u32) -> u32) {
        let mut events = self.events();
        let (was, is) = (before.xpsr & EXCEPTION, after.xpsr & EXCEPTION);
        if was != is && after.msp < before.msp {
            events.active.push(is);
            // EXC_RETURN has bit 4 clear for a frame with floats [armv7-m, table B1-9]
            let place = match it_state(before.xpsr) & 0xf {
                0 => 0,
                _ if condition_holds(before.xpsr) => 1,
                _ => 2,
            };
            return events.turn(ENTER, is | place << 16, before.r[15] | u32::from(after.r[14] & 0x10 == 0));
        }
        // of a core that sleeps on, or that has loaded its first stack pointer
        if slept[0] && before.r[15] == after.r[15] || before.msp == 0 {
            return;
        }
        if slept[1] {
            events.sleeps.insert(before.r[15]);
        }
        events.instructions += u32::from(condition_holds(before.xpsr));
        if was == is && (is == 0 || before.r[15] == after.r[15] || after.r[15] != vector(is) & !1) {
            return;
        }
        events.active.pop();
        if was != is && is == events.active.last().copied().unwrap_or(0) {
            events.turn(RETURN, 0, 0);
        } else {
            events.active.push(is);
            events.turn(CHAIN, is, 0);
        }
    }

    /// The records so far, and the end.
    pub fn bytes(&self) -> Vec<u8> {
        let mut events = self.events();
        events.turn(END, 0, 0);
        let sleeps = events.sleeps.iter().map(|address| [SLEEP, *address, 0, 0]);
        sleeps.chain(events.records.iter().copied()).flatten().flat_map(|word| word.to_le_bytes()).collect()
    }
}

impl Events {
    fn access(&mut self, kind: u32, address: u32, data: &[u8]) {
        let value = data.iter().rev().fold(0, |value, byte| value << 8 | u32::from(*byte));
        self.records.push([kind, address, value, data.len() as u32]);
    }

    fn turn(&mut self, kind: u32, exception: u32, returns_to: u32) {
        self.records.push([kind, exception, self.instructions, returns_to]);
        self.instructions = 0;
    }
}
