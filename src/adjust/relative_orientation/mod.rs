//! Relative orientation: how two cameras stood to each other, from what both show.

mod pair;
mod robust;

use alloc::vec::Vec;

use nalgebra::{Point2, Point3, Rotation3, SMatrix, SVector, Vector3};

use self::pair::{Settled, Sight};
use super::five_point::{five_point, in_front, moved, tangents};
use super::nearest_point;
use super::precision::Precision;
use super::report::{self, Report};
use super::settle::minimise_to_rounding;
use crate::camera::CentralModel;
use crate::error::Error;
use crate::geometry::{Pose, Ray};
use crate::numeric::least_squares::{
    Convergence, Damped, LeastSquaresOptions, NormalEquations, Problem, unit_weight,
};
use crate::numeric::robust_loss::RobustLoss;

pub use robust::{RobustRelativeOrientation, relative_orientation_robust};

/// A point that two pictures show.
#[derive(Clone, Copy, Debug, PartialEq)]
#[doc(alias("match", "correspondence", "tie point", "conjugate points"))]
pub struct ImagePair {
    /// In the first picture, in pixels.
    pub first: Point2<f64>,
    /// In the second.
    pub second: Point2<f64>,
    /// How good both measurements are; σ = 1 pixel unless said otherwise.
    pub precisions: [Precision<2>; 2],
}

impl ImagePair {
    /// A pair measured with σ = 1 pixel in both pictures.
    #[must_use]
    pub fn new(first: Point2<f64>, second: Point2<f64>) -> Self {
        Self { first, second, precisions: [Precision::default(); 2] }
    }

    /// With another precision in both pictures.
    #[must_use]
    pub fn with_precision(mut self, precision: Precision<2>) -> Self {
        self.precisions = [precision; 2];
        self
    }
}

/// How to orient.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RelativeOrientationOptions {
    /// An approximate pose of the second camera in the first one's frame, of whatever base, to be used instead of those found from samples of
    /// five. With it five pairs are enough.
    pub start: Option<Pose>,
    /// How each pair's residual enters, in units of its standard deviation.
    pub loss: RobustLoss,
    /// Whether covariances and tests use the σ₀ found, or believe the stated precisions.
    pub estimate_sigma: bool,
    /// When to stop.
    pub least_squares: LeastSquaresOptions,
}

impl Default for RelativeOrientationOptions {
    fn default() -> Self {
        Self {
            start: None,
            loss: RobustLoss::Squared,
            estimate_sigma: true,
            least_squares: LeastSquaresOptions::default(),
        }
    }
}

/// The relative orientation of two pictures, with its report.
#[derive(Clone, Debug)]
pub struct RelativeOrientation {
    /// second_from_first, in camera axes (x right, y down, z forward); its origin is the base b, of length one.
    pub pose: Pose,
    /// Two unit vectors across the base and each other, along which the first two parameters move it.
    pub across: [Vector3<f64>; 2],
    /// How good it is. The parameters are the base along `across` and the left rotation vector δ of R ← exp(\[δ\]×) R, all in radians; the values
    /// are x and y in the first and x and y in the second picture of each pair.
    pub report: Report,
    /// The point of each pair in the first camera's frame, in bases; `None` where its rays are parallel or meet behind a camera.
    pub model: Vec<Option<Point3<f64>>>,
}

/// The motion between two calibrated cameras from n ≥ 6 points that both show: relative orientation.
///
/// *Model.* The rays of a point and the base lie in one plane; measurements are corrected until they do, as little as they can:
///
/// ```text
/// minimise Σ ρ(vᵢᵀ Pᵢ vᵢ)   subject to   b · (dᵢ × Rᵀ dᵢ′) = 0,   ‖b‖ = 1
/// ```
///
/// over base, rotation and the corrections v of four coordinates a pair (the condition of coplanarity, in the Gauß–Helmert model). Each pair's
/// corrections are found to rounding for each trial of the five parameters, so that this is the maximum-likelihood estimate, the same as of an
/// adjustment with the model points as unknowns.
///
/// *Start.* Every motion ([`five_point`]) of some samples of five; the best are refined. Wrong pairs spoil that: see
/// [`relative_orientation_robust`].
///
/// *Frames and units.* Camera axes of the first camera, lengths in bases, pixels for the corrections. Any [`CentralModel`] with its lens.
///
/// # Errors
/// [`Error::TooFewPoints`], [`Error::NotFinite`]; as [`Precision::covariance`]; [`Error::Projection`] where an image point has no
/// direction; [`Error::Degenerate`] where no sample determines a motion, where the pictures have no parallax, as from one place (the measure
/// is the largest sine of the angle between a pair's rays), and where the pairs leave a parameter open (one over the condition);
/// [`Error::NotConverged`].
///
/// # Example
/// The sample data of the program relor (Dewitt 1998, for Wolf & Dewitt, Elements of Photogrammetry): f = 152.113 mm, six points of a near vertical pair.
/// The expected numbers are SciPy's and mpmath's for an adjustment with the six model points as unknowns.
/// ```
/// use collinear::InteriorOrientation;
/// use collinear::adjust::{ImagePair, RelativeOrientationOptions, relative_orientation};
/// use collinear::geometry::Affine2;
/// use nalgebra::Point2;
///
/// // With the identity image coordinates are photo millimetres, y up.
/// let camera = InteriorOrientation::from_photogrammetric(152.113, Point2::origin(), &Affine2::identity())?;
/// let pairs = [
///     ((-4.878, 1.974), (-97.920, -2.923)),
///     ((89.307, 2.709), (-1.507, -1.856)),
///     ((0.261, 84.144), (-90.917, 78.970)),
///     ((90.334, 83.843), (-1.571, 79.470)),
///     ((-4.668, -86.821), (-100.060, -95.748)),
///     ((88.599, -85.274), (-0.965, -94.319)),
/// ]
/// .map(|(l, r)| ImagePair::new(Point2::new(l.0, l.1), Point2::new(r.0, r.1)));
/// let found = relative_orientation(&camera, &camera, &pairs, &RelativeOrientationOptions::default())?;
/// // by/bx and bz/bx; y is down and z forward in camera axes.
/// let b = found.pose.origin;
/// assert!((b.y / b.x - 0.018685255813455218).abs() < 1e-12 && (b.z / b.x - 0.04142631172336817).abs() < 1e-12);
/// assert!((found.report.sigma0.unwrap() - 0.0045223251787618775).abs() < 1e-12);
/// # Ok::<(), collinear::Error>(())
/// ```
#[doc(alias("essential matrix", "recoverPose", "relative pose", "coplanarity", "y-parallax"))]
pub fn relative_orientation(
    first: &dyn CentralModel,
    second: &dyn CentralModel,
    pairs: &[ImagePair],
    options: &RelativeOrientationOptions,
) -> Result<RelativeOrientation, Error> {
    let needed = if options.start.is_some() { 5 } else { 6 };
    if pairs.len() < needed {
        return Err(Error::TooFewPoints { needed, got: pairs.len() });
    }
    let sights = sights(first, second, pairs)?;
    let task = Task { cameras: [first, second], sights: &sights, loss: options.loss };
    let starts = match options.start {
        Some(start) => vec_of_start(&start)?,
        None => task.starts()?,
    };
    let mut best: Option<(Motion, Convergence, usize)> = None;
    for start in starts {
        let mut linear = NormalEquations::default();
        let (motion, convergence) =
            minimise_to_rounding(&task, start, &mut linear, &options.least_squares);
        let front = task.front(&motion);
        let better = best.as_ref().is_none_or(|(_, c, f)| {
            front > *f || front == *f && convergence.final_cost < c.final_cost
        });
        if better {
            best = Some((motion, convergence, front));
        }
    }
    let nothing = Error::Degenerate { what: "pairs without a motion", measure: 0.0, limit: 0.0 };
    let (motion, convergence, _) = best.ok_or(nothing)?;
    let parallax = sights
        .iter()
        .map(|s| s.directions[0].cross(&(motion.rotation.inverse() * s.directions[1])).norm())
        .fold(0.0, f64::max);
    let limit = 64.0 * f64::EPSILON;
    if !(parallax > limit) {
        let what = "pictures without parallax";
        return Err(Error::Degenerate { what, measure: parallax, limit });
    }
    convergence.check()?;
    task.finish(&motion, options.estimate_sigma, convergence)
}

/// The start a caller gives, its base brought to length one.
fn vec_of_start(start: &Pose) -> Result<Vec<Motion>, Error> {
    let finite = start.rotation.matrix().iter().chain(start.origin.iter()).all(|c| c.is_finite());
    if !finite {
        return Err(Error::NotFinite { what: "approximate relative orientation" });
    }
    let base = start.origin.coords;
    match base.try_normalize(0.0) {
        Some(base) => Ok(Vec::from([Motion { rotation: start.rotation, base }])),
        None => Err(Error::Degenerate {
            what: "base of an approximate relative orientation",
            measure: 0.0,
            limit: 0.0,
        }),
    }
}

fn sights(
    first: &dyn CentralModel,
    second: &dyn CentralModel,
    pairs: &[ImagePair],
) -> Result<Vec<Sight>, Error> {
    pairs.iter().map(|pair| Sight::new(first, second, pair)).collect()
}

/// Base and rotation.
#[derive(Clone, Copy, Debug)]
struct Motion {
    rotation: Rotation3<f64>,
    base: Vector3<f64>,
}

impl Motion {
    fn sees(&self, sight: &Sight) -> bool {
        in_front(&self.rotation, &self.base, &sight.directions[0], &sight.directions[1])
    }
}

/// The least-squares problem of the five parameters.
struct Task<'a> {
    cameras: [&'a dyn CentralModel; 2],
    sights: &'a [Sight],
    loss: RobustLoss,
}

/// Samples of five tried for a start.
const SAMPLES: usize = 24;
/// Of their motions so many are refined.
const REFINED: usize = 4;

impl Task<'_> {
    /// How many points are before both cameras.
    fn front(&self, motion: &Motion) -> usize {
        self.sights.iter().filter(|s| motion.sees(s)).count()
    }

    /// The best motions of samples spread over the pairs.
    fn starts(&self) -> Result<Vec<Motion>, Error> {
        let n = self.sights.len();
        let mut found: Vec<(usize, f64, Motion)> = Vec::new();
        let mut failure = None;
        let mut state = 1u64;
        for _ in 0..SAMPLES {
            let mut sample = [0; 5];
            for k in 0..5 {
                // The k-th of the numbers not yet taken.
                state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
                let mut index = ((u128::from(state) * (n - k) as u128) >> 64) as usize;
                let mut taken = sample;
                taken[..k].sort_unstable();
                for t in &taken[..k] {
                    index += usize::from(index >= *t);
                }
                sample[k] = index;
            }
            let side = |side: usize| sample.map(|i| self.sights[i].directions[side]);
            match five_point(&side(0), &side(1)) {
                Ok(roots) => found.extend(roots.into_iter().map(|pose| {
                    let motion = Motion { rotation: pose.rotation, base: pose.origin.coords };
                    (self.front(&motion), self.sampson(&motion), motion)
                })),
                Err(error) => failure = Some(error),
            }
        }
        found.sort_by(|a, b| b.0.cmp(&a.0).then(a.1.total_cmp(&b.1)));
        found.truncate(REFINED);
        let nothing =
            Error::Degenerate { what: "pairs without a motion", measure: 0.0, limit: 0.0 };
        if found.is_empty() {
            return Err(failure.unwrap_or(nothing));
        }
        Ok(found.into_iter().map(|f| f.2).collect())
    }

    /// The cost with each pair corrected by one linear step (Sampson 1982).
    fn sampson(&self, motion: &Motion) -> f64 {
        let squared = |s: &Sight| s.sampson(&motion.rotation, &motion.base);
        0.5 * self.sights.iter().map(|s| self.loss.cost(squared(s))).sum::<f64>()
    }

    fn settle(&self, motion: &Motion, sight: &Sight) -> Option<Settled> {
        sight.settle(&self.cameras, &motion.rotation, &motion.base)
    }

    fn finish(
        &self,
        motion: &Motion,
        estimate_sigma: bool,
        convergence: Convergence,
    ) -> Result<RelativeOrientation, Error> {
        let across = tangents(&motion.base);
        let lost = Error::NotFinite { what: "corrected image point" };
        let settled = self
            .sights
            .iter()
            .map(|sight| self.settle(motion, sight).ok_or(lost))
            .collect::<Result<Vec<_>, _>>()?;
        let mut normal = SMatrix::<f64, 5, 5>::zeros();
        let mut weighted_sum = 0.0;
        let robust = |s: &Settled| self.loss.weight(s.squared());
        for s in &settled {
            let row = s.row / s.variance.sqrt();
            normal += row * row.transpose() * robust(s);
            weighted_sum += s.squared() * robust(s);
        }
        let (q, condition) = report::fixed_cofactor(&normal)?;
        let redundancy = settled.len() - 5;
        let sigma0 = unit_weight(weighted_sum, redundancy);
        let sigma = report::sigma(sigma0, estimate_sigma);
        let mut values = Vec::with_capacity(4 * settled.len());
        for (sight, s) in self.sights.iter().zip(&settled) {
            // A pair that the loss ignores has an infinite variance.
            let weight = robust(s).max(1e-12);
            let covariance = sight.covariance() / weight;
            let gain = s.gain / s.variance;
            let explained = s.row.dot(&(q * s.row));
            let unexplained = gain * gain.transpose() * (s.variance / weight - explained);
            values.extend(report::observed(&unexplained, &covariance, &s.corrections, sigma));
        }
        let pose = Pose::new(motion.rotation, motion.base.into());
        let model = settled.iter().map(|s| model_point(&pose, s)).collect();
        let report = Report {
            observations: 4 * settled.len(),
            unknowns: 5 + 3 * settled.len(),
            redundancy,
            weighted_sum,
            sigma0,
            sigma,
            covariance: report::covariance(&q, sigma),
            condition,
            values,
            convergence,
        };
        Ok(RelativeOrientation { pose, across, report, model })
    }
}

/// Where the corrected rays meet.
fn model_point(pose: &Pose, settled: &Settled) -> Option<Point3<f64>> {
    let first = Ray::new(Point3::origin(), settled.directions[0]).ok()?;
    let second = Ray::new(pose.origin, pose.rotation.inverse() * settled.directions[1]).ok()?;
    nearest_point(&[first, second], None).ok().map(|nearest| nearest.point)
}

impl Problem for Task<'_> {
    type State = Motion;
    type Linear = NormalEquations<5>;
    type Step = SVector<f64, 5>;

    fn cost(&self, motion: &Motion) -> f64 {
        let mut sum = 0.0;
        for sight in self.sights {
            let Some(settled) = self.settle(motion, sight) else { return f64::INFINITY };
            sum += self.loss.cost(settled.squared());
        }
        0.5 * sum
    }

    fn linearise(&self, motion: &Motion, linear: &mut NormalEquations<5>) -> f64 {
        linear.clear();
        for sight in self.sights {
            let Some(settled) = self.settle(motion, sight) else { continue };
            let root = settled.variance.sqrt();
            let robust = self.loss.weight(settled.squared());
            linear.add(&(settled.row / root), settled.misclosure / root, robust);
        }
        linear.scaled_gradient()
    }

    fn solve(
        &self,
        _: &Motion,
        linear: &NormalEquations<5>,
        damping: f64,
    ) -> Option<Damped<SVector<f64, 5>>> {
        linear.solve(damping, &SVector::repeat(1.0))
    }

    fn apply(&self, motion: &Motion, step: &SVector<f64, 5>) -> Motion {
        match moved(&motion.rotation, &motion.base, &tangents(&motion.base), step) {
            Some((rotation, base)) => Motion { rotation, base },
            None => *motion,
        }
    }
}
