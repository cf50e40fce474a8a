//! A texture stretched bilinearly over a quadrilateral in space, seen in perspective.
#![allow(
    clippy::neg_cmp_op_on_partial_ord,
    reason = "a comparison that must fail for NaN is written negated"
)]

use nalgebra::{Matrix2, Point2, Vector3};

use super::Map;
use super::polynomial::{cross, solve_bilinear};
use crate::error::{Error, ProjectionError};
use crate::numeric::scalar::Scalar;
use crate::numeric::twofold::Twofold;

/// A rectangular texture on a quadrilateral of four corners in space, planar or not, seen in perspective (Hourcade &
/// Nicolas 1983, as \[WD\] tells it).
///
/// *Model.* With s = u / width, t = v / height, and hᵢ = (xᵢ wᵢ, yᵢ wᵢ, wᵢ) the corners in homogeneous screen
/// coordinates:
///
/// ```text
/// h(s, t) = a + b s + c t + d s t,   a = h₀₀, b = h₁₀ − h₀₀, c = h₀₁ − h₀₀, d = h₁₁ − h₁₀ − h₀₁ + h₀₀
/// forward:   x = h_x / h_w,   y = h_y / h_w
/// inverse:   (h_x − x h_w, h_y − y h_w) = 0, two bilinear equations in s and t: a quadratic at each pixel
/// ```
///
/// Where d = 0 (the quadrilateral is a parallelogram in space) this is a homography. A planar quadrilateral that is no
/// parallelogram carries the texture with its bilinear bend, unlike the homography of its corners.
///
/// *Which root.* A ray can meet the bilinear patch twice. Of the points in the texture's rectangle (to 10⁻⁹ of its
/// sides) and in front of the eye (`h_w` > 0) it is the one nearer to the eye, the smaller `h_w`.
///
/// *Frames.* Screen and texture in pixels from their top-left corners; w in the units of the corners, growing with
/// depth.
///
/// *Accuracy.* The screen is taken relative to the quad's middle, the quadratic's coefficients are formed in twice the
/// precision, and a Newton step polishes the root: the forward map returns to the pixel within some 10⁻¹² of the
/// quad's size, except on the patch's silhouette, where the roots meet.
///
/// ```
/// use collinear::mapping::{Map, perspective_bilinear::PerspectiveBilinear};
/// use nalgebra::{Point2, Vector3};
///
/// // Corners for the texture's (0, 0), (64, 0), (64, 32), (0, 32), as (x w, y w, w).
/// let corners = [(0.0, 0.0, 1.0), (200.0, 20.0, 2.0), (330.0, 300.0, 3.0), (0.0, 150.0, 1.5)];
/// let map = PerspectiveBilinear::new(&corners.map(|(x, y, w)| Vector3::new(x, y, w)), [64.0, 32.0])?;
/// // The texture's centre is the mean of the homogeneous corners: (132.5, 117.5, 1.875).
/// let centre = map.screen_from_texture(&Point2::new(32.0, 16.0))?;
/// assert!((centre - Point2::new(132.5 / 1.875, 117.5 / 1.875)).norm() < 1e-13);
/// assert!((map.at(&centre)? - Point2::new(32.0, 16.0)).norm() < 1e-12);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PerspectiveBilinear {
    /// a, b, c, d with the screen relative to `origin`.
    terms: [[f64; 3]; 4],
    origin: [f64; 2],
    size: [f64; 2],
}

/// A point of the patch that a pixel's ray meets.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PatchPoint {
    /// The texture point; it may lie outside the texture.
    pub texture: Point2<f64>,
    /// The homogeneous w there: growing with depth, positive in front of the eye.
    pub w: f64,
}

/// How far beyond its sides, in units of them, the texture's rectangle is taken to reach, so that pixels on an edge
/// are in it whatever their rounding.
const SLACK: f64 = 1e-9;

impl PerspectiveBilinear {
    /// From the homogeneous screen coordinates (x w, y w, w) of the texture's corners (0, 0), (width, 0),
    /// (width, height), (0, height).
    ///
    /// Corners behind the eye (w ≤ 0) are allowed, as long as one is in front.
    ///
    /// # Errors
    /// [`Error::NotFinite`]; [`Error::OutOfRange`] for a texture side that is not positive, a corner coordinate beyond
    /// 10¹⁰⁰, or a quad wholly behind the eye.
    pub fn new(corners: &[Vector3<f64>; 4], texture_size: [f64; 2]) -> Result<Self, Error> {
        for value in corners.iter().flat_map(|c| c.iter()).chain(&texture_size) {
            if !value.is_finite() {
                return Err(Error::NotFinite { what: "quad corner or texture size" });
            }
            if value.abs() > 1e100 {
                return Err(Error::OutOfRange {
                    what: "quad corner or texture size",
                    value: *value,
                    expected: "at most 1e100 in magnitude",
                });
            }
        }
        if let Some(side) = texture_size.iter().find(|s| **s <= 0.0) {
            return Err(Error::OutOfRange {
                what: "texture side",
                value: *side,
                expected: "a positive length",
            });
        }
        let nearest = corners.iter().max_by(|a, b| a.z.total_cmp(&b.z));
        let middle = corners.iter().filter(|c| c.z > 0.0).fold(None, |sum, c| {
            let [x, y, n] = sum.unwrap_or([0.0; 3]);
            Some([x + c.x / c.z, y + c.y / c.z, n + 1.0])
        });
        let Some([x, y, n]) = middle else {
            return Err(Error::OutOfRange {
                what: "w of every quad corner",
                value: nearest.map_or(0.0, |c| c.z),
                expected: "at least one corner in front of the eye",
            });
        };
        let origin = [x / n, y / n];
        if !(origin[0].is_finite() && origin[1].is_finite()) {
            return Err(Error::NotFinite { what: "screen position of a quad corner" });
        }
        // hₓ − x₀ w: the corner relative to the origin, rounded once.
        let relative =
            |h: f64, o: f64, w: f64| (Twofold::new(h) - Twofold::new(o) * Twofold::new(w)).round();
        let h =
            corners.map(|c| [relative(c.x, origin[0], c.z), relative(c.y, origin[1], c.z), c.z]);
        let component = |f: &dyn Fn(usize) -> f64| -> [f64; 3] { core::array::from_fn(f) };
        let terms = [
            h[0],
            component(&|i| h[1][i] - h[0][i]),
            component(&|i| h[3][i] - h[0][i]),
            component(&|i| (h[2][i] - h[1][i]) - (h[3][i] - h[0][i])),
        ];
        Ok(Self { terms, origin, size: texture_size })
    }

    /// The size of the texture, in pixels.
    #[must_use]
    pub fn texture_size(&self) -> [f64; 2] {
        self.size
    }

    /// h relative to the origin, at s and t.
    fn homogeneous<S: Scalar>(&self, s: S, t: S) -> [S; 3] {
        let [a, b, c, d] = &self.terms;
        core::array::from_fn(|i| {
            S::constant(a[i]) + s.scale(b[i]) + t * (S::constant(c[i]) + s.scale(d[i]))
        })
    }

    /// The screen point of a texture point, inside the texture or not.
    ///
    /// # Errors
    /// [`ProjectionError::BehindCamera`] where `h_w` ≤ 0, and [`ProjectionError::NotFinite`].
    pub fn screen_from_texture(
        &self,
        texture: &Point2<f64>,
    ) -> Result<Point2<f64>, ProjectionError> {
        let [x, y, w] = self.homogeneous(texture.x / self.size[0], texture.y / self.size[1]);
        if w <= 0.0 {
            return Err(ProjectionError::BehindCamera { depth: w });
        }
        let p = Point2::new(self.origin[0] + x / w, self.origin[1] + y / w);
        if p.x.is_finite() && p.y.is_finite() { Ok(p) } else { Err(ProjectionError::NotFinite) }
    }

    /// The two bilinear equations of a pixel: their terms in 1, s, t and s t.
    fn equations(&self, screen: &Point2<f64>) -> [[f64; 2]; 4] {
        let (x, y) = (screen.x - self.origin[0], screen.y - self.origin[1]);
        self.terms.map(|[hx, hy, w]| [hx - x * w, hy - y * w])
    }

    /// (s, t, w) of the points that a pixel's line of sight meets.
    fn solve(&self, screen: &Point2<f64>) -> Result<[Option<[f64; 3]>; 2], ProjectionError> {
        let [a, b, c, d] = self.equations(screen);
        if !a.iter().chain(&b).chain(&c).chain(&d).all(|v| v.is_finite()) {
            return Err(ProjectionError::NotFinite);
        }
        let roots = solve_bilinear([-a[0], -a[1]], b, c, d)
            .map_err(|short| ProjectionError::OutsideDomain { value: 1.0 + short, limit: 1.0 })?;
        Ok(roots.map(|r| r.map(|[s, t]| [s, t, self.homogeneous(s, t)[2]])))
    }

    /// The points of the patch, extended beyond its sides, on a pixel's line of sight in front of the eye, the nearer
    /// first.
    ///
    /// # Errors
    /// [`ProjectionError::NotFinite`]; [`ProjectionError::OutsideDomain`] where the line misses the patch: the value is
    /// 4 times the product of the quadratic's outer coefficients over the square of the inner one, its limit 1.
    pub fn roots(&self, screen: &Point2<f64>) -> Result<[Option<PatchPoint>; 2], ProjectionError> {
        let point = |[s, t, w]: [f64; 3]| PatchPoint {
            texture: Point2::new(s * self.size[0], t * self.size[1]),
            w,
        };
        let in_front = self.solve(screen)?.map(|r| r.filter(|[_, _, w]| *w > 0.0).map(point));
        Ok(match in_front {
            [Some(a), Some(b)] if b.w < a.w => [Some(b), Some(a)],
            [None, Some(b)] => [Some(b), None],
            ordered => ordered,
        })
    }

    /// (s, t, w) of the point that the pixel shows.
    fn visible(&self, screen: &Point2<f64>) -> Result<[f64; 3], ProjectionError> {
        let mut best: Option<[f64; 3]> = None;
        let (mut depth, mut outside) = (f64::NEG_INFINITY, f64::INFINITY);
        for root in self.solve(screen)?.into_iter().flatten() {
            let [s, t, w] = root;
            let far = f64::max((2.0 * s - 1.0).abs(), (2.0 * t - 1.0).abs());
            if !(far <= 1.0 + SLACK) {
                outside = outside.min(far);
            } else if !(w > 0.0) {
                depth = depth.max(w);
            } else if best.is_none_or(|b| w < b[2]) {
                best = Some(root);
            }
        }
        match best {
            Some(root) => Ok(root),
            None if depth > f64::NEG_INFINITY => Err(ProjectionError::BehindCamera { depth }),
            None => Err(ProjectionError::OutsideDomain { value: outside, limit: 1.0 }),
        }
    }
}

impl Map for PerspectiveBilinear {
    /// The texture point that a screen point shows.
    ///
    /// # Errors
    /// [`ProjectionError::OutsideDomain`] outside the quad: the value is the larger of |2s − 1| and |2t − 1| at the
    /// nearest root, its limit 1 (or as [`roots`](Self::roots) where there is none);
    /// [`ProjectionError::BehindCamera`] where the quad is met behind the eye; [`ProjectionError::NotFinite`].
    fn at(&self, screen: &Point2<f64>) -> Result<Point2<f64>, ProjectionError> {
        let [s, t, _] = self.visible(screen)?;
        Ok(Point2::new(s * self.size[0], t * self.size[1]))
    }

    /// By implicit differentiation of the two equations: `∂(s, t)/∂(x, y) = h_w M⁻¹` with
    /// `M = ∂(h_x − x h_w, h_y − y h_w)/∂(s, t)`.
    ///
    /// # Errors
    /// As [`at`](Self::at), and [`ProjectionError::OutsideDomain`] with value and limit 0 on the silhouette, where M
    /// is singular.
    fn jacobian(&self, screen: &Point2<f64>) -> Result<Matrix2<f64>, ProjectionError> {
        let [s, t, w] = self.visible(screen)?;
        let [_, b, c, d] = self.equations(screen);
        let by_s: [f64; 2] = core::array::from_fn(|i| b[i] + d[i] * t);
        let by_t: [f64; 2] = core::array::from_fn(|i| c[i] + d[i] * s);
        let factor = w / cross(by_s, by_t);
        let [width, height] = self.size;
        let m = Matrix2::new(
            factor * by_t[1] * width,
            -factor * by_t[0] * width,
            -factor * by_s[1] * height,
            factor * by_s[0] * height,
        );
        if m.iter().all(|v| v.is_finite()) {
            Ok(m)
        } else {
            Err(ProjectionError::OutsideDomain { value: 0.0, limit: 0.0 })
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::scalar::Dual;

    #[test]
    fn jacobian_inverts_the_dual_numbers_of_the_forward_map() {
        let corners = [(0.0, 0.0, 1.0), (200.0, 20.0, 2.0), (330.0, 300.0, 3.0), (0.0, 150.0, 1.5)]
            .map(|(x, y, w)| Vector3::new(x, y, w));
        let map = PerspectiveBilinear::new(&corners, [1.0, 1.0]).unwrap();
        for (s, t) in [(0.1, 0.2), (0.5, 0.9), (0.8, 0.3)] {
            let [x, y, w] = map.homogeneous(Dual::<2>::variable(s, 0), Dual::<2>::variable(t, 1));
            let (x, y) = (x / w, y / w);
            let forward = Matrix2::new(x.gradient[0], x.gradient[1], y.gradient[0], y.gradient[1]);
            let screen = Point2::new(x.value + map.origin[0], y.value + map.origin[1]);
            let inverse = map.jacobian(&screen).unwrap();
            assert!((forward * inverse - Matrix2::identity()).norm() < 1e-12);
        }
    }
}
