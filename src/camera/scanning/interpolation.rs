//! Values between the nodes of a table.

use alloc::vec::Vec;

use crate::error::{Error, ProjectionError};

/// No window of Lagrange's polynomial has more nodes.
pub(super) const MOST_NODES: usize = 12;

/// A node may be missed by this share of the mean distance of nodes: rounding of the first and the last line.
const SLACK: f64 = 1e-6;

/// The times of a table, ascending.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Nodes {
    times: Vec<f64>,
}

/// The nodes around a time, and what share each has in the value and in its slope.
pub(super) struct Window {
    pub(super) first: usize,
    pub(super) len: usize,
    pub(super) weights: [f64; MOST_NODES],
    pub(super) slopes: [f64; MOST_NODES],
}

impl Nodes {
    /// Of finite times, each after the one before it.
    pub(super) fn new(times: &[f64], what: &'static str) -> Result<Self, Error> {
        if !times.iter().all(|t| t.is_finite()) {
            return Err(Error::NotFinite { what });
        }
        for pair in times.windows(2) {
            if !(pair[1] > pair[0]) {
                let expected = "a time after the one before it";
                return Err(Error::OutOfRange { what, value: pair[1], expected });
            }
        }
        Ok(Self { times: times.to_vec() })
    }

    pub(super) fn len(&self) -> usize {
        self.times.len()
    }

    pub(super) fn span(&self) -> [f64; 2] {
        match *self.times {
            [first, .., last] => [first, last],
            [only] => [only, only],
            [] => [f64::NAN, f64::NAN],
        }
    }

    /// The interval of nodes that holds `time`: the number of its first node.
    fn interval(&self, time: f64) -> Result<usize, ProjectionError> {
        let [first, last] = self.span();
        let slack = SLACK * (last - first) / (self.len() as f64 - 1.0);
        if !(time >= first - slack && time <= last + slack) {
            return Err(ProjectionError::OutsideScan { time, first, last });
        }
        let after = self.times.partition_point(|t| *t <= time);
        Ok(after.clamp(1, self.len() - 1) - 1)
    }

    /// The two nodes around a time, and its place between them: 0 at the first, 1 at the second; and the time between them.
    pub(super) fn between(&self, time: f64) -> Result<(usize, f64, f64), ProjectionError> {
        let i = self.interval(time)?;
        let step = self.times[i + 1] - self.times[i];
        Ok((i, (time - self.times[i]) / step, step))
    }

    /// Lagrange's polynomial through `count` nodes, as many before the time as after it where the table has them:
    /// lⱼ(t) = Π (t − tₖ)/(tⱼ − tₖ) over k ≠ j.
    pub(super) fn lagrange(&self, time: f64, count: usize) -> Result<Window, ProjectionError> {
        let i = self.interval(time)?;
        let first = (i + 1).saturating_sub(count / 2).min(self.len() - count);
        let nodes = &self.times[first..first + count];
        // In units of the middle interval, so that products of twelve differences stay numbers.
        let unit = self.times[i + 1] - self.times[i];
        let mut window =
            Window { first, len: count, weights: [0.0; MOST_NODES], slopes: [0.0; MOST_NODES] };
        for j in 0..count {
            // The product and its derivative grow together.
            let (mut product, mut slope) = (1.0, 0.0);
            for k in (0..count).filter(|k| *k != j) {
                let factor = (time - nodes[k]) / unit;
                let node = (nodes[j] - nodes[k]) / unit;
                slope = (slope * factor + product) / node;
                product = product * factor / node;
            }
            window.weights[j] = product;
            window.slopes[j] = slope / unit;
        }
        Ok(window)
    }
}
