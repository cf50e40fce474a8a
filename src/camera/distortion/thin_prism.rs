//! Lenses with a thin prism, in one stage and in two.

use nalgebra::{Matrix2, Point2, Vector2};

use super::one_to_one::{OneToOne, invert};
use super::planar::Planar;
use super::{Distortion, Undistorted, planar_distortion};
use crate::camera::{Parametrised, parameters};
use crate::error::{Error, ProjectionError};

/// Radial, decentering and thin-prism distortion in one stage (Weng, Cohen & Herniou 1992).
///
#[doc = include_str!("../../../docs/figures/lenses/thin_prism.svg")]
///
/// # Model
/// ```text
/// x″ = x (1 + k₁r² + k₂r⁴ + k₃r⁶ + k₄r⁸) + 2 p₁ x y + p₂ (r² + 2x²) + s₁ r²
/// y″ = y (1 + k₁r² + k₂r⁴ + k₃r⁶ + k₄r⁸) + p₁ (r² + 2y²) + 2 p₂ x y + s₂ r²
/// ```
/// After the [equidistant](crate::camera::Fisheye::Equidistant) projection it is COLMAP's `THIN_PRISM_FISHEYE`, the model of
/// the ETH3D benchmark.
///
/// # Domain
/// A disc on which the map is one to one, found when the lens is made; see
/// [`fold_radius`](Distortion::fold_radius).
///
/// # Example
/// By hand at (½, 0), r² = ¼: x″ = ½ (1 + 0.1/4) + 3 p₂/4 + s₁/4.
///
/// ```
/// use collinear::camera::{Distortion, ThinPrism};
/// use nalgebra::Point2;
///
/// let lens = ThinPrism::new([0.1, 0.0, 0.0, 0.0], [0.002, 0.004], [0.008, 0.016])?;
/// let p = lens.distort(&Point2::new(0.5, 0.0))?;
/// assert!((p - Point2::new(0.5125 + 0.003 + 0.002, 0.0005 + 0.004)).norm() < 1e-16);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[doc(alias("THIN_PRISM_FISHEYE"))]
pub struct ThinPrism(Planar<4, 0, 1, 1>);

planar_distortion!(ThinPrism);

impl ThinPrism {
    /// From k₁ to k₄, p₁ and p₂, s₁ and s₂ (COLMAP's sx1 and sy1).
    ///
    /// # Errors
    /// [`Error::NotFinite`]; [`Error::OutOfRange`] for coefficients so large that nothing is left inside the fold.
    pub fn new(k: [f64; 4], p: [f64; 2], s: [f64; 2]) -> Result<Self, Error> {
        Planar::new(k, [], p, [0.0; 2], [s[0], 0.0, s[1], 0.0], 0.0).map(Self)
    }
}

impl Parametrised for ThinPrism {
    const NAME: &'static str = "lens distortion";
    const PARAMETERS: &'static [&'static str] = &["k1", "k2", "k3", "k4", "p1", "p2", "s1", "s2"];

    fn values(&self, out: &mut [f64]) {
        let ([k1, k2, k3, k4], [p1, p2], s) = (self.0.k, self.0.p, self.0.s);
        parameters::write(&[k1, k2, k3, k4, p1, p2, s[0], s[2]], out);
    }

    fn with_values(&self, values: &[f64]) -> Result<Self, Error> {
        let [k1, k2, k3, k4, p1, p2, s1, s2] = parameters::read(values)?;
        Self::new([k1, k2, k3, k4], [p1, p2], [s1, s2])
    }
}

/// Radial distortion, and decentering and thin-prism distortion of its result.
///
#[doc = include_str!("../../../docs/figures/lenses/two_stage.svg")]
///
/// # Model
/// ```text
/// (x′, y′) = (x, y) (1 + k₀r² + k₁r⁴ + … + k₅r¹²)
/// x″ = x′ + p₀ (r′² + 2x′²) + 2 p₁ x′y′ + s₀ r′² + s₁ r′⁴
/// y″ = y′ + p₁ (r′² + 2y′²) + 2 p₀ x′y′ + s₂ r′² + s₃ r′⁴        r′² = x′² + y′²
/// ```
/// After the [equidistant](crate::camera::Fisheye::Equidistant) projection it is the *Fisheye624* model of Project Aria and
/// COLMAP's `RAD_TAN_THIN_PRISM_FISHEYE`, whose names and order of p the parameters keep.
///
/// # Domain
/// Ideal points within the fold of the radial polynomial whose radial image is within the disc of the second stage.
///
/// # Example
/// pycolmap 4.2.1, `RAD_TAN_THIN_PRISM_FISHEYE`: see `tests/data/oracles/central_models.py`. By hand, k₀ = 0.4 at (½, 0): x′ =
/// 0.55, and p₀ adds 3 · 0.55² p₀.
///
/// ```
/// use collinear::camera::{Distortion, RadialTangentialThinPrism};
/// use nalgebra::Point2;
///
/// let k = [0.4, 0.0, 0.0, 0.0, 0.0, 0.0];
/// let lens = RadialTangentialThinPrism::new(k, [0.01, 0.0], [0.0; 4])?;
/// let p = lens.distort(&Point2::new(0.5, 0.0))?;
/// assert!((p - Point2::new(0.55 + 0.009075, 0.0)).norm() < 1e-15);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[doc(alias("Fisheye624", "RAD_TAN_THIN_PRISM_FISHEYE"))]
pub struct RadialTangentialThinPrism {
    radial: Planar<6, 0, 0, 0>,
    second: Planar<0, 0, 1, 2>,
}

impl RadialTangentialThinPrism {
    /// From k₀ to k₅, p₀ and p₁, s₀ to s₃.
    ///
    /// # Errors
    /// [`Error::NotFinite`]; [`Error::OutOfRange`] for coefficients so large that nothing is left inside a fold.
    pub fn new(k: [f64; 6], p: [f64; 2], s: [f64; 4]) -> Result<Self, Error> {
        let zero = ([0.0; 2], [0.0; 4]);
        let radial = Planar::new(k, [], zero.0, zero.0, zero.1, 0.0)?;
        // This model's p₀ is the coefficient that Brown's formula calls p₂.
        let second = Planar::new([], [], [p[1], p[0]], zero.0, s, 0.0)?;
        Ok(Self { radial, second })
    }
}

impl Parametrised for RadialTangentialThinPrism {
    const NAME: &'static str = "lens distortion";
    const PARAMETERS: &'static [&'static str] =
        &["k0", "k1", "k2", "k3", "k4", "k5", "p0", "p1", "s0", "s1", "s2", "s3"];

    fn values(&self, out: &mut [f64]) {
        let ([k0, k1, k2, k3, k4, k5], [p1, p0]) = (self.radial.k, self.second.p);
        let [s0, s1, s2, s3] = self.second.s;
        parameters::write(&[k0, k1, k2, k3, k4, k5, p0, p1, s0, s1, s2, s3], out);
    }

    fn with_values(&self, values: &[f64]) -> Result<Self, Error> {
        let [k0, k1, k2, k3, k4, k5, p0, p1, s0, s1, s2, s3] = parameters::read(values)?;
        Self::new([k0, k1, k2, k3, k4, k5], [p0, p1], [s0, s1, s2, s3])
    }
}

impl Distortion for RadialTangentialThinPrism {
    fn distort(&self, ideal: &Point2<f64>) -> Result<Point2<f64>, ProjectionError> {
        self.second.checked(&self.radial.checked(ideal)?)
    }

    fn distort_jacobian(
        &self,
        ideal: &Point2<f64>,
    ) -> Result<(Point2<f64>, Matrix2<f64>), ProjectionError> {
        let between = self.radial.checked(ideal)?;
        let distorted = self.second.checked(&between)?;
        Ok((distorted, self.second.jacobian(&between) * self.radial.jacobian(ideal)))
    }

    fn undistort(&self, distorted: &Point2<f64>) -> Result<Undistorted, ProjectionError> {
        let second = invert(&self.second, distorted)?;
        let radial = invert(&self.radial, &second.point)?;
        let thrown = self.second.value(&self.radial.value(&radial.point));
        let iterations = second.iterations + radial.iterations;
        Ok(Undistorted { iterations, residual: (thrown - distorted).norm(), ..radial })
    }

    fn parameter_partials(&self, ideal: &Point2<f64>, out: &mut [Vector2<f64>]) {
        let between = self.radial.value(ideal);
        let through = self.second.jacobian(&between);
        let mut second = [Vector2::zeros(); 6];
        self.second.columns(&between, &mut second);
        second.swap(0, 1);
        let mut all = [Vector2::zeros(); 12];
        self.radial.columns(ideal, &mut all[..6]);
        for column in &mut all[..6] {
            *column = through * *column;
        }
        all[6..].copy_from_slice(&second);
        parameters::write(&all, out);
    }

    fn fold_radius(&self) -> f64 {
        let [fold, limit] = [self.radial.fold_radius(), self.second.fold_radius()];
        if limit.is_infinite() || self.radial.radial(fold)[0] <= limit {
            return fold;
        }
        // The radius whose radial image is the second stage's rim.
        match invert(&self.radial, &Point2::new(limit, 0.0)) {
            Ok(rim) => rim.point.x,
            Err(_) => fold,
        }
    }
}
