//! The pose and the principal distance of a camera from four points.

use alloc::vec::Vec;

use nalgebra::{Matrix3, Point2, Point3, Rotation3, Vector2, Vector3};

use super::p3p;
use crate::error::Error;
use crate::geometry::Pose;
use crate::geometry::rotation::{RotationVector, orthonormalised};
use crate::numeric::triangular::Triangular;

/// A pose and a principal distance found by [`p4pf`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FocalPose {
    /// camera_from_world.
    pub pose: Pose,
    /// f, in pixels.
    pub principal_distance: f64,
    /// The root mean square of the eight residuals, in pixels: rounding for exact points, the square root of an eighth of the noise for
    /// measured ones, since seven numbers are estimated.
    pub residual: f64,
}

/// The cameras of unknown principal distance that show four known points at four image points, the best first.
///
/// *Model.* Square pixels, a known principal point (x₀, y₀), no lens errors:
///
/// ```text
/// minimise Σ (f Xᵢ/Zᵢ − xᵢ)² + (f Yᵢ/Zᵢ − yᵢ)²,   (X, Y, Z)ᵢ = R (Pᵢ − C) in camera axes,   over f, R, C
/// ```
///
/// Eight equations for seven unknowns: all local minima with the points in front and a residual below a tenth of the image's radius. For
/// exact points the first is the true camera; the others have residuals that tell them from it.
///
/// *Method.* For a given f the poses of the best-shaped three points are the roots of [`p3p`](super::p3p()). Over 256 values of f, in equal
/// ratios, each root whose distance from the fourth image point is smaller than at the values beside is refined by Gauß–Newton
/// steps on all eight. Unlike eliminations to one polynomial (Bujnak, Kukelova & Pajdla 2008) this knows no degenerate choice of three
/// equations, and takes points in a plane as well as others. What lies between the values of f can escape it: of 20 000 random exact
/// scenes one was missed, whose image points lay nearly on a line.
///
/// *Domain.* f between a twentieth of and two hundred times the largest distance of an image point from the principal point: half
/// angles of view from 0.3° to 87°.
///
/// *Frames and units.* Pixels; world units, relative to the first point inside. The principal point is mostly the middle of the picture.
///
/// # Errors
/// [`Error::NotFinite`]; [`Error::Degenerate`] where the object or the image points lie on a line (the measure is twice the largest triangle's area over the
/// square of the longest side), and where every minimum leaves f open, as points of a plane parallel to the picture do (the measure is the smallest
/// singular value of the scaled equations). No minimum is no error: the result is empty.
///
/// # Example
/// f = 800 and x₀ = y₀ = 500, the world's axes the camera's, the origin 10 before it: (1, 2, 0) is seen at (500 + 80, 500 + 160).
/// ```
/// use collinear::adjust::p4pf;
/// use collinear::nalgebra::{Point2, Point3};
///
/// let object = [[1., 2., 0.], [-2., 1., 2.], [2., -1., -2.], [-1., -2., 6.]].map(Point3::from);
/// let image = [[580., 660.], [500. - 400. / 3., 500. + 200. / 3.], [700., 400.], [450., 400.]].map(Point2::from);
/// let found = p4pf(&object, &image, &Point2::new(500.0, 500.0))?;
/// assert!((found[0].principal_distance - 800.0).abs() < 1e-9);
/// assert!((found[0].pose.origin - Point3::new(0.0, 0.0, -10.0)).norm() < 1e-10);
/// # Ok::<(), collinear::Error>(())
/// ```
#[doc(alias("P4Pf", "PnPf", "unknown focal length", "uncalibrated resection"))]
pub fn p4pf(
    object: &[Point3<f64>; 4],
    image: &[Point2<f64>; 4],
    principal_point: &Point2<f64>,
) -> Result<Vec<FocalPose>, Error> {
    let task = Task::new(object, image, principal_point)?;
    let mut found: Vec<FocalPose> = Vec::new();
    let mut open: Option<f64> = None;
    for start in task.starts() {
        match task.refine(start) {
            Refined::Minimum(root) => {
                let same = |other: &FocalPose| {
                    (other.principal_distance / root.principal_distance - 1.0).abs() < 1e-6
                        && (other.pose.rotation.matrix() - root.pose.rotation.matrix()).amax()
                            < 1e-6
                };
                if !found.iter().any(same) {
                    found.push(root);
                }
            }
            Refined::Open(pivot) => open = Some(pivot),
            Refined::None => {}
        }
    }
    if let (true, Some(measure)) = (found.is_empty(), open) {
        let what = "principal distance that four points leave open";
        return Err(Error::Degenerate { what, measure, limit: LEAST_PIVOT });
    }
    found.sort_by(|a, b| a.residual.total_cmp(&b.residual));
    Ok(found)
}

/// Values of f that are tried, and their range in units of the image's radius.
const VALUES: i32 = 256;
const LEAST: f64 = 0.05;
const LARGEST: f64 = 200.0;
/// Pivots of the scaled equations below it leave an unknown open.
const LEAST_PIVOT: f64 = 1e-9;

/// A pose of the first three points for one f.
#[derive(Clone, Copy, Debug)]
struct Start {
    /// f in units of the image's radius.
    f: f64,
    rotation: Rotation3<f64>,
    /// The centroid of the four points in camera axes, in units of their extent.
    place: Vector3<f64>,
    /// The fourth point's squared distance from its image.
    squared: f64,
}

enum Refined {
    Minimum(FocalPose),
    Open(f64),
    None,
}

struct Task {
    /// The points about their centroid, in units of their extent; the first three are the best-shaped triangle.
    object: [Vector3<f64>; 4],
    /// About the principal point, in units of the radius.
    image: [Vector2<f64>; 4],
    centroid: Point3<f64>,
    extent: f64,
    radius: f64,
}

/// Twice a triangle's area over the square of its longest side.
fn shape(a: &Vector3<f64>, b: &Vector3<f64>, c: &Vector3<f64>) -> f64 {
    let (u, v) = (b - a, c - a);
    let longest = u.norm_squared().max(v.norm_squared()).max((v - u).norm_squared());
    if longest > 0.0 { u.cross(&v).norm() / longest } else { 0.0 }
}

impl Task {
    fn new(
        object: &[Point3<f64>; 4],
        image: &[Point2<f64>; 4],
        principal_point: &Point2<f64>,
    ) -> Result<Self, Error> {
        let first = object[0];
        let centroid = first + object.iter().fold(Vector3::zeros(), |s, p| s + (p - first) * 0.25);
        let extent = object.iter().map(|p| (p - centroid).amax()).fold(0.0, f64::max);
        let radius = image.iter().map(|p| (p - principal_point).norm()).fold(0.0, f64::max);
        if !(object.iter().all(|p| p.iter().all(|c| c.is_finite())) && extent.is_finite()) {
            return Err(Error::NotFinite { what: "object point" });
        }
        let seen = || image.iter().chain([principal_point]);
        if !(seen().all(|p| p.x.is_finite() && p.y.is_finite()) && radius.is_finite()) {
            return Err(Error::NotFinite { what: "image point" });
        }
        let points =
            object.map(|p| if extent > 0.0 { (p - centroid) / extent } else { Vector3::zeros() });
        let flat = image
            .map(|p| if radius > 0.0 { (p - principal_point) / radius } else { Vector2::zeros() });
        // The triangle that is well shaped on the ground and in the picture.
        let triples = [[0, 1, 2, 3], [0, 1, 3, 2], [0, 2, 3, 1], [1, 2, 3, 0]];
        let shapes = triples.map(|[a, b, c, _]| {
            let lifted = [a, b, c].map(|i| flat[i].push(0.0));
            [shape(&points[a], &points[b], &points[c]), shape(&lifted[0], &lifted[1], &lifted[2])]
        });
        let coordinates = object.iter().map(|p| p.coords.amax()).fold(0.0, f64::max);
        let pixels = seen().map(|p| p.coords.amax()).fold(0.0, f64::max);
        let bounds = [
            ("four object points on a line", coordinates / extent),
            ("four image points on a line", pixels / radius),
        ];
        for (side, (what, largest)) in bounds.into_iter().enumerate() {
            let measure = shapes.iter().map(|s| s[side]).fold(0.0, f64::max);
            let limit = 8.0 * f64::EPSILON * (1.0 + largest);
            if !(measure > limit) {
                return Err(Error::Degenerate { what, measure, limit });
            }
        }
        let mut best = 0;
        for i in 1..4 {
            if shapes[i][0] * shapes[i][1] > shapes[best][0] * shapes[best][1] {
                best = i;
            }
        }
        let order = triples[best];
        Ok(Self {
            object: order.map(|i| points[i]),
            image: order.map(|i| flat[i]),
            centroid,
            extent,
            radius,
        })
    }

    /// The roots for one f.
    fn roots(&self, f: f64) -> Vec<Start> {
        let [a, b, c, _] = self.object.map(Point3::from);
        let directions = [0, 1, 2].map(|i| self.image[i].push(f));
        let Ok(poses) = p3p(&[a, b, c], &directions) else { return Vec::new() };
        poses
            .into_iter()
            .map(|pose| {
                let seen = pose.rotation * (self.object[3] - pose.origin.coords);
                let offset = seen.xy() * (f / seen.z) - self.image[3];
                let squared = if seen.z > 0.0 { offset.norm_squared() } else { f64::INFINITY };
                Start { f, rotation: pose.rotation, place: pose.translation(), squared }
            })
            .collect()
    }

    /// Where along f a root comes nearest to the fourth image point. A root without a neighbour is taken: its branch ends there.
    fn starts(&self) -> Vec<Start> {
        let ratio = (LARGEST / LEAST).ln() / f64::from(VALUES - 1);
        let value = |k: i32| LEAST * (ratio * f64::from(k)).exp();
        let mut window = [Vec::new(), self.roots(value(0)), self.roots(value(1))];
        let mut starts = Vec::new();
        for k in 0..VALUES {
            let [before, here, after] = &window;
            for root in here {
                let beside = |others: &[Start]| {
                    let distance = |o: &Start| {
                        (o.rotation.matrix() - root.rotation.matrix()).norm()
                            + (o.place / o.f - root.place / root.f).norm() * root.f
                                / root.place.norm()
                    };
                    let nearest = others.iter().min_by(|a, b| distance(a).total_cmp(&distance(b)));
                    nearest.filter(|o| distance(o) < 0.5).map_or(f64::INFINITY, |o| o.squared)
                };
                if root.squared.is_finite()
                    && root.squared <= beside(before)
                    && root.squared <= beside(after)
                {
                    starts.push(*root);
                }
            }
            let next = if k + 2 < VALUES { self.roots(value(k + 2)) } else { Vec::new() };
            window.rotate_left(1);
            window[2] = next;
        }
        starts
    }

    /// Residuals (image minus projection) with their slopes by ln f, δ and the place; `None` behind the camera.
    fn equations(&self, state: &Start) -> Option<(f64, [[f64; 8]; 8])> {
        let mut rows = [[0.0; 8]; 8];
        let mut sum = 0.0;
        for (i, (point, seen)) in self.object.iter().zip(&self.image).enumerate() {
            let turned = state.rotation * point;
            let x = turned + state.place;
            if !(x.z > 0.0) {
                return None;
            }
            let projected = x.xy() * (state.f / x.z);
            let by_x = [
                Vector3::new(state.f / x.z, 0.0, -projected.x / x.z),
                Vector3::new(0.0, state.f / x.z, -projected.y / x.z),
            ];
            for axis in 0..2 {
                let residual = seen[axis] - projected[axis];
                sum += residual * residual;
                // ∂/∂δ of (δ × turned) · g is turned × g.
                let by_turn = turned.cross(&by_x[axis]);
                let g = by_x[axis];
                rows[2 * i + axis] =
                    [projected[axis], by_turn.x, by_turn.y, by_turn.z, g.x, g.y, g.z, residual];
            }
        }
        sum.is_finite().then_some((sum, rows))
    }

    fn refine(&self, mut state: Start) -> Refined {
        let Some((mut sum, mut rows)) = self.equations(&state) else { return Refined::None };
        let mut last = f64::INFINITY;
        for _ in 0..50 {
            let step = match solve(&rows, state.place.norm()) {
                Ok(step) => step,
                Err(pivot) => return Refined::Open(pivot),
            };
            // Shortened until it helps.
            let mut factor = 1.0;
            let moved = loop {
                let next = state.moved(&step, factor);
                if let Some((after, rows)) = next.and_then(|n| self.equations(&n))
                    && after < sum
                {
                    break next.map(|n| (n, after, rows));
                }
                factor *= 0.25;
                if factor < 1e-3 {
                    break None;
                }
            };
            last = step.iter().map(|s| s.abs()).fold(0.0, f64::max);
            let Some((next, after, next_rows)) = moved else { break };
            (state, sum, rows) = (next, after, next_rows);
            if last < 1e-15 {
                break;
            }
        }
        let residual = (sum / 8.0).sqrt();
        let within = state.f > 0.5 * LEAST && state.f < 2.0 * LARGEST;
        // A step that no longer helps is short at a minimum.
        if !(last < 1e-6 && residual < 0.1 && within) {
            return Refined::None;
        }
        let origin = self.centroid - state.rotation.inverse() * state.place * self.extent;
        Refined::Minimum(FocalPose {
            pose: Pose::new(state.rotation, origin),
            principal_distance: state.f * self.radius,
            residual: residual * self.radius,
        })
    }
}

/// The Gauß–Newton step for ln f, δ and the place over the range; the smallest singular value of the equations, whose columns have length
/// one, where they leave an unknown open.
fn solve(rows: &[[f64; 8]; 8], range: f64) -> Result<[f64; 7], f64> {
    let mut scale = [1.0; 8];
    for (j, scale) in scale.iter_mut().enumerate().take(7) {
        let length = rows.iter().map(|r| r[j] * r[j]).sum::<f64>().sqrt();
        if !(length > 0.0) {
            return Err(0.0);
        }
        *scale = 1.0 / length;
    }
    let mut triangle = Triangular::<8>::new();
    for row in rows {
        triangle.add_row(core::array::from_fn(|j| row[j] * scale[j]));
    }
    let Some(x) = triangle.solve(LEAST_PIVOT) else {
        let mut unknowns = Triangular::<7>::new();
        for row in rows {
            unknowns.add_row(core::array::from_fn(|j| row[j] * scale[j]));
        }
        return Err(unknowns.singular().0[6]);
    };
    Ok(core::array::from_fn(|j| x[j] * scale[j] / if j < 4 { 1.0 } else { range }))
}

impl Start {
    fn moved(&self, step: &[f64; 7], factor: f64) -> Option<Self> {
        let s = step.map(|s| s * factor);
        // A longer step is no small change of f.
        let f = self.f * s[0].clamp(-1.0, 1.0).exp();
        let turn = RotationVector { x: s[1], y: s[2], z: s[3] }.rotation();
        let product: Matrix3<f64> = turn.matrix() * self.rotation.matrix();
        let rotation = orthonormalised(&product).ok()?;
        let place = self.place + Vector3::new(s[4], s[5], s[6]) * self.place.norm();
        Some(Self { f, rotation, place, squared: 0.0 })
    }
}
