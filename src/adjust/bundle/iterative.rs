//! The reduced system solved by preconditioned conjugate gradients, without forming it.
//!
//! ```text
//! S x = U x − W (V⁻¹ (Wᵀ x))
//! ```
//! The preconditioner is the block diagonal of S (Schur–Jacobi: Agarwal et al. 2010, §3.2). Iterations end by the quadratic
//! model's own measure (Nash & Sofer 1990): where i times the last decrease of the model is below a tenth of the whole.

use alloc::vec;
use alloc::vec::Vec;

use super::engine::Engine;
use super::layout::Role;
use super::normal::{Normal, symmetric};
use super::parallel;
use super::schur::times;
use super::width::Width;
use crate::camera::{Adjustable, CentralModel};

/// A step of the reduced system.
pub(super) struct Solved {
    pub(super) step: Vec<f64>,
    /// S δ less the right side, of the damped system: zero where it was factorised.
    pub(super) residual: Vec<f64>,
}

/// The forcing term: how well a step must solve its system.
const FORCING: f64 = 0.01;
/// Iterations allowed.
const MOST_ITERATIONS: usize = 500;

impl<C: CentralModel + Adjustable + Clone, E: Width, K: Width> Engine<'_, C, E, K> {
    /// The step by conjugate gradients.
    pub(super) fn solve_iteratively(
        &self,
        normal: &Normal,
        inverses: &[[f64; 6]],
        damping: f64,
    ) -> Option<Solved> {
        let n = self.layout.reduced(self.bundle);
        let preconditioner = self.block_diagonal(normal, inverses, damping)?;
        let right = self.reduced_right(normal, inverses);
        let mut x = vec![0.0; n];
        let mut r = right.clone();
        let mut z = self.precondition(&preconditioner, &r);
        let mut p = z.clone();
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let mut rho = dot(&r, &z);
        let mut model = 0.0;
        for iteration in 1..=MOST_ITERATIONS {
            if !(rho > 0.0) {
                break;
            }
            let q = self.times_reduced(normal, inverses, damping, &p);
            let curvature = dot(&p, &q);
            if !(curvature > 0.0) {
                return None;
            }
            let alpha = rho / curvature;
            for i in 0..n {
                x[i] += alpha * p[i];
                r[i] -= alpha * q[i];
            }
            // The model falls by ½ α ρ with each step.
            let fall = 0.5 * alpha * rho;
            model += fall;
            if iteration as f64 * fall < FORCING * model {
                break;
            }
            z = self.precondition(&preconditioner, &r);
            let next = dot(&r, &z);
            let beta = next / rho;
            rho = next;
            for i in 0..n {
                p[i] = z[i] + beta * p[i];
            }
        }
        r.iter_mut().for_each(|r| *r = -*r);
        Some(Solved { step: x, residual: r })
    }

    /// −g_c + W V⁻¹ g_p.
    fn reduced_right(&self, normal: &Normal, inverses: &[[f64; 6]]) -> Vec<f64> {
        let points: Vec<[f64; 3]> =
            inverses.iter().zip(&normal.point_gradient).map(|(v, g)| times(v, *g)).collect();
        let mut right = self.w_times(normal, &points);
        right.iter_mut().zip(&normal.gradient).for_each(|(r, g)| *r -= g);
        right
    }

    /// W t, for one vector of three a point, without the points that are kept.
    fn w_times(&self, normal: &Normal, points: &[[f64; 3]]) -> Vec<f64> {
        struct Part {
            image: Vec<f64>,
        }
        let (bundle, layout) = (self.bundle, self.layout);
        let (k, e, images) = (self.total.get(), self.own.get(), bundle.images.len());
        let mut parts: Vec<Part> = (0..images).map(|_| Part { image: vec![0.0; k] }).collect();
        parallel::for_each(&mut parts, |i, part| {
            let out = &mut part.image[..k];
            for place in &layout.by_image[layout.image_first[i]..layout.image_first[i + 1]] {
                let place = *place as usize;
                let [x, y, z] = points[layout.seen(bundle, place).point as usize];
                let w = &normal.w[place * 3 * k..][..3 * k];
                for c in 0..k {
                    out[c] += w[c] * x + w[k + c] * y + w[2 * k + c] * z;
                }
            }
        });
        let mut sum = vec![0.0; layout.reduced(bundle)];
        for (i, part) in parts.iter().enumerate() {
            sum[i * e..][..e].copy_from_slice(&part.image[..e]);
            if e < k {
                let camera = layout.camera_column(images, bundle.images[i].camera as usize);
                sum[camera..].iter_mut().zip(&part.image[e..]).for_each(|(s, v)| *s += v);
            }
        }
        sum
    }

    /// S x of the damped system.
    fn times_reduced(
        &self,
        normal: &Normal,
        inverses: &[[f64; 6]],
        damping: f64,
        x: &[f64],
    ) -> Vec<f64> {
        struct Part<'a> {
            points: core::ops::Range<usize>,
            out: &'a mut [[f64; 3]],
        }
        let (bundle, layout) = (self.bundle, self.layout);
        let (k, e, images) = (self.total.get(), self.own.get(), bundle.images.len());
        // −V⁻¹ Wᵀ x of the eliminated points; x itself of the kept ones, whose W belongs to S. Wᵀ x of the kept ones beside.
        let mut points = vec![[0.0; 3]; bundle.points.len()];
        let mut rest = &mut points[..];
        let mut parts: Vec<Part<'_>> = parallel::parts(&layout.first)
            .into_iter()
            .map(|points| Part { out: parallel::take(&mut rest, points.len()), points })
            .collect();
        parallel::for_each(&mut parts, |_, part| {
            for (own, point) in part.points.clone().enumerate() {
                let mut sum = [0.0; 3];
                for place in layout.first[point]..layout.first[point + 1] {
                    let w = &normal.w[place * 3 * k..][..3 * k];
                    self.transposed_times(layout.seen(bundle, place).image, w, x, &mut sum);
                }
                part.out[own] = match layout.roles[point] {
                    Role::Eliminated => times(&inverses[point], sum).map(|v| -v),
                    _ => sum,
                };
            }
        });
        drop(parts);
        let mut kept = vec![0.0; 3 * layout.kept.len()];
        for (place, point) in layout.kept.iter().enumerate() {
            let at = layout.kept_column(bundle, place);
            kept[3 * place..][..3].copy_from_slice(&points[*point as usize]);
            points[*point as usize].copy_from_slice(&x[at..at + 3]);
        }
        for (point, role) in points.iter_mut().zip(&layout.roles) {
            if *role == Role::Constant {
                *point = [0.0; 3];
            }
        }
        let mut out = self.w_times(normal, &points);
        for i in 0..images {
            let u = &normal.u[i * k * k..][..k * k];
            let camera = layout.camera_column(images, bundle.images[i].camera as usize);
            let at = |c: usize| if c < e { i * e + c } else { camera + c - e };
            for r in 0..k {
                out[at(r)] += u[r * k + r] * x[at(r)];
                for s in r + 1..k {
                    out[at(r)] += u[r * k + s] * x[at(s)];
                    out[at(s)] += u[r * k + s] * x[at(r)];
                }
            }
        }
        for parameter in &normal.observed {
            out[parameter.at] += parameter.weight * x[parameter.at];
        }
        for (place, point) in layout.kept.iter().enumerate() {
            let at = layout.kept_column(bundle, place);
            let own = times(&normal.v[*point as usize], [x[at], x[at + 1], x[at + 2]]);
            for c in 0..3 {
                out[at + c] += own[c] + kept[3 * place + c];
            }
        }
        for (distance, block) in bundle.distances.iter().zip(&normal.tied) {
            let ends = distance.ends.map(|p| layout.roles[p as usize]);
            let [Role::Kept(a), Role::Kept(b)] = ends else { continue };
            let [a, b] = [a, b].map(|p| layout.kept_column(bundle, p as usize));
            for (to, from) in [(a, b), (b, a)] {
                for r in 0..3 {
                    out[to + r] += (0..3).map(|s| block[(r, s)] * x[from + s]).sum::<f64>();
                }
            }
        }
        for i in 0..x.len() {
            let d = normal.diagonal[i];
            out[i] = if d > 0.0 { out[i] + damping * d * x[i] } else { x[i] };
        }
        out
    }

    /// Factors of the diagonal blocks of S, scaled to a unit diagonal, with the scales.
    fn block_diagonal(
        &self,
        normal: &Normal,
        inverses: &[[f64; 6]],
        damping: f64,
    ) -> Option<Vec<Block>> {
        let (bundle, layout) = (self.bundle, self.layout);
        let (k, e, images) = (self.total.get(), self.own.get(), bundle.images.len());
        let of = k - e;
        let cameras = if of > 0 { bundle.cameras.len() } else { 0 };
        let mut blocks: Vec<Option<Block>> = vec![None; images + cameras + layout.kept.len()];
        parallel::for_each(&mut blocks, |i, block| {
            let (at, size) = if i < images {
                (i * e, e)
            } else if i < images + cameras {
                (layout.camera_column(images, i - images), of)
            } else {
                (layout.kept_column(bundle, i - images - cameras), 3)
            };
            let mut matrix = vec![0.0; size * size];
            if i < images {
                for r in 0..e {
                    matrix[r * e + r..(r + 1) * e]
                        .copy_from_slice(&normal.u[(i * k + r) * k + r..(i * k + r) * k + e]);
                }
                for place in &layout.by_image[layout.image_first[i]..layout.image_first[i + 1]] {
                    let place = *place as usize;
                    let inverse = &inverses[layout.seen(bundle, place).point as usize];
                    let w = &normal.w[place * 3 * k..][..3 * k];
                    let rows = [&w[..e], &w[k..][..e], &w[2 * k..][..e]];
                    subtract_square(&mut matrix, inverse, rows);
                }
            } else if i < images + cameras {
                self.camera_square(normal, inverses, i - images, &mut matrix);
            } else {
                let v = symmetric(normal.v[layout.kept[i - images - cameras] as usize]);
                matrix.copy_from_slice(v.as_slice());
            }
            for parameter in &normal.observed {
                if (at..at + size).contains(&parameter.at) {
                    matrix[(parameter.at - at) * (size + 1)] += parameter.weight;
                }
            }
            *block = Block::new(matrix, &normal.diagonal[at..at + size], damping, at);
        });
        blocks.into_iter().collect()
    }

    /// The diagonal block of a shared camera.
    fn camera_square(
        &self,
        normal: &Normal,
        inverses: &[[f64; 6]],
        camera: usize,
        matrix: &mut [f64],
    ) {
        let (bundle, layout) = (self.bundle, self.layout);
        let (k, e) = (self.total.get(), self.own.get());
        let of = k - e;
        let mine = |image: usize| bundle.images[image].camera as usize == camera;
        for i in (0..bundle.images.len()).filter(|i| mine(*i)) {
            for r in 0..of {
                for s in r..of {
                    matrix[r * of + s] += normal.u[(i * k + e + r) * k + e + s];
                }
            }
        }
        let mut sum = vec![0.0; 3 * of];
        for point in &layout.camera_points[camera] {
            let point = *point as usize;
            sum.fill(0.0);
            for place in layout.first[point]..layout.first[point + 1] {
                if mine(layout.seen(bundle, place).image as usize) {
                    let w = &normal.w[place * 3 * k..][..3 * k];
                    for c in 0..3 {
                        for r in 0..of {
                            sum[c * of + r] += w[c * k + e + r];
                        }
                    }
                }
            }
            let rows = [&sum[..of], &sum[of..2 * of], &sum[2 * of..]];
            subtract_square(matrix, &inverses[point], rows);
        }
    }

    fn precondition(&self, blocks: &[Block], r: &[f64]) -> Vec<f64> {
        let mut out = r.to_vec();
        for block in blocks {
            let own = &mut out[block.at..][..block.scale.len()];
            own.iter_mut().zip(&block.scale).for_each(|(v, s)| *v *= s);
            super::dense::solve(&block.factor, block.scale.len(), own);
            own.iter_mut().zip(&block.scale).for_each(|(v, s)| *v *= s);
        }
        out
    }
}

/// The factor of a diagonal block.
#[derive(Clone, Debug)]
struct Block {
    factor: Vec<f64>,
    scale: Vec<f64>,
    at: usize,
}

impl Block {
    fn new(mut matrix: Vec<f64>, diagonal: &[f64], damping: f64, at: usize) -> Option<Self> {
        let n = diagonal.len();
        let scale: Vec<f64> =
            diagonal.iter().map(|d| if *d > 0.0 { 1.0 / d.sqrt() } else { 1.0 }).collect();
        for r in 0..n {
            for s in r..n {
                matrix[r * n + s] *= scale[r] * scale[s];
            }
            let own = &mut matrix[r * n + r];
            *own = if diagonal[r] > 0.0 { *own + damping } else { 1.0 };
        }
        super::dense::factorise(&mut matrix, n).ok()?;
        Some(Self { factor: matrix, scale, at })
    }
}

/// M −= w V⁻¹ wᵀ for w of three rows.
fn subtract_square(matrix: &mut [f64], inverse: &[f64; 6], [a, b, c]: [&[f64]; 3]) {
    let n = a.len();
    for r in 0..n {
        let [x, y, z] = times(inverse, [a[r], b[r], c[r]]);
        for s in r..n {
            matrix[r * n + s] -= x * a[s] + y * b[s] + z * c[s];
        }
    }
}
