//! Photogrammetric camera models and texture mapping.
#![no_std]
extern crate alloc;
#[cfg(feature = "std")]
extern crate std;

#[cfg(not(any(feature = "std", feature = "libm")))]
compile_error!("collinear needs float functions: enable the feature `std` (default) or `libm`");

pub mod camera;
pub mod error;
pub mod geometry;
pub mod mapping;
pub mod numeric;

pub use error::{Error, ProjectionError};
pub use nalgebra;
