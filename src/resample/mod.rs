//! Pixels: views of pictures, filters, and a picture through a map.
//!
//! Pictures are borrowed ([`ImageView`], [`ImageViewMut`]): `u8`, `u16` or `f32` samples, one to four interleaved channels, any
//! stride. Texel (i, j) covers the square [i, i+1) × [j, j+1) and its value is that of its centre (i + ½, j + ½).
//! [`warp`] sends a whole picture through a [`Map`](crate::mapping::Map) with a [`Filter`]; [`sample`] looks up one
//! position, and the texturer draws polygons with the same formulas.
//!
//! Where a map makes the picture smaller, pixels cover areas, and a [`Filter`] between four texels aliases. Averages over areas:
//!
//! | what | how | cost a pixel | blurs |
//! | --- | --- | --- | --- |
//! | [`Pyramid`], [`AreaFilter::Trilinear`] | [`warp_area`] | 8 texels | along an area's shorter axis |
//! | [`Pyramid`], [`AreaFilter::Ewa`] | [`warp_area`] | some 9 to 30 texels times the ratio of its axes | little |
//! | [`SummedAreaTable`] | [`warp_area`] | 4 sums a rectangle | oblique areas, less in strips |
//! | [`RepeatedIntegral`] | [`warp_area`] | 16 to 64 sums | oblique areas |
//! | [`Supersampling`] | [`warp_supersampled`] | as many lookups as are asked for | nothing; too few alias |
//!
//! The example `filters` measures them all on three pictures.
//!
//! *Accuracy.* Positions are computed in `f64` and rounded to 2⁻³² texel, weights are `f32`, wherever in a picture of up to
//! 524,288 pixels a side (beyond, positions are `f64`). Against lookups in `f64` of a picture of noise of 1920 × 1080 pixels no
//! nearest pixel is another one, of 5 in a million bilinear 8-bit pixels the rounding differs, and of `f32` ones between 0 and 255
//! the largest difference is 5·10⁻⁵, with cubics 10⁻⁴.
//!
#![doc = include_str!("../../docs/figures/resample.svg")]

mod area;
mod bands;
mod block;
mod border;
mod filter;
mod image;
mod kernel;
mod light;
mod located;
mod margin;
mod position;
mod sampler;
mod taps;
mod warp;
mod weigh;

pub use area::{
    AreaFilter, AreaSource, Footprint, Pyramid, RepeatedIntegral, SummedAreaTable, Supersampling,
    TableFilter, VolumePyramid, sample_area, warp_area, warp_supersampled,
};
pub use border::Border;
pub use filter::{Cubic, Filter};
pub use image::{ImageView, ImageViewMut, Sample};
pub use light::{Alpha, Coding, Light, light_of, samples_of, warp_by_light};
pub use sampler::sample;
pub use warp::warp;

pub(crate) use sampler::{Visit, visit_row};
