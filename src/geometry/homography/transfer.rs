//! The distances that a fitted homography makes small, and their linearisation.

use alloc::vec::Vec;

use nalgebra::{Matrix2, Matrix3, SMatrix, SVector, Vector2};

use super::fit::{FitOptions, Frame, TransferCost};
use super::homogeneous;
use crate::error::{Error, ProjectionError};
use crate::numeric::float;
use crate::numeric::least_squares::{Damped, NormalEquations, Problem};
use crate::numeric::triangular::Triangular;

/// The image (u, v) of a point and its partial derivatives with respect to the nine entries: s/w, s/w and −u s/w.
pub(super) fn transfer(
    h: &SVector<f64, 9>,
    [x, y]: [f64; 2],
) -> Result<([f64; 2], SMatrix<f64, 2, 9>), ProjectionError> {
    let [u, v, w] = homogeneous(&(*h).into(), [x, y]);
    if w <= 0.0 {
        return Err(ProjectionError::BeyondHorizon { w });
    }
    let (u, v, s) = (u / w, v / w, [x / w, y / w, 1.0 / w]);
    if !(u.is_finite() && v.is_finite()) {
        return Err(ProjectionError::NotFinite);
    }
    let partials = SMatrix::from_fn(|row, k| match (row, k / 3) {
        (0, 0) | (1, 1) => s[k % 3],
        (0, 2) => -u * s[k % 3],
        (1, 2) => -v * s[k % 3],
        _ => 0.0,
    });
    Ok(([u, v], partials))
}

/// The distances in normalised coordinates: object of unit variance, image divided by `pixel`.
pub(super) struct Transfer<'a> {
    pub(super) object: Vec<[f64; 2]>,
    pub(super) image: Vec<[f64; 2]>,
    pub(super) weights: Option<&'a [f64]>,
    pub(super) options: FitOptions,
    pub(super) pixel: f64,
    pub(super) object_unit: Matrix2<f64>,
}

/// Normal equations of eight entries, the largest of the nine held fixed.
pub(super) struct Linear {
    pub(super) fixed: usize,
    pub(super) normal: NormalEquations<8>,
}

/// The condition down to which the linear start is found from squared equations: its error is then below 1e-6.
const SQUARED: f64 = 1e-5;

/// Where the product of entry `i` and `j` of (x, y, 1) stands among the six.
const PAIR: [[usize; 3]; 3] = [[0, 1, 2], [1, 3, 4], [2, 4, 5]];

/// Σ of the six products of s = (x, y, 1) times 1, u, v and u² + v²: all of `JᵀJ`, since a point's 18 partials are s, s,
/// −u s and −v s times a factor.
#[derive(Default)]
struct Moments([[f64; 6]; 4]);

impl Moments {
    #[inline]
    fn add(&mut self, s: [f64; 3], u: f64, v: f64, weight: f64) {
        let squares =
            [s[0] * s[0], s[0] * s[1], s[0] * s[2], s[1] * s[1], s[1] * s[2], s[2] * s[2]];
        for (sums, factor) in self.0.iter_mut().zip([1.0, u, v, u * u + v * v]) {
            for (sum, square) in sums.iter_mut().zip(squares) {
                *sum += weight * factor * square;
            }
        }
    }

    fn entry(&self, i: usize, j: usize) -> f64 {
        let pair = PAIR[i % 3][j % 3];
        match (i / 3, j / 3) {
            (0, 0) | (1, 1) => self.0[0][pair],
            (2, 0) | (0, 2) => -self.0[1][pair],
            (2, 1) | (1, 2) => -self.0[2][pair],
            (2, 2) => self.0[3][pair],
            _ => 0.0,
        }
    }
}

impl Transfer<'_> {
    /// `AᵀA` of the linear equations, with the image whitened.
    fn moments(&self, whiten: &Matrix2<f64>) -> Triangular<9> {
        let mut moments = Moments::default();
        for (i, (s, t)) in self.object.iter().zip(&self.image).enumerate() {
            let t = whiten * Vector2::from(*t);
            moments.add([s[0], s[1], 1.0], t.x, t.y, self.weight(i));
        }
        let mut triangle = Triangular::new();
        for i in 0..9 {
            triangle.add_row(core::array::from_fn(|j| moments.entry(i, j)));
        }
        triangle
    }

    pub(super) fn weight(&self, index: usize) -> f64 {
        self.weights.and_then(|w| w.get(index).copied()).unwrap_or(1.0)
    }

    /// The entries h of unit length that make Σ ‖w x′ − H x‖² least, oriented so that most points lie in front, and the
    /// eighth singular value over the first.
    pub(super) fn linear(&self, from: &Frame, to: &Frame) -> Result<(SVector<f64, 9>, f64), Error> {
        let whiten = to.matrix * self.pixel;
        let rows = || {
            self.object.iter().zip(&self.image).enumerate().flat_map(move |(i, (s, t))| {
                let root = float::sqrt(self.weight(i));
                let t = whiten * Vector2::from(*t);
                [t.x, t.y].into_iter().enumerate().map(move |(axis, u)| {
                    let mut row = [0.0; 9];
                    for (k, s) in [s[0], s[1], 1.0].into_iter().enumerate() {
                        row[3 * axis + k] = root * s;
                        row[6 + k] = -root * u * s;
                    }
                    row
                })
            })
        };
        // From the sums AᵀA where the small singular values survive the squaring, from A itself where they do not.
        let (squares, mut vectors) = self.moments(&whiten).singular();
        let mut condition = if squares[0] > 0.0 { squares[7] / squares[0] } else { 0.0 };
        condition = float::sqrt(condition);
        if condition.is_nan() || condition <= SQUARED {
            let mut triangle = Triangular::<9>::new();
            for row in rows() {
                triangle.add_row(row);
            }
            let (values, rows) = triangle.singular();
            condition = if values[0] > 0.0 { values[7] / values[0] } else { 0.0 };
            vectors = rows;
        }
        let limit = 64.0 * (f64::EPSILON + from.rounding + to.rounding);
        if condition.is_nan() || condition <= limit {
            let what = "homography fit: fewer than four points in general position";
            return Err(Error::Degenerate { what, measure: condition, limit });
        }
        let mut h: SVector<f64, 9> = vectors.column(8).into();
        // From the whitened image to the one only scaled.
        let unwhiten = to.inverse / self.pixel;
        for k in 0..3 {
            let row = unwhiten * Vector2::new(h[k], h[3 + k]);
            (h[k], h[3 + k]) = (row.x, row.y);
        }
        let front: f64 = (0..self.object.len())
            .map(|i| self.weight(i).min(1.0) * homogeneous(&h.into(), self.object[i])[2].signum())
            .sum();
        Ok((h.normalize() * 1.0f64.copysign(front), condition))
    }
}

impl Problem for Transfer<'_> {
    type State = SVector<f64, 9>;
    type Linear = Linear;
    type Step = SVector<f64, 9>;

    fn cost(&self, h: &Self::State) -> f64 {
        let entries: [f64; 9] = (*h).into();
        let loss = self.options.loss;
        let back = match self.options.cost {
            TransferCost::Image => None,
            TransferCost::Symmetric => Some(inverse(h)),
        };
        let mut sum = 0.0;
        for (i, (s, t)) in self.object.iter().zip(&self.image).enumerate() {
            let weight = self.weight(i);
            if weight == 0.0 {
                continue;
            }
            let [u, v, w] = homogeneous(&entries, *s);
            // A point beyond the horizon is infinitely far off, which only a truncated loss can bear.
            let squared = if w > 0.0 {
                Vector2::new(u / w - t[0], v / w - t[1]).norm_squared() * self.pixel * self.pixel
            } else {
                f64::INFINITY
            };
            sum += weight * loss.cost(squared);
            if let Some(back) = &back {
                let [x, y, w] = homogeneous(back, *t);
                let squared = if w > 0.0 {
                    (self.object_unit * Vector2::new(x / w - s[0], y / w - s[1])).norm_squared()
                } else {
                    f64::INFINITY
                };
                sum += weight * loss.cost(squared);
            }
        }
        0.5 * sum
    }

    fn linearise(&self, h: &Self::State, linear: &mut Self::Linear) -> f64 {
        linear.fixed = h.iamax();
        let entries: [f64; 9] = (*h).into();
        let unit = self.pixel * self.pixel;
        let mut moments = Moments::default();
        let mut gradient = [0.0f64; 9];
        for (i, (s, t)) in self.object.iter().zip(&self.image).enumerate() {
            let [u, v, w] = homogeneous(&entries, *s);
            if w <= 0.0 {
                continue;
            }
            let (u, v, s) = (u / w, v / w, [s[0] / w, s[1] / w, 1.0 / w]);
            let (ex, ey) = (u - t[0], v - t[1]);
            let loss = self.options.loss.weight(unit * (ex * ex + ey * ey));
            let weight = unit * self.weight(i) * loss;
            moments.add(s, u, v, weight);
            let along = u * ex + v * ey;
            for (k, s) in s.into_iter().enumerate() {
                gradient[k] += weight * ex * s;
                gradient[3 + k] += weight * ey * s;
                gradient[6 + k] -= weight * along * s;
            }
        }
        let free = |k: usize| if k < linear.fixed { k } else { k + 1 };
        linear.normal = NormalEquations::from_parts(
            SMatrix::from_fn(|i, j| moments.entry(free(i), free(j))),
            SVector::from_fn(|i, _| gradient[free(i)]),
        );
        if self.options.cost == TransferCost::Symmetric {
            self.add_backward(h, linear);
        }
        linear.normal.scaled_gradient()
    }

    fn solve(
        &self,
        _: &Self::State,
        linear: &Self::Linear,
        damping: f64,
    ) -> Option<Damped<Self::Step>> {
        let d = linear.normal.solve(damping, &SVector::repeat(1.0))?;
        let step = SVector::from_fn(|k, _| match k.cmp(&linear.fixed) {
            core::cmp::Ordering::Less => d.step[k],
            core::cmp::Ordering::Equal => 0.0,
            core::cmp::Ordering::Greater => d.step[k - 1],
        });
        Some(Damped {
            step,
            predicted_decrease: d.predicted_decrease,
            relative_length: d.relative_length,
        })
    }

    fn apply(&self, h: &Self::State, step: &Self::Step) -> Self::State {
        (h + step).normalize()
    }
}

/// The entries of the inverse matrix; NaN for a singular one.
fn inverse(h: &SVector<f64, 9>) -> [f64; 9] {
    let inverse = Matrix3::from_row_slice(h.as_slice()).try_inverse();
    inverse.map_or([f64::NAN; 9], |m| m.transpose().as_slice().try_into().unwrap_or([f64::NAN; 9]))
}

impl Transfer<'_> {
    /// The distances ‖x − G x′‖ in the object, G = H⁻¹: with y = G x′, dy = −G dH y.
    fn add_backward(&self, h: &SVector<f64, 9>, linear: &mut Linear) {
        let g = inverse(h);
        for (i, (s, t)) in self.object.iter().zip(&self.image).enumerate() {
            let y = homogeneous(&g, *t);
            if y[2] <= 0.0 {
                continue;
            }
            let (p, q) = (y[0] / y[2], y[1] / y[2]);
            let residual = self.object_unit * Vector2::new(p - s[0], q - s[1]);
            let weight = self.weight(i) * self.options.loss.weight(residual.norm_squared());
            let partial = |k: usize| {
                let column = [g[k / 3], g[3 + k / 3], g[6 + k / 3]];
                let factor = -y[k % 3] / y[2];
                self.object_unit
                    * Vector2::new(column[0] - p * column[2], column[1] - q * column[2])
                    * factor
            };
            let free = |k: usize| if k < linear.fixed { k } else { k + 1 };
            let partials = SMatrix::<f64, 2, 8>::from_fn(|row, k| partial(free(k))[row]);
            for axis in 0..2 {
                linear.normal.add(&partials.row(axis).transpose(), residual[axis], weight);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::scalar::Dual;

    const H: [f64; 9] = [0.5, 0.1, -0.2, -0.15, 0.6, 0.1, 0.05, -0.08, 0.55];
    const WEIGHTS: [f64; 5] = [1.0, 0.5, 2.0, 0.0, 1.5];

    fn problem(cost: TransferCost) -> Transfer<'static> {
        Transfer {
            object: alloc::vec![[-1.0, 0.3], [0.7, -1.2], [1.4, 0.9], [-0.2, 1.5], [0.1, 0.2]],
            image: alloc::vec![[-1.2, 0.8], [0.5, -1.0], [1.1, 1.0], [-0.4, 1.9], [-0.3, 0.5]],
            weights: Some(&WEIGHTS),
            options: FitOptions { cost, ..Default::default() },
            pixel: 3.0,
            object_unit: Matrix2::new(2.0, 0.0, 0.3, 1.5),
        }
    }

    /// The rows of the adjugate, whose scale a projective map does not see.
    fn adjugate(h: &[Dual<9>; 9]) -> [Dual<9>; 9] {
        core::array::from_fn(|k| {
            let (i, j) = (k % 3, k / 3);
            let at = |di: usize, dj: usize| h[3 * ((i + di) % 3) + (j + dj) % 3];
            at(1, 1) * at(2, 2) - at(1, 2) * at(2, 1)
        })
    }

    #[test]
    fn normal_equations_are_those_of_the_formula() {
        for cost in [TransferCost::Image, TransferCost::Symmetric] {
            let problem = problem(cost);
            let entries: [Dual<9>; 9] = core::array::from_fn(|k| Dual::variable(H[k], k));
            let constant = |p: [f64; 2]| p.map(|c| Dual { value: c, gradient: [0.0; 9] });
            let mut expected = NormalEquations::<9>::default();
            let mut add = |residual: Dual<9>, weight: f64| {
                expected.add(&SVector::from(residual.gradient), residual.value, weight);
            };
            let scaled = |d: Dual<9>, factor: f64| d * Dual { value: factor, gradient: [0.0; 9] };
            for (i, (s, t)) in problem.object.iter().zip(&problem.image).enumerate() {
                let [u, v, w] = homogeneous(&entries, constant(*s));
                for (image, t) in [(u / w, t[0]), (v / w, t[1])] {
                    let t = Dual { value: t, gradient: [0.0; 9] };
                    add(scaled(image - t, problem.pixel), WEIGHTS[i]);
                }
                if cost == TransferCost::Symmetric {
                    let [x, y, w] = homogeneous(&adjugate(&entries), constant(*t));
                    let [a, b] = constant(*s);
                    let (dx, dy) = (x / w - a, y / w - b);
                    let unit = problem.object_unit;
                    add(scaled(dx, unit.m11) + scaled(dy, unit.m12), WEIGHTS[i]);
                    add(scaled(dx, unit.m21) + scaled(dy, unit.m22), WEIGHTS[i]);
                }
            }
            let mut linear = Linear { fixed: 0, normal: NormalEquations::default() };
            problem.linearise(&SVector::from(H), &mut linear);
            assert_eq!(linear.fixed, 4);
            let (full, part) = (expected.matrix(), linear.normal.matrix());
            let free = |k: usize| if k < 4 { k } else { k + 1 };
            for i in 0..8 {
                for j in 0..8 {
                    let (a, b) = (part[(i, j)], full[(free(i), free(j))]);
                    assert!((a - b).abs() < 1e-12 * full.amax(), "{cost:?} {i} {j} {a} {b}");
                }
            }
            // The gradient by the slope of the cost along each entry.
            let step = linear.normal.solve(1.0, &SVector::repeat(1.0)).unwrap().step;
            let gradient = -(part + SMatrix::from_diagonal(&part.diagonal())) * step;
            for (i, g) in gradient.iter().enumerate() {
                let mut moved = [SVector::<f64, 9>::from(H); 2];
                moved[0][free(i)] += 1e-6;
                moved[1][free(i)] -= 1e-6;
                let slope = (problem.cost(&moved[0]) - problem.cost(&moved[1])) / 2e-6;
                assert!((g - slope).abs() < 1e-6 * (1.0 + slope.abs()), "{cost:?} {i} {g} {slope}");
            }
        }
    }

    #[test]
    fn partials_are_those_of_the_formula() {
        let point = [0.7, -1.3];
        let entries: [Dual<9>; 9] = core::array::from_fn(|k| Dual::variable(H[k], k));
        let [u, v, w] = homogeneous(&entries, point.map(|c| Dual { value: c, gradient: [0.0; 9] }));
        let ([image_u, image_v], partials) = transfer(&SVector::from(H), point).unwrap();
        for (row, (value, dual)) in [(image_u, u / w), (image_v, v / w)].into_iter().enumerate() {
            assert!((value - dual.value).abs() < 1e-15);
            for k in 0..9 {
                assert!((partials[(row, k)] - dual.gradient[k]).abs() < 1e-15);
            }
        }
    }
}
