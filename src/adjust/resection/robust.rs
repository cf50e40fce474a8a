//! Space resection from points some of which are wrong.

use alloc::vec::Vec;

use nalgebra::{Point3, Rotation3, Vector3};

use super::solve::{Observed, Task};
use super::{ControlPoint, Resection, ResectionOptions, observed, resect};
use crate::adjust::agreement;
use crate::adjust::p3p;
use crate::adjust::unknowns::{Columns, Unknown};
use crate::camera::{Adjustable, CentralModel, ExteriorOrientation, Frame};
use crate::error::Error;
use crate::numeric::consensus::{ConsensusOptions, Estimator, chosen, log10_false_alarms, search};
use crate::numeric::float;

/// A resection that most control points agree on.
#[derive(Clone, Debug)]
pub struct RobustResection<S> {
    /// The resection from the points that agree; its report is theirs, in order.
    pub resection: Resection<S>,
    /// For each control point, whether it agrees.
    pub inliers: Vec<bool>,
    /// How many do.
    pub inlier_count: usize,
    /// Samples tried.
    pub trials: u32,
    /// log₁₀ of the number of poses with as many agreeing points that chance would give: far below zero for a result to be
    /// believed.
    pub log10_false_alarms: f64,
}

/// The pose that the largest part of the control points agrees on, and its adjustment.
///
/// *Model.* Random samples of three with every pose of [`p3p`], scored by the truncated squared residual of all points
/// and refined on those that agree (Fischler & Bolles 1981; MSAC, Torr & Zisserman 2000; LO-RANSAC, Chum, Matas &
/// Kittler 2003); then [`resect`] from the points that agree, until they stay the same.
///
/// *Units.* [`ConsensusOptions::threshold`] bounds √(vᵀPv): pixels where σ is 1.
///
/// *Whether to believe it.* A wrong pose has the three points of its sample, and others by chance only: a point falls within the
/// threshold with the probability p = π t² / A, where A is the rectangle around the image points. The number of poses with
/// k of n points agreeing that chance would give over all samples (a contrario: Moisan & Stival 2004; four poses a sample)
///
/// ```text
/// NFA = 4 (n − 3) C(n, k) C(k, 3) p^(k − 3)
/// ```
///
/// must be below 10⁻⁶, or the result is an error. The same input and seed give the same result.
///
/// # Errors
/// [`Error::NoConsensus`] where no pose has [`ConsensusOptions::min_support`] points beyond its sample, or no more than chance
/// gives; [`Error::TooFewPoints`] for fewer than four; and as [`resect`]. A point without a direction, as outside the lens's
/// domain, is no error: it agrees with nothing.
///
/// # Example
/// ```
/// use collinear::adjust::{ControlPoint, ResectionOptions, resect_robust};
/// use collinear::numeric::consensus::ConsensusOptions;
/// use collinear::{ExteriorOrientation, Frame, InteriorOrientation, SensorModel};
/// use nalgebra::{Point2, Point3, Vector3};
///
/// let camera = InteriorOrientation::new([1000.0; 2], Point2::new(640.0, 480.0), 0.0)?;
/// let place = Point3::new(512_300.0, 5_412_000.0, 480.0);
/// let truth = ExteriorOrientation::look_at(place, place + Vector3::new(20.0, 90.0, -5.0), Vector3::z())?;
/// let frame = Frame::new(truth, camera);
/// let control: Vec<ControlPoint> = (0..40)
///     .map(|i| {
///         let (a, b) = (f64::from(i % 8), f64::from(i / 8));
///         let object = place + Vector3::new(10.0 * a - 15.0, 90.0 + 7.0 * b, 9.0 * b - 20.0 + a);
///         // Two of three are measured somewhere else.
///         let wrong = Point2::new(1279.0 * (0.37 * f64::from(i)).sin().abs(), 24.0 * f64::from(i));
///         Ok(ControlPoint::new(object, if i % 3 == 0 { frame.project(&object)? } else { wrong }))
///     })
///     .collect::<Result<_, collinear::ProjectionError>>()?;
/// let found = resect_robust(&camera, &control, &ConsensusOptions::default(), &ResectionOptions::default())?;
/// assert_eq!(found.inlier_count, 14);
/// assert!((found.resection.sensor.exterior.projection_center() - place).norm() < 1e-7);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[doc(alias("solvePnPRansac", "RANSAC", "LO-RANSAC", "estimate_absolute_pose"))]
pub fn resect_robust<C: CentralModel + Adjustable + Clone>(
    camera: &C,
    control: &[ControlPoint],
    consensus: &ConsensusOptions,
    options: &ResectionOptions,
) -> Result<RobustResection<Frame<C>>, Error> {
    let points = observed(control)?;
    let sights = points.iter().map(|p| camera.direction(&p.image).ok()).collect();
    let local = ResectionOptions {
        least_squares: agreement::local_options(),
        ..ResectionOptions::default()
    };
    let nowhere = ExteriorOrientation::new(Point3::origin(), Rotation3::identity());
    let columns = Columns::resolve(&Frame::new(nowhere, camera.clone()), &[Unknown::group(0)])?;
    let poses = Poses { camera, points: &points, sights, columns, options: local };
    let found = search(&poses, consensus)?;
    let limit = consensus.threshold * consensus.threshold;
    let adjust = |agreeing: &[ControlPoint], pose: ExteriorOrientation| {
        let options = ResectionOptions { start: Some(pose), ..options.clone() };
        let resection = resect(camera, agreeing, &options)?;
        let again = points.iter().map(|p| p.squared(&resection.sensor) <= limit).collect();
        let pose = resection.sensor.exterior;
        Ok((resection, pose, again))
    };
    let agreed = agreement::settle(control, found, adjust, |count| {
        false_alarms(&points, count, consensus.threshold)
    })?;
    Ok(RobustResection {
        resection: agreed.adjusted,
        inliers: agreed.inliers,
        inlier_count: agreed.inlier_count,
        trials: agreed.trials,
        log10_false_alarms: agreed.log10_false_alarms,
    })
}

/// log₁₀ NFA.
fn false_alarms(points: &[Observed], agreeing: usize, threshold: f64) -> f64 {
    let variance = points.iter().map(|p| p.covariance.amax()).fold(0.0, f64::max);
    // Variances to pixels: the largest, so that chance is never made too small.
    let reach = threshold * float::sqrt(variance);
    let [width, height] = agreement::rectangle(points.iter().map(|p| p.image), reach);
    let chance = (core::f64::consts::PI * reach * reach / (width * height)).min(1.0);
    log10_false_alarms(4, 3, points.len(), agreeing, chance)
}

/// The poses of one camera.
struct Poses<'a, C> {
    camera: &'a C,
    points: &'a [Observed],
    sights: Vec<Option<Vector3<f64>>>,
    columns: Columns,
    options: ResectionOptions,
}

impl<C: CentralModel + Adjustable + Clone> Estimator for Poses<'_, C> {
    type Model = ExteriorOrientation;
    const SAMPLE: usize = 3;

    fn len(&self) -> usize {
        self.points.len()
    }

    fn minimal(&self, sample: &[usize], models: &mut Vec<ExteriorOrientation>) {
        let &[a, b, c] = sample else { return };
        let (Some(fa), Some(fb), Some(fc)) = (self.sights[a], self.sights[b], self.sights[c])
        else {
            return;
        };
        let object = [a, b, c].map(|i| self.points[i].object);
        if let Ok(roots) = p3p(&object, &[fa, fb, fc]) {
            models.extend(roots.iter().map(|p| ExteriorOrientation::new(p.origin, p.rotation)));
        }
    }

    fn squared_residual(&self, model: &ExteriorOrientation, index: usize) -> f64 {
        let point = &self.points[index];
        let direction = model.pose().apply(&point.object).coords;
        match self.camera.project_direction(&direction) {
            Ok(image) => point.squared_from(image),
            Err(_) => f64::INFINITY,
        }
    }

    fn refine(&self, model: &ExteriorOrientation, inliers: &[bool]) -> Option<ExteriorOrientation> {
        let points = chosen(self.points, inliers);
        if points.len() <= Self::SAMPLE {
            return None;
        }
        let task = Task { points: &points, columns: &self.columns, options: &self.options };
        Some(task.minimise(&Frame::new(*model, self.camera.clone())).sensor.exterior)
    }
}
