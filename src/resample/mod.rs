//! Pixels: views of pictures, filters, and a picture through a map.
//!
//! Pictures are borrowed ([`ImageView`], [`ImageViewMut`]): `u8` or `f32` samples, one to four interleaved channels, any
//! stride. Texel (i, j) covers the square [i, i+1) × [j, j+1) and its value is that of its centre (i + ½, j + ½).
//! [`warp`] sends a whole picture through a [`Map`](crate::mapping::Map); the texturer draws polygons with the same
//! kernels.
//!
#![doc = include_str!("../../docs/figures/resample.svg")]

mod border;
mod image;
mod sampler;
mod warp;

pub use border::Border;
pub use image::{ImageView, ImageViewMut, Sample};
pub use sampler::{Filter, sample};
pub use warp::warp;

pub(crate) use sampler::{Visit, sample_with, visit_row};
