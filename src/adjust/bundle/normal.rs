//! The normal equations of a block, with the blocks that tie photographs to points kept apart.
//!
//! ```text
//! ⎛ U   W ⎞ ⎛ δ_c ⎞     ⎛ g_c ⎞
//! ⎝ Wᵀ  V ⎠ ⎝ δ_p ⎠ = − ⎝ g_p ⎠
//! ```
//! U of photographs and cameras, V block diagonal of the points, W one block an observation. Nothing else is stored: memory
//! grows with the observations alone.

use alloc::vec;
use alloc::vec::Vec;
use core::ops::Range;
use core::sync::atomic::Ordering;

use nalgebra::Matrix3;

use super::engine::{Engine, ObservedParameter};
use super::evaluate::Rows;
use super::layout::Role;
use super::parallel;
use super::state::State;
use super::width::Width;
use crate::camera::{Adjustable, CentralModel};

/// The linearisation of a block about a state.
#[derive(Clone, Debug, Default)]
pub(super) struct Normal {
    /// For each observation that takes part, three rows of the photograph's columns.
    pub(super) w: Vec<f64>,
    /// For each point the upper triangle of V: xx, xy, xz, yy, yz, zz.
    pub(super) v: Vec<[f64; 6]>,
    pub(super) point_gradient: Vec<[f64; 3]>,
    /// For each photograph a square block of all its columns, upper triangle.
    pub(super) u: Vec<f64>,
    /// For each photograph the gradient by its columns.
    pub(super) image_gradient: Vec<f64>,
    /// The diagonal of U, and the gradient, in the order of the reduced system.
    pub(super) diagonal: Vec<f64>,
    pub(super) gradient: Vec<f64>,
    /// The blocks of two points that a distance ties: for its first end and its second.
    pub(super) tied: Vec<Matrix3<f64>>,
    pub(super) observed: Vec<ObservedParameter>,
    /// What each part of the points adds to `u` and `image_gradient`, kept from step to step: new memory costs more than the sums,
    /// and each return of it stops the other threads.
    sums: Vec<(Vec<f64>, Vec<f64>)>,
}

/// Photographs whose sums one task adds.
const SOME: usize = 16;

/// The part of a linearisation that belongs to a range of points.
struct Part<'a> {
    points: Range<usize>,
    w: &'a mut [f64],
    v: &'a mut [[f64; 6]],
    gradient: &'a mut [[f64; 3]],
    sums: (Vec<f64>, Vec<f64>),
}

pub(super) fn symmetric([xx, xy, xz, yy, yz, zz]: [f64; 6]) -> Matrix3<f64> {
    Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz)
}

pub(super) fn add_symmetric(v: &mut [f64; 6], m: &Matrix3<f64>) {
    let upper = [m.m11, m.m12, m.m13, m.m22, m.m23, m.m33];
    v.iter_mut().zip(upper).for_each(|(v, m)| *v += m);
}

impl<C: CentralModel + Adjustable + Clone, E: Width, K: Width> Engine<'_, C, E, K> {
    /// Linearises about a state and returns the largest scaled entry of the gradient.
    pub(super) fn linearise_into(&self, state: &State<C>, normal: &mut Normal) -> f64 {
        let (bundle, layout, k) = (self.bundle, self.layout, self.total.get());
        let (images, points) = (bundle.images.len(), bundle.points.len());
        normal.w.resize(layout.order.len() * 3 * k, 0.0);
        normal.v.resize(points, [0.0; 6]);
        normal.point_gradient.resize(points, [0.0; 3]);
        let (mut w, mut v, mut g) =
            (&mut normal.w[..], &mut normal.v[..], &mut normal.point_gradient[..]);
        let mut old = core::mem::take(&mut normal.sums).into_iter();
        let mut parts: Vec<Part<'_>> = parallel::parts(&layout.first)
            .into_iter()
            .map(|range| Part {
                w: parallel::take(
                    &mut w,
                    (layout.first[range.end] - layout.first[range.start]) * 3 * k,
                ),
                v: parallel::take(&mut v, range.len()),
                gradient: parallel::take(&mut g, range.len()),
                points: range,
                sums: old.next().unwrap_or_default(),
            })
            .collect();
        parallel::for_each(&mut parts, |_, part| self.linearise_part(state, part));
        let sums: Vec<_> = parts.into_iter().map(|part| part.sums).collect();
        normal.u.resize(images * k * k, 0.0);
        normal.image_gradient.resize(images * k, 0.0);
        let mut rows: Vec<_> = normal
            .u
            .chunks_mut(SOME * k * k)
            .zip(normal.image_gradient.chunks_mut(SOME * k))
            .collect();
        parallel::for_each(&mut rows, |i, (u, gradient)| {
            u.fill(0.0);
            gradient.fill(0.0);
            for (of_u, of_gradient) in &sums {
                let of_u = &of_u[i * SOME * k * k..][..u.len()];
                u.iter_mut().zip(of_u).for_each(|(a, b)| *a += b);
                let of_gradient = &of_gradient[i * SOME * k..][..gradient.len()];
                gradient.iter_mut().zip(of_gradient).for_each(|(a, b)| *a += b);
            }
        });
        drop(rows);
        normal.sums = sums;
        self.add_given(state, normal);
        self.gather(state, normal);
        self.scaled_gradient(normal)
    }

    fn linearise_part(&self, state: &State<C>, part: &mut Part<'_>) {
        let (bundle, layout, k) = (self.bundle, self.layout, self.total.get());
        let curved = self.curved.load(Ordering::Relaxed);
        let (sum_u, sum_gradient) = &mut part.sums;
        for (sum, width) in [(&mut *sum_u, k * k), (&mut *sum_gradient, k)] {
            sum.clear();
            sum.resize(bundle.images.len() * width, 0.0);
        }
        let mut rows = Rows::default();
        let begin = layout.first[part.points.start];
        for (own, point) in part.points.clone().enumerate() {
            let (mut v, mut g) = ([0.0; 6], [0.0; 3]);
            for place in layout.first[point]..layout.first[point + 1] {
                let seen = layout.seen(bundle, place);
                let w = &mut part.w[(place - begin) * 3 * k..][..3 * k];
                if rows.fill(bundle, state, seen, self.outside, k).is_err() {
                    // The cost of such a state is infinite, and it is never linearised.
                    w.fill(0.0);
                    continue;
                }
                let [x, y] = rows.residual;
                let squared = x * x + y * y;
                let weight = self.loss.weight(squared);
                if weight != 1.0 {
                    let curvature = if curved { self.loss.curvature(squared) } else { 0.0 };
                    rows.reweigh(weight, curvature, k);
                }
                let image = seen.image as usize;
                let u = &mut sum_u[image * k * k..][..k * k];
                let image_gradient = &mut sum_gradient[image * k..][..k];
                accumulate(self.total, &rows, w, u, image_gradient);
                let [[a, b, c], [d, e, f]] = rows.by_point;
                let [x, y] = rows.residual;
                v[0] += a * a + d * d;
                v[1] += a * b + d * e;
                v[2] += a * c + d * f;
                v[3] += b * b + e * e;
                v[4] += b * c + e * f;
                v[5] += c * c + f * f;
                g[0] += a * x + d * y;
                g[1] += b * x + e * y;
                g[2] += c * x + f * y;
            }
            part.v[own] = v;
            part.gradient[own] = g;
        }
    }

    /// The diagonal and the gradient of the reduced system's unknowns.
    fn gather(&self, state: &State<C>, normal: &mut Normal) {
        let (bundle, layout) = (self.bundle, self.layout);
        let (k, e, images) = (self.total.get(), self.own.get(), bundle.images.len());
        let mut diagonal = vec![0.0; layout.reduced(bundle)];
        let mut gradient = vec![0.0; diagonal.len()];
        // The present values of parameters, where they were observed.
        for (i, image) in bundle.images.iter().enumerate() {
            let camera = image.camera as usize;
            let shared = layout.camera_column(images, camera);
            for c in 0..k {
                let to = if c < e { i * e + c } else { shared + c - e };
                diagonal[to] += normal.u[(i * k + c) * k + c];
                gradient[to] += normal.image_gradient[i * k + c];
            }
        }
        normal.observed = self.observed_parameters(state);
        for parameter in &normal.observed {
            diagonal[parameter.at] += parameter.weight;
            gradient[parameter.at] += parameter.weight * parameter.off;
        }
        for (place, point) in layout.kept.iter().enumerate() {
            let to = layout.kept_column(bundle, place);
            let v = normal.v[*point as usize];
            for (c, d) in [v[0], v[3], v[5]].into_iter().enumerate() {
                diagonal[to + c] = d;
                gradient[to + c] = normal.point_gradient[*point as usize][c];
            }
        }
        normal.diagonal = diagonal;
        normal.gradient = gradient;
    }

    fn scaled_gradient(&self, normal: &Normal) -> f64 {
        let scaled = |g: f64, d: f64| if d > 0.0 { g.abs() / d.sqrt() } else { 0.0 };
        let larger = |m: f64, g: f64| if m.is_nan() || g <= m { m } else { g };
        let reduced = normal.gradient.iter().zip(&normal.diagonal).map(|(g, d)| scaled(*g, *d));
        let mut parts: Vec<_> = normal.v.chunks(parallel::MANY).map(|v| (v, 0.0)).collect();
        parallel::for_each(&mut parts, |i, (part, largest)| {
            for (own, v) in part.iter().enumerate() {
                let point = i * parallel::MANY + own;
                if self.layout.roles[point] == Role::Eliminated {
                    let g = normal.point_gradient[point];
                    for (g, d) in g.into_iter().zip([v[0], v[3], v[5]]) {
                        *largest = larger(*largest, scaled(g, d));
                    }
                }
            }
        });
        reduced.chain(parts.iter().map(|(_, g)| *g)).fold(0.0, larger)
    }
}

/// W = AᵀP, U += AᵀA and g += Aᵀr of one observation.
#[inline(always)]
fn accumulate<K: Width>(width: K, rows: &Rows, w: &mut [f64], u: &mut [f64], g: &mut [f64]) {
    let k = width.get();
    let (a, b) = (&rows.by_image[0][..k], &rows.by_image[1][..k]);
    for c in 0..3 {
        let (p, q) = (rows.by_point[0][c], rows.by_point[1][c]);
        let w = &mut w[c * k..][..k];
        for i in 0..k {
            w[i] = a[i] * p + b[i] * q;
        }
    }
    let [x, y] = rows.residual;
    for i in 0..k {
        g[i] += a[i] * x + b[i] * y;
    }
    for r in 0..k {
        let (p, q) = (a[r], b[r]);
        let u = &mut u[r * k..][..k];
        for i in 0..k {
            u[i] += a[i] * p + b[i] * q;
        }
    }
}
