//! From the ground to the image.

use core::f64::consts::TAU;

use nalgebra::{Matrix2x3, Point2};

use super::correction::ImageCorrection;
use super::cubic::{Cubics, LINE, SAMPLE};
use super::record::Rpc00b;
use crate::error::{Error, ProjectionError};
use crate::geometry::geodetic::{EllipsoidalHeight, Geodetic, GeoidGrid, OrthometricHeight};
use crate::numeric::twofold::Twofold;

/// A rational polynomial camera (RPC00B), perhaps with a correction from control points.
///
/// # Model
/// ```text
/// L = (λ − λ₀)/λₛ,   P = (φ − φ₀)/φₛ,   H = (h − h₀)/hₛ
/// line   = l₀ + lₛ · N_l(L, P, H)/D_l(L, P, H)
/// sample = s₀ + sₛ · N_s(L, P, H)/D_s(L, P, H)        (NIMA STDI-0002, appendix E, RPC00B)
/// (x, y) = correction( sample + ½, line + ½ )
/// ```
/// N and D are cubics of twenty terms in longitude λ, latitude φ and **ellipsoidal** height h. The polynomials count
/// lines and samples from the centre of the first pixel, this crate from its corner: the half pixel is crossed here, by
/// [`from_rpc00b`](Self::from_rpc00b) and [`to_rpc00b`](Self::to_rpc00b), and nowhere else.
///
#[doc = include_str!("../../../docs/figures/lenses/rpc.svg")]
///
/// # Domain
/// |L|, |P|, |H| ≤ 2, or what [`with_domain`](Self::with_domain) says: the polynomials are fitted within ±1 and mean
/// nothing far outside. Within it a denominator must stay above 0.001 of its value at the centre, with the same sign.
/// What lies outside is [`ProjectionError::OutsideDomain`].
///
/// # Accuracy
/// 10⁻¹⁰ px for pictures of 40,000 px, from [degrees](Self::project_degrees). An angle in radians is itself exact to
/// 0.4 nm on the ground at 45° and 1.5 nm near 180°, which is 10⁻⁹ and 3·10⁻⁹ px of half a metre.
///
/// # Example
/// Of first degree: a sample for each 10⁻⁵°, and 2 m of height move it by one. By hand.
///
/// ```
/// use collinear::camera::rpc::{Rpc, Rpc00b};
/// use collinear::geometry::geodetic::{EllipsoidalHeight, Geodetic};
/// use nalgebra::Point2;
///
/// let mut one = [0.0; 20];
/// one[0] = 1.0;
/// let (mut line, mut sample) = ([0.0; 20], [0.0; 20]);
/// line[2] = -1.0; // −P
/// (sample[1], sample[3]) = (1.0, 0.05); // L + 0.05 H
/// let rpc = Rpc::from_rpc00b(&Rpc00b {
///     line_offset: 4999.5, sample_offset: 4999.5, line_scale: 5000.0, sample_scale: 5000.0,
///     latitude_offset_deg: 44.0, longitude_offset_deg: 5.0, height_offset: 500.0,
///     latitude_scale_deg: 0.05, longitude_scale_deg: 0.05, height_scale: 500.0,
///     line_numerator: line, line_denominator: one, sample_numerator: sample, sample_denominator: one,
///     error_bias: None, error_random: None,
/// })?;
/// // 0.01° north, 0.02° east and 100 m above the centre: 1000 lines up, 2000 + 50 samples right.
/// let place = Geodetic::from_degrees(44.01, 5.02, EllipsoidalHeight(600.0))?;
/// let p = rpc.project(&place)?;
/// assert!((p - Point2::new(5000.0 + 2050.0, 5000.0 - 1000.0)).norm() < 1e-8);
/// let back = rpc.at_height(&p, EllipsoidalHeight(600.0))?;
/// assert!((back.latitude().to_degrees() - 44.01).abs() < 1e-14);
/// assert!((back.longitude().to_degrees() - 5.02).abs() < 1e-14);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[doc(alias("RPC", "RFM", "rational function model"))]
pub struct Rpc {
    record: Rpc00b,
    pub(super) cubics: Cubics,
    pub(super) correction: ImageCorrection,
    domain: f64,
    pub(super) latitude: Angle,
    pub(super) longitude: Angle,
    /// The sign of the determinant of ∂(line, sample)/∂(L, P) at the centre.
    pub(super) orientation: f64,
}

/// Offset and scale of an angle, in radians. The offset is the sum of two floats: that of degrees, rounded to one, would
/// be a nanometre off.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Angle {
    offset: [f64; 2],
    scale: f64,
}

/// π/180 is the sum of these.
const DEGREE: [f64; 2] = [0.017_453_292_519_943_295, 2.948_652_270_870_168_7e-19];

impl Angle {
    fn from_degrees(offset: f64, scale: f64) -> Self {
        let degree = Twofold::new(DEGREE[0]) + Twofold::new(DEGREE[1]);
        let exact = Twofold::new(offset) * degree;
        let high = exact.round();
        let low = (exact - Twofold::new(high)).round();
        Self { offset: [high, low], scale: scale * DEGREE[0] }
    }

    fn normalised(&self, angle: f64, turns: f64) -> f64 {
        ((angle - self.offset[0]) + turns * TAU - self.offset[1]) / self.scale
    }

    pub(super) fn angle(&self, normalised: f64) -> f64 {
        self.offset[0] + (self.offset[1] + normalised * self.scale)
    }
}

/// The turns that bring a difference of longitudes to the nearer side: the picture may lie across the meridian at which
/// they jump.
fn turns(difference: f64, turn: f64) -> f64 {
    if difference > 0.5 * turn {
        -1.0
    } else if difference < -0.5 * turn {
        1.0
    } else {
        0.0
    }
}

/// The centre of the first pixel, from which the polynomials count, in the crate's image coordinates.
const CENTRE_OF_FIRST_PIXEL: f64 = 0.5;

/// A denominator must stay above this share of its value at the centre.
const LEAST_DENOMINATOR: f64 = 1e-3;

/// The least sine of the angle between the gradients of line and sample on the ground, at the centre.
const LEAST_ANGLE: f64 = 1e-9;

/// Line and sample, normalised, with their slopes by L, P and H.
pub(super) struct Linearised {
    pub(super) value: [f64; 2],
    pub(super) slopes: [[f64; 3]; 2],
}

impl Linearised {
    /// The determinant of ∂(line, sample)/∂(L, P).
    pub(super) fn determinant(&self) -> f64 {
        let [a, b] = self.slopes;
        a[0] * b[1] - a[1] * b[0]
    }
}

impl Rpc {
    /// The largest |L|, |P| and |H| that are taken, unless [`with_domain`](Self::with_domain) says another.
    pub const DEFAULT_DOMAIN: f64 = 2.0;

    /// From the numbers of a file, which count pixels from the centre of the first one.
    ///
    /// # Errors
    /// [`Error::NotFinite`]; [`Error::OutOfRange`] for an offset or a scale that no picture has (a scale of zero among
    /// them); [`Error::Degenerate`] for a denominator without a constant term, and where line and sample change in the
    /// same direction on the ground at the centre (the sine of the angle between their gradients is below 10⁻⁹).
    pub fn from_rpc00b(record: &Rpc00b) -> Result<Self, Error> {
        record.check()?;
        for (what, denominator) in [
            ("line denominator", &record.line_denominator),
            ("sample denominator", &record.sample_denominator),
        ] {
            let measure = denominator[0].abs();
            if !(measure > f64::MIN_POSITIVE) {
                return Err(Error::Degenerate { what, measure, limit: f64::MIN_POSITIVE });
            }
        }
        let mut rpc = Self {
            record: *record,
            cubics: Cubics::new(record.polynomials()),
            correction: ImageCorrection::none(),
            domain: Self::DEFAULT_DOMAIN,
            latitude: Angle::from_degrees(record.latitude_offset_deg, record.latitude_scale_deg),
            longitude: Angle::from_degrees(record.longitude_offset_deg, record.longitude_scale_deg),
            orientation: 1.0,
        };
        let centre = rpc.linearised([0.0; 3])?;
        let [a, b] = centre.slopes.map(|s| nalgebra::Vector2::new(s[0], s[1]).norm());
        let measure = centre.determinant().abs() / (a * b);
        if !(measure > LEAST_ANGLE) {
            let what = "the image of the ground at the centre";
            return Err(Error::Degenerate { what, measure, limit: LEAST_ANGLE });
        }
        rpc.orientation = centre.determinant().signum();
        Ok(rpc)
    }

    /// The numbers as a file has them; the correction is not among them.
    #[must_use]
    pub fn to_rpc00b(&self) -> Rpc00b {
        self.record
    }

    /// The same camera with another correction, in place of the one it has.
    #[must_use]
    pub fn with_correction(mut self, correction: ImageCorrection) -> Self {
        self.correction = correction;
        self
    }

    /// The correction from control points.
    #[must_use]
    pub fn correction(&self) -> ImageCorrection {
        self.correction
    }

    /// The same camera with another limit of |L|, |P| and |H|.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] for a limit that is not between 1 and 1000.
    pub fn with_domain(mut self, limit: f64) -> Result<Self, Error> {
        if !(1.0..=1000.0).contains(&limit) {
            let what = "domain of a rational polynomial camera";
            return Err(Error::OutOfRange { what, value: limit, expected: "from 1 to 1000" });
        }
        self.domain = limit;
        Ok(self)
    }

    /// The largest |L|, |P| and |H| that are taken.
    #[must_use]
    pub fn domain(&self) -> f64 {
        self.domain
    }

    /// The middle of the picture that the polynomials were fitted to, without the correction: pixels.
    #[must_use]
    pub fn image_centre(&self) -> Point2<f64> {
        self.image_from_normalised([0.0; 2])
    }

    /// The image (pixels) of a position on WGS84.
    ///
    /// # Errors
    /// [`ProjectionError::OutsideDomain`], [`ProjectionError::NotFinite`].
    #[doc(alias("groundToImage", "image_from_ground"))]
    pub fn project(&self, ground: &Geodetic) -> Result<Point2<f64>, ProjectionError> {
        self.image_at(self.normalised(ground)?)
    }

    /// As [`project`](Self::project), from degrees, in which the polynomials' offsets are: nothing is lost on the way
    /// through radians.
    ///
    /// # Errors
    /// As [`project`](Self::project).
    pub fn project_degrees(
        &self,
        latitude_deg: f64,
        longitude_deg: f64,
        height: EllipsoidalHeight,
    ) -> Result<Point2<f64>, ProjectionError> {
        let record = &self.record;
        // Past the pole, where the polynomials mean nothing.
        if latitude_deg.abs() > 90.0 {
            return Err(ProjectionError::OutsideDomain { value: latitude_deg.abs(), limit: 90.0 });
        }
        let east = longitude_deg - record.longitude_offset_deg;
        let east = east + 360.0 * turns(east, 360.0);
        let ground = self.checked([
            east / record.longitude_scale_deg,
            (latitude_deg - record.latitude_offset_deg) / record.latitude_scale_deg,
            self.normalised_height(height.0),
        ])?;
        self.image_at(ground)
    }

    #[inline]
    fn image_at(&self, normalised: [f64; 3]) -> Result<Point2<f64>, ProjectionError> {
        let ratios = self.ratios(&self.cubics.at(normalised))?;
        Ok(self.correction.apply(&self.image_from_normalised(ratios)))
    }

    /// The image of a place whose height counts from the geoid; latitude and longitude in radians.
    ///
    /// # Errors
    /// As [`GeoidGrid::geodetic`] and [`project`](Self::project).
    pub fn project_orthometric(
        &self,
        latitude: f64,
        longitude: f64,
        height: OrthometricHeight,
        geoid: &GeoidGrid,
    ) -> Result<Point2<f64>, Error> {
        Ok(self.project(&geoid.geodetic(latitude, longitude, height)?)?)
    }

    /// The image with its partial derivatives ∂(x, y)/∂(φ, λ, h): pixels a radian, a radian and a metre.
    ///
    /// # Errors
    /// As [`project`](Self::project).
    pub fn project_jacobian(
        &self,
        ground: &Geodetic,
    ) -> Result<(Point2<f64>, Matrix2x3<f64>), ProjectionError> {
        let at = self.linearised(self.normalised(ground)?)?;
        let [by_line, by_sample] = at.slopes;
        let record = &self.record;
        let row = |[l, p, h]: [f64; 3], scale: f64| {
            [
                p * scale / self.latitude.scale,
                l * scale / self.longitude.scale,
                h * scale / record.height_scale,
            ]
        };
        let rows = [row(by_sample, record.sample_scale), row(by_line, record.line_scale)];
        let raw = Matrix2x3::from_fn(|i, j| rows[i][j]);
        let image = self.correction.apply(&self.image_from_normalised(at.value));
        Ok((image, raw + self.correction.linear() * raw))
    }

    /// (L, P, H) within the domain.
    #[inline]
    fn normalised(&self, ground: &Geodetic) -> Result<[f64; 3], ProjectionError> {
        let longitude = ground.longitude();
        let turns = turns(longitude - self.longitude.offset[0], TAU);
        self.checked([
            self.longitude.normalised(longitude, turns),
            self.latitude.normalised(ground.latitude(), 0.0),
            self.normalised_height(ground.height().0),
        ])
    }

    #[inline]
    fn checked(&self, normalised: [f64; 3]) -> Result<[f64; 3], ProjectionError> {
        for value in normalised {
            self.inside(value)?;
        }
        Ok(normalised)
    }

    #[inline]
    pub(super) fn normalised_height(&self, height: f64) -> f64 {
        (height - self.record.height_offset) / self.record.height_scale
    }

    #[inline]
    pub(super) fn inside(&self, value: f64) -> Result<(), ProjectionError> {
        if value.abs() <= self.domain {
            return Ok(());
        }
        if value.is_nan() {
            return Err(ProjectionError::NotFinite);
        }
        Err(ProjectionError::OutsideDomain { value: value.abs(), limit: self.domain })
    }

    /// N/D for line and sample, where both denominators have kept their sign.
    #[inline]
    fn ratios(&self, sums: &[f64; 4]) -> Result<[f64; 2], ProjectionError> {
        let ratio = |[n, d]: [usize; 2], at_centre: f64| {
            let share = sums[d] / at_centre;
            if !(share > LEAST_DENOMINATOR) {
                // The error reads "value is not below limit".
                let (value, limit) = (-share, -LEAST_DENOMINATOR);
                return Err(ProjectionError::OutsideDomain { value, limit });
            }
            let value = sums[n] / sums[d];
            if value.is_finite() { Ok(value) } else { Err(ProjectionError::NotFinite) }
        };
        let record = &self.record;
        Ok([ratio(LINE, record.line_denominator[0])?, ratio(SAMPLE, record.sample_denominator[0])?])
    }

    /// (N/D)′ = (N′ − (N/D) D′)/D.
    #[inline]
    pub(super) fn linearised(&self, ground: [f64; 3]) -> Result<Linearised, ProjectionError> {
        let (sums, by) = self.cubics.with_slopes(ground);
        let value = self.ratios(&sums)?;
        let slope = |[n, d]: [usize; 2], q: f64| {
            core::array::from_fn(|i| (by[i][n] - q * by[i][d]) / sums[d])
        };
        Ok(Linearised { value, slopes: [slope(LINE, value[0]), slope(SAMPLE, value[1])] })
    }

    #[inline]
    pub(super) fn image_from_normalised(&self, [line, sample]: [f64; 2]) -> Point2<f64> {
        let record = &self.record;
        Point2::new(
            record.sample_offset + record.sample_scale * sample + CENTRE_OF_FIRST_PIXEL,
            record.line_offset + record.line_scale * line + CENTRE_OF_FIRST_PIXEL,
        )
    }

    /// The inverse of [`image_from_normalised`](Self::image_from_normalised).
    #[inline]
    pub(super) fn normalised_from_image(&self, image: &Point2<f64>) -> [f64; 2] {
        let record = &self.record;
        [
            (image.y - CENTRE_OF_FIRST_PIXEL - record.line_offset) / record.line_scale,
            (image.x - CENTRE_OF_FIRST_PIXEL - record.sample_offset) / record.sample_scale,
        ]
    }

    #[inline]
    pub(super) fn record(&self) -> &Rpc00b {
        &self.record
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_offset_keeps_the_digits_beyond_a_float() {
        // mpmath 1.3.0: −33.9° in radians, nearest float and rest.
        let (high, low) = (-0.591_666_616_426_077_7, -5.007_196_876_949_885e-17);
        let angle = Angle::from_degrees(-33.9, 0.1);
        assert_eq!(angle.offset[0], high);
        assert!((angle.offset[1] - low).abs() < 1e-31);
        // The float lies beyond the exact offset, by the rest.
        let normalised = -low / 0.1f64.to_radians();
        assert!((angle.normalised(high, 0.0) - normalised).abs() < 1e-28);
        assert_eq!(angle.angle(normalised), high);
    }
}
