//! What can go wrong, with the numbers that say how far.
//!
//! Two types. [`ProjectionError`] is what a per-point or per-pixel path returns: it is `Copy`, small, and never a
//! plausible coordinate. [`Error`] is what constructors and estimators return. Both carry numbers, and neither carries
//! a `String`.

/// Why one point has no image, or one pixel no place in the world or in a texture.
///
/// Per-point paths return this instead of a number that only looks right: a perspective division gives a perfectly
/// plausible pixel for a point behind the camera.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ProjectionError {
    /// The point lies on or behind the camera's focal plane.
    #[error("the point lies behind the camera: depth {depth}")]
    BehindCamera {
        /// Signed depth along the optical axis, in world units; zero or negative.
        depth: f64,
    },
    /// The pixel lies on or beyond the horizon of the plane: its ray meets the plane behind the eye, or never.
    #[error("the pixel lies beyond the plane's horizon: w = {w}")]
    BeyondHorizon {
        /// The homogeneous denominator at the pixel; zero or negative.
        w: f64,
    },
    /// The line of sight does not meet the surface in front of the camera.
    #[error("the line of sight does not meet the surface")]
    MissesSurface,
    /// The model is not defined here, as a lens distortion is past the radius where it folds back.
    #[error("outside the model's domain: {value} is not below {limit}")]
    OutsideDomain {
        /// The quantity that left its domain.
        value: f64,
        /// The limit it must stay below.
        limit: f64,
    },
    /// An iteration ended before it reached its tolerance.
    #[error("not converged after {iterations} iterations: residual {residual}")]
    NotConverged {
        /// Iterations done.
        iterations: u32,
        /// The residual reached, in the units the function states.
        residual: f64,
    },
    /// A coordinate is NaN or infinite.
    #[error("a coordinate is NaN or infinite")]
    NotFinite,
}

/// Why a constructor or an estimator refused its input, or could not finish.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// An input is NaN or infinite.
    #[error("{what} is NaN or infinite")]
    NotFinite {
        /// Which input.
        what: &'static str,
    },
    /// An input lies outside its domain.
    #[error("{what} is {value}, expected {expected}")]
    OutOfRange {
        /// Which input.
        what: &'static str,
        /// Its value.
        value: f64,
        /// The domain, in words.
        expected: &'static str,
    },
    /// A grid has no value here: the cell is void.
    #[error("{what} has no value at row {row}, column {column}")]
    NoData {
        /// Which grid.
        what: &'static str,
        /// Row of the void node.
        row: usize,
        /// Column of the void node.
        column: usize,
    },
    /// A name that is none of those known.
    #[error("unknown {what}")]
    Unknown {
        /// What was named.
        what: &'static str,
    },
    /// Fewer points than the unknowns need.
    #[error("{got} points given, {needed} needed")]
    TooFewPoints {
        /// The smallest number that determines the unknowns.
        needed: usize,
        /// The number given.
        got: usize,
    },
    /// Two slices that belong together differ in length.
    #[error("{what} differ in length: {left} and {right}")]
    LengthMismatch {
        /// Which slices.
        what: &'static str,
        /// Length of the first.
        left: usize,
        /// Length of the second.
        right: usize,
    },
    /// The input does not determine the result: points on one line, a plane through the eye, a singular matrix.
    #[error("{what} is degenerate: measure {measure}, needed more than {limit}")]
    Degenerate {
        /// Which configuration.
        what: &'static str,
        /// The measure of how far from degenerate it is; its units are stated by the function.
        measure: f64,
        /// The value the measure must exceed.
        limit: f64,
    },
    /// The four corners do not go once around a convex quadrilateral: the quad is concave or crosses itself.
    #[error("the quad is folded or concave: corner weights {weights:?} do not share one sign")]
    FoldedQuad {
        /// Twice the signed areas of the four corner triangles, in the order of the corners.
        weights: [f64; 4],
    },
    /// Data that should agree do not, as texture coordinates that no plane can carry.
    #[error("{what} do not agree: residual {residual}, allowed {limit}")]
    Inconsistent {
        /// Which data.
        what: &'static str,
        /// The largest disagreement.
        residual: f64,
        /// The largest allowed.
        limit: f64,
    },
    /// An estimator's iteration ended before it reached its tolerance.
    #[error("not converged after {iterations} iterations: cost {cost}")]
    NotConverged {
        /// Iterations done.
        iterations: u32,
        /// The cost reached, half the weighted sum of squares.
        cost: f64,
    },
    /// A robust search found no model that enough observations support.
    #[error("no consensus: {inliers} of {needed} needed observations agree after {trials} trials")]
    NoConsensus {
        /// Observations that agree with the best model found.
        inliers: usize,
        /// Observations needed.
        needed: usize,
        /// Trials done.
        trials: u32,
    },
    /// A point that the estimator must project has no image.
    #[error(transparent)]
    Projection(#[from] ProjectionError),
}
