//! Photogrammetric camera models and texture mapping.
//!
//! A photograph, a plane in the world and a screen are related by one projective algebra. The crate gives every link of
//! that chain, each usable alone:
//!
//! 1. A **camera** ([`Frame`]) says where a world point is in a photograph, and back: the collinearity equations, after
//!    the lens ([`Brown`]).
//! 2. A **plane** ([`Plane`]) stands for the façade, the street, the facet of a model.
//! 3. The plane, seen by the photograph's camera and by a screen, is **eight coefficients** ([`FractionalLinear`]).
//! 4. A row of the screen is a **span** ([`mapping::span`]): three additions and one division a pixel, within a stated
//!    bound of the exact ratio.
//! 5. **Samples** are looked up in the photograph, between its pixels and at its edge ([`resample`]).
//! 6. **Polygons** are clipped, covered pixel by pixel and hidden by nearer ones ([`texturer`]).
//!
//! # A whole task
//!
//! A field in a vertical photograph, drawn as it looks from its southern side:
//!
#![cfg_attr(feature = "std", doc = "```")]
#![cfg_attr(not(feature = "std"), doc = "```ignore")]
//! use collinear::mapping::PhotographMap;
//! use collinear::nalgebra::{Point2, Point3, Vector3};
//! use collinear::resample::{Border, Filter};
//! use collinear::texturer::{Canvas, Paint, ScreenPolygon};
//! use collinear::{Brown, BrownCamera, Error, ExteriorOrientation, Frame, ImageView, ImageViewMut, InteriorOrientation, Plane};
//!
//! // c = 100 px, from 100 m: a pixel shows a metre. The grey value of this picture is its column.
//! let bytes: Vec<u8> = (0..200 * 200).map(|i| (i % 200) as u8).collect();
//! let image = ImageView::<u8, 1>::new(&bytes, 200, 200)?;
//! let interior = InteriorOrientation::new([100.0; 2], Point2::new(100.0, 100.0), 0.0)?;
//! let above = ExteriorOrientation::look_at(Point3::new(0.0, 0.0, 100.0), Point3::origin(), Vector3::y())?;
//! let photograph = Frame::new(above, BrownCamera::new(interior, Brown::none()));
//! let south = ExteriorOrientation::look_at(Point3::new(0.0, -60.0, 30.0), Point3::origin(), Vector3::z())?;
//! let screen = Frame::new(south, interior).homogeneous();
//! let field = [(-40., -40.), (40., -40.), (40., 40.), (-40., 40.)].map(|(x, y)| Point3::new(x, y, 0.));
//! let plane = Plane::fit(&field)?.plane;
//! let map = PhotographMap::from_plane(&plane, &photograph, &screen)?;
//! let mut view = vec![0; 200 * 200];
//! let mut canvas = Canvas::new(ImageViewMut::<u8, 1>::new(&mut view, 200, 200)?);
//! let polygon = ScreenPolygon::project(&field, &screen, 1.0)?;
//! let paint = Paint::Texture { image, map: &map, filter: Filter::Bilinear, border: Border::Clamp };
//! canvas.draw(&polygon, screen.nearness(&plane)?, &paint)?;
//! // By hand: pixel (130, 100) meets the field at depth 66.42 m and 0.305 · 66.42 = 20.26 m to the east, in column 120.
//! assert_eq!(view[100 * 200 + 130], 120);
//! # Ok::<(), Error>(())
//! ```
//!
//! # Modules
//!
//! Each uses only those above it.
//!
//! | module | what lives there |
//! | --- | --- |
//! | [`error`] | what can go wrong, with numbers |
//! | [`numeric`] | least squares, robust losses, consensus |
//! | [`geometry`] | planes, rays, rotations, poses, projection matrices, homographies, the Earth |
//! | [`camera`] | the sensor contracts, collinearity with its partial derivatives, interior and exterior orientation, lenses |
//! | [`adjust`] | cameras and points from measurements: resection, intersection, orientation, with reports |
//! | [`mapping`] | maps from screen to texture: fractional-linear, polynomial, piecewise, composed; registration; spans |
//! | [`resample`] | borrowed pictures, filters, borders, a picture through a map |
//! | [`texturer`] | the reference scanline texturer |
//! | [`interop`] | nalgebra to glam and back |
//!
//! # Conventions
//!
//! - World, camera (x right, y down, z forward) and photo (x right, y up, z back) frames are right-handed; `b_from_a`
//!   takes a point of a to b.
//! - Image coordinates are pixels from the top-left corner of the top-left pixel, whose centre is (0.5, 0.5).
//! - Angles are radians, lengths are the world's unit, unless a name says otherwise.
//! - Geometry is `f64` and nalgebra, pixels are `f32`; both libraries are re-exported.
//! - Failure is a value: [`ProjectionError`] for a point or pixel, [`Error`] for constructors and estimators.
//!
//! What the figures of an adjustment mean: [`_adjustment`]. More in [`_conventions`]; every camera model in [`_models`]; what the numbers of other tools mean in [`_coming_from`].
//! \[WD\], \[S\], \[H\] and \[C\] are the sources whose equations the documentation cites by
//! number; [`_sources`] lists which equation is which function, and the test that holds it.
//!
//! # Features
//!
//! | feature | |
//! | --- | --- |
//! | `std` (default) | the standard library; `adjust`, `resample`, `texturer` and `interop` need it |
//! | `libm` | float functions where there is no standard library |
//! | `rayon` | bundle adjustment and warping on the threads of the caller's pool |
//! | `simd` | loops over many points on the processor's widest vectors, chosen at run time |
//! | `mint` | conversions to and from the neutral types of mint 0.5 |
#![no_std]
extern crate alloc;
#[cfg(feature = "std")]
extern crate std;

#[cfg(not(any(feature = "std", feature = "libm")))]
compile_error!("collinear needs float functions: enable the feature `std` (default) or `libm`");

#[cfg(feature = "std")]
pub mod adjust;
pub mod camera;
pub mod error;
pub mod geometry;
#[cfg(feature = "std")]
pub mod interop;
pub mod mapping;
pub mod numeric;
#[cfg(feature = "std")]
pub mod resample;
#[cfg(feature = "std")]
pub mod texturer;

pub use camera::{
    Brown, BrownCamera, CentralModel, ExteriorOrientation, Frame, InteriorOrientation, SensorModel,
};
pub use error::{Error, ProjectionError};
pub use geometry::{Homography, Plane, Pose};
#[cfg(feature = "std")]
pub use glam;
pub use mapping::{FractionalLinear, Map};
pub use nalgebra;
#[cfg(feature = "std")]
pub use resample::{ImageView, ImageViewMut};

#[doc = include_str!("../docs/conventions.md")]
pub mod _conventions {}

#[doc = include_str!("../docs/coming-from.md")]
pub mod _coming_from {}

#[cfg(feature = "std")]
#[doc = include_str!("../docs/adjustment.md")]
pub mod _adjustment {}

#[doc = include_str!("../docs/models.md")]
pub mod _models {}

#[doc = include_str!("../docs/sources.md")]
pub mod _sources {}

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
