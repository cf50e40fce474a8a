//! Polygons as any sensor sees them, by the line of sight of each pixel.

use alloc::collections::BTreeSet;
use alloc::vec;
use alloc::vec::Vec;
use core::fmt;

use nalgebra::{Point2, Point3, UnitVector3};

use super::polygon::{Facing, ScreenPolygon};
use crate::camera::{ExteriorOrientation, Orthographic, SensorModel};
use crate::error::{Error, ProjectionError};
use crate::geometry::{Affine2, HeightCurve, Locus, Plane, Ray, Surface, TriangleMesh, axes};
use crate::resample::{Border, Filter, ImageView, ImageViewMut, Sample, sample};

/// Polygons that lines of sight are cast at.
///
/// Each polygon has three or more vertices, convex or concave, in one plane, as for a [`ScreenPolygon`]. It is cut into triangles, exactly on
/// vertices rounded to 2⁻²⁶ of its size; those of all polygons stand in one [`TriangleMesh`]. Of a polygon that crosses itself that is
/// met which the even-odd rule counts as inside.
///
/// # Example
/// Two walls, one behind the other and larger. Above the first the second is seen:
///
/// ```
/// use collinear::geometry::{Locus, Ray};
/// use collinear::texturer::Facets;
/// use nalgebra::{Point3, Vector3};
///
/// let wall = |y: f64, size: f64| vec![
///     Point3::new(-size, y, 0.0), Point3::new(size, y, 0.0), Point3::new(size, y, size), Point3::new(-size, y, size),
/// ];
/// let (facets, refused) = Facets::new(&[wall(20.0, 10.0), wall(10.0, 2.0)])?;
/// assert!(refused.is_empty());
/// let seen = |slope| {
///     let ray = Ray::new(Point3::new(0.0, 0.0, 1.0), Vector3::new(0.0, 1.0, slope)).ok()?;
///     facets.first(&Locus::Ray(ray), |_| true).map(|sight| (sight.polygon, sight.point))
/// };
/// assert_eq!(seen(0.0), Some((1, Point3::new(0.0, 10.0, 1.0))));
/// assert_eq!(seen(0.25).map(|s| s.0), Some(0));
/// assert_eq!(seen(1.0), None);
/// # Ok::<(), collinear::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct Facets {
    mesh: TriangleMesh,
    /// Of each triangle, its polygon.
    polygons: Vec<u32>,
    /// Each polygon; none for one that was refused.
    facets: Vec<Option<Facet>>,
}

#[derive(Clone, Debug)]
struct Facet {
    plane: Plane,
    has_front: bool,
    /// Of a polygon that crosses itself, whose triangles are those of its rectangle.
    outline: Option<Outline>,
}

/// A polygon in its plane.
#[derive(Clone, Debug)]
struct Outline {
    /// From the world to the plane's axes, whose third is the normal.
    exterior: ExteriorOrientation,
    corners: Vec<Point2<f64>>,
}

impl Outline {
    /// By the even-odd rule: along x from the point an odd number of edges is crossed.
    fn contains(&self, world: &Point3<f64>) -> bool {
        let p = self.exterior.pose().apply(world);
        let next = self.corners.iter().cycle().skip(1);
        let crossed = self.corners.iter().zip(next).filter(|(a, b)| {
            // A corner at the point's own height belongs to the edge below it.
            (a.y > p.y) != (b.y > p.y) && p.x < a.x + (b.x - a.x) * ((p.y - a.y) / (b.y - a.y))
        });
        crossed.count() % 2 == 1
    }

    /// The corners of its rectangle, world coordinates.
    fn rectangle(&self) -> [Point3<f64>; 4] {
        let ends = |axis: usize| {
            let of = || self.corners.iter().map(|c| c[axis]);
            [of().fold(f64::INFINITY, f64::min), of().fold(f64::NEG_INFINITY, f64::max)]
        };
        let ([left, right], [low, high]) = (ends(0), ends(1));
        [(left, low), (right, low), (right, high), (left, high)]
            .map(|(x, y)| self.exterior.pose().apply_inverse(&Point3::new(x, y, 0.0)))
    }
}

/// A polygon on a line of sight.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sight {
    /// The number of the polygon.
    pub polygon: usize,
    /// Where it is met, world coordinates.
    pub point: Point3<f64>,
    /// How far that is from where the line of sight begins, world units: the sensor, or the top of a curve over height.
    pub distance: f64,
    /// Whether the side is seen from which the vertices turn counter-clockwise; none of a polygon that crosses itself with parts of one
    /// size, which has no front.
    pub from_front: Option<bool>,
}

/// The chords that a curve is followed along.
const CHORDS: u32 = 64;

/// Polygons that are passed one by one; the others on the ray are then taken all at once, so that many of them cost no more for being
/// many.
const ONE_BY_ONE: usize = 8;

/// Pixels across a polygon when it is cut into triangles.
const ACROSS: f64 = 262_144.0;

impl Facets {
    /// From polygons by their vertices; and those that are none, by their numbers, with the reason: too few vertices, all on one line, or not
    /// finite.
    ///
    /// # Errors
    /// [`Error::TooFewPoints`] where no polygon is left, and those of [`TriangleMesh::new`].
    pub fn new<P: AsRef<[Point3<f64>]>>(
        polygons: &[P],
    ) -> Result<(Self, Vec<(usize, Error)>), Error> {
        let mut refused = Vec::new();
        let (mut vertices, mut triangles) = (Vec::new(), Vec::new());
        let (mut numbers, mut facets) = (Vec::new(), Vec::with_capacity(polygons.len()));
        for (number, polygon) in polygons.iter().enumerate() {
            let world = polygon.as_ref();
            match cut(world) {
                Err(error) => {
                    refused.push((number, error));
                    facets.push(None);
                }
                Ok((facet, corners, pieces)) => {
                    let first = vertices.len() as u32;
                    vertices.extend(corners);
                    numbers.extend(pieces.iter().map(|_| number as u32));
                    triangles.extend(pieces.into_iter().map(|t| t.map(|i| first + i as u32)));
                    facets.push(Some(facet));
                }
            }
        }
        let mesh = TriangleMesh::new(vertices, triangles)?;
        Ok((Self { mesh, polygons: numbers, facets }, refused))
    }

    /// The triangles of all polygons; of one that crosses itself those of its rectangle.
    #[must_use]
    pub fn mesh(&self) -> &TriangleMesh {
        &self.mesh
    }

    /// The first polygon along a line of sight that is wanted. Of two at one distance, to rounding to `f32`, the one of the lower number is
    /// asked first, as on a [`Canvas`](super::Canvas).
    pub fn first(&self, locus: &Locus, mut wanted: impl FnMut(&Sight) -> bool) -> Option<Sight> {
        match locus {
            Locus::Ray(ray) => self.first_on(ray, f64::INFINITY, &mut wanted),
            Locus::Curve(curve) => self.first_along(curve, &mut wanted),
        }
    }

    /// The first on a ray to the last digit.
    fn hit(&self, ray: &Ray) -> Option<f64> {
        let mut nearest = f64::INFINITY;
        self.visit(ray, |_, distance, is_inside| {
            if distance < nearest && is_inside() {
                nearest = distance;
            }
            nearest
        });
        Some(nearest).filter(|t| t.is_finite())
    }

    fn plane(&self, polygon: usize) -> Option<Plane> {
        self.facets.get(polygon)?.as_ref().map(|f| f.plane)
    }

    /// Visits the polygons whose triangles the ray meets, in no order: the polygon, how far along the ray, and what tells whether the
    /// polygon itself is there. What `visit` returns is how far along the ray others still matter.
    fn visit(&self, ray: &Ray, mut visit: impl FnMut(u32, f64, &dyn Fn() -> bool) -> f64) {
        self.mesh.visit_hits(ray, |hit| {
            let polygon = self.polygons.get(hit.triangle).copied().unwrap_or_default();
            let facet = self.facets.get(polygon as usize).and_then(Option::as_ref);
            let at = |o: &Outline| o.contains(&ray.at(hit.distance));
            let is_inside = || facet.is_some_and(|f| f.outline.as_ref().is_none_or(at));
            visit(polygon, hit.distance, &is_inside)
        });
    }

    /// The first on a ray, not farther than `reach`.
    fn first_on(
        &self,
        ray: &Ray,
        reach: f64,
        wanted: &mut impl FnMut(&Sight) -> bool,
    ) -> Option<Sight> {
        // What was not wanted comes no more: a line of sight meets a polygon once.
        let mut passed: Vec<u32> = Vec::new();
        while passed.len() < ONE_BY_ONE {
            let mut first: Option<((f32, u32), f64)> = None;
            self.visit(ray, |polygon, distance, is_inside| {
                let key = (distance as f32, polygon);
                if distance <= reach
                    && !passed.contains(&polygon)
                    && first.is_none_or(|(nearest, _)| key < nearest)
                    && is_inside()
                {
                    first = Some((key, distance));
                }
                // Those that round to the same distance count.
                first.map_or(reach, |((distance, _), _)| f64::from(distance.next_up()))
            });
            let ((_, polygon), distance) = first?;
            let sight = self.sight(ray, polygon, distance)?;
            if wanted(&sight) {
                return Some(sight);
            }
            passed.push(polygon);
        }
        let mut others: Vec<(f32, u32, f64)> = Vec::new();
        self.visit(ray, |polygon, distance, is_inside| {
            if distance <= reach && is_inside() {
                others.push((distance as f32, polygon, distance));
            }
            reach
        });
        others.sort_unstable_by(|a, b| {
            a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)).then(a.2.total_cmp(&b.2))
        });
        let mut passed: BTreeSet<u32> = passed.into_iter().collect();
        others.into_iter().filter(|(_, polygon, _)| passed.insert(*polygon)).find_map(
            |(_, polygon, distance)| {
                self.sight(ray, polygon, distance).filter(|sight| wanted(sight))
            },
        )
    }

    fn sight(&self, ray: &Ray, polygon: u32, distance: f64) -> Option<Sight> {
        let facet = self.facets.get(polygon as usize)?.as_ref()?;
        Some(Sight {
            polygon: polygon as usize,
            point: ray.at(distance),
            distance,
            from_front: facet.has_front.then(|| facet.plane.normal().dot(&ray.direction) < 0.0),
        })
    }

    /// The first along a curve from its top: chord by chord, then on the curve itself.
    fn first_along(
        &self,
        curve: &HeightCurve,
        wanted: &mut impl FnMut(&Sight) -> bool,
    ) -> Option<Sight> {
        let [low, high] = curve.heights;
        let at = |k: u32| curve.at(high + (low - high) * (f64::from(k) / f64::from(CHORDS)));
        let (top, mut from) = (at(0), at(0));
        for k in 1..=CHORDS {
            let to = at(k);
            let chord = to - from;
            let ray = Ray::new(from, chord).ok()?;
            let mut on_curve = |sight: &Sight| {
                let exact = self.plane(sight.polygon).and_then(|p| p.meet_curve(curve).ok());
                let point = exact.filter(|p| (p - sight.point).norm() <= chord.norm());
                let point = point.unwrap_or(sight.point);
                let sight = Sight { point, distance: (point - top).norm(), ..*sight };
                wanted(&sight).then_some(sight)
            };
            let mut found = None;
            let _ = self.first_on(&ray, chord.norm(), &mut |sight| {
                found = on_curve(sight);
                found.is_some()
            });
            if found.is_some() {
                return found;
            }
            from = to;
        }
        None
    }
}

/// Heights and normals are those of the triangles ([`Facets::mesh`]).
impl Surface for Facets {
    fn height_above(&self, world: &Point3<f64>) -> f64 {
        self.mesh.height_above(world)
    }

    fn meet_ray(&self, ray: &Ray) -> Result<Point3<f64>, ProjectionError> {
        self.hit(ray).map(|t| ray.at(t)).ok_or(ProjectionError::MissesSurface)
    }

    fn normal(&self, world: &Point3<f64>) -> Result<UnitVector3<f64>, ProjectionError> {
        self.mesh.normal(world)
    }
}

/// Parts whose areas differ by less than a millionth of the polygon's size squared are of one size; doubled, in 1/256² pixel.
const EQUAL_PARTS: f64 = 1e-6 * (256.0 * ACROSS) * (256.0 * ACROSS);

/// A polygon, the corners of its triangles, and these by the numbers of the corners.
type Cut = (Facet, Vec<Point3<f64>>, Vec<[usize; 3]>);

fn cut(world: &[Point3<f64>]) -> Result<Cut, Error> {
    let plane = match world {
        [a, b, c] => Plane::through(a, b, c)?,
        _ => Plane::fit(world)?.plane,
    };
    let size = world.iter().map(|p| (p - plane.point()).norm()).fold(0.0, f64::max);
    let turned = axes(&plane.normal()).inverse();
    let exterior = ExteriorOrientation::new(plane.point(), turned);
    let scale = ACROSS / size;
    let flat = Affine2::from_coefficients([0.0, scale, 0.0], [0.0, 0.0, scale]);
    let flat = Orthographic::new(exterior, flat)?.homogeneous();
    let outline = ScreenPolygon::project(world, &flat, 1.0)?;
    if outline.crosses_itself() {
        let has_front = outline.doubled_area().unsigned_abs() as f64 > EQUAL_PARTS;
        let corners = world.iter().map(|p| exterior.pose().apply(p).xy()).collect();
        let outline = Outline { exterior, corners };
        let rectangle = outline.rectangle().to_vec();
        let facet = Facet { plane, has_front, outline: Some(outline) };
        return Ok((facet, rectangle, vec![[0, 1, 2], [0, 2, 3]]));
    }
    Ok((Facet { plane, has_front: true, outline: None }, world.to_vec(), outline.triangles()))
}

/// What a polygon is painted with where a line of sight meets it.
#[derive(Clone, Copy)]
pub enum RayPaint<'a, T, const C: usize> {
    /// Nothing: what lies behind is seen.
    Nothing,
    /// One value.
    Flat([T; C]),
    /// A picture.
    Picture {
        /// The picture.
        image: ImageView<'a, T, C>,
        /// Where in the picture a world point is: a [`SensorModel::project`], a [`PlaneTexture::at`](super::PlaneTexture::at).
        coordinates: &'a TextureCoordinates<'a>,
        /// How values are taken between texel centres.
        filter: Filter,
        /// What lies beyond the picture. Where a transparent border or the coordinates give nothing, what lies behind is seen.
        border: Border,
    },
}

/// Texture coordinates of a world point, or why it has none.
pub type TextureCoordinates<'a> =
    dyn Fn(&Point3<f64>) -> Result<Point2<f64>, ProjectionError> + Sync + 'a;

impl<T: fmt::Debug, const C: usize> fmt::Debug for RayPaint<'_, T, C> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Nothing => f.write_str("Nothing"),
            Self::Flat(value) => f.debug_tuple("Flat").field(value).finish(),
            Self::Picture { filter, border, .. } => f
                .debug_struct("Picture")
                .field("filter", filter)
                .field("border", border)
                .finish_non_exhaustive(),
        }
    }
}

/// The picture that any sensor takes of polygons.
///
/// Each pixel's line of sight, through its centre, meets the polygons from the nearest on, until one gives the pixel a value. A pixel
/// without a line of sight, as beyond a fisheye's circle, stays as it was. A parallel screen sees from its plane Z′ = 0 on. For a perspective screen the [`Canvas`](super::Canvas) draws the
/// same pixels faster; the two agree but for pixels whose centre is within 1/256 pixel of an edge.
///
/// # Example
/// A cylindrical panorama of four pixels, each a quarter turn wide, from the middle of a room with walls of four colours:
///
/// ```
/// use collinear::camera::{CentralCamera, ExteriorOrientation, Frame, InteriorOrientation, Panorama};
/// use collinear::resample::ImageViewMut;
/// use collinear::texturer::{Facets, Facing, RayCaster, RayPaint};
/// use nalgebra::{Point2, Point3, Rotation3, Vector3};
///
/// // Wall k stands a quarter turn right of wall k − 1; the first is ahead (z forward, y down).
/// let walls: Vec<Vec<Point3<f64>>> = (0..4).map(|k| {
///     let turn = Rotation3::from_axis_angle(&Vector3::y_axis(), f64::from(k) * std::f64::consts::FRAC_PI_2);
///     [(-3.0, -3.0), (3.0, -3.0), (3.0, 3.0), (-3.0, 3.0)].map(|(x, y)| turn * Point3::new(x, y, 3.0)).to_vec()
/// }).collect();
/// let (facets, _) = Facets::new(&walls)?;
/// let eye = ExteriorOrientation::new(Point3::origin(), Rotation3::identity());
/// let turn = 4.0 / std::f64::consts::TAU;
/// let interior = InteriorOrientation::new([turn; 2], Point2::new(1.5, 0.5), 0.0)?;
/// let screen = Frame::new(eye, CentralCamera::ideal(interior, Panorama::Cylindrical));
/// let paints = [1, 2, 3, 4].map(|color| RayPaint::Flat([color]));
/// let caster = RayCaster { screen: &screen, facets: &facets, paints: &paints, facing: Facing::Both, near: 0.1 };
/// let mut pixels = [0u8; 4];
/// caster.draw(&mut ImageViewMut::<u8, 1>::new(&mut pixels, 4, 1)?);
/// // A quarter turn to the left of the principal point, ahead, to the right; a fourth is past the seam.
/// assert_eq!(pixels, [4, 1, 2, 3]);
/// # Ok::<(), collinear::Error>(())
/// ```
#[derive(Clone, Copy, Debug)]
#[doc(alias("ray tracing", "ray casting"))]
pub struct RayCaster<'a, T, const C: usize> {
    /// The sensor whose picture is drawn.
    pub screen: &'a dyn SensorModel,
    /// The polygons.
    pub facets: &'a Facets,
    /// Of each polygon its paint; those without one are not seen.
    pub paints: &'a [RayPaint<'a, T, C>],
    /// Which sides are seen. The front is that from which the vertices turn counter-clockwise.
    pub facing: Facing,
    /// The distance, in world units along the line of sight, before which nothing is seen.
    pub near: f64,
}

impl<T: Sample, const C: usize> RayCaster<'_, T, C> {
    /// Draws a whole picture. The sensor's pixels are its pixels.
    pub fn draw(&self, target: &mut ImageViewMut<'_, T, C>) {
        for y in 0..target.height() {
            self.row(y, target.row_mut(y), |_, _| ());
        }
    }

    /// Draws row `y`, of as many pixels as `row` has room for, and tells for each that it draws what is seen there.
    pub fn row(&self, y: usize, row: &mut [T], mut seen: impl FnMut(usize, &Sight)) {
        for (x, pixel) in row.chunks_exact_mut(C.max(1)).enumerate() {
            let center = Point2::new(x as f64 + 0.5, y as f64 + 0.5);
            if let Some((sight, value)) = self.value(&center) {
                pixel.copy_from_slice(&value);
                seen(x, &sight);
            }
        }
    }

    /// What a point of the sensor's picture shows.
    fn value(&self, image: &Point2<f64>) -> Option<(Sight, [T; C])> {
        let locus = self.screen.locus(image).ok()?;
        let mut value = None;
        let sight = self.facets.first(&locus, |sight| {
            let shown = match self.facing {
                Facing::Both => true,
                Facing::Front => sight.from_front == Some(true),
                Facing::Back => sight.from_front == Some(false),
            };
            if shown && sight.distance >= self.near {
                value = self.paint(sight);
            }
            value.is_some()
        })?;
        Some((sight, value?))
    }

    /// What a polygon shows where it is met.
    fn paint(&self, sight: &Sight) -> Option<[T; C]> {
        match self.paints.get(sight.polygon)? {
            RayPaint::Nothing => None,
            RayPaint::Flat(value) => Some(*value),
            RayPaint::Picture { image, coordinates, filter, border } => {
                let position = coordinates(&sight.point).ok()?;
                sample(*image, &position, *filter, *border)
            }
        }
    }
}
