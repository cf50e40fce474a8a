//! A photograph's camera or scanner as what a plane map needs.

use std::sync::Arc;

use anyhow::{Error, anyhow};
use collinear::ProjectionError;
use collinear::camera::{Brown, BrownCamera, CentralModel, Frame, HomogeneousCamera, SensorModel};
use collinear::error::Brief;
use collinear::geometry::{Homography, Locus, Plane, Ray};
use collinear::mapping::{
    CentralMap, CentralPhotographMap, Composed, DistortMap, FractionalLinear, Map, PhotographMap,
    SensorMap, UndistortMap,
};
use collinear::nalgebra::{Point2, Point3};
use collinear_io::convert::{Camera, Central};
use collinear_io::sensor::SensorFile;

/// What a photograph was taken with.
#[derive(Clone, Debug)]
pub(crate) enum Photograph {
    /// A camera, of whose models some have quicker maps than others.
    Camera(Box<Camera>),
    /// A sensor of any other kind.
    Other(Arc<dyn SensorModel>),
}

impl Photograph {
    pub(crate) fn new(file: &SensorFile) -> Result<Self, collinear_io::Error> {
        Ok(match file {
            SensorFile::Camera(camera) => Self::Camera(Box::new(camera.camera()?)),
            SensorFile::Scanner(_) | SensorFile::Rpc(_) => Self::Other(file.sensor()?.into()),
        })
    }

    /// The camera, where it is one.
    pub(crate) fn camera(&self) -> Option<&Camera> {
        match self {
            Self::Camera(camera) => Some(camera),
            Self::Other(_) => None,
        }
    }

    pub(crate) fn sensor(&self) -> &dyn SensorModel {
        match self {
            Self::Camera(camera) => camera.sensor(),
            Self::Other(sensor) => sensor,
        }
    }

    pub(crate) fn into_sensor(self) -> Arc<dyn SensorModel> {
        match self {
            Self::Camera(camera) => camera.into_sensor().into(),
            Self::Other(sensor) => sensor,
        }
    }

    /// As a camera of one projection centre, where it is one.
    pub(crate) fn into_central(self) -> Option<Frame<Arc<dyn CentralModel>>> {
        let Self::Camera(camera) = self else { return None };
        Some(match *camera {
            Camera::Pinhole(f) => Frame::new(f.exterior, Arc::new(f.camera)),
            Camera::Brown(f) => Frame::new(f.exterior, Arc::new(f.camera)),
            Camera::Central(f) => Frame::new(f.exterior, f.camera),
            Camera::Orthographic(_) => return None,
        })
    }

    /// The line of sight in the middle of the picture, where it has one.
    pub(crate) fn middle(&self, size: [u32; 2]) -> Option<Ray> {
        let [x, y] = size.map(|s| 0.5 * f64::from(s));
        match self.sensor().locus(&Point2::new(x, y)) {
            Ok(Locus::Ray(ray)) => Some(ray),
            _ => None,
        }
    }

    /// A camera's projection centre; of other sensors where the middle line of sight begins.
    pub(crate) fn eye(&self, size: [u32; 2]) -> Option<Point3<f64>> {
        let exterior = match self.camera() {
            Some(Camera::Pinhole(frame)) => frame.exterior,
            Some(Camera::Brown(frame)) => frame.exterior,
            Some(Camera::Central(frame)) => frame.exterior,
            Some(Camera::Orthographic(_)) | None => {
                return self.middle(size).map(|ray| ray.origin);
            }
        };
        Some(exterior.projection_center())
    }
}

/// A plane's map into a photograph.
#[derive(Clone, Debug)]
pub(crate) enum PlaneMap {
    /// The whole of it is a homography.
    Linear(FractionalLinear),
    /// Into the ideal picture, and from there through Brown's lens.
    Brown(PhotographMap),
    /// To a plane of directions, and from there through any central model.
    Central(CentralPhotographMap<Central>),
    /// Point by point through any sensor.
    Other(SensorMap<HomogeneousCamera, Plane, Arc<dyn SensorModel>>),
}

impl PlaneMap {
    /// The map that a plane, a photograph and a screen share. The plane is clear of the screen's eye.
    pub(crate) fn new(
        plane: &Plane,
        photograph: &Photograph,
        screen: &HomogeneousCamera,
    ) -> Result<Self, Error> {
        let photograph = match photograph {
            Photograph::Camera(camera) => camera.as_ref(),
            Photograph::Other(sensor) => {
                return Ok(Self::Other(SensorMap::new(*screen, *plane, Arc::clone(sensor))));
            }
        };
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
            Camera::Central(frame) => Self::Central(
                CentralPhotographMap::from_plane(plane, frame, screen)
                    .map_err(|e| in_user_words(e, photograph))?,
            ),
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
            let outer = CentralMap::ahead(frame.camera.clone());
            let (inner, mirrored) = linear(&each(corners, |c| outer.plane_point(c))?)?;
            return Ok((Self::Central(Composed { outer, inner }), mirrored));
        }
        linear(corners).map(|(inner, mirrored)| (Self::Linear(inner), mirrored))
    }

    /// The homography into the ideal picture of the photograph, where the camera has one.
    pub(crate) fn homography(&self) -> Result<Option<Homography>, collinear::Error> {
        match self {
            Self::Linear(linear) => linear.homography().map(Some),
            Self::Brown(map) => map.inner.homography().map(Some),
            Self::Central(_) | Self::Other(_) => Ok(None),
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
            Self::Other(map) => Box::new(map),
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
