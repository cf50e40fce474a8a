//! Which samples a search draws, and how many.

use std::cell::RefCell;
use std::collections::BTreeMap;

use collinear::Error;
use collinear::numeric::consensus::{ConsensusOptions, Estimator, search};

/// Keeps the samples it is given, and makes no model of them.
struct Recorder<const K: usize> {
    len: usize,
    samples: RefCell<Vec<Vec<usize>>>,
}

impl<const K: usize> Estimator for Recorder<K> {
    type Model = ();
    const SAMPLE: usize = K;

    fn len(&self) -> usize {
        self.len
    }

    fn minimal(&self, sample: &[usize], _: &mut Vec<()>) {
        self.samples.borrow_mut().push(sample.to_vec());
    }

    fn squared_residual(&self, (): &(), _: usize) -> f64 {
        f64::INFINITY
    }

    fn refine(&self, (): &(), _: &[bool]) -> Option<()> {
        None
    }
}

fn drawn<const K: usize>(len: usize, trials: u32) -> BTreeMap<Vec<usize>, u32> {
    let recorder = Recorder::<K> { len, samples: RefCell::default() };
    let options =
        ConsensusOptions { max_trials: trials, min_support: 0, ..ConsensusOptions::default() };
    assert_eq!(
        search(&recorder, &options).err(),
        Some(Error::NoConsensus { inliers: 0, needed: K, trials })
    );
    let mut counts = BTreeMap::new();
    for mut sample in recorder.samples.into_inner() {
        sample.sort_unstable();
        *counts.entry(sample).or_insert(0) += 1;
    }
    counts
}

#[test]
fn every_sample_is_drawn_equally_often_and_repeats_no_observation() {
    // Of five observations there are 10 samples of three: 2000 of 20 000 draws each, with σ = √(20 000 · 0.1 · 0.9) = 42.
    let counts = drawn::<3>(5, 20_000);
    assert_eq!(counts.len(), 10);
    for (sample, count) in &counts {
        assert!(sample.windows(2).all(|w| w[0] < w[1]) && sample[2] < 5, "{sample:?}");
        assert!(count.abs_diff(2000) < 5 * 42, "{sample:?} {count}");
    }
    // Samples of one: 4000 each, σ = 57; and all there are.
    let counts = drawn::<1>(5, 20_000);
    assert!(counts.len() == 5 && counts.values().all(|c| c.abs_diff(4000) < 5 * 57), "{counts:?}");
    assert_eq!(drawn::<3>(3, 50), BTreeMap::from([(vec![0, 1, 2], 50)]));
}

/// The value that two equal observations give.
struct Pair(Vec<f64>);

impl Estimator for Pair {
    type Model = f64;
    const SAMPLE: usize = 2;

    fn len(&self) -> usize {
        self.0.len()
    }

    fn minimal(&self, sample: &[usize], models: &mut Vec<f64>) {
        if self.0[sample[0]] == self.0[sample[1]] {
            models.push(self.0[sample[0]]);
        }
    }

    fn squared_residual(&self, model: &f64, index: usize) -> f64 {
        (self.0[index] - model).powi(2)
    }

    fn refine(&self, _: &f64, _: &[bool]) -> Option<f64> {
        None
    }
}

#[test]
fn the_number_of_trials_counts_samples_without_repetition() {
    // 5 of 10 agree: a pair is good with 5/10 · 4/9 = 2/9, and ln(1 − 0.9999) / ln(7/9) = 36.6, so 37 trials.
    let values = (0..10).map(|i| if i % 2 == 0 { 0.0 } else { 100.0 * f64::from(i) }).collect();
    let options = ConsensusOptions { min_trials: 0, min_support: 2, ..ConsensusOptions::default() };
    let found = search(&Pair(values), &options).unwrap();
    assert_eq!((found.model, found.inlier_count, found.trials), (0.0, 5, 37));
    // All agree: one trial is enough, if no more are asked for.
    let same = Pair(vec![3.0; 6]);
    for (min_trials, max_trials, trials) in [(0, 100, 1), (1, 100, 1), (7, 100, 7), (40, 9, 9)] {
        let found = search(&same, &ConsensusOptions { min_trials, max_trials, ..options }).unwrap();
        assert_eq!((found.inlier_count, found.trials), (6, trials));
    }
    let default = ConsensusOptions::default();
    assert_eq!(search(&same, &default).unwrap().trials, default.min_trials);
    // As many observations as a sample needs are enough, one fewer is not.
    let two = search(&Pair(vec![3.0; 2]), &options).unwrap();
    assert_eq!((two.model, two.inlier_count), (3.0, 2));
    assert_eq!(
        search(&Pair(vec![3.0]), &options).err(),
        Some(Error::TooFewPoints { needed: 2, got: 1 })
    );
}
