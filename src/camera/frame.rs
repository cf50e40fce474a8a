//! The frame camera: one exposure from one place.

use nalgebra::{Matrix2x3, Point2, Point3, Vector3};

use super::interior::InteriorOrientation;
use super::{
    Adjustable, CentralCamera, CentralModel, Distortion, ExteriorOrientation, Gnomonic,
    HomogeneousCamera, ParameterGroup, SensorModel, collinearity,
};
use crate::error::{Error, ProjectionError};
use crate::geometry::rotation::{RotationVector, orthonormalised};
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

const EXTERIOR: ParameterGroup = ParameterGroup { name: "exterior orientation", len: 6 };

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
    fn project(&self, world: &Point3<f64>) -> Result<Point2<f64>, ProjectionError> {
        self.camera.project_direction(&self.exterior.pose().apply(world).coords)
    }

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
            None => {
                let c = self.exterior.projection_center();
                for (v, p) in values.iter_mut().zip([c.x, c.y, c.z, 0.0, 0.0, 0.0]) {
                    *v = p;
                }
            }
        }
    }

    fn adjust(&mut self, group: usize, step: &[f64]) -> Result<(), Error> {
        if let Some(inner) = group.checked_sub(1) {
            return self.camera.adjust(inner, step);
        }
        let &[x, y, z, a, b, c] = step else {
            return Err(Error::LengthMismatch {
                what: "parameter group and step",
                left: EXTERIOR.len,
                right: step.len(),
            });
        };
        if !step.iter().all(|s| s.is_finite()) {
            return Err(Error::NotFinite { what: "exterior orientation step" });
        }
        let center = self.exterior.projection_center() + Vector3::new(x, y, z);
        if !center.iter().all(|c| c.is_finite()) {
            return Err(Error::NotFinite { what: "projection centre after a step" });
        }
        let turn = RotationVector { x: a, y: b, z: c }.rotation();
        // Products of many small turns drift from orthonormal; renormalising at each step keeps them there.
        let product = turn.matrix() * self.exterior.camera_from_world().matrix();
        self.exterior = ExteriorOrientation::new(center, orthonormalised(&product)?);
        Ok(())
    }

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
        if let Some(out) = own
            && out.len() == 2 * EXTERIOR.len
        {
            let by_rotation = by_direction * collinearity::rotation_partials(&in_camera.coords);
            for row in 0..2 {
                for i in 0..3 {
                    out[row * 6 + i] = -by_world[(row, i)];
                    out[row * 6 + 3 + i] = by_rotation[(row, i)];
                }
            }
        }
        Ok(image)
    }
}
