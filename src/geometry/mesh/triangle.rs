//! One triangle: where a ray meets it, and its nearest point.

use nalgebra::{Point3, Vector3};

use crate::geometry::ray::Ray;

/// A ray in the coordinates of Woop et al. 2013: the axis along which it is steepest last, sheared so that it runs along that axis.
pub(super) struct Sheared {
    origin: Point3<f64>,
    axes: [usize; 3],
    shear: [f64; 2],
    scale: f64,
}

impl Sheared {
    pub(super) fn new(ray: &Ray) -> Self {
        let d = &ray.direction;
        let along = d.iamax();
        let (mut x, mut y) = ((along + 1) % 3, (along + 2) % 3);
        if d[along] < 0.0 {
            core::mem::swap(&mut x, &mut y);
        }
        let shear = [d[x] / d[along], d[y] / d[along]];
        Self { origin: ray.origin, axes: [x, y, along], shear, scale: 1.0 / d[along] }
    }

    /// The distance along the ray at which it meets the triangle.
    ///
    /// The signs of the three edge functions of two triangles that share an edge are exactly opposite there, so one of them is met.
    pub(super) fn distance(&self, corners: &[Point3<f64>; 3]) -> Option<f64> {
        let [x, y, along] = self.axes;
        let [a, b, c] = corners.map(|corner| {
            let p = corner - self.origin;
            [p[x] - self.shear[0] * p[along], p[y] - self.shear[1] * p[along], p[along]]
        });
        let edge = |p: &[f64; 3], q: &[f64; 3]| p[0] * q[1] - p[1] * q[0];
        let weights = [edge(&c, &b), edge(&a, &c), edge(&b, &a)];
        if weights.iter().any(|w| *w < 0.0) && weights.iter().any(|w| *w > 0.0) {
            return None;
        }
        let sum: f64 = weights.iter().sum();
        if sum == 0.0 {
            return None;
        }
        // Divided first: a convex sum of the corners' distances does not overflow.
        let [u, v, w] = weights.map(|weight| weight / sum);
        let distance = (u * a[2] + v * b[2] + w * c[2]) * self.scale;
        (distance >= 0.0 && distance.is_finite()).then_some(distance)
    }
}

/// How far a point is off the plane of a triangle, positive on the side from which its vertices turn counter-clockwise.
pub(super) fn height([a, b, c]: &[Point3<f64>; 3], p: &Point3<f64>) -> f64 {
    let normal = (b - a).cross(&(c - a));
    let length = normal.norm();
    if length > 0.0 { normal.dot(&(p - a)) / length } else { 0.0 }
}

/// The point of a triangle nearest to p (Ericson 2005, 5.1.5): by the Voronoi region of vertices, edges and face that p is in.
pub(super) fn nearest([a, b, c]: &[Point3<f64>; 3], p: &Point3<f64>) -> Point3<f64> {
    let (ab, ac) = (b - a, c - a);
    let dots = |from: &Point3<f64>| -> (f64, f64) {
        let to: Vector3<f64> = p - from;
        (ab.dot(&to), ac.dot(&to))
    };
    let ((d1, d2), (d3, d4), (d5, d6)) = (dots(a), dots(b), dots(c));
    if d1 <= 0.0 && d2 <= 0.0 {
        return *a;
    }
    if d3 >= 0.0 && d4 <= d3 {
        return *b;
    }
    if d6 >= 0.0 && d5 <= d6 {
        return *c;
    }
    // Products of the areas that p makes with the edges.
    let on_ab = d1 * d4 - d3 * d2;
    if on_ab <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        return a + ab * (d1 / (d1 - d3));
    }
    let on_ac = d5 * d2 - d1 * d6;
    if on_ac <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        return a + ac * (d2 / (d2 - d6));
    }
    let on_bc = d3 * d6 - d5 * d4;
    if on_bc <= 0.0 && d4 >= d3 && d5 >= d6 {
        return b + (c - b) * ((d4 - d3) / ((d4 - d3) + (d5 - d6)));
    }
    let sum = on_bc + on_ac + on_ab;
    a + ab * (on_ac / sum) + ac * (on_ab / sum)
}
