//! Tables of a report as text, as a survey protocol has them.

use std::fmt::Write;

use collinear::nalgebra::DMatrix;
use serde_json::Value;

/// A table with columns of equal width, texts to the left and numbers to the right.
#[derive(Clone, Debug, Default)]
pub(crate) struct Table {
    rows: Vec<Vec<String>>,
}

impl Table {
    /// A table with its header; the first column holds names.
    pub(crate) fn new(header: &[&str]) -> Self {
        Self { rows: vec![header.iter().map(|h| (*h).to_owned()).collect()] }
    }

    pub(crate) fn row(&mut self, cells: Vec<String>) {
        self.rows.push(cells);
    }

    /// The lines, two blanks between columns.
    pub(crate) fn write(&self, text: &mut String) {
        let columns = self.rows.iter().map(Vec::len).max().unwrap_or(0);
        let width = |c: usize| {
            self.rows.iter().filter_map(|r| r.get(c)).map(|t| t.chars().count()).max().unwrap_or(0)
        };
        let widths: Vec<usize> = (0..columns).map(width).collect();
        for row in &self.rows {
            let mut line = String::new();
            for (c, (cell, width)) in row.iter().zip(&widths).enumerate() {
                let blanks = " ".repeat(width - cell.chars().count());
                // Writing to a string cannot fail.
                let _ = match c {
                    0 => write!(line, "  {cell}{blanks}"),
                    _ => write!(line, "  {blanks}{cell}"),
                };
            }
            text.push_str(line.trim_end());
            text.push('\n');
        }
    }
}

/// A number with so many decimals; a dash where it is not one, which reads better than NaN.
pub(crate) fn fixed(value: f64, decimals: usize) -> String {
    if value.is_finite() {
        // Adding zero makes −0 into 0.
        let text = format!("{:.decimals$}", value + 0.0);
        if text.trim_start_matches(['-', '0', '.']).is_empty() {
            return text.trim_start_matches('-').to_owned();
        }
        text
    } else {
        "–".to_owned()
    }
}

/// The decimals that show three digits of a standard deviation, at most nine.
pub(crate) fn decimals_for(sigma: f64) -> usize {
    if !(sigma.is_finite() && sigma > 0.0) {
        return 4;
    }
    let digits = 2.0 - sigma.log10().floor();
    digits.clamp(0.0, 9.0) as usize
}

/// A number for machines; null where it is not one, which JSON cannot hold.
pub(crate) fn number(value: f64) -> Value {
    if value.is_finite() { Value::from(value) } else { Value::Null }
}

/// The rows of a matrix.
pub(crate) fn rows(matrix: &DMatrix<f64>) -> Vec<Vec<f64>> {
    matrix.row_iter().map(|row| row.iter().copied().collect()).collect()
}
