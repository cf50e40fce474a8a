//! How large a pixel is in the texture: the longest axis, and the ellipse.

/// Beyond this a derivative counts as it, so that squares of squares stay finite.
const LARGEST: f32 = 1e9;
/// The variance of a pixel: of a square with sides of one.
const PIXEL: f32 = 1.0 / 12.0;
/// The least variance of an ellipse along an axis, texels²; a bilinear lookup has 1/6. Of those between 1/8 and 1/3 the one whose
/// weights' centre is off the position least, by 0.025 texel.
const LEAST: f32 = 0.1875;
/// R²/σ² of the weight (1 − r²/R²)² over a disc.
const SUPPORT: f32 = 8.0;
/// Less is not divided by.
const TINY: f32 = 1e-30;

/// A divisor instead of a branch: where it is less, what it divides is zero.
#[inline(always)]
fn at_least_tiny(x: f32) -> f32 {
    if x > TINY { x } else { TINY }
}

/// ∂u/∂S, ∂v/∂S, ∂u/∂L and ∂v/∂L.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Derivatives(pub(super) [f32; 4]);

impl Derivatives {
    /// Those that are no numbers count as zero.
    #[inline(always)]
    pub(super) fn new(derivatives: [f64; 4]) -> Self {
        Self(derivatives.map(|d| {
            let d = d as f32;
            let d = if d > LARGEST { LARGEST } else { d };
            let d = if d < -LARGEST { -LARGEST } else { d };
            if d.is_nan() { 0.0 } else { d }
        }))
    }

    /// J Jᵀ and |J|².
    #[inline(always)]
    fn square(self) -> (Spread, f32) {
        let Self([us, vs, ul, vl]) = self;
        let determinant = us * vl - vs * ul;
        let spread = Spread { uu: us * us + ul * ul, uv: us * vs + ul * vl, vv: vs * vs + vl * vl };
        (spread, determinant * determinant)
    }

    /// The square of the texel whose bilinear lookup has the variance of the pixel's square along its longest axis: ρ²/3.
    #[inline(always)]
    pub(super) fn texel_squared(self) -> f32 {
        // A texel's own variance and that of the hat between texels: 1/12 + 1/6.
        self.square().0.largest().0 * (PIXEL / (PIXEL + 1.0 / 6.0))
    }
}

/// A symmetric 2 × 2 matrix.
#[derive(Clone, Copy)]
struct Spread {
    uu: f32,
    uv: f32,
    vv: f32,
}

impl Spread {
    /// The larger eigenvalue, and the root it is half the trace and.
    #[inline(always)]
    fn largest(self) -> (f32, f32) {
        let (mean, half) = (0.5 * (self.uu + self.vv), 0.5 * (self.uu - self.vv));
        let root = (half * half + self.uv * self.uv).sqrt();
        (mean + root, root)
    }

    /// The smaller one, without cancellation.
    #[inline(always)]
    fn smallest(largest: f32, determinant: f32) -> f32 {
        determinant / at_least_tiny(largest)
    }
}

/// log₂ x for positive x, to 1.6·10⁻⁵; exact for powers of two.
#[inline(always)]
pub(super) fn log2(x: f32) -> f32 {
    let bits = x.to_bits();
    let exponent = (bits >> 23) as i32 - 127;
    let m = f32::from_bits(bits & 0x7f_ffff | 0x3f80_0000) - 1.0;
    // log₂(1 + m)/m, which is 1 at m = 1.
    let series = 0.045_148_77;
    let series = series * m - 0.193_575;
    let series = series * m + 0.415_605_45;
    let series = series * m - 0.709_096_25;
    let series = series * m + 1.441_917;
    exponent as f32 + m * series
}

/// 2ˣ for |x| ≤ 120, to 4·10⁻⁷ of it; exact for whole numbers.
#[inline(always)]
pub(super) fn exp2(x: f32) -> f32 {
    let whole = floor(x);
    let f = x - whole;
    // (2ᶠ − 1)/f, which is 1 at f = 1.
    let series = 0.001_896_85;
    let series = series * f + 0.008_947_751;
    let series = series * f + 0.055_855_296;
    let series = series * f + 0.240_147_12;
    let series = series * f + 0.693_152_98;
    f32::from_bits(((integer(whole) + 127) as u32) << 23) * (1.0 + f * series)
}

/// 1.5 · 2²³: sums with small numbers are whole.
const WHOLE: f32 = 12_582_912.0;

/// The nearest whole number, for |x| < 2²².
#[inline(always)]
pub(super) fn nearest(x: f32) -> f32 {
    (x + WHOLE) - WHOLE
}

/// ⌊x⌋, for |x| < 2²².
#[inline(always)]
pub(super) fn floor(x: f32) -> f32 {
    let whole = nearest(x);
    if whole > x { whole - 1.0 } else { whole }
}

/// The nearest integer, for |x| < 2²².
#[inline(always)]
pub(super) fn integer(x: f32) -> i32 {
    (x + WHOLE).to_bits() as i32 - WHOLE.to_bits() as i32
}

/// The value between two levels; that of the finer one where the coarser has no share, whatever it is.
#[inline(always)]
pub(super) fn mix(fine: f32, coarse: f32, share: f32) -> f32 {
    let between = fine + share * (coarse - fine);
    if share == 0.0 { fine } else { between }
}

/// What an elliptical weighted average needs to know of a pyramid and of its own limits.
#[derive(Clone, Copy, Debug)]
pub(super) struct Limits {
    /// 1/A², A the largest ratio of the axes.
    shape: f32,
    /// The largest variance along the shorter and along the longer axis; only the last level comes to them.
    most: [f32; 2],
    /// ½ / log₂ r.
    half_levels: f32,
    /// 1/(r − 1).
    by_step: f32,
    /// The last level.
    last: f32,
}

impl Limits {
    pub(super) fn new(anisotropy: f32, ratio: f64, levels: usize) -> Self {
        let anisotropy = anisotropy.max(1.0);
        // Where there is a next level it would be taken at r²(³⁄₁₆ + ¹⁄₁₂).
        let most = (0.5 * ratio * ratio) as f32;
        Self {
            shape: 1.0 / (anisotropy * anisotropy),
            most: [most, most * anisotropy * anisotropy],
            half_levels: (0.5 / ratio.log2()) as f32,
            by_step: (1.0 / (ratio - 1.0)) as f32,
            last: levels.saturating_sub(1) as f32,
        }
    }

    /// A level within those there are.
    #[inline(always)]
    fn within(&self, level: f32) -> f32 {
        let level = if level < self.last { level } else { self.last };
        if level > 0.0 { level } else { 0.0 }
    }

    /// The level of detail: logᵣ of the texel to look up, within the levels there are.
    #[inline(always)]
    fn detail(&self, squared: f32) -> f32 {
        self.within(self.half_levels * log2(at_least_tiny(squared)))
    }

    /// The level nearest to the level of detail.
    #[inline(always)]
    pub(super) fn level_of_detail(&self, derivatives: Derivatives) -> f32 {
        nearest(self.detail(derivatives.texel_squared()))
    }

    /// The level below the texel s to look up, and the share of the next one: (s/rᵏ − 1)/(r − 1), so that the mean of both
    /// texels is s.
    #[inline(always)]
    pub(super) fn between(&self, derivatives: Derivatives) -> (f32, f32) {
        let squared = derivatives.texel_squared();
        let level = floor(self.detail(squared));
        (level, self.share(squared, level))
    }

    /// (ρ/rᵏ − 1)/(r − 1) within 0 and 1, for ρ² and k.
    #[inline(always)]
    fn share(&self, squared: f32, level: f32) -> f32 {
        let texel = exp2(-level / (2.0 * self.half_levels));
        let share = (squared.sqrt() * texel - 1.0) * self.by_step;
        let share = if share > 0.0 { share } else { 0.0 };
        if share < 1.0 { share } else { 1.0 }
    }

    /// The level that an ellipse is looked up in, before it is made whole: the coarsest whose texels it still
    /// resolves along its shorter axis, or along the one it is widened to.
    #[inline(always)]
    pub(super) fn level(&self, derivatives: Derivatives) -> f32 {
        let (square, determinant) = derivatives.square();
        let (largest, _) = square.largest();
        let smallest = Spread::smallest(largest, determinant);
        let widened = largest * self.shape;
        let smallest = PIXEL * if smallest > widened { smallest } else { widened };
        // A texel's own spread is 1/12 of its square, and the weights' at least `LEAST`.
        let texels = smallest / (LEAST + PIXEL);
        self.detail(texels)
    }
}

/// An ellipse about a position in a level, cut into its rows.
///
/// With r² = dy² `down` + (dx − `slope` dy)² `across` the weight is (1 − r²)² where r² < 1.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ellipse {
    pub(super) slope: f32,
    pub(super) down: f32,
    pub(super) across: f32,
    /// Half its height.
    pub(super) height: f32,
    /// Half its width at its middle row.
    pub(super) width: f32,
}

impl Ellipse {
    /// The ellipse of a pixel in a level of `scale` texels a texel of the picture, which has the variance `own` itself.
    #[inline(always)]
    pub(super) fn new(
        derivatives: Derivatives,
        [su, sv]: [f32; 2],
        own: f32,
        limits: &Limits,
    ) -> Self {
        let Derivatives([us, vs, ul, vl]) = derivatives;
        let (square, determinant) = Derivatives([us * su, vs * sv, ul * su, vl * sv]).square();
        let (largest, root) = square.largest();
        let smallest = Spread::smallest(largest, determinant);
        let [least_most, most] = limits.most;
        let long = PIXEL * largest - own;
        let long = if long > LEAST { long } else { LEAST };
        let long = if long < most { long } else { most };
        let short = PIXEL * smallest - own;
        let short = if short > LEAST { short } else { LEAST };
        let short = if short < least_most { short } else { least_most };
        let widened = long * limits.shape;
        let short = if short > widened { short } else { widened };
        // The directions stay, the variances along them are the new ones.
        let mean = 0.5 * (long + short);
        let turn = 0.5 * (long - short) / at_least_tiny(root);
        let (half, uv) = (turn * 0.5 * (square.uu - square.vv), turn * square.uv);
        let vv = mean - half;
        let slope = uv / vv;
        let across = long * short / vv;
        Self {
            slope,
            down: 1.0 / (SUPPORT * vv),
            across: 1.0 / (SUPPORT * across),
            height: (SUPPORT * vv).sqrt(),
            width: (SUPPORT * across).sqrt(),
        }
    }

    /// At most half its whole width.
    #[inline(always)]
    pub(super) fn reach(&self) -> f32 {
        self.slope.abs() * self.height + self.width
    }

    /// How many groups of four texels its widest row takes.
    #[inline(always)]
    pub(super) fn groups(&self) -> i32 {
        // At most ⌊2 w⌋ + 1 texel centres lie within.
        (integer(2.0 * self.width + 0.5) + 1 + 3) >> 2
    }
}
