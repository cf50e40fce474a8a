//! Planes in space.

use nalgebra::{Matrix3, Point3, Rotation3, UnitVector3, Vector3};

use super::ray::Ray;
use super::surface::Surface;
use crate::error::{Error, ProjectionError};
use crate::numeric::float;
use crate::numeric::triangular::Triangular;

/// A plane: a point on it and its unit normal.
///
/// ```text
/// n · (X − P) = 0        or, with d = −n · P,        n · X + d = 0
/// ```
///
/// The point is kept beside the normal because n · X + d cancels in map coordinates of 10⁶ m, where n · (X − P) does
/// not. The normal points to the plane's front, the side from which a polygon's vertices turn counter-clockwise.
///
/// ```
/// use collinear::geometry::Plane;
/// use nalgebra::Point3;
///
/// // x/2 + y/3 + z/6 = 1 meets the axes at 2, 3 and 6; the origin lies 6/√14 behind it.
/// let plane = Plane::through(
///     &Point3::new(2.0, 0.0, 0.0),
///     &Point3::new(0.0, 3.0, 0.0),
///     &Point3::new(0.0, 0.0, 6.0),
/// )?;
/// assert!((plane.signed_distance(&Point3::origin()) + 6.0 / 14f64.sqrt()).abs() < 1e-15);
/// # Ok::<(), collinear::Error>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plane {
    point: Point3<f64>,
    normal: UnitVector3<f64>,
}

/// The sine of the angle below which three points count as lying on one line.
const COLLINEAR: f64 = 1e-14;

impl Plane {
    /// The plane through `point` with the given normal of any non-zero length.
    ///
    /// # Errors
    /// [`Error::NotFinite`] and, for a normal of length zero, [`Error::Degenerate`].
    pub fn from_point_and_normal(point: Point3<f64>, normal: Vector3<f64>) -> Result<Self, Error> {
        let ray = Ray::new(point, normal)?;
        Ok(Self { point: ray.origin, normal: ray.direction })
    }

    /// The plane a x + b y + c z + d = 0, its point the one nearest to the origin.
    ///
    /// # Errors
    /// [`Error::NotFinite`] and, where a, b and c vanish, [`Error::Degenerate`].
    pub fn from_coefficients([a, b, c, d]: [f64; 4]) -> Result<Self, Error> {
        let normal = Vector3::new(a, b, c);
        if !d.is_finite() {
            return Err(Error::NotFinite { what: "plane offset" });
        }
        let mut plane = Self::from_point_and_normal(Point3::origin(), normal)?;
        // Scaled first: the square of a tiny or huge coefficient must not vanish or overflow.
        let largest = normal.amax();
        let distance = -(d / largest) / (normal / largest).norm();
        if !distance.is_finite() {
            return Err(Error::NotFinite { what: "distance of the plane from the origin" });
        }
        plane.point = Point3::from(plane.normal.into_inner() * distance);
        Ok(plane)
    }

    /// The plane through three points; its normal is (b − a) × (c − a), towards the side from which a, b, c turn
    /// counter-clockwise.
    ///
    /// # Errors
    /// [`Error::NotFinite`], and [`Error::Degenerate`] where the points lie on one line; the measure is the sine of
    /// the angle at a.
    pub fn through(a: &Point3<f64>, b: &Point3<f64>, c: &Point3<f64>) -> Result<Self, Error> {
        let (u, v) = (b - a, c - a);
        if !u.iter().chain(v.iter()).all(|c| c.is_finite()) {
            return Err(Error::NotFinite { what: "plane point" });
        }
        let unit = |v: Vector3<f64>| (v / v.amax()).normalize();
        let normal = unit(u).cross(&unit(v));
        let sine = normal.norm();
        if !(sine > COLLINEAR) {
            let measure = if sine.is_finite() { sine } else { 0.0 };
            return Err(Error::Degenerate {
                what: "plane through three points",
                measure,
                limit: COLLINEAR,
            });
        }
        Self::from_point_and_normal(*a, normal)
    }

    /// The plane with the least sum of squared distances to n points: through their centroid, normal to the direction
    /// of least scatter. The normal points to the side from which the points, in their order, turn counter-clockwise;
    /// where they do not go around, its largest component is positive.
    ///
    /// # Errors
    /// [`Error::TooFewPoints`] for fewer than three, [`Error::NotFinite`], and [`Error::Degenerate`] where the points
    /// lie on one line (the measure is the ratio of the second to the first extent).
    ///
    /// ```
    /// use collinear::geometry::Plane;
    /// use nalgebra::Point3;
    ///
    /// // Four corners of a square, two raised and two lowered by 0.1: the plane lies between them.
    /// let corners = [(0.0, 0.0, 0.1), (1.0, 0.0, -0.1), (1.0, 1.0, 0.1), (0.0, 1.0, -0.1)];
    /// let points = corners.map(|(x, y, z)| Point3::new(x, y, z));
    /// let fit = Plane::fit(&points)?;
    /// assert!((fit.rms - 0.1).abs() < 1e-15);
    /// # Ok::<(), collinear::Error>(())
    /// ```
    pub fn fit(points: &[Point3<f64>]) -> Result<PlaneFit, Error> {
        let n = points.len();
        if n < 3 {
            return Err(Error::TooFewPoints { needed: 3, got: n });
        }
        let first = points[0];
        let mean = points.iter().fold(Vector3::zeros(), |s, p| s + (p - first)) / n as f64;
        let centroid = first + mean;
        // In units of the largest offset, so that no square vanishes or overflows.
        let size = points.iter().map(|p| (p - centroid).amax()).fold(0.0, f64::max);
        let mut rows = Triangular::<3>::new();
        for p in points {
            let d = p - centroid;
            if !d.iter().all(|c| c.is_finite()) {
                return Err(Error::NotFinite { what: "plane point" });
            }
            rows.add_row(if size > 0.0 { (d / size).into() } else { [0.0; 3] });
        }
        let (extents, axes) = rows.singular();
        let ratio = if extents[0] > 0.0 { extents[1] / extents[0] } else { 0.0 };
        if !(ratio > COLLINEAR) {
            return Err(Error::Degenerate { what: "plane fit", measure: ratio, limit: COLLINEAR });
        }
        let mut normal: Vector3<f64> = axes.column(2).into_owned();
        // The sign that the points' own order gives, where it goes around (Newell); else its largest component is positive.
        let turn = points
            .iter()
            .zip(points.iter().cycle().skip(1))
            .fold(Vector3::zeros(), |s: Vector3<f64>, (a, b)| {
                s + ((a - centroid) / size).cross(&((b - centroid) / size))
            });
        let turned = normal.dot(&turn);
        let goes_around = turned.abs() > 1e-12 * extents[0] * extents[1];
        if (if goes_around { turned } else { normal[normal.iamax()] }) < 0.0 {
            normal = -normal;
        }
        let plane = Self::from_point_and_normal(centroid, normal)?;
        let largest = points.iter().map(|p| plane.signed_distance(p).abs()).fold(0.0, f64::max);
        let sum: f64 = points.iter().map(|p| plane.signed_distance(p) / size).map(|d| d * d).sum();
        Ok(PlaneFit { plane, rms: size * float::sqrt(sum / n as f64), largest_residual: largest })
    }

    /// The point the plane is anchored at.
    #[must_use]
    pub fn point(&self) -> Point3<f64> {
        self.point
    }

    /// The unit normal.
    #[must_use]
    pub fn normal(&self) -> UnitVector3<f64> {
        self.normal
    }

    /// (a, b, c, d) of a x + b y + c z + d = 0, (a, b, c) of unit length.
    #[must_use]
    pub fn coefficients(&self) -> [f64; 4] {
        let n = self.normal;
        [n.x, n.y, n.z, -n.dot(&self.point.coords)]
    }

    /// The plane seen from its other side.
    #[must_use]
    pub fn flipped(&self) -> Self {
        Self { point: self.point, normal: -self.normal }
    }

    /// Distance from the plane, positive in front.
    #[must_use]
    pub fn signed_distance(&self, point: &Point3<f64>) -> f64 {
        self.normal.dot(&(point - self.point))
    }

    /// The point of the plane nearest to `point`.
    #[must_use]
    pub fn foot(&self, point: &Point3<f64>) -> Point3<f64> {
        point - self.normal.into_inner() * self.signed_distance(point)
    }
}

impl Surface for Plane {
    fn height_above(&self, world: &Point3<f64>) -> f64 {
        self.signed_distance(world)
    }

    /// λ = −n·(O − P) / n·d, met from either side; a ray that starts on the plane meets it there.
    fn meet_ray(&self, ray: &Ray) -> Result<Point3<f64>, ProjectionError> {
        let distance = self.signed_distance(&ray.origin);
        if distance == 0.0 {
            return Ok(ray.origin);
        }
        let t = -distance / self.normal.dot(&ray.direction);
        if t.is_nan() {
            return Err(ProjectionError::NotFinite);
        }
        let hit = ray.at(t);
        if t >= 0.0 && hit.coords.iter().all(|c| c.is_finite()) {
            Ok(hit)
        } else {
            Err(ProjectionError::MissesSurface)
        }
    }

    fn normal(&self, _: &Point3<f64>) -> Result<UnitVector3<f64>, ProjectionError> {
        Ok(self.normal)
    }
}

/// Right-handed axes of which the third is this one, as columns.
pub(crate) fn axes(third: &UnitVector3<f64>) -> Rotation3<f64> {
    let across = Vector3::ith(third.iamin(), 1.0);
    let first = third.cross(&across).normalize();
    let columns = [first, third.cross(&first), third.into_inner()];
    Rotation3::from_matrix_unchecked(Matrix3::from_columns(&columns))
}

/// A plane fitted to points, and how well they lie on it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlaneFit {
    /// The plane.
    pub plane: Plane,
    /// Root mean square distance of the points, in world units.
    pub rms: f64,
    /// The largest distance, in world units.
    pub largest_residual: f64,
}
