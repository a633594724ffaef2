//! A custom `f32` parser and formatter.
//!
//! Those of `core` take 20 kB of flash. These share one row of digits and give the same numbers and texts.

mod decimal;
mod text;

pub use text::Text;

use decimal::Decimal;

/// Parses a finite number such as `-0.35`, `2e-3`, `7.` or `.5`. `None` for anything else, and beyond the range of `f32`.
#[must_use]
pub fn parse(text: &str) -> Option<f32> {
    let (negative, text) = match text.as_bytes() {
        [b'-', rest @ ..] => (true, rest),
        [b'+', rest @ ..] => (false, rest),
        rest => (false, rest),
    };
    let (integer, rest) = digits(text);
    let (fraction, rest) = match rest {
        [b'.', rest @ ..] => digits(rest),
        rest => (&[][..], rest),
    };
    if integer.is_empty() && fraction.is_empty() {
        return None;
    }
    let exponent = match rest {
        [] => 0,
        [b'e' | b'E', rest @ ..] => exponent(rest)?,
        _ => return None,
    };
    let behind = exponent.saturating_sub(fraction.len() as i32);
    let magnitude = f32::from_bits(Decimal::new(integer.iter().chain(fraction), behind).nearest());
    magnitude.is_finite().then_some(if negative { -magnitude } else { magnitude })
}

/// Number of four digits next to `x` ≥ 0, below or above it. `x` if it has at most four digits.
pub(crate) fn four_digits(x: f32, above: bool) -> f32 {
    let mut decimal = Decimal::of(x);
    let up = above && decimal.len() > 4;
    decimal.cut(4, up);
    f32::from_bits(decimal.nearest())
}

/// Leading digits of a text, and the rest.
fn digits(text: &[u8]) -> (&[u8], &[u8]) {
    let count = text.iter().take_while(|byte| byte.is_ascii_digit()).count();
    text.split_at(count)
}

fn exponent(text: &[u8]) -> Option<i32> {
    let (negative, text) = match text {
        [b'-', rest @ ..] => (true, rest),
        [b'+', rest @ ..] => (false, rest),
        rest => (false, rest),
    };
    let (digits, []) = digits(text) else { return None };
    if digits.is_empty() {
        return None;
    }
    // saturates far beyond the range
    let value = digits.iter().fold(0_i32, |value, digit| (value * 10 + i32::from(digit - b'0')).min(9_999));
    Some(if negative { -value } else { value })
}

#[cfg(test)]
mod tests {
    use super::parse;
    use proptest::prelude::*;
    use std::{format, string::String};

    #[test]
    fn what_is_no_number_is_none() {
        for text in [
            "", "-", "+", ".", "e5", "1e", "1e+", "1.2.3", "0x10", "1,5", "NaN", "inf", "-inf", "1e39", "1 ",
            "٣",
        ] {
            assert_eq!(parse(text), None, "{text:?}");
        }
    }

    #[test]
    fn every_way_to_write_it() {
        for (text, value) in [
            ("7", 7.0),
            ("7.", 7.0),
            (".5", 0.5),
            ("-0.35", -0.35),
            ("+2E-3", 0.002),
            ("000", 0.0),
            ("0.00e9", 0.0),
            ("1e-99", 0.0),
            ("00012.500", 12.5),
        ] {
            assert_eq!(parse(text), Some(value), "{text:?}");
        }
        assert_eq!(parse(&format!("0.{}1", "0".repeat(120))), Some(0.0));
        let long = "0.40350000560283660888671875";
        assert_eq!(parse(long), long.parse().ok());
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(20_000))]

        #[test]
        fn agrees_with_the_standard_library(bits in any::<u32>(), digits in 0..12_usize) {
            let x = f32::from_bits(bits);
            prop_assume!(x.is_finite());
            for text in [format!("{x}"), format!("{x:e}"), format!("{x:.digits$}"), format!("{x:.digits$e}")] {
                let theirs = text.parse::<f32>().ok().filter(|x| x.is_finite());
                prop_assert_eq!(parse(&text).map(f32::to_bits), theirs.map(f32::to_bits), "{}", text);
            }
        }

        #[test]
        fn no_text_panics(text in "[-+.eE0-9x ]{0,40}") {
            let theirs = text.parse::<f32>().ok().filter(|x| x.is_finite());
            prop_assert_eq!(parse(&text), theirs, "{}", String::from(&text));
        }
    }
}
