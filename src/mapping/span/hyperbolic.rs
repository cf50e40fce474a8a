//! Whole rows of a span: exactly, and incrementally with a bound on the drift.

use core::ops::Range;

use super::linear::{LINEAR_ERROR, Linear, RAMP};
use super::{BLOCK, Span};

/// u, the unit roundoff of `f64`.
const UNIT: f64 = 0.5 * f64::EPSILON;
/// Interleaved walks in one block.
pub(crate) const LANES: usize = 8;
/// The most additions between an anchor and a pixel: one from lane to lane, whose product rounds by less than another, and
/// one a step of the lanes.
const ADDITIONS: u32 = 2 + (BLOCK / LANES) as u32 - 1;
/// A block is walked only if its denominators differ by no more than this factor.
const WALKABLE: f64 = 64.0;
/// And only if they lie between these, so that the product of two neither overflows nor loses digits.
const MULTIPLIABLE: [f64; 2] = [1e-150, 1e150];
/// Covers the rounding of a bound's own arithmetic.
pub(super) const OUTWARD: f64 = 1.0 + 1.0 / (1u64 << 40) as f64;

/// A linear form on a block of 64 pixels.
#[derive(Clone, Copy)]
pub(crate) struct Form {
    /// The value at its first pixel, rounded once.
    first: f64,
    step: f64,
}

/// What a block is walked with.
#[derive(Clone, Copy)]
pub(crate) struct Forms<const N: usize> {
    pub(crate) depth: Form,
    /// 1/d at the first pixel: everywhere, if its form has no step.
    pub(crate) reciprocal: f64,
    pub(crate) numerators: [Form; N],
}

impl Form {
    /// The values at the first pixels, each rounded twice more.
    #[inline(always)]
    pub(crate) fn lanes(&self) -> [f64; LANES] {
        let mut lanes = [0.0; LANES];
        for i in 0..LANES {
            lanes[i] = self.first + self.step * RAMP[i];
        }
        lanes
    }

    /// From each of them to the next one of its chain.
    #[inline(always)]
    pub(crate) fn step_of_lanes(&self) -> f64 {
        LANES as f64 * self.step
    }
}

/// γₖ = k u / (1 − k u).
fn gamma(k: f64) -> f64 {
    k * UNIT / (1.0 - k * UNIT)
}

impl<const N: usize> Span<N> {
    /// The attributes of the pixels of `range` in the valid interval, each within 4 ulp.
    ///
    /// `emit` is called with the x of a first pixel and, for each attribute, the values there and at the pixels that
    /// follow, ascending, at most 64 at once. The values equal [`at`](Self::at)'s bit for bit; where that reports an
    /// overflow they are infinite or NaN.
    pub fn exact(&self, range: Range<i32>, mut emit: impl FnMut(i32, [&[f64]; N])) {
        let valid = self.valid_interval(range);
        let mut values = [[0.0; BLOCK]; N];
        let mut x = valid.start;
        while x < valid.end {
            let count = ((valid.end - x) as usize).min(BLOCK);
            self.fill_exact(x, count, &mut values);
            emit(x, values.each_ref().map(|v| &v[..count]));
            x += count as i32;
        }
    }

    /// Writes the first `count` attributes from pixel `x` on.
    #[inline]
    pub(super) fn fill_exact(&self, x: i32, count: usize, values: &mut [[f64; BLOCK]; N]) {
        let x = self.relative(x);
        let mut reciprocals = [0.0; BLOCK];
        let reciprocals = &mut reciprocals[..count];
        self.denominator.fill(x, reciprocals);
        for r in reciprocals.iter_mut() {
            *r = 1.0 / *r;
        }
        for (values, numerator) in values.iter_mut().zip(&self.numerators) {
            let values = &mut values[..count];
            numerator.fill(x, values);
            for (v, r) in values.iter_mut().zip(&*reciprocals) {
                *v *= r;
            }
        }
    }

    /// The attributes of the pixels of `range` in the valid interval, incrementally.
    ///
    /// A pixel costs N + 1 additions, half a division and N + 1½ products: 1/a and 1/b are b/(a b) and a/(a b). Each block of
    /// 64 pixels, from an absolute multiple of 64 to the next, starts from an exact value, and eight neighbouring chains
    /// from there add eight steps at a time side by side, so no value is more than 9 roundings from an exact one. Where
    /// the denominator has no step nothing is divided. A block in which the denominator changes by more than 64 times,
    /// or its sign, or is beyond 10^±150, is evaluated exactly. `emit` is called as by [`exact`](Self::exact).
    /// [`walk_bound`](Self::walk_bound) says how far the values can be off.
    ///
    /// ```
    /// use collinear::mapping::span::Span;
    ///
    /// let span = Span::new([[3.0, 2.0]], [1.0, 1.0])?;
    /// let mut row = Vec::new();
    /// span.walk(0..200, |_, [u]| row.extend_from_slice(u));
    /// assert!((row[199] - 401.0 / 200.0).abs() <= span.walk_bound(0..200)[0]);
    /// # Ok::<(), collinear::Error>(())
    /// ```
    #[inline(always)]
    pub fn walk(&self, range: Range<i32>, mut emit: impl FnMut(i32, [&[f64]; N])) {
        let valid = self.valid_interval(range);
        let mut values = [[0.0; BLOCK]; N];
        let mut x = valid.start;
        while x < valid.end {
            let anchor = x & !(BLOCK as i32 - 1);
            let from = (x - anchor) as usize;
            let count = ((valid.end - x) as usize).min(BLOCK - from);
            self.walk_block(anchor, |start, lanes| {
                for (values, lanes) in values.iter_mut().zip(lanes) {
                    values[start..start + LANES].copy_from_slice(&lanes);
                }
            });
            emit(x, values.each_ref().map(|v| &v[from..from + count]));
            x += count as i32;
        }
    }

    /// The attributes of the 64 pixels from `anchor` on, a multiple of 64, as [`walk`](Self::walk) has them: `emit` is called
    /// with the number of a first pixel and the attributes there and at the seven that follow. Outside the valid interval
    /// they are without meaning.
    #[inline(always)]
    pub(crate) fn walk_block(&self, anchor: i32, mut emit: impl FnMut(usize, [[f64; LANES]; N])) {
        let Some(forms) = self.forms(anchor) else {
            let mut values = [[0.0; BLOCK]; N];
            self.fill_exact(anchor, BLOCK, &mut values);
            for start in (0..BLOCK).step_by(LANES) {
                emit(start, values.map(|v| core::array::from_fn(|i| v[start + i])));
            }
            return;
        };
        // Eight chains of each form, all advancing together, so that nothing but the quotients leaves the registers.
        let mut depths = forms.depth.lanes();
        let mut sums = forms.numerators.map(|n| n.lanes());
        let depth_step = forms.depth.step_of_lanes();
        let steps = forms.numerators.map(|n| n.step_of_lanes());
        for start in (0..BLOCK).step_by(2 * LANES) {
            let mut reciprocals = [[forms.reciprocal; LANES]; 2];
            if depth_step != 0.0 {
                for i in 0..LANES {
                    let a = depths[i];
                    let b = a + depth_step;
                    depths[i] = b + depth_step;
                    let of_both = 1.0 / (a * b);
                    reciprocals[0][i] = of_both * b;
                    reciprocals[1][i] = of_both * a;
                }
            }
            for (half, reciprocals) in reciprocals.iter().enumerate() {
                let mut values = [[0.0; LANES]; N];
                for k in 0..N {
                    for i in 0..LANES {
                        values[k][i] = sums[k][i] * reciprocals[i];
                        sums[k][i] += steps[k];
                    }
                }
                emit(start + half * LANES, values);
            }
        }
    }

    /// The forms of the block of 64 pixels from `anchor` on; `None` if it is to be evaluated exactly.
    #[inline(always)]
    pub(crate) fn forms(&self, anchor: i32) -> Option<Forms<N>> {
        let x = self.relative(anchor);
        let form = |linear: &Linear| Form { first: linear.at(x), step: linear.step };
        let depth = form(&self.denominator);
        self.is_walkable(depth.first).then(|| Forms {
            depth,
            reciprocal: 1.0 / depth.first,
            numerators: self.numerators.each_ref().map(form),
        })
    }

    /// Whether the denominators of a block differ little, by the one at its first pixel. Of a block with valid pixels at least
    /// one is positive, and the comparisons then fail unless both ends are.
    #[inline(always)]
    fn is_walkable(&self, first: f64) -> bool {
        // Where the comparisons hold nothing has cancelled.
        let last = first + (BLOCK - 1) as f64 * self.denominator.step;
        let [least, most] = MULTIPLIABLE;
        first <= WALKABLE * last && last <= WALKABLE * first && first >= least && first <= most
    }

    /// How far an attribute of [`walk`](Self::walk) can be from the exact ratio at the valid pixels of `range`.
    ///
    /// The largest [`drift_bound`](Self::drift_bound) with 9 additions among the blocks that `range` touches, or 4 ulp in
    /// those that are evaluated exactly. The cost is a look at each block.
    #[must_use]
    pub fn walk_bound(&self, range: Range<i32>) -> [f64; N] {
        let valid = self.valid_interval(range);
        let mut bound = [0.0; N];
        if valid.is_empty() {
            return bound;
        }
        let mut anchor = valid.start & !(BLOCK as i32 - 1);
        while anchor < valid.end {
            let block = anchor..anchor + BLOCK as i32;
            let first = self.denominator.at(self.relative(anchor));
            let of_block = if self.is_walkable(first) {
                self.bound(block, ADDITIONS)
            } else {
                self.exact_bound(block.start.max(valid.start)..block.end.min(valid.end))
            };
            for (b, o) in bound.iter_mut().zip(of_block) {
                *b = f64::max(*b, o);
            }
            anchor += BLOCK as i32;
        }
        bound
    }

    /// The attributes of the pixels of `range` in the valid interval by the textbook loop, which adds the steps from
    /// the first pixel to the last and never looks back.
    ///
    /// It is here to be compared: its values depend on where the range begins, and drift as
    /// [`drift_bound`](Self::drift_bound) with (pixels − 1) additions says. A pixel at which drift has taken the
    /// denominator's sign is NaN. `emit` is called as by [`exact`](Self::exact).
    pub fn walk_unanchored(&self, range: Range<i32>, mut emit: impl FnMut(i32, [&[f64]; N])) {
        let valid = self.valid_interval(range);
        let at = self.relative(valid.start);
        let mut depth = self.denominator.at(at);
        let mut sums = self.numerators.map(|l| l.at(at));
        let mut values = [[0.0; BLOCK]; N];
        let mut x = valid.start;
        while x < valid.end {
            let count = ((valid.end - x) as usize).min(BLOCK);
            for i in 0..count {
                let reciprocal = if depth > 0.0 { 1.0 / depth } else { f64::NAN };
                depth += self.denominator.step;
                for k in 0..N {
                    values[k][i] = sums[k] * reciprocal;
                    sums[k] += self.numerators[k].step;
                }
            }
            emit(x, values.each_ref().map(|v| &v[..count]));
            x += count as i32;
        }
    }

    /// How far an attribute can be from the exact ratio at the valid pixels of `range`, when every form was reached
    /// there by at most `additions` additions of its step from a rounded exact value; infinite where the denominator
    /// may have drifted to zero.
    ///
    /// ```text
    /// |v̂ − v| ≤ γₘ₊₁ (1 + 2⁻²³) max|v|,   γₖ = k u / (1 − k u),   u = 2⁻⁵³        (m additions)
    /// |û − u*| ≤ (Eₙ + max|u*| E_d) / (min c − E_d), and four roundings
    /// ```
    ///
    /// Proof. The start is rounded once, |v̂₀ − v₀| ≤ u (1 + 2⁻²³) |v₀|. An addition rounds its exact sum:
    /// εᵢ ≤ εᵢ₋₁ + u (|vᵢ| + εᵢ₋₁). With M = max|v| this unrolls to εₘ ≤ M ((1 + u)ᵐ⁺¹ − 1)(1 + 2⁻²³) ≤
    /// γₘ₊₁ (1 + 2⁻²³) M; to first order (m + 1) u M. Linear forms take their extremes at the range's ends, and so
    /// does the ratio, which is monotone where its denominator keeps its sign. For the quotient
    /// n̂/d̂ − n/d = ((n̂ − n) − (n/d)(d̂ − d)) / d̂; the reciprocal from a product of two denominators then
    /// rounds three times, and the product once. ∎
    #[must_use]
    pub fn drift_bound(&self, range: Range<i32>, additions: u32) -> [f64; N] {
        let valid = self.valid_interval(range);
        if valid.is_empty() { [0.0; N] } else { self.bound(valid, additions) }
    }

    /// The bound on exact values at a range of positive denominators, which are largest at its ends.
    pub(super) fn exact_bound(&self, range: Range<i32>) -> [f64; N] {
        let ends = [range.start, range.end - 1].map(|x| self.relative(x));
        self.numerators.map(|l| {
            let [a, b] = ends.map(|x| (l.at(x) / self.denominator.at(x)).abs());
            4.5 * UNIT * a.max(b)
        })
    }

    /// The bound on a range of positive denominators.
    fn bound(&self, range: Range<i32>, additions: u32) -> [f64; N] {
        let ends = [self.relative(range.start), self.relative(range.end - 1)];
        let factor = gamma(f64::from(additions) + 1.0) * (LINEAR_ERROR / UNIT);
        let depths = ends.map(|x| self.denominator.at(x));
        let depth_error = factor * depths[0].max(depths[1]);
        let least = depths[0].min(depths[1]) - depth_error;
        if !(least > 0.0) {
            return [f64::INFINITY; N];
        }
        self.numerators.map(|l| {
            let values = ends.map(|x| l.at(x));
            let error = factor * values[0].abs().max(values[1].abs());
            let ratio = (values[0] / depths[0]).abs().max((values[1] / depths[1]).abs());
            let forms = (error + ratio * depth_error) / least;
            (forms + 4.5 * UNIT * (ratio + forms)) * OUTWARD
        })
    }
}
