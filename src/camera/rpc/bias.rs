//! The image correction of a rational polynomial camera from control points.

use alloc::vec::Vec;

use nalgebra::{Matrix2, Matrix6, Point2, Vector2};

use super::correction::ImageCorrection;
use super::model::Rpc;
use crate::error::Error;
use crate::geometry::geodetic::Geodetic;
use crate::numeric::float;
use crate::numeric::least_squares::unit_weight;
use crate::numeric::triangular::Triangular;

/// A point whose place on the ground and in the picture is known.
#[derive(Clone, Copy, Debug, PartialEq)]
#[doc(alias("GCP", "ground control point"))]
pub struct ControlPoint {
    /// Where it is, on WGS84.
    pub ground: Geodetic,
    /// Where it was measured, in pixels.
    pub image: Point2<f64>,
    /// The standard deviations of x and y before the adjustment, in pixels; the weight is 1/σ².
    pub sigma: [f64; 2],
}

/// Which part of the image correction is estimated; the rest is zero.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum CorrectionModel {
    /// A shift: one point at least. For pictures of less than 50 km along the track (Grodecki & Dial 2003).
    #[default]
    Shift,
    /// A shift, and a drift by the line: two points at least, not on one line of the picture (Fraser & Hanley 2003).
    ShiftAndDrift,
    /// The whole affine map: three points at least, not on one straight line.
    Affine,
}

impl CorrectionModel {
    /// The number of parameters for each of x and y, which is the least number of points.
    #[must_use]
    pub fn parameters(self) -> usize {
        match self {
            Self::Shift => 1,
            Self::ShiftAndDrift => 2,
            Self::Affine => 3,
        }
    }
}

/// A corrected camera, and how well the control points support it.
#[derive(Clone, Debug)]
pub struct CorrectionReport {
    /// The camera with its correction, about the middle of the picture.
    pub rpc: Rpc,
    /// Measured image point minus corrected projection, in pixels, in the order of the control points.
    pub residuals: Vec<Vector2<f64>>,
    /// Observations minus parameters: 2n − 2u.
    pub redundancy: usize,
    /// √(Σ v²/σ² / redundancy): 1 where the standard deviations given are true. `None` without redundancy.
    pub sigma0: Option<f64>,
    /// The covariance of (sₓ, s_y, drift of x and y by the line, shear of x and y by the sample), in pixels and pixels a
    /// pixel: the inverse normal matrix times σ0², or times 1 without redundancy. Zero for what is not estimated.
    pub covariance: Matrix6<f64>,
}

/// The least spread of the control points across what they must not lie on, in half sizes of the picture.
const LEAST_SPREAD: f64 = 1e-6;

impl Rpc {
    /// The camera with the correction that fits control points best, in place of the one it has.
    ///
    /// ```text
    /// minimise Σ (vₓ/σₓ)² + (v_y/σ_y)²,   v = measured − (q + s + A (q − c))
    /// ```
    /// linear in s and A, and solved through orthogonal rotations, in units of half a picture.
    ///
    /// # Errors
    /// [`Error::TooFewPoints`]; [`Error::Degenerate`] where the points lie on one line of the picture (for the drift) or on
    /// one straight line (affine): the spread across it, in half sizes of the picture, is not above 10⁻⁶;
    /// [`Error::OutOfRange`] for a standard deviation that is not from 10⁻⁹ to 10⁹ px; [`Error::NotFinite`];
    /// [`Error::Projection`] for a control point outside the domain.
    ///
    /// # Example
    /// Two points measured 2 px right of where the model of [`Rpc`]'s example has them, one of them 1 px down, one 1 px up:
    ///
    /// ```
    /// # use collinear::camera::rpc::{ControlPoint, CorrectionModel, Rpc, Rpc00b};
    /// # use collinear::geometry::geodetic::{EllipsoidalHeight, Geodetic};
    /// # use nalgebra::{Point2, Vector2};
    /// # let polynomial = |k: usize, c: f64| { let mut p = [0.0; 20]; p[k] = c; p };
    /// # let rpc = Rpc::from_rpc00b(&Rpc00b {
    /// #     line_offset: 4999.5, sample_offset: 4999.5, line_scale: 5000.0, sample_scale: 5000.0,
    /// #     latitude_offset_deg: 44.0, longitude_offset_deg: 5.0, height_offset: 500.0,
    /// #     latitude_scale_deg: 0.05, longitude_scale_deg: 0.05, height_scale: 500.0,
    /// #     line_numerator: polynomial(2, -1.0), line_denominator: polynomial(0, 1.0),
    /// #     sample_numerator: polynomial(1, 1.0), sample_denominator: polynomial(0, 1.0),
    /// #     error_bias: None, error_random: None,
    /// # })?;
    /// let ground = |north| Geodetic::from_degrees(44.0 + north, 5.0, EllipsoidalHeight(500.0));
    /// let control = [
    ///     ControlPoint { ground: ground(0.0)?, image: Point2::new(5002.0, 5001.0), sigma: [0.5; 2] },
    ///     ControlPoint { ground: ground(0.01)?, image: Point2::new(5002.0, 3999.0), sigma: [0.5; 2] },
    /// ];
    /// let fit = rpc.correct(&control, CorrectionModel::Shift)?;
    /// assert!((fit.rpc.correction().shift() - Vector2::new(2.0, 0.0)).norm() < 1e-8);
    /// // v = (0, ±1): σ0 = √(2 · (1/0.5)² / 2) = 2, and a shift has σ0 · 0.5/√2.
    /// assert_eq!(fit.redundancy, 2);
    /// assert!((fit.sigma0.unwrap() - 2.0).abs() < 1e-8);
    /// assert!((fit.covariance[(0, 0)] - 0.5).abs() < 1e-8);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[doc(alias("bias compensation", "refine", "GCP"))]
    pub fn correct(
        &self,
        control: &[ControlPoint],
        model: CorrectionModel,
    ) -> Result<CorrectionReport, Error> {
        let unknowns = model.parameters();
        if control.len() < unknowns {
            return Err(Error::TooFewPoints { needed: unknowns, got: control.len() });
        }
        let bare = self.with_correction(ImageCorrection::none());
        let centre = self.image_centre();
        let half = [self.record().sample_scale, self.record().line_scale];
        let mut rows = Vec::with_capacity(control.len());
        for point in control {
            if !(point.image.x.is_finite() && point.image.y.is_finite()) {
                return Err(Error::NotFinite { what: "control point" });
            }
            for value in point.sigma {
                // Their squares must not overflow in the covariance.
                if !(1e-9..=1e9).contains(&value) {
                    let what = "standard deviation of a control point";
                    let expected = "from 10⁻⁹ to 10⁹ pixels";
                    return Err(Error::OutOfRange { what, value, expected });
                }
            }
            let q = bare.project(&point.ground)?;
            let (u, v) = ((q.x - centre.x) / half[0], (q.y - centre.y) / half[1]);
            rows.push(Row { terms: [1.0, v, u], off: point.image - q, sigma: point.sigma });
        }
        check_spread(&rows, model)?;
        let axis = |k| match model {
            CorrectionModel::Shift => solve::<1, 2>(&rows, k),
            CorrectionModel::ShiftAndDrift => solve::<2, 3>(&rows, k),
            CorrectionModel::Affine => solve::<3, 4>(&rows, k),
        };
        let (x, y) = (axis(0)?, axis(1)?);
        // From half pictures to pixels.
        let unit = [1.0, 1.0 / half[1], 1.0 / half[0]];
        let scaled = |a: &Axis, i: usize| a.values[i] * unit[i];
        let shift = Vector2::new(scaled(&x, 0), scaled(&y, 0));
        let linear = Matrix2::new(scaled(&x, 2), scaled(&x, 1), scaled(&y, 2), scaled(&y, 1));
        let rpc = bare.with_correction(ImageCorrection::new(centre, shift, linear)?);

        let mut residuals = Vec::with_capacity(control.len());
        let mut sum = 0.0;
        for (point, row) in control.iter().zip(&rows) {
            let v = point.image - rpc.project(&point.ground)?;
            let [a, b] = [v.x / row.sigma[0], v.y / row.sigma[1]];
            sum += a * a + b * b;
            residuals.push(v);
        }
        let redundancy = 2 * (control.len() - unknowns);
        let sigma0 = unit_weight(sum, redundancy);
        let variance = sigma0.map_or(1.0, |s| s * s);
        let mut covariance = Matrix6::zeros();
        for (k, a) in [x, y].iter().enumerate() {
            for i in 0..unknowns {
                for j in 0..unknowns {
                    covariance[(2 * i + k, 2 * j + k)] =
                        variance * a.cofactors[i][j] * unit[i] * unit[j];
                }
            }
        }
        Ok(CorrectionReport { rpc, residuals, redundancy, sigma0, covariance })
    }
}

/// One control point: the factors of shift, drift and shear, what they must explain, and its weights.
struct Row {
    terms: [f64; 3],
    off: Vector2<f64>,
    sigma: [f64; 2],
}

/// The estimate for x or for y.
struct Axis {
    values: [f64; 3],
    cofactors: [[f64; 3]; 3],
}

/// U unknowns from weighted rows, V = U + 1.
fn solve<const U: usize, const V: usize>(rows: &[Row], axis: usize) -> Result<Axis, Error> {
    let (mut design, mut system) = (Triangular::<U>::new(), Triangular::<V>::new());
    for row in rows {
        let weight = 1.0 / row.sigma[axis];
        let terms: [f64; U] = core::array::from_fn(|i| weight * row.terms[i]);
        design.add_row(terms);
        system.add_row(core::array::from_fn(
            |i| {
                if i < U { terms[i] } else { weight * row.off[axis] }
            },
        ));
    }
    let what = "system of an image correction";
    let singular = Error::Degenerate { what, measure: 0.0, limit: 0.0 };
    let solution = system.solve(0.0).ok_or(singular)?;
    let (s, v) = design.singular();
    let mut found = Axis { values: [0.0; 3], cofactors: [[0.0; 3]; 3] };
    found.values[..U].copy_from_slice(&solution[..U]);
    for i in 0..U {
        for j in 0..U {
            found.cofactors[i][j] = (0..U).map(|k| v[(i, k)] * v[(j, k)] / (s[k] * s[k])).sum();
        }
    }
    Ok(found)
}

/// Refuses points that do not determine the drift or the affine map.
fn check_spread(rows: &[Row], model: CorrectionModel) -> Result<(), Error> {
    let n = rows.len() as f64;
    let mean = |i: usize| rows.iter().map(|r| r.terms[i]).sum::<f64>() / n;
    let (v, u) = (mean(1), mean(2));
    let (what, measure) = match model {
        CorrectionModel::Shift => return Ok(()),
        CorrectionModel::ShiftAndDrift => {
            let sum: f64 = rows.iter().map(|r| (r.terms[1] - v) * (r.terms[1] - v)).sum();
            ("control points along the track", float::sqrt(sum / n))
        }
        CorrectionModel::Affine => {
            let mut spread = Triangular::<2>::new();
            rows.iter().for_each(|r| spread.add_row([r.terms[1] - v, r.terms[2] - u]));
            ("control points off a straight line", spread.singular().0[1] / float::sqrt(n))
        }
    };
    if measure > LEAST_SPREAD {
        return Ok(());
    }
    Err(Error::Degenerate { what, measure, limit: LEAST_SPREAD })
}
