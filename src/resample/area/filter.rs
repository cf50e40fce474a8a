//! Area filters by name.

/// How a picture is averaged over the area that a pixel covers, from a [`Pyramid`](super::Pyramid).
///
/// A pixel's area is taken from the map's Jacobian J = ∂(u, v)/∂(S, L): its unit circle becomes an ellipse in the texture.
/// The longest half axis ρ of it, the root of the larger eigenvalue of J Jᵀ, gives the level of detail λ = logᵣ (ρ/√3), with r
/// the pyramid's ratio: a bilinear lookup in texels of the length s has the variance s²/4, of which 1/12 is the texel's and 1/6 the
/// interpolation's, and a pixel of the length ρ has ρ²/12; for s = ρ/√3 they are the same. (OpenGL's λ is log₂ ρ, 0.8 level more, which
/// blurs; it takes the longer column of J for ρ, which is less by up to √2, or better.)
///
/// | filter | texels | what it does | where it is blurred |
/// | --- | --- | --- | --- |
/// | [`NearestLevel`](Self::NearestLevel) | 4 | bilinear in the level nearest to λ | along the shorter axis |
/// | [`Trilinear`](Self::Trilinear) | 8 | bilinear in both levels beside λ, and between | along the shorter axis |
/// | [`Ewa`](Self::Ewa) | ≈ 9 to 30 · axes' ratio | an average over the ellipse itself | beyond the largest ratio |
///
/// All reproduce a constant. Where the picture is magnified the first two are bilinear, and so reproduce ramps; the last one
/// is a smooth average of 2 × 2 to 3 × 3 texels, whose centre is off by up to 0.03 texel. None aliases toward a horizon: there the level rises without end.
///
/// Where a position has no Jacobian (a map's is an error, or NaN) it is looked up as if magnified.
///
/// ```
/// use collinear::nalgebra::{Matrix2, Point2};
/// use collinear::resample::{AreaFilter, Border, Footprint, ImageView, Pyramid, sample_area};
///
/// // Columns of 0, 100, 0, 100 … seen four to a pixel, and looked at on one of them: nothing but their mean is right.
/// let columns: Vec<u8> = (0..256).map(|i| 100 * (i % 2) as u8).collect();
/// let pyramid = Pyramid::new(ImageView::<u8, 1>::new(&columns, 16, 16)?)?;
/// let pixel = Footprint { position: Point2::new(8.5, 8.0), jacobian: Matrix2::identity() * 4.0 };
/// for filter in [AreaFilter::NearestLevel, AreaFilter::Trilinear, AreaFilter::Ewa { anisotropy: 16 }] {
///     assert_eq!(sample_area(&pyramid, &pixel, filter, Border::Clamp), Some([50]));
/// }
/// # Ok::<(), collinear::Error>(())
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum AreaFilter {
    /// Bilinear in the level nearest to λ; levels change at once.
    #[doc(alias("GL_LINEAR_MIPMAP_NEAREST", "bilinear-nearest"))]
    NearestLevel,
    /// Bilinear in the levels k = ⌊λ⌋ and k + 1, and linear between them (Williams 1983): the coarser one has the share
    /// (s/rᵏ − 1)/(r − 1), so that both texels' mean is s.
    #[default]
    #[doc(alias("GL_LINEAR_MIPMAP_LINEAR", "mipmapping"))]
    Trilinear,
    /// The elliptical weighted average of Greene & Heckbert 1986, on a pyramid with a bounded cost (Heckbert 1989).
    ///
    /// *Weights.* w = (1 − r²)² within the ellipse r² = 1, zero outside. Its variances along u and v are those of the pixel's
    /// square, J Jᵀ/12, and at least ³⁄₁₆ texel² along either axis. Greene & Heckbert's Gaussian cut off at its second deviation
    /// has a step there; this polynomial has none, and the deviation σ = R/√8 of a Gaussian that looks the same.
    ///
    /// *Level.* The coarsest one in which the shorter axis' variance, less the 1/12 texel² that the level's own texels have, is
    /// still ³⁄₁₆ texel²: so the levels' blur is no part of the result, and changes of the level are hardly seen.
    ///
    /// *Cost.* An ellipse whose axes have a larger ratio than `anisotropy` is made wider, not shorter: it blurs and does not
    /// alias. Then at most about (4 r + 1)(4 r · `anisotropy` + 1) texels are read, a fifth of that on the average.
    #[doc(alias("elliptical weighted average", "anisotropic", "elliptically weighted average"))]
    Ewa {
        /// The largest ratio of the axes; 0 counts as 1. Graphics hardware takes up to 16.
        anisotropy: u8,
    },
}
