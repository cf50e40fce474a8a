//! A block as a problem of least squares: cost, linearisation, step.

use alloc::vec;
use alloc::vec::Vec;
use core::sync::atomic::AtomicBool;

use nalgebra::Vector3;

use super::layout::{Layout, Role};
use super::normal::Normal;
use super::problem::Bundle;
use super::sparse::Plan;
use super::state::{State, Step};
use super::width::Width;
use super::{OutsideRule, Solver, evaluate, parallel, schur};
use crate::camera::{Adjustable, CentralModel};
use crate::numeric::least_squares::{Damped, Problem};
use crate::numeric::robust_loss::RobustLoss;

/// A parameter of a camera whose start value was observed.
#[derive(Clone, Copy, Debug)]
pub(super) struct ObservedParameter {
    pub(super) camera: u32,
    pub(super) unknown: usize,
    /// Its place in the reduced system.
    pub(super) at: usize,
    pub(super) weight: f64,
    /// Its value less the observed one.
    pub(super) off: f64,
}

/// A block, and how it is worked through.
pub(super) struct Engine<'a, C, E, K> {
    pub(super) bundle: &'a Bundle<C>,
    pub(super) layout: &'a Layout,
    pub(super) loss: RobustLoss,
    pub(super) outside: OutsideRule,
    pub(super) solver: Solver,
    /// Whether the curvature of the loss belongs to the normal equations: to step by near the minimum, not to judge by.
    pub(super) curved: AtomicBool,
    /// Of the sparse solver.
    pub(super) plan: Option<&'a Plan>,
    /// Columns of a photograph's own block.
    pub(super) own: E,
    /// All columns of a photograph.
    pub(super) total: K,
}

impl<C: CentralModel + Adjustable + Clone, E: Width, K: Width> Engine<'_, C, E, K> {
    /// Where a camera's unknown stands in the reduced system; in its photograph's own block where it has one alone. `None` for a
    /// camera without a photograph.
    pub(super) fn parameter_column(&self, camera: usize, column: usize) -> Option<usize> {
        let (bundle, layout) = (self.bundle, self.layout);
        let image = layout.camera_image[camera]? as usize;
        Some(if layout.own < layout.total {
            layout.camera_column(bundle.images.len(), camera) + column
        } else {
            image * layout.own + 6 + column
        })
    }

    /// The parameters that were observed, of the cameras that have a photograph.
    pub(super) fn observed_parameters(&self, state: &State<C>) -> Vec<ObservedParameter> {
        let mut list = Vec::new();
        for (i, camera) in self.bundle.cameras.iter().enumerate() {
            let observed = camera.columns.list.iter().enumerate().filter(|(_, c)| c.weight > 0.0);
            for (k, column) in observed {
                let Some(at) = self.parameter_column(i, k) else { continue };
                let value = |model| camera.columns.value(k, model);
                list.push(ObservedParameter {
                    camera: i as u32,
                    unknown: k,
                    at,
                    weight: column.weight,
                    off: value(&state.cameras[i]) - value(&camera.model),
                });
            }
        }
        list
    }

    /// The steps of the eliminated points, with what they say of the step: the decrease of cost, and the length.
    fn substitute(
        &self,
        normal: &Normal,
        inverses: &[[f64; 6]],
        reduced: &[f64],
        damping: f64,
    ) -> (Vec<Vector3<f64>>, f64, f64) {
        struct Part<'a> {
            points: core::ops::Range<usize>,
            steps: &'a mut [Vector3<f64>],
            decrease: f64,
            length: f64,
        }
        let (bundle, layout, k) = (self.bundle, self.layout, self.total.get());
        let mut steps = vec![Vector3::zeros(); bundle.points.len()];
        let mut rest = &mut steps[..];
        let mut parts: Vec<Part<'_>> = parallel::parts(&layout.first)
            .into_iter()
            .map(|points| Part {
                steps: parallel::take(&mut rest, points.len()),
                points,
                decrease: 0.0,
                length: 0.0,
            })
            .collect();
        parallel::for_each(&mut parts, |_, part| {
            for (own, point) in part.points.clone().enumerate() {
                if layout.roles[point] != Role::Eliminated {
                    continue;
                }
                let gradient = normal.point_gradient[point];
                let mut sum = gradient;
                for place in layout.first[point]..layout.first[point + 1] {
                    let w = &normal.w[place * 3 * k..][..3 * k];
                    self.transposed_times(layout.seen(bundle, place).image, w, reduced, &mut sum);
                }
                let [x, y, z] = schur::times(&inverses[point], sum);
                let step = Vector3::new(-x, -y, -z);
                part.steps[own] = step;
                part.length = part.length.max(step.norm() / layout.extent);
                let v = normal.v[point];
                for (i, d) in [v[0], v[3], v[5]].into_iter().enumerate() {
                    part.decrease += 0.5 * step[i] * (damping * d * step[i] - gradient[i]);
                }
            }
        });
        let (mut decrease, mut length) = (0.0, 0.0);
        for part in &parts {
            decrease += part.decrease;
            length = f64::max(length, part.length);
        }
        drop(parts);
        (steps, decrease, length)
    }

    /// Adds Wᵀ x of one observation.
    #[inline]
    pub(super) fn transposed_times(&self, image: u32, w: &[f64], x: &[f64], sum: &mut [f64; 3]) {
        let (k, e) = (self.total.get(), self.own.get());
        let own = &x[image as usize * e..][..e];
        for (c, sum) in sum.iter_mut().enumerate() {
            let row = &w[c * k..][..k];
            let mut s = 0.0;
            for i in 0..e {
                s += row[i] * own[i];
            }
            *sum += s;
        }
        if e < k {
            let camera = self.bundle.images[image as usize].camera as usize;
            let shared = &x[self.layout.camera_column(self.bundle.images.len(), camera)..][..k - e];
            for (c, sum) in sum.iter_mut().enumerate() {
                let row = &w[c * k + e..][..k - e];
                *sum += row.iter().zip(shared).map(|(w, x)| w * x).sum::<f64>();
            }
        }
    }

    /// The length of a reduced step, relative to the sizes of its unknowns.
    fn reduced_length(&self, state: &State<C>, normal: &Normal, step: &[f64]) -> f64 {
        let (bundle, layout) = (self.bundle, self.layout);
        let mut length: f64 = 0.0;
        for own in step.chunks_exact(layout.own).take(bundle.images.len()) {
            let centre = Vector3::new(own[0], own[1], own[2]).norm() / layout.extent;
            let turn = Vector3::new(own[3], own[4], own[5]).norm();
            length = length.max(centre).max(turn);
        }
        for (i, camera) in bundle.cameras.iter().enumerate() {
            for k in 0..camera.columns.len() {
                let Some(at) = self.parameter_column(i, k) else { continue };
                let d = normal.diagonal.get(at).copied().unwrap_or(0.0);
                if d > 0.0 {
                    // What moves an image point by one pixel is the size of a parameter that is near zero.
                    let size = camera.columns.value(k, &state.cameras[i]).abs().max(1.0 / d.sqrt());
                    length = length.max(step[at].abs() / size);
                }
            }
        }
        let kept = layout.kept_column(bundle, 0);
        for own in step[kept..].chunks_exact(3) {
            length = length.max(Vector3::new(own[0], own[1], own[2]).norm() / layout.extent);
        }
        length
    }
}

impl<C: CentralModel + Adjustable + Clone, E: Width, K: Width> Problem for Engine<'_, C, E, K> {
    type State = State<C>;
    type Linear = Normal;
    type Step = Step;

    fn cost(&self, state: &State<C>) -> f64 {
        if !state.valid {
            return f64::INFINITY;
        }
        let (bundle, layout) = (self.bundle, self.layout);
        let mut parts: Vec<_> =
            parallel::parts(&layout.first).into_iter().map(|range| (range, 0.0)).collect();
        parallel::for_each(&mut parts, |_, (points, cost)| {
            for place in layout.first[points.start]..layout.first[points.end] {
                let seen = layout.seen(bundle, place);
                match evaluate::residual(bundle, state, seen, self.outside) {
                    Ok([x, y]) => *cost += 0.5 * self.loss.cost(x * x + y * y),
                    Err(_) => {
                        *cost = f64::INFINITY;
                        break;
                    }
                }
            }
        });
        let cost = parts.iter().map(|(_, cost)| cost).sum::<f64>() + self.given_cost(state);
        if cost.is_nan() { f64::INFINITY } else { cost }
    }

    fn linearise(&self, state: &State<C>, linear: &mut Normal) -> f64 {
        self.linearise_into(state, linear)
    }

    fn solve(&self, state: &State<C>, normal: &Normal, damping: f64) -> Option<Damped<Step>> {
        let inverses = self.inverses(normal, damping)?;
        let solved = match (self.solver, &self.plan) {
            (Solver::Sparse, Some(plan)) => self.solve_sparse(plan, normal, &inverses, damping)?,
            (Solver::Iterative, _) => self.solve_iteratively(normal, &inverses, damping)?,
            _ => self.solve_dense(normal, &inverses, damping)?,
        };
        let (points, by_points, length) = self.substitute(normal, &inverses, &solved.step, damping);
        let decrease: f64 = solved
            .step
            .iter()
            .zip(&normal.gradient)
            .zip(&normal.diagonal)
            .zip(&solved.residual)
            .map(|(((s, g), d), r)| 0.5 * s * (damping * d * s - g - r))
            .sum::<f64>()
            + by_points;
        let length = length.max(self.reduced_length(state, normal, &solved.step));
        (decrease.is_finite() && length.is_finite()).then_some(Damped {
            step: Step { reduced: solved.step, points },
            predicted_decrease: decrease,
            relative_length: length,
        })
    }

    fn apply(&self, state: &State<C>, step: &Step) -> State<C> {
        state.moved(self.bundle, self.layout, step)
    }
}
