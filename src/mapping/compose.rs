//! One map after another, and the lens as a map.

use nalgebra::{Matrix2, Point2};

use super::{FractionalLinear, Map};
use crate::camera::{BrownCamera, Frame, HomogeneousCamera};
use crate::error::{Error, ProjectionError};
use crate::geometry::Plane;

/// The map `outer` after `inner`: outer(inner(screen)).
///
/// The Jacobian is the product of both (chain rule), and a point is valid where both are.
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
/// \[WD\] eq. 1 leads into the ideal picture; behind it, as [`Composed::outer`], this map leads into the photograph.
#[derive(Clone, Copy, Debug, PartialEq)]
#[doc(alias = "redistort")]
pub struct DistortMap {
    camera: BrownCamera,
}

impl DistortMap {
    /// The lens of a camera; ideal pixels are those of its [`interior`](BrownCamera::interior).
    #[must_use]
    pub fn new(camera: BrownCamera) -> Self {
        Self { camera }
    }
}

impl Map for DistortMap {
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
pub type PhotographMap = Composed<DistortMap, FractionalLinear>;

impl PhotographMap {
    /// The map that a plane, a photograph and a screen share.
    ///
    /// # Errors
    /// As [`FractionalLinear::from_plane`].
    pub fn from_plane(
        plane: &Plane,
        photograph: &Frame<BrownCamera>,
        screen: &HomogeneousCamera,
    ) -> Result<Self, Error> {
        let inner = FractionalLinear::from_plane(plane, &photograph.ideal().homogeneous(), screen)?;
        Ok(Self { outer: DistortMap::new(photograph.camera), inner })
    }
}

/// From the picture a camera takes to its ideal picture: pixel → undistorted pixel.
#[derive(Clone, Copy, Debug, PartialEq)]
#[doc(alias = "undistort")]
pub struct UndistortMap {
    camera: BrownCamera,
}

impl UndistortMap {
    /// The lens of a camera, undone.
    #[must_use]
    pub fn new(camera: BrownCamera) -> Self {
        Self { camera }
    }
}

impl Map for UndistortMap {
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
