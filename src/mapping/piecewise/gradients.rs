//! Gradients at control points, estimated from the values around them.

use alloc::vec::Vec;

use nalgebra::{Matrix2, Point2, Vector2};

use super::triangulation::Triangulation;
use crate::error::Error;

/// Sweeps over all points, at most.
const MAX_SWEEPS: u32 = 2000;
/// A sweep that changes no gradient by more than this share of the largest one is the last.
const TOLERANCE: f64 = 1e-13;
/// What the last sweep may still change: among slivers rounding never comes to rest.
const RESTLESS: f64 = 1e-10;

/// ∂(u, v)/∂(S, L) at the points, with the least curvature of the edges:
///
/// ```text
/// minimise Σ ∫ (d²w/ds²)² ds     over all edges, w the cubic that has the values and the derivatives of its ends
/// ```
///
/// (Nielson 1983; Renka & Cline 1984.) With d = e·g along an edge e of length L, the point i wants
/// Σⱼ eᵢⱼ (2 dᵢ + dⱼ − 3 Δuᵢⱼ) / L³ = 0: two equations a point, solved point by point until nothing moves.
pub(super) fn least_curvature(
    triangles: &Triangulation,
    texture: &[Point2<f64>],
) -> Result<Vec<Matrix2<f64>>, Error> {
    let n = triangles.points.len();
    let mut around: Vec<Vec<usize>> = alloc::vec![Vec::new(); n];
    for [a, b] in triangles.edges() {
        around[a].push(b);
        around[b].push(a);
    }
    // Lengths relative to the extent: L⁻³ neither overflows nor vanishes.
    let extent =
        triangles.points.iter().map(|p| (p - triangles.points[0]).amax()).fold(0.0, f64::max);
    let edge = |i: usize, j: usize| (triangles.points[j] - triangles.points[i]) / extent;
    let inverses: Vec<Option<Matrix2<f64>>> = (0..n)
        .map(|i| {
            let normal = around[i].iter().fold(Matrix2::zeros(), |sum, &j| {
                let e = edge(i, j);
                sum + e * e.transpose() * (2.0 / cube(e.norm()))
            });
            normal.try_inverse()
        })
        .collect();
    let mut gradients = alloc::vec![Matrix2::zeros(); n];
    let (mut sweeps, mut change, mut largest) = (0, f64::INFINITY, 0.0f64);
    while !(change <= TOLERANCE * largest) {
        if sweeps == MAX_SWEEPS && change <= RESTLESS * largest {
            break;
        }
        if sweeps == MAX_SWEEPS || change.is_nan() {
            return Err(Error::NotConverged { iterations: sweeps, cost: change / largest });
        }
        sweeps += 1;
        (change, largest) = (0.0, 0.0);
        for i in 0..n {
            let degenerate =
                Error::Degenerate { what: "edges about a control point", measure: 0.0, limit: 0.0 };
            let inverse = inverses[i].ok_or(degenerate)?;
            let sum = around[i].iter().fold(Matrix2::zeros(), |sum, &j| {
                let e = edge(i, j);
                let rest: Vector2<f64> = (texture[j] - texture[i]) * 3.0 - gradients[j] * e;
                sum + rest * e.transpose() / cube(e.norm())
            });
            let new = sum * inverse;
            let moved = (new - gradients[i]).amax();
            change = if moved.is_nan() { moved } else { change.max(moved) };
            largest = largest.max(new.amax());
            gradients[i] = new;
            if change.is_nan() {
                break;
            }
        }
    }
    for g in &mut gradients {
        *g /= extent;
    }
    Ok(gradients)
}

fn cube(x: f64) -> f64 {
    x * x * x
}
