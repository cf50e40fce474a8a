//! A photograph's camera as what a plane map needs.

use collinear::camera::{Brown, BrownCamera, HomogeneousCamera};
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
    /// The map that a plane, a photograph and a screen share.
    pub(crate) fn new(
        plane: &Plane,
        photograph: &Camera,
        screen: &HomogeneousCamera,
    ) -> Result<Self, collinear::Error> {
        let ideal = match photograph {
            Camera::Pinhole(frame) => frame.homogeneous(),
            Camera::Brown(frame) => frame.ideal().homogeneous(),
            Camera::Orthographic(camera) => camera.homogeneous(),
        };
        let linear = FractionalLinear::from_plane(plane, &ideal, screen)?;
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

/// The lens of a camera, where it does anything.
pub(crate) fn lens(camera: &Camera) -> Option<BrownCamera> {
    match camera {
        Camera::Brown(frame) => Some(frame.camera).filter(|c| *c.distortion() != Brown::none()),
        Camera::Pinhole(_) | Camera::Orthographic(_) => None,
    }
}
