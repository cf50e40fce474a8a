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
#[cfg(feature = "std")]
pub mod interop;
pub mod mapping;
pub mod numeric;
#[cfg(feature = "std")]
pub mod resample;
#[cfg(feature = "std")]
pub mod texturer;

pub use error::{Error, ProjectionError};
#[cfg(feature = "std")]
pub use glam;
pub use nalgebra;

#[doc = include_str!("../docs/conventions.md")]
pub mod _conventions {}

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
