//! Minima to the last digit.

use crate::numeric::least_squares::{Convergence, Damped, LeastSquaresOptions, Problem, minimise};

/// [`minimise`], then steps that make the gradient smaller where the cost can no longer tell them apart: the cost is flat to rounding
/// within √ε of its minimum, its gradient is not.
pub(super) fn minimise_to_rounding<P: Problem>(
    problem: &P,
    start: P::State,
    linear: &mut P::Linear,
    options: &LeastSquaresOptions,
) -> (P::State, Convergence) {
    let (mut state, mut convergence) = minimise(problem, start, linear, options);
    if !convergence.converged {
        return (state, convergence);
    }
    convergence.gradient = problem.linearise(&state, linear);
    for _ in 0..3 {
        let Some(Damped { step, relative_length, .. }) = problem.solve(&state, linear, 0.0) else {
            break;
        };
        let next = problem.apply(&state, &step);
        // Not away from the minimum found.
        if !(relative_length < 1e-4 && problem.cost(&next).is_finite()) {
            break;
        }
        let gradient = problem.linearise(&next, linear);
        if !(gradient < convergence.gradient) {
            break;
        }
        (state, convergence.gradient) = (next, gradient);
    }
    convergence.final_cost = problem.cost(&state);
    (state, convergence)
}
