//! What robust estimators do after their search: the adjustment of what agrees, and whether to believe it.

use alloc::vec::Vec;

use nalgebra::Point2;

use crate::error::Error;
use crate::numeric::consensus::{Consensus, chosen};
use crate::numeric::least_squares::LeastSquaresOptions;

/// Steps of the refinement of a promising model; the last adjustment does the rest.
const LOCAL_ITERATIONS: u32 = 4;
/// Adjustments until the observations that agree stay the same.
const ROUNDS: u32 = 10;
/// log₁₀ of the false alarms that are borne.
const CHANCE: f64 = -6.0;

/// How a promising model is refined during the search.
pub(super) fn local_options() -> LeastSquaresOptions {
    LeastSquaresOptions {
        max_iterations: LOCAL_ITERATIONS,
        decrease_tolerance: 1e-3,
        ..LeastSquaresOptions::default()
    }
}

/// An adjustment of the observations that agree with it.
pub(super) struct Agreed<A> {
    pub(super) adjusted: A,
    pub(super) inliers: Vec<bool>,
    pub(super) inlier_count: usize,
    pub(super) trials: u32,
    pub(super) log10_false_alarms: f64,
}

/// Adjusts what agrees until it stays the same, and refuses what chance alone could give.
///
/// `adjust` takes the observations that agree and the model to start from, and gives the adjustment, its model, and who agrees with
/// that; `false_alarms` is log₁₀ of the number of models with so many agreeing observations that chance would give.
///
/// # Errors
/// Those of `adjust`, and [`Error::NoConsensus`].
pub(super) fn settle<T: Clone, M, A>(
    all: &[T],
    found: Consensus<M>,
    mut adjust: impl FnMut(&[T], M) -> Result<(A, M, Vec<bool>), Error>,
    false_alarms: impl Fn(usize) -> f64,
) -> Result<Agreed<A>, Error> {
    let Consensus { mut model, mut inliers, trials, .. } = found;
    let mut round = 1;
    let (adjusted, count) = loop {
        let agreeing = chosen(all, &inliers);
        let (adjusted, moved, again) = adjust(&agreeing, model)?;
        if again == inliers || round == ROUNDS {
            break (adjusted, agreeing.len());
        }
        (model, inliers) = (moved, again);
        round += 1;
    };
    let log10_false_alarms = false_alarms(count);
    if !(log10_false_alarms < CHANCE) {
        return Err(Error::NoConsensus { inliers: count, needed: count + 1, trials });
    }
    Ok(Agreed { adjusted, inliers, inlier_count: count, trials, log10_false_alarms })
}

/// Width and height of the rectangle around image points, with a margin on every side.
pub(super) fn rectangle(points: impl Iterator<Item = Point2<f64>>, margin: f64) -> [f64; 2] {
    let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
    for point in points {
        for i in 0..2 {
            low[i] = low[i].min(point[i]);
            high[i] = high[i].max(point[i]);
        }
    }
    [0, 1].map(|i| high[i] - low[i] + 2.0 * margin)
}
