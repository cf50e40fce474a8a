//! Lines of the screen along which a plane's denominator is constant: one division serves the line.

use alloc::vec::Vec;
use core::ops::Range;

use super::Span;
use crate::error::Error;
use crate::numeric::float;
use crate::numeric::twofold::Twofold;

/// A plane's texture coordinates along lines of constant denominator.
///
/// *Model.* Where R₀ + R₁ S + R₂ L is constant the quotients of \[WD\] eq. 1 are linear, so a line in the direction
/// (−R₂, R₁) needs one division. Andrew Jewett proposed such "scanlines that follow the contour of changing z" in
/// \[C\], "if the lines could be lined up properly, not to overlap". They line up when every line is the same digital
/// line, shifted: with |R₁| ≤ |R₂| (else swap the axes)
///
/// ```text
/// slope m = −R₁/R₂,   offset o(x) = ⌊m (x + ½) + ½⌋,   pixel (x, y) belongs to line k = y − o(x)
/// line k is L = k + ½ + m S, on which the denominator is R₀ + R₂ (k + ½)
/// ```
///
/// Each column has one offset, so every pixel belongs to exactly one line.
///
/// *Domain.* Pixels whose denominator is positive. Lines within half a pixel of the horizon are evaluated pixel by
/// pixel.
///
/// *Accuracy.* A pixel takes the value at the line's point in its own column, δ = o(x) − m (x + ½) away from its centre
/// along the minor axis, |δ| ≤ ½. See [`error_bound`](Self::error_bound). Exact (to rounding) where the horizon is
/// parallel to an axis, where δ = 0.
///
/// ```
/// use collinear::mapping::span::ConstantDepthLines;
///
/// // A level floor: u = S/(L − 10), v = 100/(L − 10), the horizon in line 10. Its rows are lines of constant depth.
/// let floor = ConstantDepthLines::new([[0.0, 1.0, 0.0], [100.0, 0.0, 0.0]], [-10.0, 0.0, 1.0])?;
/// let mut at_20_14 = None;
/// floor.walk(0..40, 0..30, |x, y, uv| if (x, y) == (20, 14) { at_20_14 = Some(uv) });
/// assert_eq!(at_20_14, Some([20.5 / 4.5, 100.0 / 4.5]));
/// # Ok::<(), collinear::Error>(())
/// ```
#[doc(alias = "free-direction texture mapping")]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ConstantDepthLines<const N: usize> {
    /// Coefficients with the major axis second: (constant, major, minor).
    numerators: [[f64; 3]; N],
    denominator: [f64; 3],
    x_major: bool,
    slope: f64,
}

/// The most that a pixel's centre is off its line: half a pixel, and what rounding of m S can add within 2²⁵ pixels.
const HALF: f64 = 0.5 + 1.0 / (1 << 24) as f64;

impl<const N: usize> ConstantDepthLines<N> {
    /// From the coefficients (P₀, P₁, P₂) of each numerator and (R₀, R₁, R₂) of the denominator.
    ///
    /// # Errors
    /// [`Error::NotFinite`]; [`Error::OutOfRange`] for a coefficient beyond 10¹⁰⁰ or a denominator whose largest
    /// coefficient is below 10⁻¹⁰⁰; [`Error::Degenerate`] for a denominator of zero.
    pub fn new(numerators: [[f64; 3]; N], denominator: [f64; 3]) -> Result<Self, Error> {
        let largest = denominator.iter().fold(0.0, |m: f64, c| m.max(c.abs()));
        for value in numerators.iter().chain([&denominator]).flatten().chain([&largest]) {
            if !value.is_finite() {
                return Err(Error::NotFinite { what: "plane coefficient" });
            }
            if value.abs() > 1e100 {
                return Err(Error::OutOfRange {
                    what: "plane coefficient",
                    value: *value,
                    expected: "at most 1e100 in magnitude",
                });
            }
        }
        if !(largest > 1e-100) {
            return Err(Error::Degenerate {
                what: "plane denominator",
                measure: largest,
                limit: 1e-100,
            });
        }
        let x_major = denominator[1].abs() <= denominator[2].abs();
        let order = |[c, x, y]: [f64; 3]| if x_major { [c, x, y] } else { [c, y, x] };
        let denominator = order(denominator);
        let [_, major, minor] = denominator;
        let slope = if major == 0.0 { 0.0 } else { -major / minor };
        Ok(Self { numerators: numerators.map(order), denominator, x_major, slope })
    }

    /// Whether the lines run along the rows (|R₁| ≤ |R₂|) rather than the columns.
    #[must_use]
    pub fn is_along_rows(&self) -> bool {
        self.x_major
    }

    /// Rise of the lines along the minor axis for one pixel along the major one, in [−1, 1].
    #[must_use]
    pub fn slope(&self) -> f64 {
        self.slope
    }

    /// o(x): the digital line through line 0.
    #[inline]
    fn offset(&self, major: i32) -> i32 {
        float::floor(self.slope * (f64::from(major) + 0.5) + 0.5) as i32
    }

    /// The number k of the line that a pixel belongs to; at the ends of `i32` the nearest number there is.
    #[must_use]
    pub fn line_of(&self, x: i32, y: i32) -> i32 {
        let (major, minor) = if self.x_major { (x, y) } else { (y, x) };
        minor.saturating_sub(self.offset(major))
    }

    /// Visits each pixel of the rectangle `columns` × `rows` whose denominator is positive, once, line by line, with
    /// its attributes.
    ///
    /// The rectangle is cut to pixels within 2²⁵ of the origin. A pixel's value does not depend on the rectangle.
    pub fn walk(
        &self,
        columns: Range<i32>,
        rows: Range<i32>,
        mut emit: impl FnMut(i32, i32, [f64; N]),
    ) {
        let limit = Span::<N>::PIXEL_LIMIT;
        let cut = |r: Range<i32>| r.start.max(-limit)..r.end.min(limit);
        let (columns, rows) = (cut(columns), cut(rows));
        if columns.is_empty() || rows.is_empty() {
            return;
        }
        if self.x_major {
            self.walk_lines(columns, rows, emit);
        } else {
            self.walk_lines(rows, columns, |major, minor, values| emit(minor, major, values));
        }
    }

    fn walk_lines(
        &self,
        majors: Range<i32>,
        minors: Range<i32>,
        mut emit: impl FnMut(i32, i32, [f64; N]),
    ) {
        let offsets: Vec<i32> = majors.clone().map(|x| self.offset(x)).collect();
        let (Some(first), Some(last)) = (offsets.first(), offsets.last()) else { return };
        let (low, high) = (*first.min(last), *first.max(last));
        // Along the ideal line each numerator grows by the same step in every line.
        let steps = self.numerators.map(|[_, p1, p2]| {
            (Twofold::new(p1) + Twofold::new(p2) * Twofold::new(self.slope)).round()
        });
        let rising = self.slope >= 0.0;
        for line in minors.start - high..minors.end - low {
            // The columns in which this line is inside the rectangle: offsets rise or fall with x.
            let (from, to) = (minors.start - line, minors.end - line);
            let (begin, end) = if rising {
                (offsets.partition_point(|o| *o < from), offsets.partition_point(|o| *o < to))
            } else {
                (offsets.partition_point(|o| *o >= to), offsets.partition_point(|o| *o >= from))
            };
            let centre = Twofold::new(f64::from(line) + 0.5);
            let [_, _, r2] = self.denominator;
            let at_zero =
                |[c, _, minor]: [f64; 3]| (Twofold::new(c) + Twofold::new(minor) * centre).round();
            let depth = at_zero(self.denominator);
            let reach = r2.abs() * HALF;
            if depth <= -reach {
                continue;
            }
            let start = self.numerators.map(at_zero);
            let reciprocal = 1.0 / depth;
            let near_horizon = depth <= reach;
            let x = majors.start + begin as i32;
            for (x, o) in (x..).zip(&offsets[begin..end]) {
                if near_horizon {
                    if let Some(values) = self.exact(x, line + o) {
                        emit(x, line + o, values);
                    }
                } else {
                    let centre = f64::from(x) + 0.5;
                    let values: [f64; N] =
                        core::array::from_fn(|k| (start[k] + steps[k] * centre) * reciprocal);
                    emit(x, line + o, values);
                }
            }
        }
    }

    /// The attributes at a pixel's own centre, where its denominator is positive.
    fn exact(&self, major: i32, minor: i32) -> Option<[f64; N]> {
        let (x, y) = (Twofold::new(f64::from(major) + 0.5), Twofold::new(f64::from(minor) + 0.5));
        let form = |[c, p1, p2]: [f64; 3]| {
            (Twofold::new(c) + Twofold::new(p1) * x + Twofold::new(p2) * y).round()
        };
        let depth = form(self.denominator);
        (depth > 0.0).then(|| self.numerators.map(|n| form(n) / depth))
    }

    /// How far the attributes can be from the quotient at the pixels' own centres, over a rectangle.
    ///
    /// ```text
    /// u(S, L + δ) − u(S, L) = δ · ∂u/∂L (S, L) · w / w′,   ∂u/∂L = (P₂ w − n R₂) / w²,   |δ| ≤ ½
    /// ```
    ///
    /// with n and w the forms at the pixel's centre and w′ = w + R₂ δ the line's denominator (L stands for the minor
    /// axis). Proof: (n + P₂ δ)/w′ − n/w = δ (P₂ w − n R₂)/(w w′). ∎ The numerator
    /// P₂ w − n R₂ = P₂ R₀ − P₀ R₂ + (P₂ R₁ − P₁ R₂) S does not contain L, so over a rectangle it is largest in a
    /// corner, as w and w′ are smallest; the bound is the quotient of those extremes, plus rounding. Infinite where
    /// the rectangle comes within a pixel of the horizon; 0 plus rounding where δ = 0.
    #[must_use]
    pub fn error_bound(&self, columns: Range<i32>, rows: Range<i32>) -> [f64; N] {
        let (majors, minors) = if self.x_major { (columns, rows) } else { (rows, columns) };
        if majors.is_empty() || minors.is_empty() {
            return [0.0; N];
        }
        let centres = |r: &Range<i32>| [f64::from(r.start) + 0.5, f64::from(r.end) - 0.5];
        let (xs, ys) = (centres(&majors), centres(&minors));
        let [r0, r1, r2] = self.denominator;
        let far = |c: [f64; 2]| c[0].abs().max(c[1].abs());
        let size =
            |[c, p1, p2]: [f64; 3]| c.abs() + p1.abs() * far(xs) + p2.abs() * (far(ys) + 1.0);
        let depth_error = 4.0 * f64::EPSILON * size(self.denominator);
        let corner = |x: f64, y: f64| {
            (Twofold::new(r0)
                + Twofold::new(r1) * Twofold::new(x)
                + Twofold::new(r2) * Twofold::new(y))
            .round()
        };
        let least = [(0, 0), (0, 1), (1, 0), (1, 1)]
            .iter()
            .map(|&(i, j)| corner(xs[i], ys[j]))
            .fold(f64::INFINITY, f64::min)
            - depth_error;
        let shift = if self.slope == 0.0 { 0.0 } else { HALF };
        let least_on_line = least - shift * r2.abs();
        if !(least_on_line > 0.0) {
            return [f64::INFINITY; N];
        }
        self.numerators.map(|n| {
            let [p0, p1, p2] = n;
            let cross = |a: f64, b: f64, c: f64, d: f64| {
                Twofold::new(a) * Twofold::new(b) + -(Twofold::new(c) * Twofold::new(d))
            };
            let (constant, slope) = (cross(p2, r0, p0, r2), cross(p2, r1, p1, r2));
            let largest = xs
                .iter()
                .map(|x| (constant + slope * Twofold::new(*x)).round().abs())
                .fold(0.0, f64::max);
            let geometric = shift * largest / least / least_on_line;
            // Rounding of both forms, the reciprocal and the product.
            let ratio = size(n) / least_on_line;
            let rounding =
                4.0 * f64::EPSILON * (ratio + ratio * size(self.denominator) / least_on_line);
            geometric * (1.0 + 1e-9) + rounding
        })
    }
}
