//! Which parameters of a model are estimated.

use alloc::vec;
use alloc::vec::Vec;

use super::precision::Precision;
use crate::camera::Adjustable;
use crate::error::Error;

/// Parameters of a model that an adjustment estimates, the others being held.
///
/// Groups and their parameters are those of [`Adjustable`]: for a [`Frame`](crate::camera::Frame) group 0 is the exterior
/// orientation, group 1 the interior orientation (fx, fy, x₀, y₀, s), then the projection's and the lens's.
///
/// # Example
/// The pose, the principal distance (one factor for both axes, known to 5 pixels beforehand) and k₁ of a camera with
/// Brown's lens:
///
/// ```
/// use collinear::adjust::Unknown;
///
/// let unknowns = [
///     Unknown::group(0),
///     Unknown::together(1, &[0, 1]).observed(5.0),
///     Unknown::parameter(2, 0),
/// ];
/// # let _ = unknowns;
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Unknown {
    group: usize,
    which: Which,
    sigma: Option<f64>,
}

#[derive(Clone, Debug, PartialEq)]
enum Which {
    All,
    One(usize),
    Together(Vec<usize>),
}

impl Unknown {
    /// Every parameter of a group.
    #[must_use]
    pub fn group(group: usize) -> Self {
        Self { group, which: Which::All, sigma: None }
    }

    /// One parameter of a group.
    #[must_use]
    pub fn parameter(group: usize, index: usize) -> Self {
        Self { group, which: Which::One(index), sigma: None }
    }

    /// Several parameters of a group, moved in proportion to their values as one unknown, whose unit is the first one's:
    /// fx and fy of a camera with a known ratio of its pixels' sides.
    #[must_use]
    pub fn together(group: usize, indices: &[usize]) -> Self {
        Self { group, which: Which::Together(indices.to_vec()), sigma: None }
    }

    /// With the present value as an observation of standard deviation σ, in the parameter's unit.
    #[must_use]
    #[doc(alias("prior", "soft constraint"))]
    pub fn observed(mut self, sigma: f64) -> Self {
        self.sigma = Some(sigma);
        self
    }
}

/// One unknown: the parameters of a group it moves and how far each.
#[derive(Clone, Debug)]
pub(super) struct Column {
    pub(super) group: usize,
    moves: Vec<(usize, f64)>,
    /// 1/σ² of the observed start value, zero where it is not observed.
    pub(super) weight: f64,
}

/// The columns of the design matrix that belong to one model.
#[derive(Clone, Debug)]
pub(super) struct Columns {
    pub(super) list: Vec<Column>,
    /// The length of each group of the model.
    pub(super) lengths: Vec<usize>,
    whole: Option<usize>,
}

impl Columns {
    /// Resolves a selection for a model.
    pub(super) fn resolve<M: Adjustable>(model: &M, unknowns: &[Unknown]) -> Result<Self, Error> {
        let lengths: Vec<usize> =
            (0..).map_while(|g| model.parameter_group(g)).map(|g| g.len).collect();
        let mut list = Vec::new();
        for unknown in unknowns {
            let Some(&len) = lengths.get(unknown.group) else {
                return Err(Error::OutOfRange {
                    what: "parameter group of an unknown",
                    value: unknown.group as f64,
                    expected: "a group that the model has",
                });
            };
            let mut values = vec![0.0; len];
            model.parameters(unknown.group, &mut values);
            let weight = match unknown.sigma {
                None => 0.0,
                Some(sigma) => Precision::<1>::Sigma(sigma).weight()?.x,
            };
            let mut column = |indices: &[usize]| {
                let value = |&i: &usize| {
                    values.get(i).copied().ok_or(Error::OutOfRange {
                        what: "parameter of an unknown",
                        value: i as f64,
                        expected: "a parameter that the group has",
                    })
                };
                let start = indices.first().map(value).transpose()?.unwrap_or(0.0);
                let moves = indices
                    .iter()
                    .map(|i| {
                        let factor = if start == 0.0 { 1.0 } else { value(i)? / start };
                        Ok((*i, if factor == 0.0 { 1.0 } else { factor }))
                    })
                    .collect::<Result<_, Error>>()?;
                list.push(Column { group: unknown.group, moves, weight });
                Ok::<(), Error>(())
            };
            match &unknown.which {
                Which::All => (0..len).try_for_each(|i| column(&[i]))?,
                Which::One(i) => column(&[*i])?,
                Which::Together(indices) if indices.is_empty() => {
                    return Err(Error::TooFewPoints { needed: 1, got: 0 });
                }
                Which::Together(indices) => column(indices)?,
            }
        }
        let whole = match unknowns {
            [Unknown { group, which: Which::All, .. }] => Some(*group),
            _ => None,
        };
        let columns = Self { list, lengths, whole };
        columns.check_distinct()?;
        Ok(columns)
    }

    fn check_distinct(&self) -> Result<(), Error> {
        let mut taken: Vec<(usize, usize)> =
            self.list.iter().flat_map(|c| c.moves.iter().map(|m| (c.group, m.0))).collect();
        taken.sort_unstable();
        match taken.windows(2).find(|w| w[0] == w[1]) {
            Some(w) => Err(Error::OutOfRange {
                what: "parameter chosen twice",
                value: w[0].1 as f64,
                expected: "each parameter in one unknown",
            }),
            None => Ok(()),
        }
    }

    /// The number of unknowns.
    pub(super) fn len(&self) -> usize {
        self.list.len()
    }

    /// The number of unknowns whose start is observed.
    pub(super) fn observed(&self) -> usize {
        self.list.iter().filter(|c| c.weight > 0.0).count()
    }

    /// Whether an unknown moves the group.
    pub(super) fn uses(&self, group: usize) -> bool {
        self.list.iter().any(|c| c.group == group)
    }

    /// The group whose `N` parameters are the unknowns, all of them and in order.
    #[inline]
    pub(super) fn whole_group<const N: usize>(&self) -> Option<usize> {
        self.whole.filter(|group| self.lengths[*group] == N)
    }

    /// The derivative of row `row` of a group's partials (rows of the group's length) by unknown `k`.
    #[inline]
    pub(super) fn derivative(&self, k: usize, row: usize, partials: &[f64]) -> f64 {
        let column = &self.list[k];
        let len = self.lengths[column.group];
        match column.moves.as_slice() {
            // What nearly every unknown is, without a sum.
            [(i, factor)] => partials[row * len + i] * factor,
            moves => moves.iter().map(|(i, factor)| partials[row * len + i] * factor).sum(),
        }
    }

    /// The present value of the first parameter that unknown `k` moves.
    pub(super) fn value<M: Adjustable>(&self, k: usize, model: &M) -> f64 {
        let column = &self.list[k];
        let mut values = vec![0.0; self.lengths[column.group]];
        model.parameters(column.group, &mut values);
        column.moves.first().and_then(|(i, _)| values.get(*i)).copied().unwrap_or(f64::NAN)
    }

    /// The model moved by a step of the unknowns.
    pub(super) fn moved<M: Adjustable + Clone>(&self, model: &M, step: &[f64]) -> Result<M, Error> {
        let mut moved = model.clone();
        for (group, len) in self.lengths.iter().enumerate() {
            let mut by_group = vec![0.0; *len];
            let mut any = false;
            for (column, s) in self.list.iter().zip(step).filter(|(c, _)| c.group == group) {
                any = true;
                for (i, factor) in &column.moves {
                    by_group[*i] += s * factor;
                }
            }
            if any {
                moved.adjust(group, &by_group)?;
            }
        }
        Ok(moved)
    }
}
