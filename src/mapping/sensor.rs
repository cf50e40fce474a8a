//! One sensor's picture from another's, through a surface.

use nalgebra::{Matrix2, Matrix2x3, Point2, Point3};

use super::Map;
use crate::camera::{ExteriorOrientation, Frame, SensorModel};
use crate::error::{Error, ProjectionError};
use crate::geometry::{Sphere, Surface, axes};

/// From the pixels of any sensor to those of any other, through a surface of the world.
///
#[doc = include_str!("../../docs/figures/lenses/output_models.svg")]
///
/// # Equation
/// ```text
/// world = screen.ground(S, L; surface),   (u, v) = texture.project(world)
/// ∂(u, v)/∂(S, L) = B A⁻¹,   A = ∂(S, L)/∂X · (e₁ e₂),   B = ∂(u, v)/∂X · (e₁ e₂)
/// ```
/// e₁ and e₂ span the surface's tangent plane. \[WD\] eq. 4b into the world and eq. 4a out of it, for sensors that need not be
/// perspective: with a plane and two frame cameras it is \[WD\] eq. 1, for which [`FractionalLinear`](super::FractionalLinear) is the quick way.
///
/// # What it is for
/// | screen | surface | texture | gives |
/// | --- | --- | --- | --- |
/// | fisheye, panorama, scanner | the ground, a wall | a photograph | the photograph as that sensor would have it |
/// | any central camera | none: [`distant`](Self::distant) | a panorama of the same place | a dome master, a cylinder, a view |
/// | a projector | the dome it shines on ([`Dome`](crate::geometry::Dome), [`TriangleMesh`](crate::geometry::TriangleMesh)) | a picture for the eye point | the projector's picture, pre-warped (\[WD\] "prewarp the output images so they project naturally onto domes") |
///
/// # Domain
/// Pixels whose line of sight meets the surface in front of the screen's sensor where the texture's sensor sees it. Of a surface that
/// can hide itself, as a sphere seen from outside, the hidden part has the texture of what hides it, unless the map is
/// [`hiding`](Self::hiding) it.
///
/// # Example
/// A dome of radius 10, the eye at its centre, a fisheye picture of c = 600 px for it, and a projector below the front of the rim that shines
/// on the dome's back. What the eye is to see at the zenith, the projector shows where the zenith images in it:
///
/// ```
/// use collinear::camera::{CentralCamera, ExteriorOrientation, Fisheye, Frame, InteriorOrientation, SensorModel};
/// use collinear::geometry::Dome;
/// use collinear::mapping::{Map, SensorMap};
/// use nalgebra::{Point2, Point3, Vector3};
///
/// let dome = Dome::new(Point3::origin(), 10.0, Vector3::z(), 90f64.to_radians())?;
/// let up = ExteriorOrientation::look_at(Point3::origin(), Point3::new(0.0, 0.0, 1.0), Vector3::y())?;
/// let master = InteriorOrientation::new([600.0; 2], Point2::new(950.0, 950.0), 0.0)?;
/// let master = Frame::new(up, CentralCamera::ideal(master, Fisheye::Equidistant));
/// let place = Point3::new(0.0, -9.0, -1.0);
/// let projector = ExteriorOrientation::look_at(place, Point3::new(0.0, 0.0, 10.0), Vector3::z())?;
/// let projector = Frame::new(projector, InteriorOrientation::new([1500.0; 2], Point2::new(960.0, 540.0), 0.0)?);
///
/// let prewarp = SensorMap::new(projector, dome, master);
/// assert!((prewarp.at(&Point2::new(960.0, 540.0))? - Point2::new(950.0, 950.0)).norm() < 1e-11);
/// // 45° from the zenith towards the back: 600 π/4 px, wherever the projector has it.
/// let back = projector.project(&Point3::new(0.0, 50f64.sqrt(), 50f64.sqrt()))?;
/// let in_master = prewarp.at(&back)?;
/// assert!(((in_master - Point2::new(950.0, 950.0)).norm() - 471.23889803846896).abs() < 1e-10);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
#[doc(alias("reproject", "prewarp", "dome correction", "projection mapping"))]
pub struct SensorMap<S, U, T> {
    screen: S,
    surface: U,
    texture: T,
    tolerance: Option<f64>,
}

impl<S, U, T> SensorMap<S, U, T> {
    /// From the sensor whose pixels are asked for, the surface that it shows, and the sensor of the picture.
    #[must_use]
    pub fn new(screen: S, surface: U, texture: T) -> Self {
        Self { screen, surface, texture, tolerance: None }
    }

    /// The same map without what the surface itself hides from the texture's sensor: points whose own pixel shows another point,
    /// farther than `tolerance` world units from them. It costs another search of the surface for each pixel.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] for a tolerance that is not positive.
    ///
    /// # Example
    /// A globe of radius 1, photographed from the right. From the front its left half is seen, which the photograph does not show:
    ///
    /// ```
    /// use collinear::ProjectionError;
    /// use collinear::camera::{ExteriorOrientation, Frame, InteriorOrientation};
    /// use collinear::geometry::Sphere;
    /// use collinear::mapping::{Map, SensorMap};
    /// use nalgebra::{Point2, Point3, Vector3};
    ///
    /// let from = |x, y| {
    ///     let exterior = ExteriorOrientation::look_at(Point3::new(x, y, 0.0), Point3::origin(), Vector3::z())?;
    ///     Ok::<_, collinear::Error>(Frame::new(exterior, InteriorOrientation::new([100.0; 2], Point2::origin(), 0.0)?))
    /// };
    /// let map = SensorMap::new(from(0.0, -9.0)?, Sphere::new(Point3::origin(), 1.0)?, from(9.0, 0.0)?).hiding(1e-6)?;
    /// // The right edge of the globe as the view has it, the middle of the photograph; and the left one.
    /// assert!(map.at(&Point2::new(11.0, 0.0)).is_ok());
    /// assert!(matches!(map.at(&Point2::new(-11.0, 0.0)), Err(ProjectionError::Hidden { .. })));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn hiding(self, tolerance: f64) -> Result<Self, Error> {
        if !(tolerance > 0.0 && tolerance.is_finite()) {
            let (what, expected) = ("tolerance of a point seen twice", "a finite length above 0");
            return Err(Error::OutOfRange { what, value: tolerance, expected });
        }
        Ok(Self { tolerance: Some(tolerance), ..self })
    }

    /// The sensor whose pixels are asked for.
    #[must_use]
    pub fn screen(&self) -> &S {
        &self.screen
    }

    /// The surface.
    #[must_use]
    pub fn surface(&self) -> &U {
        &self.surface
    }

    /// The sensor of the picture.
    #[must_use]
    pub fn texture(&self) -> &T {
        &self.texture
    }
}

impl<S, T> SensorMap<Frame<S>, Sphere, Frame<T>> {
    /// Between two cameras of one place, or of a world so far away that the distance of their places is nothing: only their rotations count.
    ///
    /// # Example
    /// What a panorama of 4000 × 2000 px has a quarter turn to the right of its middle is the middle of a view to the east:
    ///
    /// ```
    /// use collinear::camera::{CentralCamera, ExteriorOrientation, Frame, InteriorOrientation, Panorama};
    /// use collinear::mapping::{Map, SensorMap};
    /// use nalgebra::{Point2, Point3, Vector3};
    ///
    /// let towards = |x, y| ExteriorOrientation::look_at(Point3::origin(), Point3::new(x, y, 0.0), Vector3::z());
    /// let panorama = InteriorOrientation::from_whole_panorama(4000.0, 2000.0)?;
    /// let panorama = Frame::new(towards(0.0, 1.0)?, CentralCamera::ideal(panorama, Panorama::Equirectangular));
    /// let view = Frame::new(towards(1.0, 0.0)?, InteriorOrientation::new([500.0; 2], Point2::new(500.0, 300.0), 0.0)?);
    /// let map = SensorMap::distant(view, panorama);
    /// assert!((map.at(&Point2::new(500.0, 300.0))? - Point2::new(3000.0, 1000.0)).norm() < 1e-11);
    /// // 45° further right.
    /// assert!((map.at(&Point2::new(1000.0, 300.0))? - Point2::new(3500.0, 1000.0)).norm() < 1e-11);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[must_use]
    #[doc(alias("rotation homography", "stitch"))]
    pub fn distant(screen: Frame<S>, texture: Frame<T>) -> Self {
        let moved = |exterior: &ExteriorOrientation| {
            ExteriorOrientation::new(Point3::origin(), exterior.camera_from_world())
        };
        let screen = Frame::new(moved(&screen.exterior), screen.camera);
        let texture = Frame::new(moved(&texture.exterior), texture.camera);
        Self::new(screen, Sphere::UNIT, texture)
    }
}

impl<S: SensorModel, U: Surface, T: SensorModel> SensorMap<S, U, T> {
    /// The point of the surface that a pixel shows, and its pixel in the texture.
    fn meet(&self, screen: &Point2<f64>) -> Result<(Point3<f64>, Point2<f64>), ProjectionError> {
        let world = self.screen.ground(screen, &self.surface)?;
        let texture = self.texture.project(&world)?;
        if let Some(tolerance) = self.tolerance {
            let seen = self.texture.ground(&texture, &self.surface)?;
            let distance = (seen - world).norm();
            if !(distance <= tolerance) {
                return Err(ProjectionError::Hidden { distance });
            }
        }
        Ok((world, texture))
    }
}

impl<S: SensorModel, U: Surface, T: SensorModel> Map for SensorMap<S, U, T> {
    fn at(&self, screen: &Point2<f64>) -> Result<Point2<f64>, ProjectionError> {
        self.meet(screen).map(|(_, texture)| texture)
    }

    fn jacobian(&self, screen: &Point2<f64>) -> Result<Matrix2<f64>, ProjectionError> {
        let (world, _) = self.meet(screen)?;
        let frame = axes(&self.surface.normal(&world)?);
        let along = |by_world: Matrix2x3<f64>| by_world * frame.matrix().fixed_columns::<2>(0);
        let by_screen = along(self.screen.project_jacobian(&world)?.1);
        let by_texture = along(self.texture.project_jacobian(&world)?.1);
        // Where the line of sight only touches the surface there is none.
        let inverse = by_screen.try_inverse().ok_or(ProjectionError::NotFinite)?;
        let jacobian = by_texture * inverse;
        if jacobian.iter().all(|e| e.is_finite()) {
            Ok(jacobian)
        } else {
            Err(ProjectionError::NotFinite)
        }
    }
}
