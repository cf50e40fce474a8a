//! Maps of the plane: where in the texture a pixel of the screen looks.
//!
//! Everything that turns one picture into another is a [`Map`] from screen to texture coordinates, both in pixels from
//! the top-left corner of the top-left pixel. A map answers point by point in `f64`, and row by row through
//! [`Map::row`], which a renderer can call to fill buffers of its own.
//!
#![doc = include_str!("../../docs/figures/mapping.svg")]

mod affine;
mod cantrell;
mod compose;
mod fractional_linear;
pub mod perspective_bilinear;
pub mod polynomial;
mod row;
pub mod span;

use core::fmt::Debug;
use core::ops::Range;

use nalgebra::{Matrix2, Point2};

pub use cantrell::CantrellPlane;
pub use compose::{Composed, DistortMap, PhotographMap, UndistortMap};
pub use fractional_linear::FractionalLinear;
pub use row::{RowCoords, Run};

use crate::error::ProjectionError;

/// A map from the screen into a texture, both in pixels.
pub trait Map: Debug + Send + Sync {
    /// The texture point that a screen point shows.
    ///
    /// # Errors
    /// The reason why it shows none: beyond the horizon, behind the texture camera, outside the map's domain.
    fn at(&self, screen: &Point2<f64>) -> Result<Point2<f64>, ProjectionError>;

    /// ∂(u, v)/∂(S, L) at a screen point.
    ///
    /// # Errors
    /// As [`at`](Self::at).
    fn jacobian(&self, screen: &Point2<f64>) -> Result<Matrix2<f64>, ProjectionError>;

    /// The texture coordinates at the centres of the pixels `samples` of row `line`.
    ///
    /// `out` is cleared and filled with runs of valid coordinates, ascending in x; pixels in no run show nothing. Each
    /// pixel's coordinates depend on its own (x, y) alone, not on where the range begins.
    ///
    /// The default asks [`at`](Self::at) at each pixel. A projective map solves for the valid interval instead and
    /// walks it with one division a pixel.
    fn row(&self, line: i32, samples: Range<i32>, out: &mut RowCoords) {
        out.clear();
        let y = f64::from(line) + 0.5;
        for x in samples {
            if let Ok(p) = self.at(&Point2::new(f64::from(x) + 0.5, y)) {
                out.push(x, p.x, p.y);
            }
        }
    }
}
