//! Homographies from n points by least squares.

use alloc::vec::Vec;

use nalgebra::{Matrix2, Matrix3, Point2, SMatrix, SVector, Vector2};

use super::{Homography, homogeneous, unit_power};
use crate::error::{Error, ProjectionError};
use crate::numeric::float;
use crate::numeric::least_squares::{
    Convergence, Damped, LeastSquaresOptions, NormalEquations, Problem, minimise,
};
use crate::numeric::robust_loss::RobustLoss;
use crate::numeric::triangular::Triangular;

/// Which distances a fit makes small.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum TransferCost {
    /// Σ ‖x′ − H x‖², in the image: the object points are taken as free of error.
    #[default]
    Image,
    /// Σ ‖x′ − H x‖² + ‖x − H⁻¹ x′‖², for two images measured alike: both in pixels.
    Symmetric,
}

/// How to fit.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub struct FitOptions {
    /// Which distances are made small.
    pub cost: TransferCost,
    /// How each point's distance enters; its scale is in pixels of the image (of either image, for the symmetric cost).
    pub loss: RobustLoss,
    /// When to stop.
    pub least_squares: LeastSquaresOptions,
}

/// A fitted homography with its report.
#[derive(Clone, Debug)]
pub struct HomographyFit {
    /// The map, image from object.
    pub homography: Homography,
    /// Image point minus mapped object point, for each pair, in pixels.
    pub residuals: Vec<Vector2<f64>>,
    /// √(Σ w ‖v‖² / (2n − 8)) over the n points of positive weight: the standard deviation of an image coordinate of
    /// unit weight. `None` for four points.
    pub sigma0: Option<f64>,
    /// How the refinement ended; its cost is half the weighted sum of losses, in squared pixels.
    pub convergence: Convergence,
    /// The eighth singular value of the linear equations over the first, in the normalised frame: 0.1 for points well
    /// spread, zero where they do not determine the map.
    pub condition: f64,
    normalised: SVector<f64, 9>,
    cofactor: SMatrix<f64, 9, 9>,
    object: Frame,
    image: Frame,
    pixel: f64,
}

impl Homography {
    /// The homography with the least sum of squared distances at n ≥ 4 points, image ≈ H object.
    ///
    /// *Model.* Linear start in normalised coordinates (DLT; Hartley 1997, In defense of the eight-point algorithm), then
    /// Levenberg–Marquardt on the distances themselves:
    ///
    /// ```text
    /// minimise ½ Σ wᵢ ρ(‖x′ᵢ − H xᵢ‖²)     over the eight directions that change H more than in scale
    /// ```
    ///
    /// *Frames and units.* Both sets are centred and scaled inside, the object also sheared to equal spread: coordinates
    /// of 10⁶ and long strips are as good as any. R₀ is not assumed to be one.
    ///
    /// *Accuracy.* Converged fits are at the minimum to rounding: the cost agrees with SciPy's to 1e-12 of itself. Four
    /// points are solved in closed form.
    ///
    /// # Errors
    /// [`Error::LengthMismatch`], [`Error::TooFewPoints`], [`Error::NotFinite`]; [`Error::Degenerate`] where the points
    /// of either plane lie on a line (the measure is their extent across it over that along it), or too few are in
    /// general position (the measure is [`HomographyFit::condition`]); [`Error::Projection`] where a point ends up beyond
    /// the horizon of the linear start; [`Error::FoldedQuad`] for four points that no map keeps in front of its horizon.
    /// An iteration that ran out is no error: see [`HomographyFit::convergence`].
    ///
    /// # Example
    /// Six points of an adjustment exercise (data of Ghilani, Adjustment Computations, ch. 18), unweighted; the
    /// coefficients are those of SciPy's `least_squares`:
    /// ```
    /// use collinear::geometry::Homography;
    /// use nalgebra::Point2;
    ///
    /// let points = |c: [(f64, f64); 6]| c.map(|(x, y)| Point2::new(x, y));
    /// let fit = Homography::fit(
    ///     &points([(90., 90.), (50., 40.), (-30., 20.), (50., -40.), (110., -80.), (-100., 80.)]),
    ///     &points([
    ///         (1420.407, 895.362), (895.887, 351.398), (-944.926, 641.434),
    ///         (968.084, -1384.138), (1993.262, -2367.511), (-3382.284, 3487.762),
    ///     ]),
    ///     &Default::default(),
    /// )?;
    /// let h = fit.homography.normalised();
    /// assert!((h.m11 - 25.002742789).abs() < 1e-8 && (h.m31 - 0.004001510570).abs() < 1e-12);
    /// # Ok::<(), collinear::Error>(())
    /// ```
    #[doc(alias("findHomography", "DLT", "projective adjustment"))]
    pub fn fit(
        object: &[Point2<f64>],
        image: &[Point2<f64>],
        options: &FitOptions,
    ) -> Result<HomographyFit, Error> {
        fit(object, image, None, options)
    }

    /// [`fit`](Self::fit) with a weight for each point, inversely proportional to the variance of its image
    /// coordinates. A point of weight zero has a residual but no say.
    ///
    /// # Errors
    /// As [`fit`](Self::fit), and [`Error::OutOfRange`] for a weight that is negative or not finite.
    pub fn fit_weighted(
        object: &[Point2<f64>],
        image: &[Point2<f64>],
        weights: &[f64],
        options: &FitOptions,
    ) -> Result<HomographyFit, Error> {
        if weights.len() != object.len() {
            return Err(Error::LengthMismatch {
                what: "points and weights",
                left: object.len(),
                right: weights.len(),
            });
        }
        if let Some(&value) = weights.iter().find(|w| !(**w >= 0.0 && w.is_finite())) {
            return Err(Error::OutOfRange { what: "weight", value, expected: "zero or more" });
        }
        fit(object, image, Some(weights), options)
    }
}

impl HomographyFit {
    /// The cofactor matrix (covariance for unit variance) of the nine entries of [`Homography::matrix`], row by row. It
    /// has rank eight: the entry largest in the normalised frame is held fixed there. Multiply by σ₀² for the covariance.
    #[must_use]
    pub fn cofactor(&self) -> SMatrix<f64, 9, 9> {
        // The rows of H are combinations of those of the normalised matrix, its columns likewise.
        let left = self.image.back(self.pixel);
        let right = self.object.forward();
        let chain = SMatrix::<f64, 9, 9>::from_fn(|to, from| {
            left[(to / 3, from / 3)] * right[(from % 3, to % 3)]
        });
        let shape = chain * self.normalised;
        // The map's matrix may differ in scale from the one composed here.
        let scale = self.homography.matrix().norm() / shape.norm();
        chain * self.cofactor * chain.transpose() * (scale * scale)
    }

    /// The covariance of the image of an object point that is free of error, in squared pixels: the cofactor at the
    /// point times σ₀², or times one where four points leave σ₀ open.
    ///
    /// # Errors
    /// [`ProjectionError::BeyondHorizon`], [`ProjectionError::NotFinite`].
    pub fn covariance_at(&self, object: &Point2<f64>) -> Result<Matrix2<f64>, ProjectionError> {
        let s = self.object.apply(object);
        let (_, partials) = transfer(&self.normalised, s)?;
        let j = partials * self.pixel;
        let sigma0 = self.sigma0.unwrap_or(1.0);
        Ok(j * self.cofactor * j.transpose() * (sigma0 * sigma0))
    }
}

/// Coordinates about the centroid, of unit variance in both directions: x ↦ A (x − m).
#[derive(Clone, Copy, Debug)]
struct Frame {
    mean: Point2<f64>,
    matrix: Matrix2<f64>,
    inverse: Matrix2<f64>,
    /// ε times the largest coordinate over the smaller spread: what rounding the coordinates does to normalised ones.
    rounding: f64,
}

impl Frame {
    fn new(points: &[Point2<f64>], what: &'static str) -> Result<Self, Error> {
        let n = points.len() as f64;
        let first = points[0];
        let mean = first + points.iter().fold(Vector2::zeros(), |s, p| s + (p - first) / n);
        let extent = points.iter().map(|p| (p - mean).amax()).fold(0.0, f64::max);
        if !(extent.is_finite() && mean.coords.amax().is_finite()) {
            return Err(Error::NotFinite { what });
        }
        let power = unit_power(extent);
        let differences = || points.iter().map(|p| (p - mean) * power);
        let squares = differences().fold(Vector2::zeros(), |s, d| s + d.component_mul(&d));
        // Gram–Schmidt from the axis of the larger spread: (a, b) with b made uncorrelated to a.
        let a = usize::from(squares.y > squares.x);
        let b = 1 - a;
        let product = differences().fold(0.0, |s, d| s + d.x * d.y);
        let slope = product / squares[a];
        let across = differences().fold(0.0, |s, d| {
            let rest = d[b] - slope * d[a];
            s + rest * rest
        });
        let (along, across) = (float::sqrt(squares[a] / n), float::sqrt(across / n));
        let measure = if along > 0.0 { across / along } else { 0.0 };
        let largest = mean.coords.amax() + extent;
        let rounding = f64::EPSILON * largest * power / across;
        let limit = f64::EPSILON * (4.0 + 2.0 * largest * power / along);
        if !(measure > limit) {
            return Err(Error::Degenerate { what, measure, limit });
        }
        let (mut matrix, mut inverse) = (Matrix2::zeros(), Matrix2::zeros());
        matrix[(a, a)] = power / along;
        matrix[(b, b)] = power / across;
        matrix[(b, a)] = -slope * power / across;
        inverse[(a, a)] = along / power;
        inverse[(b, b)] = across / power;
        inverse[(b, a)] = slope * along / power;
        Ok(Self { mean, matrix, inverse, rounding })
    }

    fn apply(&self, p: &Point2<f64>) -> [f64; 2] {
        (self.matrix * (p - self.mean)).into()
    }

    /// The 3×3 matrix into the frame.
    fn forward(&self) -> Matrix3<f64> {
        let (m, t) = (self.matrix, -(self.matrix * self.mean.coords));
        Matrix3::new(m.m11, m.m12, t.x, m.m21, m.m22, t.y, 0.0, 0.0, 1.0)
    }

    /// The 3×3 matrix back from coordinates that are only centred and divided by `unit`.
    fn back(&self, unit: f64) -> Matrix3<f64> {
        Matrix3::new(unit, 0.0, self.mean.x, 0.0, unit, self.mean.y, 0.0, 0.0, 1.0)
    }

    /// The root mean square of the distances to the centroid along one axis.
    fn spread(&self) -> f64 {
        self.inverse.norm() * core::f64::consts::FRAC_1_SQRT_2
    }
}

/// The image (u, v) of a point and its partial derivatives with respect to the nine entries: s/w, s/w and −u s/w.
fn transfer(
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

fn fit(
    object: &[Point2<f64>],
    image: &[Point2<f64>],
    weights: Option<&[f64]>,
    options: &FitOptions,
) -> Result<HomographyFit, Error> {
    let n = object.len();
    if n != image.len() {
        let what = "object and image points";
        return Err(Error::LengthMismatch { what, left: n, right: image.len() });
    }
    let used = weights.map_or(n, |w| w.iter().filter(|w| **w > 0.0).count());
    if used < 4 {
        return Err(Error::TooFewPoints { needed: 4, got: used });
    }
    if !object.iter().chain(image).all(|p| p.x.is_finite() && p.y.is_finite()) {
        return Err(Error::NotFinite { what: "homography control point" });
    }
    let object_frame = Frame::new(object, "homography fit: object points on a line")?;
    let image_frame = Frame::new(image, "homography fit: image points on a line")?;
    let pixel = image_frame.spread();
    let problem = Transfer {
        object: object.iter().map(|p| object_frame.apply(p)).collect(),
        image: image.iter().map(|p| ((p - image_frame.mean) / pixel).into()).collect(),
        weights,
        options: *options,
        pixel,
        object_unit: object_frame.inverse,
    };
    let (start, condition) = problem.linear(&object_frame, &image_frame)?;
    let mut linear = Linear { fixed: 0, normal: NormalEquations::default() };
    let (h, convergence, exact) = if let ([a, b, c, d], [e, f, g, i]) = (object, image) {
        let map = Homography::from_four_points(&[*a, *b, *c, *d], &[*e, *f, *g, *i])?;
        let cost = problem.cost(&start);
        let gradient = problem.linearise(&start, &mut linear);
        let convergence = Convergence {
            converged: true,
            iterations: 0,
            initial_cost: cost,
            final_cost: cost,
            gradient,
        };
        (start, convergence, Some(map))
    } else {
        if !problem.cost(&start).is_finite() {
            let beyond = problem.object.iter().find_map(|s| transfer(&start, *s).err());
            return Err(beyond.unwrap_or(ProjectionError::NotFinite).into());
        }
        let (h, convergence) = minimise(&problem, start, &mut linear, &options.least_squares);
        problem.linearise(&h, &mut linear);
        (h, convergence, None)
    };
    let composed =
        image_frame.back(pixel) * Matrix3::from_row_slice(h.as_slice()) * object_frame.forward();
    let homography = match exact {
        Some(map) => map,
        None => Homography::from_matrix(composed)?,
    };
    let residuals: Vec<Vector2<f64>> = problem
        .object
        .iter()
        .zip(&problem.image)
        .map(|(s, t)| {
            let [u, v, w] = homogeneous(&h.into(), *s);
            Vector2::new(t[0] - u / w, t[1] - v / w) * pixel
        })
        .collect();
    let sum: f64 =
        residuals.iter().enumerate().map(|(i, v)| problem.weight(i) * v.norm_squared()).sum();
    let sigma0 = (used > 4).then(|| float::sqrt(sum / (2 * used - 8) as f64));
    let lost = Error::Degenerate { what: "homography fit", measure: 0.0, limit: condition };
    let reduced = linear.normal.covariance().ok_or(lost)?;
    let index = |k: usize| if k < linear.fixed { k } else { k - 1 };
    let cofactor = SMatrix::from_fn(|i, j| {
        if i == linear.fixed || j == linear.fixed { 0.0 } else { reduced[(index(i), index(j))] }
    });
    Ok(HomographyFit {
        homography,
        residuals,
        sigma0,
        convergence,
        condition,
        normalised: h,
        cofactor,
        object: object_frame,
        image: image_frame,
        pixel,
    })
}

/// The distances in normalised coordinates: object of unit variance, image divided by `pixel`.
struct Transfer<'a> {
    object: Vec<[f64; 2]>,
    image: Vec<[f64; 2]>,
    weights: Option<&'a [f64]>,
    options: FitOptions,
    pixel: f64,
    object_unit: Matrix2<f64>,
}

/// Normal equations of eight entries, the largest of the nine held fixed.
struct Linear {
    fixed: usize,
    normal: NormalEquations<8>,
}

/// The condition down to which the linear start is found from squared equations: its error is then below 1e-6.
const SQUARED: f64 = 1e-5;

/// Where the product of entry `i` and `j` of (x, y, 1) stands among the six.
const PAIR: [[usize; 3]; 3] = [[0, 1, 2], [1, 3, 4], [2, 4, 5]];

/// Σ of the six products of s = (x, y, 1) times 1, u, v and u² + v²: all of JᵀJ, since a point's 18 partials are s, s, −u s
/// and −v s times a factor.
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
    /// AᵀA of the linear equations, with the image whitened.
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

    fn weight(&self, index: usize) -> f64 {
        self.weights.and_then(|w| w.get(index).copied()).unwrap_or(1.0)
    }

    /// The entries h of unit length that make Σ ‖w x′ − H x‖² least, oriented so that most points lie in front, and the
    /// eighth singular value over the first.
    fn linear(&self, from: &Frame, to: &Frame) -> Result<(SVector<f64, 9>, f64), Error> {
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
        if !(condition > SQUARED) {
            let mut triangle = Triangular::<9>::new();
            for row in rows() {
                triangle.add_row(row);
            }
            let (values, rows) = triangle.singular();
            condition = if values[0] > 0.0 { values[7] / values[0] } else { 0.0 };
            vectors = rows;
        }
        let limit = 64.0 * (f64::EPSILON + from.rounding + to.rounding);
        if !(condition > limit) {
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
