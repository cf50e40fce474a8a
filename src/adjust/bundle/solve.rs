//! The reduced system, formed and factorised.

use alloc::vec;
use alloc::vec::Vec;

use super::engine::Engine;
use super::iterative::Solved;
use super::layout::Layout;
use super::normal::Normal;
use super::problem::Bundle;
use super::sparse::Plan;
use super::width::Width;
use super::{Solver, dense, parallel};
use crate::camera::{Adjustable, CentralModel};

/// The largest system that is factorised without a look at its zeros.
const SMALL: usize = 450;
/// A sparse factorisation has dearer multiplications than a dense one: it must save more than this part of them.
const SPARSE_COST: f64 = 2.0;
/// Rows that one task scales.
const BAND: usize = 64;
/// Most numbers of a factorisation: 4 GB.
const MOST_NUMBERS: usize = 1 << 29;

/// The solver that suits a block, where the caller leaves it open, and the plan of a sparse factorisation.
pub(super) fn choose<C: Sync>(
    bundle: &Bundle<C>,
    layout: &Layout,
    solver: Solver,
) -> (Solver, Option<Plan>) {
    let n = layout.reduced(bundle);
    match solver {
        Solver::Automatic if n <= SMALL => (Solver::Dense, None),
        Solver::Automatic => {
            let plan = Plan::new(bundle, layout);
            let dense = (n as f64).powi(3) / 6.0;
            if SPARSE_COST * plan.work() >= dense && n * n <= MOST_NUMBERS {
                (Solver::Dense, None)
            } else if plan.numbers() <= MOST_NUMBERS {
                (Solver::Sparse, Some(plan))
            } else {
                (Solver::Iterative, None)
            }
        }
        Solver::Sparse => (solver, Some(Plan::new(bundle, layout))),
        _ => (solver, None),
    }
}

impl<C: CentralModel + Adjustable + Clone, E: Width, K: Width> Engine<'_, C, E, K> {
    /// The step by Cholesky's factorisation.
    pub(super) fn solve_dense(
        &self,
        normal: &Normal,
        inverses: &[[f64; 6]],
        damping: f64,
    ) -> Option<Solved> {
        let mut system = self.reduce(normal, inverses);
        let scale = scale(&normal.diagonal);
        scale_matrix(&mut system.matrix, &scale, &normal.diagonal, damping);
        let n = scale.len();
        system.right.iter_mut().zip(&scale).for_each(|(r, s)| *r *= s);
        dense::factorise(&mut system.matrix, n).ok()?;
        dense::solve(&system.matrix, n, &mut system.right);
        system.right.iter_mut().zip(&scale).for_each(|(r, s)| *r *= s);
        Some(Solved { step: system.right, residual: vec![0.0; n] })
    }

    /// The step by a sparse factorisation.
    pub(super) fn solve_sparse(
        &self,
        plan: &Plan,
        normal: &Normal,
        inverses: &[[f64; 6]],
        damping: f64,
    ) -> Option<Solved> {
        let system = self.reduce_to(normal, inverses, &plan.pattern);
        let step = plan.solve(&system, &scale(&normal.diagonal), &normal.diagonal, damping)?;
        Some(Solved { residual: vec![0.0; step.len()], step })
    }
}

/// 1/√D, by which the unknowns are scaled; 1 for those that nothing depends on.
pub(super) fn scale(diagonal: &[f64]) -> Vec<f64> {
    diagonal.iter().map(|d| if *d > 0.0 { 1.0 / d.sqrt() } else { 1.0 }).collect()
}

/// The upper triangle scaled, its diagonal raised by the damping; 1 for unknowns that nothing depends on.
pub(super) fn scale_matrix(matrix: &mut [f64], scale: &[f64], diagonal: &[f64], damping: f64) {
    let n = scale.len();
    let mut bands: Vec<&mut [f64]> = matrix.chunks_mut(BAND * n.max(1)).collect();
    parallel::for_each(&mut bands, |band, rows| {
        for (i, row) in rows.chunks_exact_mut(n.max(1)).enumerate() {
            let r = band * BAND + i;
            let own = scale[r];
            row[r..].iter_mut().zip(&scale[r..]).for_each(|(v, s)| *v *= own * s);
            row[r] = if diagonal[r] > 0.0 { row[r] + damping } else { 1.0 };
        }
    });
}
