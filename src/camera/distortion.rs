//! Lens distortion: Brown's radial and decentering terms, forward and back.

use nalgebra::{Matrix2, Matrix2x3, Point2, Point3, Vector2, Vector3};

use super::interior::{INTERIOR, InteriorOrientation};
use super::{Adjustable, CentralModel, ParameterGroup, collinearity, no_group};
use crate::error::{Error, ProjectionError};
use crate::numeric::scalar::Scalar;
use crate::numeric::{float, polynomial};

/// Radial and decentering distortion of normalised image points (Brown 1971).
///
/// # Model
/// ```text
/// x″ = x (1 + k₁r² + k₂r⁴ + k₃r⁶) + 2 p₁ x y + p₂ (r² + 2x²)
/// y″ = y (1 + k₁r² + k₂r⁴ + k₃r⁶) + p₁ (r² + 2y²) + 2 p₂ x y        r² = x² + y²
/// ```
/// with the signs and the order of p₁, p₂ of OpenCV and COLMAP. (x, y) = (X/Z, Y/Z) in camera axes, y down.
///
/// # Domain
/// The Jacobian is symmetric, so the map is the gradient of a potential, which is convex as long as both eigenvalues
/// stay positive. The first one to vanish does so on the circle of the *fold radius*, the smallest positive root of
///
/// ```text
/// 1 − 6 √(p₁² + p₂²) r + 3 k₁ r² + 5 k₂ r⁴ + 7 k₃ r⁶ = 0
/// ```
///
/// Within it the map is one to one; beyond it the polynomial runs back and would place points from outside the field in
/// the middle of the picture. Such points are refused.
///
/// # Accuracy
/// The inverse is found by damped Newton steps on the convex potential, which always converge inside the fold; it ends
/// when the residual is at the rounding floor. Its error is the residual over the smallest eigenvalue of the Jacobian.
///
/// # Example
/// OpenCV 5.0.0, `projectPoints` of (0.31, −0.22, 1) with these coefficients:
///
/// ```
/// use collinear::camera::Brown;
/// use nalgebra::Point2;
///
/// let lens = Brown::new([-0.28, 0.07, 0.002], [1e-3, -5e-4])?;
/// let p = lens.distort(&Point2::new(0.31, -0.22))?;
/// assert!((p - Point2::new(0.2976076220865975, -0.21111218341629498)).norm() < 1e-15);
/// let back = lens.undistort(&p)?;
/// assert!((back.point - Point2::new(0.31, -0.22)).norm() < 1e-15 && back.iterations <= 5);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[doc(alias("Brown-Conrady", "radtan", "plumb bob", "OPENCV"))]
pub struct Brown {
    k: [f64; 3],
    p: [f64; 2],
    fold_radius: f64,
}

/// A point found by iteration, and how well.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Undistorted {
    /// The ideal point.
    pub point: Point2<f64>,
    /// Newton steps taken.
    pub iterations: u32,
    /// ‖distort(point) − given point‖, in normalised units.
    pub residual: f64,
}

const DISTORTION: ParameterGroup = ParameterGroup { name: "lens distortion", len: 5 };

/// The ends of the intervals in which the fold is looked for, one after the other: one polynomial search over all of them
/// would place a fold near 1 no better than 10⁻⁸.
const SEARCHED_TO: [f64; 5] = [0.0, 1e4, 1e8, 1e12, 1e16];
/// A start for the inverse may be thrown this many times farther than the point that is sought.
const MOST_SPREAD: f64 = 1e3;
/// Newton steps allowed: ten are rarely needed, bisection to the last bit would take 52.
const MAX_STEPS: u32 = 100;

/// The formula.
fn distort<S: Scalar>([x, y]: [S; 2], k: [S; 3], p: [S; 2]) -> [S; 2] {
    let r2 = x * x + y * y;
    let radial = S::constant(1.0) + ((k[2] * r2 + k[1]) * r2 + k[0]) * r2;
    let xy = (x * y).scale(2.0);
    [
        x * radial + p[0] * xy + p[1] * (r2 + (x * x).scale(2.0)),
        y * radial + p[0] * (r2 + (y * y).scale(2.0)) + p[1] * xy,
    ]
}

/// The first positive root of the smallest eigenvalue; infinite where there is none.
fn first_root(slope: &[f64; 7]) -> f64 {
    let mut roots = [0.0; 6];
    for range in SEARCHED_TO.windows(2) {
        if polynomial::roots_in(slope, range[0], range[1], &mut roots) > 0 {
            return roots[0];
        }
    }
    // Past the last interval the highest power alone decides; what it bends back is cut off there.
    let [.., last] = SEARCHED_TO;
    let bends_back = slope.iter().rev().find(|c| **c != 0.0).is_some_and(|c| *c < 0.0);
    if bends_back { last } else { f64::INFINITY }
}

impl Brown {
    /// From k₁, k₂, k₃ and p₁, p₂.
    ///
    /// # Errors
    /// [`Error::NotFinite`]; [`Error::OutOfRange`] for coefficients so large that nothing is left inside the fold.
    pub fn new(k: [f64; 3], p: [f64; 2]) -> Result<Self, Error> {
        if !k.iter().chain(&p).all(|c| c.is_finite()) {
            return Err(Error::NotFinite { what: "distortion coefficient" });
        }
        let slope =
            [1.0, -6.0 * float::hypot(p[0], p[1]), 3.0 * k[0], 0.0, 5.0 * k[1], 0.0, 7.0 * k[2]];
        let fold_radius = first_root(&slope);
        if !(slope.iter().all(|c| c.is_finite()) && fold_radius > 0.0) {
            return Err(Error::OutOfRange {
                what: "distortion fold radius",
                value: fold_radius,
                expected: "more than 0: smaller coefficients",
            });
        }
        Ok(Self { k, p, fold_radius })
    }

    /// No distortion.
    #[must_use]
    pub fn none() -> Self {
        Self { k: [0.0; 3], p: [0.0; 2], fold_radius: f64::INFINITY }
    }

    /// (k₁, k₂, k₃).
    #[must_use]
    pub fn radial(&self) -> [f64; 3] {
        self.k
    }

    /// (p₁, p₂).
    #[must_use]
    pub fn decentering(&self) -> [f64; 2] {
        self.p
    }

    /// The radius of ideal points where the distortion folds back, infinite where it does not; at most 10¹⁶ where it does.
    #[must_use]
    pub fn fold_radius(&self) -> f64 {
        self.fold_radius
    }

    /// Distorted point of an ideal point, both normalised.
    ///
    /// # Errors
    /// [`ProjectionError::OutsideDomain`] at and beyond the fold radius, [`ProjectionError::NotFinite`].
    #[inline]
    pub fn distort(&self, ideal: &Point2<f64>) -> Result<Point2<f64>, ProjectionError> {
        self.check(ideal)?;
        collinearity::finite(self.formula(ideal))
    }

    /// Distorted point with ∂(x″, y″)/∂(x, y).
    ///
    /// # Errors
    /// As [`distort`](Self::distort).
    #[inline]
    pub fn distort_jacobian(
        &self,
        ideal: &Point2<f64>,
    ) -> Result<(Point2<f64>, Matrix2<f64>), ProjectionError> {
        Ok((self.distort(ideal)?, self.jacobian(ideal)))
    }

    /// Ideal point of a distorted point, both normalised, with the report of its iteration.
    ///
    /// # Errors
    /// [`ProjectionError::OutsideDomain`] where no ideal point within the fold radius has this image,
    /// [`ProjectionError::NotConverged`] where the residual did not reach its floor,
    /// [`ProjectionError::NotFinite`].
    #[doc(alias = "undistortPoints")]
    pub fn undistort(&self, distorted: &Point2<f64>) -> Result<Undistorted, ProjectionError> {
        collinearity::finite(*distorted)?;
        let target = distorted.coords;
        let radius = float::hypot(target.x, target.y);
        if radius.is_infinite() {
            return Err(ProjectionError::NotFinite);
        }
        // The rounding floor of the residual: the polynomial's terms are summed with a few roundings.
        let floor = 4.0 * f64::EPSILON * radius;
        let mut point = *distorted;
        if radius >= self.fold_radius {
            let limit = self.reach(self.fold_radius);
            if radius > limit {
                return Err(ProjectionError::OutsideDomain { value: radius, limit });
            }
            point.coords *= 0.5 * self.fold_radius / radius;
        }
        // A lens that spreads the picture throws a far start much farther, or out of the numbers.
        let mut length = float::hypot(point.x, point.y);
        while length > 1.0 && !(self.reach(length) <= MOST_SPREAD * radius) {
            point.coords *= 0.5;
            length *= 0.5;
        }
        let mut miss = self.formula(&point).coords - target;
        let mut residual = float::hypot(miss.x, miss.y);
        for iterations in 0..MAX_STEPS {
            if residual <= floor {
                return Ok(Undistorted { point, iterations, residual });
            }
            let Some(inverse) = self.jacobian(&point).try_inverse() else { break };
            let step = inverse * miss;
            // Halve the step until it stays inside the fold and comes nearer.
            let mut fraction = 1.0;
            let (next, next_miss, next_residual) = loop {
                let candidate = point - step * fraction;
                if float::hypot(candidate.x, candidate.y) < self.fold_radius {
                    let miss = self.formula(&candidate).coords - target;
                    let r = float::hypot(miss.x, miss.y);
                    if r < residual {
                        break (candidate, miss, r);
                    }
                }
                fraction *= 0.5;
                if fraction < 1e-12 {
                    // No nearer point: at the floor this is the answer, elsewhere the fold is in the way.
                    return if residual <= 4.0 * floor {
                        Ok(Undistorted { point, iterations, residual })
                    } else {
                        Err(self.no_preimage(&point, radius, iterations, residual))
                    };
                }
            };
            (point, miss, residual) = (next, next_miss, next_residual);
        }
        if residual <= 4.0 * floor {
            return Ok(Undistorted { point, iterations: MAX_STEPS, residual });
        }
        Err(self.no_preimage(&point, radius, MAX_STEPS, residual))
    }

    /// No point within a radius is thrown farther than this.
    fn reach(&self, radius: f64) -> f64 {
        let ([k1, k2, k3], [p1, p2]) = (self.k, self.p);
        let r2 = radius * radius;
        let radial = 1.0 + ((k3.abs() * r2 + k2.abs()) * r2 + k1.abs()) * r2;
        radius * radial + 3.0 * float::hypot(p1, p2) * r2
    }

    /// Why the search stopped: pressed against the fold, or out of steps.
    fn no_preimage(
        &self,
        stopped: &Point2<f64>,
        radius: f64,
        iterations: u32,
        residual: f64,
    ) -> ProjectionError {
        let length = float::hypot(stopped.x, stopped.y);
        if length > 0.99 * self.fold_radius {
            let rim = self.formula(&Point2::from(stopped.coords * (self.fold_radius / length)));
            let limit = float::hypot(rim.x, rim.y);
            ProjectionError::OutsideDomain { value: radius, limit }
        } else {
            ProjectionError::NotConverged { iterations, residual }
        }
    }

    #[inline]
    fn check(&self, ideal: &Point2<f64>) -> Result<(), ProjectionError> {
        let radius_squared = ideal.coords.norm_squared();
        if radius_squared < self.fold_radius * self.fold_radius {
            return Ok(());
        }
        let value = ideal.coords.norm();
        Err(if value.is_nan() {
            ProjectionError::NotFinite
        } else {
            ProjectionError::OutsideDomain { value, limit: self.fold_radius }
        })
    }

    #[inline]
    fn formula(&self, p: &Point2<f64>) -> Point2<f64> {
        Point2::from(distort([p.x, p.y], self.k, self.p))
    }

    /// ∂(x″, y″)/∂(x, y), symmetric.
    #[inline]
    fn jacobian(&self, point: &Point2<f64>) -> Matrix2<f64> {
        let (x, y) = (point.x, point.y);
        let ([k1, k2, k3], [p1, p2]) = (self.k, self.p);
        let r2 = x * x + y * y;
        let radial = 1.0 + ((k3 * r2 + k2) * r2 + k1) * r2;
        // d(radial)/d(r²), doubled: ∂radial/∂x = slope · x.
        let slope = 2.0 * ((3.0 * k3 * r2 + 2.0 * k2) * r2 + k1);
        let off = slope * x * y + 2.0 * (p1 * x + p2 * y);
        Matrix2::new(
            radial + slope * x * x + 2.0 * p1 * y + 6.0 * p2 * x,
            off,
            off,
            radial + slope * y * y + 6.0 * p1 * y + 2.0 * p2 * x,
        )
    }

    /// Columns ∂(x″, y″)/∂(k₁, k₂, k₃, p₁, p₂).
    fn coefficient_columns(point: &Point2<f64>) -> [Vector2<f64>; 5] {
        let (x, y) = (point.x, point.y);
        let r2 = x * x + y * y;
        [
            Vector2::new(x, y) * r2,
            Vector2::new(x, y) * (r2 * r2),
            Vector2::new(x, y) * (r2 * r2 * r2),
            Vector2::new(2.0 * x * y, r2 + 2.0 * y * y),
            Vector2::new(r2 + 2.0 * x * x, 2.0 * x * y),
        ]
    }
}

/// A camera with Brown's lens distortion before an interior orientation.
///
/// ```text
/// (x, y) = (X/Z, Y/Z)   →   (x″, y″) = distort(x, y)   →   pixel = interior(x″, y″)
/// ```
///
/// Parameters: group 0 is (fx, fy, x₀, y₀, s) in pixels, group 1 (k₁, k₂, k₃, p₁, p₂).
///
/// # Example
/// OpenCV 5.0.0, `projectPoints` with fx = fy = 1000, cx = 319.5, cy = 239.5, whose pixel centres are integers:
///
/// ```
/// use collinear::camera::{Brown, BrownCamera, CentralModel, InteriorOrientation};
/// use nalgebra::{Point2, Vector2, Vector3};
///
/// let interior = InteriorOrientation::from_opencv(1000.0, 1000.0, 319.5, 239.5)?;
/// let camera = BrownCamera::new(interior, Brown::new([-0.28, 0.07, 0.002], [1e-3, -5e-4])?);
/// let p = camera.project_direction(&Vector3::new(0.31, -0.22, 1.0))?;
/// let opencv = Point2::new(617.1076220865975, 28.38781658370502);
/// assert!((p - Vector2::new(0.5, 0.5) - opencv).norm() < 1e-12);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[doc(alias("OPENCV", "FULL_OPENCV", "RADIAL", "SIMPLE_RADIAL"))]
pub struct BrownCamera {
    interior: InteriorOrientation,
    distortion: Brown,
}

impl BrownCamera {
    /// A lens before an interior orientation.
    #[must_use]
    pub fn new(interior: InteriorOrientation, distortion: Brown) -> Self {
        Self { interior, distortion }
    }

    /// The interior orientation.
    #[must_use]
    pub fn interior(&self) -> &InteriorOrientation {
        &self.interior
    }

    /// The lens.
    #[must_use]
    pub fn distortion(&self) -> &Brown {
        &self.distortion
    }
}

impl CentralModel for BrownCamera {
    fn project_direction(&self, direction: &Vector3<f64>) -> Result<Point2<f64>, ProjectionError> {
        let ideal = collinearity::normalised_point(direction)?;
        let distorted = self.distortion.distort(&ideal)?;
        collinearity::finite(self.interior.pixel_from_normalised(&distorted))
    }

    fn project_direction_jacobian(
        &self,
        direction: &Vector3<f64>,
    ) -> Result<(Point2<f64>, Matrix2x3<f64>), ProjectionError> {
        let ideal = collinearity::normalised_point(direction)?;
        let (distorted, by_ideal) = self.distortion.distort_jacobian(&ideal)?;
        let image = collinearity::finite(self.interior.pixel_from_normalised(&distorted))?;
        let by_direction = collinearity::normalised_jacobian(&ideal, direction.z);
        Ok((image, self.interior.axes() * by_ideal * by_direction))
    }

    fn direction(&self, image: &Point2<f64>) -> Result<Vector3<f64>, ProjectionError> {
        let distorted = self.interior.normalised_from_pixel(image);
        let ideal = self.distortion.undistort(&distorted)?.point;
        Ok(collinearity::unit_direction(&ideal))
    }
}

impl Adjustable for BrownCamera {
    fn parameter_group(&self, group: usize) -> Option<ParameterGroup> {
        [INTERIOR, DISTORTION].get(group).copied()
    }

    fn parameters(&self, group: usize, values: &mut [f64]) {
        let ([k1, k2, k3], [p1, p2]) = (self.distortion.k, self.distortion.p);
        let own = match group {
            0 => self.interior.values(),
            1 => [k1, k2, k3, p1, p2],
            _ => return,
        };
        for (v, p) in values.iter_mut().zip(own) {
            *v = p;
        }
    }

    fn adjust(&mut self, group: usize, step: &[f64]) -> Result<(), Error> {
        if group == 0 {
            self.interior = self.interior.moved(step)?;
            return Ok(());
        }
        if group > 1 {
            return Err(no_group(group));
        }
        let &[k1, k2, k3, p1, p2] = step else {
            return Err(Error::LengthMismatch {
                what: "parameter group and step",
                left: DISTORTION.len,
                right: step.len(),
            });
        };
        let ([a, b, c], [d, e]) = (self.distortion.k, self.distortion.p);
        self.distortion = Brown::new([a + k1, b + k2, c + k3], [d + p1, e + p2])?;
        Ok(())
    }

    fn partials(
        &self,
        object: &Point3<f64>,
        by_object: &mut [f64; 6],
        by_group: &mut [&mut [f64]],
    ) -> Result<Point2<f64>, ProjectionError> {
        let ideal = collinearity::normalised_point(&object.coords)?;
        let (distorted, by_ideal) = self.distortion.distort_jacobian(&ideal)?;
        let image = collinearity::finite(self.interior.pixel_from_normalised(&distorted))?;
        let axes = self.interior.axes();
        let by_direction = collinearity::normalised_jacobian(&ideal, object.z);
        collinearity::write_rows(&(axes * by_ideal * by_direction), by_object);
        if let Some(out) = by_group.first_mut() {
            InteriorOrientation::write_partials(&distorted, out);
        }
        if let Some(out) = by_group.get_mut(1)
            && out.len() == 2 * DISTORTION.len
        {
            for (i, column) in Brown::coefficient_columns(&ideal).into_iter().enumerate() {
                let column = axes * column;
                out[i] = column.x;
                out[DISTORTION.len + i] = column.y;
            }
        }
        Ok(image)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::scalar::Dual;

    #[test]
    fn jacobians_agree_with_dual_numbers() {
        let (k, p) = ([-0.28, 0.07, 0.013], [1.1e-3, -6e-4]);
        let lens = Brown::new(k, p).unwrap();
        for point in [[0.31, -0.22], [-0.4, -0.1], [0.05, 0.5], [0.0, 0.0]] {
            let d = distort(
                core::array::from_fn(|i| Dual::<7>::variable(point[i], i)),
                core::array::from_fn(|i| Dual::<7>::variable(k[i], 2 + i)),
                core::array::from_fn(|i| Dual::<7>::variable(p[i], 5 + i)),
            );
            let point = Point2::from(point);
            let (jacobian, columns) = (lens.jacobian(&point), Brown::coefficient_columns(&point));
            for row in 0..2 {
                for i in 0..2 {
                    assert!((d[row].gradient[i] - jacobian[(row, i)]).abs() < 1e-15);
                }
                for (i, column) in columns.iter().enumerate() {
                    assert!((d[row].gradient[2 + i] - column[row]).abs() < 1e-15);
                }
            }
        }
    }
}
