//! What can go wrong, with the numbers that say how far.
//!
//! Two types. [`ProjectionError`] is what a per-point or per-pixel path returns: it is `Copy`, small, and never a
//! plausible coordinate. [`Error`] is what constructors and estimators return. Both carry numbers, and neither carries
//! a `String`. Their texts show numbers as [`Brief`] does.

use alloc::format;
use core::fmt;

/// Why one point has no image, or one pixel no place in the world or in a texture.
///
/// Per-point paths return this instead of a number that only looks right: a perspective division gives a perfectly
/// plausible pixel for a point behind the camera.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ProjectionError {
    /// The point lies on or behind the camera's focal plane.
    #[error("the point lies behind the camera: depth {}", Brief(*depth))]
    BehindCamera {
        /// Signed depth along the optical axis, in world units; zero or negative.
        depth: f64,
    },
    /// The pixel lies on or beyond the horizon of the plane: its ray meets the plane behind the eye, or never.
    #[error("the pixel lies beyond the plane's horizon: w = {}", Brief(*w))]
    BeyondHorizon {
        /// The homogeneous denominator at the pixel; zero or negative.
        w: f64,
    },
    /// The line of sight does not meet the surface in front of the camera.
    #[error("the line of sight does not meet the surface")]
    MissesSurface,
    /// Another part of the surface stands between the texture's camera and the point.
    #[error("hidden from the texture's camera by what stands {} before it", Brief(*distance))]
    Hidden {
        /// How far before the point, in world units.
        distance: f64,
    },
    /// The model is not defined here, as a lens distortion is past the radius where it folds back.
    #[error("outside the model's domain: {} is not below {}", Brief(*value), Brief(*limit))]
    OutsideDomain {
        /// The quantity that left its domain.
        value: f64,
        /// The limit it must stay below.
        limit: f64,
    },
    /// A scan does not see the point, or has no pixel at the time.
    #[error("outside the scan: {}", OutsideScan([*time, *first, *last]))]
    OutsideScan {
        /// The time, in the trajectory's unit: for a point that of the nearest end's Newton step, NaN where that leads nowhere or into
        /// the scan.
        time: f64,
        /// First time of the scan or of the trajectory.
        first: f64,
        /// Last time of the scan or of the trajectory.
        last: f64,
    },
    /// An iteration ended before it reached its tolerance.
    #[error("not converged after {iterations} iterations: residual {}", Brief(*residual))]
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

/// The text of a scan's time and its ends.
struct OutsideScan([f64; 3]);

impl fmt::Display for OutsideScan {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [time, first, last] = self.0.map(Brief);
        if time.0.is_nan() {
            write!(f, "no time between {first} and {last} is found at which the point is seen")
        } else {
            write!(f, "time {time} is not between {first} and {last}")
        }
    }
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
    #[error("{what} is {}, expected {expected}", Brief(*value))]
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
    #[error(
        "{what} is degenerate: measure {}, needed more than {}",
        Brief(*measure),
        Brief(*limit)
    )]
    Degenerate {
        /// Which configuration.
        what: &'static str,
        /// The measure of how far from degenerate it is; its units are stated by the function.
        measure: f64,
        /// The value the measure must exceed.
        limit: f64,
    },
    /// The four corners do not go once around a convex quadrilateral: the quad is concave or crosses itself.
    #[error(
        "the quad is folded or concave: corner weights {:?} do not share one sign",
        weights.map(Brief)
    )]
    FoldedQuad {
        /// Twice the signed areas of the four corner triangles, in the order of the corners.
        weights: [f64; 4],
    },
    /// Data that should agree do not, as texture coordinates that no plane can carry.
    #[error("{what} do not agree: residual {}, allowed {}", Brief(*residual), Brief(*limit))]
    Inconsistent {
        /// Which data.
        what: &'static str,
        /// The largest disagreement.
        residual: f64,
        /// The largest allowed.
        limit: f64,
    },
    /// An estimator's iteration ended before it reached its tolerance.
    #[error("not converged after {iterations} iterations: cost {}", Brief(*cost))]
    NotConverged {
        /// Iterations done.
        iterations: u32,
        /// The cost reached, half the weighted sum of squares.
        cost: f64,
    },
    /// The residuals of a group of observations do not tell its precision: nothing controls it, or it agrees with the others better than
    /// any precision explains, so that the estimate of its standard deviation goes to zero.
    #[error("nothing tells the precision of group {group}: redundancy {}, factor {}", Brief(*redundancy), Brief(*factor))]
    UnknownPrecision {
        /// The number of the group.
        group: usize,
        /// Its redundancy when that was seen.
        redundancy: f64,
        /// What its standard deviations had been multiplied with by then: 1 where nothing controls it, less where it went to zero.
        factor: f64,
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

/// A number as a message shows it: with six significant digits, in scientific notation below 10⁻⁴ and from 10⁷ on.
///
/// ```
/// use collinear::error::Brief;
///
/// let texts = [0.5, 1e200, -3.330669e-16, 12345.678].map(|v| Brief(v).to_string());
/// assert_eq!(texts, ["0.5", "1e200", "-3.33067e-16", "12345.7"]);
/// ```
#[derive(Clone, Copy, PartialEq)]
pub struct Brief(pub f64);

impl fmt::Display for Brief {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        // Adding zero makes −0 into 0.
        let value = self.0 + 0.0;
        let text = format!("{value:.5e}");
        // NaN and infinities have no exponent.
        let Some((mantissa, exponent)) = text.split_once('e') else { return f.write_str(&text) };
        let exponent: i32 = exponent.parse().unwrap_or(0);
        if (-4..7).contains(&exponent) {
            let decimals = usize::try_from(5 - exponent).unwrap_or(0);
            f.write_str(without_zeros(&format!("{value:.decimals$}")))
        } else {
            write!(f, "{}e{exponent}", without_zeros(mantissa))
        }
    }
}

impl fmt::Debug for Brief {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Display::fmt(self, f)
    }
}

/// Decimals without the zeros at their end.
fn without_zeros(number: &str) -> &str {
    if number.contains('.') { number.trim_end_matches('0').trim_end_matches('.') } else { number }
}

#[cfg(test)]
mod tests {
    use alloc::string::ToString;

    use super::{Brief, Error};

    #[test]
    fn a_message_has_no_more_digits_than_are_read() {
        for (value, text) in [
            (0.0, "0"),
            (-0.0, "0"),
            (1.0, "1"),
            (-2.5, "-2.5"),
            (100.0, "100"),
            (0.1 + 0.2, "0.3"),
            (1e-4, "0.0001"),
            (1.234_567_89e-4, "0.000123457"),
            (9.999_999e-5, "0.0001"),
            (9.99e-5, "9.99e-5"),
            (5e-324, "4.94066e-324"),
            (999_999.6, "1000000"),
            (1_234_567.0, "1234567"),
            (9_999_999.0, "1e7"),
            (1e7, "1e7"),
            (-1.5e300, "-1.5e300"),
            (f64::NAN, "NaN"),
            (f64::INFINITY, "inf"),
            (f64::NEG_INFINITY, "-inf"),
        ] {
            assert_eq!(Brief(value).to_string(), text, "{value:e}");
        }
        let error = Error::Degenerate { what: "map", measure: 1.0 / 3.0e15, limit: 1e-300 };
        assert_eq!(
            error.to_string(),
            "map is degenerate: measure 3.33333e-16, needed more than 1e-300"
        );
    }
}
