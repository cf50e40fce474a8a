//! Cholesky's factorisation of the reduced system.
//!
//! ```text
//! S = UᵀU,   U upper triangular
//! ```
//! The matrix is kept by rows, its upper triangle only: every loop runs along rows.

use super::parallel;

/// Rows that are eliminated together: a panel of them stays in the cache.
const PANEL: usize = 32;
/// Rows of the rest that one part of the work updates.
const BAND: usize = 64;

/// A pivot of a matrix of unit diagonal that rounding alone may have left, for each of its rows.
const MIN_PIVOT: f64 = 2.0 * f64::EPSILON;

/// Replaces the upper triangle of an `n` × `n` matrix of about unit diagonal by U; `None` where it is not positive definite
/// to rounding, with the row.
pub(super) fn factorise(a: &mut [f64], n: usize) -> Result<(), usize> {
    eliminate(a, n, n, n)
}

/// Replaces the first `pivots` rows by those of U, and the rest by what is left of it when their unknowns are eliminated. Rows have `n`
/// columns, of which those beyond the square are right sides. `of` is the number of unknowns of the whole system.
pub(super) fn eliminate(a: &mut [f64], n: usize, pivots: usize, of: usize) -> Result<(), usize> {
    let mut begin = 0;
    while begin < pivots {
        let end = (begin + PANEL).min(pivots);
        let (head, rest) = a.split_at_mut(end * n);
        let panel = &mut head[begin * n..];
        factorise_panel(panel, begin, n, of)?;
        let mut bands: alloc::vec::Vec<&mut [f64]> = rest.chunks_mut(BAND * n).collect();
        let panel = &*panel;
        parallel::for_each(&mut bands, |band, rows| {
            update(panel, rows, end + band * BAND, n);
        });
        begin = end;
    }
    Ok(())
}

/// U of the rows from `begin` on, whose columns before it are done.
fn factorise_panel(panel: &mut [f64], begin: usize, n: usize, of: usize) -> Result<(), usize> {
    let count = panel.len() / n;
    for i in 0..count {
        let (row, below) = panel[i * n..].split_at_mut(n);
        let column = begin + i;
        let pivot = row[column];
        if !(pivot > MIN_PIVOT * of as f64 && pivot < f64::INFINITY) {
            return Err(column);
        }
        let inverse = 1.0 / pivot.sqrt();
        row[column..].iter_mut().for_each(|v| *v *= inverse);
        for (j, other) in below.chunks_exact_mut(n).enumerate() {
            let from = column + 1 + j;
            let factor = row[from];
            if factor != 0.0 {
                for (o, v) in other[from..].iter_mut().zip(&row[from..]) {
                    *o -= factor * v;
                }
            }
        }
    }
    Ok(())
}

/// Rows from `first` on less what the panel's rows say of them.
fn update(panel: &[f64], rows: &mut [f64], first: usize, n: usize) {
    for (i, row) in rows.chunks_exact_mut(n).enumerate() {
        let column = first + i;
        let row = &mut row[column..];
        let mut four = panel.chunks_exact(4 * n);
        for block in &mut four {
            let [a, b, c, d] = [0, 1, 2, 3].map(|k| &block[k * n + column..][..row.len()]);
            let [fa, fb, fc, fd] = [a, b, c, d].map(|u| u[0]);
            for (j, v) in row.iter_mut().enumerate() {
                *v -= (fa * a[j] + fb * b[j]) + (fc * c[j] + fd * d[j]);
            }
        }
        for u in four.remainder().chunks_exact(n) {
            let u = &u[column..][..row.len()];
            let factor = u[0];
            row.iter_mut().zip(u).for_each(|(v, u)| *v -= factor * u);
        }
    }
}

/// Solves UᵀU x = b in place.
pub(super) fn solve(u: &[f64], n: usize, b: &mut [f64]) {
    solve_from(u, n, b, 0);
}

/// The same for a b that is zero before its `first` element.
fn solve_from(u: &[f64], n: usize, b: &mut [f64], first: usize) {
    for i in first..n {
        let row = &u[i * n..][..n];
        let x = b[i] / row[i];
        b[i] = x;
        for (b, u) in b[i + 1..].iter_mut().zip(&row[i + 1..]) {
            *b -= x * u;
        }
    }
    for i in (0..n).rev() {
        let row = &u[i * n..][..n];
        let sum: f64 = row[i + 1..].iter().zip(&b[i + 1..]).map(|(u, x)| u * x).sum();
        b[i] = (b[i] - sum) / row[i];
    }
}

/// (UᵀU)⁻¹ by rows, both halves.
pub(super) fn inverse(u: &[f64], n: usize) -> alloc::vec::Vec<f64> {
    let mut inverse = alloc::vec![0.0; n * n];
    let mut columns: alloc::vec::Vec<&mut [f64]> = inverse.chunks_mut(n.max(1)).collect();
    // The matrix is symmetric: what is a column of it is a row.
    parallel::for_each(&mut columns, |i, column| {
        column[i] = 1.0;
        solve_from(u, n, column, i);
    });
    inverse
}

#[cfg(test)]
mod tests {
    use alloc::vec;

    use super::*;

    #[test]
    fn a_matrix_by_hand() {
        // UᵀU of U = (1 ½ 0; 0 1 ½; 0 0 1), and of what lies below only the upper triangle is read.
        let mut a = vec![1.0, 0.5, 0.0, 7.0, 1.25, 0.5, 7.0, 7.0, 1.25];
        factorise(&mut a, 3).unwrap();
        assert_eq!([a[0], a[1], a[2], a[4], a[5], a[8]], [1.0, 0.5, 0.0, 1.0, 0.5, 1.0]);
        // S (1, 2, 3) = (2, 4.5, 4.75)
        let mut x = [2.0, 4.5, 4.75];
        solve(&a, 3, &mut x);
        assert_eq!(x, [1.0, 2.0, 3.0]);
        assert_eq!(factorise(&mut [1.0, 2.0, 0.0, 1.0], 2), Err(1));
    }

    #[test]
    fn panels_and_bands_fit_together() {
        // The inverse of second differences: aᵢⱼ = min(i, j) of an integer chain; U has ones throughout.
        for n in [1, 31, 32, 33, 100, 161] {
            let mut a: vec::Vec<f64> =
                (0..n * n).map(|k| (k / n).min(k % n) as f64 + 1.0).collect();
            factorise(&mut a, n).unwrap();
            for i in 0..n {
                assert!(a[i * n + i..(i + 1) * n].iter().all(|u| *u == 1.0), "{n} {i}");
            }
        }
    }
}
