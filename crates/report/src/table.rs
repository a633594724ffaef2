//! Aligned tables for the terminal.

use std::fmt::Write;

/// Aligned columns. A header that begins with `>` is right-aligned.
#[derive(Debug, Clone, Default)]
pub struct Table {
    right: Vec<bool>,
    rows: Vec<Vec<String>>,
}

impl Table {
    /// A table with these headers.
    #[must_use]
    pub fn new(heads: &[&str]) -> Self {
        Self {
            right: heads.iter().map(|h| h.starts_with('>')).collect(),
            rows: vec![heads.iter().map(|h| h.trim_start_matches('>').to_owned()).collect()],
        }
    }

    /// Appends a row. Cells beyond the headers are dropped.
    pub fn row<S: Into<String>>(&mut self, cells: impl IntoIterator<Item = S>) {
        self.rows.push(cells.into_iter().map(Into::into).take(self.right.len()).collect());
    }

    /// Whether there are no rows.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.rows.len() < 2
    }

    /// The table, indented by two spaces.
    #[must_use]
    pub fn render(&self) -> String {
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
}
