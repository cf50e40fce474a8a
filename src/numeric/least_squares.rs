//! Levenberg–Marquardt, apart from any linear algebra.
//!
//! ```text
//! minimise ½ Σ ρ(‖rᵢ(x)‖²),   (JᵀWJ + λ D) δ = −JᵀWr,   D = diag(JᵀWJ)        (Levenberg 1944, Marquardt 1963)
//! ```
//!
//! The driver [`minimise`] decides damping, acceptance and the end; a [`Problem`] linearises itself and solves its own
//! damped system. A problem of few unknowns keeps [`NormalEquations`]; one with millions of observations can eliminate
//! its points first. The damping follows Nielsen (1999), Damping parameter in Marquardt's method, eq. 2.21.

use core::ops::ControlFlow;

use nalgebra::{SMatrix, SVector};

use super::float;
#[cfg(feature = "std")]
use crate::error::Error;

/// A sum of squares that can be linearised, solved for a damped step and moved along it. [`minimise`] shows one.
pub trait Problem {
    /// The unknowns at one place.
    type State: Clone;
    /// The linearisation about a state, reused from step to step.
    type Linear;
    /// A damped step.
    type Step;

    /// Half the weighted sum of squared residuals; infinite where a residual does not exist.
    fn cost(&self, state: &Self::State) -> f64;
    /// Linearises about `state` and returns the largest scaled entry of the gradient: max |gᵢ| / √(Dᵢ), which has the
    /// units of a residual.
    fn linearise(&self, state: &Self::State, linear: &mut Self::Linear) -> f64;
    /// The step for the damping λ, with the decrease of cost that the linearisation predicts and the step's length
    /// scaled by the unknowns' own sizes; `None` where the system has no solution.
    fn solve(
        &self,
        state: &Self::State,
        linear: &Self::Linear,
        damping: f64,
    ) -> Option<Damped<Self::Step>>;
    /// The state moved by a step.
    fn apply(&self, state: &Self::State, step: &Self::Step) -> Self::State;
}

/// A damped step and what the linearisation says of it.
#[derive(Clone, Debug)]
pub struct Damped<S> {
    /// The step.
    pub step: S,
    /// The decrease of cost that the linear model predicts; positive.
    pub predicted_decrease: f64,
    /// The step's length relative to the unknowns, dimensionless.
    pub relative_length: f64,
}

/// When to stop.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LeastSquaresOptions {
    /// Linearisations allowed.
    pub max_iterations: u32,
    /// Converged when no scaled gradient entry exceeds this times √(2 · cost), or the cost is at its rounding floor.
    pub gradient_tolerance: f64,
    /// Converged when a step is shorter than this, relative to the unknowns.
    pub step_tolerance: f64,
    /// Converged after a step of which the linearisation foretold a decrease below this fraction of the cost.
    pub decrease_tolerance: f64,
    /// The first damping λ.
    pub initial_damping: f64,
}

impl Default for LeastSquaresOptions {
    fn default() -> Self {
        Self {
            max_iterations: 100,
            gradient_tolerance: 1e-14,
            step_tolerance: 1e-15,
            decrease_tolerance: 0.0,
            initial_damping: 1e-4,
        }
    }
}

/// Where a minimisation is, told after each step that decreased the cost.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Progress {
    /// Linearisations done.
    pub iterations: u32,
    /// The cost reached.
    pub cost: f64,
    /// The damping λ of the next step.
    pub damping: f64,
}

/// How a minimisation ended.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Convergence {
    /// Whether a tolerance was met; `false` means the iterations ran out, no step decreased the cost, or the caller stopped it.
    pub converged: bool,
    /// Linearisations done.
    pub iterations: u32,
    /// Cost at the start: half the weighted sum of squares.
    pub initial_cost: f64,
    /// Cost at the end.
    pub final_cost: f64,
    /// The largest scaled gradient entry of the last linearisation, in units of a residual; a stop by the length of a step or
    /// by the iterations comes one step later.
    pub gradient: f64,
}

impl Convergence {
    /// Of a minimum that needed no iteration, as one in closed form.
    pub(crate) fn without_iteration(cost: f64, gradient: f64) -> Self {
        Self { converged: true, iterations: 0, initial_cost: cost, final_cost: cost, gradient }
    }

    /// Refuses an iteration that did not converge.
    #[cfg(feature = "std")]
    pub(crate) fn check(&self) -> Result<(), Error> {
        if self.converged {
            return Ok(());
        }
        Err(Error::NotConverged { iterations: self.iterations, cost: self.final_cost })
    }
}

/// σ₀ = √(vᵀPv / r), the standard deviation of an observation of unit weight; `None` where nothing is redundant.
pub(crate) fn unit_weight(weighted_sum: f64, redundancy: usize) -> Option<f64> {
    (redundancy > 0).then(|| float::sqrt(weighted_sum / redundancy as f64))
}

/// Minimises from `start`. The state returned is the best one met, converged or not.
///
/// # Example
/// Rosenbrock's valley (1960), the residuals 10 (y − x²) and 1 − x, from (−1.2, 1); its minimum is at (1, 1).
///
/// ```
/// use collinear::numeric::least_squares::{Damped, LeastSquaresOptions, NormalEquations, Problem, minimise};
/// use nalgebra::Vector2;
///
/// struct Valley;
///
/// impl Problem for Valley {
///     type State = Vector2<f64>;
///     type Linear = NormalEquations<2>;
///     type Step = Vector2<f64>;
///     fn cost(&self, p: &Vector2<f64>) -> f64 {
///         50.0 * (p.y - p.x * p.x).powi(2) + 0.5 * (1.0 - p.x).powi(2)
///     }
///     fn linearise(&self, p: &Vector2<f64>, linear: &mut NormalEquations<2>) -> f64 {
///         linear.clear();
///         linear.add(&Vector2::new(-20.0 * p.x, 10.0), 10.0 * (p.y - p.x * p.x), 1.0);
///         linear.add(&Vector2::new(-1.0, 0.0), 1.0 - p.x, 1.0);
///         linear.scaled_gradient()
///     }
///     fn solve(&self, p: &Vector2<f64>, linear: &NormalEquations<2>, damping: f64) -> Option<Damped<Vector2<f64>>> {
///         linear.solve(damping, p)
///     }
///     fn apply(&self, p: &Vector2<f64>, step: &Vector2<f64>) -> Vector2<f64> {
///         p + step
///     }
/// }
///
/// let start = Vector2::new(-1.2, 1.0);
/// let (found, report) = minimise(&Valley, start, &mut NormalEquations::default(), &LeastSquaresOptions::default());
/// assert!(report.converged && (found - Vector2::new(1.0, 1.0)).norm() < 1e-12);
/// ```
pub fn minimise<P: Problem>(
    problem: &P,
    start: P::State,
    linear: &mut P::Linear,
    options: &LeastSquaresOptions,
) -> (P::State, Convergence) {
    minimise_watched(problem, start, linear, options, |_, _| ControlFlow::Continue(()))
}

/// [`minimise`] with a watcher, which is told of each step and may end the work: the state returned is then the best one met,
/// and not converged.
pub fn minimise_watched<P: Problem>(
    problem: &P,
    start: P::State,
    linear: &mut P::Linear,
    options: &LeastSquaresOptions,
    mut watch: impl FnMut(&P::State, &Progress) -> ControlFlow<()>,
) -> (P::State, Convergence) {
    let mut state = start;
    let mut cost = problem.cost(&state);
    let initial_cost = cost;
    let mut damping = options.initial_damping;
    let mut growth = 2.0;
    let mut report = Convergence {
        converged: false,
        iterations: 0,
        initial_cost,
        final_cost: cost,
        gradient: f64::NAN,
    };
    if !cost.is_finite() {
        return (state, report);
    }
    while report.iterations < options.max_iterations {
        report.iterations += 1;
        report.gradient = problem.linearise(&state, linear);
        if report.gradient <= options.gradient_tolerance * float::sqrt(2.0 * cost) {
            report.converged = true;
            break;
        }
        // Raise the damping until a step is found that decreases the cost.
        let moved = loop {
            let Some(damped) = problem.solve(&state, linear, damping) else {
                damping *= growth;
                growth *= 2.0;
                if !(damping < 1e32) {
                    break None;
                }
                continue;
            };
            let candidate = problem.apply(&state, &damped.step);
            let candidate_cost = problem.cost(&candidate);
            let gain = (cost - candidate_cost) / damped.predicted_decrease;
            if candidate_cost < cost {
                let shrink = 1.0 - (2.0 * gain - 1.0) * (2.0 * gain - 1.0) * (2.0 * gain - 1.0);
                damping *= shrink.max(1.0 / 3.0);
                growth = 2.0;
                let last = damped.predicted_decrease <= options.decrease_tolerance * cost
                    || damped.relative_length <= options.step_tolerance;
                break Some((candidate, candidate_cost, last));
            }
            if damped.relative_length <= options.step_tolerance
                || damped.predicted_decrease <= 4.0 * f64::EPSILON * cost
            {
                // No shorter step can be told from none: this is the minimum to rounding.
                report.converged = true;
                break None;
            }
            damping *= growth;
            growth *= 2.0;
            if !(damping < 1e32) {
                break None;
            }
        };
        let Some((candidate, candidate_cost, last)) = moved else { break };
        state = candidate;
        cost = candidate_cost;
        if last {
            report.converged = true;
            break;
        }
        let progress = Progress { iterations: report.iterations, cost, damping };
        if watch(&state, &progress).is_break() {
            break;
        }
    }
    report.final_cost = cost;
    (state, report)
}

/// Normal equations of a problem with `N` unknowns, gathered row by row.
///
/// # Example
/// The line through (1, 6), (2, 5), (3, 7), (4, 10) in Wikipedia's *Linear least squares*: y = 3.5 + 1.4 x, the squares of
/// the residuals summing to 4.2.
///
/// ```
/// use collinear::numeric::least_squares::NormalEquations;
/// use nalgebra::Vector2;
///
/// let mut line = NormalEquations::<2>::default();
/// for (x, y) in [(1.0, 6.0), (2.0, 5.0), (3.0, 7.0), (4.0, 10.0)] {
///     line.add(&Vector2::new(1.0, x), -y, 1.0); // the residual at a + b x = 0
/// }
/// let solved = line.solve(0.0, &Vector2::new(1.0, 1.0)).ok_or("regular")?;
/// assert!((solved.step - Vector2::new(3.5, 1.4)).norm() < 1e-14);
/// // Half of 6² + 5² + 7² + 10² = 210, and half of 4.2 left.
/// assert!((105.0 - solved.predicted_decrease - 2.1).abs() < 1e-12);
/// # Ok::<(), &str>(())
/// ```
#[derive(Clone, Debug)]
pub struct NormalEquations<const N: usize> {
    matrix: SMatrix<f64, N, N>,
    gradient: SVector<f64, N>,
}

impl<const N: usize> Default for NormalEquations<N> {
    fn default() -> Self {
        Self { matrix: SMatrix::zeros(), gradient: SVector::zeros() }
    }
}

impl<const N: usize> NormalEquations<N> {
    /// Forgets all rows.
    pub fn clear(&mut self) {
        *self = Self::default();
    }

    /// From the lower triangle of JᵀWJ and the gradient JᵀWr, for a problem that sums them by a structure of its own.
    #[must_use]
    pub fn from_parts(matrix: SMatrix<f64, N, N>, gradient: SVector<f64, N>) -> Self {
        Self { matrix, gradient }
    }

    /// Adds one residual with its partial derivatives and weight.
    #[inline]
    pub fn add(&mut self, partials: &SVector<f64, N>, residual: f64, weight: f64) {
        for j in 0..N {
            let weighted = partials[j] * weight;
            self.gradient[j] += weighted * residual;
            for i in 0..=j {
                self.matrix[(j, i)] += weighted * partials[i];
            }
        }
    }

    /// The matrix JᵀWJ.
    #[must_use]
    pub fn matrix(&self) -> SMatrix<f64, N, N> {
        let mut full = self.matrix;
        full.fill_upper_triangle_with_lower_triangle();
        full
    }

    /// max |gᵢ| / √(Dᵢ) over the unknowns that any residual depends on.
    #[must_use]
    pub fn scaled_gradient(&self) -> f64 {
        (0..N).fold(0.0, |largest: f64, i| {
            let d = self.matrix[(i, i)];
            if d > 0.0 { largest.max(self.gradient[i].abs() / float::sqrt(d)) } else { largest }
        })
    }

    /// The step of (JᵀWJ + λ D) δ = −g; `sizes` are the magnitudes of the unknowns, by which the step's relative
    /// length is judged. `None` where the matrix is not positive definite.
    #[must_use]
    pub fn solve(&self, damping: f64, sizes: &SVector<f64, N>) -> Option<Damped<SVector<f64, N>>> {
        // Scaled to a unit diagonal, which makes the damping and the factorisation free of units.
        let scale =
            self.matrix.diagonal().map(|d| if d > 0.0 { 1.0 / float::sqrt(d) } else { 0.0 });
        let mut scaled = self.matrix();
        for j in 0..N {
            for i in 0..N {
                scaled[(i, j)] *= scale[i] * scale[j];
            }
            scaled[(j, j)] = 1.0 + damping;
        }
        let factor = scaled.cholesky()?;
        let step = factor.solve(&-self.gradient.component_mul(&scale)).component_mul(&scale);
        let damped_part: f64 =
            (0..N).map(|i| damping * self.matrix[(i, i)] * step[i] * step[i]).sum();
        let predicted_decrease = 0.5 * (damped_part - self.gradient.dot(&step));
        let relative_length = (0..N)
            .map(|i| step[i].abs() / sizes[i].abs().max(f64::MIN_POSITIVE))
            .fold(0.0, f64::max);
        predicted_decrease.is_finite().then_some(Damped {
            step,
            predicted_decrease,
            relative_length,
        })
    }

    /// The inverse of JᵀWJ: with unit weights in units of the observations' variance, the covariance of the unknowns.
    #[must_use]
    pub fn covariance(&self) -> Option<SMatrix<f64, N, N>> {
        let scale =
            self.matrix.diagonal().map(|d| if d > 0.0 { 1.0 / float::sqrt(d) } else { 0.0 });
        let mut scaled = self.matrix();
        for j in 0..N {
            for i in 0..N {
                scaled[(i, j)] *= scale[i] * scale[j];
            }
        }
        let inverse = scaled.cholesky()?.inverse();
        Some(SMatrix::from_fn(|i, j| inverse[(i, j)] * scale[i] * scale[j]))
    }
}
