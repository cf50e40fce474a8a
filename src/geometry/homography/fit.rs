//! Homographies from n points by least squares.

use alloc::vec::Vec;

use nalgebra::{Matrix2, Matrix3, Point2, SMatrix, SVector, Vector2};

use super::transfer::{Linear, Transfer, transfer};
use super::{Homography, homogeneous, unit_power};
use crate::error::{Error, ProjectionError};
use crate::numeric::float;
use crate::numeric::least_squares::{
    Convergence, LeastSquaresOptions, NormalEquations, Problem, minimise, unit_weight,
};
use crate::numeric::robust_loss::RobustLoss;

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
    /// *Accuracy.* Converged fits are at the minimum to rounding: the cost is that of the minimum found in 50 digits to 1e-12. Four
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
    /// coefficients are those of the minimum found in 50 digits with mpmath:
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
    /// assert!((h.m11 - 25.002742894903).abs() < 1e-11 && (h.m31 - 0.004001510651788).abs() < 1e-15);
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
pub(super) struct Frame {
    mean: Point2<f64>,
    pub(super) matrix: Matrix2<f64>,
    pub(super) inverse: Matrix2<f64>,
    /// ε times the largest coordinate over the smaller spread: what rounding the coordinates does to normalised ones.
    pub(super) rounding: f64,
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
        if measure.is_nan() || limit.is_nan() || measure <= limit {
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
        (start, Convergence::without_iteration(cost, gradient), Some(map))
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
    let sigma0 = unit_weight(sum, (2 * used).saturating_sub(8));
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
