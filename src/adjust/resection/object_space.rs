//! Poses without initial values: the least object-space error, every minimum of it.
//!
//! The squared distances of the points from their lines of sight sum to a quadratic form of the rotation:
//!
//! ```text
//! eᵢ = Vᵢ (R Xᵢ + t),   Vᵢ = I − fᵢ fᵢᵀ                       (Lu, Hager & Mjolsness 2000)
//! t = −(Σ wᵢ Vᵢ)⁻¹ Σ wᵢ Vᵢ R Xᵢ                               the best t of a given R
//! Σ wᵢ ‖eᵢ‖² = rᵀ Ω r,   r = vec R                              (Schweighofer & Pinz 2008; Terzakis & Lourakis 2020)
//! ```
//!
//! Ω is summed once; what follows costs the same for 6 points and for 100,000. On the rotations the form has few minima, two
//! for a plane seen from afar. Newton's descents from the 24 rotations that turn a cube into itself, none farther than
//! 63° from any rotation, find them.

use alloc::vec::Vec;

use nalgebra::{Matrix3, SMatrix, Vector3};

type Nine = [f64; 9];

/// Ω, and t as a linear function of r.
#[derive(Clone, Debug)]
pub(super) struct ObjectSpace {
    omega: [Nine; 9],
    translation: SMatrix<f64, 3, 9>,
}

/// A minimum of rᵀΩr on the rotations.
#[derive(Clone, Copy, Debug)]
pub(super) struct Minimum {
    pub(super) rotation: Matrix3<f64>,
    pub(super) error: f64,
}

/// Σ wV of lines of sight that are one is singular but for rounding: its least eigenvalue over the sum of the weights.
pub(super) const LEAST_SPREAD: f64 = 16.0 * f64::EPSILON;
/// Minima closer than this are one.
const SAME: f64 = 0.03;
/// A descent ends after a step as short, Newton's next being its square, if it brought no more than a part of the error: points near
/// a line leave a long flat valley.
const SHORT: f64 = 1e-3;
const FLAT: f64 = 1e-3;
/// No step turns farther than 70°, squared.
const FARTHEST: f64 = 1.5;

impl ObjectSpace {
    /// From points about their centre and unit directions with weights.
    ///
    /// # Errors
    /// How little the directions differ, where it is not more than [`LEAST_SPREAD`].
    pub(super) fn new(
        points: impl Iterator<Item = (Vector3<f64>, Vector3<f64>, f64)>,
    ) -> Result<Self, f64> {
        // Of V ⊗ X Xᵀ only the six different elements of either factor: 36 sums.
        let mut products = [[0.0; 6]; 6];
        let mut across = [[0.0; 3]; 6];
        let mut sum = [0.0; 6];
        for (x, f, w) in points {
            let xx = [x.x * x.x, x.x * x.y, x.x * x.z, x.y * x.y, x.y * x.z, x.z * x.z];
            let (a, b, c) = (w * f.x, w * f.y, w * f.z);
            let v = [w - a * f.x, -a * f.y, -a * f.z, w - b * f.y, -b * f.z, w - c * f.z];
            for i in 0..6 {
                for j in 0..6 {
                    products[i][j] += v[i] * xx[j];
                }
                for j in 0..3 {
                    across[i][j] += v[i] * x[j];
                }
                sum[i] += v[i];
            }
        }
        const AT: [[usize; 3]; 3] = [[0, 1, 2], [1, 3, 4], [2, 4, 5]];
        let sum = Matrix3::from_fn(|i, j| sum[AT[i][j]]);
        // λ₁λ₂λ₃ over λ₁λ₂ + λ₁λ₃ + λ₂λ₃, of which the least is small, over half the trace, λ₁ + λ₂ + λ₃ = 2 Σ w.
        let (trace, squares) = (sum.trace(), sum.norm_squared());
        let spread = sum.determinant() / (0.25 * trace * (trace * trace - squares));
        let inverse = if spread > LEAST_SPREAD { sum.try_inverse() } else { None };
        let inverse = inverse.ok_or(if spread > 0.0 { spread } else { 0.0 })?;
        let linear = SMatrix::<f64, 3, 9>::from_fn(|i, k| across[AT[i][k / 3]][k % 3]);
        let translation = -(inverse * linear);
        let omega = core::array::from_fn(|k| {
            core::array::from_fn(|l| {
                let eliminated: f64 = (0..3).map(|i| linear[(i, k)] * translation[(i, l)]).sum();
                products[AT[k / 3][l / 3]][AT[k % 3][l % 3]] + eliminated
            })
        });
        let finite = omega.iter().flatten().all(|v: &f64| v.is_finite());
        if finite { Ok(Self { omega, translation }) } else { Err(0.0) }
    }

    /// t of a rotation: the centre of the points in camera axes.
    pub(super) fn translation(&self, rotation: &Matrix3<f64>) -> Vector3<f64> {
        self.translation * SMatrix::<f64, 9, 1>::from(elements(rotation))
    }

    /// The minima, least first.
    pub(super) fn minima(&self) -> Vec<Minimum> {
        let mut found: Vec<Minimum> = Vec::new();
        for start in cube_rotations() {
            if let Some(minimum) = self.descend(&start, &found) {
                found.push(minimum);
            }
        }
        found.sort_by(|a, b| a.error.total_cmp(&b.error));
        found
    }

    #[inline]
    fn times(&self, r: &Nine) -> Nine {
        // Ω is symmetric: sums of its rows, which a processor adds several at a time.
        let mut y = [0.0; 9];
        for (row, r) in self.omega.iter().zip(r) {
            for (y, o) in y.iter_mut().zip(row) {
                *y += o * r;
            }
        }
        y
    }

    /// Newton's descent from a rotation, by turns about the present one; `None` where it comes to a minimum that is known.
    ///
    /// ```text
    /// y = Ω r,  Y its rows,  B = R Yᵀ:   ½ gₖ = tr(B [eₖ]×),   ½ H = GᵀΩG + sym B − tr(B) I,   Gₖ = vec([eₖ]× R)
    /// ```
    pub(super) fn descend(&self, start: &Matrix3<f64>, known: &[Minimum]) -> Option<Minimum> {
        let mut rotation = *start;
        let mut y = self.times(&elements(&rotation));
        let mut error = dot(&elements(&rotation), &y);
        let mut shift = 0.0;
        for _ in 0..30 {
            if known.iter().any(|m| (m.rotation - rotation).norm_squared() < SAME * SAME) {
                return None;
            }
            let b = rotation * Matrix3::from_row_slice(&y).transpose();
            let gradient = [b.m23 - b.m32, b.m31 - b.m13, b.m12 - b.m21];
            let turns = turns(&rotation);
            let curved = [self.times(&turns[0]), self.times(&turns[1]), self.times(&turns[2])];
            let trace = b.trace();
            let mut hessian = [[0.0; 3]; 3];
            for i in 0..3 {
                for j in i..3 {
                    hessian[i][j] = dot(&turns[i], &curved[j]) + 0.5 * (b[(i, j)] + b[(j, i)]);
                }
                hessian[i][i] -= trace;
            }
            let size = (0..3).map(|i| hessian[i][i].abs()).fold(0.0, f64::max);
            let mut moved = false;
            for _ in 0..30 {
                let mut damped = hessian;
                for i in 0..3 {
                    damped[i][i] += shift * size;
                }
                let short = solve(&damped, &gradient).filter(|s| s.norm_squared() < FARTHEST);
                if let Some(short) = short {
                    let turned = turned(&short) * rotation;
                    let next = elements(&turned);
                    let next_y = self.times(&next);
                    let next_error = dot(&next, &next_y);
                    if next_error <= error {
                        let last = short.norm_squared() < SHORT * SHORT;
                        moved = !last || error - next_error > FLAT * error;
                        (rotation, y, error) = (turned, next_y, next_error);
                        shift = if shift > 1e-2 { shift * 0.2 } else { 0.0 };
                        break;
                    }
                    if short.norm_squared() < SHORT * SHORT {
                        break;
                    }
                }
                shift = (shift * 3.0).max(0.1);
            }
            if !moved {
                break;
            }
        }
        Some(Minimum { rotation, error })
    }
}

/// The 24 rotations of a cube.
fn cube_rotations() -> impl Iterator<Item = Matrix3<f64>> {
    const ORDERS: [([usize; 3], bool); 6] = [
        ([0, 1, 2], true),
        ([1, 2, 0], true),
        ([2, 0, 1], true),
        ([0, 2, 1], false),
        ([1, 0, 2], false),
        ([2, 1, 0], false),
    ];
    ORDERS.into_iter().flat_map(|(order, even)| {
        (0..4).map(move |signs| {
            let first = if signs & 1 == 0 { 1.0 } else { -1.0 };
            let second = if signs & 2 == 0 { 1.0 } else { -1.0 };
            let third = first * second * if even { 1.0 } else { -1.0 };
            let mut m = Matrix3::zeros();
            for (i, sign) in [first, second, third].into_iter().enumerate() {
                m[(i, order[i])] = sign;
            }
            m
        })
    })
}

/// G: the change of r with a turn about each axis, vec([eₖ]× R).
#[inline]
fn turns(r: &Matrix3<f64>) -> [Nine; 3] {
    let [a, b, c] = [0, 1, 2].map(|i| [r[(i, 0)], r[(i, 1)], r[(i, 2)]]);
    let zero = [0.0; 3];
    let negative = |v: [f64; 3]| v.map(|e| -e);
    [join([zero, negative(c), b]), join([c, zero, negative(a)]), join([negative(b), a, zero])]
}

#[inline]
fn join([a, b, c]: [[f64; 3]; 3]) -> Nine {
    [a[0], a[1], a[2], b[0], b[1], b[2], c[0], c[1], c[2]]
}

/// The elements row by row.
#[inline]
fn elements(m: &Matrix3<f64>) -> Nine {
    join([0, 1, 2].map(|i| [m[(i, 0)], m[(i, 1)], m[(i, 2)]]))
}

#[inline]
fn dot(a: &Nine, b: &Nine) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// −H⁻¹ g of a positive definite H, by its adjugate; `None` where a leading minor is not positive.
#[inline]
fn solve(h: &[[f64; 3]; 3], g: &[f64; 3]) -> Option<Vector3<f64>> {
    let [[a, b, c], [_, d, e], [_, _, f]] = *h;
    let (aa, ab, ac) = (d * f - e * e, c * e - b * f, b * e - c * d);
    let (bb, bc, cc) = (a * f - c * c, b * c - a * e, a * d - b * b);
    let determinant = a * aa + b * ab + c * ac;
    let [x, y, z] = *g;
    let product =
        Vector3::new(aa * x + ab * y + ac * z, ab * x + bb * y + bc * z, ac * x + bc * y + cc * z);
    (a > 0.0 && cc > 0.0 && determinant > 0.0).then(|| product / -determinant)
}

/// The rotation of Cayley (1846), which is exp([δ]×) to the third order, without a sine.
#[inline]
fn turned(step: &Vector3<f64>) -> Matrix3<f64> {
    let half = step * 0.5;
    let scale = 2.0 / (1.0 + half.norm_squared());
    let cross = half.cross_matrix();
    Matrix3::identity() + (cross + cross * cross) * scale
}
