//! The frame camera: one exposure from one place.

use nalgebra::{Matrix2x3, Matrix3, Matrix3x4, Point2, Point3};

use super::exterior::{self, EXTERIOR};
use super::interior::InteriorOrientation;
use super::{
    Adjustable, CentralCamera, CentralModel, Distortion, ExteriorOrientation, Gnomonic,
    HomogeneousCamera, ParameterGroup, SensorModel, collinearity, parameters,
};
use crate::error::{Error, ProjectionError};
use crate::geometry::rotation::orthonormalised;
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

    /// The camera of a projection matrix, (x w, y w, w)ᵀ ∝ P (X − O, 1)ᵀ for object points about the `origin` O.
    ///
    /// ```text
    /// P = (M | p) = λ K R (I | O − C),    C = O − M⁻¹ p
    /// ```
    ///
    /// K and R are the triangular and the orthogonal factor of M, made orthogonal from the last row upwards. Of P and −P, which are the
    /// same map, the one with det M > 0 is taken, whose K has positive principal distances; points that must be in front but then
    /// are behind belong to a mirrored picture.
    ///
    /// # Errors
    /// [`Error::NotFinite`]; [`Error::Degenerate`] where M is singular, as of a parallel projection. The measure is |det M| over the
    /// product of the lengths of its rows.
    ///
    /// # Example
    /// P of a camera at (1, 2, 3) with the axes of the world, fx = 800, fy = 900, s = 2, x₀ = 320, y₀ = 240, multiplied by −2:
    /// ```
    /// use collinear::Frame;
    /// use collinear::nalgebra::{Matrix3x4, Point2, Point3};
    ///
    /// let p = -2.0 * Matrix3x4::new(
    ///     800.0, 2.0, 320.0, -1764.0, // 800 · 1 + 2 · 2 + 320 · 3
    ///     0.0, 900.0, 240.0, -2520.0,
    ///     0.0, 0.0, 1.0, -3.0,
    /// );
    /// let frame = Frame::from_projection_matrix(&p, &Point3::origin())?;
    /// assert!((frame.exterior.projection_center() - Point3::new(1.0, 2.0, 3.0)).norm() < 1e-13);
    /// assert!((frame.camera.skew() - 2.0).abs() < 1e-12);
    /// assert!((frame.camera.principal_point() - Point2::new(320.0, 240.0)).norm() < 1e-12);
    /// # Ok::<(), collinear::Error>(())
    /// ```
    #[doc(alias("decomposeProjectionMatrix", "RQ decomposition"))]
    pub fn from_projection_matrix(p: &Matrix3x4<f64>, origin: &Point3<f64>) -> Result<Self, Error> {
        if !p.iter().chain(origin.iter()).all(|e| e.is_finite()) {
            return Err(Error::NotFinite { what: "projection matrix" });
        }
        let m = p.fixed_columns::<3>(0).into_owned();
        let [a, b, c] = [0, 1, 2].map(|i| m.row(i).transpose());
        let lengths = [a.norm(), b.norm(), c.norm()];
        // Rows of unit length: the determinant is their volume, and overflows nowhere.
        let [a1, b1, c1] = [a / lengths[0], b / lengths[1], c / lengths[2]];
        let volume = a1.cross(&b1).dot(&c1);
        let (measure, limit) = (volume.abs(), 8.0 * f64::EPSILON);
        if !(measure > limit) {
            let what = "projection matrix";
            let measure = if measure > 0.0 { measure } else { 0.0 };
            return Err(Error::Degenerate { what, measure, limit });
        }
        let scale = lengths[2].copysign(volume);
        let [a, b, third] = [a, b, c].map(|row| row / scale);
        let y0 = b.dot(&third);
        let across = b - third * y0;
        let fy = across.norm();
        let second = across / fy;
        let (skew, x0) = (a.dot(&second), a.dot(&third));
        let across = a - second * skew - third * x0;
        let fx = across.norm();
        let rows = [across / fx, second, third].map(|r| r.transpose());
        let rotation = orthonormalised(&Matrix3::from_rows(&rows))?;
        let interior = InteriorOrientation::new([fx, fy], Point2::new(x0, y0), skew)?;
        // C from K R (C − O) = −p, by the factors.
        let in_camera = interior.inverse_matrix() * (p.column(3) / -scale);
        let center = origin + rotation.inverse() * in_camera;
        if !center.iter().all(|e| e.is_finite()) {
            return Err(Error::NotFinite { what: "projection centre" });
        }
        Ok(Self::new(ExteriorOrientation::new(center, rotation), interior))
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
