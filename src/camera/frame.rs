//! The frame camera: one exposure from one place.

use nalgebra::{Matrix2x3, Point2, Point3};

use super::exterior::{self, EXTERIOR};
use super::interior::InteriorOrientation;
use super::{
    Adjustable, CentralCamera, CentralModel, Distortion, ExteriorOrientation, Gnomonic,
    HomogeneousCamera, ParameterGroup, SensorModel, collinearity, parameters,
};
use crate::error::{Error, ProjectionError};
use crate::geometry::{Locus, Ray};

/// A photograph taken from one place: an exterior orientation and a central model.
///
/// # Model
/// ```text
/// image = camera( R (X − C) )                      [WD] eq. 4a
/// X = C + λ Rᵀ camera⁻¹(image),   λ > 0            [WD] eq. 4b
/// ```
///
/// # Parameters
/// Group 0 is the exterior orientation, six numbers: the projection centre in world units, then a left rotation vector
/// δ in radians, camera_from_world ← exp(\[δ\]×) R. The groups of the central model follow.
///
/// # Example
/// The photograph of Wuhan University's single-photo resection: f = 153.24 mm, the orientation published for it, and the
/// first control point, measured at (−86.15, −68.99) mm. The expected numbers are the textbook's collinearity equations
/// in Python's floats.
///
/// ```
/// use collinear::camera::{ExteriorOrientation, Frame, InteriorOrientation, SensorModel};
/// use collinear::geometry::Affine2;
/// use collinear::geometry::rotation::{PhiOmegaKappa, camera_from_photo};
/// use nalgebra::{Point2, Point3};
///
/// let angles = PhiOmegaKappa { phi: -0.0039869, omega: 0.0021139, kappa: -0.0675780 };
/// let center = Point3::new(39795.45, 27476.46, 7572.69);
/// let exterior = ExteriorOrientation::new(center, camera_from_photo() * angles.photo_from_world());
/// // With the identity for the scanner's map, image coordinates are photo millimetres, y up.
/// let interior = InteriorOrientation::from_photogrammetric(153.24, Point2::origin(), &Affine2::identity())?;
/// let p = Frame::new(exterior, interior).project(&Point3::new(36589.41, 25273.32, 2195.17))?;
/// assert!((p - Point2::new(-86.15117812, -68.98653065)).norm() < 1e-7);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[doc(alias("PerspectiveCamera", "photograph"))]
pub struct Frame<C> {
    /// Where the camera stands.
    pub exterior: ExteriorOrientation,
    /// What it does to a direction.
    pub camera: C,
}

impl<C> Frame<C> {
    /// A camera at its place.
    #[must_use]
    pub fn new(exterior: ExteriorOrientation, camera: C) -> Self {
        Self { exterior, camera }
    }
}

impl Frame<InteriorOrientation> {
    /// The camera as a projection matrix about its centre, with its inverse rays.
    #[must_use]
    pub fn homogeneous(&self) -> HomogeneousCamera {
        HomogeneousCamera::perspective(&self.exterior, &self.camera)
    }
}

impl<D: Distortion> Frame<CentralCamera<Gnomonic, D>> {
    /// The same camera with its lens errors taken away.
    #[must_use]
    pub fn ideal(&self) -> Frame<InteriorOrientation> {
        Frame::new(self.exterior, *self.camera.interior())
    }
}

impl<C: CentralModel> SensorModel for Frame<C> {
    #[inline]
    fn project(&self, world: &Point3<f64>) -> Result<Point2<f64>, ProjectionError> {
        self.camera.project_direction(&self.exterior.pose().apply(world).coords)
    }

    #[inline]
    fn project_jacobian(
        &self,
        world: &Point3<f64>,
    ) -> Result<(Point2<f64>, Matrix2x3<f64>), ProjectionError> {
        let pose = self.exterior.pose();
        let (image, jacobian) =
            self.camera.project_direction_jacobian(&pose.apply(world).coords)?;
        Ok((image, jacobian * pose.rotation.matrix()))
    }

    fn locus(&self, image: &Point2<f64>) -> Result<Locus, ProjectionError> {
        let direction = self.camera.direction(image)?;
        let pose = self.exterior.pose();
        Ray::new(pose.origin, pose.rotation.inverse() * direction)
            .map(Locus::Ray)
            .map_err(|_| ProjectionError::NotFinite)
    }
}

impl<C: CentralModel + Adjustable> Adjustable for Frame<C> {
    fn parameter_group(&self, group: usize) -> Option<ParameterGroup> {
        match group.checked_sub(1) {
            None => Some(EXTERIOR),
            Some(inner) => self.camera.parameter_group(inner),
        }
    }

    fn parameters(&self, group: usize, values: &mut [f64]) {
        match group.checked_sub(1) {
            Some(inner) => self.camera.parameters(inner, values),
            None => parameters::write(&self.exterior.values(), values),
        }
    }

    fn adjust(&mut self, group: usize, step: &[f64]) -> Result<(), Error> {
        if let Some(inner) = group.checked_sub(1) {
            return self.camera.adjust(inner, step);
        }
        self.exterior = self.exterior.moved(step)?;
        Ok(())
    }

    #[inline]
    fn partials(
        &self,
        object: &Point3<f64>,
        by_object: &mut [f64; 6],
        by_group: &mut [&mut [f64]],
    ) -> Result<Point2<f64>, ProjectionError> {
        let pose = self.exterior.pose();
        let in_camera = pose.apply(object);
        let (own, inner) = match by_group {
            [] => (None, &mut [][..]),
            [first, rest @ ..] => (Some(first), rest),
        };
        let mut by_direction = [0.0; 6];
        let image = self.camera.partials(&in_camera, &mut by_direction, inner)?;
        let by_direction = Matrix2x3::from_row_slice(&by_direction);
        let by_world = by_direction * pose.rotation.matrix();
        collinearity::write_rows(&by_world, by_object);
        if let Some(out) = own.filter(|out| !out.is_empty()) {
            let by_rotation = by_direction * collinearity::rotation_partials(&in_camera.coords);
            exterior::write_partials(&by_world, &by_rotation, out);
        }
        Ok(image)
    }
}
