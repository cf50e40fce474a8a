//! A tall matrix reduced row by row to its triangular factor.
//!
//! The rows of a linear system are rotated one by one into an upper triangle R with RᵀR = AᵀA (Givens 1958). Unlike the
//! product AᵀA, R keeps the full precision of A, and no more than N × N numbers are stored.

use nalgebra::{SMatrix, SVector};

use super::float;

/// The upper triangle R of the rows added so far.
#[derive(Clone, Debug)]
pub(crate) struct Triangular<const N: usize> {
    r: SMatrix<f64, N, N>,
}

impl<const N: usize> Triangular<N> {
    pub(crate) fn new() -> Self {
        Self { r: SMatrix::zeros() }
    }

    /// Rotates one row into the triangle.
    pub(crate) fn add_row(&mut self, mut row: [f64; N]) {
        for i in 0..N {
            if row[i] == 0.0 {
                continue;
            }
            let length = float::hypot(self.r[(i, i)], row[i]);
            let (c, s) = (self.r[(i, i)] / length, row[i] / length);
            self.r[(i, i)] = length;
            for j in i + 1..N {
                let (a, b) = (self.r[(i, j)], row[j]);
                self.r[(i, j)] = c * a + s * b;
                row[j] = c * b - s * a;
            }
        }
    }

    /// The singular values, descending, with the right singular vectors as columns in the same order: eigenvalues of
    /// RᵀR by one-sided Jacobi rotations (Hestenes 1958), accurate in the small ones too.
    pub(crate) fn singular(&self) -> (SVector<f64, N>, SMatrix<f64, N, N>) {
        let mut a = self.r;
        let mut v = SMatrix::<f64, N, N>::identity();
        // A column that should be zero is only ever rotated to ε of itself; below this it counts as zero.
        let nothing = 1e-40 * a.norm_squared();
        for _sweep in 0..40 {
            let mut rotated = false;
            for p in 0..N {
                for q in p + 1..N {
                    let (alpha, beta) = (a.column(p).norm_squared(), a.column(q).norm_squared());
                    let gamma = a.column(p).dot(&a.column(q));
                    // A product of N terms is not exact below N u: a smaller limit would turn rounding for ever.
                    let limit = 0.5 * f64::EPSILON * N as f64;
                    if !(gamma.abs() > limit * float::sqrt(alpha * beta) + nothing) {
                        continue;
                    }
                    rotated = true;
                    let zeta = (beta - alpha) / (2.0 * gamma);
                    let t = 1.0f64.copysign(zeta) / (zeta.abs() + float::hypot(1.0, zeta));
                    let c = 1.0 / float::hypot(1.0, t);
                    let s = c * t;
                    for m in [&mut a, &mut v] {
                        for k in 0..N {
                            let (x, y) = (m[(k, p)], m[(k, q)]);
                            m[(k, p)] = c * x - s * y;
                            m[(k, q)] = s * x + c * y;
                        }
                    }
                }
            }
            if !rotated {
                break;
            }
        }
        let norms = SVector::<f64, N>::from_fn(|i, _| a.column(i).norm());
        let mut order: [usize; N] = core::array::from_fn(|i| i);
        order.sort_unstable_by(|&i, &j| norms[j].total_cmp(&norms[i]));
        (SVector::from_fn(|i, _| norms[order[i]]), SMatrix::from_fn(|i, j| v[(i, order[j])]))
    }
}

impl<const N: usize> Triangular<N> {
    /// The least-squares solution x of A x = b, where the rows added were (A | b) and N counts the column of b; the
    /// result has N − 1 meaningful entries. Returns `None` where a diagonal entry of R is below `tolerance` times the
    /// largest.
    pub(crate) fn solve(&self, tolerance: f64) -> Option<[f64; N]> {
        let unknowns = N - 1;
        let largest = (0..unknowns).map(|i| self.r[(i, i)].abs()).fold(0.0, f64::max);
        let mut x = [0.0; N];
        for i in (0..unknowns).rev() {
            let pivot = self.r[(i, i)];
            if !(pivot.abs() > tolerance * largest) {
                return None;
            }
            let rest: f64 = (i + 1..unknowns).map(|j| self.r[(i, j)] * x[j]).sum();
            x[i] = (self.r[(i, N - 1)] - rest) / pivot;
        }
        Some(x)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn singular_values_of_a_known_matrix() {
        // numpy 2.4.6: np.linalg.svd([[1,2,3],[4,5,6],[7,8,10],[1,0,1]]).
        let mut t = Triangular::<3>::new();
        for row in [[1.0, 2.0, 3.0], [4.0, 5.0, 6.0], [7.0, 8.0, 10.0], [1.0, 0.0, 1.0]] {
            t.add_row(row);
        }
        let (s, v) = t.singular();
        for (s, e) in
            s.iter().zip([17.450_895_584_636_637, 0.986_939_165_736_587_9, 0.701_565_661_392_129_1])
        {
            assert!((s - e).abs() < 1e-13, "{s} {e}");
        }
        assert!(((v.transpose() * v) - SMatrix::<f64, 3, 3>::identity()).norm() < 1e-14);
    }

    #[test]
    fn least_squares_line() {
        // A line through (0, 2), (1, 5), (2, 8), (3, 15).
        let mut t = Triangular::<3>::new();
        for (x, y) in [(0.0, 2.0), (1.0, 5.0), (2.0, 8.0), (3.0, 15.0)] {
            t.add_row([1.0, x, y]);
        }
        let x = t.solve(1e-12).unwrap();
        // Normal equations by hand: n = 4, Σx = 6, Σx² = 14, Σy = 30, Σxy = 66; slope 4.2, intercept 1.2.
        assert!((x[0] - 1.2).abs() < 1e-14 && (x[1] - 4.2).abs() < 1e-14, "{x:?}");
    }
}
