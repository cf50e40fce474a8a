//! Which photograph sees a polygon best, by casting rays at the model.

use anyhow::Result;
use collinear::camera::SensorModel;
use collinear::geometry::{Plane, Ray, Surface};
use collinear::nalgebra::{Matrix2x3, Point2, Point3, UnitVector3, Vector3};

use crate::model::{Face, PASSERS_BY};
use crate::site::Photograph;

/// A point this near to the seen face, in world units, hides nothing.
const CLEARANCE: f64 = 0.1;
/// Points along each side of the box about a face at which visibility is asked.
const SAMPLES: usize = 16;

/// A face ready for casting rays.
pub(crate) struct Target {
    plane: Plane,
    axes: [UnitVector3<f64>; 2],
    /// The outline in the plane's own coordinates; the second is up, or into the façade where the plane is level.
    pub(crate) outline: Vec<Point2<f64>>,
}

impl Target {
    fn new(face: &Face) -> Result<Self> {
        let plane = Plane::fit(&face.outline)?.plane;
        let n = plane.normal();
        let helper = if n.z.abs() < 0.9 { Vector3::z() } else { Vector3::y() };
        let x = UnitVector3::new_normalize(helper.cross(&n));
        let axes = [x, UnitVector3::new_normalize(n.cross(&x))];
        let mut target = Self { plane, axes, outline: Vec::new() };
        target.outline = face.outline.iter().map(|p| target.coordinates(p)).collect();
        Ok(target)
    }

    fn coordinates(&self, p: &Point3<f64>) -> Point2<f64> {
        let d = p - self.plane.point();
        Point2::new(self.axes[0].dot(&d), self.axes[1].dot(&d))
    }

    /// The point of the plane at its own coordinates.
    pub(crate) fn world(&self, p: &Point2<f64>) -> Point3<f64> {
        self.plane.point() + *self.axes[0] * p.x + *self.axes[1] * p.y
    }

    /// The corners of the box about the outline.
    pub(crate) fn bounds(&self) -> [Point2<f64>; 2] {
        let far = Point2::new(f64::INFINITY, f64::INFINITY);
        self.outline.iter().fold([far, -far], |[a, b], p| [a.inf(p), b.sup(p)])
    }

    /// Whether a ray to the right crosses the outline an odd number of times.
    pub(crate) fn holds(&self, p: &Point2<f64>) -> bool {
        let edges = self.outline.iter().zip(self.outline.iter().cycle().skip(1));
        let crossed = edges.filter(|(a, b)| {
            (a.y > p.y) != (b.y > p.y) && p.x < a.x + (b.x - a.x) * (p.y - a.y) / (b.y - a.y)
        });
        crossed.count() % 2 == 1
    }

    fn distance(&self, ray: &Ray) -> Option<f64> {
        let hit = self.plane.meet_ray(ray).ok()?;
        self.holds(&self.coordinates(&hit)).then(|| (hit - ray.origin).norm())
    }

    /// Points of a regular grid that lie in the face.
    fn samples(&self) -> Vec<Point3<f64>> {
        let [low, high] = self.bounds();
        let at = |i: usize, a: f64, b: f64| a + (b - a) * (i as f64 + 0.5) / SAMPLES as f64;
        let grid = (0..SAMPLES * SAMPLES)
            .map(|k| Point2::new(at(k % SAMPLES, low.x, high.x), at(k / SAMPLES, low.y, high.y)));
        grid.filter(|p| self.holds(p)).map(|p| self.world(&p)).collect()
    }
}

/// The model, for casting rays.
pub(crate) struct Sight {
    targets: Vec<Target>,
}

/// How a photograph sees a face.
#[derive(Clone, Copy, Debug)]
pub(crate) struct View {
    /// The photograph's place in the list.
    pub(crate) photograph: usize,
    /// The part of the face that it shows, from 0 to 1.
    pub(crate) share: f64,
    /// Pixels along a world unit, the geometric mean of the longest and the shortest direction.
    pub(crate) pixels: f64,
}

impl Sight {
    pub(crate) fn new(faces: &[Face]) -> Result<Self> {
        Ok(Self { targets: faces.iter().map(Target::new).collect::<Result<_>>()? })
    }

    /// The nearest face along a ray and the distance to it.
    pub(crate) fn first(&self, ray: &Ray) -> Option<(usize, f64)> {
        let hits = self.targets.iter().enumerate().filter_map(|(i, t)| Some((i, t.distance(ray)?)));
        hits.min_by(|a, b| a.1.total_cmp(&b.1))
    }

    /// The faces, in order.
    pub(crate) fn targets(&self) -> &[Target] {
        &self.targets
    }

    /// ∂image/∂world where a photograph shows a point: in its picture, hidden by no face and by nobody passing.
    pub(crate) fn sees(
        &self,
        photograph: &Photograph,
        point: &Point3<f64>,
    ) -> Option<Matrix2x3<f64>> {
        let (image, by_world) = photograph.frame.project_jacobian(point).ok()?;
        let inside =
            |[x0, y0, x1, y1]: [f64; 4]| (x0..x1).contains(&image.x) && (y0..y1).contains(&image.y);
        let (width, height) = (photograph.camera.width, photograph.camera.height);
        if !inside([0.0, 0.0, f64::from(width), f64::from(height)])
            || PASSERS_BY.iter().any(|(name, area)| *name == photograph.name && inside(*area))
        {
            return None;
        }
        let center = photograph.frame.exterior.projection_center();
        let to_point = point - center;
        let ray = Ray::new(center, to_point).ok()?;
        let limit = to_point.norm() - CLEARANCE;
        let hidden = self.targets.iter().filter_map(|t| t.distance(&ray)).any(|d| d < limit);
        (!hidden).then_some(by_world)
    }

    /// How each photograph sees a face: the best first.
    pub(crate) fn views(&self, face: usize, photographs: &[Photograph]) -> Vec<View> {
        let Some(target) = self.targets.get(face) else { return Vec::new() };
        let samples = target.samples();
        let mut views: Vec<View> = photographs
            .iter()
            .enumerate()
            .filter_map(|(i, p)| self.view(target, &samples, i, p))
            .collect();
        // A photograph that shows twice as much outweighs one with twice the pixels.
        let worth = |v: &View| v.share * v.share * v.pixels;
        views.sort_by(|a, b| worth(b).total_cmp(&worth(a)));
        views
    }

    fn view(
        &self,
        target: &Target,
        samples: &[Point3<f64>],
        index: usize,
        photograph: &Photograph,
    ) -> Option<View> {
        let (mut seen, mut pixels) = (0.0, 0.0);
        for p in samples {
            if let Some(by_world) = self.sees(photograph, p) {
                let [x, y] = target.axes.map(|a| by_world * *a);
                seen += 1.0;
                pixels += (x.x * y.y - x.y * y.x).abs().sqrt();
            }
        }
        (seen > 0.0).then(|| View {
            photograph: index,
            share: seen / samples.len() as f64,
            pixels: pixels / seen,
        })
    }
}
