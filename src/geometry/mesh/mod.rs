//! Triangle meshes as surfaces: what a ray meets first, and the nearest point.
//!
//! The triangles stand in a tree of boxes, so that a ray looks at a few of them only. A ray between two triangles that share an edge
//! meets one of them: there are no cracks.

mod tree;
mod triangle;

use alloc::vec::Vec;

use nalgebra::{Point3, UnitVector3, Vector3};

use self::tree::Tree;
use self::triangle::Sheared;
use super::ray::Ray;
use super::surface::{Surface, unit_normal};
use crate::error::{Error, ProjectionError};

/// Triangles over shared vertices.
///
/// # Method
/// Rays: the watertight test of Woop, Benthin & Wald 2013 ("Watertight ray/triangle intersection", JCGT 2) in `f64`, in a tree of
/// boxes cut at the median of the longest side. Nearest points: Ericson 2005, *Real-Time Collision Detection*, 5.1.5, in the same tree.
///
/// # As a surface
/// [`height_above`](Surface::height_above) is the distance to the nearest triangle, positive on the side from which its vertices turn
/// counter-clockwise; [`meet_ray`](Surface::meet_ray) meets triangles from either side. A triangle without area is never met.
///
/// # Example
/// A tetrahedron's slope x + y + z = 1, seen from (2, 2, 2): at (⅓, ⅓, ⅓).
///
/// ```
/// use collinear::geometry::{Ray, Surface, TriangleMesh};
/// use nalgebra::{Point3, Vector3};
///
/// let vertices = vec![Point3::origin(), Point3::new(1.0, 0.0, 0.0), Point3::new(0.0, 1.0, 0.0), Point3::new(0.0, 0.0, 1.0)];
/// let mesh = TriangleMesh::new(vertices, vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])?;
/// let ray = Ray::new(Point3::new(2.0, 2.0, 2.0), Vector3::new(-1.0, -1.0, -1.0))?;
/// let hit = mesh.first_hit(&ray).ok_or("nothing is met")?;
/// assert_eq!(hit.triangle, 3);
/// assert!((hit.distance - 5.0 / 3f64.sqrt()).abs() < 1e-15);
/// assert!((mesh.meet_ray(&ray)? - Point3::new(1.0, 1.0, 1.0) / 3.0.into()).norm() < 1e-15);
/// // Half a unit above the slope.
/// let above = Point3::new(1.0, 1.0, 1.0) / 3.0 + Vector3::new(1.0, 1.0, 1.0) / 12f64.sqrt();
/// assert!((mesh.height_above(&above) - 0.5).abs() < 1e-15);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
#[doc(alias("BVH", "Mesh3d", "TIN"))]
pub struct TriangleMesh {
    vertices: Vec<Point3<f64>>,
    triangles: Vec<[u32; 3]>,
    tree: Tree,
}

/// Where a ray meets a mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MeshHit {
    /// The number of the triangle.
    pub triangle: usize,
    /// How far along the ray, world units.
    pub distance: f64,
}

impl TriangleMesh {
    /// From vertices and, for each triangle, three numbers of vertices.
    ///
    /// # Errors
    /// [`Error::TooFewPoints`] without a triangle, [`Error::NotFinite`] for a vertex, [`Error::OutOfRange`] for the number of a
    /// vertex that is not there and for more than 2³¹ triangles.
    pub fn new(vertices: Vec<Point3<f64>>, triangles: Vec<[u32; 3]>) -> Result<Self, Error> {
        if triangles.is_empty() {
            return Err(Error::TooFewPoints { needed: 3, got: 0 });
        }
        let count = triangles.len();
        if count > 1 << 31 {
            let (what, expected) = ("number of triangles", "at most 2³¹");
            return Err(Error::OutOfRange { what, value: count as f64, expected });
        }
        if !vertices.iter().all(|v| v.iter().all(|c| c.is_finite())) {
            return Err(Error::NotFinite { what: "mesh vertex" });
        }
        if let Some(&far) = triangles.iter().flatten().find(|i| **i as usize >= vertices.len()) {
            let (what, expected) = ("number of a mesh vertex", "one of the vertices");
            return Err(Error::OutOfRange { what, value: far.into(), expected });
        }
        let tree = Tree::new(count, |i| corners_of(&vertices, &triangles, i));
        Ok(Self { vertices, triangles, tree })
    }

    /// The vertices.
    #[must_use]
    pub fn vertices(&self) -> &[Point3<f64>] {
        &self.vertices
    }

    /// The triangles, by the numbers of their vertices.
    #[must_use]
    pub fn triangles(&self) -> &[[u32; 3]] {
        &self.triangles
    }

    /// What the ray meets first; of triangles at one distance that of the lowest number.
    #[must_use]
    #[doc(alias("raycast", "intersect"))]
    pub fn first_hit(&self, ray: &Ray) -> Option<MeshHit> {
        let mut first: Option<MeshHit> = None;
        self.visit_hits(ray, |hit| {
            let nearer = first.is_none_or(|f| {
                hit.distance < f.distance
                    || (hit.distance == f.distance && hit.triangle < f.triangle)
            });
            if nearer {
                first = Some(hit);
            }
            first.map_or(f64::INFINITY, |f| f.distance)
        });
        first
    }

    /// Visits triangles that the ray meets, in no order. What `visit` returns is how far along the ray others still matter.
    pub(crate) fn visit_hits(&self, ray: &Ray, mut visit: impl FnMut(MeshHit) -> f64) {
        let sheared = Sheared::new(ray);
        self.tree.along(ray, |triangle, limit| {
            let corners = corners_of(&self.vertices, &self.triangles, triangle);
            match sheared.distance(&corners) {
                Some(distance) if distance <= limit => visit(MeshHit { triangle, distance }),
                _ => limit,
            }
        });
    }

    /// The point of the mesh nearest to a point, and the triangle that has it. On an edge between triangles, the one whose plane the point
    /// is farther from: it says on which side of both the point is.
    #[must_use]
    pub fn nearest(&self, world: &Point3<f64>) -> Option<(usize, Point3<f64>)> {
        if !world.iter().all(|c| c.is_finite()) {
            return None;
        }
        // Squared distance, then how far off the triangle's plane.
        let mut best: Option<(usize, Point3<f64>)> = None;
        let (mut least, mut off) = (f64::INFINITY, 0.0);
        self.tree.near(world, |triangle| {
            let corners = corners_of(&self.vertices, &self.triangles, triangle);
            let point = triangle::nearest(&corners, world);
            let squared = (world - point).norm_squared();
            let from_plane = triangle::height(&corners, world).abs();
            let tie = (squared - least).abs() <= 1e-12 * least;
            if if tie { from_plane > off } else { squared < least } {
                best = Some((triangle, point));
                off = from_plane;
                least = least.min(squared);
            }
            least
        });
        best
    }

    /// The normal of a triangle, of unit length; from its side the vertices turn counter-clockwise.
    fn normal_of(&self, triangle: usize) -> Result<UnitVector3<f64>, ProjectionError> {
        let [a, b, c] = corners_of(&self.vertices, &self.triangles, triangle);
        // At a length near one: the area of a tiny triangle must not vanish, nor that of a huge one overflow.
        let scale = (b - a).amax().max((c - a).amax());
        unit_normal(((b - a) / scale).cross(&((c - a) / scale)))
    }
}

/// The corners of a triangle.
fn corners_of(
    vertices: &[Point3<f64>],
    triangles: &[[u32; 3]],
    triangle: usize,
) -> [Point3<f64>; 3] {
    let numbers = triangles.get(triangle).copied().unwrap_or_default();
    numbers.map(|i| vertices.get(i as usize).copied().unwrap_or_else(Point3::origin))
}

impl Surface for TriangleMesh {
    fn height_above(&self, world: &Point3<f64>) -> f64 {
        let Some((triangle, point)) = self.nearest(world) else { return f64::NAN };
        let offset: Vector3<f64> = world - point;
        let corners = corners_of(&self.vertices, &self.triangles, triangle);
        let side = triangle::height(&corners, world);
        if side < 0.0 { -offset.norm() } else { offset.norm() }
    }

    fn meet_ray(&self, ray: &Ray) -> Result<Point3<f64>, ProjectionError> {
        let hit = self.first_hit(ray).ok_or(ProjectionError::MissesSurface)?;
        Ok(ray.at(hit.distance))
    }

    /// That of the nearest triangle.
    fn normal(&self, world: &Point3<f64>) -> Result<UnitVector3<f64>, ProjectionError> {
        let (triangle, _) = self.nearest(world).ok_or(ProjectionError::NotFinite)?;
        self.normal_of(triangle)
    }
}
