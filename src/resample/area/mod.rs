//! Averages over the areas that pixels cover.

mod block;
mod filter;
mod lookup;
mod pyramid;
mod spread;
mod texel;
mod warp;

pub use filter::AreaFilter;
pub use lookup::Footprint;
pub use pyramid::Pyramid;
pub(super) use texel::Words;
pub use warp::{AreaSource, sample_area, warp_area};
