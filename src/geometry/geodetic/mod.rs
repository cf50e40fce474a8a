//! The Earth: ellipsoid, geoid and local frames, since control points come in them.
//!
//! | frame | coordinates | type |
//! | --- | --- | --- |
//! | geodetic | latitude, longitude (radians, north and east positive), height | [`Geodetic`] |
//! | geocentric | X to (0°, 0°), Y to 90° east, Z to the north pole | `Point3<f64>` |
//! | local | east, north, up, or north, east, down, from an origin | `Point3<f64>`, by a [`LocalFrame`] |
//!
//! Lengths are metres, or whatever unit the semi-major axis is in. A height says what it counts from in its type:
//! [`EllipsoidalHeight`] from the ellipsoid (satellite positioning, RPC cameras), [`OrthometricHeight`] from the geoid
//! (levelling, most elevation models). A [`GeoidGrid`] turns one into the other; they differ by up to 107 m.
//!
//! ```
//! use collinear::geometry::geodetic::{Ellipsoid, EllipsoidalHeight, Geodetic, LocalFrame};
//!
//! // IOGP Guidance Note 7-2, methods 9602 and 9837: a point in the North Sea, from an origin 600 km away.
//! let point = Geodetic::from_degrees(
//!     53.0 + 48.0 / 60.0 + 33.82 / 3600.0,
//!     2.0 + 7.0 / 60.0 + 46.38 / 3600.0,
//!     EllipsoidalHeight(73.0),
//! )?;
//! let geocentric = Ellipsoid::WGS84.geocentric_from_geodetic(&point);
//! assert!((geocentric.x - 3_771_793.968).abs() < 1e-3);
//! assert!((geocentric.y - 140_253.342).abs() < 1e-3);
//! assert!((geocentric.z - 5_124_304.349).abs() < 1e-3);
//!
//! let origin = Geodetic::from_degrees(55.0, 5.0, EllipsoidalHeight(200.0))?;
//! let local = LocalFrame::east_north_up(Ellipsoid::WGS84, origin).local_from_geodetic(&point);
//! assert!((local.x + 189_013.869).abs() < 1e-3);
//! assert!((local.y + 128_642.040).abs() < 1e-3);
//! assert!((local.z + 4_220.171).abs() < 1e-3);
//! # Ok::<(), collinear::Error>(())
//! ```
//!
#![doc = include_str!("../../../docs/figures/geodetic.svg")]

mod constant_height;
mod earth_frame;
mod ellipsoid;
mod geoid;
mod geoid_surface;
mod local;
mod position;

pub use constant_height::ConstantHeight;
pub use earth_frame::{EarthFrame, Placed};
pub use ellipsoid::Ellipsoid;
pub use geoid::{GeoidGrid, GeoidInterpolation, GeoidLayout};
pub use geoid_surface::ConstantOrthometric;
pub use local::LocalFrame;
pub use position::{EllipsoidalHeight, Geodetic, OrthometricHeight};
