//! The reduced system, formed and factorised.

use alloc::vec;
use alloc::vec::Vec;

use super::dense;
use super::engine::Engine;
use super::iterative::Solved;
use super::normal::Normal;
use super::width::Width;
use crate::camera::{Adjustable, CentralModel};

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
}

/// 1/√D, by which the unknowns are scaled; 1 for those that nothing depends on.
pub(super) fn scale(diagonal: &[f64]) -> Vec<f64> {
    diagonal.iter().map(|d| if *d > 0.0 { 1.0 / d.sqrt() } else { 1.0 }).collect()
}

/// The upper triangle scaled, its diagonal raised by the damping; 1 for unknowns that nothing depends on.
pub(super) fn scale_matrix(matrix: &mut [f64], scale: &[f64], diagonal: &[f64], damping: f64) {
    let n = scale.len();
    for (r, row) in matrix.chunks_exact_mut(n.max(1)).enumerate() {
        let own = scale[r];
        row[r..].iter_mut().zip(&scale[r..]).for_each(|(v, s)| *v *= own * s);
        row[r] = if diagonal[r] > 0.0 { row[r] + damping } else { 1.0 };
    }
}
