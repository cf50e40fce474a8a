//! The least-squares problem of one sensor.

use alloc::vec;
use alloc::vec::Vec;
use core::marker::PhantomData;

use nalgebra::{
    Matrix1, Matrix2, Matrix2x3, Matrix3, Point2, Point3, SMatrix, SVector, Vector1, Vector2,
};

use super::ResectionOptions;
use crate::adjust::Precision;
use crate::adjust::precision::inverse;
use crate::adjust::report::{self, ObservationReport, Report};
use crate::adjust::unknowns::Columns;
use crate::camera::{Adjustable, SensorModel};
use crate::error::{Error, ProjectionError};
use crate::numeric::least_squares::{
    Convergence, Damped, NormalEquations, Problem, minimise, unit_weight,
};
use crate::numeric::robust_loss::RobustLoss;

/// A control point with its precisions as matrices.
#[derive(Clone, Copy, Debug)]
pub(super) struct Observed {
    pub(super) object: Point3<f64>,
    pub(super) image: Point2<f64>,
    pub(super) covariance: Matrix2<f64>,
    weight: Matrix2<f64>,
    /// Σ of the object point, where it is not free of error.
    spread: Option<Matrix3<f64>>,
}

/// A point for a sensor: the object point that fits it best within its precision.
struct Settled {
    object: Point3<f64>,
    /// Observed minus computed, linear in what is left of the object point.
    residual: Vector2<f64>,
    /// ∂(x, y)/∂(X, Y, Z), where the object point has a precision.
    slope: Matrix2x3<f64>,
    /// S⁻¹, of the covariance S of the image point and the object point's share of it.
    weight: Matrix2<f64>,
}

impl Observed {
    pub(super) fn new(
        object: Point3<f64>,
        image: Point2<f64>,
        precision: &Precision<2>,
        object_precision: Option<&Precision<3>>,
    ) -> Result<Self, Error> {
        if !object.iter().all(|c| c.is_finite()) {
            return Err(Error::NotFinite { what: "control point" });
        }
        if !image.iter().all(|c| c.is_finite()) {
            return Err(Error::NotFinite { what: "image point" });
        }
        let covariance = precision.covariance()?;
        let spread = object_precision.map(Precision::covariance).transpose()?;
        Ok(Self { object, image, covariance, weight: inverse(&covariance), spread })
    }

    /// The weight of a point as one number: that of its better coordinate, as for directions only the size counts.
    pub(super) fn single_weight(&self) -> f64 {
        0.5 * self.weight.trace()
    }

    /// min over X of ‖l − f(X)‖² + ‖X − X observed‖², each by its precision: Gauss–Newton in the form that never divides by
    /// the object point's covariance.
    #[inline]
    fn settle<S: SensorModel>(&self, sensor: &S) -> Result<Settled, ProjectionError> {
        let Some(spread) = &self.spread else {
            return Ok(self.without_spread(sensor.project(&self.object)?));
        };
        let mut object = self.object;
        for iteration in 1.. {
            let (image, slope) = sensor.project_jacobian(&object)?;
            let residual = (self.image - image) + slope * (object - self.object);
            let covariance = self.covariance + slope * spread * slope.transpose();
            let weight = inverse(&covariance);
            let next = self.object + spread * slope.transpose() * (weight * residual);
            let moved = slope * (next - object);
            // The image of what is still missing, beside its precision.
            if moved.dot(&(self.weight * moved)) < 1e-24 || iteration == 20 {
                return Ok(Settled { object, residual, slope, weight });
            }
            object = next;
        }
        Err(ProjectionError::NotFinite)
    }

    /// vᵀPv of the point for a sensor, infinite where it has no image.
    pub(super) fn squared<S: SensorModel>(&self, sensor: &S) -> f64 {
        self.settle(sensor).map_or(f64::INFINITY, |settled| settled.squared())
    }

    /// vᵀPv for an image by some sensor, the object point taken as free of error.
    #[inline]
    pub(super) fn squared_from(&self, image: Point2<f64>) -> f64 {
        self.without_spread(image).squared()
    }

    /// The point as it is, for its image by the sensor.
    #[inline]
    fn without_spread(&self, image: Point2<f64>) -> Settled {
        Settled {
            object: self.object,
            residual: self.image - image,
            slope: Matrix2x3::zeros(),
            weight: self.weight,
        }
    }

    /// The reports of the image point and of the object point's coordinates, where they were observed. `explained` is A Q Aᵀ.
    ///
    /// ```text
    /// λ = S⁻¹ r,   Q_λ = S⁻¹ − S⁻¹ A Q Aᵀ S⁻¹      v = Σ λ,  Qᵥ = Σ Q_λ Σ      v_X = −Σ_X Bᵀ λ,  Qᵥ_X = Σ_X Bᵀ Q_λ B Σ_X
    /// ```
    fn report(
        &self,
        settled: &Settled,
        explained: &Matrix2<f64>,
        robust: f64,
        sigma: f64,
        values: &mut Vec<ObservationReport>,
    ) {
        let p = settled.weight * robust;
        let correlate = p - p * explained * p;
        let lambda = settled.weight * settled.residual;
        let covariance = self.covariance / robust;
        let unexplained = covariance * correlate * covariance;
        let residual = self.covariance * lambda;
        values.extend(report::observed(&unexplained, &covariance, &residual, sigma));
        if let Some(spread) = &self.spread {
            let covariance = spread / robust;
            let share = covariance * settled.slope.transpose();
            let unexplained = share * correlate * share.transpose();
            let residual = -(spread * settled.slope.transpose() * lambda);
            values.extend(report::observed(&unexplained, &covariance, &residual, sigma));
        }
    }
}

impl Settled {
    /// The weighted sum of squares of the point.
    #[inline]
    fn squared(&self) -> f64 {
        self.residual.dot(&(self.weight * self.residual))
    }
}

/// What is to be adjusted, for any number of unknowns.
pub(super) struct Task<'a> {
    pub(super) points: &'a [Observed],
    pub(super) columns: &'a Columns,
    pub(super) options: &'a ResectionOptions,
}

/// A sensor at a minimum.
#[derive(Clone, Debug)]
pub(super) struct Minimised<S> {
    pub(super) sensor: S,
    pub(super) convergence: Convergence,
    /// How far each unknown has moved from its start.
    offset: Vec<f64>,
}

/// The sum of the points' losses.
fn losses<S: SensorModel>(
    points: &[Observed],
    loss: &RobustLoss,
    sensor: &S,
) -> Result<f64, ProjectionError> {
    let mut sum = 0.0;
    for point in points {
        sum += loss.cost(point.settle(sensor)?.squared());
    }
    Ok(sum)
}

/// Calls a function of `Fit<_, N>` for the least compiled N that holds the unknowns.
macro_rules! with_size {
    ($task:expr, $fit:ident, $call:expr) => {
        match $task.columns.len() {
            0..=6 => {
                let $fit = Fit::<_, 6>::new($task);
                $call
            }
            7..=12 => {
                let $fit = Fit::<_, 12>::new($task);
                $call
            }
            13..=24 => {
                let $fit = Fit::<_, 24>::new($task);
                $call
            }
            _ => {
                let $fit = Fit::<_, MOST>::new($task);
                $call
            }
        }
    };
}

/// No sensor has more parameters.
pub(super) const MOST: usize = 48;

impl Task<'_> {
    /// Half the sum of losses.
    pub(super) fn cost<S: SensorModel>(&self, sensor: &S) -> Result<f64, ProjectionError> {
        Ok(0.5 * losses(self.points, &self.options.loss, sensor)?)
    }

    /// The nearest minimum.
    pub(super) fn minimise<S: SensorModel + Adjustable + Clone>(&self, sensor: &S) -> Minimised<S> {
        with_size!(self, fit, fit.minimise(sensor))
    }

    /// What a minimum says of itself, and the place of each point's first number in it.
    pub(super) fn report<S: SensorModel + Adjustable + Clone>(
        &self,
        minimum: &Minimised<S>,
    ) -> Result<(Report, Vec<usize>), Error> {
        minimum.convergence.check()?;
        with_size!(self, fit, fit.report(minimum))
    }
}

/// The sensor, and how far its unknowns have moved from their start.
#[derive(Clone, Debug)]
struct State<S, const N: usize> {
    sensor: S,
    offset: SVector<f64, N>,
}

/// A [`Task`] in matrices of one size; `N` is at least the number of unknowns, those past the last depend on nothing.
struct Fit<'a, S, const N: usize> {
    points: &'a [Observed],
    columns: &'a Columns,
    options: &'a ResectionOptions,
    sensor: PhantomData<S>,
}

impl<'a, S: SensorModel + Adjustable + Clone, const N: usize> Fit<'a, S, N> {
    fn new(task: &Task<'a>) -> Self {
        let Task { points, columns, options } = *task;
        Self { points, columns, options, sensor: PhantomData }
    }

    fn minimise(&self, sensor: &S) -> Minimised<S> {
        let start = State { sensor: sensor.clone(), offset: SVector::zeros() };
        let mut normal = NormalEquations::default();
        let (State { sensor, offset }, convergence) =
            minimise(self, start, &mut normal, &self.options.least_squares);
        let offset = offset.as_slice()[..self.columns.len()].to_vec();
        Minimised { sensor, convergence, offset }
    }

    fn priors(&self) -> impl Iterator<Item = (usize, f64)> + '_ {
        let weights = self.columns.list.iter().map(|c| c.weight).enumerate();
        weights.filter(|(_, weight)| *weight > 0.0)
    }

    /// Calls `each` with every point, its two rows of A and its robust weight.
    #[inline]
    fn rows(
        &self,
        sensor: &S,
        mut each: impl FnMut(&Observed, &Settled, &[SVector<f64, N>; 2], f64),
    ) -> Result<(), ProjectionError> {
        let held_or = |group: &usize| {
            let len = if self.columns.uses(*group) { 2 * self.columns.lengths[*group] } else { 0 };
            vec![0.0; len]
        };
        let mut buffers: Vec<Vec<f64>> =
            (0..self.columns.lengths.len()).map(|g| held_or(&g)).collect();
        let mut by_group: Vec<&mut [f64]> = buffers.iter_mut().map(Vec::as_mut_slice).collect();
        let mut by_object = [0.0; 6];
        for point in self.points {
            // Where the object point is free of error the projection comes with its derivatives, one evaluation for two.
            let settled = match point.spread {
                Some(_) => Some(point.settle(sensor)?),
                None => None,
            };
            let at = settled.as_ref().map_or(&point.object, |s| &s.object);
            let image = sensor.partials(at, &mut by_object, &mut by_group)?;
            let settled = settled.unwrap_or_else(|| point.without_spread(image));
            let rows = match self.columns.whole_group::<N>() {
                // The pose alone: its partials are the rows.
                Some(group) => [0, 1].map(|row| {
                    SVector::from_column_slice(&by_group[group][row * N..(row + 1) * N])
                }),
                None => [0, 1].map(|row| {
                    SVector::from_fn(|k, _| match self.columns.list.get(k) {
                        Some(c) => self.columns.derivative(k, row, by_group[c.group]),
                        None => 0.0,
                    })
                }),
            };
            let robust = self.options.loss.weight(settled.squared());
            each(point, &settled, &rows, robust);
        }
        Ok(())
    }

    fn report(&self, minimum: &Minimised<S>) -> Result<(Report, Vec<usize>), Error> {
        let Minimised { sensor, convergence, offset } = minimum;
        let unknowns = self.columns.len();
        let (mut normal, mut sum) = (NormalEquations::<N>::default(), 0.0);
        self.rows(sensor, |_, settled, rows, robust| {
            add(&mut normal, settled, rows, robust);
            sum += robust * settled.squared();
        })?;
        let mut matrix = normal.matrix().view((0, 0), (unknowns, unknowns)).into_owned();
        let mut priors = 0;
        for (k, weight) in self.priors() {
            matrix[(k, k)] += weight;
            sum += weight * offset[k] * offset[k];
            priors += 1;
        }
        let (cofactor, condition) = report::cofactor(&matrix)?;
        let redundancy = (2 * self.points.len() + priors).saturating_sub(unknowns);
        let sigma0 = unit_weight(sum, redundancy);
        let sigma = report::sigma(sigma0, self.options.estimate_sigma);
        let q = SMatrix::<f64, N, N>::from_fn(|i, j| cofactor.get((i, j)).copied().unwrap_or(0.0));
        let (mut values, mut first) = (Vec::new(), Vec::with_capacity(self.points.len()));
        let mut object_numbers = 0;
        // Rows made again cost less than rows kept: room for those of a thousand points is new pages of memory each time.
        self.rows(sensor, |point, settled, rows, robust| {
            let times = [q * rows[0], q * rows[1]];
            let explained = Matrix2::from_fn(|i, j| rows[i].dot(&times[j]));
            let before = values.len();
            first.push(before);
            point.report(settled, &explained, robust, sigma, &mut values);
            object_numbers += values.len() - before - 2;
        })?;
        first.push(values.len());
        for (k, weight) in self.priors() {
            let variance = Matrix1::new(1.0 / weight);
            let unexplained = variance - Matrix1::new(cofactor[(k, k)]);
            let residual = Vector1::new(-offset[k]);
            values.extend(report::observed(&unexplained, &variance, &residual, sigma));
        }
        let report = Report {
            observations: values.len(),
            unknowns: unknowns + object_numbers,
            redundancy,
            weighted_sum: sum,
            sigma0,
            sigma,
            covariance: cofactor * (sigma * sigma),
            condition,
            values,
            convergence: *convergence,
        };
        Ok((report, first))
    }
}

/// Adds the rows of a point with S⁻¹ as their weight: the correlation is taken out by the second row's part along the first.
#[inline]
fn add<const N: usize>(
    normal: &mut NormalEquations<N>,
    settled: &Settled,
    rows: &[SVector<f64, N>; 2],
    robust: f64,
) {
    let (p, r) = (&settled.weight, -settled.residual);
    if p.m12 == 0.0 {
        normal.add(&rows[0], r.x, robust * p.m11);
        normal.add(&rows[1], r.y, robust * p.m22);
        return;
    }
    // P = L D Lᵀ.
    let l = p.m21 / p.m11;
    normal.add(&(rows[0] + rows[1] * l), r.x + l * r.y, robust * p.m11);
    normal.add(&rows[1], r.y, robust * (p.m22 - l * p.m21));
}

impl<S: SensorModel + Adjustable + Clone, const N: usize> Problem for Fit<'_, S, N> {
    type State = State<S, N>;
    type Linear = NormalEquations<N>;
    type Step = SVector<f64, N>;

    fn cost(&self, state: &State<S, N>) -> f64 {
        let Ok(sum) = losses(self.points, &self.options.loss, &state.sensor) else {
            return f64::INFINITY;
        };
        let priors = self.priors().map(|(k, w)| w * state.offset[k] * state.offset[k]);
        0.5 * (sum + priors.sum::<f64>())
    }

    fn linearise(&self, state: &State<S, N>, normal: &mut NormalEquations<N>) -> f64 {
        normal.clear();
        let filled = self.rows(&state.sensor, |_, s, rows, robust| add(normal, s, rows, robust));
        if filled.is_err() {
            // The cost of this state was finite, so its points project; no step leaves a zero matrix.
            normal.clear();
        }
        for (k, weight) in self.priors() {
            let unit = SVector::from_fn(|i, _| f64::from(i == k));
            normal.add(&unit, state.offset[k], weight);
        }
        normal.scaled_gradient()
    }

    fn solve(
        &self,
        _: &State<S, N>,
        normal: &NormalEquations<N>,
        damping: f64,
    ) -> Option<Damped<SVector<f64, N>>> {
        // Lengths are told by the decrease they bring, not by the unknowns' sizes.
        normal.solve(damping, &SVector::repeat(1.0))
    }

    fn apply(&self, state: &State<S, N>, step: &SVector<f64, N>) -> State<S, N> {
        // A step out of the model's domain costs infinitely much, by a place that is not a number.
        match self.columns.moved(&state.sensor, &step.as_slice()[..self.columns.len()]) {
            Ok(sensor) => State { sensor, offset: state.offset + step },
            Err(_) => State { sensor: state.sensor.clone(), offset: state.offset * f64::NAN },
        }
    }
}
