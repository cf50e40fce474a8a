//! Space intersection: a point from the pictures that show it.

use alloc::vec::Vec;

use nalgebra::{Matrix2x3, Matrix3, Point2, Point3, Vector2, Vector3};

use super::precision::{Precision, Weighting};
use super::report::{self, Report};
use super::settle::minimise_to_rounding;
use crate::camera::SensorModel;
use crate::error::{Error, ProjectionError};
use crate::geometry::{Locus, Ray, axes};
use crate::numeric::float;
use crate::numeric::least_squares::{
    Damped, LeastSquaresOptions, NormalEquations, Problem, unit_weight,
};
use crate::numeric::robust_loss::RobustLoss;
use crate::numeric::triangular::Triangular;

/// The point nearest to rays.
#[derive(Clone, Debug)]
pub struct NearestPoint {
    /// The point.
    pub point: Point3<f64>,
    /// For each ray how far along it the foot of the perpendicular from the point lies, in world units; positive.
    pub along: Vec<f64>,
    /// For each ray the point's distance from it, in world units.
    pub off: Vec<f64>,
    /// The smallest singular value of the equations over √Σw: the sine of half the angle between two rays of equal weight, zero for
    /// parallel ones.
    pub measure: f64,
}

/// The point whose squared distances from n ≥ 2 rays have the smallest sum: for two rays the middle of their common perpendicular.
///
/// *Model.* A ray from Cᵢ along the unit vector dᵢ (\[WD\] eq. 4b):
///
/// ```text
/// minimise Σ wᵢ ‖(I − dᵢ dᵢᵀ)(X − Cᵢ)‖²
/// ```
///
/// *Accuracy.* The equations are solved by rotations, not squared: the error grows as one over the angle of the rays.
///
/// *Use.* No distance in a picture is made small, so a far camera counts as much as a near one: a start for [`intersect`].
/// `weights` defaults to one for each ray.
///
/// # Errors
/// [`Error::TooFewPoints`], [`Error::LengthMismatch`]; [`Error::OutOfRange`] for a weight that is not positive; [`Error::Degenerate`] where all rays are parallel,
/// so that the point is at infinity (the measure is [`NearestPoint::measure`]), or start in one place (the measure is the largest distance between
/// their origins); [`Error::Projection`] with [`ProjectionError::BehindCamera`] where the point lies before the origin of a ray,
/// with the distance along it.
///
/// # Example
/// Two rays that pass each other: one along x at height 0, the other along y at height 1. Their common perpendicular stands at
/// (4, 3).
/// ```
/// use collinear::adjust::nearest_point;
/// use collinear::geometry::Ray;
/// use collinear::nalgebra::{Point3, Vector3};
///
/// let east = Ray::new(Point3::new(0.0, 3.0, 0.0), Vector3::x())?;
/// let north = Ray::new(Point3::new(4.0, 0.0, 1.0), Vector3::y())?;
/// let nearest = nearest_point(&[east, north], None)?;
/// assert!((nearest.point - Point3::new(4.0, 3.0, 0.5)).norm() < 1e-14);
/// assert!((nearest.along[0] - 4.0).abs() < 1e-14 && (nearest.off[0] - 0.5).abs() < 1e-14);
/// # Ok::<(), collinear::Error>(())
/// ```
#[doc(alias("midpoint", "triangulate", "ray intersection", "forward intersection"))]
pub fn nearest_point(rays: &[Ray], weights: Option<&[f64]>) -> Result<NearestPoint, Error> {
    let found = meet(rays, weights)?;
    if let Some(&depth) = found.along.iter().find(|t| !(**t > 0.0)) {
        return Err(ProjectionError::BehindCamera { depth }.into());
    }
    Ok(found)
}

/// [`nearest_point`] of the whole lines.
fn meet(rays: &[Ray], weights: Option<&[f64]>) -> Result<NearestPoint, Error> {
    if rays.len() < 2 {
        return Err(Error::TooFewPoints { needed: 2, got: rays.len() });
    }
    if let Some(weights) = weights {
        if weights.len() != rays.len() {
            let (left, right) = (rays.len(), weights.len());
            return Err(Error::LengthMismatch { what: "rays and weights", left, right });
        }
        if let Some(&value) = weights.iter().find(|w| !(**w > 0.0 && w.is_finite())) {
            return Err(Error::OutOfRange {
                what: "weight of a ray",
                value,
                expected: "a positive number",
            });
        }
    }
    let weight = |i: usize| weights.and_then(|w| w.get(i).copied()).unwrap_or(1.0);
    let first = rays[0].origin;
    let base = rays.iter().map(|r| (r.origin - first).amax()).fold(0.0, f64::max);
    if !base.is_finite() {
        return Err(Error::NotFinite { what: "origin of a ray" });
    }
    let largest = rays.iter().map(|r| r.origin.coords.amax()).fold(0.0, f64::max);
    // What rounding the origins leaves of their distance.
    let rounding = f64::EPSILON * largest;
    if !(base > rounding) {
        let what = "rays from one place";
        return Err(Error::Degenerate { what, measure: base, limit: rounding });
    }
    let heaviest = (0..rays.len()).map(weight).fold(0.0, f64::max);
    let mut equations = Triangular::<4>::new();
    let mut directions = Triangular::<3>::new();
    let mut sum = 0.0;
    for (i, ray) in rays.iter().enumerate() {
        let w = weight(i) / heaviest;
        sum += w;
        let offset = (ray.origin - first) / base;
        for across in axes(&ray.direction).matrix().column_iter().take(2) {
            let row = across * float::sqrt(w);
            equations.add_row([row.x, row.y, row.z, row.dot(&offset)]);
            directions.add_row(row.into());
        }
    }
    let measure = directions.singular().0[2] / float::sqrt(sum);
    let limit = 8.0 * f64::EPSILON + rounding / base;
    let parallel = Error::Degenerate { what: "parallel rays", measure, limit };
    if !(measure > limit) {
        return Err(parallel);
    }
    let [x, y, z, _] = equations.solve(0.0).ok_or(parallel)?;
    let point = first + Vector3::new(x, y, z) * base;
    if !point.iter().all(|c| c.is_finite()) {
        return Err(parallel);
    }
    let along = |r: &Ray| (point - r.origin).dot(&r.direction);
    let off = |r: &Ray| (point - r.origin).cross(&r.direction).norm();
    Ok(NearestPoint {
        point,
        along: rays.iter().map(along).collect(),
        off: rays.iter().map(off).collect(),
        measure,
    })
}

/// A picture that shows the point.
#[derive(Clone, Copy, Debug)]
pub struct ImageObservation<'a> {
    /// The oriented sensor.
    pub sensor: &'a dyn SensorModel,
    /// Where it shows the point, in pixels.
    pub image: Point2<f64>,
    /// How good the measurement is; σ = 1 pixel unless said otherwise.
    pub precision: Precision<2>,
}

impl<'a> ImageObservation<'a> {
    /// A point measured with σ = 1 pixel.
    #[must_use]
    pub fn new(sensor: &'a dyn SensorModel, image: Point2<f64>) -> Self {
        Self { sensor, image, precision: Precision::default() }
    }

    /// With another precision, in pixels.
    #[must_use]
    pub fn with_precision(mut self, precision: Precision<2>) -> Self {
        self.precision = precision;
        self
    }
}

/// How to intersect.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct IntersectionOptions {
    /// How each picture's residual enters, in units of its standard deviation.
    pub loss: RobustLoss,
    /// Whether covariances and tests use the σ₀ found, or believe the stated precisions.
    pub estimate_sigma: bool,
    /// When to stop.
    pub least_squares: LeastSquaresOptions,
}

impl Default for IntersectionOptions {
    fn default() -> Self {
        Self {
            loss: RobustLoss::Squared,
            estimate_sigma: true,
            least_squares: LeastSquaresOptions::default(),
        }
    }
}

/// A point found from pictures, with its report.
#[derive(Clone, Debug)]
pub struct Intersection {
    /// The point.
    pub point: Point3<f64>,
    /// How good it is. The parameters are X, Y, Z in world units; the values are x and y of each picture in pixels.
    pub report: Report,
}

/// The point that n ≥ 2 oriented sensors of any kind show, by maximum likelihood: space intersection.
///
/// *Model.* Collinearity (\[WD\] eq. 4a), with the orientations free of error:
///
/// ```text
/// minimise Σ ρ(vᵢᵀ Pᵢ vᵢ),   vᵢ = imageᵢ − sensorᵢ(X)
/// ```
///
/// *Start.* The point nearest to the lines of sight ([`nearest_point`]); of a sensor without rays, as an RPC, the chord of its curve.
///
/// *Accuracy.* The gradient is zero to rounding. The covariance does not know errors of the orientations, which two pictures more often have than not.
///
/// # Errors
/// [`Error::TooFewPoints`], [`Error::NotFinite`]; [`Error::OutOfRange`] and others for precisions that are none (see [`Precision::covariance`]);
/// [`Error::Degenerate`] where the lines of sight are parallel, the point being at infinity, or start in one place (measures as of [`nearest_point`]);
/// [`Error::Projection`] where an image point has no line of sight, or the point lies behind a sensor or outside what it sees;
/// [`Error::NotConverged`].
///
/// # Example
/// The normal case of stereo photogrammetry: base B = 100, c = 1000 px, both cameras looking down from 500. A point at x = 200 in the left
/// and x = −50 in the right picture has the parallax 250: its depth is 1000 · 100/250 = 400, its X is 200 · 400/1000 = 80.
/// ```
/// use collinear::adjust::{ImageObservation, IntersectionOptions, intersect};
/// use collinear::nalgebra::{Point2, Point3, Vector3};
/// use collinear::{ExteriorOrientation, Frame, InteriorOrientation};
///
/// let interior = InteriorOrientation::new([1000.0; 2], Point2::origin(), 0.0)?;
/// let camera = |x: f64| {
///     let center = Point3::new(x, 0.0, 500.0);
///     ExteriorOrientation::look_at(center, Point3::new(x, 0.0, 0.0), Vector3::y())
///         .map(|exterior| Frame::new(exterior, interior))
/// };
/// let (left, right) = (camera(0.0)?, camera(100.0)?);
/// let found = intersect(
///     &[
///         ImageObservation::new(&left, Point2::new(200.0, 0.5)),
///         ImageObservation::new(&right, Point2::new(-50.0, -0.5)),
///     ],
///     &IntersectionOptions::default(),
/// )?;
/// assert!((found.point - Point3::new(80.0, 0.0, 100.0)).norm() < 1e-10);
/// // A parallax in y of one pixel is left, half in each picture: σ₀² = 2 · 0.5² / 1.
/// assert!((found.report.sigma0.ok_or("redundant")? - 0.5f64.sqrt()).abs() < 1e-12);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[doc(alias("triangulate", "triangulatePoints", "forward intersection", "multi-ray"))]
pub fn intersect(
    observations: &[ImageObservation<'_>],
    options: &IntersectionOptions,
) -> Result<Intersection, Error> {
    if observations.len() < 2 {
        return Err(Error::TooFewPoints { needed: 2, got: observations.len() });
    }
    let sightings = observations.iter().map(Sighting::new).collect::<Result<Vec<_>, _>>()?;
    let mut rays = Vec::with_capacity(sightings.len());
    let mut straight = true;
    for sighting in &sightings {
        rays.push(match sighting.sensor.locus(&sighting.image)? {
            Locus::Ray(ray) => ray,
            Locus::Curve(curve) => {
                straight = false;
                let [low, high] = curve.heights;
                let (top, bottom) = (curve.at(high), curve.at(low));
                Ray::new(top, bottom - top)?
            }
        });
    }
    let start = if straight { nearest_point(&rays, None)? } else { meet(&rays, None)? };
    let range = start.along.iter().map(|t| t.abs()).fold(0.0, f64::max);
    let problem = Sightings { list: &sightings, loss: options.loss, range };
    // The start says why where a sensor does not see it.
    for sighting in &sightings {
        sighting.sensor.project(&start.point)?;
    }
    let mut linear = NormalEquations::<3>::default();
    let (point, convergence) =
        minimise_to_rounding(&problem, start.point, &mut linear, &options.least_squares);
    convergence.check()?;
    let rows = sightings
        .iter()
        .map(|sighting| {
            let (image, jacobian) = sighting.sensor.project_jacobian(&point)?;
            let residual = sighting.image - image;
            let robust = options.loss.weight(residual.dot(&(sighting.weighting.weight * residual)));
            Ok((sighting, jacobian, residual, robust))
        })
        .collect::<Result<Vec<_>, ProjectionError>>()?;
    let mut normal = Matrix3::zeros();
    let mut weighted_sum = 0.0;
    for (sighting, jacobian, residual, robust) in &rows {
        normal += jacobian.transpose() * sighting.weighting.weight * jacobian * *robust;
        weighted_sum += residual.dot(&(sighting.weighting.weight * residual)) * robust;
    }
    let (q, condition) = report::fixed_cofactor(&normal)?;
    let redundancy = 2 * rows.len() - 3;
    let sigma0 = unit_weight(weighted_sum, redundancy);
    let sigma = report::sigma(sigma0, options.estimate_sigma);
    let mut values = Vec::with_capacity(2 * rows.len());
    for (sighting, jacobian, residual, robust) in &rows {
        // A picture that the loss ignores has an infinite variance.
        let covariance = sighting.weighting.covariance / robust.max(1e-12);
        let unexplained = covariance - jacobian * q * jacobian.transpose();
        values.extend(report::observed(&unexplained, &covariance, residual, sigma));
    }
    let report = Report {
        observations: 2 * rows.len(),
        unknowns: 3,
        redundancy,
        weighted_sum,
        sigma0,
        sigma,
        covariance: report::covariance(&q, sigma),
        condition,
        values,
        convergence,
    };
    Ok(Intersection { point, report })
}

/// An observation with its weight.
struct Sighting<'a> {
    sensor: &'a dyn SensorModel,
    image: Point2<f64>,
    weighting: Weighting<2>,
}

impl<'a> Sighting<'a> {
    fn new(observation: &ImageObservation<'a>) -> Result<Self, Error> {
        let ImageObservation { sensor, image, precision } = *observation;
        if !(image.x.is_finite() && image.y.is_finite()) {
            return Err(Error::NotFinite { what: "image point" });
        }
        let weighting = Weighting::new(&precision, "weight of an image point")?;
        Ok(Self { sensor, image, weighting })
    }
}

struct Sightings<'a> {
    list: &'a [Sighting<'a>],
    loss: RobustLoss,
    /// How far the point is from the sensors.
    range: f64,
}

impl Problem for Sightings<'_> {
    type State = Point3<f64>;
    type Linear = NormalEquations<3>;
    type Step = Vector3<f64>;

    fn cost(&self, point: &Point3<f64>) -> f64 {
        let mut sum = 0.0;
        for sighting in self.list {
            let Ok(image) = sighting.sensor.project(point) else { return f64::INFINITY };
            sum +=
                self.loss.cost((sighting.weighting.root * (sighting.image - image)).norm_squared());
        }
        0.5 * sum
    }

    fn linearise(&self, point: &Point3<f64>, linear: &mut NormalEquations<3>) -> f64 {
        linear.clear();
        for sighting in self.list {
            let Ok((image, jacobian)) = sighting.sensor.project_jacobian(point) else { continue };
            let v: Vector2<f64> = sighting.weighting.root * (sighting.image - image);
            let rows: Matrix2x3<f64> = sighting.weighting.root * jacobian;
            let robust = self.loss.weight(v.norm_squared());
            for i in 0..2 {
                linear.add(&rows.row(i).transpose(), -v[i], robust);
            }
        }
        linear.scaled_gradient()
    }

    fn solve(
        &self,
        _: &Point3<f64>,
        linear: &NormalEquations<3>,
        damping: f64,
    ) -> Option<Damped<Vector3<f64>>> {
        linear.solve(damping, &Vector3::repeat(self.range))
    }

    fn apply(&self, point: &Point3<f64>, step: &Vector3<f64>) -> Point3<f64> {
        point + step
    }
}
