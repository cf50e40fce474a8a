//! Averages over the areas that pixels cover.

mod block;
mod filter;
mod lookup;
mod pyramid;
mod repeated;
mod single;
mod spread;
mod summed;
mod supersample;
mod texel;
mod volume;
mod warp;

pub use filter::AreaFilter;
pub use lookup::Footprint;
pub use pyramid::Pyramid;
pub use repeated::RepeatedIntegral;
pub use summed::{SummedAreaTable, TableFilter};
pub use supersample::{Supersampling, warp_supersampled};
pub use volume::VolumePyramid;
pub use warp::{AreaSource, sample_area, warp_area};
