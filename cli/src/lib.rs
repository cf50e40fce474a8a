//! The program `collinear` as functions: what its commands do, without their arguments and messages.

mod picture;
pub mod render;

pub use picture::{LARGEST_AREA, LARGEST_SIDE, check_size};
