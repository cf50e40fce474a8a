//! Thin-plate splines.

use alloc::vec::Vec;

use nalgebra::{DMatrix, DVector, Matrix2, Point2, Vector2, Vector3};

use super::{Map, control};
use crate::error::{Error, ProjectionError};
use crate::geometry::Affine2;
use crate::numeric::float;

/// The thin-plate spline through control points, or near them (Duchon 1977; Bookstein 1989).
///
/// ```text
/// u(p) = a₀ + a₁S + a₂L + Σ wᵢ φ(‖p − pᵢ‖),   φ(r) = r² ln r,   Σ wᵢ = Σ wᵢ Sᵢ = Σ wᵢ Lᵢ = 0
/// minimise Σ (uᵢ − u(pᵢ))² + λ/(8π) ∬ (∂²u/∂S²)² + 2 (∂²u/∂S∂L)² + (∂²u/∂L²)²  dS dL
/// ```
///
/// v likewise. With λ = 0 the map passes through the points and bends as little as a metal plate would; a large λ makes it
/// the affine map of least squares. λ is in squared pixels of the screen and is that of scipy's
/// `RBFInterpolator(kernel="thin_plate_spline", smoothing=λ)`.
///
/// *Domain.* The whole screen; far outside the points it tends to an affine map. Nothing keeps it from folding. *Smoothness.*
/// C¹ at the points and C^∞ elsewhere. *Cost.* n³/3 operations and 8n² bytes to fit n points; a logarithm a point for every pixel: lay an
/// [`Approximated`](super::Approximated) over it for whole pictures.
///
/// *Accuracy.* Points are taken relative to their centre and extent, so coordinates of 10⁶ lose only their own digits.
/// What is solved is positive definite; its condition grows as the fourth power of the extent over the least distance.
///
/// # Example
/// A square whose corners on one diagonal go down and those on the other up, with the value of mpmath (40 digits):
///
/// ```
/// use collinear::mapping::{Map, ThinPlate};
/// use nalgebra::Point2;
///
/// let points = |c: [(f64, f64); 4]| c.map(|(x, y)| Point2::new(x, y));
/// let screen = points([(0., 1.), (-1., 0.), (0., -1.), (1., 0.)]);
/// let texture = points([(0., 0.75), (-1., 0.25), (0., -1.25), (1., 0.25)]);
/// let map = ThinPlate::fit(&screen, &texture, 0.0)?;
/// assert!((map.at(&screen[2])? - texture[2]).norm() < 1e-15);
/// assert!((map.at(&Point2::new(0.5, 0.25))? - Point2::new(0.5, 0.3100478508131803)).norm() < 1e-15);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
#[doc(alias("RBFInterpolator", "ThinPlateSplineShapeTransformer", "TPS", "rubber sheet"))]
pub struct ThinPlate {
    centre: Point2<f64>,
    /// One over the unit of length inside.
    scale: f64,
    /// The points inside.
    nodes: Vec<Point2<f64>>,
    weights: Vec<Vector2<f64>>,
    /// The polynomial of inside coordinates.
    affine: Affine2,
}

/// r² ln r of a squared distance.
#[inline(always)]
fn kernel(square: f64) -> f64 {
    if square > 0.0 { 0.5 * square * float::ln(square) } else { 0.0 }
}

/// The least share of its size that a column or a pivot must keep in the elimination.
const DEGENERATE: f64 = 1e-13;

impl ThinPlate {
    /// The spline of control points with the smoothing λ.
    ///
    /// # Errors
    /// [`Error::LengthMismatch`], [`Error::TooFewPoints`] below three, [`Error::NotFinite`]; [`Error::OutOfRange`] for a λ that is
    /// negative or infinite; [`Error::Degenerate`] where the screen points lie on one line, or two of them coincide while λ is
    /// zero (the measure is a pivot over its size before elimination).
    pub fn fit(
        screen: &[Point2<f64>],
        texture: &[Point2<f64>],
        smoothing: f64,
    ) -> Result<Self, Error> {
        control::check(screen, texture, 3)?;
        if !(smoothing >= 0.0 && smoothing.is_finite()) {
            return Err(Error::OutOfRange {
                what: "smoothing of a thin plate",
                value: smoothing,
                expected: "zero or more",
            });
        }
        let n = screen.len();
        let [centre, offset] = [screen, texture].map(control::centre);
        let extent = screen.iter().map(|p| (p - centre).amax()).fold(0.0, f64::max);
        let scale = 1.0 / extent;
        let degenerate = |what, measure| Error::Degenerate { what, measure, limit: DEGENERATE };
        const ON_A_LINE: &str = "thin plate: control points on one line";
        if !(scale > 0.0 && scale.is_finite()) {
            return Err(degenerate(ON_A_LINE, 0.0));
        }
        let nodes: Vec<Point2<f64>> =
            screen.iter().map(|p| Point2::from((p - centre) * scale)).collect();

        // The weights lie in the space that no linear function sees: Householder reflections Q turn the columns 1, S, L
        // into the first three axes, and what is left of Q K Q is positive definite.
        let mut columns = DMatrix::from_fn(n, 3, |i, k| [1.0, nodes[i].x, nodes[i].y][k]);
        let mut matrix =
            DMatrix::from_fn(n, n, |i, j| kernel((nodes[i] - nodes[j]).norm_squared()));
        for i in 0..n {
            matrix[(i, i)] += smoothing * scale * scale;
        }
        let values: Vec<Vector2<f64>> = texture.iter().map(|t| t - offset).collect();
        let mut data = DMatrix::from_fn(n, 2, |i, k| values[i][k]);
        let mut reflectors: Vec<DVector<f64>> = Vec::new();
        let sizes: Vec<f64> = columns.column_iter().map(|c| c.norm()).collect();
        for k in 0..3 {
            let mut h = DVector::zeros(n);
            h.rows_mut(k, n - k).copy_from(&columns.view((k, k), (n - k, 1)));
            let length = h.norm();
            let measure = length / sizes[k];
            if !(measure > DEGENERATE) {
                return Err(degenerate(ON_A_LINE, measure));
            }
            h[k] += if h[k] < 0.0 { -length } else { length };
            h /= h.norm();
            reflect(&h, &mut columns);
            reflect(&h, &mut data);
            reflect(&h, &mut matrix);
            // From the right as well; the matrix is symmetric.
            matrix.transpose_mut();
            reflect(&h, &mut matrix);
            reflectors.push(h);
        }

        let rest = n - 3;
        let mut weights = DMatrix::<f64>::zeros(n, 2);
        if rest > 0 {
            let block = matrix.view((3, 3), (rest, rest)).into_owned();
            let diagonal = block.diagonal();
            let factor = block
                .cholesky()
                .ok_or(degenerate("thin plate: control points that coincide", 0.0))?;
            let pivot = (0..rest)
                .map(|i| factor.l_dirty()[(i, i)] * factor.l_dirty()[(i, i)] / diagonal[i])
                .fold(f64::INFINITY, f64::min);
            if !(pivot > DEGENERATE) {
                return Err(degenerate("thin plate: control points that coincide", pivot));
            }
            let solution = factor.solve(&data.view((3, 0), (rest, 2)).into_owned());
            weights.view_mut((3, 0), (rest, 2)).copy_from(&solution);
        }
        // R (a₀, a₁, a₂) = the first rows of Q (values − K w).
        let bent = &matrix * &weights;
        let mut affine = [[0.0; 3]; 2];
        for (c, row) in affine.iter_mut().enumerate() {
            let mut solution = Vector3::zeros();
            for i in (0..3).rev() {
                let known: f64 = (i + 1..3).map(|j| columns[(i, j)] * solution[j]).sum();
                solution[i] = (data[(i, c)] - bent[(i, c)] - known) / columns[(i, i)];
            }
            *row = solution.into();
        }
        for h in reflectors.iter().rev() {
            reflect(h, &mut weights);
        }
        let mut affine = Affine2::from_coefficients(affine[0], affine[1]);
        affine.translation += offset.coords;
        let weights: Vec<Vector2<f64>> =
            (0..n).map(|i| Vector2::new(weights[(i, 0)], weights[(i, 1)])).collect();
        let mut finite = weights.iter().flat_map(|w| w.iter()).chain(affine.linear.iter());
        if !finite.all(|c| c.is_finite()) {
            return Err(Error::NotFinite { what: "coefficient of a thin plate" });
        }
        Ok(Self { centre, scale, nodes, weights, affine })
    }

    /// The number of control points.
    #[must_use]
    #[allow(clippy::len_without_is_empty, reason = "there are three at least")]
    pub fn len(&self) -> usize {
        self.nodes.len()
    }

    /// The affine part: what is left where the weights vanish, as in a large λ.
    #[must_use]
    pub fn affine(&self) -> Affine2 {
        let linear = self.affine.linear * self.scale;
        Affine2 { linear, translation: self.affine.translation - linear * self.centre.coords }
    }

    fn inside(&self, screen: &Point2<f64>) -> Point2<f64> {
        Point2::from((screen - self.centre) * self.scale)
    }
}

/// (I − 2 h hᵀ) M.
fn reflect(h: &DVector<f64>, m: &mut DMatrix<f64>) {
    let along = m.tr_mul(h);
    m.ger(-2.0, h, &along, 1.0);
}

impl Map for ThinPlate {
    fn at(&self, screen: &Point2<f64>) -> Result<Point2<f64>, ProjectionError> {
        let p = self.inside(screen);
        let mut sum = Vector2::zeros();
        for (node, weight) in self.nodes.iter().zip(&self.weights) {
            sum += weight * kernel((p - node).norm_squared());
        }
        let q = self.affine.apply(&p) + sum;
        if q.x.is_finite() && q.y.is_finite() { Ok(q) } else { Err(ProjectionError::NotFinite) }
    }

    fn jacobian(&self, screen: &Point2<f64>) -> Result<Matrix2<f64>, ProjectionError> {
        let p = self.inside(screen);
        let mut sum = self.affine.linear;
        for (node, weight) in self.nodes.iter().zip(&self.weights) {
            let d = p - node;
            let square = d.norm_squared();
            if square > 0.0 {
                // ∇ r² ln r = d (ln r² + 1).
                sum += weight * d.transpose() * (float::ln(square) + 1.0);
            }
        }
        let jacobian = sum * self.scale;
        let finite = jacobian.iter().all(|c| c.is_finite());
        if finite { Ok(jacobian) } else { Err(ProjectionError::NotFinite) }
    }
}
