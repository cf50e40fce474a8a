//! The model that most observations agree on, found by trying small samples.
//!
//! Random sample consensus (Fischler & Bolles 1981), scored by the truncated squared residual (MSAC, Torr & Zisserman
//! 2000) and with a local refinement of each new best model (LO-RANSAC, Chum, Matas & Kittler 2003). The search is
//! deterministic: the same input, options and seed give the same model.

use alloc::vec;
use alloc::vec::Vec;

use super::float;
use crate::error::Error;

/// A family of models that can be fitted to few observations and judged by all. [`search`] shows one.
pub trait Estimator {
    /// One model.
    type Model: Clone;
    /// The number of observations that determine a model.
    const SAMPLE: usize;

    /// The number of observations.
    fn len(&self) -> usize;
    /// Whether there is no observation.
    fn is_empty(&self) -> bool {
        self.len() == 0
    }
    /// Appends the models (none, one or several) that the sampled observations determine.
    fn minimal(&self, sample: &[usize], models: &mut Vec<Self::Model>);
    /// The squared residual of one observation; infinite where the model does not predict it.
    fn squared_residual(&self, model: &Self::Model, index: usize) -> f64;
    /// A model fitted to all the observations marked `true`, starting from `model`; `None` where they do not
    /// determine one.
    fn refine(&self, model: &Self::Model, inliers: &[bool]) -> Option<Self::Model>;
}

/// How to search.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ConsensusOptions {
    /// The residual up to which an observation agrees with a model, in the residual's units.
    pub threshold: f64,
    /// The wanted probability that one all-inlier sample was drawn; the search ends when it is reached.
    pub confidence: f64,
    /// Trials allowed.
    pub max_trials: u32,
    /// Trials done at least.
    pub min_trials: u32,
    /// Observations that must agree beyond the sample itself, or the search fails.
    pub min_support: usize,
    /// Start of the random sequence.
    pub seed: u64,
}

impl Default for ConsensusOptions {
    fn default() -> Self {
        Self {
            threshold: 2.0,
            confidence: 0.9999,
            max_trials: 20_000,
            min_trials: 32,
            min_support: 3,
            seed: 0,
        }
    }
}

/// The model found and who agrees with it.
#[derive(Clone, Debug)]
pub struct Consensus<M> {
    /// The model, refined on its inliers.
    pub model: M,
    /// For each observation, whether its residual is within the threshold.
    pub inliers: Vec<bool>,
    /// How many are.
    pub inlier_count: usize,
    /// Trials done.
    pub trials: u32,
}

/// SplitMix64 (Steele, Lea & Flood 2014): a sequence fixed by its seed on every machine and in every release.
#[derive(Clone, Debug)]
struct SplitMix64(u64);

impl SplitMix64 {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    fn below(&mut self, bound: usize) -> usize {
        ((u128::from(self.next()) * bound as u128) >> 64) as usize
    }
}

struct Scored<M> {
    model: M,
    inliers: Vec<bool>,
    count: usize,
    score: f64,
}

/// The score of a model; `None` as soon as it is not below `bar`.
fn score<E: Estimator>(
    estimator: &E,
    model: E::Model,
    threshold: f64,
    bar: f64,
) -> Option<Scored<E::Model>> {
    let limit = threshold * threshold;
    let mut score = 0.0;
    for index in 0..estimator.len() {
        score += estimator.squared_residual(&model, index).min(limit);
        if !(score < bar) {
            return None;
        }
    }
    // Few models come so far: who agrees is asked again.
    let inliers: Vec<bool> = (0..estimator.len())
        .map(|index| estimator.squared_residual(&model, index) <= limit)
        .collect();
    let count = inliers.iter().filter(|i| **i).count();
    Some(Scored { model, inliers, count, score })
}

/// Searches for the model with the smallest truncated sum of squared residuals.
///
/// # Errors
/// [`Error::TooFewPoints`] where there are fewer observations than a sample needs, [`Error::OutOfRange`] for a
/// threshold that is not a positive number, and [`Error::NoConsensus`] where no model gathers
/// `SAMPLE + min_support` observations.
///
/// # Example
/// The level that most readings agree on, from samples of one:
///
/// ```
/// use collinear::numeric::consensus::{ConsensusOptions, Estimator, search};
///
/// struct Readings(Vec<f64>);
///
/// impl Estimator for Readings {
///     type Model = f64;
///     const SAMPLE: usize = 1;
///     fn len(&self) -> usize {
///         self.0.len()
///     }
///     fn minimal(&self, sample: &[usize], models: &mut Vec<f64>) {
///         models.push(self.0[sample[0]]);
///     }
///     fn squared_residual(&self, level: &f64, index: usize) -> f64 {
///         (self.0[index] - level).powi(2)
///     }
///     fn refine(&self, _: &f64, inliers: &[bool]) -> Option<f64> {
///         let agreeing: Vec<f64> = self.0.iter().zip(inliers).filter(|(_, i)| **i).map(|(r, _)| *r).collect();
///         Some(agreeing.iter().sum::<f64>() / agreeing.len() as f64)
///     }
/// }
///
/// let readings = Readings(vec![9.0, 10.0, 11.0, 10.0, 10.0, 50.0, 70.0, -30.0]);
/// let found = search(&readings, &ConsensusOptions { threshold: 2.0, ..Default::default() })?;
/// assert_eq!((found.model, found.inlier_count), (10.0, 5));
/// # Ok::<(), collinear::Error>(())
/// ```
pub fn search<E: Estimator>(
    estimator: &E,
    options: &ConsensusOptions,
) -> Result<Consensus<E::Model>, Error> {
    let n = estimator.len();
    if n < E::SAMPLE {
        return Err(Error::TooFewPoints { needed: E::SAMPLE, got: n });
    }
    if !(options.threshold > 0.0 && options.threshold.is_finite()) {
        return Err(Error::OutOfRange {
            what: "consensus threshold",
            value: options.threshold,
            expected: "a positive number",
        });
    }
    let mut random = SplitMix64(options.seed);
    let mut sample = vec![0; E::SAMPLE];
    let mut models = Vec::new();
    let mut best: Option<Scored<E::Model>> = None;
    let mut trials = 0;
    let mut needed_trials = options.max_trials;
    while trials < options.max_trials && (trials < needed_trials || trials < options.min_trials) {
        trials += 1;
        draw(&mut random, n, &mut sample);
        models.clear();
        estimator.minimal(&sample, &mut models);
        for model in models.drain(..) {
            let bar = best.as_ref().map_or(f64::INFINITY, |b| b.score);
            let Some(candidate) = score(estimator, model, options.threshold, bar) else {
                continue;
            };
            let improved = polish(estimator, candidate, options.threshold);
            needed_trials = trials_needed(improved.count, n, E::SAMPLE, options.confidence);
            best = Some(improved);
        }
    }
    let needed = E::SAMPLE.saturating_add(options.min_support).min(n);
    match best {
        Some(b) if b.count >= needed => {
            Ok(Consensus { model: b.model, inliers: b.inliers, inlier_count: b.count, trials })
        }
        other => Err(Error::NoConsensus { inliers: other.map_or(0, |b| b.count), needed, trials }),
    }
}

/// Those marked `true`, as the inliers of a search.
pub(crate) fn chosen<T: Clone>(all: &[T], marks: &[bool]) -> Vec<T> {
    all.iter().zip(marks).filter(|(_, mark)| **mark).map(|(item, _)| item.clone()).collect()
}

/// `sample.len()` different indices below `n`, by Floyd's method.
fn draw(random: &mut SplitMix64, n: usize, sample: &mut [usize]) {
    let k = sample.len();
    for (filled, top) in (n - k..n).enumerate() {
        let index = random.below(top + 1);
        let taken = sample[..filled].contains(&index);
        sample[filled] = if taken { top } else { index };
    }
}

/// Refits a model to its inliers until its score no longer falls.
fn polish<E: Estimator>(
    estimator: &E,
    mut current: Scored<E::Model>,
    threshold: f64,
) -> Scored<E::Model> {
    for _ in 0..10 {
        let Some(refined) = estimator.refine(&current.model, &current.inliers) else { break };
        let Some(better) = score(estimator, refined, threshold, current.score) else { break };
        current = better;
    }
    current
}

/// Trials until an all-inlier sample was drawn with the wanted probability: ln(1 − p) / ln(1 − wᵏ).
fn trials_needed(inliers: usize, n: usize, sample: usize, confidence: f64) -> u32 {
    let mut all_inliers = 1.0;
    for k in 0..sample {
        all_inliers *= (inliers.saturating_sub(k)) as f64 / (n - k) as f64;
    }
    if all_inliers >= 1.0 {
        return 1;
    }
    let trials = float::ln(1.0 - confidence) / float::ln(1.0 - all_inliers);
    if trials.is_finite() { float::ceil(trials.min(f64::from(u32::MAX))) as u32 } else { u32::MAX }
}

/// log₁₀ of the number of models with `agreeing` of `n` observations that chance alone would give (a contrario: Moisan & Stival 2004), where
/// a sample of `sample` observations determines up to `models` and another agrees with a wrong one with the probability `chance`.
///
/// ```text
/// NFA = models (n − sample) C(n, k) C(k, sample) chance^(k − sample)
/// ```
#[cfg(feature = "std")]
pub(crate) fn log10_false_alarms(
    models: u32,
    sample: usize,
    n: usize,
    agreeing: usize,
    chance: f64,
) -> f64 {
    let choices = |n: usize, k: usize| -> f64 {
        (0..k).map(|i| float::ln((n - i) as f64) - float::ln((i + 1) as f64)).sum()
    };
    let extra = agreeing.saturating_sub(sample);
    let logarithm = float::ln(f64::from(models) * n.saturating_sub(sample).max(1) as f64)
        + choices(n, agreeing.min(n))
        + choices(agreeing, agreeing.min(sample))
        + extra as f64 * float::ln(chance);
    logarithm / core::f64::consts::LN_10
}

#[cfg(test)]
mod tests {
    use super::*;

    #[cfg(feature = "std")]
    #[test]
    fn false_alarms_of_a_small_case() {
        // 4 (10 − 3) C(10, 5) C(5, 3) 0.01² = 28 · 252 · 10 · 10⁻⁴ = 7.056.
        let found = log10_false_alarms(4, 3, 10, 5, 0.01);
        assert!((found - 7.056f64.log10()).abs() < 1e-13, "{found}");
    }

    /// y = a + b x.
    struct Line(Vec<[f64; 2]>);

    impl Estimator for Line {
        type Model = [f64; 2];
        const SAMPLE: usize = 2;
        fn len(&self) -> usize {
            self.0.len()
        }
        fn minimal(&self, s: &[usize], models: &mut Vec<[f64; 2]>) {
            let ([x1, y1], [x2, y2]) = (self.0[s[0]], self.0[s[1]]);
            if x1 != x2 {
                let b = (y2 - y1) / (x2 - x1);
                models.push([y1 - b * x1, b]);
            }
        }
        fn squared_residual(&self, m: &[f64; 2], i: usize) -> f64 {
            (self.0[i][1] - m[0] - m[1] * self.0[i][0]).powi(2)
        }
        fn refine(&self, _: &[f64; 2], inliers: &[bool]) -> Option<[f64; 2]> {
            let (mut n, mut sx, mut sy, mut sxx, mut sxy) = (0.0, 0.0, 0.0, 0.0, 0.0);
            for ([x, y], _) in self.0.iter().zip(inliers).filter(|(_, i)| **i) {
                (n, sx, sy, sxx, sxy) = (n + 1.0, sx + x, sy + y, sxx + x * x, sxy + x * y);
            }
            let d = n * sxx - sx * sx;
            (d > 0.0).then(|| [(sy * sxx - sx * sxy) / d, (n * sxy - sx * sy) / d])
        }
    }

    #[test]
    fn line_among_blunders() {
        let mut random = SplitMix64(7);
        let points: Vec<[f64; 2]> = (0..100)
            .map(|i| {
                let x = f64::from(i);
                let noise = random.below(1000) as f64 / 1000.0 - 0.5;
                if i % 5 < 3 {
                    [x, random.below(4000) as f64]
                } else {
                    [x, 20.0 + 3.0 * x + 0.1 * noise]
                }
            })
            .collect();
        let options = ConsensusOptions { threshold: 0.2, ..Default::default() };
        let found = search(&Line(points.clone()), &options).unwrap();
        assert!(found.inlier_count >= 40, "{}", found.inlier_count);
        assert!((found.model[0] - 20.0).abs() < 0.05 && (found.model[1] - 3.0).abs() < 1e-3);
        let again = search(&Line(points), &options).unwrap();
        assert_eq!(found.model, again.model);
    }

    #[test]
    fn failure_says_how_far_it_got() {
        let points =
            vec![[0.0, 0.0], [1.0, 5.0], [2.0, -3.0], [3.0, 40.0], [4.0, -17.0], [5.0, 100.0]];
        let options = ConsensusOptions { threshold: 1e-3, max_trials: 50, ..Default::default() };
        let error = search(&Line(points), &options).unwrap_err();
        assert_eq!(error, Error::NoConsensus { inliers: 2, needed: 5, trials: 50 });
        assert_eq!(
            search(&Line(vec![[0.0; 2]]), &options).unwrap_err(),
            Error::TooFewPoints { needed: 2, got: 1 }
        );
    }

    #[test]
    fn splitmix64_published_sequence() {
        // Reference sequence for seed 1234567 (Vigna's splitmix64.c, as published on rosettacode.org).
        let mut random = SplitMix64(1_234_567);
        assert_eq!(random.next(), 6_457_827_717_110_365_317);
        assert_eq!(random.next(), 3_203_168_211_198_807_973);
    }
}
