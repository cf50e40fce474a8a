//! The weights of separable filters.

use super::filter::Cubic;

/// A separable filter: the weights of N taps along an axis, whose second middle one lies `fraction` behind the position.
///
/// With f = fraction the taps lie at −(N/2 − 1) … N/2, the position at f ∈ [0, 1]. The weights sum to one.
pub(super) trait Kernel<const N: usize>: Copy {
    fn weights(&self, fraction: f32) -> [f32; N];
}

/// Σ wᵢ tᵢ, from the first to the last.
#[inline(always)]
pub(super) fn dot<const N: usize>(weights: &[f32; N], taps: &[f32; N]) -> f32 {
    let mut sum = weights[0] * taps[0];
    for i in 1..N {
        sum += weights[i] * taps[i];
    }
    sum
}

/// The bilinear mean of the quadrilateral a b / c d.
#[inline(always)]
pub(super) fn bilinear([a, b, c, d]: [f32; 4], fu: f32, fv: f32) -> f32 {
    let top = a + fu * (b - a);
    let bottom = c + fu * (d - c);
    top + fv * (bottom - top)
}

/// A cubic filter's four weights as polynomials of the fraction.
#[derive(Clone, Copy)]
pub(super) struct CubicWeights {
    /// Coefficients of 1, f, f², f³ for each tap.
    taps: [[f32; 4]; 4],
}

impl CubicWeights {
    pub(super) fn new(cubic: Cubic) -> Self {
        let taps = cubic.polynomials().map(|p| p.map(|c| c as f32));
        Self { taps }
    }
}

impl Kernel<4> for CubicWeights {
    #[inline(always)]
    fn weights(&self, f: f32) -> [f32; 4] {
        self.taps.map(|[c0, c1, c2, c3]| ((c3 * f + c2) * f + c1) * f + c0)
    }
}

/// Lanczos weights of N = 2 n taps, normalised.
#[derive(Clone, Copy)]
pub(super) struct LanczosWeights<const N: usize> {
    /// (−1)ⁱ cos(π i/n) and (−1)ⁱ sin(π i/n) for each tap i.
    turns: [[f32; 2]; N],
    /// (π/n)².
    squared: f32,
    /// π/n.
    step: f32,
}

impl<const N: usize> LanczosWeights<N> {
    pub(super) fn new() -> Self {
        let n = N as f64 / 2.0;
        let step = core::f64::consts::PI / n;
        let turns = core::array::from_fn(|k| {
            let i = k as f64 - (n - 1.0);
            let sign = if k % 2 == (N / 2 - 1) % 2 { 1.0 } else { -1.0 };
            let (sin, cos) = (step * i).sin_cos();
            [(sign * cos) as f32, (sign * sin) as f32]
        });
        Self { turns, squared: (step * step) as f32, step: step as f32 }
    }

    /// sin(π f/n)/f, by Taylor's series to (π/2)¹⁴/15! < 5·10⁻¹⁰.
    #[inline(always)]
    fn sine_over(&self, f: f32) -> f32 {
        let x = self.squared * f * f;
        let series = 1.0 / 6_227_020_800.0;
        let series = series * x - 1.0 / 39_916_800.0;
        let series = series * x + 1.0 / 362_880.0;
        let series = series * x - 1.0 / 5040.0;
        let series = series * x + 1.0 / 120.0;
        let series = series * x - 1.0 / 6.0;
        self.step * (series * x + 1.0)
    }

    /// cos(π f/n), by Taylor's series to (π/2)¹⁶/16! < 10⁻¹⁰.
    #[inline(always)]
    fn cosine(&self, f: f32) -> f32 {
        let x = self.squared * f * f;
        let series = -1.0 / 87_178_291_200.0;
        let series = series * x + 1.0 / 479_001_600.0;
        let series = series * x - 1.0 / 3_628_800.0;
        let series = series * x + 1.0 / 40_320.0;
        let series = series * x - 1.0 / 720.0;
        let series = series * x + 1.0 / 24.0;
        let series = series * x - 0.5;
        series * x + 1.0
    }
}

impl<const N: usize> Kernel<N> for LanczosWeights<N> {
    /// The window's weight at the distance d = f − i is sinc(d) sinc(d/n) ∝ (−1)ⁱ sin(π f) sin(π d/n)/d². The factor sin(π f) is
    /// the same for all and goes with the sum; multiplying by f (1 − f) instead takes the poles at the two middle
    /// taps away, where sin(π d/n)/d is a series.
    #[inline(always)]
    fn weights(&self, f: f32) -> [f32; N] {
        let g = 1.0 - f;
        let (sine, cosine) = (f * self.sine_over(f), self.cosine(f));
        let both = f * g;
        let mut weights = [0.0; N];
        let mut sum = 0.0;
        for k in 0..N {
            weights[k] = if k + 1 == N / 2 {
                g * self.sine_over(f)
            } else if k == N / 2 {
                f * self.sine_over(g)
            } else {
                let distance = f - (k as f32 - (N / 2 - 1) as f32);
                let [cos, sin] = self.turns[k];
                both * (sine * cos - cosine * sin) / (distance * distance)
            };
            sum += weights[k];
        }
        let scale = 1.0 / sum;
        weights.map(|w| w * scale)
    }
}
