//! The program `collinear` as functions: what its commands do, without their arguments and messages.
//!
//! | command | function |
//! | --- | --- |
//! | `collinear render` | [`render::render_scene`] |
//! | `collinear rectify` | [`rectify::Rectification`] |
//! | `collinear reproject` | [`reproject::photograph_from_screen`], [`lookup::Lookup`] |
//! | `collinear resect` | [`resect::run`], [`residuals::to_svg`] |
//! | `collinear intersect` | [`intersect::run`] |
//! | `collinear adjust` | [`block::BlockFile`], [`given::Given`], [`adjust::run`] |
//! | `collinear project` | [`project::project`], [`project::ground`] |
//! | `collinear warp` | [`warp::Job`] |
//! | `collinear overlay` | [`overlay::Overlay`] |
//! | `collinear convert` | [`convert::write`] |
//!
//! The mathematics is that of [`collinear`], the files are those of [`collinear_io`].

pub mod adjust;
pub mod block;
pub mod convert;
mod draft;
pub mod given;
pub mod given_report;
pub mod intersect;
pub mod lookup;
mod obj;
pub mod overlay;
mod photograph;
mod picture;
pub mod project;
mod protocol;
mod reason;
pub mod rectify;
pub mod render;
pub mod reproject;
pub mod resect;
pub mod residuals;
pub mod rpc;
pub mod warp;

pub use picture::{LARGEST_AREA, LARGEST_SIDE, check_size};
