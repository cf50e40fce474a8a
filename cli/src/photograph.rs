//! A photograph's camera as what a plane map needs.

use anyhow::{Error, anyhow};
use collinear::camera::{Brown, BrownCamera, HomogeneousCamera};
use collinear::error::Brief;
use collinear::geometry::Plane;
use collinear::mapping::{Composed, DistortMap, FractionalLinear, Map};
use collinear_io::convert::Camera;

/// A plane's map into a photograph: into the ideal picture, and from there through the lens.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PlaneMap {
    pub(crate) linear: FractionalLinear,
    pub(crate) lens: Option<BrownCamera>,
}

impl PlaneMap {
    /// The map that a plane, a photograph and a screen share. The plane is clear of the screen's eye.
    pub(crate) fn new(
        plane: &Plane,
        photograph: &Camera,
        screen: &HomogeneousCamera,
    ) -> Result<Self, Error> {
        let ideal = match photograph {
            Camera::Pinhole(frame) => frame.homogeneous(),
            Camera::Brown(frame) => frame.ideal().homogeneous(),
            Camera::Orthographic(camera) => camera.homogeneous(),
        };
        let linear = FractionalLinear::from_plane(plane, &ideal, screen)
            .map_err(|e| in_user_words(e, photograph))?;
        Ok(Self { linear, lens: lens(photograph) })
    }

    /// The whole as one map; a fractional-linear one where there is no lens.
    pub(crate) fn boxed(self) -> Box<dyn Map> {
        match self.lens {
            Some(camera) => {
                Box::new(Composed { outer: DistortMap::new(camera), inner: self.linear })
            }
            None => Box::new(self.linear),
        }
    }
}

/// What a plane without a map has to do with its photograph.
fn in_user_words(error: collinear::Error, photograph: &Camera) -> Error {
    match (error, photograph) {
        (collinear::Error::Degenerate { measure, .. }, Camera::Pinhole(_) | Camera::Brown(_)) => {
            anyhow!(
                "the camera lies in the plane and sees it as a line: its projection centre is {} off it",
                Brief(measure)
            )
        }
        (collinear::Error::Degenerate { measure, .. }, Camera::Orthographic(_)) => anyhow!(
            "the camera looks along the plane and sees it as a line: the sine of their angle is {}",
            Brief(measure)
        ),
        (other, _) => other.into(),
    }
}

/// The lens of a camera, where it does anything.
pub(crate) fn lens(camera: &Camera) -> Option<BrownCamera> {
    match camera {
        Camera::Brown(frame) => Some(frame.camera).filter(|c| *c.distortion() != Brown::none()),
        Camera::Pinhole(_) | Camera::Orthographic(_) => None,
    }
}
