//! One map after another, and the lens as a map.

use nalgebra::{Matrix2, Point2};

use super::{FractionalLinear, Map};
use crate::camera::{Brown, CentralCamera, Distortion, Frame, Gnomonic, HomogeneousCamera};
use crate::error::{Error, ProjectionError};
use crate::geometry::Plane;

/// The map `outer` after `inner`: outer(inner(screen)).
///
/// The Jacobian is the product of both (chain rule), and a point is valid where both are.
///
/// ```
/// use collinear::geometry::Affine2;
/// use collinear::mapping::{Composed, FractionalLinear, Map};
/// use nalgebra::{Matrix2, Point2};
///
/// // x = S/(1 + L), y = L/(1 + L), then u = 2x + 1, v = y.
/// let inner = FractionalLinear::from_coefficients(
///     [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 1.0], [1.0, 0.0, 0.0])?;
/// let map = Composed { outer: Affine2::from_coefficients([1.0, 2.0, 0.0], [0.0, 0.0, 1.0]), inner };
/// let p = Point2::new(4.0, 1.0);
/// assert_eq!(map.at(&p)?, Point2::new(5.0, 0.5));
/// // ∂u/∂S = 2/(1 + L), ∂u/∂L = −2S/(1 + L)², ∂v/∂L = 1/(1 + L)².
/// assert_eq!(map.jacobian(&p)?, Matrix2::new(1.0, -2.0, 0.0, 0.25));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Composed<A, B> {
    /// Applied last, to what `inner` gives.
    pub outer: A,
    /// Applied first, to the screen point.
    pub inner: B,
}

impl<A: Map, B: Map> Map for Composed<A, B> {
    #[inline]
    fn at(&self, screen: &Point2<f64>) -> Result<Point2<f64>, ProjectionError> {
        self.outer.at(&self.inner.at(screen)?)
    }

    fn jacobian(&self, screen: &Point2<f64>) -> Result<Matrix2<f64>, ProjectionError> {
        let middle = self.inner.at(screen)?;
        Ok(self.outer.jacobian(&middle)? * self.inner.jacobian(screen)?)
    }
}

/// From the ideal (distortion-free) picture of a camera to the picture it takes: pixel → distorted pixel.
///
/// Of a perspective with any lens; fisheyes and the like, which have no ideal picture, have a [`CentralMap`](super::CentralMap).
/// \[WD\] eq. 1 leads into the ideal picture; behind it, as [`Composed::outer`], this map leads into the photograph.
///
/// *Domain.* Ideal points within the lens's [fold radius](Distortion::fold_radius).
///
/// # Example
/// OpenCV 5.0.0, `projectPoints` of (0.31, −0.22, 1), whose ideal pixel is (810, 280):
///
/// ```
/// use collinear::camera::{Brown, BrownCamera, InteriorOrientation};
/// use collinear::mapping::{DistortMap, Map, UndistortMap};
/// use nalgebra::Point2;
///
/// let interior = InteriorOrientation::new([1000.0; 2], Point2::new(500.0, 500.0), 0.0)?;
/// let camera = BrownCamera::new(interior, Brown::new([-0.28, 0.07, 0.002], [1e-3, -5e-4])?);
/// let photograph = DistortMap::new(camera).at(&Point2::new(810.0, 280.0))?;
/// assert!((photograph - Point2::new(797.6076220865975, 288.88781658370502)).norm() < 1e-12);
/// let ideal = UndistortMap::new(camera).at(&photograph)?;
/// assert!((ideal - Point2::new(810.0, 280.0)).norm() < 1e-12);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[doc(alias = "redistort")]
pub struct DistortMap<D = Brown> {
    camera: CentralCamera<Gnomonic, D>,
}

impl<D: Distortion> DistortMap<D> {
    /// The lens of a camera; ideal pixels are those of its [`interior`](CentralCamera::interior).
    #[must_use]
    pub fn new(camera: CentralCamera<Gnomonic, D>) -> Self {
        Self { camera }
    }

    /// The camera whose lens it is.
    #[must_use]
    pub fn camera(&self) -> &CentralCamera<Gnomonic, D> {
        &self.camera
    }
}

impl<D: Distortion> Map for DistortMap<D> {
    #[inline]
    fn at(&self, ideal: &Point2<f64>) -> Result<Point2<f64>, ProjectionError> {
        let interior = self.camera.interior();
        let normalised = interior.normalised_from_pixel(ideal);
        let distorted = self.camera.distortion().distort(&normalised)?;
        Ok(interior.pixel_from_normalised(&distorted))
    }

    fn jacobian(&self, ideal: &Point2<f64>) -> Result<Matrix2<f64>, ProjectionError> {
        let interior = self.camera.interior();
        let normalised = interior.normalised_from_pixel(ideal);
        let (_, by_ideal) = self.camera.distortion().distort_jacobian(&normalised)?;
        Ok(interior.conjugate(&by_ideal))
    }
}

/// The map into a photograph taken through a lens: \[WD\] eq. 1 into the ideal picture, then the lens.
///
/// # Example
/// A camera 100 m above a field, c = 1000 px and k₁ = −0.1, textures a map of the field at 1 m a pixel. What lies 10 m to
/// the east is 1000 · 0.1 (1 − 0.1 · 0.1²) = 99.9 px to the right of the principal point:
///
/// ```
/// use collinear::camera::{Brown, BrownCamera, ExteriorOrientation, Frame, InteriorOrientation, Orthographic};
/// use collinear::geometry::{Affine2, Plane};
/// use collinear::mapping::{Map, PhotographMap};
/// use nalgebra::{Point2, Point3, Vector3};
///
/// let above = ExteriorOrientation::look_at(Point3::new(0.0, 0.0, 100.0), Point3::origin(), Vector3::y())?;
/// let interior = InteriorOrientation::new([1000.0; 2], Point2::new(640.0, 480.0), 0.0)?;
/// let photograph = Frame::new(above, BrownCamera::new(interior, Brown::new([-0.1, 0.0, 0.0], [0.0; 2])?));
/// let field = Plane::from_point_and_normal(Point3::origin(), Vector3::z())?;
/// let screen = Orthographic::new(above, Affine2::identity())?;
/// let map = PhotographMap::from_plane(&field, &photograph, &screen.homogeneous())?;
/// assert!((map.at(&Point2::new(10.0, 0.0))? - Point2::new(739.9, 480.0)).norm() < 1e-10);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub type PhotographMap<D = Brown> = Composed<DistortMap<D>, FractionalLinear>;

impl<D: Distortion> PhotographMap<D> {
    /// The map that a plane, a photograph and a screen share.
    ///
    /// # Errors
    /// As [`FractionalLinear::from_plane`].
    pub fn from_plane(
        plane: &Plane,
        photograph: &Frame<CentralCamera<Gnomonic, D>>,
        screen: &HomogeneousCamera,
    ) -> Result<Self, Error> {
        let inner = FractionalLinear::from_plane(plane, &photograph.ideal().homogeneous(), screen)?;
        Ok(Self { outer: DistortMap::new(photograph.camera), inner })
    }
}

/// From the picture a camera takes to its ideal picture: pixel → undistorted pixel. The inverse of [`DistortMap`].
///
/// *Domain.* Pixels that an ideal point within the fold radius has for its image. *Accuracy.* As
/// [`Distortion::undistort`]; a few Newton steps a pixel.
///
/// # Example
/// OpenCV 5.0.0's `projectPoints` puts (0.31, −0.22, 1) at this pixel (half a pixel on, as its centres are integers);
/// without the lens it would be at 320 + 310, 240 − 220:
///
/// ```
/// use collinear::camera::{Brown, BrownCamera, InteriorOrientation};
/// use collinear::mapping::{Map, UndistortMap};
/// use nalgebra::Point2;
///
/// let interior = InteriorOrientation::from_opencv(1000.0, 1000.0, 319.5, 239.5)?;
/// let lens = Brown::new([-0.28, 0.07, 0.002], [1e-3, -5e-4])?;
/// let map = UndistortMap::new(BrownCamera::new(interior, lens));
/// let ideal = map.at(&Point2::new(617.6076220865975, 28.88781658370502))?;
/// assert!((ideal - Point2::new(630.0, 20.0)).norm() < 1e-11);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[doc(alias = "undistort")]
pub struct UndistortMap<D = Brown> {
    camera: CentralCamera<Gnomonic, D>,
}

impl<D: Distortion> UndistortMap<D> {
    /// The lens of a camera, undone.
    #[must_use]
    pub fn new(camera: CentralCamera<Gnomonic, D>) -> Self {
        Self { camera }
    }
}

impl<D: Distortion> Map for UndistortMap<D> {
    fn at(&self, photograph: &Point2<f64>) -> Result<Point2<f64>, ProjectionError> {
        let interior = self.camera.interior();
        let distorted = interior.normalised_from_pixel(photograph);
        let ideal = self.camera.distortion().undistort(&distorted)?.point;
        Ok(interior.pixel_from_normalised(&ideal))
    }

    fn jacobian(&self, photograph: &Point2<f64>) -> Result<Matrix2<f64>, ProjectionError> {
        let interior = self.camera.interior();
        let distorted = interior.normalised_from_pixel(photograph);
        let ideal = self.camera.distortion().undistort(&distorted)?.point;
        let (_, by_ideal) = self.camera.distortion().distort_jacobian(&ideal)?;
        let inverse = by_ideal.try_inverse().ok_or(ProjectionError::OutsideDomain {
            value: ideal.coords.norm(),
            limit: self.camera.distortion().fold_radius(),
        })?;
        Ok(interior.conjugate(&inverse))
    }
}
