//! The numbers of a rational polynomial camera as its standard and its files have them.

use super::cubic::TERMS;
use crate::error::Error;

/// A rational polynomial camera as its file states it: RPC00B of STDI-0002, appendix E.
///
/// Lines and samples count from the **centre** of the first pixel; angles are degrees; heights are metres above the
/// WGS84 ellipsoid. [`Rpc::from_rpc00b`](super::Rpc::from_rpc00b) crosses to the conventions of this crate.
///
/// Each polynomial has its coefficients in the order 1, L, P, H, LP, LH, PH, L², P², H², LPH, L³, LP², LH², L²P, P³,
/// PH², L²H, P²H, H³, with L, P and H the normalised longitude, latitude and height.
#[derive(Clone, Copy, Debug, PartialEq)]
#[doc(alias("RPC00B", "RFM", "rational function model"))]
pub struct Rpc00b {
    /// LINE_OFF, in pixels.
    pub line_offset: f64,
    /// SAMP_OFF, in pixels.
    pub sample_offset: f64,
    /// LAT_OFF, in degrees.
    pub latitude_offset_deg: f64,
    /// LONG_OFF, in degrees.
    pub longitude_offset_deg: f64,
    /// HEIGHT_OFF, in metres above the ellipsoid.
    pub height_offset: f64,
    /// LINE_SCALE, in pixels.
    pub line_scale: f64,
    /// SAMP_SCALE, in pixels.
    pub sample_scale: f64,
    /// LAT_SCALE, in degrees.
    pub latitude_scale_deg: f64,
    /// LONG_SCALE, in degrees.
    pub longitude_scale_deg: f64,
    /// HEIGHT_SCALE, in metres.
    pub height_scale: f64,
    /// LINE_NUM_COEFF.
    pub line_numerator: [f64; TERMS],
    /// LINE_DEN_COEFF.
    pub line_denominator: [f64; TERMS],
    /// SAMP_NUM_COEFF.
    pub sample_numerator: [f64; TERMS],
    /// SAMP_DEN_COEFF.
    pub sample_denominator: [f64; TERMS],
    /// ERR_BIAS: the bias of a ground position, in metres a horizontal axis; not used by any equation.
    pub error_bias: Option<f64>,
    /// ERR_RAND: the random error of a ground position, in metres a horizontal axis; not used by any equation.
    pub error_random: Option<f64>,
}

/// Where each coefficient of RPC00A stands in RPC00B.
const B_FROM_A: [usize; TERMS] =
    [0, 1, 2, 3, 4, 5, 6, 10, 7, 8, 9, 11, 14, 17, 12, 15, 18, 13, 16, 19];

impl Rpc00b {
    /// A polynomial of the older RPC00A, whose order is 1, L, P, H, LP, LH, PH, LPH, L², P², H², L³, L²P, L²H, LP²,
    /// P³, P²H, LH², PH², H³, in the order of RPC00B.
    ///
    /// ```
    /// use collinear::camera::rpc::Rpc00b;
    ///
    /// // LPH is the eighth term of RPC00A and the eleventh of RPC00B.
    /// let mut polynomial = [0.0; 20];
    /// polynomial[7] = 1.0;
    /// assert_eq!(Rpc00b::from_rpc00a_order(&polynomial)[10], 1.0);
    /// ```
    #[must_use]
    pub fn from_rpc00a_order(polynomial: &[f64; TERMS]) -> [f64; TERMS] {
        let mut ordered = [0.0; TERMS];
        for (value, place) in polynomial.iter().zip(B_FROM_A) {
            ordered[place] = *value;
        }
        ordered
    }

    /// The four polynomials: line numerator and denominator, sample numerator and denominator.
    pub(super) fn polynomials(&self) -> [&[f64; TERMS]; 4] {
        [
            &self.line_numerator,
            &self.line_denominator,
            &self.sample_numerator,
            &self.sample_denominator,
        ]
    }

    pub(super) fn check(&self) -> Result<(), Error> {
        let offsets = [
            ("line offset", self.line_offset, 1e9, "within ±10⁹ pixels"),
            ("sample offset", self.sample_offset, 1e9, "within ±10⁹ pixels"),
            ("latitude offset", self.latitude_offset_deg, 90.0, "within ±90°"),
            ("longitude offset", self.longitude_offset_deg, 360.0, "within ±360°"),
            ("height offset", self.height_offset, 1e7, "within ±10⁷ m"),
        ];
        for (what, value, limit, expected) in offsets {
            if !value.is_finite() {
                return Err(Error::NotFinite { what });
            }
            if value.abs() > limit {
                return Err(Error::OutOfRange { what, value, expected });
            }
        }
        let scales = [
            ("line scale", self.line_scale, 1e-3..=1e9, "from 10⁻³ to 10⁹ pixels"),
            ("sample scale", self.sample_scale, 1e-3..=1e9, "from 10⁻³ to 10⁹ pixels"),
            ("latitude scale", self.latitude_scale_deg, 1e-9..=180.0, "from 10⁻⁹ to 180°"),
            ("longitude scale", self.longitude_scale_deg, 1e-9..=360.0, "from 10⁻⁹ to 360°"),
            ("height scale", self.height_scale, 1e-6..=1e7, "from 10⁻⁶ to 10⁷ m"),
        ];
        for (what, value, range, expected) in scales {
            if !value.is_finite() {
                return Err(Error::NotFinite { what });
            }
            if !range.contains(&value) {
                return Err(Error::OutOfRange { what, value, expected });
            }
        }
        let names =
            ["line numerator", "line denominator", "sample numerator", "sample denominator"];
        for (what, polynomial) in names.into_iter().zip(self.polynomials()) {
            for &value in polynomial {
                if !value.is_finite() {
                    return Err(Error::NotFinite { what });
                }
                if value.abs() > 1e100 {
                    return Err(Error::OutOfRange { what, value, expected: "within ±10¹⁰⁰" });
                }
            }
        }
        for (what, value) in [("error bias", self.error_bias), ("error random", self.error_random)]
        {
            if value.is_some_and(|v| !v.is_finite()) {
                return Err(Error::NotFinite { what });
            }
        }
        Ok(())
    }
}
