//! Absolute orientation: the similarity that brings a model onto the ground.

use alloc::vec::Vec;

use nalgebra::{Matrix3, Point3, Rotation3, SMatrix, SVector, Vector3};

use super::precision::{Precision, Weighting};
use super::report::{self, Report};
use super::settle::minimise_to_rounding;
use crate::error::Error;
use crate::geometry::Similarity;
use crate::geometry::rotation::{RotationVector, orthonormalised};
use crate::numeric::least_squares::{
    Convergence, Damped, LeastSquaresOptions, NormalEquations, Problem, unit_weight,
};
use crate::numeric::triangular::Triangular;

/// A place known in the frame of a model and in that of the ground.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PointPair {
    /// In the model, free of error.
    pub from: Point3<f64>,
    /// On the ground.
    pub to: Point3<f64>,
    /// How good the place on the ground is, in its units; σ = 1 unless said otherwise.
    pub precision: Precision<3>,
}

impl PointPair {
    /// A pair with σ = 1 on the ground.
    #[must_use]
    pub fn new(from: Point3<f64>, to: Point3<f64>) -> Self {
        Self { from, to, precision: Precision::default() }
    }

    /// With another precision of the place on the ground. Where both are uncertain, with σ and σ′, take √(σ² + s² σ′²).
    #[must_use]
    pub fn with_precision(mut self, precision: Precision<3>) -> Self {
        self.precision = precision;
        self
    }
}

/// How to orient.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AbsoluteOrientationOptions {
    /// The scale where it is known, as 1 for a rigid motion; `None` estimates it.
    pub scale: Option<f64>,
    /// Whether covariances and tests use the σ₀ found, or believe the stated precisions.
    pub estimate_sigma: bool,
    /// When to stop, where precisions have a direction; else nothing is iterated.
    pub least_squares: LeastSquaresOptions,
}

impl Default for AbsoluteOrientationOptions {
    fn default() -> Self {
        Self { scale: None, estimate_sigma: true, least_squares: LeastSquaresOptions::default() }
    }
}

/// A similarity found from points, with its report.
#[derive(Clone, Debug)]
pub struct AbsoluteOrientation {
    /// The map, ground from model. Its places are the weighted centroid of the model and where that goes.
    pub similarity: Similarity,
    /// How good it is. The parameters are the scale s (unless it was held), the left rotation vector δ of R ← exp(\[δ\]×) R in
    /// radians, and the ground coordinates of the centroid; the values are X, Y, Z of each pair.
    pub report: Report,
}

impl AbsoluteOrientation {
    /// The covariance of a model point brought to the ground, in squared units of the ground.
    #[must_use]
    #[allow(clippy::wrong_self_convention, reason = "`from` is the frame")]
    pub fn covariance_at(&self, from: &Point3<f64>) -> Matrix3<f64> {
        let rows = partials(&self.similarity, from);
        let n = self.report.covariance.nrows();
        let skip = 7 - n.min(7);
        Matrix3::from_fn(|i, j| {
            let mut sum = 0.0;
            for k in 0..n {
                for l in 0..n {
                    sum +=
                        rows[(i, k + skip)] * self.report.covariance[(k, l)] * rows[(j, l + skip)];
                }
            }
            sum
        })
    }
}

/// The similarity that brings n ≥ 3 points of a model onto their places on the ground: absolute orientation.
///
/// *Model.*
/// ```text
/// minimise Σ vᵢᵀ Pᵢ vᵢ ,   vᵢ = toᵢ − (T + s R fromᵢ)
///
/// H = Σ w (to − t̄)(from − f̄)ᵀ = U Σ Vᵀ      R = U diag(1, 1, det U det V) Vᵀ      s = tr(Rᵀ H) / Σ w |from − f̄|²
/// ```
/// The closed form (Horn 1987; Umeyama 1991, whose sign keeps R a rotation for points that noise has mirrored) is the minimum where every
/// precision is the same in all directions. Where one is not, as heights better than positions, it is the start of an iteration.
///
/// *Frames and units.* Everything is relative to the weighted centroids: coordinates of 10⁶ lose nothing. The scale is in units of the
/// ground per unit of the model.
///
/// # Errors
/// [`Error::TooFewPoints`], [`Error::NotFinite`]; [`Error::OutOfRange`] for a precision or a held scale that is not positive;
/// [`Error::Degenerate`] where the points of either frame lie on a line (the measure is (σ₂ ± σ₃)/σ₁ of the singular values of H), so that
/// the rotation about it is open, or coincide.
///
/// # Example
/// The sample data of the program 3DCONF (Dewitt 1998, for Wolf & Dewitt, Elements of Photogrammetry): six common points. The expected numbers
/// are those of SciPy's `least_squares` on the same model.
/// ```
/// use collinear::adjust::{AbsoluteOrientationOptions, PointPair, absolute_orientation};
/// use collinear::nalgebra::Point3;
///
/// let pairs = [
///     ([390.35, 499.63, 469.43], [607.54, 501.63, 469.09]),
///     ([371.68, 630.84, 81.25], [589.98, 632.36, 82.81]),
///     ([425.65, 419.07, 82.49], [643.65, 421.28, 83.50]),
///     ([410.50, 438.31, 81.13], [628.58, 440.51, 82.27]),
///     ([448.22, 295.83, 97.79], [666.27, 298.16, 98.29]),
///     ([414.60, 709.39, 101.77], [632.59, 710.62, 103.01]),
/// ]
/// .map(|(from, to)| PointPair::new(Point3::from(from), Point3::from(to)));
/// let found = absolute_orientation(&pairs, &AbsoluteOrientationOptions::default())?;
/// assert!((found.similarity.scale() - 0.9967398632496934).abs() < 1e-12);
/// assert!((found.report.sigma0.unwrap() - 0.2475493565535956).abs() < 1e-12);
/// let first = found.similarity.apply(&Point3::new(611.37, 498.98, 470.45));
/// assert!((first - Point3::new(827.9191442263407, 500.59468862762225, 470.7249166828609)).norm() < 1e-9);
/// # Ok::<(), collinear::Error>(())
/// ```
#[doc(alias(
    "Umeyama",
    "Horn",
    "Sim3",
    "seven-parameter",
    "Helmert",
    "Procrustes",
    "3D conformal"
))]
pub fn absolute_orientation(
    pairs: &[PointPair],
    options: &AbsoluteOrientationOptions,
) -> Result<AbsoluteOrientation, Error> {
    if pairs.len() < 3 {
        return Err(Error::TooFewPoints { needed: 3, got: pairs.len() });
    }
    let finite = |p: &Point3<f64>| p.iter().all(|c| c.is_finite());
    if !pairs.iter().all(|p| finite(&p.from) && finite(&p.to)) {
        return Err(Error::NotFinite { what: "point pair" });
    }
    let pairs = pairs.iter().map(Weighted::new).collect::<Result<Vec<_>, _>>()?;
    if let Some(value) = options.scale.filter(|s| !(*s > 0.0 && s.is_finite())) {
        let what = "held scale";
        return Err(Error::OutOfRange { what, value, expected: "a positive number" });
    }
    let start = closed_form(&pairs, options.scale)?;
    if options.scale.is_some() {
        Adjustment::<6> { pairs: &pairs }.finish(start, options)
    } else {
        Adjustment::<7> { pairs: &pairs }.finish(start, options)
    }
}

/// A pair with its weight.
struct Weighted {
    from: Point3<f64>,
    to: Point3<f64>,
    weighting: Weighting<3>,
}

impl Weighted {
    fn new(pair: &PointPair) -> Result<Self, Error> {
        let weighting = Weighting::new(&pair.precision, "weight of a point pair")?;
        Ok(Self { from: pair.from, to: pair.to, weighting })
    }

    /// A weight without direction: the mean variance's.
    fn scalar(&self) -> f64 {
        3.0 / self.weighting.covariance.trace()
    }

    fn is_isotropic(&self) -> bool {
        let c = &self.weighting.covariance;
        *c == Matrix3::from_diagonal_element(c.m11)
    }
}

/// The weighted centroid about the first point, and the largest distance from it along an axis.
fn centroid(
    pairs: &[Weighted],
    largest_weight: f64,
    place: impl Fn(&Weighted) -> Point3<f64>,
) -> (Point3<f64>, f64) {
    let first = place(&pairs[0]);
    let (mut sum, mut weights) = (Vector3::zeros(), 0.0);
    for pair in pairs {
        let w = pair.scalar() / largest_weight;
        sum += (place(pair) - first) * w;
        weights += w;
    }
    let mean = first + sum / weights;
    let extent = pairs.iter().map(|p| (place(p) - mean).amax()).fold(0.0, f64::max);
    (mean, extent)
}

fn closed_form(pairs: &[Weighted], held: Option<f64>) -> Result<Similarity, Error> {
    let largest_weight = pairs.iter().map(Weighted::scalar).fold(0.0, f64::max);
    let (from, from_extent) = centroid(pairs, largest_weight, |p| p.from);
    let (to, to_extent) = centroid(pairs, largest_weight, |p| p.to);
    let what = "point pairs on a line";
    if !(from_extent > 0.0 && to_extent > 0.0) {
        return Err(Error::Degenerate { what, measure: 0.0, limit: 16.0 * f64::EPSILON });
    }
    // Extents of one in both frames.
    let (mut h, mut squares) = (Matrix3::zeros(), 0.0);
    for pair in pairs {
        let w = pair.scalar() / largest_weight;
        let f = (pair.from - from) / from_extent;
        h += (pair.to - to) / to_extent * f.transpose() * w;
        squares += w * f.norm_squared();
    }
    let mut triangle = Triangular::<3>::new();
    for i in 0..3 {
        triangle.add_row([h[(i, 0)], h[(i, 1)], h[(i, 2)]]);
    }
    let (singular, v) = triangle.singular();
    let sign = 1f64.copysign(h.determinant());
    let measure = (singular[1] + sign * singular[2]) / singular[0];
    let largest = from.coords.amax() / from_extent + to.coords.amax() / to_extent;
    let limit = f64::EPSILON * (16.0 + 4.0 * largest);
    if !(measure > limit) {
        let measure = if measure > 0.0 { measure } else { 0.0 };
        return Err(Error::Degenerate { what, measure, limit });
    }
    // Right-handed axes in both frames: where H mirrors, the third pair of singular vectors has the other sign.
    let (v1, v2) = (v.column(0).into_owned(), v.column(1).into_owned());
    let u1 = (h * v1).normalize();
    let across = h * v2;
    let u2 = (across - u1 * u1.dot(&across)).normalize();
    let left = Matrix3::from_columns(&[u1, u2, u1.cross(&u2)]);
    let right = Matrix3::from_columns(&[v1, v2, v1.cross(&v2)]);
    let rotation = orthonormalised(&(left * right.transpose()))?;
    let free = rotation.matrix().dot(&h) / squares * (to_extent / from_extent);
    Similarity::new(held.unwrap_or(free), rotation, from, to)
}

/// ∂(X, Y, Z)/∂(s, δ, centroid).
fn partials(map: &Similarity, from: &Point3<f64>) -> SMatrix<f64, 3, 7> {
    let turned = map.rotation() * (from - map.places().0);
    let mut rows = SMatrix::<f64, 3, 7>::zeros();
    rows.set_column(0, &turned);
    let by_turn = -(turned * map.scale()).cross_matrix();
    rows.fixed_view_mut::<3, 3>(0, 1).copy_from(&by_turn);
    rows.fixed_view_mut::<3, 3>(0, 4).copy_from(&Matrix3::identity());
    rows
}

/// The least-squares problem of N = 7 unknowns, or of the last six of them.
struct Adjustment<'a, const N: usize> {
    pairs: &'a [Weighted],
}

impl<const N: usize> Adjustment<'_, N> {
    /// The rows of the unknowns that are estimated.
    fn rows(map: &Similarity, pair: &Weighted) -> SMatrix<f64, 3, N> {
        let all = partials(map, &pair.from);
        SMatrix::from_fn(|i, j| all[(i, j + 7 - N)])
    }

    fn finish(
        &self,
        start: Similarity,
        options: &AbsoluteOrientationOptions,
    ) -> Result<AbsoluteOrientation, Error> {
        let (similarity, convergence) = if self.pairs.iter().all(Weighted::is_isotropic) {
            let cost = self.cost(&start);
            let mut linear = NormalEquations::<N>::default();
            let gradient = self.linearise(&start, &mut linear);
            (start, Convergence::without_iteration(cost, gradient))
        } else {
            let mut linear = NormalEquations::<N>::default();
            minimise_to_rounding(self, start, &mut linear, &options.least_squares)
        };
        let report = self.report(&similarity, options.estimate_sigma, convergence)?;
        Ok(AbsoluteOrientation { similarity, report })
    }

    fn report(
        &self,
        map: &Similarity,
        estimate_sigma: bool,
        convergence: Convergence,
    ) -> Result<Report, Error> {
        let mut normal = SMatrix::<f64, N, N>::zeros();
        for pair in self.pairs {
            let rows = Self::rows(map, pair);
            normal += rows.transpose() * pair.weighting.weight * rows;
        }
        let (q, condition) = report::fixed_cofactor(&normal)?;
        let residual = |pair: &Weighted| pair.to - map.apply(&pair.from);
        let weighted_sum: f64 = self
            .pairs
            .iter()
            .map(|pair| {
                let v = residual(pair);
                v.dot(&(pair.weighting.weight * v))
            })
            .sum();
        let observations = 3 * self.pairs.len();
        let redundancy = observations - N;
        let sigma0 = unit_weight(weighted_sum, redundancy);
        let sigma = report::sigma(sigma0, estimate_sigma);
        let mut values = Vec::with_capacity(observations);
        for pair in self.pairs {
            let rows = Self::rows(map, pair);
            let unexplained = pair.weighting.covariance - rows * q * rows.transpose();
            let v = residual(pair);
            values.extend(report::observed(&unexplained, &pair.weighting.covariance, &v, sigma));
        }
        Ok(Report {
            observations,
            unknowns: N,
            redundancy,
            weighted_sum,
            sigma0,
            sigma,
            covariance: report::covariance(&q, sigma),
            condition,
            values,
            convergence,
        })
    }
}

impl<const N: usize> Problem for Adjustment<'_, N> {
    type State = Similarity;
    type Linear = NormalEquations<N>;
    type Step = SVector<f64, N>;

    fn cost(&self, map: &Similarity) -> f64 {
        let squared = |pair: &Weighted| {
            (pair.weighting.root * (pair.to - map.apply(&pair.from))).norm_squared()
        };
        0.5 * self.pairs.iter().map(squared).sum::<f64>()
    }

    fn linearise(&self, map: &Similarity, linear: &mut NormalEquations<N>) -> f64 {
        linear.clear();
        for pair in self.pairs {
            let rows = pair.weighting.root * Self::rows(map, pair);
            let v = pair.weighting.root * (pair.to - map.apply(&pair.from));
            for i in 0..3 {
                linear.add(&rows.row(i).transpose(), -v[i], 1.0);
            }
        }
        linear.scaled_gradient()
    }

    fn solve(
        &self,
        map: &Similarity,
        linear: &NormalEquations<N>,
        damping: f64,
    ) -> Option<Damped<SVector<f64, N>>> {
        let (from, _) = map.places();
        let extent = self.pairs.iter().map(|p| (p.from - from).amax()).fold(0.0, f64::max);
        let all = [map.scale(), 1.0, 1.0, 1.0, map.scale() * extent];
        linear.solve(damping, &SVector::from_fn(|i, _| all[(i + 7 - N).min(4)]))
    }

    fn apply(&self, map: &Similarity, step: &SVector<f64, N>) -> Similarity {
        let at = |i: usize| if i + N < 7 { 0.0 } else { step[i + N - 7] };
        let turn = RotationVector { x: at(1), y: at(2), z: at(3) }.rotation();
        let product = turn.matrix() * map.rotation().matrix();
        let rotation = orthonormalised(&product).unwrap_or(Rotation3::identity());
        let (from, to) = map.places();
        let moved = to + Vector3::new(at(4), at(5), at(6));
        // A step beyond a scale of zero has a cost that is refused.
        Similarity::new(map.scale() + at(0), rotation, from, moved).unwrap_or(*map)
    }
}
