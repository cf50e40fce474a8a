//! A block of photographs, its points and what was measured.

use alloc::vec::Vec;

use nalgebra::{Matrix3, Point2, Point3, Rotation3, Vector3};

use crate::adjust::Precision;
use crate::adjust::unknowns::{Columns, Unknown};
use crate::camera::{Adjustable, CentralModel, ExteriorOrientation};
use crate::error::Error;
use crate::numeric::float;

/// A camera of a [`Bundle`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct CameraId(pub(super) u32);

/// A photograph of a [`Bundle`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct ImageId(pub(super) u32);

/// An object point of a [`Bundle`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct PointId(pub(super) u32);

macro_rules! number {
    ($($id:ty, $what:literal);*) => {$(
        impl $id {
            #[doc = concat!("The number of the ", $what, ", from 0 in the order in which they were added.")]
            #[must_use]
            pub fn number(self) -> usize {
                self.0 as usize
            }
        }
    )*};
}

number!(CameraId, "camera"; ImageId, "photograph"; PointId, "point");

/// What is known of an object point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Kind {
    /// Nothing: the coordinates are approximate, or those of a check point.
    Pass,
    /// The coordinates are observations with this weight matrix.
    Control { given: Point3<f64>, weight: Matrix3<f64> },
    /// The coordinates are exact.
    Fixed,
}

#[derive(Clone, Debug)]
pub(super) struct Camera<C> {
    pub(super) model: C,
    pub(super) columns: Columns,
}

#[derive(Clone, Debug)]
pub(super) struct Image {
    pub(super) exterior: ExteriorOrientation,
    pub(super) camera: u32,
    pub(super) held: bool,
    pub(super) position: Option<Position>,
    pub(super) attitude: Option<Attitude>,
}

/// An observed position of an antenna.
#[derive(Clone, Copy, Debug)]
pub(super) struct Position {
    pub(super) given: Point3<f64>,
    pub(super) lever: Vector3<f64>,
    pub(super) weight: Matrix3<f64>,
}

/// An observed camera_from_world.
#[derive(Clone, Copy, Debug)]
pub(super) struct Attitude {
    pub(super) given: Rotation3<f64>,
    pub(super) weight: Matrix3<f64>,
}

#[derive(Clone, Copy, Debug)]
pub(super) struct Object {
    pub(super) start: Point3<f64>,
    pub(super) kind: Kind,
}

/// An observed image point.
#[derive(Clone, Copy, Debug)]
pub(super) struct Seen {
    pub(super) image: u32,
    pub(super) point: u32,
    pub(super) at: Point2<f64>,
    /// Its place in the list of precisions.
    pub(super) precision: u32,
}

/// An observed distance of two points.
#[derive(Clone, Copy, Debug)]
pub(super) struct Distance {
    pub(super) ends: [u32; 2],
    pub(super) length: f64,
    pub(super) weight: f64,
}

/// A block of photographs: cameras, exterior orientations, object points and what was measured of them.
///
/// Everything has approximate values, which [`adjust`](Self::adjust) improves. A camera may belong to one photograph or to
/// many; which of its parameters are unknown is said when it is added. The unknowns of a photograph are its centre and a
/// left rotation vector. The example at [`bundle`](crate::adjust::bundle) is a whole adjustment.
#[derive(Clone, Debug)]
#[doc(alias("BundleAdjustment", "block adjustment"))]
pub struct Bundle<C> {
    pub(super) cameras: Vec<Camera<C>>,
    pub(super) images: Vec<Image>,
    pub(super) points: Vec<Object>,
    pub(super) seen: Vec<Seen>,
    /// W = (w₁₁ 0; w₁₂ w₂₂) of the weight matrices P = WᵀW: w₁₁, w₁₂, w₂₂.
    pub(super) precisions: Vec<[f64; 3]>,
    pub(super) last_precision: Option<(Precision<2>, u32)>,
    pub(super) distances: Vec<Distance>,
}

impl<C> Default for Bundle<C> {
    fn default() -> Self {
        Self {
            cameras: Vec::new(),
            images: Vec::new(),
            points: Vec::new(),
            seen: Vec::new(),
            precisions: Vec::new(),
            last_precision: None,
            distances: Vec::new(),
        }
    }
}

/// The next number of a list.
fn next(what: &'static str, len: usize) -> Result<u32, Error> {
    u32::try_from(len).ok().filter(|n| *n < u32::MAX).ok_or(Error::OutOfRange {
        what,
        value: len as f64,
        expected: "less than 2³² − 1",
    })
}

/// The numbers of a list's entries, which [`next`] gave.
fn numbers(len: usize) -> core::ops::Range<u32> {
    0..u32::try_from(len).unwrap_or(u32::MAX)
}

fn all_finite(what: &'static str, point: &Point3<f64>) -> Result<(), Error> {
    if point.iter().all(|c| c.is_finite()) { Ok(()) } else { Err(Error::NotFinite { what }) }
}

fn there(what: &'static str, number: u32, len: usize) -> Result<(), Error> {
    if (number as usize) < len { Ok(()) } else { Err(Error::Unknown { what }) }
}

impl<C: CentralModel + Adjustable + Clone> Bundle<C> {
    /// An empty block.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// The cameras, in the order in which they were added.
    pub fn camera_ids(&self) -> impl ExactSizeIterator<Item = CameraId> + use<C> {
        numbers(self.cameras.len()).map(CameraId)
    }

    /// The photographs, in the order in which they were added.
    pub fn image_ids(&self) -> impl ExactSizeIterator<Item = ImageId> + use<C> {
        numbers(self.images.len()).map(ImageId)
    }

    /// The object points, in the order in which they were added.
    pub fn point_ids(&self) -> impl ExactSizeIterator<Item = PointId> + use<C> {
        numbers(self.points.len()).map(PointId)
    }

    /// The number of observed image points.
    #[must_use]
    pub fn observation_count(&self) -> usize {
        self.seen.len()
    }

    /// Adds a camera with its approximate model. The groups of `unknowns` are those of the central model: for a
    /// [`CentralCamera`](crate::camera::CentralCamera) group 0 is the interior orientation (fx, fy, x₀, y₀, s), then the
    /// projection's parameters and the lens's where there are any. What is not chosen is held.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] for a parameter that the camera does not have or that is chosen twice, or more than 24 unknowns.
    pub fn add_camera(&mut self, model: C, unknowns: &[Unknown]) -> Result<CameraId, Error> {
        let number = next("number of cameras", self.cameras.len())?;
        let columns = Columns::resolve(&model, unknowns)?;
        if columns.len() > super::MOST_OF_CAMERA || columns.lengths.len() > super::MOST_GROUPS {
            return Err(Error::OutOfRange {
                what: "number of unknowns of a camera",
                value: columns.len() as f64,
                expected: "at most 24 in 4 groups",
            });
        }
        self.cameras.push(Camera { model, columns });
        Ok(CameraId(number))
    }

    /// Adds a photograph with its approximate exterior orientation.
    ///
    /// # Errors
    /// [`Error::Unknown`] for a camera of another block, [`Error::NotFinite`].
    pub fn add_image(
        &mut self,
        exterior: ExteriorOrientation,
        camera: CameraId,
    ) -> Result<ImageId, Error> {
        let number = next("number of photographs", self.images.len())?;
        there("camera", camera.0, self.cameras.len())?;
        all_finite("projection centre", &exterior.projection_center())?;
        let (held, position, attitude) = (false, None, None);
        self.images.push(Image { exterior, camera: camera.0, held, position, attitude });
        Ok(ImageId(number))
    }

    /// Holds the exterior orientation of a photograph.
    ///
    /// # Errors
    /// [`Error::Unknown`].
    pub fn hold(&mut self, image: ImageId) -> Result<(), Error> {
        let image =
            self.images.get_mut(image.number()).ok_or(Error::Unknown { what: "photograph" })?;
        image.held = true;
        Ok(())
    }

    /// Gives a photograph the observed position of an antenna, as of a GNSS receiver, in world units.
    ///
    /// ```text
    /// G = C + Rᵀ a
    /// ```
    ///
    /// C is the projection centre and R the camera_from_world; the lever arm a leads from the centre to the antenna in camera axes.
    /// A second call replaces the first.
    ///
    /// # Errors
    /// [`Error::Unknown`], [`Error::NotFinite`], and those of [`Precision::weight`].
    #[doc(alias("GPS", "GNSS", "lever arm"))]
    pub fn observe_position(
        &mut self,
        image: ImageId,
        antenna: Point3<f64>,
        lever_arm: Vector3<f64>,
        precision: Precision<3>,
    ) -> Result<(), Error> {
        let image =
            self.images.get_mut(image.number()).ok_or(Error::Unknown { what: "photograph" })?;
        all_finite("antenna position", &antenna)?;
        all_finite("lever arm", &lever_arm.into())?;
        let weight = precision.weight()?;
        image.position = Some(Position { given: antenna, lever: lever_arm, weight });
        Ok(())
    }

    /// Gives a photograph an observed attitude camera_from_world, as of an inertial unit, whose precision is that of a small
    /// turn about the camera's axes, radians.
    ///
    /// ```text
    /// exp([φ]×) R_observed = R,    φ = 0 expected
    /// ```
    ///
    /// A unit that is not mounted along the camera's axes observes R_observed = (camera_from_unit) (unit_from_world): the first
    /// factor is the misalignment (boresight), which has to be known. A second call replaces the first.
    ///
    /// # Errors
    /// [`Error::Unknown`]; [`Error::NotFinite`]; [`Error::Inconsistent`] where the matrix is no rotation; those of
    /// [`Precision::weight`].
    #[doc(alias("IMU", "INS", "boresight", "misalignment"))]
    pub fn observe_attitude(
        &mut self,
        image: ImageId,
        camera_from_world: Rotation3<f64>,
        precision: Precision<3>,
    ) -> Result<(), Error> {
        let image =
            self.images.get_mut(image.number()).ok_or(Error::Unknown { what: "photograph" })?;
        if !camera_from_world.matrix().iter().all(|c| c.is_finite()) {
            return Err(Error::NotFinite { what: "attitude" });
        }
        let m = camera_from_world.matrix();
        let (residual, limit) = ((m * m.transpose() - Matrix3::identity()).amax(), 1e-9);
        if residual > limit {
            return Err(Error::Inconsistent {
                what: "attitude: rows of a rotation",
                residual,
                limit,
            });
        }
        let weight = precision.weight()?;
        image.attitude = Some(Attitude { given: camera_from_world, weight });
        Ok(())
    }

    /// Adds a pass point with approximate coordinates; a check point too, whose known coordinates are compared with the adjusted ones
    /// afterwards ([`Adjusted::check`](super::Adjusted::check)).
    ///
    /// # Errors
    /// [`Error::NotFinite`]: a point at infinity has no coordinates.
    #[doc(alias("tie point", "check point"))]
    pub fn add_point(&mut self, approximate: Point3<f64>) -> Result<PointId, Error> {
        self.add(approximate, Kind::Pass)
    }

    /// Adds a control point: its coordinates are observations with a precision of their own.
    ///
    /// # Errors
    /// [`Error::NotFinite`], and those of [`Precision::weight`].
    #[doc(alias("GCP"))]
    pub fn add_control(
        &mut self,
        given: Point3<f64>,
        precision: Precision<3>,
    ) -> Result<PointId, Error> {
        let weight = precision.weight()?;
        self.add(given, Kind::Control { given, weight })
    }

    /// Adds a control point whose coordinates are exact.
    ///
    /// # Errors
    /// [`Error::NotFinite`].
    pub fn add_fixed(&mut self, given: Point3<f64>) -> Result<PointId, Error> {
        self.add(given, Kind::Fixed)
    }

    fn add(&mut self, start: Point3<f64>, kind: Kind) -> Result<PointId, Error> {
        let number = next("number of points", self.points.len())?;
        all_finite("object point", &start)?;
        self.points.push(Object { start, kind });
        Ok(PointId(number))
    }

    /// Adds an observed image point, in pixels. A point observed twice in one photograph counts as two observations.
    ///
    /// # Errors
    /// [`Error::Unknown`], [`Error::NotFinite`], and those of [`Precision::weight`], as for an infinite weight.
    pub fn observe(
        &mut self,
        image: ImageId,
        point: PointId,
        at: Point2<f64>,
        precision: Precision<2>,
    ) -> Result<(), Error> {
        there("photograph", image.0, self.images.len())?;
        there("point", point.0, self.points.len())?;
        next("number of observations", self.seen.len())?;
        if !(at.x.is_finite() && at.y.is_finite()) {
            return Err(Error::NotFinite { what: "image point" });
        }
        let number = match self.last_precision {
            Some((last, number)) if last == precision => number,
            _ => {
                let p = precision.weight()?;
                let w22 = float::sqrt(p.m22);
                let w12 = p.m12 / w22;
                let w11 = float::sqrt((p.m11 - w12 * w12).max(0.0));
                let number = next("number of precisions", self.precisions.len())?;
                self.precisions.push([w11, w12, w22]);
                number
            }
        };
        self.last_precision = Some((precision, number));
        self.seen.push(Seen { image: image.0, point: point.0, at, precision: number });
        Ok(())
    }

    /// Adds the observed distance of two points, as of a scale bar, with its standard deviation, both in world units.
    ///
    /// # Errors
    /// [`Error::Unknown`]; [`Error::OutOfRange`] for a distance that is not positive, or of a point from itself; those of
    /// [`Precision::weight`].
    #[doc(alias("scale bar"))]
    pub fn observe_distance(
        &mut self,
        ends: [PointId; 2],
        length: f64,
        sigma: f64,
    ) -> Result<(), Error> {
        for end in ends {
            there("point", end.0, self.points.len())?;
        }
        if !(length > 0.0 && length.is_finite()) {
            let expected = "a positive number";
            return Err(Error::OutOfRange { what: "distance", value: length, expected });
        }
        if ends[0] == ends[1] {
            return Err(Error::OutOfRange {
                what: "distance of a point from itself",
                value: length,
                expected: "two points",
            });
        }
        let weight = Precision::<1>::Sigma(sigma).weight()?.x;
        self.distances.push(Distance { ends: ends.map(|e| e.0), length, weight });
        Ok(())
    }
}
