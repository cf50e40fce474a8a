//! An even polynomial in the radius: the fisheye lens of Kannala and Brandt.

use super::planar::Planar;
use super::planar_distortion;
use crate::camera::{Parametrised, parameters};
use crate::error::Error;

/// Radial distortion by an even polynomial of four terms.
///
#[doc = include_str!("../../../docs/figures/lenses/even_radial.svg")]
///
/// # Model
/// ```text
/// r″ = r (1 + k₁r² + k₂r⁴ + k₃r⁶ + k₄r⁸)
/// ```
/// After the [equidistant](crate::camera::Fisheye::Equidistant) projection, where r is the angle θ from the axis, it is the
/// fisheye of Kannala & Brandt (2006), eq. 6 as OpenCV's `fisheye` and COLMAP's `OPENCV_FISHEYE` write it: θ″ = θ (1 + k₁θ² +
/// …).
///
/// # Domain
/// Up to the first root of 1 + 3k₁r² + 5k₂r⁴ + 7k₃r⁶ + 9k₄r⁸.
///
/// # Example
/// By hand: at r = ½, 1 + 0.1/4 − 0.2/16 + 0.3/64 − 0.4/256 = 1.015625.
///
/// ```
/// use collinear::camera::{Distortion, EvenRadial};
/// use nalgebra::Point2;
///
/// let lens = EvenRadial::new([0.1, -0.2, 0.3, -0.4])?;
/// assert_eq!(lens.distort(&Point2::new(0.0, 0.5))?, Point2::new(0.0, 0.5078125));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[doc(alias("Kannala-Brandt", "KB4", "fisheye", "equidistant"))]
pub struct EvenRadial(Planar<4, 0, 0, 0>);

planar_distortion!(EvenRadial);

impl EvenRadial {
    /// From k₁ to k₄.
    ///
    /// # Errors
    /// [`Error::NotFinite`]; [`Error::OutOfRange`] for coefficients so large that nothing is left inside the fold.
    pub fn new(k: [f64; 4]) -> Result<Self, Error> {
        Planar::new(k, [], [0.0; 2], [0.0; 2], [0.0; 4], 0.0).map(Self)
    }

    /// (k₁, k₂, k₃, k₄).
    #[must_use]
    pub fn coefficients(&self) -> [f64; 4] {
        self.0.k
    }
}

impl Parametrised for EvenRadial {
    const NAME: &'static str = "radial distortion";
    const PARAMETERS: &'static [&'static str] = &["k1", "k2", "k3", "k4"];

    fn values(&self, out: &mut [f64]) {
        parameters::write(&self.0.k, out);
    }

    fn with_values(&self, values: &[f64]) -> Result<Self, Error> {
        Self::new(parameters::read(values)?)
    }
}
