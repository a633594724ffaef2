//! Exact decimal numbers of many digits, for small code rather than speed.
//!
//! `f32` needs at most 112 digits: 0.5·2⁻¹⁴⁹ times an odd number of 25 bits. Numbers up to [`MOST`] digits are exact; beyond,
//! digits are dropped and a flag records that. The only operations are doubling and halving a row of digits, as in
//! [steele-1990] and in the “simple decimal conversion” of Go and `core`.

use heapless::Vec;

/// Number of digits kept.
const MOST: usize = 128;
/// Binary places per pass. The carry between digits stays below 2³².
const AT_ONCE: u32 = 24;
/// Bits of a significand, and the exponent of its last bit in the smallest numbers.
const BITS: u32 = 24;
const LOWEST: i32 = -149;

/// The number 0.d₁d₂d₃… × 10^point without zeros at either end. No digits stand for 0.
#[derive(Debug, Clone, Default)]
pub(super) struct Decimal {
    digits: Vec<u8, MOST>,
    point: i32,
    /// Whether non-zero digits were dropped after the last.
    more: bool,
}

impl Decimal {
    /// The number with these digits, the first one first, times 10^`exponent`.
    pub fn new<'a>(digits: impl Iterator<Item = &'a u8>, exponent: i32) -> Self {
        let mut new = Self { point: exponent, ..Self::default() };
        for digit in digits.map(|ascii| ascii.wrapping_sub(b'0')) {
            new.point += 1;
            new.push(digit);
        }
        new.trim();
        new
    }

    /// The exact value of a finite number, without its sign.
    pub fn of(x: f32) -> Self {
        let bits = x.to_bits() & 0x7fff_ffff;
        let raised = (bits >> (BITS - 1)).max(1);
        let mut exponent = raised as i32 - 1 + LOWEST;
        let mut new = Self::default();
        new.carry(bits - ((raised - 1) << (BITS - 1)));
        new.trim();
        while exponent != 0 {
            let places = exponent.unsigned_abs().min(AT_ONCE);
            if exponent > 0 {
                new.double(places);
                exponent -= places as i32;
            } else {
                new.halve(places);
                exponent += places as i32;
            }
        }
        new
    }

    /// Appends a digit. The point stays.
    fn push(&mut self, digit: u8) {
        if self.digits.is_empty() && digit == 0 {
            self.point -= 1;
        } else if self.digits.push(digit).is_err() {
            self.more |= digit != 0;
        }
    }

    /// Prepends the digits of `number`.
    fn carry(&mut self, mut number: u32) {
        while number > 0 {
            if self.digits.is_full() {
                self.more |= self.digits.pop() != Some(0);
            }
            let _ = self.digits.insert(0, (number % 10) as u8);
            number /= 10;
            self.point += 1;
        }
    }

    fn trim(&mut self) {
        while self.digits.last() == Some(&0) {
            self.digits.pop();
        }
    }

    /// Multiplies by 2^places, at most [`AT_ONCE`].
    fn double(&mut self, places: u32) {
        let mut carried = 0;
        for digit in self.digits.iter_mut().rev() {
            carried += u32::from(*digit) << places;
            *digit = (carried % 10) as u8;
            carried /= 10;
        }
        self.carry(carried);
        self.trim();
    }

    /// Divides by 2^places, at most [`AT_ONCE`].
    fn halve(&mut self, places: u32) {
        let old = core::mem::take(&mut self.digits);
        let mut digits = old.iter();
        let mut rest = 0;
        loop {
            let digit = digits.next();
            if digit.is_none() && (rest == 0 || self.digits.is_full()) {
                break;
            }
            rest = rest * 10 + u32::from(digit.copied().unwrap_or(0));
            self.push((rest >> places) as u8);
            rest &= (1 << places) - 1;
        }
        self.more |= rest != 0;
        self.trim();
    }

    /// Number of digits before the point: 3 for 120.5, 0 for 0.05.
    pub fn point(&self) -> i32 {
        if self.digits.is_empty() { 0 } else { self.point }
    }

    /// Digit at a place counted from the first. 0 beyond the last.
    pub fn digit(&self, place: i32) -> u8 {
        usize::try_from(place).ok().and_then(|place| self.digits.get(place)).copied().unwrap_or(0)
    }

    /// Number of digits.
    pub fn len(&self) -> i32 {
        self.digits.len() as i32
    }

    /// Rounds to the nearest number with `digits` digits, ties to even.
    pub fn round(&mut self, keep: i32) {
        if keep >= self.len() {
            return;
        }
        let (next, behind) = (self.digit(keep), self.len() > keep + 1 || self.more);
        let odd = self.digit(keep - 1) % 2 == 1;
        let up = keep >= 0 && (next > 5 || next == 5 && (behind || odd));
        self.cut(keep, up);
    }

    /// Truncates to `digits` digits, then rounds up if `up`.
    pub fn cut(&mut self, keep: i32, up: bool) {
        self.digits.truncate(usize::try_from(keep).unwrap_or(0));
        self.more = false;
        if up {
            loop {
                match self.digits.last_mut() {
                    Some(9) => drop(self.digits.pop()),
                    Some(last) => break *last += 1,
                    None => break self.carry(1),
                }
            }
        }
        self.trim();
    }

    /// Digits before the point as a number, at most 9 digits.
    fn whole(&self) -> u32 {
        (0..self.point()).fold(0, |whole, place| whole * 10 + u32::from(self.digit(place)))
    }

    /// Bits of the nearest `f32`, ties to even. Infinity beyond the largest.
    pub fn nearest(mut self) -> u32 {
        const INFINITY: u32 = 0x7f80_0000;
        if self.digits.is_empty() || self.point < -60 {
            return 0;
        }
        if self.point > 60 {
            return INFINITY;
        }
        // the number is `self` × 2^exponent
        let mut exponent = 0;
        while self.point > 8 || self.whole() >= 1 << BITS {
            // a decimal place is more than three binary ones
            let places = (3 * (self.point - 8)).clamp(1, AT_ONCE as i32);
            self.halve(places as u32);
            exponent += places;
        }
        while exponent > LOWEST && (self.point < 7 || self.whole() < 1 << (BITS - 1)) {
            let places = (3 * (7 - self.point)).clamp(1, AT_ONCE as i32).min(exponent - LOWEST);
            self.double(places as u32);
            exponent -= places;
        }
        self.round(self.point);
        // the leading bit of the significand adds one to the exponent, and so does rounding up to 2²⁴
        let bits = (((exponent - LOWEST) as u32) << (BITS - 1)).saturating_add(self.whole());
        bits.min(INFINITY)
    }
}
