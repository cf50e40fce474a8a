//! A frame camera with Brown's distortion, from the collinearity equations alone; and a fisheye to look with.

use super::vector::{V3, v3};

/// Camera axes x right, y down, z forward; pixels from the top-left corner of the top-left pixel.
#[derive(Clone, Debug)]
pub(crate) struct Camera {
    pub(crate) width: usize,
    pub(crate) height: usize,
    pub(crate) principal_distance: (f64, f64),
    pub(crate) principal_point: (f64, f64),
    /// k1, k2, k3 of r², r⁴, r⁶.
    pub(crate) k: [f64; 3],
    /// p1, p2 in OpenCV's order.
    pub(crate) p: [f64; 2],
    pub(crate) center: V3,
    pub(crate) right: V3,
    pub(crate) down: V3,
    pub(crate) forward: V3,
    /// Whether a pixel's distance from the principal point is the angle of its direction: a dome master. Such a camera only looks.
    pub(crate) fisheye: bool,
}

impl Camera {
    /// A camera at `center` looking at `target`, turned clockwise by `roll` about its axis.
    pub(crate) fn looking(
        (width, height): (usize, usize),
        principal_distance: f64,
        center: V3,
        target: V3,
        roll: f64,
    ) -> Self {
        let forward = (target - center).unit();
        let level = forward.cross(v3(0.0, 0.0, 1.0)).unit();
        let below = forward.cross(level);
        let (sin, cos) = roll.sin_cos();
        Self {
            width,
            height,
            principal_distance: (principal_distance, principal_distance),
            principal_point: (width as f64 / 2.0, height as f64 / 2.0),
            k: [0.0; 3],
            p: [0.0; 2],
            center,
            right: level * cos + below * sin,
            down: below * cos - level * sin,
            forward,
            fisheye: false,
        }
    }

    /// The same rays in pixels `divisor` times as large.
    pub(crate) fn coarser(&self, divisor: usize) -> Self {
        let by = 1.0 / divisor as f64;
        let scaled = |p: (f64, f64)| (p.0 * by, p.1 * by);
        Self {
            width: self.width / divisor,
            height: self.height / divisor,
            principal_distance: scaled(self.principal_distance),
            principal_point: scaled(self.principal_point),
            ..self.clone()
        }
    }

    /// Distorted from ideal image coordinates, and the derivatives by x and y.
    fn distort(&self, x: f64, y: f64) -> ((f64, f64), [f64; 4]) {
        let [k1, k2, k3] = self.k;
        let [p1, p2] = self.p;
        let r2 = x * x + y * y;
        let radial = 1.0 + r2 * (k1 + r2 * (k2 + r2 * k3));
        let slope = k1 + r2 * (2.0 * k2 + r2 * 3.0 * k3);
        let place = (
            x * radial + 2.0 * p1 * x * y + p2 * (r2 + 2.0 * x * x),
            y * radial + p1 * (r2 + 2.0 * y * y) + 2.0 * p2 * x * y,
        );
        let mixed = 2.0 * x * y * slope + 2.0 * p1 * x + 2.0 * p2 * y;
        let xx = radial + 2.0 * x * x * slope + 2.0 * p1 * y + 6.0 * p2 * x;
        let yy = radial + 2.0 * y * y * slope + 6.0 * p1 * y + 2.0 * p2 * x;
        (place, [xx, mixed, mixed, yy])
    }

    /// Ideal image coordinates of a pixel position: Newton's iteration on the distortion.
    pub(crate) fn ideal(&self, pixel: (f64, f64)) -> (f64, f64) {
        let x = (pixel.0 - self.principal_point.0) / self.principal_distance.0;
        let y = (pixel.1 - self.principal_point.1) / self.principal_distance.1;
        if self.k == [0.0; 3] && self.p == [0.0; 2] {
            return (x, y);
        }
        let (mut u, mut v) = (x, y);
        for _ in 0..12 {
            let ((a, b), [xx, xy, yx, yy]) = self.distort(u, v);
            let (ex, ey) = (x - a, y - b);
            let determinant = xx * yy - xy * yx;
            u += (ex * yy - ey * xy) / determinant;
            v += (ey * xx - ex * yx) / determinant;
            if ex.abs().max(ey.abs()) < 1e-9 {
                break;
            }
        }
        (u, v)
    }

    /// World direction of a pixel position, with unit component along the camera axis.
    pub(crate) fn direction(&self, pixel: (f64, f64)) -> V3 {
        if self.fisheye {
            let x = (pixel.0 - self.principal_point.0) / self.principal_distance.0;
            let y = (pixel.1 - self.principal_point.1) / self.principal_distance.1;
            let angle = x.hypot(y);
            let across = if angle > 0.0 { angle.sin() / angle } else { 1.0 };
            return self.right * (x * across)
                + self.down * (y * across)
                + self.forward * angle.cos();
        }
        let (x, y) = self.ideal(pixel);
        self.right * x + self.down * y + self.forward
    }

    /// Pixel position of a world point before the camera and inside the frame.
    pub(crate) fn project(&self, point: V3) -> Option<(f64, f64)> {
        let d = point - self.center;
        let depth = self.forward.dot(d);
        if depth <= 0.0 {
            return None;
        }
        let (x, y) = (self.right.dot(d) / depth, self.down.dot(d) / depth);
        // Far outside the frame the distortion polynomial folds back into it.
        let reach = (self.width as f64).hypot(self.height as f64) / self.principal_distance.0;
        if x.hypot(y) > 0.62 * reach {
            return None;
        }
        let ((a, b), _) = self.distort(x, y);
        let pixel = (
            self.principal_distance.0 * a + self.principal_point.0,
            self.principal_distance.1 * b + self.principal_point.1,
        );
        let inside = pixel.0 >= 0.0
            && pixel.1 >= 0.0
            && pixel.0 <= self.width as f64
            && pixel.1 <= self.height as f64;
        inside.then_some(pixel)
    }

    /// Quaternion w, x, y, z of the rotation camera from world.
    pub(crate) fn quaternion(&self) -> [f64; 4] {
        let (r, d, f) = (self.right, self.down, self.forward);
        let squares = [
            1.0 + r.x + d.y + f.z,
            1.0 + r.x - d.y - f.z,
            1.0 - r.x + d.y - f.z,
            1.0 - r.x - d.y + f.z,
        ];
        let largest = (0..4).max_by(|&i, &j| squares[i].total_cmp(&squares[j])).unwrap_or(0);
        let twice = squares[largest].sqrt();
        let products = match largest {
            0 => [squares[0], f.y - d.z, r.z - f.x, d.x - r.y],
            1 => [f.y - d.z, squares[1], r.y + d.x, f.x + r.z],
            2 => [r.z - f.x, r.y + d.x, squares[2], d.z + f.y],
            _ => [d.x - r.y, f.x + r.z, d.z + f.y, squares[3]],
        };
        let sign = if products[0] < 0.0 { -1.0 } else { 1.0 };
        products.map(|q| sign * q / (2.0 * twice))
    }
}
