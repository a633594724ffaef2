//! Formatting of numbers, without the 9 kB of flash of `core`.

use super::decimal::Decimal;
use core::fmt::{self, Write};

/// An `f32` formatted like `core` does: `{}` gives the shortest text that parses to the same number, `{:.3}` the exact value
/// rounded to three places. Never an exponent; width and fill are ignored.
///
/// ```
/// use haptics::number::Text;
/// assert_eq!(format!("{} m, {:.2} N", Text(0.007), Text(-1.255)), "0.007 m, -1.25 N");
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Text(pub f32);

impl fmt::Display for Text {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let x = self.0;
        if x.is_nan() {
            return f.write_str("NaN");
        }
        if x.is_sign_negative() {
            f.write_char('-')?;
        }
        if x.is_infinite() {
            return f.write_str("inf");
        }
        let (decimal, places) = match f.precision() {
            Some(places) => {
                let mut decimal = Decimal::of(x);
                // a precision is a `u16`
                decimal.round(decimal.point() + places as i32);
                (decimal, places as i32)
            }
            None => {
                let decimal = shortest(x);
                let places = decimal.len() - decimal.point();
                (decimal, places)
            }
        };
        write(&decimal, places, f)
    }
}

fn write(decimal: &Decimal, places: i32, f: &mut fmt::Formatter<'_>) -> fmt::Result {
    let point = decimal.point();
    // at least one digit before the point
    for place in point.min(1) - 1..point + places.max(0) {
        if place == point {
            f.write_char('.')?;
        }
        f.write_char(char::from(b'0' + decimal.digit(place)))?;
    }
    Ok(())
}

/// The fewest digits that parse to the same number, and the nearest of those.
fn shortest(x: f32) -> Decimal {
    let exact = Decimal::of(x);
    let bits = x.to_bits() & 0x7fff_ffff;
    // below a power of two the numbers are closer: the nearest decimal may parse to another number, while the next
    // larger one still parses to this one
    let uneven = bits.trailing_zeros() >= 23;
    for digits in 1..9 {
        // ties go up, as in `core`
        let nearer_up = exact.digit(digits) >= 5;
        for up in [nearer_up, true] {
            let mut text = exact.clone();
            text.cut(digits, up);
            if text.clone().nearest() == bits {
                return text;
            }
            if !uneven {
                break;
            }
        }
    }
    let mut text = exact;
    text.round(9);
    text
}

#[cfg(test)]
mod tests {
    use super::{super::parse, Text};
    use std::{format, println, string::String};

    /// SplitMix64 [steele-2014].
    fn random(state: &mut u64) -> u64 {
        *state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (*state ^ (*state >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    fn agrees(x: f32) {
        assert_eq!(format!("{}", Text(x)), format!("{x}"), "{:#x}", x.to_bits());
    }

    #[test]
    fn shows_what_the_standard_library_shows() {
        for exponent in 0..=255_u32 {
            // every power of two with its neighbours, where spacing changes
            for near in [-2_i32, -1, 0, 1, 2] {
                agrees(f32::from_bits((exponent << 23).wrapping_add_signed(near)));
            }
        }
        for x in [0.0, -0.0, 0.1, 16_777_216.0, f32::MAX, f32::MIN_POSITIVE, f32::INFINITY, -f32::INFINITY] {
            agrees(x);
        }
        assert_eq!(
            (format!("{}", Text(f32::NAN)), format!("{:.2}", Text(f32::NAN))),
            ("NaN".into(), "NaN".into())
        );
        let (mut state, count) = (1, if cfg!(debug_assertions) { 100_000 } else { 3_000_000 });
        let mut text = String::new();
        for _ in 0..count {
            let bits = random(&mut state);
            let x = f32::from_bits(bits as u32);
            agrees(x);
            // of the size shown in practice, with few digits and with all
            let near = (random(&mut state) as i32) as f32 * 10_f32.powi((bits >> 32) as i32 % 12 - 14);
            let places = (bits >> 40) as usize % 9;
            agrees(near);
            for x in [x, near] {
                text = format!("{x:.places$}");
                assert_eq!(format!("{:.places$}", Text(x)), text, "{:#x}", x.to_bits());
            }
            let short: f32 = text.parse().unwrap();
            agrees(short);
            assert_eq!(parse(&text).map(f32::to_bits), Some(short.to_bits()), "{text}");
        }
        println!("{count} times 3 numbers shown as the standard library shows them; the last one is {text}");
    }

    #[test]
    fn ties_round_like_the_standard_library() {
        for numerator in -4_000..4_000_i16 {
            let x = f32::from(numerator) / 64.0;
            for places in 0..8 {
                assert_eq!(format!("{:.places$}", Text(x)), format!("{x:.places$}"));
            }
        }
    }
}
