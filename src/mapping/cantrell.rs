//! Cantrell's form: a textured plane given by vectors in eye coordinates.

use nalgebra::{Point2, Point3, Vector3};

use super::FractionalLinear;
use crate::error::Error;

/// A plane with texture axes, in eye coordinates: \[C\]'s N, P, C, U and V.
///
/// # Model
/// ```text
/// z  = d (N·P) / (N·(x′, y′, d))
/// Tx = (N·P) (U·(x′, y′, d)) / (N·(x′, y′, d)) − U·C
/// Ty = (N·P) (V·(x′, y′, d)) / (N·(x′, y′, d)) − V·C                                        [C], basic result
/// ```
/// with (x′, y′) the screen point from the principal point, in the units of the screen distance d. Multiplied out, with
/// k = N·P, these are \[WD\] eq. 1's coefficients
///
/// ```text
/// P₁ = k Ux − (U·C) Nx    P₂ = k Uy − (U·C) Ny    P₀ = d (k Uz − (U·C) Nz)
/// R₁ = Nx                 R₂ = Ny                 R₀ = d Nz
/// ```
/// Q is P with V for U. The denominator is d k / z: inverse depth up to a factor, so that one sign decides.
///
/// # Frames and units
/// Eye at the origin, z forward, x and y as on the screen (y down in this crate). N needs no unit length.
///
/// \[C\] has U and V of unit length and orthogonal, which makes a texel a world unit. In general U and V are the reciprocal
/// basis of the texel's edges in the plane ([`from_texel`](Self::from_texel)): an edge a of one texel, orthogonal to the
/// other, enters as a / |a|².
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CantrellPlane {
    /// N, any length.
    pub normal: Vector3<f64>,
    /// P, any point of the plane.
    pub point: Point3<f64>,
    /// C, the point of the plane where the texture's (0, 0) lies.
    pub origin: Point3<f64>,
    /// U, texels a world unit towards increasing u.
    pub u_axis: Vector3<f64>,
    /// V, texels a world unit towards increasing v.
    pub v_axis: Vector3<f64>,
}

impl CantrellPlane {
    /// From the texture's corner and the edge vectors of one texel, in eye coordinates; the edges need not be orthogonal.
    ///
    /// # Errors
    /// [`Error::Degenerate`] where the edges are parallel or vanish; the measure is the sine of their angle.
    pub fn from_texel(
        origin: Point3<f64>,
        texel_u: Vector3<f64>,
        texel_v: Vector3<f64>,
    ) -> Result<Self, Error> {
        let normal = texel_u.cross(&texel_v);
        let measure = normal.norm() / (texel_u.norm() * texel_v.norm());
        let limit = 1e-14;
        if !(measure > limit) {
            let measure = if measure.is_finite() { measure } else { 0.0 };
            return Err(Error::Degenerate { what: "texel edges", measure, limit });
        }
        let area = normal.norm_squared();
        Ok(Self {
            normal,
            point: origin,
            origin,
            u_axis: texel_v.cross(&normal) / area,
            v_axis: normal.cross(&texel_u) / area,
        })
    }

    /// The coefficients for a screen at distance `d`, in coordinates centred on the principal point.
    ///
    /// # Errors
    /// [`Error::Degenerate`] where the plane passes through the eye; the measure is N·P / |N|.
    ///
    /// # Example
    /// A floor 2 below the eye, one texel a unit, d = 100: at y′ = 50 the floor is 4 ahead (similar triangles).
    ///
    /// ```
    /// use collinear::mapping::{CantrellPlane, Map};
    /// use nalgebra::{Point2, Point3, Vector3};
    ///
    /// let floor = CantrellPlane::from_texel(Point3::new(0.0, 2.0, 0.0), Vector3::x(), Vector3::z())?;
    /// let map = floor.fractional_linear(100.0)?;
    /// let t = map.at(&Point2::new(25.0, 50.0))?;
    /// assert!((t - Point2::new(1.0, 4.0)).norm() < 1e-15);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn fractional_linear(&self, d: f64) -> Result<FractionalLinear, Error> {
        if !(d > 0.0 && d.is_finite()) {
            return Err(Error::OutOfRange {
                what: "screen distance d",
                value: d,
                expected: "more than 0",
            });
        }
        let (n, c) = (self.normal, self.origin.coords);
        let k = n.dot(&self.point.coords);
        let limit = 1e-13 * n.norm() * self.point.coords.norm();
        if !(k.abs() > limit) {
            let measure = k.abs() / n.norm();
            return Err(Error::Degenerate { what: "plane through the eye", measure, limit });
        }
        // The denominator is d k / z: signed by k it is positive before the eye.
        let sign = k.signum();
        let numerator = |axis: Vector3<f64>| {
            let t = (axis * k - n * axis.dot(&c)) * sign;
            [d * t.z, t.x, t.y]
        };
        let r = [d * n.z * sign, n.x * sign, n.y * sign];
        FractionalLinear::from_coefficients(numerator(self.u_axis), numerator(self.v_axis), r, r)
    }

    /// The depth z of the plane at a centred screen point; negative behind the eye.
    #[must_use]
    pub fn depth(&self, screen: &Point2<f64>, d: f64) -> f64 {
        let k = self.normal.dot(&self.point.coords);
        d * k / self.normal.dot(&Vector3::new(screen.x, screen.y, d))
    }
}
