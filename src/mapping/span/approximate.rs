//! Polynomials in place of the hyperbola, on runs of n pixels, with the error they make.

use core::ops::Range;

use super::hyperbolic::OUTWARD;
use super::linear::RAMP;
use super::{BLOCK, Span};
use crate::error::Error;
use crate::numeric::float;
use crate::numeric::twofold::Twofold;

/// The degree of the polynomial that replaces the hyperbola within a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Degree {
    /// A straight line between the exact values at the run's ends.
    Affine,
    /// A parabola through the ends and the middle.
    Quadratic,
    /// A cubic through the ends and the two thirds.
    Cubic,
}

impl Degree {
    const fn get(self) -> usize {
        match self {
            Self::Affine => 1,
            Self::Quadratic => 2,
            Self::Cubic => 3,
        }
    }
}

/// Interpolation of the hyperbola by polynomials on runs of n pixels.
///
/// *Model.* A run goes from an absolute multiple of n to the next. In it each attribute is the polynomial of degree
/// k through the exact values at k + 1 equally spaced nodes, the first and last shared with the neighbouring runs: one
/// division every n/k pixels. Runs whose nodes do not all have positive denominators, and runs of one pixel, are
/// exact. A pixel's value depends on its own x alone.
///
/// *Accuracy.* With u = α + β/w, w = c + d x the denominator, and wᵢ its values at the nodes,
///
/// ```text
/// u(w) − p(w) = (−1)ᵏ⁺¹ β ∏(w − wᵢ) / (w ∏wᵢ)                                     exactly
/// affine:        max |u − p| = |β| (√w₁ − √w₀)² / (w₀ w₁)      at w = √(w₀ w₁)
/// quadratic:     |u − p| ≤ |D| d² n³ (√3/36) / (min w · w₀ w₁ w₂)
/// cubic:         |u − p| ≤ |D| |d|³ n⁴ (1/81) / (min w · w₀ w₁ w₂ w₃)
/// ```
///
/// where D = a d − b c = β d. Proof of the identity: w ∏wᵢ (1/w − q(w)) for the interpolant q of 1/w is a polynomial
/// of degree k + 1 in w with zeros at the nodes and the value ∏wᵢ at w = 0, hence (−1)ᵏ⁺¹ ∏(w − wᵢ). The affine maximum
/// is where w + w₀w₁/w is least. In the others √3/36 and 1/81 are the maxima of ∏|t − i/k| on [0, 1], taken in the
/// run's outermost intervals; with R the ratio of the larger to the smaller end of w over the run the true maximum is
/// at least 1/(1 + 0.2114 (R − 1)) of the bound for the quadratic and 1/(1 + 0.1274 (R − 1)) for the cubic, the
/// fractions being where those maxima lie. The bound includes 2¹¹ u max|u| for rounding.
///
/// ```
/// use collinear::mapping::span::{Approximation, Degree, Span};
///
/// // A floor seen at a slant: w falls from 1000 by 1 a pixel.
/// let span = Span::new([[0.0, 500.0]], [1000.0, -1.0])?;
/// let affine = Approximation::for_tolerance(&span, 0..512, 0.1, Degree::Affine);
/// // The largest distance of chord and hyperbola at the far end, sampled (mpmath 1.3.0): 0.067179 texels on 8 pixels,
/// // 0.262329 on 16.
/// assert_eq!(affine.run(), 8);
/// assert!((affine.error_bound(&span, 0..512)[0] - 0.067_178_54).abs() < 1e-8);
/// assert_eq!(Approximation::for_tolerance(&span, 0..512, 0.1, Degree::Cubic).run(), 128);
/// # Ok::<(), collinear::Error>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Approximation {
    degree: Degree,
    run: u32,
}

/// What rounding can add, over M = max|u|. With t ≤ 3, |Δⁱ| ≤ 2ⁱ M and Σ|cᵢ| tⁱ ≤ 111 M for the cubic: nodes 65 u M,
/// differences and coefficients 448 u M, Horner's six roundings 666 u M, two roundings of t 474 u M. Less than 2¹¹ u M.
const ROUNDING: f64 = 2048.0 * 0.5 * f64::EPSILON;

impl Approximation {
    /// The longest run, in pixels.
    pub const MAX_RUN: u32 = 1024;

    /// Polynomials of a degree on runs of `run` pixels.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] for a run of 0 or more than [`MAX_RUN`](Self::MAX_RUN) pixels.
    pub fn new(degree: Degree, run: u32) -> Result<Self, Error> {
        if (1..=Self::MAX_RUN).contains(&run) {
            Ok(Self { degree, run })
        } else {
            Err(Error::OutOfRange {
                what: "run of a span approximation",
                value: f64::from(run),
                expected: "1 to 1024 pixels",
            })
        }
    }

    /// The longest run, a power of two, that keeps every attribute within `tolerance` on the valid pixels of `range`.
    ///
    /// A run of one pixel, which is exact, where no longer one does: for a row that comes near the horizon, where a
    /// longer run would be evaluated exactly anyway, and for a tolerance that is negative or NaN.
    #[must_use]
    pub fn for_tolerance<const N: usize>(
        span: &Span<N>,
        range: Range<i32>,
        tolerance: f64,
        degree: Degree,
    ) -> Self {
        let valid = span.valid_interval(range.clone());
        let mut run = Self::MAX_RUN;
        while run > 1 && !valid.is_empty() {
            let approximation = Self { degree, run };
            let bound = approximation.error_bound(span, range.clone());
            let approximated = [valid.start, valid.end - 1]
                .map(|x| approximation.nodes(span, approximation.start_of_run(x)).is_some());
            if approximated == [true; 2] && bound.iter().all(|b| *b <= tolerance) {
                return approximation;
            }
            run /= 2;
        }
        Self { degree, run: 1 }
    }

    /// The polynomials' degree.
    #[must_use]
    pub fn degree(&self) -> Degree {
        self.degree
    }

    /// Pixels in a run.
    #[must_use]
    pub fn run(&self) -> u32 {
        self.run
    }

    fn length(&self) -> i32 {
        self.run as i32
    }

    fn start_of_run(&self, x: i32) -> i32 {
        x.div_euclid(self.length()) * self.length()
    }

    /// How far each attribute can be from the hyperbola at the valid pixels of `range`.
    ///
    /// The bound falls as w grows, so the run with the smallest w decides: the first or the last that is approximated.
    #[must_use]
    pub fn error_bound<const N: usize>(&self, span: &Span<N>, range: Range<i32>) -> [f64; N] {
        let valid = span.valid_interval(range);
        if valid.is_empty() {
            return [0.0; N];
        }
        let (mut first, mut last) =
            (self.start_of_run(valid.start), self.start_of_run(valid.end - 1));
        // w is linear: only the outermost run can touch the horizon, and the next one is clear of it.
        let mut bound = [0.0; N];
        if first < last && self.nodes(span, first).is_none() {
            first += self.length();
        }
        if last > first && self.nodes(span, last).is_none() {
            last -= self.length();
        }
        for run in [first, last] {
            if let Some(w) = self.nodes(span, run) {
                for (b, of_run) in bound.iter_mut().zip(self.bound_of_run(span, run, w)) {
                    *b = f64::max(*b, of_run);
                }
            }
        }
        let exact = span.exact_bound(valid);
        core::array::from_fn(|k| f64::max(bound[k], exact[k]))
    }

    /// w at a run's two ends, where the run is approximated.
    #[inline]
    fn nodes<const N: usize>(&self, span: &Span<N>, run: i32) -> Option<[f64; 2]> {
        let x = span.relative(run);
        let w = [span.denominator.at(x), span.denominator.at(x + f64::from(self.run))];
        (self.run > 1 && w[0] > 0.0 && w[1] > 0.0).then_some(w)
    }

    fn bound_of_run<const N: usize>(&self, span: &Span<N>, run: i32, w: [f64; 2]) -> [f64; N] {
        let n = f64::from(self.run);
        let near = w[0].min(w[1]);
        // d n, the change of w over the run.
        let change = (span.denominator.step * n).abs();
        let third = (w[1] - w[0]) / 3.0;
        let shape = match self.degree {
            Degree::Affine => {
                let roots = float::sqrt(w[0]) + float::sqrt(w[1]);
                (change / roots) / roots
            }
            Degree::Quadratic => {
                let (maximum, middle) = (float::sqrt(3.0) / 36.0, 0.5 * (w[0] + w[1]));
                maximum * (change / near) * (change / middle)
            }
            Degree::Cubic => {
                let inner = (change / (w[0] + third)) * (change / (w[1] - third));
                inner * (change / near) / 81.0
            }
        };
        let x = span.relative(run);
        let [c, d] = span.denominator().map(Twofold::new);
        core::array::from_fn(|k| {
            let numerator = &span.numerators[k];
            let (a, b) = (Twofold::new(numerator.at_origin), Twofold::new(numerator.step));
            let determinant = (a * d - b * c).round().abs();
            // |D| n · shape / (w₀ w₁), the remaining factors of w being in `shape`.
            let interpolation = (determinant * n / w[0]) / w[1] * shape;
            let largest = [(x, w[0]), (x + n, w[1])].map(|(x, w)| (numerator.at(x) / w).abs());
            interpolation * OUTWARD + ROUNDING * f64::max(largest[0], largest[1])
        })
    }

    /// The attributes of the pixels of `range` in the valid interval. `emit` is called as by [`Span::exact`].
    pub fn walk<const N: usize>(
        &self,
        span: &Span<N>,
        range: Range<i32>,
        mut emit: impl FnMut(i32, [&[f64]; N]),
    ) {
        match self.degree {
            Degree::Affine => self.walk_degree::<N, 1>(span, range, &mut emit),
            Degree::Quadratic => self.walk_degree::<N, 2>(span, range, &mut emit),
            Degree::Cubic => self.walk_degree::<N, 3>(span, range, &mut emit),
        }
    }

    #[inline(always)]
    fn walk_degree<const N: usize, const K: usize>(
        &self,
        span: &Span<N>,
        range: Range<i32>,
        emit: &mut impl FnMut(i32, [&[f64]; N]),
    ) {
        debug_assert_eq!(K, self.degree.get());
        let valid = span.valid_interval(range);
        let mut values = [[0.0; BLOCK]; N];
        // The end of one run is the start of the next; it is the same number computed once.
        let mut end: Option<(i32, End<N>)> = None;
        let mut x = valid.start;
        while x < valid.end {
            let run = self.start_of_run(x);
            let next = run + self.length();
            let stop = next.min(valid.end);
            let start = match end {
                Some((at, known)) if at == run => known,
                _ => End::at(span, run),
            };
            let finish = End::at(span, next);
            end = Some((next, finish));
            let approximated = self.run > 1 && start.depth > 0.0 && finish.depth > 0.0;
            let polynomials = polynomials::<N, K>(&start, &finish);
            let per_pixel = K as f64 / f64::from(self.run);
            while x < stop {
                let count = ((stop - x) as usize).min(BLOCK);
                if approximated {
                    let from = f64::from(x - run);
                    for (values, c) in values.iter_mut().zip(&polynomials) {
                        for (value, i) in values[..count].iter_mut().zip(&RAMP) {
                            let t = (from + i) * per_pixel;
                            *value = horner::<K>(c, t);
                        }
                    }
                } else {
                    span.fill_exact(x, count, &mut values);
                }
                emit(x, values.each_ref().map(|v| &v[..count]));
                x += count as i32;
            }
        }
    }
}

#[inline(always)]
fn horner<const K: usize>(c: &[f64; 4], t: f64) -> f64 {
    let mut sum = c[K];
    for power in (0..K).rev() {
        sum = sum * t + c[power];
    }
    sum
}

/// The exact forms at a run's end.
#[derive(Clone, Copy)]
struct End<const N: usize> {
    numerators: [f64; N],
    depth: f64,
    values: [f64; N],
}

impl<const N: usize> End<N> {
    #[inline(always)]
    fn at(span: &Span<N>, x: i32) -> Self {
        let x = span.relative(x);
        let depth = span.denominator.at(x);
        let numerators = span.numerators.map(|l| l.at(x));
        let reciprocal = 1.0 / depth;
        Self { numerators, depth, values: numerators.map(|n| n * reciprocal) }
    }
}

/// The coefficients in t = 0 … K of the polynomials through the values at t = 0, 1, …, K (Newton's forward
/// differences, multiplied out). The forms at inner nodes lie between those at the ends, so they cannot cancel.
#[inline(always)]
fn polynomials<const N: usize, const K: usize>(start: &End<N>, finish: &End<N>) -> [[f64; 4]; N] {
    let mut nodes = [[0.0; 4]; N];
    for i in 1..K {
        let t = i as f64 / K as f64;
        let reciprocal = 1.0 / (start.depth + (finish.depth - start.depth) * t);
        for k in 0..N {
            let (a, b) = (start.numerators[k], finish.numerators[k]);
            nodes[k][i] = (a + (b - a) * t) * reciprocal;
        }
    }
    for k in 0..N {
        nodes[k][0] = start.values[k];
        nodes[k][K] = finish.values[k];
    }
    nodes.map(|u| {
        let first = u[1] - u[0];
        if K == 1 {
            return [u[0], first, 0.0, 0.0];
        }
        let second = u[2] - 2.0 * u[1] + u[0];
        if K == 2 {
            return [u[0], first - 0.5 * second, 0.5 * second, 0.0];
        }
        let third = u[3] - 3.0 * (u[2] - u[1]) - u[0];
        [u[0], first - 0.5 * second + third / 3.0, 0.5 * (second - third), third / 6.0]
    })
}
