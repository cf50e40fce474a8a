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

/// No float has more significant digits.
const MOST_DIGITS: usize = 15;

/// A number with so many decimals, in scientific notation where that takes more digits than a float has; a dash where it is not one,
/// which reads better than NaN.
pub(crate) fn fixed(value: f64, decimals: usize) -> String {
    if !value.is_finite() {
        return "–".to_owned();
    }
    let before = if value == 0.0 { 0.0 } else { value.abs().log10().floor() };
    // Digits from the first that is not zero, and those that stand there with the zeros before it.
    let significant = before + 1.0 + decimals as f64;
    let written = before.max(0.0) + 1.0 + decimals as f64;
    if written > MOST_DIGITS as f64 && significant >= 1.0 && value != 0.0 {
        let digits = significant.min(MOST_DIGITS as f64) as usize;
        return format!("{value:.*e}", digits - 1);
    }
    let decimals = decimals.min(MOST_DIGITS - 1);
    // Adding zero makes −0 into 0.
    let text = format!("{:.decimals$}", value + 0.0);
    if text.trim_start_matches(['-', '0', '.']).is_empty() {
        return text.trim_start_matches('-').to_owned();
    }
    text
}

/// The decimals that show three digits of a standard deviation.
pub(crate) fn decimals_for(sigma: f64) -> usize {
    if !(sigma.is_finite() && sigma > 0.0) {
        return 4;
    }
    let digits = 2.0 - sigma.log10().floor();
    digits.max(0.0) as usize
}

/// A number for machines; null where it is not one, which JSON cannot hold.
pub(crate) fn number(value: f64) -> Value {
    if value.is_finite() { Value::from(value) } else { Value::Null }
}

/// The rows of a matrix.
pub(crate) fn rows(matrix: &DMatrix<f64>) -> Vec<Vec<f64>> {
    matrix.row_iter().map(|row| row.iter().copied().collect()).collect()
}

#[cfg(test)]
mod tests {
    use super::{decimals_for, fixed};

    #[test]
    fn a_number_has_no_more_digits_than_a_float() {
        for (value, decimals, text) in [
            (0.0, 3, "0.000"),
            (-0.0, 0, "0"),
            (-1e-9, 3, "0.000"),
            (-1.25, 1, "-1.2"),
            (4_500_000.123_4, 3, "4500000.123"),
            (123_456_789_012.3, 3, "123456789012.300"),
            (1_234_567_890_123.0, 3, "1.23456789012300e12"),
            (1e150, 0, "1.00000000000000e150"),
            (-2.5e200, 4, "-2.50000000000000e200"),
            (3.21e-12, 14, "0.00000000000321"),
            (3.21e-20, 22, "3.21e-20"),
            (1e-300, 22, "0.00000000000000"),
            (0.0, 300, "0.00000000000000"),
            (f64::NAN, 3, "–"),
            (f64::INFINITY, 3, "–"),
        ] {
            assert_eq!(fixed(value, decimals), text, "{value:e} {decimals}");
        }
        for (sigma, decimals) in
            [(1.0, 2), (123.0, 0), (0.05, 4), (1.5e-12, 14), (5e-324, 326), (1e300, 0), (0.0, 4)]
        {
            assert_eq!(decimals_for(sigma), decimals, "{sigma:e}");
        }
    }
}
