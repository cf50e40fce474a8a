//! Spans: texture coordinates along one row of pixels.
//!
//! On a row of the screen the texture coordinates of a plane are hyperbolas with one denominator: every attribute is
//! a ratio of two linear forms of the pixel's x. Interpolating the ratio itself linearly is wrong by many texels and
//! makes textures fold at polygon diagonals and swim with the view; interpolating numerators and denominator is right
//! (Heckbert & Moreton 1991, Blinn 1992).
//!
//! ```text
//! uₖ(x) = (aₖ + bₖ x) / (c + d x),   k = 1 … N
//! ```
//!
//! A [`Span`] holds the coefficients and evaluates them
//!
//! | how | work a pixel | error | where |
//! | --- | --- | --- | --- |
//! | exactly, at any pixel | one division, a compensated sum a form | 4 ulp | [`Span::at`], [`Span::exact`] |
//! | incrementally, anchored every 64 pixels | half a division, N + 1 additions, N + 1½ products | [`Span::walk_bound`] | [`Span::walk`] |
//! | by polynomials on runs of n pixels | one division every n (quadratic n/2, cubic n/3) | [`Approximation::error_bound`] | [`Approximation`] |
//! | along lines of constant depth | one division a line | [`ConstantDepthLines::error_bound`] | [`ConstantDepthLines`] |
//!
//! In all of them a pixel's value depends on the coefficients and on its own x alone: anchors and runs begin at
//! absolute multiples of 64 or n, never where a polygon's edge happens to lie. Cutting a polygon therefore changes no
//! pixel.
//!
#![doc = include_str!("../../../docs/figures/span.svg")]
#![allow(
    clippy::neg_cmp_op_on_partial_ord,
    reason = "a comparison that must fail for NaN is written negated"
)]
#![allow(clippy::needless_range_loop, reason = "parallel arrays are walked by one index")]

mod approximate;
mod constant_depth;
mod hyperbolic;
mod linear;

use core::ops::Range;

pub use approximate::{Approximation, Degree};
pub use constant_depth::ConstantDepthLines;

use crate::error::{Error, ProjectionError};
use crate::numeric::twofold::Twofold;
#[cfg(feature = "std")]
pub(crate) use hyperbolic::LANES;
#[cfg(all(feature = "simd", target_arch = "x86_64"))]
pub(crate) use hyperbolic::{Form, Forms};
use linear::Linear;

/// Pixels between two anchors of an incremental walk, and the most pixels handed out at once.
pub(crate) const BLOCK: usize = 64;

/// N attributes along a row of pixels, ratios of linear forms with one denominator.
///
/// *Model*
///
/// ```text
/// uₖ = (aₖ + bₖ (x − x₀)) / (c + d (x − x₀)),   k = 1 … N
/// ```
///
/// x is the integer index of a pixel, sampled at its centre x + ½; x₀ is the span's origin, a multiple of 64. On a row
/// of a plane's picture these are the coefficients of \[WD\] eq. 1; between two vertices they come from the weights
/// 1/w (\[S\] eq. 8) or wˡ/w (\[S\] eq. 7).
///
/// *Domain.* Pixels from −2²⁵ to 2²⁵ where the denominator is positive. [`valid_interval`](Self::valid_interval) gives
/// them, and agrees with [`at`](Self::at) at every pixel.
///
/// *Accuracy.* The relative error of [`at`](Self::at) and [`exact`](Self::exact) is at most 4 u (1 + 2⁻²⁰), u = 2⁻⁵³:
/// within 4 units in the last place of the exact ratio of the stored coefficients, cancellation in them included. (Both
/// forms are right to u (1 + 2⁻²³) with their signs exact; the reciprocal and the product round once each.)
///
/// ```
/// use collinear::mapping::span::Span;
///
/// // u = (3 + 2x) / (1 + x): 3, 5/2, 7/3, 9/4 at the pixels 0 to 3.
/// let span = Span::new([[3.0, 2.0]], [1.0, 1.0])?;
/// assert_eq!(span.at(1)?, [2.5]);
/// assert_eq!(span.at(3)?, [2.25]);
/// // The denominator is positive from pixel 0 on.
/// assert_eq!(span.valid_interval(-10..10), 0..10);
/// assert!(span.at(-1).is_err());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[doc(alias = "hyperbolic interpolation")]
#[doc(alias = "perspective-correct interpolation")]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Span<const N: usize> {
    origin: i32,
    numerators: [Linear; N],
    denominator: Linear,
}

/// One end of a span between two vertices or edges: where it is on the screen, and what is interpolated.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpanEnd<const N: usize> {
    /// Continuous screen x in pixels (the first pixel's centre is at 0.5).
    pub x: f64,
    /// The homogeneous w of the point in clip coordinates; positive.
    pub w: f64,
    /// The numerators before division by w: attributes, or light coordinates xˡ, yˡ, ….
    pub values: [f64; N],
    /// What is interpolated beneath them: 1 for attributes, wˡ for light coordinates. May be negative at one end.
    pub weight: f64,
}

impl<const N: usize> SpanEnd<N> {
    /// Attributes (s, t, …) assigned to a vertex: \[S\] eq. 8.
    #[must_use]
    pub fn attributes(x: f64, w: f64, values: [f64; N]) -> Self {
        Self { x, w, values, weight: 1.0 }
    }

    /// Homogeneous light coordinates (xˡ, yˡ, …) and wˡ of a vertex: \[S\] eq. 7.
    #[must_use]
    pub fn light(x: f64, w: f64, values: [f64; N], light_w: f64) -> Self {
        Self { x, w, values, weight: light_w }
    }

    fn is_finite(&self) -> bool {
        [self.x, self.w, self.weight].iter().chain(&self.values).all(|v| v.is_finite())
    }
}

impl<const N: usize> Span<N> {
    /// Pixels from −`PIXEL_LIMIT` to `PIXEL_LIMIT` − 1 can be evaluated.
    pub const PIXEL_LIMIT: i32 = 1 << 25;

    /// Whether all of some pixels can be evaluated.
    pub(crate) fn reaches(pixels: &Range<i32>) -> bool {
        pixels.start >= -Self::PIXEL_LIMIT && pixels.end <= Self::PIXEL_LIMIT
    }

    /// From the value of each form at pixel 0's centre and its step from pixel to pixel.
    ///
    /// # Errors
    /// As [`with_origin`](Self::with_origin).
    pub fn new(numerators: [[f64; 2]; N], denominator: [f64; 2]) -> Result<Self, Error> {
        Self::with_origin(0, numerators, denominator)
    }

    /// From the value of each form at pixel `origin`'s centre and its step from pixel to pixel.
    ///
    /// An origin near the span saves the digits that a value at a far pixel 0 would lose in the caller's own
    /// arithmetic. Pieces of one polygon must share it to be bit-identical.
    ///
    /// # Errors
    /// [`Error::NotFinite`]; [`Error::OutOfRange`] for a coefficient that is neither zero nor between 2⁻⁸⁰⁰ and 2⁸⁰⁰
    /// in magnitude, or an origin beyond [`PIXEL_LIMIT`](Self::PIXEL_LIMIT); [`Error::Degenerate`] for a denominator
    /// that is zero at every pixel.
    pub fn with_origin(
        origin: i32,
        numerators: [[f64; 2]; N],
        denominator: [f64; 2],
    ) -> Result<Self, Error> {
        let [least, most] = Linear::MAGNITUDES;
        for value in numerators.iter().chain([&denominator]).flatten() {
            if !value.is_finite() {
                return Err(Error::NotFinite { what: "span coefficient" });
            }
            if *value != 0.0 && !(least..=most).contains(&value.abs()) {
                return Err(Error::OutOfRange {
                    what: "span coefficient",
                    value: *value,
                    expected: "zero or a magnitude from 2^-800 to 2^800",
                });
            }
        }
        if !(-Self::PIXEL_LIMIT..=Self::PIXEL_LIMIT).contains(&origin) {
            return Err(Error::OutOfRange {
                what: "span origin",
                value: f64::from(origin),
                expected: "a pixel within 2^25 of 0",
            });
        }
        if denominator == [0.0; 2] {
            return Err(Error::Degenerate { what: "span denominator", measure: 0.0, limit: 0.0 });
        }
        Ok(Self {
            origin,
            numerators: numerators.map(|[a, b]| Linear::new(a, b)),
            denominator: Linear::new(denominator[0], denominator[1]),
        })
    }

    /// The row `line` of a fractional-linear map of the plane, from the coefficients of \[WD\] eq. 1.
    ///
    /// ```text
    /// u = (P₀ + P₁ S + P₂ L) / (R₀ + R₁ S + R₂ L),   S = x + ½,   L = line + ½
    /// ```
    ///
    /// The forms' values at pixel 0 are summed in twice the precision and rounded once.
    ///
    /// # Errors
    /// As [`with_origin`](Self::with_origin).
    pub fn on_line(
        numerators: [[f64; 3]; N],
        denominator: [f64; 3],
        line: i32,
    ) -> Result<Self, Error> {
        let y = Twofold::new(f64::from(line) + 0.5);
        let row = |[p0, p1, p2]: [f64; 3]| {
            let at_zero =
                Twofold::new(p0) + Twofold::new(p1) * Twofold::new(0.5) + Twofold::new(p2) * y;
            [at_zero.round(), p1]
        };
        Self::new(numerators.map(row), row(denominator))
    }

    /// The span between two ends: the weights and values over w are linear in screen x.
    ///
    /// ```text
    /// s = (s/w) / (1/w)                                         [S] eq. 8, weight 1 (SpanEnd::attributes)
    /// xᵗ = (xˡ/w) / (wˡ/w)                                      [S] eq. 7, weight wˡ (SpanEnd::light)
    /// ```
    ///
    /// The common factor (x₂ − x₁) w₁ w₂ is multiplied out, so nothing is divided here; the products are formed in
    /// twice the precision. The origin is the multiple of 64 at or left of the left end. The denominator may change
    /// sign along a span with weights wˡ: pixels behind the light are outside the valid interval. The span continues
    /// beyond its ends.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] for w ≤ 0 (clip first) or |x| beyond [`PIXEL_LIMIT`](Self::PIXEL_LIMIT),
    /// [`Error::Degenerate`] for ends at one x, and as [`with_origin`](Self::with_origin).
    ///
    /// ```
    /// use collinear::mapping::span::{Span, SpanEnd};
    ///
    /// // A floor that recedes from w = 1 to w = 3 between pixels 0 and 8. Half way on the screen is a quarter of the
    /// // way on the floor: t = (½ · 1/3) / (½ · 1/1 + ½ · 1/3) = ¼.
    /// let span = Span::between(
    ///     &SpanEnd::attributes(0.5, 1.0, [0.0]),
    ///     &SpanEnd::attributes(8.5, 3.0, [1.0]),
    /// )?;
    /// assert_eq!(span.at(4)?, [0.25]);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn between(a: &SpanEnd<N>, b: &SpanEnd<N>) -> Result<Self, Error> {
        if !(a.is_finite() && b.is_finite()) {
            return Err(Error::NotFinite { what: "span end" });
        }
        let (a, b) = if a.x <= b.x { (a, b) } else { (b, a) };
        for end in [a, b] {
            if !(end.w > 0.0) {
                return Err(Error::OutOfRange {
                    what: "w of a span end",
                    value: end.w,
                    expected: "a positive number: clip against the near plane first",
                });
            }
            if !(end.x.abs() <= f64::from(Self::PIXEL_LIMIT)) {
                return Err(Error::OutOfRange {
                    what: "x of a span end",
                    value: end.x,
                    expected: "a pixel within 2^25 of 0",
                });
            }
        }
        if a.x == b.x {
            return Err(Error::Degenerate { what: "span ends", measure: 0.0, limit: 0.0 });
        }
        let origin = (crate::numeric::float::floor(a.x) as i32).div_euclid(64) * 64;
        let centre = f64::from(origin) + 0.5;
        let (xa, xb) = (Twofold::new(a.x - centre), Twofold::new(b.x - centre));
        let (wa, wb) = (Twofold::new(a.w), Twofold::new(b.w));
        let form = |at_a: f64, at_b: f64| {
            let (at_a, at_b) = (Twofold::new(at_a) * wb, Twofold::new(at_b) * wa);
            [(at_a * xb - at_b * xa).round(), (at_b - at_a).round()]
        };
        let numerators = core::array::from_fn(|k| form(a.values[k], b.values[k]));
        Self::with_origin(origin, numerators, form(a.weight, b.weight))
    }

    /// x₀, the pixel at which the coefficients are given.
    #[must_use]
    pub fn origin(&self) -> i32 {
        self.origin
    }

    /// (aₖ, bₖ) of each numerator.
    #[must_use]
    pub fn numerators(&self) -> [[f64; 2]; N] {
        self.numerators.map(|l| [l.at_origin, l.step])
    }

    /// (c, d) of the denominator.
    #[must_use]
    pub fn denominator(&self) -> [f64; 2] {
        [self.denominator.at_origin, self.denominator.step]
    }

    /// x − x₀ as a float; exact.
    #[inline(always)]
    fn relative(&self, x: i32) -> f64 {
        f64::from(x) - f64::from(self.origin)
    }

    /// The attributes at one pixel, within 4 ulp.
    ///
    /// # Errors
    /// [`ProjectionError::BehindCamera`] where the denominator is not positive (its depth is the denominator),
    /// [`ProjectionError::OutsideDomain`] beyond [`PIXEL_LIMIT`](Self::PIXEL_LIMIT), and
    /// [`ProjectionError::NotFinite`] where an attribute overflows.
    #[inline]
    pub fn at(&self, x: i32) -> Result<[f64; N], ProjectionError> {
        if !(-Self::PIXEL_LIMIT..Self::PIXEL_LIMIT).contains(&x) {
            return Err(ProjectionError::OutsideDomain {
                value: f64::from(x).abs(),
                limit: f64::from(Self::PIXEL_LIMIT),
            });
        }
        let x = self.relative(x);
        let depth = self.denominator.at(x);
        if !(depth > 0.0) {
            return Err(ProjectionError::BehindCamera { depth });
        }
        let reciprocal = 1.0 / depth;
        let values = self.numerators.map(|l| l.at(x) * reciprocal);
        if values.iter().all(|v| v.is_finite()) {
            Ok(values)
        } else {
            Err(ProjectionError::NotFinite)
        }
    }

    /// The pixels of `range` where the denominator is positive: one interval, perhaps empty.
    ///
    /// The end is solved for and then settled by the sign at the pixels beside it. The signs are exact, so the interval
    /// agrees with [`at`](Self::at) at every pixel.
    #[must_use]
    pub fn valid_interval(&self, range: Range<i32>) -> Range<i32> {
        let start = range.start.max(-Self::PIXEL_LIMIT);
        let end = range.end.min(Self::PIXEL_LIMIT).max(start);
        let positive = |x: i32| self.denominator.at(self.relative(x)) > 0.0;
        if start < end && positive(start) && positive(end - 1) {
            return start..end;
        }
        let step = self.denominator.step;
        if step == 0.0 {
            return if positive(0) { start..end } else { start..start };
        }
        let root = f64::from(self.origin) - self.denominator.at_origin / step;
        // The cast saturates; the loops move by no more than the root's rounding.
        let mut edge = (crate::numeric::float::ceil(root) as i32).clamp(start, end);
        if step > 0.0 {
            while edge > start && positive(edge - 1) {
                edge -= 1;
            }
            while edge < end && !positive(edge) {
                edge += 1;
            }
            edge..end
        } else {
            while edge > start && !positive(edge - 1) {
                edge -= 1;
            }
            while edge < end && positive(edge) {
                edge += 1;
            }
            start..edge
        }
    }

    /// The pixels of a valid interval where attribute `k` lies between two values: one interval, up to `slack` pixels wider at
    /// either end, or narrower where it is negative.
    ///
    /// The ends are right to the rounding of the difference of attribute and value, and to less than a pixel.
    #[cfg(feature = "std")]
    pub(crate) fn interval_within(
        &self,
        k: usize,
        [low, high]: [f64; 2],
        valid: Range<i32>,
        slack: i32,
    ) -> Range<i32> {
        let (n, d) = (&self.numerators[k], &self.denominator);
        // uₖ ≥ low is n − low d ≥ 0 where d > 0, and so for high.
        let above = [n.at_origin - low * d.at_origin, n.step - low * d.step];
        let below = [high * d.at_origin - n.at_origin, high * d.step - n.step];
        [above, below].into_iter().fold(valid, |range, [at_origin, step]| {
            let root = f64::from(self.origin) - at_origin / step;
            // The cast saturates, and sends NaN to 0.
            let clamped = |x: f64| (x as i32).clamp(range.start, range.end);
            if step > 0.0 {
                clamped(root - f64::from(slack))..range.end
            } else if step < 0.0 {
                range.start..clamped(root + f64::from(1 + slack))
            } else if at_origin < 0.0 {
                range.start..range.start
            } else {
                range
            }
        })
    }
}
