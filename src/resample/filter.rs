//! Filters by name.

/// How a value is taken between texel centres.
///
/// | filter | texels | what it reproduces |
/// | --- | --- | --- |
/// | [`Nearest`](Self::Nearest) | 1 | texels |
/// | [`Bilinear`](Self::Bilinear) | 2 × 2 | texels, ramps |
/// | [`Bicubic`](Self::Bicubic) | 4 × 4 | as its [`Cubic`] says |
/// | [`Lanczos2`](Self::Lanczos2), [`3`](Self::Lanczos3), [`4`](Self::Lanczos4) | 4 × 4, 6 × 6, 8 × 8 | texels; frequencies nearly up to the limit of ½ cycle a texel |
///
/// All reproduce a constant. None looks at how densely the map samples the picture: where it is minified they alias.
///
/// What one costs stands in benches/README.md; its accuracy [above](super).
///
/// ```
/// use collinear::nalgebra::Point2;
/// use collinear::resample::{Border, Cubic, Filter, ImageView, sample};
///
/// // A step from 0 to 160, half a texel beyond its foot. Bilinear is in the middle; OpenCV's cubic overshoots further out.
/// let row = [0.0f32, 0.0, 0.0, 160.0, 160.0, 160.0];
/// let view = ImageView::<f32, 1>::new(&row, 6, 1)?;
/// let at = |u, filter| sample(view, &Point2::new(u, 0.5), filter, Border::Clamp).map(|[value]| value);
/// assert_eq!(at(3.0, Filter::Bilinear), Some(80.0));
/// // k(3/2) of a = −¾ is a(27/8 − 45/4 + 12 − 4) = −3/32: of 160 that is −15.
/// assert_eq!(at(2.0, Filter::Bicubic(Cubic::keys(-0.75))), Some(-15.0));
/// // OpenCV 5.0.0, `remap` with INTER_LANCZOS4 at the same place.
/// let lanczos = at(2.0, Filter::Lanczos4).unwrap_or_default();
/// assert!((lanczos + 19.020386).abs() < 1e-3);
/// # Ok::<(), collinear::Error>(())
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub enum Filter {
    /// The texel that contains the position. Jagged when magnified.
    #[doc(alias("INTER_NEAREST", "GL_NEAREST", "point"))]
    Nearest,
    /// The mean of the four texels whose centres surround the position, weighted by the opposite areas.
    #[default]
    #[doc(alias("INTER_LINEAR", "GL_LINEAR"))]
    Bilinear,
    /// A piecewise cubic along each axis.
    #[doc(alias("INTER_CUBIC", "cubic convolution"))]
    Bicubic(Cubic),
    /// The sinc, windowed by a sinc of two lobes a side (Lanczos's σ factors; Duchon 1979, *Lanczos filtering in one and
    /// two dimensions*), normalised to sum one.
    Lanczos2,
    /// Of three lobes a side.
    Lanczos3,
    /// Of four lobes a side.
    #[doc(alias = "INTER_LANCZOS4")]
    Lanczos4,
}

/// A cubic filter of four taps along an axis, of the two-parameter family of Mitchell & Netravali 1988.
///
/// ```text
///          ⎧ (12 − 9B − 6C)|x|³ + (−18 + 12B + 6C)|x|² + (6 − 2B)             |x| < 1
/// k(x) = ⅙ ⎨ (−B − 6C)|x|³ + (6B + 30C)|x|² + (−12B − 48C)|x| + (8B + 24C)    1 ≤ |x| < 2
///          ⎩ 0                                                                2 ≤ |x|      (their eq. 8)
/// ```
///
/// Where B = 0 it reproduces texels; where B + 2C = 1 a ramp, and a parabola if B = 0 too. Programs mean different ones by
/// "bicubic":
///
/// | program | filter |
/// | --- | --- |
/// | OpenCV | [`keys(-0.75)`](Self::keys) |
/// | scikit-image, imageproc, kornia, Skia | [`CATMULL_ROM`](Self::CATMULL_ROM) = `keys(-0.5)` |
/// | Pillow | `keys(-1.0)` |
///
/// ```
/// use collinear::resample::Cubic;
///
/// // Keys's cubic convolution at half a texel: −1/16, 9/16, 9/16, −1/16.
/// assert_eq!(Cubic::CATMULL_ROM.weights(0.5), [-0.0625, 0.5625, 0.5625, -0.0625]);
/// assert_eq!(Cubic::keys(-0.5), Cubic::CATMULL_ROM);
/// // Mitchell & Netravali's own choice, at a texel: (8B + 24C − … )/6 = 1/18, 16/18, 1/18.
/// let [before, at, after, _] = Cubic::MITCHELL.weights(0.0);
/// assert!((before - 1.0 / 18.0).abs() < 1e-15 && (after - before).abs() < 1e-15 && (at - 16.0 / 18.0).abs() < 1e-15);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[doc(alias("BC-spline", "cubic convolution"))]
pub struct Cubic {
    /// B: how much it blurs.
    pub b: f64,
    /// C: how much it rings; Keys's −a where B = 0.
    pub c: f64,
}

impl Cubic {
    /// Catmull & Rom 1974, the cubic convolution of Keys 1981 with a = −½: of the interpolating ones the one that
    /// reproduces parabolas.
    pub const CATMULL_ROM: Self = Self { b: 0.0, c: 0.5 };
    /// Mitchell & Netravali's compromise between blur, ringing and blocks.
    pub const MITCHELL: Self = Self { b: 1.0 / 3.0, c: 1.0 / 3.0 };
    /// The uniform cubic B-spline: positive, smooth to the second derivative, a low-pass filter that does not interpolate.
    pub const B_SPLINE: Self = Self { b: 1.0, c: 0.0 };

    /// Keys 1981's cubic convolution with the slope a at distance 1: B = 0, C = −a.
    #[must_use]
    pub const fn keys(a: f64) -> Self {
        Self { b: 0.0, c: -a }
    }

    /// The weights of the taps at −1, 0, 1 and 2 for a position at `fraction` ∈ [0, 1].
    #[must_use]
    pub fn weights(self, fraction: f64) -> [f64; 4] {
        self.polynomials()
            .map(|[c0, c1, c2, c3]| ((c3 * fraction + c2) * fraction + c1) * fraction + c0)
    }

    /// Each tap's weight as a polynomial of the fraction: k(f + 1), k(f), k(1 − f), k(2 − f), coefficients of 1, f, f², f³.
    pub(super) fn polynomials(self) -> [[f64; 4]; 4] {
        let Self { b, c } = self;
        let near = [(6.0 - 2.0 * b) / 6.0, 0.0, -3.0 + 2.0 * b + c, 2.0 - 1.5 * b - c];
        // k(1 + f) in powers of f: the far branch, expanded about 1.
        let far = [b / 6.0, -0.5 * b - c, 0.5 * b + 2.0 * c, -b / 6.0 - c];
        [far, near, mirrored(near), mirrored(far)]
    }
}

/// The polynomial at 1 − f instead of f.
fn mirrored([a, b, c, d]: [f64; 4]) -> [f64; 4] {
    [a + b + c + d, -b - 2.0 * c - 3.0 * d, c + 3.0 * d, -d]
}
