//! Numbers to the digits of their standard error, as text and HTML.

/// Output format of a number.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Medium {
    Text,
    Html,
}

impl Medium {
    fn number(self, value: f64, digits: usize) -> String {
        let html = self == Self::Html;
        if value.is_nan() {
            return if html { "not determined" } else { "–" }.into();
        }
        if value.is_infinite() {
            return match (html, value > 0.0) {
                (false, _) => format!("{value}"),
                (true, true) => "∞".into(),
                (true, false) => "−∞".into(),
            };
        }
        if value == 0.0 {
            return "0".into();
        }
        let digits = digits.max(1);
        // formatting first and reading the exponent back turns 9.996 into 10.0
        let scientific = format!("{value:.*e}", digits - 1);
        let (mantissa, exponent) = scientific.split_once('e').unwrap_or((&scientific, "0"));
        let power: i32 = exponent.parse().unwrap_or(0);
        let text = if (-3..5).contains(&power) {
            format!("{value:.*}", (digits as i32 - 1 - power).max(0) as usize)
        } else if html {
            format!("{mantissa} × 10<sup>{power}</sup>")
        } else {
            return scientific;
        };
        if html { text.replace('-', "−") } else { text }
    }

    fn with_std(self, value: f64, std: f64) -> (String, String) {
        if !value.is_finite() || !std.is_finite() || std <= 0.0 {
            return (self.number(value, 5), self.number(std, 2));
        }
        let place = |x: f64| x.abs().log10().floor() as i32;
        let digits = if value == 0.0 { 2 } else { (place(value) - place(std) + 2).clamp(1, 9) };
        (self.number(value, digits as usize), self.number(std, 2))
    }
}

/// A number with `digits` significant digits; scientific outside 10⁻³…10⁵.
#[must_use]
pub fn number(value: f64, digits: usize) -> String {
    Medium::Text.number(value, digits)
}

/// A value to the second significant digit of its standard error, and the error.
#[must_use]
pub fn with_std(value: f64, std: f64) -> (String, String) {
    Medium::Text.with_std(value, std)
}

/// [`number`] as HTML: a real minus sign, powers of ten.
#[must_use]
pub fn html(value: f64, digits: usize) -> String {
    Medium::Html.number(value, digits)
}

/// [`with_std`] as HTML.
#[must_use]
pub fn html_with_std(value: f64, std: f64) -> (String, String) {
    Medium::Html.with_std(value, std)
}

/// A p value: `< 10⁻⁶` rather than a row of zeros.
pub(crate) fn p_value(p: f64) -> String {
    if p.is_finite() && p < 1e-6 { "&lt; 10<sup>−6</sup>".into() } else { html(p, 2) }
}

/// A share as a percentage.
pub(crate) fn percent(share: f64) -> String {
    if share.is_finite() { format!("{:.0} %", 100.0 * share) } else { "not determined".into() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_keep_their_digits() {
        assert_eq!(number(9.9996, 4), "10.00");
        assert_eq!(number(2.57e-6, 3), "2.57e-6");
        assert_eq!(number(-0.0, 3), "0");
        assert_eq!(number(f64::NAN, 3), "–");
        assert_eq!(with_std(95.1543, 0.0831), ("95.154".into(), "0.083".into()));
        assert_eq!(html(9.9996, 4), "10.00");
        assert_eq!(html(-0.0311, 3), "−0.0311");
        assert_eq!(html(2.57e-6, 3), "2.57 × 10<sup>−6</sup>");
        assert_eq!(html(123_456.0, 3), "1.23 × 10<sup>5</sup>");
        assert_eq!(html(f64::NAN, 3), "not determined");
        assert_eq!(html_with_std(95.1543, 0.0831), ("95.154".into(), "0.083".into()));
        assert_eq!(html_with_std(-3.165, 0.044), ("−3.165".into(), "0.044".into()));
        assert_eq!(html_with_std(1.2, f64::NAN).1, "not determined");
        assert_eq!(p_value(1e-12), "&lt; 10<sup>−6</sup>");
    }
}
