//! Tables for the terminal: columns aligned, numbers by their right edge.

use std::fmt::Write;

/// Columns that align; a header that begins with `>` is right-aligned.
#[derive(Debug, Clone, Default)]
pub(crate) struct Table {
    right: Vec<bool>,
    rows: Vec<Vec<String>>,
}

impl Table {
    /// A table with these column heads.
    pub(crate) fn new(heads: &[&str]) -> Self {
        Self {
            right: heads.iter().map(|h| h.starts_with('>')).collect(),
            rows: vec![heads.iter().map(|h| h.trim_start_matches('>').to_owned()).collect()],
        }
    }

    /// Appends a row; cells beyond the heads are dropped.
    pub(crate) fn row<S: Into<String>>(&mut self, cells: impl IntoIterator<Item = S>) {
        self.rows.push(cells.into_iter().map(Into::into).take(self.right.len()).collect());
    }

    /// No rows below the heads.
    pub(crate) fn is_empty(&self) -> bool {
        self.rows.len() < 2
    }

    /// The table, indented by two spaces.
    pub(crate) fn render(&self) -> String {
        let width = |column: usize| {
            self.rows.iter().filter_map(|r| r.get(column)).map(|c| c.chars().count()).max().unwrap_or(0)
        };
        let widths: Vec<usize> = (0..self.right.len()).map(width).collect();
        let mut out = String::new();
        for row in &self.rows {
            let mut line = String::from(" ");
            for ((cell, &width), &right) in row.iter().zip(&widths).zip(&self.right) {
                let _ =
                    if right { write!(line, " {cell:>width$} ") } else { write!(line, " {cell:<width$} ") };
            }
            out.push_str(line.trim_end());
            out.push('\n');
        }
        out
    }
}

/// A number with `digits` significant digits; scientific outside 10⁻³…10⁵.
pub(crate) fn number(value: f64, digits: usize) -> String {
    if value.is_nan() {
        return "–".into();
    }
    if value == 0.0 || value.is_infinite() {
        return format!("{value}");
    }
    let digits = digits.max(1);
    let scientific = format!("{value:.*e}", digits - 1);
    let exponent: i32 = scientific.rsplit('e').next().and_then(|e| e.parse().ok()).unwrap_or(0);
    if (-3..5).contains(&exponent) {
        format!("{value:.*}", (digits as i32 - 1 - exponent).max(0) as usize)
    } else {
        scientific
    }
}

/// A value to the second significant digit of its standard deviation, and that deviation.
pub(crate) fn with_std(value: f64, std: f64) -> (String, String) {
    if !value.is_finite() || !std.is_finite() || std <= 0.0 {
        return (number(value, 5), number(std, 2));
    }
    let place = |x: f64| x.abs().log10().floor() as i32;
    let digits = if value == 0.0 { 2 } else { (place(value) - place(std) + 2).clamp(1, 9) };
    (number(value, digits as usize), number(std, 2))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_align() {
        let mut t = Table::new(&["parameter", ">value", "unit"]);
        t.row(["mass", "95.154", "kg"]);
        t.row(["σ₀", "3", "N/m"]);
        assert_eq!(
            t.render(),
            "  parameter   value  unit\n  mass       95.154  kg\n  σ₀              3  N/m\n"
        );
    }

    #[test]
    fn numbers_keep_their_digits() {
        assert_eq!(number(9.9996, 4), "10.00");
        assert_eq!(number(2.57e-6, 3), "2.57e-6");
        assert_eq!(with_std(95.1543, 0.0831), ("95.154".into(), "0.083".into()));
        assert_eq!(number(f64::NAN, 3), "–");
    }
}
