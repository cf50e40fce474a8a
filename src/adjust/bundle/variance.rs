//! Variance components: how good each kind of observation really is.
//!
//! ```text
//! σ̂_g² = v_gᵀ P_g v_g / r_g,    r_g = Σ rᵢ over the group g
//! ```
//! (Förstner 1979, *Ein Verfahren zur Schätzung von Varianz- und Kovarianzkomponenten*.) Precisions multiplied by σ̂ again and
//! again, until all are 1, are Helmert's (1907) and the restricted maximum-likelihood estimate, at a third of the work a step.

use alloc::collections::BTreeMap;
use alloc::vec::Vec;
use core::ops::ControlFlow;

use super::problem::{Bundle, CameraId, ImageId, Kind, PointId};
use super::quality::Observation;
use super::state::State;
use super::{Adjusted, BundleOptions, BundleReport, BundleReportOptions};
use crate::camera::{Adjustable, CentralModel};
use crate::error::Error;

/// How good a group of observations is, relative to its stated precision.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VarianceComponent {
    /// The number of the group.
    pub group: usize,
    /// Observed numbers.
    pub observations: usize,
    /// v_gᵀ P_g v_g.
    pub weighted_sum: f64,
    /// r_g: the part of the redundancy that is the group's.
    pub redundancy: f64,
    /// σ̂_g: what the stated standard deviations are to be multiplied with; `None` where r_g is nearly zero.
    pub sigma: Option<f64>,
}

impl VarianceComponent {
    /// The standard deviation of σ̂_g, about σ̂_g/√(2 r_g): what a ratio near 1 is to be judged by.
    #[must_use]
    pub fn uncertainty(&self) -> f64 {
        self.sigma.map_or(f64::NAN, |s| s / (2.0 * self.redundancy).sqrt())
    }
}

/// A group with less redundancy a number says nothing of its own precision.
const LEAST_REDUNDANCY: f64 = 1e-6;

impl BundleReport {
    /// σ̂_g of each group of observations; `group` tells the number of the group that an observation belongs to.
    ///
    /// *In words.* σ₀ alone says whether all precisions together were stated too well or too badly. Where image points, GNSS and
    /// control points each have their own, a component for each tells which of them it was.
    #[must_use]
    #[doc(alias("variance component estimation", "VCE"))]
    pub fn variance_components(
        &self,
        group: impl Fn(Observation) -> usize,
    ) -> Vec<VarianceComponent> {
        let mut sums: BTreeMap<usize, (usize, f64, f64)> = BTreeMap::new();
        for (of, number) in self.numbers() {
            let (count, squares, redundancy) = sums.entry(group(of)).or_default();
            *count += 1;
            *squares += number.weighted_square;
            *redundancy += number.redundancy;
        }
        let component = |(group, (observations, weighted_sum, redundancy))| {
            let enough = redundancy > LEAST_REDUNDANCY * observations as f64;
            let sigma = enough.then(|| f64::max(weighted_sum / redundancy, 0.0).sqrt());
            VarianceComponent { group, observations, weighted_sum, redundancy, sigma }
        };
        sums.into_iter().map(component).collect()
    }
}

/// A block adjusted with the precisions that its own residuals speak for.
#[derive(Clone, Debug)]
pub struct VarianceEstimate<C> {
    /// The block with those precisions.
    pub bundle: Bundle<C>,
    /// Adjusted with them.
    pub adjusted: Adjusted<C>,
    /// Judged with them, believed as they are.
    pub report: BundleReport,
    /// For each group, what the standard deviations stated first were multiplied with.
    pub factors: Vec<(usize, f64)>,
    /// How many adjustments it took.
    pub adjustments: usize,
}

/// σ̂ nearer to 1 than this is 1.
const TOLERANCE: f64 = 1e-7;
/// Adjustments allowed.
const MOST_ADJUSTMENTS: usize = 100;
/// σ̂ that shrinks by the same ratio so many times in a row has no other limit than zero.
const SHRINKING: usize = 10;
/// The same ratio: 1 − σ̂ has lost no more than this part of itself.
const SAME_RATIO: f64 = 0.01;
/// No one states a standard deviation so many times too large.
const LEAST_FACTOR: f64 = 1e-6;

/// How a group's precision has come about.
#[derive(Clone, Copy, Debug)]
struct Course {
    factor: f64,
    last: f64,
    shrinking: usize,
}

impl Course {
    const START: Self = Self { factor: 1.0, last: 1.0, shrinking: 0 };

    /// Takes a step; `false` where the steps lead to zero.
    fn step(&mut self, sigma: f64) -> bool {
        let same = sigma < 1.0 - TOLERANCE && 1.0 - sigma >= (1.0 - SAME_RATIO) * (1.0 - self.last);
        self.shrinking = if same { self.shrinking + 1 } else { 0 };
        (self.factor, self.last) = (self.factor * sigma, sigma);
        self.factor > LEAST_FACTOR && self.shrinking < SHRINKING
    }
}

impl<C: CentralModel + Adjustable + Clone> Bundle<C> {
    /// Adjusts the block again and again, each time with the precisions of each group of observations multiplied by what its
    /// residuals say ([`BundleReport::variance_components`]), until nothing changes.
    ///
    /// `how` tells the datum; the precisions are believed once they are estimated. A robust loss changes with the
    /// precisions, its scale being told in standard deviations.
    ///
    /// # Errors
    /// Those of [`adjust`](Self::adjust) and [`report`](Self::report); [`Error::UnknownPrecision`] for a group that nothing controls, or
    /// whose estimate goes to zero, as it may for a few observations that agree well by chance;
    /// [`Error::NotConverged`] after 100 adjustments.
    pub fn estimate_variances(
        &self,
        options: &BundleOptions,
        how: &BundleReportOptions<'_>,
        group: impl Fn(Observation) -> usize,
    ) -> Result<VarianceEstimate<C>, Error> {
        let how = BundleReportOptions { estimate_sigma: false, ..*how };
        let mut bundle = self.clone();
        let mut courses: BTreeMap<usize, Course> = BTreeMap::new();
        let mut state = State::start(self);
        let mut cost = f64::NAN;
        for adjustments in 1..=MOST_ADJUSTMENTS {
            let adjusted =
                bundle.adjust_from(options, state, &mut |_| ControlFlow::Continue(()))?;
            cost = adjusted.convergence.final_cost;
            let report = bundle.report(&adjusted, options, &how)?;
            let components = report.variance_components(&group);
            let settled =
                |c: &VarianceComponent| c.sigma.is_some_and(|s| (s - 1.0).abs() < TOLERANCE);
            if components.iter().all(settled) {
                let factor =
                    |c: &VarianceComponent| courses.get(&c.group).map_or(1.0, |c| c.factor);
                let factors = components.iter().map(|c| (c.group, factor(c))).collect();
                return Ok(VarianceEstimate { bundle, adjusted, report, factors, adjustments });
            }
            let mut steps = BTreeMap::new();
            for component in components {
                let VarianceComponent { group, redundancy, .. } = component;
                let course = courses.entry(group).or_insert(Course::START);
                let sigma = component.sigma.filter(|s| s.is_finite());
                match sigma.filter(|s| course.step(*s)) {
                    Some(sigma) => steps.insert(group, sigma),
                    None => {
                        let factor = course.factor;
                        return Err(Error::UnknownPrecision { group, redundancy, factor });
                    }
                };
            }
            bundle.rescale(|of| steps.get(&group(of)).copied().unwrap_or(1.0));
            state = adjusted.state;
        }
        Err(Error::NotConverged { iterations: MOST_ADJUSTMENTS as u32, cost })
    }

    /// Multiplies the standard deviations of observations.
    fn rescale(&mut self, factor: impl Fn(Observation) -> f64) {
        let mut scaled: BTreeMap<(u32, u64), u32> = BTreeMap::new();
        let old = core::mem::take(&mut self.precisions);
        for (i, seen) in self.seen.iter_mut().enumerate() {
            let factor = factor(Observation::ImagePoint(i));
            let key = (seen.precision, factor.to_bits());
            seen.precision = *scaled.entry(key).or_insert_with(|| {
                self.precisions.push(old[seen.precision as usize].map(|w| w / factor));
                (self.precisions.len() - 1) as u32
            });
        }
        self.last_precision = None;
        for (i, object) in self.points.iter_mut().enumerate() {
            if let Kind::Control { weight, .. } = &mut object.kind {
                *weight /= factor(Observation::ControlPoint(PointId(i as u32))).powi(2);
            }
        }
        for (i, image) in self.images.iter_mut().enumerate() {
            let id = ImageId(i as u32);
            if let Some(position) = &mut image.position {
                position.weight /= factor(Observation::Position(id)).powi(2);
            }
            if let Some(attitude) = &mut image.attitude {
                attitude.weight /= factor(Observation::Attitude(id)).powi(2);
            }
        }
        for (i, distance) in self.distances.iter_mut().enumerate() {
            distance.weight /= factor(Observation::Distance(i)).powi(2);
        }
        for (i, camera) in self.cameras.iter_mut().enumerate() {
            for (k, column) in camera.columns.list.iter_mut().enumerate() {
                let of = Observation::Parameter(CameraId(i as u32), k);
                column.weight /= factor(of).powi(2);
            }
        }
    }
}
