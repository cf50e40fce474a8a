//! Space resection: a camera from points whose places are known.

mod object_space;
mod robust;
mod solve;
mod start;

use alloc::vec::Vec;

use nalgebra::{Matrix3, Point2, Point3};

pub use self::robust::{RobustResection, resect_robust};
use self::solve::{Minimised, Observed, Task};
use self::start::Starts;
use super::precision::Precision;
use super::report::{ObservationReport, Report};
use super::unknowns::{Columns, Unknown};
use crate::camera::{Adjustable, CentralModel, ExteriorOrientation, Frame, SensorModel};
use crate::error::Error;
use crate::numeric::least_squares::LeastSquaresOptions;
use crate::numeric::robust_loss::RobustLoss;

/// A point whose place in the world is known and whose image was measured.
///
/// # Example
/// ```
/// use collinear::adjust::{ControlPoint, Precision};
/// use nalgebra::{Point2, Point3};
///
/// let control = ControlPoint::new(Point3::new(36589.41, 25273.32, 2195.17), Point2::new(812.5, 410.25))
///     .with_precision(Precision::Sigma(0.3))
///     .with_object_precision(Precision::Sigmas([0.02, 0.02, 0.05]));
/// assert_eq!(control.precision, Precision::Sigma(0.3));
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[doc(alias("GCP", "ground control point", "2D-3D correspondence"))]
pub struct ControlPoint {
    /// The place in the world.
    pub object: Point3<f64>,
    /// The measured image, in pixels.
    pub image: Point2<f64>,
    /// How good the measurement is; σ = 1 pixel unless said otherwise.
    pub precision: Precision<2>,
    /// How good the place is; `None` takes it as free of error.
    pub object_precision: Option<Precision<3>>,
}

impl ControlPoint {
    /// A point free of error, measured with σ = 1 pixel.
    #[must_use]
    pub fn new(object: Point3<f64>, image: Point2<f64>) -> Self {
        Self { object, image, precision: Precision::default(), object_precision: None }
    }

    /// With another precision of the measurement, in pixels.
    #[must_use]
    pub fn with_precision(mut self, precision: Precision<2>) -> Self {
        self.precision = precision;
        self
    }

    /// With a place that is not free of error: the adjustment may move it, at a cost.
    #[must_use]
    pub fn with_object_precision(mut self, precision: Precision<3>) -> Self {
        self.object_precision = Some(precision);
        self
    }
}

/// How to resect.
#[derive(Clone, Debug, PartialEq)]
pub struct ResectionOptions {
    /// What is estimated; group 0 of a [`Frame`] is the exterior orientation.
    pub unknowns: Vec<Unknown>,
    /// How each point's residual enters, in units of its standard deviation.
    pub loss: RobustLoss,
    /// An approximate pose. It is tried beside those found without it.
    pub start: Option<ExteriorOrientation>,
    /// Whether covariances and tests use the σ₀ found, or believe the stated precisions.
    pub estimate_sigma: bool,
    /// When to stop.
    pub least_squares: LeastSquaresOptions,
}

impl Default for ResectionOptions {
    fn default() -> Self {
        Self {
            unknowns: Vec::from([Unknown::group(0)]),
            loss: RobustLoss::Squared,
            start: None,
            estimate_sigma: true,
            least_squares: LeastSquaresOptions {
                decrease_tolerance: 1e-15,
                ..LeastSquaresOptions::default()
            },
        }
    }
}

/// A sensor found from control points, with its report.
#[derive(Clone, Debug)]
pub struct Resection<S> {
    /// The sensor.
    pub sensor: S,
    /// How good it is. Its values are, for each control point, image x, y and, where the place was given with a precision,
    /// X, Y, Z; then the observed parameters in the order of the unknowns.
    pub report: Report,
    /// The second solution: another pose that no small change improves, with all points in front of it. A plane seen from
    /// afar has two, and only their costs tell which is right.
    #[doc(alias("planar ambiguity", "IPPE"))]
    pub other: Option<OtherPose>,
    /// For each control point the place of its first number, and the end.
    first: Vec<usize>,
    exterior_first: bool,
}

/// A second local minimum of a resection.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OtherPose {
    /// The pose.
    pub exterior: ExteriorOrientation,
    /// Half of its vᵀPv, or of its sum of losses, to be compared with the [`Report`]'s final cost.
    pub cost: f64,
}

impl<S> Resection<S> {
    /// What the report says of a control point's image, x and y; `None` past the last point.
    #[must_use]
    pub fn image_report(&self, point: usize) -> Option<[ObservationReport; 2]> {
        let (first, next) = (*self.first.get(point)?, *self.first.get(point + 1)?);
        self.report.values.get(first..next)?.first_chunk().copied()
    }

    /// What the report says of a control point's place, X, Y and Z; `None` where it was free of error.
    #[must_use]
    pub fn object_report(&self, point: usize) -> Option<[ObservationReport; 3]> {
        let (first, next) = (*self.first.get(point)?, *self.first.get(point + 1)?);
        self.report.values.get(first + 2..next)?.try_into().ok()
    }
}

impl<C> Resection<Frame<C>> {
    /// The covariance of ω, φ, κ in square radians, where the whole exterior orientation is what was estimated, or first among it.
    ///
    /// ```text
    /// Σ(ω, φ, κ) = J⁻¹ Σ(δ) J⁻ᵀ,   δ = J d(ω, φ, κ)
    /// ```
    ///
    /// `None` where it was not, or φ is ±90° and ω and κ turn about one axis.
    #[must_use]
    pub fn omega_phi_kappa_covariance(&self) -> Option<Matrix3<f64>> {
        if !self.exterior_first {
            return None;
        }
        let by_angles = self.sensor.exterior.rotation_from_omega_phi_kappa();
        let inverse = by_angles.try_inverse()?;
        let turn = self.report.covariance.fixed_view::<3, 3>(3, 3);
        let covariance = inverse * turn * inverse.transpose();
        covariance.iter().all(|v| v.is_finite()).then_some(covariance)
    }
}

/// The pose of a camera from control points, by maximum likelihood and without initial values: space resection.
///
/// *Model.* The collinearity equations (\[WD\] eq. 4a) through the whole camera, lens and all:
///
/// ```text
/// minimise Σ ρ(vᵢᵀ Pᵢ vᵢ),   vᵢ = imageᵢ − camera(R (Xᵢ − C))
/// ```
///
/// *Start.* Every minimum of the object-space error over the rotations, in closed form but for Newton's descents, whose cost does not
/// depend on the number of points; those with all points before the camera are refined, the best is the answer, and
/// the next is [`Resection::other`]. [`ResectionOptions::start`] is tried with them, so a wrong one does no harm.
///
/// *Frames and units.* World units for points and projection centre, pixels for the image. Map coordinates of 10⁶ lose nothing: the
/// centre is subtracted first.
///
/// *Domain.* Four points or more, three of them not on one line; any [`CentralModel`], fisheye and panorama too. What else is
/// estimated is chosen by [`ResectionOptions::unknowns`]. Points that lie on a common surface with the camera, as the
/// cylinder through three points of a danger circle, leave it weak: [`Report::condition`] and the standard deviations show it.
///
/// *Accuracy.* Within 2·10⁻⁷ standard deviations of the optimum, and within 10⁻⁶ of a map unit where coordinates are 10⁶.
///
/// # Errors
/// [`Error::TooFewPoints`] (duplicates count once), [`Error::NotFinite`]; [`Error::OutOfRange`], [`Error::Inconsistent`] for
/// precisions, loss or unknowns that are none; [`Error::Degenerate`] where the points lie on a line (the measure is their
/// extent across it over that along it) or the unknowns are not determined (one over the condition);
/// [`Error::Projection`] where an image point has no direction or no pose has all points before the camera;
/// [`Error::NotConverged`].
///
/// # Example
/// Single-photo resection of Wuhan University's textbook (photogrammetry): f = 153.24 mm, four points, the published
/// result Xs = 39795.45, Ys = 27476.46, Zs = 7572.69 m, σ₀ = 7.26 µm; no initial values are given.
///
/// ```
/// use collinear::InteriorOrientation;
/// use collinear::adjust::{ControlPoint, ResectionOptions, resect};
/// use collinear::geometry::Affine2;
/// use nalgebra::{Point2, Point3};
///
/// // With the identity image coordinates are photo millimetres, y up.
/// let camera = InteriorOrientation::from_photogrammetric(153.24, Point2::origin(), &Affine2::identity())?;
/// let control = [
///     ((-86.15, -68.99), (36589.41, 25273.32, 2195.17)),
///     ((-53.40, 82.21), (37631.08, 31324.51, 728.69)),
///     ((-14.78, -76.63), (39100.97, 24934.98, 2386.50)),
///     ((10.46, 64.43), (40426.54, 30319.81, 757.31)),
/// ]
/// .map(|((x, y), (e, n, h))| ControlPoint::new(Point3::new(e, n, h), Point2::new(x, y)));
/// let found = resect(&camera, &control, &ResectionOptions::default())?;
/// let center = found.sensor.exterior.projection_center();
/// assert!((center - Point3::new(39795.45, 27476.46, 7572.69)).amax() < 0.005);
/// assert!((found.report.sigma0.unwrap() - 0.00726).abs() < 0.000005);
/// # Ok::<(), collinear::Error>(())
/// ```
#[doc(alias("solvePnP", "PnP", "absolute pose", "camera pose estimation"))]
pub fn resect<C: CentralModel + Adjustable + Clone>(
    camera: &C,
    control: &[ControlPoint],
    options: &ResectionOptions,
) -> Result<Resection<Frame<C>>, Error> {
    options.loss.check()?;
    let points = observed(control)?;
    start::check_distinct(&points)?;
    let mut starts = start::poses(camera, &points)?;
    starts.others.extend(options.start);
    let first = Frame::new(starts.minima[0], camera.clone());
    let pose_only = Columns::resolve(&first, &[Unknown::group(0)])?;
    let columns = Columns::resolve(&first, &options.unknowns)?;
    check_enough(&points, &columns)?;
    let pose = Task { points: &points, columns: &pose_only, options };
    let mut solutions = refined(starts, camera, &pose)?.into_iter();
    let Some(mut best) = solutions.next() else { return Err(start::no_sight(0.0)) };
    let other = solutions
        .next()
        .map(|s| OtherPose { exterior: s.sensor.exterior, cost: s.convergence.final_cost });
    let task = Task { points: &points, columns: &columns, options };
    if options.unknowns != [Unknown::group(0)] {
        best = task.minimise(&best.sensor);
    }
    let (report, first) = task.report(&best)?;
    let exterior_first = options.unknowns.first() == Some(&Unknown::group(0));
    Ok(Resection { sensor: best.sensor, report, other, first, exterior_first })
}

/// The sensor from control points and a start: any sensor with parameters, a scanner's too.
///
/// The model, accuracy and report are those of [`resect`]; the unknowns are chosen among the sensor's groups. Only the
/// start's own valley is searched, and [`ResectionOptions::start`] is not looked at.
///
/// # Errors
/// As [`resect`]; [`Error::TooFewPoints`] where there are fewer observations than unknowns; [`Error::Projection`] where a point
/// has no image at the start.
///
/// # Example
/// A level camera's height and turn from three points, started 2 m and 5° off:
///
/// ```
/// use collinear::adjust::{ControlPoint, ResectionOptions, Unknown, resect_from};
/// use collinear::{ExteriorOrientation, Frame, InteriorOrientation};
/// use nalgebra::{Point2, Point3, Vector3};
///
/// // c = 1000 px; the images of the points from (0, 0, 10), looking along y: x = 500 + 1000 X/Y, y = 500 + 1000 (10 − Z)/Y.
/// let camera = InteriorOrientation::new([1000.0; 2], Point2::new(500.0, 500.0), 0.0)?;
/// let control = [
///     ControlPoint::new(Point3::new(5.0, 20.0, 10.0), Point2::new(750.0, 500.0)),
///     ControlPoint::new(Point3::new(-4.0, 25.0, 15.0), Point2::new(340.0, 300.0)),
///     ControlPoint::new(Point3::new(2.0, 40.0, 4.0), Point2::new(550.0, 650.0)),
/// ];
/// let place = Point3::new(0.0, 0.0, 12.0);
/// let start = ExteriorOrientation::look_at(place, place + Vector3::new(1.75, 20.0, 0.0), Vector3::z())?;
/// let found = resect_from(&Frame::new(start, camera), &control, &ResectionOptions::default())?;
/// assert!((found.sensor.exterior.projection_center() - Point3::new(0.0, 0.0, 10.0)).norm() < 1e-9);
/// # Ok::<(), collinear::Error>(())
/// ```
#[doc(alias("solvePnPRefineLM", "refine_absolute_pose", "useExtrinsicGuess"))]
pub fn resect_from<S: SensorModel + Adjustable + Clone>(
    sensor: &S,
    control: &[ControlPoint],
    options: &ResectionOptions,
) -> Result<Resection<S>, Error> {
    options.loss.check()?;
    let points = observed(control)?;
    let columns = Columns::resolve(sensor, &options.unknowns)?;
    check_enough(&points, &columns)?;
    for point in &points {
        sensor.project(&point.object)?;
    }
    let task = Task { points: &points, columns: &columns, options };
    let found = task.minimise(sensor);
    let (report, first) = task.report(&found)?;
    let exterior_first = options.unknowns.first() == Some(&Unknown::group(0));
    Ok(Resection { sensor: found.sensor, report, other: None, first, exterior_first })
}

fn observed(control: &[ControlPoint]) -> Result<Vec<Observed>, Error> {
    control
        .iter()
        .map(|c| Observed::new(c.object, c.image, &c.precision, c.object_precision.as_ref()))
        .collect()
}

/// Two equations a point, and one for each observed parameter.
fn check_enough(points: &[Observed], columns: &Columns) -> Result<(), Error> {
    let needed = (columns.len() - columns.observed()).div_ceil(2);
    if columns.len() > solve::MOST {
        return Err(Error::OutOfRange {
            what: "number of unknowns",
            value: columns.len() as f64,
            expected: "at most 48",
        });
    }
    if points.len() < needed || points.is_empty() {
        return Err(Error::TooFewPoints { needed: needed.max(1), got: points.len() });
    }
    Ok(())
}

/// Solutions farther from the best than this, by their starts' costs, are not worth refining.
const HOPELESS: f64 = 400.0;
/// So many minima of the object-space error are refined at most, and as many of the other starts: those often lie in one valley, and
/// would leave the second solution out.
const REFINED: usize = 4;

/// The poses that no small change improves, best first: at least one.
fn refined<C: CentralModel + Adjustable + Clone>(
    starts: Starts,
    camera: &C,
    task: &Task<'_>,
) -> Result<Vec<Minimised<Frame<C>>>, Error> {
    let Starts { minima, others, flat } = starts;
    let mut costs = Vec::with_capacity(minima.len() + others.len());
    let mut reason = None;
    let sources = minima.into_iter().map(|e| (0, e)).chain(others.into_iter().map(|e| (1, e)));
    for (source, exterior) in sources {
        let frame = Frame::new(exterior, camera.clone());
        match task.cost(&frame) {
            Ok(cost) => costs.push((cost, frame, source)),
            Err(e) => reason = reason.or(Some(e)),
        }
    }
    costs.sort_by(|a, b| a.0.total_cmp(&b.0));
    let Some(least) = costs.first().map(|c| c.0) else {
        return Err(reason.map_or(start::no_sight(0.0), Error::Projection));
    };
    let mut solutions: Vec<Minimised<Frame<C>>> = Vec::new();
    let mut refined = [0; 2];
    for (cost, frame, source) in costs {
        // Of flat points the second solution is told however bad it is.
        let hopeless = cost > HOPELESS * least && !(flat && source == 0 && solutions.len() < 2);
        if hopeless && !solutions.is_empty() {
            continue;
        }
        if refined[source] == REFINED {
            continue;
        }
        refined[source] += 1;
        let found = task.minimise(&frame);
        let rotation = |s: &Frame<C>| *s.exterior.camera_from_world().matrix();
        let same =
            |s: &Minimised<Frame<C>>| (rotation(&s.sensor) - rotation(&found.sensor)).norm() < 1e-5;
        if !solutions.iter().any(same) {
            solutions.push(found);
        }
    }
    solutions.sort_by(|a, b| a.convergence.final_cost.total_cmp(&b.convergence.final_cost));
    Ok(solutions)
}
