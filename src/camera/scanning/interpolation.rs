//! Values between the nodes of a table.

use alloc::vec::Vec;

use crate::error::{Error, ProjectionError};

/// No window of Lagrange's polynomial has more nodes.
pub(super) const MOST_NODES: usize = 12;

/// The times of a table, ascending, and how many of them a value is interpolated from.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Nodes {
    times: Vec<f64>,
    count: usize,
    /// For each window of `count` nodes: 1/Π (tⱼ − tₖ) over k ≠ j, in units of the window's mean step.
    reciprocals: Vec<f64>,
}

/// The nodes around a time, and what share each has in the value and in its slope.
pub(super) struct Window {
    pub(super) first: usize,
    pub(super) weights: [f64; MOST_NODES],
    pub(super) slopes: [f64; MOST_NODES],
}

/// The mean step of a window, by which products of twelve differences stay numbers.
fn mean_step(window: &[f64]) -> f64 {
    match *window {
        [first, .., last] => (last - first) / (window.len() as f64 - 1.0),
        _ => 1.0,
    }
}

impl Nodes {
    /// Of finite times, each after the one before it, at least `count` of them.
    pub(super) fn new(times: &[f64], count: usize, what: &'static str) -> Result<Self, Error> {
        if times.len() < count {
            return Err(Error::TooFewPoints { needed: count, got: times.len() });
        }
        if !times.iter().all(|t| t.is_finite()) {
            return Err(Error::NotFinite { what });
        }
        for pair in times.windows(2) {
            if !(pair[1] > pair[0]) {
                let expected = "a time after the one before it";
                return Err(Error::OutOfRange { what, value: pair[1], expected });
            }
        }
        let mut reciprocals = Vec::with_capacity(count * (times.len() - count + 1));
        for window in times.windows(count) {
            let unit = mean_step(window);
            for (j, node) in window.iter().enumerate() {
                let others = window.iter().enumerate().filter(|(k, _)| *k != j);
                let product: f64 = others.map(|(_, other)| (node - other) / unit).product();
                reciprocals.push(1.0 / product);
            }
        }
        if !reciprocals.iter().all(|r| r.is_finite()) {
            let expected = "steps of a size";
            return Err(Error::OutOfRange { what, value: times[0], expected });
        }
        Ok(Self { times: times.to_vec(), count, reciprocals })
    }

    /// First and last time.
    pub(super) fn span(&self) -> [f64; 2] {
        // There are two at least.
        [self.times[0], self.times[self.times.len() - 1]]
    }

    /// The interval of nodes that holds `time`: the number of its first node.
    fn interval(&self, time: f64) -> Result<usize, ProjectionError> {
        let [first, last] = self.span();
        if !(time >= first && time <= last) {
            return Err(ProjectionError::OutsideScan { time, first, last });
        }
        let after = self.times.partition_point(|t| *t <= time);
        Ok(after.clamp(1, self.times.len() - 1) - 1)
    }

    /// The two nodes around a time, and its place between them: 0 at the first, 1 at the second; and the time between them.
    pub(super) fn between(&self, time: f64) -> Result<(usize, f64, f64), ProjectionError> {
        let i = self.interval(time)?;
        let step = self.times[i + 1] - self.times[i];
        Ok((i, (time - self.times[i]) / step, step))
    }

    /// Lagrange's polynomial through the nodes of a window, as many before the time as after it where the table has them:
    /// lⱼ(t) = Π (t − tₖ)/(tⱼ − tₖ) over k ≠ j.
    pub(super) fn lagrange(&self, time: f64) -> Result<Window, ProjectionError> {
        let (i, count) = (self.interval(time)?, self.count);
        let first = (i + 1).saturating_sub(count / 2).min(self.times.len() - count);
        let nodes = &self.times[first..first + count];
        let reciprocals = &self.reciprocals[count * first..count * (first + 1)];
        let unit = mean_step(nodes);
        let (mut weights, mut slopes) = ([0.0; MOST_NODES], [0.0; MOST_NODES]);
        // The product of the factors before j and its derivative, then those after j.
        let (mut product, mut slope) = (1.0, 0.0);
        for (j, node) in nodes.iter().enumerate() {
            (weights[j], slopes[j]) = (product, slope);
            let factor = (time - node) / unit;
            slope = slope * factor + product;
            product *= factor;
        }
        (product, slope) = (1.0, 0.0);
        for (j, node) in nodes.iter().enumerate().rev() {
            slopes[j] = (slopes[j] * product + weights[j] * slope) * reciprocals[j] / unit;
            weights[j] *= product * reciprocals[j];
            let factor = (time - node) / unit;
            slope = slope * factor + product;
            product *= factor;
        }
        Ok(Window { first, weights, slopes })
    }
}
