//! A photograph's camera as what a plane map needs.

use anyhow::{Error, anyhow};
use collinear::ProjectionError;
use collinear::camera::{
    Brown, BrownCamera, CentralModel, ExteriorOrientation, Frame, HomogeneousCamera,
    InteriorOrientation, Orthographic,
};
use collinear::error::Brief;
use collinear::geometry::{Affine2, Homography, Plane};
use collinear::mapping::{Composed, DistortMap, FractionalLinear, Map, UndistortMap};
use collinear::nalgebra::{
    Matrix2, Matrix3, Matrix3x2, Point2, Rotation3, UnitVector3, Vector2, Vector3,
};
use collinear_io::convert::{Camera, Central};

/// A plane's map into a photograph.
#[derive(Clone, Debug)]
pub(crate) enum PlaneMap {
    /// The whole of it is a homography.
    Linear(FractionalLinear),
    /// Into the ideal picture, and from there through Brown's lens.
    Brown(Composed<DistortMap, FractionalLinear>),
    /// To a plane of directions, and from there through any central model.
    Central(Composed<Directions, FractionalLinear>),
}

impl PlaneMap {
    /// The map that a plane, a photograph and a screen share. The plane is clear of the screen's eye.
    pub(crate) fn new(
        plane: &Plane,
        photograph: &Camera,
        screen: &HomogeneousCamera,
    ) -> Result<Self, Error> {
        let to = |texture: &HomogeneousCamera| {
            FractionalLinear::from_plane(plane, texture, screen)
                .map_err(|e| in_user_words(e, photograph))
        };
        Ok(match photograph {
            Camera::Pinhole(frame) => Self::Linear(to(&frame.homogeneous())?),
            Camera::Orthographic(camera) => Self::Linear(to(&camera.homogeneous())?),
            Camera::Brown(frame) => {
                let inner = to(&frame.ideal().homogeneous())?;
                match brown(&frame.camera) {
                    Some(lens) => Self::Brown(Composed { outer: DistortMap::new(lens), inner }),
                    None => Self::Linear(inner),
                }
            }
            Camera::Central(frame) => {
                // A pinhole in the camera's place says whether the plane is clear of it.
                let pinhole = InteriorOrientation::new([1.0; 2], Point2::origin(), 0.0)?;
                to(&Frame::new(frame.exterior, pinhole).homogeneous())?;
                let (outer, coordinates) = Directions::of_plane(plane, frame)?;
                Self::Central(Composed { outer, inner: to(&coordinates.homogeneous())? })
            }
        })
    }

    /// The map of a rectangle's corners to those of a quadrilateral of a photograph, through its lens; and whether the
    /// quadrilateral is mirrored.
    pub(crate) fn of_quad(
        sides: &[Point2<f64>; 4],
        corners: &[Point2<f64>; 4],
        photograph: Option<&Camera>,
    ) -> Result<(Self, bool), Error> {
        let linear = |corners: &[Point2<f64>; 4]| -> Result<_, Error> {
            let homography = Homography::from_quads(sides, corners)?;
            let mirrored = homography.matrix().determinant() < 0.0;
            Ok((FractionalLinear::from_homography(&homography), mirrored))
        };
        let lens = match photograph {
            Some(Camera::Brown(frame)) => brown(&frame.camera),
            _ => None,
        };
        if let Some(lens) = lens {
            let undistort = UndistortMap::new(lens);
            let (inner, mirrored) = linear(&each(corners, |c| undistort.at(c))?)?;
            return Ok((Self::Brown(Composed { outer: DistortMap::new(lens), inner }), mirrored));
        }
        if let Some(Camera::Central(frame)) = photograph {
            let outer = Directions::ahead(frame.camera.clone());
            let (inner, mirrored) = linear(&each(corners, |c| outer.ideal(c))?)?;
            return Ok((Self::Central(Composed { outer, inner }), mirrored));
        }
        linear(corners).map(|(inner, mirrored)| (Self::Linear(inner), mirrored))
    }

    /// The homography into the ideal picture of the photograph, where the camera has one.
    pub(crate) fn homography(&self) -> Result<Option<Homography>, collinear::Error> {
        match self {
            Self::Linear(linear) => linear.homography().map(Some),
            Self::Brown(map) => map.inner.homography().map(Some),
            Self::Central(_) => Ok(None),
        }
    }

    /// Whether the map is more than a homography.
    pub(crate) fn through_lens(&self) -> bool {
        !matches!(self, Self::Linear(_))
    }

    pub(crate) fn boxed(self) -> Box<dyn Map> {
        match self {
            Self::Linear(map) => Box::new(map),
            Self::Brown(map) => Box::new(map),
            Self::Central(map) => Box::new(map),
        }
    }
}

/// The ideal corners.
fn each(
    corners: &[Point2<f64>; 4],
    ideal: impl Fn(&Point2<f64>) -> Result<Point2<f64>, ProjectionError>,
) -> Result<[Point2<f64>; 4], Error> {
    let mut found = *corners;
    for c in &mut found {
        *c = ideal(c).map_err(|e| anyhow!("corner ({}, {}): {e}", Brief(c.x), Brief(c.y)))?;
    }
    Ok(found)
}

/// From the coordinates (x, y) of a plane to the image of the direction `origin` + x `right` + y `down` in camera axes.
#[derive(Clone, Debug)]
pub(crate) struct Directions {
    origin: Vector3<f64>,
    axes: Matrix3x2<f64>,
    camera: Central,
}

impl Directions {
    /// Of a plane of the world, with the parallel projection to its coordinates. Their origin is the foot of the projection
    /// centre, so that nothing is lost where both are far from the world's.
    fn of_plane(plane: &Plane, frame: &Frame<Central>) -> Result<(Self, Orthographic), Error> {
        let center = frame.exterior.projection_center();
        let world_from_plane = axes(&plane.normal());
        let foot = plane.foot(&center);
        let exterior = ExteriorOrientation::new(foot, world_from_plane.inverse());
        let coordinates = Orthographic::new(exterior, Affine2::identity())?;
        let rotation = frame.exterior.camera_from_world();
        let camera_from_plane = (rotation * world_from_plane).into_inner();
        let axes = camera_from_plane.fixed_columns::<2>(0).into_owned();
        let distance = plane.signed_distance(&center);
        let origin = -(rotation * plane.normal().into_inner()) * distance;
        Ok((Self { origin, axes, camera: frame.camera.clone() }, coordinates))
    }

    /// Of the plane one before the camera: (x, y) is (X/Z, Y/Z).
    fn ahead(camera: Central) -> Self {
        let axes = Matrix3x2::from_columns(&[Vector3::x(), Vector3::y()]);
        Self { origin: Vector3::z(), axes, camera }
    }

    /// (X/Z, Y/Z) of an image point.
    fn ideal(&self, image: &Point2<f64>) -> Result<Point2<f64>, ProjectionError> {
        let d = self.camera.direction(image)?;
        if d.z > 0.0 {
            Ok(Point2::from(d.xy() / d.z))
        } else {
            Err(ProjectionError::BehindCamera { depth: d.z })
        }
    }

    fn direction(&self, plane: &Vector2<f64>) -> Vector3<f64> {
        self.origin + self.axes * plane
    }
}

impl Map for Directions {
    fn at(&self, plane: &Point2<f64>) -> Result<Point2<f64>, ProjectionError> {
        self.camera.project_direction(&self.direction(&plane.coords))
    }

    fn jacobian(&self, plane: &Point2<f64>) -> Result<Matrix2<f64>, ProjectionError> {
        let direction = self.direction(&plane.coords);
        Ok(self.camera.project_direction_jacobian(&direction)?.1 * self.axes)
    }
}

/// Right-handed axes of which the third is this one, as columns.
fn axes(third: &UnitVector3<f64>) -> Rotation3<f64> {
    let across = Vector3::ith(third.iamin(), 1.0);
    let first = third.cross(&across).normalize();
    let columns = [first, third.cross(&first), third.into_inner()];
    Rotation3::from_matrix_unchecked(Matrix3::from_columns(&columns))
}

/// What a plane without a map has to do with its photograph.
fn in_user_words(error: collinear::Error, photograph: &Camera) -> Error {
    match (error, photograph) {
        (collinear::Error::Degenerate { measure, .. }, Camera::Orthographic(_)) => anyhow!(
            "the camera looks along the plane and sees it as a line: the sine of their angle is {}",
            Brief(measure)
        ),
        (collinear::Error::Degenerate { measure, .. }, _) => anyhow!(
            "the camera lies in the plane and sees it as a line: its projection centre is {} off it",
            Brief(measure)
        ),
        (other, _) => other.into(),
    }
}

/// A lens that does anything.
fn brown(camera: &BrownCamera) -> Option<BrownCamera> {
    Some(*camera).filter(|c| *c.distortion() != Brown::none())
}
