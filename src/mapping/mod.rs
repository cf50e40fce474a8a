//! Maps of the plane: where in the texture a pixel of the screen looks.
//!
//! Everything that turns one picture into another is a [`Map`] from screen to texture coordinates, both in pixels from
//! the top-left corner of the top-left pixel. A map answers point by point in `f64`, and row by row through
//! [`Map::row`], which a renderer can call to fill buffers of its own.
//!
//! | map | from |
//! | --- | --- |
//! | [`FractionalLinear`], [`CantrellPlane`] | a plane and two cameras, four points |
//! | [`PhotographMap`], [`CentralPhotographMap`], [`SensorMap`] | a surface and two sensors, lenses included |
//! | [`DistortMap`], [`UndistortMap`], [`Composed`] | a lens; one map after another |
//! | [`polynomial`], [`piecewise`], [`ThinPlate`] | control points; [`registration`] fits and compares them |
//! | [`LookupTable`] | what another program computed, pixel by pixel |
//! | [`Approximated`] | another map that is too slow, within a tolerance |
//!
//! [`shader`] writes maps for graphics processors.
//!
#![doc = include_str!("../../docs/figures/mapping.svg")]

mod affine;
mod approximated;
mod blocks;
mod cantrell;
mod central;
mod compose;
mod control;
mod footprint;
mod fractional_linear;
mod lookup_table;
pub mod perspective_bilinear;
pub mod piecewise;
pub mod polynomial;
pub mod registration;
mod row;
mod sensor;
pub mod shader;
pub mod span;
mod thin_plate;

use core::fmt::Debug;
use core::ops::Range;

use nalgebra::{Matrix2, Point2};

pub use approximated::{Approximated, ApproximationReport};
pub use cantrell::CantrellPlane;
pub use central::{CentralMap, CentralPhotographMap};
pub use compose::{Composed, DistortMap, PhotographMap, UndistortMap};
pub use footprint::{FootprintBlock, FootprintSink};
pub use fractional_linear::FractionalLinear;
pub use lookup_table::{LookupTable, TextureOrigin};
pub use row::{RowCoords, Run};
pub use sensor::SensorMap;
pub use thin_plate::ThinPlate;

use crate::error::ProjectionError;

/// Takes neighbouring pixels of a row: the first one's x, and the texture coordinates u and v there and at those that follow.
pub type BlockSink<'a> = dyn FnMut(i32, &[f64], &[f64]) + 'a;

/// A map from the screen into a texture, both in pixels.
///
/// *Frames.* Screen points (S, L) and texture points (u, v) are continuous, from the top-left corner of the top-left
/// pixel. The pixel in column x of row `line` is asked at its centre (x + ½, line + ½).
///
/// *Domain.* A map knows where it ends: there [`at`](Self::at) is an error and [`row`](Self::row) leaves the pixel out.
///
/// # Example
/// A map of one's own, and what a renderer reads of it. Pixel 4 of row 3 is asked at (4.5, 3.5):
///
/// ```
/// use collinear::ProjectionError;
/// use collinear::mapping::{Map, RowCoords};
/// use nalgebra::{Matrix2, Point2};
///
/// /// Everything twice as large, left of S = 10.
/// #[derive(Debug)]
/// struct Enlarged;
///
/// impl Map for Enlarged {
///     fn at(&self, screen: &Point2<f64>) -> Result<Point2<f64>, ProjectionError> {
///         if screen.x < 10.0 {
///             Ok(screen / 2.0)
///         } else {
///             Err(ProjectionError::OutsideDomain { value: screen.x, limit: 10.0 })
///         }
///     }
///     fn jacobian(&self, screen: &Point2<f64>) -> Result<Matrix2<f64>, ProjectionError> {
///         self.at(screen).map(|_| Matrix2::identity() / 2.0)
///     }
/// }
///
/// let mut row = RowCoords::new();
/// Enlarged.row(3, 4..100, &mut row);
/// let run = row.runs()[0];
/// assert_eq!(run.pixels(), 4..10);
/// let (u, v) = row.offsets(&run);
/// assert_eq!([run.origin[0] as f32 + u[0], run.origin[1] as f32 + v[0]], [2.25, 1.75]);
/// ```
#[doc(alias("remap", "warp"))]
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

    /// The texture coordinates at the centres of the pixels `samples` of row `line`, in `f64`.
    ///
    /// `emit` is called with the x of a first pixel and the u and v there and at the pixels that follow, ascending, at
    /// most 64 at once; pixels that are not handed out show nothing. Coordinates may be infinite or NaN where they
    /// overflow. Each pixel's coordinates depend on its own (x, y) alone, not on where the range begins.
    ///
    /// The default walks the row's [`span`](Self::span), with three additions, half a division and 3½ products a pixel,
    /// and asks [`at`](Self::at) at each pixel where a row is none.
    fn blocks(&self, line: i32, samples: Range<i32>, emit: &mut BlockSink<'_>) {
        match self.span(line, samples.clone()) {
            Some((span, valid)) => crate::numeric::vectorised(
                #[inline(always)]
                || span.walk(valid, |x, [u, v]| emit(x, u, v)),
            ),
            None => blocks::pointwise(|p| self.at(p), line, samples, emit),
        }
    }

    /// As [`blocks`](Self::blocks), with the derivatives that say how large a pixel is in the texture.
    ///
    /// Positions are those of [`blocks`](Self::blocks) bit for bit. Derivatives are NaN where [`jacobian`](Self::jacobian) is
    /// an error. The default asks it at each pixel; a fractional-linear map has closed forms.
    ///
    /// ```
    /// use collinear::mapping::{FractionalLinear, Map};
    ///
    /// // u = S/L, v = −1/L: at S = 3.5, L = 0.5 the derivatives are 1/L, 0 by S and −S/L², 1/L² by L.
    /// let map = FractionalLinear::from_coefficients(
    ///     [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0])?;
    /// map.footprints(0, 3..4, &mut |block| {
    ///     assert_eq!((block.u[0], block.v[0]), (7.0, -2.0));
    ///     assert_eq!(block.by_sample.map(|d| d[0]), [2.0, 0.0]);
    ///     assert_eq!(block.by_line.map(|d| d[0]), [-14.0, 4.0]);
    /// });
    /// # Ok::<(), collinear::Error>(())
    /// ```
    fn footprints(&self, line: i32, samples: Range<i32>, emit: &mut FootprintSink<'_>) {
        let by_map = |x, y| self.jacobian(&Point2::new(x, y)).ok();
        self.blocks(line, samples, &mut |x, u, v| footprint::ask(by_map, line, [u, v], x, emit));
    }

    /// The pixels `samples` of row `line` that show something as a hyperbolic span, with its attributes u and v, and which
    /// pixels those are; `None` where a row is none.
    ///
    /// A caller that knows spans takes a projective map's rows without a word of memory between the map and what it
    /// does with them. The default is `None`.
    fn span(&self, line: i32, samples: Range<i32>) -> Option<(span::Span<2>, Range<i32>)> {
        let _ = (line, samples);
        None
    }

    /// The texture coordinates at the centres of the pixels `samples` of row `line`, as a renderer reads them.
    ///
    /// `out` is cleared and filled with runs of the coordinates of [`blocks`](Self::blocks), ascending in x; pixels in no
    /// run show nothing.
    fn row(&self, line: i32, samples: Range<i32>, out: &mut RowCoords) {
        out.clear();
        self.blocks(line, samples, &mut |x, u, v| out.push_block(x, u, v));
    }
}

/// A borrowed map is a map.
impl<M: Map + ?Sized> Map for &M {
    fn at(&self, screen: &Point2<f64>) -> Result<Point2<f64>, ProjectionError> {
        (**self).at(screen)
    }

    fn jacobian(&self, screen: &Point2<f64>) -> Result<Matrix2<f64>, ProjectionError> {
        (**self).jacobian(screen)
    }

    fn blocks(&self, line: i32, samples: Range<i32>, emit: &mut BlockSink<'_>) {
        (**self).blocks(line, samples, emit);
    }

    fn footprints(&self, line: i32, samples: Range<i32>, emit: &mut FootprintSink<'_>) {
        (**self).footprints(line, samples, emit);
    }

    fn span(&self, line: i32, samples: Range<i32>) -> Option<(span::Span<2>, Range<i32>)> {
        (**self).span(line, samples)
    }

    fn row(&self, line: i32, samples: Range<i32>, out: &mut RowCoords) {
        (**self).row(line, samples, out);
    }
}
