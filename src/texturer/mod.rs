//! The reference texturer: polygons of the world, textured, on a screen.
//!
//! One polygon at a time: project it ([`ScreenPolygon`]: near-plane clipping in homogeneous coordinates, vertices snapped
//! to 1/256 pixel), find its pixels row by row (top-left rule), keep those nearer than what is there ([`Canvas`]), and
//! look each up in its texture through a [`Map`]. The map comes from the polygon's plane and a camera
//! ([`PhotographMap::from_plane`]), or from coordinates at the vertices ([`from_vertices`]); coverage comes from snapped
//! vertices, coordinates and depth from unsnapped ones.
//!
//! This is the readable reference that faster texturers are held against.
//!
//! On a screen where straight edges are curves, as of a fisheye, a panorama or a scanner, the polygons are met by each pixel's own line of
//! sight instead: [`RayCaster`].
//!
#![doc = include_str!("../../docs/figures/texturer.svg")]
//!
//! [`Map`]: crate::mapping::Map
//! [`PhotographMap::from_plane`]: crate::mapping::PhotographMap::from_plane

mod canvas;
mod coordinates;
mod interpolation;
mod outline;
mod polygon;
mod rays;
mod scan;

pub use canvas::{Canvas, Paint};
pub use coordinates::{PlaneTexture, from_vertices};
pub use interpolation::{bilinear_quad, linear_triangles};
pub use polygon::{Facing, ScreenPolygon};
pub use rays::{Facets, RayCaster, RayPaint, Sight, TextureCoordinates};
pub use scan::PixelSpan;
