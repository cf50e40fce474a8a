//! Atmospheric refraction of aerial photographs.

use core::f64::consts::FRAC_PI_2;

use nalgebra::{Point2, UnitVector3, Vector3};

use super::{Ray, moved};
use crate::camera::{CentralModel, Frame};
use crate::error::{Error, ProjectionError};
use crate::numeric::float;

/// Refraction of the rays of an aerial photograph by the air between the ground and the camera.
///
/// ```text
/// α₀ = α − K tan α
/// ```
///
/// α is the angle from the nadir at which the camera sees a point, α₀ that of the straight line to it. The air is thinner at the
/// camera, so that a ray bends away from the vertical on its way up: **a picture shows points farther from the nadir point than they
/// are, and the correction moves them towards it.** The nadir point stays. K, in radians, depends on the heights of camera and ground.
///
/// # Where K comes from
/// In air whose refractive index n depends on the height z only, n sin α is the same along the ray (Snellius), and to first order
///
/// ```text
/// K = 1/(H − h) ∫ₕᴴ (n(z) − n(H)) dz
/// ```
///
/// | | K | |
/// | --- | --- | --- |
/// | [`standard_atmosphere`](Self::standard_atmosphere) | Saastamoinen 1974, of the standard atmosphere | within 0.3 % of a ray traced through the standard atmosphere of 1976, ground at any height |
/// | [`ardc`](Self::ardc) | Bertram 1966, of the ARDC atmosphere of 1959 | 5 µrad from it, over ground at sea level; too large over high ground, as said there |
/// | [`from_constant`](Self::from_constant) | your own, as of a sounding | |
///
/// # Accuracy
/// The law K tan α is that of a flat Earth. Against a ray traced through the standard atmosphere of 1976 about a sphere, for H up to
/// 12 km: 0.4 % of the correction at 60° from the nadir, 2 % at 75°, 4 % at 80°. The weather changes K by some percent. A camera
/// behind the window of a pressurised cabin sees what the cabin's air makes of the ray: that is not in these formulas. Heights are metres above sea level.
///
/// # Example
/// Manual of Photogrammetry, 4th edition (1980), p. 487: at 9 km above ground at sea level a ray at 45° is displaced by 78.3 µrad. On
/// a vertical photograph with c = 152 mm that is 152 · 2 · 78.3·10⁻⁶ mm, since r = c tan α changes by c/cos² α.
///
/// ```
/// use collinear::camera::{ExteriorOrientation, Frame, InteriorOrientation, Refraction};
/// use collinear::geometry::Affine2;
/// use collinear::geometry::rotation::OmegaPhiKappa;
/// use nalgebra::{Point2, Point3, Vector3};
///
/// let camera = InteriorOrientation::from_photogrammetric(152.0, Point2::origin(), &Affine2::identity())?;
/// let level = OmegaPhiKappa { omega: 0.0, phi: 0.0, kappa: 0.0 };
/// let exterior = ExteriorOrientation::from_omega_phi_kappa(Point3::new(0.0, 0.0, 9000.0), &level);
/// let frame = Frame::new(exterior, camera);
///
/// let refraction = Refraction::ardc(9000.0, 0.0)?;
/// assert!((refraction.constant() - 78.3e-6).abs() < 0.05e-6);
/// let measured = Point2::new(152.0, 0.0);
/// let corrected = refraction.corrected(&frame, &Vector3::z_axis(), &measured)?;
/// assert!((measured.x - corrected.x - 0.0238).abs() < 5e-5); // 23.8 µm, towards the nadir
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[doc(alias("atmospheric refraction", "Bertram", "Saastamoinen", "ARDC"))]
pub struct Refraction {
    constant: f64,
}

/// The lowest ground, metres: below the shore of the Dead Sea.
const LOWEST: f64 = -500.0;
/// The highest camera, metres: above it the air bends no ray, but the Earth is not flat below it.
const HIGHEST: f64 = 100_000.0;
/// No air makes a K of more.
const LARGEST: f64 = 0.01;
/// Of so thin a layer of air, km, both rules agree to 2·10⁻⁶.
const THIN: f64 = 1e-4;

/// Iterations in which a ray is bent; some are usual, fifty where its correction is about to fold.
const MAX_ITERATIONS: u32 = 100;

impl Refraction {
    /// Of the ARDC atmosphere of 1959 (Bertram 1966), for a camera and ground at these heights above sea level, metres.
    ///
    /// ```text
    /// K = [ 2410 H / (H² − 6H + 250) − (h/H) 2410 h / (h² − 6h + 250) ] · 10⁻⁶        H, h in km
    /// ```
    ///
    /// This is what most textbooks print. Its second term suits low ground only: where n falls evenly with the height, K is
    /// proportional to H − h, and the formula gives (1 + h/H) times that. At H = 5 km over h = 2 km it gives 41 µrad; a ray traced through
    /// the standard atmosphere 29 µrad. [`standard_atmosphere`](Self::standard_atmosphere) has no such error.
    ///
    /// # Errors
    /// [`Error::NotFinite`]; [`Error::OutOfRange`] for ground below −500 m, a camera that is not above the ground and above sea level, or
    /// above 100 km.
    pub fn ardc(camera_height: f64, ground_height: f64) -> Result<Self, Error> {
        let (camera, ground) = kilometres(camera_height, ground_height)?;
        if camera <= 0.0 {
            return Err(Error::OutOfRange {
                what: "height of the camera",
                value: camera_height,
                expected: "above sea level",
            });
        }
        let over_sea = |z: f64| 2410.0 * z / (z * z - 6.0 * z + 250.0);
        Self::from_constant((over_sea(camera) - over_sea(ground) * (ground / camera)) * 1e-6)
    }

    /// Of the standard atmosphere (Saastamoinen 1974), for a camera and ground at these heights above sea level, metres.
    ///
    /// ```text
    /// K = κ [ (p(h) − p(H)) / (H − h) + p′(H) ],      κ = 2335·10⁻⁶ km
    ///
    /// p(z) = (1 − 0.02257 z)^5.256                      up to 11 km, z in km
    /// p(z) = p(11) · 0.8540^(z − 11)                    above
    /// ```
    ///
    /// p is the pressure as a part of that at sea level. The weight of the air between two heights is the difference of their pressures, and
    /// n − 1 is proportional to its density: so the integral of n − 1 is κ (p(h) − p(H)), and n(z) − 1 = −κ p′(z), which is
    /// 277·10⁻⁶ at sea level. With p put in, up to 11 km
    ///
    /// ```text
    /// K = { 2335/(H − h) [ (1 − 0.02257 h)^5.256 − (1 − 0.02257 H)^5.256 ] − 277.0 (1 − 0.02257 H)^4.256 } · 10⁻⁶
    /// ```
    ///
    /// # Errors
    /// [`Error::NotFinite`]; [`Error::OutOfRange`] for ground below −500 m, a camera that is not above the ground, or above 100 km.
    ///
    /// # Example
    /// A ray traced through the standard atmosphere of 1976 in Python has K = 29.3 µrad for 5 km above sea level and ground at 2 km.
    ///
    /// ```
    /// use collinear::camera::Refraction;
    ///
    /// let refraction = Refraction::standard_atmosphere(5000.0, 2000.0)?;
    /// assert!((refraction.constant() - 29.3e-6).abs() < 0.1e-6);
    /// # Ok::<(), collinear::Error>(())
    /// ```
    pub fn standard_atmosphere(camera_height: f64, ground_height: f64) -> Result<Self, Error> {
        let (camera, ground) = kilometres(camera_height, ground_height)?;
        let (above, slope) = pressure(camera);
        let (below, slope_below) = pressure(ground);
        let over = camera - ground;
        // Just above the ground the difference of pressures is rounding; by the trapezoidal rule it drops out.
        let part =
            if over < THIN { 0.5 * (slope - slope_below) } else { (below - above) / over + slope };
        Self::from_constant(2335e-6 * part)
    }

    /// From K, radians.
    ///
    /// # Errors
    /// [`Error::NotFinite`], and [`Error::OutOfRange`] for less than 0 or more than 0.01.
    pub fn from_constant(constant: f64) -> Result<Self, Error> {
        if !constant.is_finite() {
            return Err(Error::NotFinite { what: "refraction constant" });
        }
        if !(0.0..=LARGEST).contains(&constant) {
            return Err(Error::OutOfRange {
                what: "refraction constant",
                value: constant,
                expected: "from 0 to 0.01",
            });
        }
        Ok(Self { constant })
    }

    /// K, radians.
    #[must_use]
    pub fn constant(&self) -> f64 {
        self.constant
    }

    /// The direction of the straight line to what is seen in a direction: towards the nadir. Both from the projection centre, in any axes
    /// in which `up` is the vertical there; of unit length.
    ///
    /// # Errors
    /// [`ProjectionError::OutsideDomain`], in radians, at and above the horizon, and already where the law folds back, cos² α ≤ K: with
    /// K = 10⁻⁴ at 89.4°; [`ProjectionError::NotFinite`].
    pub fn straight(
        &self,
        direction: &Vector3<f64>,
        up: &UnitVector3<f64>,
    ) -> Result<Vector3<f64>, ProjectionError> {
        let ray = Ray::new(direction, up)?;
        if !(ray.down > 0.0 && ray.down * ray.down > self.constant) {
            return Err(ray.beyond(self.fold()));
        }
        let tangent = ray.tangent();
        let turned = tangent_of(self.constant * tangent);
        // tan(α − δ) / tan α; at the nadir there is nothing to turn.
        let part = if tangent > 0.0 { turned / tangent } else { 0.0 };
        ray.with_tangent_times((1.0 - part) / (1.0 + tangent * turned))
    }

    /// The direction in which the end of a straight line is seen: the inverse of [`straight`](Self::straight).
    ///
    /// # Errors
    /// As [`straight`](Self::straight), where no ray below the fold leads; [`ProjectionError::NotConverged`], in radians.
    pub fn bent(
        &self,
        direction: &Vector3<f64>,
        up: &UnitVector3<f64>,
    ) -> Result<Vector3<f64>, ProjectionError> {
        let ray = Ray::new(direction, up)?;
        let limit = self.fold() - float::sqrt(self.constant * (1.0 - self.constant));
        if !(ray.down > 0.0 && ray.angle() < limit) {
            return Err(ray.beyond(limit));
        }
        let tangent = ray.tangent();
        // δ = K tan(α₀ + δ) by Newton's method, from below, where it does not overshoot.
        let (mut delta, mut step) = (0.0, f64::INFINITY);
        for _ in 0..MAX_ITERATIONS {
            let turned = tangent_of(delta);
            let seen = (tangent + turned) / (1.0 - tangent * turned);
            let slope = 1.0 - self.constant * (1.0 + seen * seen);
            if !(slope > 0.0) {
                break;
            }
            step = (self.constant * seen - delta) / slope;
            delta += step;
            if !(step > 1e-17) {
                break;
            }
        }
        // Where the law folds, rounding ends the way before the step is so small.
        if !(step.abs() < 1e-9) {
            let residual = step;
            return Err(ProjectionError::NotConverged { iterations: MAX_ITERATIONS, residual });
        }
        let turned = tangent_of(delta);
        let part = if tangent > 0.0 { turned / tangent } else { 0.0 };
        ray.with_tangent_times((1.0 + part) / (1.0 - tangent * turned))
    }

    /// The image point (pixels) as it would be without air, from the measured one; `up` is the vertical at the projection centre in
    /// world axes, [`Vector3::z_axis`] in a map system.
    ///
    /// The attitude of the photograph enters only through the direction of the nadir, which an approximate orientation gives well
    /// enough: 1° changes the correction at 45° by 3 %.
    ///
    /// # Errors
    /// As [`straight`](Self::straight), and those of the camera.
    pub fn corrected<C: CentralModel>(
        &self,
        frame: &Frame<C>,
        up: &UnitVector3<f64>,
        image: &Point2<f64>,
    ) -> Result<Point2<f64>, ProjectionError> {
        moved(frame, image, |direction| self.straight(direction, up))
    }

    /// The image point as it is seen through the air, from the one without: the inverse of [`corrected`](Self::corrected).
    ///
    /// # Errors
    /// As [`bent`](Self::bent), and those of the camera.
    pub fn displaced<C: CentralModel>(
        &self,
        frame: &Frame<C>,
        up: &UnitVector3<f64>,
        image: &Point2<f64>,
    ) -> Result<Point2<f64>, ProjectionError> {
        moved(frame, image, |direction| self.bent(direction, up))
    }

    /// The angle from the nadir where α − K tan α is largest.
    fn fold(&self) -> f64 {
        if self.constant > 0.0 {
            let root = float::sqrt(self.constant);
            float::atan2(float::sqrt(1.0 - self.constant), root)
        } else {
            FRAC_PI_2
        }
    }
}

fn tangent_of(angle: f64) -> f64 {
    let (sine, cosine) = float::sin_cos(angle);
    sine / cosine
}

/// The heights of camera and ground, where both may be.
fn kilometres(camera: f64, ground: f64) -> Result<(f64, f64), Error> {
    if !camera.is_finite() {
        return Err(Error::NotFinite { what: "height of the camera" });
    }
    if !ground.is_finite() {
        return Err(Error::NotFinite { what: "height of the ground" });
    }
    if ground < LOWEST {
        let (what, value) = ("height of the ground", ground);
        return Err(Error::OutOfRange { what, value, expected: "at least -500 m" });
    }
    let (what, value) = ("height of the camera", camera);
    if camera > HIGHEST {
        return Err(Error::OutOfRange { what, value, expected: "at most 100 000 m" });
    }
    if camera <= ground {
        return Err(Error::OutOfRange { what, value, expected: "above the ground" });
    }
    Ok((camera / 1000.0, ground / 1000.0))
}

/// The pressure at a height (km) as a part of that at sea level, and its slope.
fn pressure(height: f64) -> (f64, f64) {
    const LAPSE: f64 = 0.02257;
    const POWER: f64 = 5.256;
    const TROPOPAUSE: f64 = 11.0;
    let below = height.min(TROPOPAUSE);
    let base = 1.0 - LAPSE * below;
    let part = float::exp(POWER * float::ln(base));
    let rate = -POWER * LAPSE / base;
    // Above 11 km the rate stays: e^rate = 0.8540.
    let pressure = part * float::exp(rate * (height - below));
    (pressure, rate * pressure)
}
