//! Code reachable from a place in the image, by following every branch of the machine code.
//!
//! Only branches are decoded [armv7-m, ch. A5 and A7.7]; of other instructions only the length. A call through a register ends
//! the trail and is listed: a claim of unreachability holds only without such calls.

use crate::Image;
use crate::image::CCM_BASE;
use std::collections::BTreeSet;
use std::fmt;

/// Reachable code.
#[derive(Debug, Clone, Default)]
pub struct Reach {
    /// Names of the functions.
    pub functions: BTreeSet<String>,
    /// Names of those that run from flash, with its wait states.
    pub in_flash: BTreeSet<String>,
    /// Number of instructions.
    pub instructions: usize,
    /// Jumps through a register, with address and function. Not followed.
    pub indirect: Vec<(u32, String)>,
    /// `udf` instructions: unreachable code for the compiler, and aborts.
    pub traps: Vec<(u32, String)>,
}

/// The code cannot be followed.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Lost {
    /// No such symbol.
    NoSymbol(String),
    /// A branch leaves the image.
    OutsideFlash(u32),
}

impl fmt::Display for Lost {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoSymbol(name) => write!(f, "the image has no symbol `{name}`: was it stripped?"),
            Self::OutsideFlash(address) => write!(f, "code at {address:#010x} is not in the image"),
        }
    }
}

impl std::error::Error for Lost {}

/// Control flow after an instruction.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Flow {
    Next,
    /// To an address and, if marked, also to the next instruction: a condition, or a call that returns.
    To(u32, bool),
    /// Table of half offsets after the instruction, with entries of one or two bytes.
    Table(usize),
    /// Through a register. True for a call that returns.
    Register(bool),
    Return,
    Trap,
}

/// Length of an instruction, bytes, and its control flow. `at` is its address.
fn decode(at: u32, first: u16, second: u16) -> (u32, Flow) {
    let (a, b) = (u32::from(first), u32::from(second));
    if a >> 11 < 0b11101 {
        let pc = at.wrapping_add(4);
        let flow = match a {
            _ if a >> 12 == 0b1101 && a >> 8 & 15 == 14 => Flow::Trap,
            _ if a >> 12 == 0b1101 && a >> 8 & 15 < 14 => Flow::To(offset(pc, (a & 0xff) << 1, 9), true),
            _ if a >> 11 == 0b11100 => Flow::To(offset(pc, (a & 0x7ff) << 1, 12), false),
            _ if a & 0xf500 == 0xb100 => Flow::To(pc + ((a >> 3 & 31) << 1 | (a >> 9 & 1) << 6), true),
            _ if a & 0xff87 == 0x4780 => Flow::Register(true),
            _ if a & 0xff87 == 0x4700 && a >> 3 & 15 == 14 => Flow::Return,
            _ if a & 0xff87 == 0x4700 => Flow::Register(false),
            // mov pc, rm and add pc, rm
            _ if a & 0xff87 == 0x4687 || a & 0xff87 == 0x4487 => Flow::Register(false),
            _ if a & 0xff00 == 0xbd00 => Flow::Return,
            _ => Flow::Next,
        };
        return (2, flow);
    }
    let pc = at.wrapping_add(4);
    let flow = if a >> 11 == 0b11110 && b >> 15 == 1 {
        let (s, j1, j2) = (a >> 10 & 1, b >> 13 & 1, b >> 11 & 1);
        let long = |i1: u32, i2: u32| {
            offset(pc, s << 24 | i1 << 23 | i2 << 22 | (a & 0x3ff) << 12 | (b & 0x7ff) << 1, 25)
        };
        let (i1, i2) = (1 ^ j1 ^ s, 1 ^ j2 ^ s);
        match b >> 12 & 5 {
            5 => Flow::To(long(i1, i2), true), // bl
            1 => Flow::To(long(i1, i2), false),
            0 if a >> 6 & 15 < 14 => {
                let near = s << 20 | j2 << 19 | j1 << 18 | (a & 0x3f) << 12 | (b & 0x7ff) << 1;
                Flow::To(offset(pc, near, 21), true)
            }
            0 if a & 0xfff0 == 0xf7f0 && b & 0xf000 == 0xa000 => Flow::Trap,
            _ => Flow::Next,
        }
    } else if a & 0xfff0 == 0xe8d0 && b & 0xffe0 == 0xf000 {
        Flow::Table(1 + (b >> 4 & 1) as usize)
    } else if a & 0xffd0 == 0xe890 && b >> 15 == 1 || a == 0xf85d && b == 0xfb04 {
        Flow::Return // pop.w {…, pc}, ldm with pc
    } else if a & 0xff70 == 0xf850 && b >> 12 == 15 {
        Flow::Register(false) // ldr pc
    } else {
        Flow::Next
    };
    (4, flow)
}

/// Half (true: the upper one), register and value of a `movw` or `movt`.
fn moved(first: u16, second: u16) -> Option<(bool, u32, u32)> {
    let (a, b) = (u32::from(first), u32::from(second));
    let top = match a & 0xfbf0 {
        0xf240 => false,
        0xf2c0 => true,
        _ => return None,
    };
    let value = (a & 15) << 12 | (a >> 10 & 1) << 11 | (b >> 12 & 7) << 8 | b & 0xff;
    (b >> 15 == 0).then_some((top, b >> 8 & 15, value))
}

/// `pc` plus a signed number of `bits` bits.
fn offset(pc: u32, value: u32, bits: u32) -> u32 {
    let shift = 32 - bits;
    pc.wrapping_add((((value << shift) as i32) >> shift) as u32)
}

impl Image {
    /// Follows every branch from the entry of a function.
    ///
    /// # Errors
    /// Unknown function, or a branch that leaves the image.
    pub fn reach(&self, function: &str) -> Result<Reach, Lost> {
        let entry = self.symbol(function).ok_or_else(|| Lost::NoSymbol(function.to_string()))? & !1;
        let mut reach = Reach::default();
        let (mut seen, mut open) = (BTreeSet::new(), vec![entry]);
        while let Some(mut at) = open.pop() {
            while seen.insert(at) {
                let (length, flow) = decode(at, self.half(at)?, self.half(at + 2).unwrap_or(0));
                let name = self.function_at(at);
                reach.functions.insert(name.clone());
                if at < CCM_BASE {
                    reach.in_flash.insert(name.clone());
                }
                match flow {
                    Flow::Next => {}
                    Flow::To(target, true) => open.push(target),
                    Flow::To(target, false) => {
                        open.push(target);
                        break;
                    }
                    Flow::Table(size) => {
                        open.extend(self.table(at + length, size)?);
                        break;
                    }
                    Flow::Register(returns) => {
                        match if returns { self.loaded(at) } else { self.thunk(at) } {
                            Some(function) => open.push(function),
                            None => reach.indirect.push((at, name)),
                        }
                        if !returns {
                            break;
                        }
                    }
                    Flow::Return => break,
                    Flow::Trap => {
                        reach.traps.push((at, name));
                        break;
                    }
                }
                at += length;
            }
        }
        reach.instructions = seen.len();
        Ok(reach)
    }

    /// Target of a `blx rm` at `at` whose register holds a constant, as the compiler emits for repeated calls when it optimises
    /// for size. The constant is the last one loaded into that register, and must be the address of a function.
    fn loaded(&self, at: u32) -> Option<u32> {
        let register = u32::from(self.half(at).ok()?) >> 3 & 15;
        let before = self.functions.partition_point(|(address, _)| *address <= at);
        let mut place = self.functions.get(before.checked_sub(1)?)?.0;
        let mut literal = None;
        while place < at {
            let (first, second) = (self.half(place).ok()?, self.half(place + 2).ok()?);
            let (a, b) = (u32::from(first), u32::from(second));
            let pc = place.wrapping_add(4) & !3;
            if a >> 11 == 0b01001 && a >> 8 & 7 == register {
                literal = Some(pc + ((a & 0xff) << 2));
            } else if a == 0xf8df && b >> 12 == register {
                literal = Some(pc + (b & 0xfff));
            }
            place += decode(place, first, second).0;
        }
        let word = |at: u32| Some(u32::from(self.half(at).ok()?) | u32::from(self.half(at + 2).ok()?) << 16);
        self.entry(word(literal?)?)
    }

    /// Target of the `bx ip` at `at` that ends what the linker puts where a function is too far for a branch: `movw ip`, `movt ip`.
    fn thunk(&self, at: u32) -> Option<u32> {
        const IP: u32 = 12;
        let half = |back: u32| at.checked_sub(back).and_then(|place| self.half(place).ok());
        let (low, high) = (moved(half(8)?, half(6)?)?, moved(half(4)?, half(2)?)?);
        let jump = u32::from(half(0)?);
        let is_one = (low.0, high.0) == (false, true) && [low.1, high.1, jump >> 3 & 15] == [IP; 3];
        self.entry(is_one.then_some(high.2 << 16 | low.2)?)
    }

    /// A function by its address, which is odd.
    fn entry(&self, address: u32) -> Option<u32> {
        let entry = address & !1;
        let known = self.functions.binary_search_by_key(&entry, |(address, _)| *address & !1).is_ok();
        (address & 1 == 1 && known).then_some(entry)
    }

    /// Targets of a `tbb` or `tbh` with its table at `at`. The table ends at the next code mark (`$t`), or at constants, which
    /// begin where an entry would leave the function.
    fn table(&self, at: u32, size: usize) -> Result<Vec<u32>, Lost> {
        let next = self.code.partition_point(|address| *address <= at);
        let end = *self.code.get(next).ok_or(Lost::OutsideFlash(at))?;
        let next = self.functions.partition_point(|(address, _)| *address <= at);
        let function_end = self.functions.get(next).map_or(u32::MAX, |(address, _)| *address);
        let mut targets = Vec::new();
        for entry in (at..end).step_by(size) {
            let half = self.half(entry & !1)?;
            let steps = match size {
                1 => u32::from(half.to_le_bytes()[(entry & 1) as usize]),
                _ => u32::from(half),
            };
            let target = at + 2 * steps;
            // a table of bytes is padded to a half-word with zero
            if target <= entry || target >= function_end {
                break;
            }
            targets.push(target);
        }
        Ok(targets)
    }

    fn half(&self, at: u32) -> Result<u16, Lost> {
        let bytes = |(base, data): &(u32, Vec<u8>)| {
            let from = at.checked_sub(*base)? as usize;
            data.get(from..from + 2)?.try_into().ok().map(u16::from_le_bytes)
        };
        self.flash.iter().chain(&self.ccm).find_map(bytes).ok_or(Lost::OutsideFlash(at))
    }

    fn function_at(&self, at: u32) -> String {
        let next = self.functions.partition_point(|(address, _)| *address <= at);
        let name = next.checked_sub(1).and_then(|i| self.functions.get(i)).map_or("?", |(_, name)| name);
        format!("{:#}", rustc_demangle::demangle(name))
    }
}

#[cfg(test)]
mod tests {
    use super::{Flow, decode, moved};

    #[test]
    fn moves_of_halves_as_an_assembler_writes_them() {
        // encodings by llvm-mc --triple=thumbv7em -show-encoding
        assert_eq!(moved(0xf643, 0x3cbd), Some((false, 12, 0x3bbd))); // movw r12, #15293
        assert_eq!(moved(0xf6c0, 0x0c00), Some((true, 12, 0x0800))); // movt r12, #2048
        assert_eq!(moved(0xf04f, 0x0c01), None); // mov.w r12, #1
    }

    #[test]
    fn branches_as_an_assembler_writes_them() {
        // encodings by llvm-mc --triple=thumbv7em -show-encoding
        for (halves, expected) in [
            ([0xe7fe, 0], (2, Flow::To(0x1000, false))),      // b .
            ([0xd0fe, 0], (2, Flow::To(0x1000, true))),       // beq .
            ([0xb108, 0], (2, Flow::To(0x1006, true))),       // cbz r0, .+6
            ([0xb9f8, 0], (2, Flow::To(0x1042, true))),       // cbnz r0, .+66
            ([0xf7ff, 0xfffe], (4, Flow::To(0x1000, true))),  // bl .
            ([0xf000, 0xf800], (4, Flow::To(0x1004, true))),  // bl .+4
            ([0xf7ff, 0xbffe], (4, Flow::To(0x1000, false))), // b.w .
            ([0xf43f, 0xaffe], (4, Flow::To(0x1000, true))),  // beq.w .
            ([0x4780, 0], (2, Flow::Register(true))),         // blx r0
            ([0x4718, 0], (2, Flow::Register(false))),        // bx r3
            ([0x4770, 0], (2, Flow::Return)),                 // bx lr
            ([0xbdb0, 0], (2, Flow::Return)),                 // pop {r4, r5, r7, pc}
            ([0xe8bd, 0x8ff0], (4, Flow::Return)),            // pop.w {r4-r11, pc}
            ([0xe8df, 0xf000], (4, Flow::Table(1))),          // tbb [pc, r0]
            ([0xe8df, 0xf010], (4, Flow::Table(2))),          // tbh [pc, r0, lsl #1]
            ([0xde00, 0], (2, Flow::Trap)),                   // udf #0
            ([0xf7f0, 0xa000], (4, Flow::Trap)),              // udf.w #0
            ([0xf85d, 0xfb04], (4, Flow::Return)),            // pop.w {pc}
            ([0xf3bf, 0x8f4f], (4, Flow::Next)),              // dsb sy
            ([0xdf00, 0], (2, Flow::Next)),                   // svc #0
            ([0xf8d0, 0xf004], (4, Flow::Register(false))),   // ldr.w pc, [r0, #4]
            ([0xf3ef, 0x8010], (4, Flow::Next)),              // mrs r0, primask
            ([0xee30, 0x0a00], (4, Flow::Next)),              // vadd.f32 s0, s0, s0
            ([0x4687, 0], (2, Flow::Register(false))),        // mov pc, r0
        ] {
            let [first, second] = halves;
            assert_eq!(decode(0x1000, first, second), expected, "{first:04x} {second:04x}");
        }
    }
}
