//! Maps through control points, piece by piece.
//!
//! Where no single formula follows a distortion, as of a scanned map that has shrunk unevenly or of an old film, the screen is
//! cut into pieces and each has its own:
//!
//! | map | pieces | at the seams | passes through the points |
//! | --- | --- | --- | --- |
//! | [`PiecewiseAffine`] | Delaunay triangles | continuous | yes |
//! | [`PiecewiseCubic`] | Delaunay triangles, three cubics in each | smooth | yes |
//! | [`BilinearGrid`] | cells of a regular grid | continuous | its nodes |
//!
//! All of them end at the outermost points. A row goes from piece to piece and searches for none, so that a pixel costs
//! a few operations. [`ThinPlate`](super::ThinPlate) is smooth without pieces; [`registration`](super::registration) says
//! which map fits given points best.
//!
//! The triangles are those of the crate `delaunator`; every other step is by the sides of corners, with no tolerance.
//!
#![doc = include_str!("../../../docs/figures/piecewise.svg")]

mod affine;
mod cubic;
mod gradients;
mod grid;
mod triangulation;

pub use affine::PiecewiseAffine;
pub use cubic::PiecewiseCubic;
pub use grid::BilinearGrid;
