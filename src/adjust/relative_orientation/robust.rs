//! Relative orientation from pairs some of which are wrong.

use alloc::vec::Vec;

use super::{
    ImagePair, Motion, RelativeOrientation, RelativeOrientationOptions, Sight, Task,
    relative_orientation,
};
use crate::adjust::agreement;
use crate::adjust::five_point::five_point;
use crate::camera::CentralModel;
use crate::error::Error;
use crate::geometry::Pose;
use crate::numeric::consensus::{ConsensusOptions, Estimator, chosen, log10_false_alarms, search};
use crate::numeric::float;
use crate::numeric::least_squares::{NormalEquations, minimise};
use crate::numeric::robust_loss::RobustLoss;

/// A relative orientation that most pairs agree on.
#[derive(Clone, Debug)]
pub struct RobustRelativeOrientation {
    /// The orientation from the pairs that agree; its report and model are theirs, in order.
    pub orientation: RelativeOrientation,
    /// For each pair, whether it agrees.
    pub inliers: Vec<bool>,
    /// How many do.
    pub inlier_count: usize,
    /// Samples tried.
    pub trials: u32,
    /// log₁₀ of the number of motions with as many agreeing pairs that chance would give: far below zero for a result to be
    /// believed.
    pub log10_false_alarms: f64,
}

/// The motion between two cameras that the largest part of the pairs agrees on, and its adjustment.
///
/// *Model.* Random samples of five with every motion of [`five_point`], scored by the truncated squared correction of all pairs (one linear step: Sampson
/// 1982) and refined on those that agree (LO-RANSAC, Chum, Matas & Kittler 2003); then [`relative_orientation`] from these, until
/// they stay the same. A pair whose rays meet behind a camera does not agree.
///
/// *Units.* [`ConsensusOptions::threshold`] bounds √(vᵀPv): pixels where σ is 1.
///
/// *Whether to believe it.* A wrong pair agrees where its second point lies in a strip along a line, with a probability of at most p = 2 t D / A in a
/// picture of diagonal D and area A. The number of motions with k of n pairs agreeing that chance would give (Moisan & Stival 2004; ten
/// motions a sample)
///
/// ```text
/// NFA = 10 (n − 5) C(n, k) C(k, 5) p^(k − 5)
/// ```
///
/// must be below 10⁻⁶, or the result is an error. The same input and seed give the same result.
///
/// # Errors
/// [`Error::NoConsensus`] where no motion has [`ConsensusOptions::min_support`] pairs beyond its sample, or no more than chance gives; and as
/// [`relative_orientation`]. A point without a direction, as outside the lens's domain, is an error.
///
/// # Example
/// A third of the pairs is wrong:
/// ```
/// use collinear::adjust::{ImagePair, RelativeOrientationOptions, relative_orientation_robust};
/// use collinear::camera::{CentralModel, InteriorOrientation};
/// use collinear::numeric::consensus::ConsensusOptions;
/// use nalgebra::{Point2, Vector3};
///
/// let camera = InteriorOrientation::new([1000.0; 2], Point2::new(640.0, 480.0), 0.0)?;
/// let base = Vector3::new(0.8, 0.0, 0.6);
/// let pairs: Vec<ImagePair> = (0..60)
///     .map(|i| {
///         let (a, b) = (f64::from(i % 10), f64::from(i / 10));
///         let x = Vector3::new(0.4 * a - 2.0, 0.5 * b - 1.4, 5.0 + (1.7 * a + b).sin());
///         let wrong = Point2::new(20.0 * f64::from(i), 900.0 * (0.7 * f64::from(i)).sin().abs());
///         let seen = camera.project_direction(&(x - base))?;
///         Ok(ImagePair::new(camera.project_direction(&x)?, if i % 3 == 0 { wrong } else { seen }))
///     })
///     .collect::<Result<_, collinear::ProjectionError>>()?;
/// let found = relative_orientation_robust(
///     &camera,
///     &camera,
///     &pairs,
///     &ConsensusOptions { threshold: 0.5, ..Default::default() },
///     &RelativeOrientationOptions::default(),
/// )?;
/// assert_eq!(found.inlier_count, 40);
/// assert!((found.orientation.pose.origin.coords - base).norm() < 1e-9);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[doc(alias("findEssentialMat", "RANSAC", "LO-RANSAC", "estimate_relative_pose"))]
pub fn relative_orientation_robust(
    first: &dyn CentralModel,
    second: &dyn CentralModel,
    pairs: &[ImagePair],
    consensus: &ConsensusOptions,
    options: &RelativeOrientationOptions,
) -> Result<RobustRelativeOrientation, Error> {
    let sights = super::sights(first, second, pairs)?;
    let motions = Motions { cameras: [first, second], sights: &sights };
    let found = search(&motions, consensus)?;
    let limit = consensus.threshold * consensus.threshold;
    let adjust = |agreeing: &[ImagePair], motion: Motion| {
        let start = Pose::new(motion.rotation, motion.base.into());
        let options = RelativeOrientationOptions { start: Some(start), ..*options };
        let orientation = relative_orientation(first, second, agreeing, &options)?;
        let pose = orientation.pose;
        let motion = Motion { rotation: pose.rotation, base: pose.origin.coords };
        let again =
            (0..sights.len()).map(|i| motions.squared_residual(&motion, i) <= limit).collect();
        Ok((orientation, motion, again))
    };
    let agreed = agreement::settle(pairs, found, adjust, |count| {
        false_alarms(pairs, count, consensus.threshold, &sights)
    })?;
    Ok(RobustRelativeOrientation {
        orientation: agreed.adjusted,
        inliers: agreed.inliers,
        inlier_count: agreed.inlier_count,
        trials: agreed.trials,
        log10_false_alarms: agreed.log10_false_alarms,
    })
}

/// log₁₀ NFA.
fn false_alarms(pairs: &[ImagePair], agreeing: usize, threshold: f64, sights: &[Sight]) -> f64 {
    // Variances to pixels: the largest of both pictures, so that chance is never made too small.
    let variance = sights.iter().map(|s| s.covariance().amax()).fold(0.0, f64::max);
    let reach = threshold * float::sqrt(2.0 * variance);
    let [width, height] = agreement::rectangle(pairs.iter().map(|p| p.second), reach);
    let chance = (2.0 * reach * float::hypot(width, height) / (width * height)).min(1.0);
    log10_false_alarms(10, 5, pairs.len(), agreeing, chance)
}

/// The motions between two cameras.
struct Motions<'a> {
    cameras: [&'a dyn CentralModel; 2],
    sights: &'a [Sight],
}

impl Estimator for Motions<'_> {
    type Model = Motion;
    const SAMPLE: usize = 5;

    fn len(&self) -> usize {
        self.sights.len()
    }

    fn minimal(&self, sample: &[usize], models: &mut Vec<Motion>) {
        if let &[a, b, c, d, e] = sample {
            let side = |side: usize| [a, b, c, d, e].map(|i| self.sights[i].directions[side]);
            if let Ok(roots) = five_point(&side(0), &side(1)) {
                let motion = |p: Pose| Motion { rotation: p.rotation, base: p.origin.coords };
                models.extend(roots.into_iter().map(motion));
            }
        }
    }

    fn squared_residual(&self, motion: &Motion, index: usize) -> f64 {
        let sight = &self.sights[index];
        let squared = sight.sampson(&motion.rotation, &motion.base);
        if motion.sees(sight) { squared } else { f64::INFINITY }
    }

    fn refine(&self, motion: &Motion, inliers: &[bool]) -> Option<Motion> {
        let agreeing = chosen(self.sights, inliers);
        if agreeing.len() <= Self::SAMPLE {
            return None;
        }
        let task = Task { cameras: self.cameras, sights: &agreeing, loss: RobustLoss::Squared };
        let options = agreement::local_options();
        Some(minimise(&task, *motion, &mut NormalEquations::default(), &options).0)
    }
}
