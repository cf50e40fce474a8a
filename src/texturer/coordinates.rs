//! Texture coordinates at vertices.

use alloc::vec::Vec;

use nalgebra::{Matrix3, Matrix3x4, Point2, Point3, Vector3};

use crate::camera::HomogeneousCamera;
use crate::error::{Error, ProjectionError};
use crate::geometry::homography::FitOptions;
use crate::geometry::{Affine2, Homography, Plane, axes};
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
    let texture = PlaneTexture::from_vertices(world, coordinates)?;
    FractionalLinear::from_plane_texture(&texture.plane, &texture.about(&screen.origin()), screen)
}

/// A texture laid on a plane or projected onto it: its coordinates at any point of the plane.
///
/// ```text
/// (w u, w v, w) = T (a, b, 1),   (a, b) the point in the plane's own axes
/// ```
///
/// # Example
/// A wall of 4 × 2, with 100 texels a unit and v downwards:
///
/// ```
/// use collinear::texturer::PlaneTexture;
/// use nalgebra::{Point2, Point3, Vector3};
///
/// let wall = [(0.0, 0.0), (4.0, 0.0), (4.0, 2.0), (0.0, 2.0)].map(|(x, z)| Point3::new(x, 7.0, z));
/// let corners = [(0.0, 200.0), (400.0, 200.0), (400.0, 0.0), (0.0, 0.0)];
/// let texture = PlaneTexture::from_vertices(&wall, &corners.map(|(u, v)| Vector3::new(u, v, 1.0)))?;
/// assert!((texture.at(&Point3::new(1.0, 7.0, 1.5))? - Point2::new(100.0, 50.0)).norm() < 1e-12);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlaneTexture {
    plane: Plane,
    origin: Point3<f64>,
    /// (w u, w v, w) from (X − origin, 1).
    matrix: Matrix3x4<f64>,
}

impl PlaneTexture {
    /// The texture of a planar polygon whose vertices carry coordinates (u, v, w), as [`from_vertices`] takes them.
    ///
    /// # Errors
    /// As [`from_vertices`].
    pub fn from_vertices(
        world: &[Point3<f64>],
        coordinates: &[Vector3<f64>],
    ) -> Result<Self, Error> {
        if world.len() != coordinates.len() {
            return Err(Error::LengthMismatch {
                what: "vertices and texture coordinates",
                left: world.len(),
                right: coordinates.len(),
            });
        }
        if let Some(c) = coordinates.iter().find(|c| !(c.z > 0.0)) {
            let (what, expected) = ("texture w", "more than 0");
            return Err(Error::OutOfRange { what, value: c.z, expected });
        }
        let plane = Plane::fit(world)?.plane;
        let frame = PlaneAxes::new(&plane, world);
        let in_plane: Vec<Point2<f64>> = world.iter().map(|p| frame.coordinates(p)).collect();
        let texture_from_plane = texture_from_plane(&in_plane, coordinates)?;
        let matrix = texture_from_plane * frame.plane_from_offset();
        Ok(Self { plane, origin: frame.origin, matrix })
    }

    /// The texture's coordinates at a point of the plane.
    ///
    /// # Errors
    /// [`ProjectionError::BehindCamera`] where w is not positive, [`ProjectionError::NotFinite`].
    pub fn at(&self, world: &Point3<f64>) -> Result<Point2<f64>, ProjectionError> {
        let h = self.matrix * (world - self.origin).push(1.0);
        let point = Point2::new(h.x / h.z, h.y / h.z);
        if h.z <= 0.0 {
            Err(ProjectionError::BehindCamera { depth: h.z })
        } else if point.iter().all(|c| c.is_finite()) {
            Ok(point)
        } else {
            Err(ProjectionError::NotFinite)
        }
    }

    /// (w u, w v, w) from (X − O, 1), O another origin.
    fn about(&self, origin: &Point3<f64>) -> Matrix3x4<f64> {
        let mut moved = self.matrix;
        moved.set_column(3, &(self.matrix * (origin - self.origin).push(1.0)));
        moved
    }
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
        let axes = axes(&plane.normal());
        let [x, y] = [0, 1].map(|i| axes.matrix().column(i) / size);
        Self { origin, x, y }
    }

    fn coordinates(&self, p: &Point3<f64>) -> Point2<f64> {
        let d = p - self.origin;
        Point2::new(self.x.dot(&d), self.y.dot(&d))
    }

    /// (a, b, 1) from (X − origin, 1).
    fn plane_from_offset(&self) -> Matrix3x4<f64> {
        let mut matrix = Matrix3x4::zeros();
        matrix.fixed_view_mut::<1, 3>(0, 0).copy_from(&self.x.transpose());
        matrix.fixed_view_mut::<1, 3>(1, 0).copy_from(&self.y.transpose());
        matrix[(2, 3)] = 1.0;
        matrix
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
