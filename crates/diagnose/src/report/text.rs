//! Text for a page: escaping, and numbers as a person writes them.

/// `text` safe inside HTML elements and quoted attributes.
pub(super) fn escape(text: &str) -> String {
    let mut out = String::with_capacity(text.len() + text.len() / 8);
    for c in text.chars() {
        match c {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            '\'' => out.push_str("&#39;"),
            c if c.is_control() && c != '\n' && c != '\t' => out.push('\u{fffd}'),
            c => out.push(c),
        }
    }
    out
}

/// A number with `digits` significant digits as HTML: a real minus sign, powers of ten outside 10⁻³…10⁵.
pub(super) fn number(value: f64, digits: usize) -> String {
    if value.is_nan() {
        return "not determined".into();
    }
    if value.is_infinite() {
        return if value > 0.0 { "∞" } else { "−∞" }.into();
    }
    if value == 0.0 {
        return "0".into();
    }
    let digits = digits.max(1);
    // Formatting first and reading the exponent back is what makes 9.996 come out as 10.0.
    let scientific = format!("{:.*e}", digits - 1, value);
    let (mantissa, exponent) = scientific.split_once('e').unwrap_or((&scientific, "0"));
    let exponent: i32 = exponent.parse().unwrap_or(0);
    let text = if (-3..5).contains(&exponent) {
        format!("{:.*}", (digits as i32 - 1 - exponent).max(0) as usize, value)
    } else {
        format!("{mantissa} × 10<sup>{exponent}</sup>")
    };
    text.replace('-', "−")
}

/// `value` and its standard deviation, both to the standard deviation's second significant digit.
pub(super) fn with_std(value: f64, std: f64) -> (String, String) {
    if !value.is_finite() || !std.is_finite() || std <= 0.0 {
        return (number(value, 4), if std == 0.0 { "0".into() } else { number(std, 2) });
    }
    let place = |x: f64| x.abs().log10().floor() as i32;
    let digits = if value == 0.0 { 2 } else { (place(value) - place(std) + 2).clamp(1, 9) };
    (number(value, digits as usize), number(std, 2))
}

/// A p value: `< 10⁻⁶` rather than a row of zeros.
pub(super) fn p_value(p: f64) -> String {
    if p.is_finite() && p < 1e-6 { "&lt; 10<sup>−6</sup>".into() } else { number(p, 2) }
}

/// A share as a percentage.
pub(super) fn percent(share: f64) -> String {
    if share.is_finite() { format!("{:.0} %", 100.0 * share) } else { "not determined".into() }
}

/// `distance_since_reversal` as words.
pub(super) fn words(id: &str) -> String {
    escape(&id.replace('_', " "))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_written_as_a_person_would() {
        assert_eq!(number(9.9996, 4), "10.00");
        assert_eq!(number(-0.0311, 3), "−0.0311");
        assert_eq!(number(2.57e-6, 3), "2.57 × 10<sup>−6</sup>");
        assert_eq!(number(123_456.0, 3), "1.23 × 10<sup>5</sup>");
        assert_eq!(number(f64::NAN, 3), "not determined");
        assert_eq!(with_std(95.1543, 0.0831), ("95.154".into(), "0.083".into()));
        assert_eq!(with_std(-3.165, 0.044), ("−3.165".into(), "0.044".into()));
        assert_eq!(with_std(1.2, f64::NAN).1, "not determined");
        assert_eq!(p_value(1e-12), "&lt; 10<sup>−6</sup>");
    }

    #[test]
    fn nothing_a_recording_says_becomes_markup() {
        let hostile = "<script>alert('x')</script> & \"quoted\"\u{0}";
        let safe = escape(hostile);
        assert!(!safe.contains(['<', '>', '"', '\'', '\u{0}']));
        assert_eq!(escape("a & b"), "a &amp; b");
    }
}
