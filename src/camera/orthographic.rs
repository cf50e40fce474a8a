//! Parallel projection.

use nalgebra::{Matrix2, Matrix2x3, Point2, Point3, Vector3};

use super::exterior::{self, EXTERIOR};
use super::{
    Adjustable, ExteriorOrientation, HomogeneousCamera, ParameterGroup, SensorModel, collinearity,
    no_group, parameters,
};
use crate::error::{Error, ProjectionError};
use crate::geometry::{Affine2, Locus, Ray, Surface};

/// A parallel (orthographic) projection: \[WD\] table 2 with 1/f = 0.
///
/// ```text
/// (x, y) = A · (X′, Y′) + b,      (X′, Y′, Z′) = R (X − O)
/// ```
///
/// A is in pixels per world unit. Maps and orthophotos are such pictures, and a texture laid on orthogonally. There is
/// no eye: a point at any depth Z′ has an image. A ray starts on the plane Z′ = 0, so O is best placed above the scene.
///
#[doc = include_str!("../../docs/figures/lenses/parallel.svg")]
///
/// # Parameters
/// Group 0 is the exterior orientation: O in world units, then a left rotation vector in radians. Group 1 is the map to pixels: a₁₁, a₁₂,
/// a₂₁, a₂₂ in pixels a world unit, b₁, b₂ in pixels. No picture tells a step of O from one of b, nor one along the line of sight from
/// none: hold one of them.
///
/// # Example
/// An orthophoto with its upper left corner at (500 000, 5 000 100) and half a metre a pixel. A point 10 m east and 5 m
/// south of the corner is at (20, 10), whatever its height:
///
/// ```
/// use collinear::camera::{ExteriorOrientation, Orthographic, SensorModel};
/// use collinear::geometry::Affine2;
/// use nalgebra::{Point2, Point3, Vector3};
///
/// let corner = Point3::new(500_000.0, 5_000_100.0, 1000.0);
/// let down = ExteriorOrientation::look_at(corner, corner - Vector3::z(), Vector3::y())?;
/// let map = Orthographic::new(down, Affine2::from_coefficients([0.0, 2.0, 0.0], [0.0, 0.0, 2.0]))?;
/// let p = map.project(&Point3::new(500_010.0, 5_000_095.0, 123.0))?;
/// assert!((p - Point2::new(20.0, 10.0)).norm() < 1e-12);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[doc(alias("parallel projection", "affine camera"))]
pub struct Orthographic {
    exterior: ExteriorOrientation,
    pixel_from_plane: Affine2,
    inverse: Affine2,
}

impl Orthographic {
    /// From the viewing frame (its `projection_center` is O) and the affine map of its x–y plane to pixels.
    ///
    /// # Errors
    /// [`Error::NotFinite`], [`Error::Degenerate`] where the affine map is singular.
    pub fn new(exterior: ExteriorOrientation, pixel_from_plane: Affine2) -> Result<Self, Error> {
        if !pixel_from_plane.to_matrix().iter().all(|v| v.is_finite()) {
            return Err(Error::NotFinite { what: "orthographic projection" });
        }
        let inverse = pixel_from_plane.inverse()?;
        Ok(Self { exterior, pixel_from_plane, inverse })
    }

    /// The projection as a matrix about O, with its inverse rays.
    #[must_use]
    pub fn homogeneous(&self) -> HomogeneousCamera {
        HomogeneousCamera::orthographic(&self.exterior, &self.pixel_from_plane, &self.inverse)
    }

    /// A row after row, then b.
    fn pixel_values(&self) -> [f64; 6] {
        let Affine2 { linear: a, translation: b } = self.pixel_from_plane;
        [a.m11, a.m12, a.m21, a.m22, b.x, b.y]
    }

    fn by_world(&self) -> Matrix2x3<f64> {
        let rotation = self.exterior.camera_from_world();
        let linear: Matrix2<f64> = self.pixel_from_plane.linear;
        linear * rotation.matrix().fixed_view::<2, 3>(0, 0)
    }

    fn line(&self, image: &Point2<f64>) -> Result<Ray, ProjectionError> {
        let on_plane = collinearity::finite(self.inverse.apply(image))?;
        let pose = self.exterior.pose();
        let origin = pose.apply_inverse(&Point3::new(on_plane.x, on_plane.y, 0.0));
        Ray::new(origin, pose.rotation.inverse() * Vector3::z())
            .map_err(|_| ProjectionError::NotFinite)
    }
}

impl SensorModel for Orthographic {
    fn project(&self, world: &Point3<f64>) -> Result<Point2<f64>, ProjectionError> {
        let p = self.exterior.pose().apply(world);
        collinearity::finite(self.pixel_from_plane.apply(&p.xy()))
    }

    fn project_jacobian(
        &self,
        world: &Point3<f64>,
    ) -> Result<(Point2<f64>, Matrix2x3<f64>), ProjectionError> {
        Ok((self.project(world)?, self.by_world()))
    }

    fn locus(&self, image: &Point2<f64>) -> Result<Locus, ProjectionError> {
        self.line(image).map(Locus::Ray)
    }

    /// The first point along the viewing direction from the plane Z′ = 0; failing that, the first against it.
    fn ground(
        &self,
        image: &Point2<f64>,
        surface: &dyn Surface,
    ) -> Result<Point3<f64>, ProjectionError> {
        self.line(image)?.meet_either_way(surface)
    }
}

impl Adjustable for Orthographic {
    fn parameter_group(&self, group: usize) -> Option<ParameterGroup> {
        [EXTERIOR, PIXELS].get(group).copied()
    }

    fn parameters(&self, group: usize, values: &mut [f64]) {
        match group {
            0 => parameters::write(&self.exterior.values(), values),
            1 => parameters::write(&self.pixel_values(), values),
            _ => {}
        }
    }

    fn adjust(&mut self, group: usize, step: &[f64]) -> Result<(), Error> {
        *self = match group {
            0 => Self { exterior: self.exterior.moved(step)?, ..*self },
            1 => {
                let step: [f64; PIXELS.len] = parameters::read(step)?;
                let mut values = self.pixel_values();
                values.iter_mut().zip(step).for_each(|(v, s)| *v += s);
                let [a, b, c, d, x, y] = values;
                Self::new(self.exterior, Affine2::from_coefficients([x, a, b], [y, c, d]))?
            }
            _ => return Err(no_group(group)),
        };
        Ok(())
    }

    fn partials(
        &self,
        object: &Point3<f64>,
        by_object: &mut [f64; 6],
        by_group: &mut [&mut [f64]],
    ) -> Result<Point2<f64>, ProjectionError> {
        let p = self.exterior.pose().apply(object);
        let image = collinearity::finite(self.pixel_from_plane.apply(&p.xy()))?;
        let by_world = self.by_world();
        collinearity::write_rows(&by_world, by_object);
        for (group, out) in by_group.iter_mut().enumerate().filter(|(_, out)| !out.is_empty()) {
            match group {
                0 => {
                    let turned = collinearity::rotation_partials(&p.coords);
                    let by_turn = self.pixel_from_plane.linear * turned.fixed_rows::<2>(0);
                    exterior::write_partials(&by_world, &by_turn, out);
                }
                1 => parameters::write(
                    &[p.x, p.y, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, p.x, p.y, 0.0, 1.0],
                    out,
                ),
                _ => {}
            }
        }
        Ok(image)
    }
}

/// The group of the affine map.
const PIXELS: ParameterGroup = ParameterGroup { name: "pixels from plane", len: 6 };
