//! Texture coordinates at vertices.

use alloc::vec::Vec;

use nalgebra::{Matrix3, Matrix3x4, Point2, Point3, Vector3};

use crate::camera::HomogeneousCamera;
use crate::error::Error;
use crate::geometry::homography::FitOptions;
use crate::geometry::{Affine2, Homography, Plane};
use crate::mapping::FractionalLinear;

/// Vertices may disagree with one map of their plane by this much, in texels.
const TOLERANCE: f64 = 0.1;

/// The map of a planar polygon whose vertices carry texture coordinates (u, v, w).
///
/// With w = 1 everywhere the coordinates are laid on: three vertices, or more that agree, give an affine map of the plane,
/// which \[WD\] eq. 3 takes to the screen. Four vertices that no affine map serves, as a quadrilateral of the texture on a
/// rectangle, get the projective map of their plane (\[WD\] eq. 2); more than four the least-squares one. With other w,
/// (w u, w v, w) is affine in the plane, as for a projected texture (\[S\] eq. 5).
///
/// All vertices have a say, so cutting the polygon changes the map by rounding only.
///
/// # Errors
/// [`Error::LengthMismatch`], [`Error::TooFewPoints`], [`Error::Degenerate`] for vertices on one line or a plane through
/// the eye, [`Error::OutOfRange`] for a w that is not positive, and [`Error::Inconsistent`] where no projective map of the
/// plane gives the coordinates to within a tenth of a texel.
///
/// # Example
/// A floor one below the eye, from depth 1 (v = 0) to depth 3 (v = 32), c = 100 px. Line 50 shows it at depth 100/50 = 2,
/// half way: v = 16.
///
/// ```
/// use collinear::camera::{ExteriorOrientation, Frame, InteriorOrientation};
/// use nalgebra::{Point2, Point3, Rotation3, Vector3};
///
/// let eye = ExteriorOrientation::new(Point3::origin(), Rotation3::identity());
/// let interior = InteriorOrientation::new([100.0; 2], Point2::origin(), 0.0)?;
/// let screen = Frame::new(eye, interior).homogeneous();
/// let floor = [(-1.0, 1.0), (1.0, 1.0), (1.0, 3.0), (-1.0, 3.0)].map(|(x, z)| Point3::new(x, 1.0, z));
/// let corners = [(0.0, 0.0), (64.0, 0.0), (64.0, 32.0), (0.0, 32.0)];
/// let coordinates = corners.map(|(u, v)| Vector3::new(u, v, 1.0));
/// let map = collinear::texturer::from_vertices(&floor, &coordinates, &screen)?;
/// let texture = collinear::mapping::Map::at(&map, &Point2::new(0.0, 50.0))?;
/// assert!((texture - Point2::new(32.0, 16.0)).norm() < 1e-12);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn from_vertices(
    world: &[Point3<f64>],
    coordinates: &[Vector3<f64>],
    screen: &HomogeneousCamera,
) -> Result<FractionalLinear, Error> {
    if world.len() != coordinates.len() {
        return Err(Error::LengthMismatch {
            what: "vertices and texture coordinates",
            left: world.len(),
            right: coordinates.len(),
        });
    }
    if let Some(c) = coordinates.iter().find(|c| !(c.z > 0.0)) {
        return Err(Error::OutOfRange { what: "texture w", value: c.z, expected: "more than 0" });
    }
    let plane = Plane::fit(world)?.plane;
    let frame = PlaneAxes::new(&plane, world);
    let in_plane: Vec<Point2<f64>> = world.iter().map(|p| frame.coordinates(p)).collect();
    let texture_from_plane = texture_from_plane(&in_plane, coordinates)?;
    FractionalLinear::from_plane_texture(
        &plane,
        &(texture_from_plane * frame.plane_from_world(screen)),
        screen,
    )
}

/// Axes in a plane, scaled to the polygon.
struct PlaneAxes {
    origin: Point3<f64>,
    x: Vector3<f64>,
    y: Vector3<f64>,
}

impl PlaneAxes {
    fn new(plane: &Plane, world: &[Point3<f64>]) -> Self {
        let origin = plane.point();
        let size = world.iter().map(|p| (p - origin).norm()).fold(0.0, f64::max);
        let n = plane.normal().into_inner();
        // Any vector well off the normal will do for the first axis.
        let helper = if n.x.abs() < 0.6 { Vector3::x() } else { Vector3::y() };
        let x = n.cross(&helper).normalize();
        Self { origin, x: x / size, y: n.cross(&x) / size }
    }

    fn coordinates(&self, p: &Point3<f64>) -> Point2<f64> {
        let d = p - self.origin;
        Point2::new(self.x.dot(&d), self.y.dot(&d))
    }

    /// (a, b, 1) from (X − O, 1), O the screen's origin.
    fn plane_from_world(&self, screen: &HomogeneousCamera) -> Matrix3x4<f64> {
        let shift = screen.origin() - self.origin;
        let (x, y) = (self.x, self.y);
        Matrix3x4::new(
            x.x,
            x.y,
            x.z,
            x.dot(&shift), //
            y.x,
            y.y,
            y.z,
            y.dot(&shift), //
            0.0,
            0.0,
            0.0,
            1.0,
        )
    }
}

/// (w u, w v, w) from (a, b, 1).
fn texture_from_plane(
    in_plane: &[Point2<f64>],
    coordinates: &[Vector3<f64>],
) -> Result<Matrix3<f64>, Error> {
    let uv: Vec<Point2<f64>> = coordinates.iter().map(|c| Point2::new(c.x, c.y)).collect();
    let scaled: Vec<Point2<f64>> =
        coordinates.iter().map(|c| Point2::new(c.x * c.z, c.y * c.z)).collect();
    let weights: Vec<Point2<f64>> = coordinates.iter().map(|c| Point2::new(c.z, 0.0)).collect();
    let numerators = Affine2::fit(in_plane, &scaled)?.map;
    let denominator = Affine2::fit(in_plane, &weights)?.map;
    let mut matrix = numerators.to_matrix();
    matrix[(2, 0)] = denominator.linear.m11;
    matrix[(2, 1)] = denominator.linear.m12;
    matrix[(2, 2)] = denominator.translation.x;
    let worst = |m: &Matrix3<f64>| {
        in_plane
            .iter()
            .zip(&uv)
            .map(|(p, t)| {
                let h = m * Vector3::new(p.x, p.y, 1.0);
                (Point2::new(h.x / h.z, h.y / h.z) - t).norm()
            })
            .fold(0.0, f64::max)
    };
    if worst(&matrix) <= TOLERANCE {
        return Ok(matrix);
    }
    let projective = match (in_plane, &uv[..]) {
        (&[a, b, c, d], &[p, q, r, s]) => Homography::from_quads(&[a, b, c, d], &[p, q, r, s])?,
        _ => Homography::fit(in_plane, &uv, &FitOptions::default())?.homography,
    };
    let residual = worst(projective.matrix());
    if residual <= TOLERANCE {
        Ok(*projective.matrix())
    } else {
        Err(Error::Inconsistent { what: "texture coordinates", residual, limit: TOLERANCE })
    }
}
