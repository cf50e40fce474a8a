//! Points first: the reduced system of photographs and cameras.
//!
//! ```text
//! S = U − W V⁻¹ Wᵀ,   S δ_c = −g_c + W V⁻¹ g_p,   δ_p = −V⁻¹ (g_p + Wᵀ δ_c)
//! ```
//! (Brown 1976, *The bundle adjustment – progress and prospects*; Triggs et al. 2000, §6.) Each photograph's rows of S are summed
//! over its own observations, in the order of the points: by one thread each, and so the same on any number of threads.

use alloc::vec;
use alloc::vec::Vec;

use super::engine::Engine;
use super::layout::Role;
use super::normal::Normal;
use super::parallel;
use super::pattern::Pattern;
use super::width::Width;
use crate::camera::{Adjustable, CentralModel};

/// A symmetric matrix, by its upper triangle, times a vector.
#[inline(always)]
pub(super) fn times([xx, xy, xz, yy, yz, zz]: &[f64; 6], [x, y, z]: [f64; 3]) -> [f64; 3] {
    [xx * x + xy * y + xz * z, xy * x + yy * y + yz * z, xz * x + yz * y + zz * z]
}

/// The inverse of a symmetric matrix with its diagonal raised by (1 + damping); `None` where it is not positive definite.
pub(super) fn inverse(v: &[f64; 6], damping: f64) -> Option<[f64; 6]> {
    let [xx, xy, xz, yy, yz, zz] = *v;
    let raised = 1.0 + damping;
    // Scaled to a unit diagonal first: pivots are then free of units.
    let scale = [xx, yy, zz].map(|d| 1.0 / d.sqrt());
    let [a, b, c] = scale;
    let (p, q, r) = (xy * a * b, xz * a * c, yz * b * c);
    // Pivots of (d p q; p d r; q r d), d = 1 + λ.
    let l = p / raised;
    let m = q / raised;
    let second = raised - l * p;
    let off = r - l * q;
    let n = off / second;
    let third = raised - m * q - n * off;
    if !(second > MIN_PIVOT && third > MIN_PIVOT && raised.is_finite()) {
        return None;
    }
    // (L D Lᵀ)⁻¹ with the columns of L⁻¹: (1, −l, ln − m), (0, 1, −n), (0, 0, 1).
    let k = l * n - m;
    let (d1, d2, d3) = (1.0 / raised, 1.0 / second, 1.0 / third);
    let inverse =
        [d1 + l * l * d2 + k * k * d3, -l * d2 - k * n * d3, k * d3, d2 + n * n * d3, -n * d3, d3];
    Some([
        inverse[0] * a * a,
        inverse[1] * a * b,
        inverse[2] * a * c,
        inverse[3] * b * b,
        inverse[4] * b * c,
        inverse[5] * c * c,
    ])
}

/// A pivot of a matrix of unit diagonal that rounding alone may have left.
const MIN_PIVOT: f64 = 1e-15;

/// The reduced system: its blocks as their pattern has them, the upper triangle by rows, and the right side.
pub(super) struct Reduced {
    pub(super) matrix: Vec<f64>,
    pub(super) right: Vec<f64>,
}

/// The rows of one block of the reduced system.
struct Rows<'a> {
    matrix: &'a mut [f64],
    right: &'a mut [f64],
}

/// A camera with more points is worked through in parts.
const MOST_CAMERA_POINTS: usize = 4096;
/// At least so many parts then.
const CAMERA_PARTS: usize = 16;

/// S −= T Wᵀ of one pair of observations, `t` and `w` being three rows each: into the first `columns` of rows of `n`.
#[inline(always)]
fn subtract<E: Width, F: Width>(
    (e, f): (E, F),
    (t, t_stride): (&[f64], usize),
    w: [&[f64]; 3],
    out: &mut [f64],
    n: usize,
) {
    let (e, f) = (e.get(), f.get());
    let [w0, w1, w2] = w.map(|row| &row[..f]);
    for r in 0..e {
        let (a, b, c) = (t[r], t[t_stride + r], t[2 * t_stride + r]);
        let row = &mut out[r * n..][..f];
        for i in 0..f {
            row[i] -= a * w0[i] + b * w1[i] + c * w2[i];
        }
    }
}

impl<C: CentralModel + Adjustable + Clone, E: Width, K: Width> Engine<'_, C, E, K> {
    /// V⁻¹ of the eliminated points, zero for the others; `None` where one is singular.
    pub(super) fn inverses(&self, normal: &Normal, damping: f64) -> Option<Vec<[f64; 6]>> {
        let mut inverses = vec![[0.0; 6]; normal.v.len()];
        let mut parts: Vec<_> = inverses.chunks_mut(parallel::MANY).map(|p| (p, true)).collect();
        parallel::for_each(&mut parts, |i, (part, regular)| {
            for (own, out) in part.iter_mut().enumerate() {
                let point = i * parallel::MANY + own;
                if self.layout.roles[point] == Role::Eliminated {
                    match inverse(&normal.v[point], damping) {
                        Some(found) => *out = found,
                        None => *regular = false,
                    }
                }
            }
        });
        parts.iter().all(|(_, regular)| *regular).then_some(inverses)
    }

    /// The whole of S, square, and the right side, without damping of the photographs' unknowns.
    pub(super) fn reduce(&self, normal: &Normal, inverses: &[[f64; 6]]) -> Reduced {
        self.reduce_to(normal, inverses, &Pattern::full(self.bundle, self.layout))
    }

    /// The blocks of S that a pattern has.
    pub(super) fn reduce_to(
        &self,
        normal: &Normal,
        inverses: &[[f64; 6]],
        pattern: &Pattern,
    ) -> Reduced {
        let (bundle, layout) = (self.bundle, self.layout);
        let images = bundle.images.len();
        let mut matrix = vec![0.0; pattern.len()];
        let mut right = vec![0.0; layout.reduced(bundle)];
        let (mut m, mut r) = (&mut matrix[..], &mut right[..]);
        let nodes = images + layout.camera_nodes(bundle);
        let mut blocks: Vec<Rows<'_>> = (0..nodes)
            .map(|i| Rows {
                matrix: parallel::take(&mut m, pattern.rows(i).len()),
                right: parallel::take(&mut r, pattern.size(i)),
            })
            .collect();
        let points = |camera: usize| &layout.camera_points[camera][..];
        let large = |camera: usize| points(camera).len() > MOST_CAMERA_POINTS;
        parallel::for_each(&mut blocks, |i, rows| {
            let n = pattern.stride(i);
            let columns = pattern.columns(i);
            if i < images {
                self.image_rows(normal, inverses, i, rows, n, &columns);
            } else if !large(i - images) {
                let camera = i - images;
                self.camera_rows(normal, inverses, (camera, points(camera)), rows, n, &columns);
            }
        });
        for (i, rows) in blocks.iter_mut().enumerate().skip(images) {
            let camera = i - images;
            if large(camera) {
                let (n, columns) = (pattern.stride(i), pattern.columns(i));
                let size = (points(camera).len() / CAMERA_PARTS).max(MOST_CAMERA_POINTS / 2);
                let zeros = |len| vec![0.0; len];
                let mut parts: Vec<_> = (points(camera).chunks(size))
                    .map(|p| (p, zeros(rows.matrix.len()), zeros(rows.right.len())))
                    .collect();
                parallel::for_each(&mut parts, |_, (points, matrix, right)| {
                    let rows = &mut Rows { matrix, right };
                    self.camera_rows(normal, inverses, (camera, points), rows, n, &columns);
                });
                for (_, matrix, right) in &parts {
                    rows.matrix.iter_mut().zip(matrix).for_each(|(a, b)| *a += b);
                    rows.right.iter_mut().zip(right).for_each(|(a, b)| *a += b);
                }
            }
            self.camera_own(normal, camera, rows, pattern.stride(i), pattern.column(i, i));
        }
        drop(blocks);
        self.kept_rows(normal, &mut matrix, &mut right, pattern);
        for parameter in &normal.observed {
            matrix[pattern.diagonal(parameter.at)] += parameter.weight;
            right[parameter.at] -= parameter.weight * parameter.off;
        }
        Reduced { matrix, right }
    }

    fn image_rows(
        &self,
        normal: &Normal,
        inverses: &[[f64; 6]],
        image: usize,
        rows: &mut Rows<'_>,
        n: usize,
        columns: &[usize],
    ) {
        let (bundle, layout) = (self.bundle, self.layout);
        let (k, e) = (self.total.get(), self.own.get());
        let of = |place: usize| layout.seen(bundle, place);
        let block = |place: usize| &normal.w[place * 3 * k..][..3 * k];
        let camera_column = |image: u32| {
            columns[bundle.images.len() + bundle.images[image as usize].camera as usize]
        };
        let kept_node = bundle.images.len() + layout.camera_nodes(bundle);
        let own = columns[image];
        // U of this photograph.
        let u = &normal.u[image * k * k..][..k * k];
        for r in 0..e {
            let row = &mut rows.matrix[r * n..][..n];
            row[own + r..own + e].copy_from_slice(&u[r * k + r..r * k + e]);
            if e < k {
                row[camera_column(image as u32)..][..k - e]
                    .copy_from_slice(&u[r * k + e..][..k - e]);
            }
            rows.right[r] = -normal.image_gradient[image * k + r];
        }
        let mut t = [0.0; 3 * super::MOST_COLUMNS];
        for place in &layout.by_image[layout.image_first[image]..layout.image_first[image + 1]] {
            let place = *place as usize;
            let point = of(place).point as usize;
            let w = block(place);
            match layout.roles[point] {
                Role::Constant => continue,
                Role::Kept(kept) => {
                    let column = columns[kept_node + kept as usize];
                    for r in 0..e {
                        for c in 0..3 {
                            rows.matrix[r * n + column + c] += w[c * k + r];
                        }
                    }
                    continue;
                }
                Role::Eliminated => {}
            }
            let inverse = &inverses[point];
            for r in 0..e {
                let [x, y, z] = times(inverse, [w[r], w[k + r], w[2 * k + r]]);
                (t[r], t[e + r], t[2 * e + r]) = (x, y, z);
            }
            let g = normal.point_gradient[point];
            for r in 0..e {
                rows.right[r] += t[r] * g[0] + t[e + r] * g[1] + t[2 * e + r] * g[2];
            }
            let (begin, end) = (layout.first[point], layout.first[point + 1]);
            for other in place..end {
                let w = block(other);
                let column = of(other).image as usize;
                let out = &mut rows.matrix[columns[column]..];
                let three = [w, &w[k..], &w[2 * k..]];
                subtract((self.own, self.own), (&t, e), three, out, n);
                if column == image && other != place {
                    // The same point twice in one photograph: the pair counts both ways.
                    for r in 0..e {
                        for s in 0..e {
                            let sum = (0..3).map(|c| w[c * k + r] * t[c * e + s]).sum::<f64>();
                            out[r * n + s] -= sum;
                        }
                    }
                }
            }
            if e < k {
                for other in begin..end {
                    let w = block(other);
                    let out = &mut rows.matrix[camera_column(of(other).image)..];
                    let three = [&w[e..], &w[k + e..], &w[2 * k + e..]];
                    subtract((self.own, super::width::Runtime(k - e)), (&t, e), three, out, n);
                }
            }
        }
    }

    /// U of a camera that several photographs share.
    fn camera_own(
        &self,
        normal: &Normal,
        camera: usize,
        rows: &mut Rows<'_>,
        n: usize,
        own: usize,
    ) {
        let (k, e) = (self.total.get(), self.own.get());
        let mine = |i: &usize| self.bundle.images[*i].camera as usize == camera;
        for i in (0..self.bundle.images.len()).filter(mine) {
            let u = &normal.u[i * k * k..][..k * k];
            for r in 0..k - e {
                for s in r..k - e {
                    rows.matrix[r * n + own + s] += u[(e + r) * k + e + s];
                }
                rows.right[r] -= normal.image_gradient[i * k + e + r];
            }
        }
    }

    /// What some of its points say of a camera that several photographs share.
    fn camera_rows(
        &self,
        normal: &Normal,
        inverses: &[[f64; 6]],
        (camera, points): (usize, &[u32]),
        rows: &mut Rows<'_>,
        n: usize,
        columns: &[usize],
    ) {
        let (bundle, layout) = (self.bundle, self.layout);
        let (k, e) = (self.total.get(), self.own.get());
        let of = k - e;
        let camera_of = |image: u32| bundle.images[image as usize].camera as usize;
        let column = |camera: usize| columns[bundle.images.len() + camera];
        let kept_node = bundle.images.len() + layout.camera_nodes(bundle);
        let own = column(camera);
        let mut sum = [0.0; 3 * super::MOST_COLUMNS];
        let mut t = [0.0; 3 * super::MOST_COLUMNS];
        let width = super::width::Runtime(of);
        for point in points {
            let point = *point as usize;
            sum[..3 * of].fill(0.0);
            let places = layout.first[point]..layout.first[point + 1];
            let seen = |place: usize| camera_of(layout.seen(bundle, place).image);
            for place in places.clone().filter(|p| seen(*p) == camera) {
                let w = &normal.w[place * 3 * k..][..3 * k];
                for c in 0..3 {
                    for r in 0..of {
                        sum[c * of + r] += w[c * k + e + r];
                    }
                }
            }
            if let Role::Kept(kept) = layout.roles[point] {
                let column = columns[kept_node + kept as usize];
                for r in 0..of {
                    for c in 0..3 {
                        rows.matrix[r * n + column + c] += sum[c * of + r];
                    }
                }
            }
            let g = normal.point_gradient[point];
            for r in 0..of {
                let [x, y, z] = times(&inverses[point], [sum[r], sum[of + r], sum[2 * of + r]]);
                (t[r], t[of + r], t[2 * of + r]) = (x, y, z);
                rows.right[r] += x * g[0] + y * g[1] + z * g[2];
            }
            let three = [&sum[..], &sum[of..], &sum[2 * of..]];
            subtract((width, width), (&t, of), three, &mut rows.matrix[own..], n);
            for place in places {
                let other = seen(place);
                if other > camera {
                    let w = &normal.w[place * 3 * k..][..3 * k];
                    let three = [&w[e..], &w[k + e..], &w[2 * k + e..]];
                    subtract((width, width), (&t, of), three, &mut rows.matrix[column(other)..], n);
                }
            }
        }
    }

    /// The rows of the points that are not eliminated.
    fn kept_rows(&self, normal: &Normal, matrix: &mut [f64], right: &mut [f64], pattern: &Pattern) {
        let (bundle, layout) = (self.bundle, self.layout);
        let first = bundle.images.len() + layout.camera_nodes(bundle);
        for (place, point) in layout.kept.iter().enumerate() {
            let (node, at) = (first + place, layout.kept_column(bundle, place));
            let (rows, n) = (pattern.rows(node).start, pattern.stride(node));
            let own = rows + pattern.column(node, node);
            let v = super::normal::symmetric(normal.v[*point as usize]);
            for r in 0..3 {
                for s in r..3 {
                    matrix[own + r * n + s] += v[(r, s)];
                }
                right[at + r] = -normal.point_gradient[*point as usize][r];
            }
        }
        for (distance, block) in bundle.distances.iter().zip(&normal.tied) {
            let ends = distance.ends.map(|p| layout.roles[p as usize]);
            let [Role::Kept(a), Role::Kept(b)] = ends else { continue };
            let [a, b] = [a.min(b), a.max(b)].map(|p| first + p as usize);
            let out = pattern.rows(a).start + pattern.column(a, b);
            for r in 0..3 {
                for s in 0..3 {
                    matrix[out + r * pattern.stride(a) + s] += block[(r, s)];
                }
            }
        }
    }
}
