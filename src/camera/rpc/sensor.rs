//! A rational polynomial camera in a Cartesian world.

use core::f64::consts::PI;

use nalgebra::{Matrix2x3, Matrix3, Point2, Point3, Vector2, Vector3};

use super::correction::ImageCorrection;
use super::model::Rpc;
use crate::camera::{Adjustable, ParameterGroup, SensorModel, collinearity, no_group};
use crate::error::{Error, ProjectionError};
use crate::geometry::geodetic::{EarthFrame, Ellipsoid, EllipsoidalHeight, Geodetic};
use crate::geometry::{HeightCurve, Locus, Surface};
use crate::numeric::float;

/// A rational polynomial camera whose world is a Cartesian frame on the Earth: geocentric or local.
///
/// # Model
/// ```text
/// image = Rpc( φ, λ, h of X )
/// ```
/// # Locus
/// A cubic over the ellipsoidal height, through four exact points at Chebyshev's heights, over the heights that the
/// polynomials were fitted for (|H| ≤ 1). Its `error_bound` is **twice** the largest distance from the exact points at
/// thirteen other heights, the five extrema of Chebyshev's T₄ (where the interpolation's remainder is largest) and two
/// between each pair, plus four units in the last place of the coordinates.
///
/// # Ground
/// The point on the cubic is only a start: the point returned lies on the exact locus, so that
/// [`project`](SensorModel::project) after [`ground`](SensorModel::ground) is the identity within the rounding of the world
/// coordinates: 10⁻⁸ px in geocentric ones. A surface that is not met within |H| ≤ 1 is looked for in the whole domain of
/// the model; the highest crossing is taken. It is on the surface within 2 ε of the largest coordinate, or where its
/// [`height_above`](Surface::height_above) changes sign between neighbouring heights.
///
/// # Parameters
/// Three groups of the image correction, each x and y: `"image shift"` in pixels, `"image drift"` in pixels a line,
/// `"image shear"` in pixels a sample, the last two about the correction's centre. The polynomials are held.
///
/// # Example
/// A model of first degree on the equator, on the level 100 m above the ellipsoid.
///
/// ```
/// use collinear::camera::SensorModel;
/// use collinear::camera::rpc::{Rpc, Rpc00b, RpcSensor};
/// use collinear::geometry::geodetic::{EarthFrame, Ellipsoid, EllipsoidalHeight};
/// use nalgebra::Point2;
///
/// let polynomial = |k: usize, c: f64| { let mut p = [0.0; 20]; p[k] = c; p };
/// let mut sample = polynomial(1, 1.0);
/// sample[3] = 0.05;
/// let rpc = Rpc::from_rpc00b(&Rpc00b {
///     line_offset: 4999.5, sample_offset: 4999.5, line_scale: 5000.0, sample_scale: 5000.0,
///     latitude_offset_deg: 0.0, longitude_offset_deg: 0.0, height_offset: 500.0,
///     latitude_scale_deg: 0.05, longitude_scale_deg: 0.05, height_scale: 500.0,
///     line_numerator: polynomial(2, -1.0), line_denominator: polynomial(0, 1.0),
///     sample_numerator: sample, sample_denominator: polynomial(0, 1.0),
///     error_bias: None, error_random: None,
/// })?;
/// let frame = EarthFrame::Geocentric(Ellipsoid::WGS84);
/// let sensor = RpcSensor::new(rpc, frame);
/// // 400 m below the middle height the picture lies 400 · 0.05/500 · 0.05° = 0.002° to the east.
/// let p = sensor.ground(&Point2::new(5000.0, 5000.0), &frame.at_height(EllipsoidalHeight(100.0))?)?;
/// assert!((p.y.atan2(p.x).to_degrees() - 0.002).abs() < 1e-13);
/// assert!((p.coords.norm() - 6_378_237.0).abs() < 1e-8);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RpcSensor {
    rpc: Rpc,
    frame: EarthFrame,
}

const GROUPS: [ParameterGroup; 3] = [
    ParameterGroup { name: "image shift", len: 2 },
    ParameterGroup { name: "image drift", len: 2 },
    ParameterGroup { name: "image shear", len: 2 },
];

/// The extrema of Chebyshev's T₄ are at the ends of four intervals of the angle; a bound needs points between them.
const EXTREMA: u32 = 4;
const CHECKS: u32 = 12;

/// A surface is sought within this many doublings of the cubic's error.
const MAX_DOUBLINGS: u32 = 40;

/// Bisection alone would need 60.
const MAX_ITERATIONS: u32 = 200;

impl RpcSensor {
    /// The camera in a frame, whose ellipsoid should be WGS84, since the polynomials' is.
    #[must_use]
    pub fn new(rpc: Rpc, frame: EarthFrame) -> Self {
        Self { rpc, frame }
    }

    /// The camera in geocentric coordinates on WGS84.
    #[must_use]
    pub fn geocentric(rpc: Rpc) -> Self {
        Self::new(rpc, EarthFrame::Geocentric(Ellipsoid::WGS84))
    }

    /// The camera.
    #[must_use]
    pub fn rpc(&self) -> &Rpc {
        &self.rpc
    }

    /// The frame of its world.
    #[must_use]
    pub fn frame(&self) -> &EarthFrame {
        &self.frame
    }

    /// The exact locus at a height.
    fn at(&self, image: &Point2<f64>, height: f64) -> Result<Point3<f64>, ProjectionError> {
        let place = self.rpc.at_height(image, EllipsoidalHeight(height))?;
        Ok(self.frame.world_from_geodetic(&place))
    }

    /// The cubic over the heights |H| ≤ `reach`, compared with the exact locus at the heights that `checks` intervals of
    /// the angle part.
    fn curve(
        &self,
        image: &Point2<f64>,
        reach: f64,
        checks: u32,
    ) -> Result<HeightCurve, ProjectionError> {
        let record = self.rpc.record();
        let (middle, half) = (record.height_offset, record.height_scale * reach);
        let exact = |t: f64| self.at(image, middle + half * t);
        // Chebyshev's four nodes in [−1, 1], and Newton's divided differences between them.
        let nodes = [7.0, 5.0, 3.0, 1.0].map(|k| float::sin_cos(k * PI / 8.0).1);
        let mut d = [Vector3::zeros(); 4];
        for (value, t) in d.iter_mut().zip(nodes) {
            *value = exact(t)?.coords;
        }
        let largest = d.iter().fold(0.0_f64, |m, v| m.max(v.amax()));
        for order in 1..4 {
            for i in (order..4).rev() {
                d[i] = (d[i] - d[i - 1]) / (nodes[i] - nodes[i - order]);
            }
        }
        // From Newton's form to powers of t, by Horner's rule; the constant keeps its place for the last.
        let mut c = [d[3], Vector3::zeros(), Vector3::zeros(), Vector3::zeros()];
        for i in (0..3).rev() {
            for k in (1..4).rev() {
                c[k] = c[k - 1] - c[k] * nodes[i];
            }
            c[0] = d[i] - c[0] * nodes[i];
        }
        let coefficients = [c[0], c[1] / half, c[2] / (half * half), c[3] / (half * half * half)];
        let heights = [middle - half, middle + half];
        let mut curve =
            HeightCurve { coefficients, reference_height: middle, heights, error_bound: 0.0 };
        let mut off = 0.0_f64;
        for k in 0..=checks {
            let t = float::sin_cos(PI * f64::from(k) / f64::from(checks)).1;
            off = off.max((curve.at(middle + half * t) - exact(t)?).norm());
        }
        curve.error_bound = 2.0 * off + 4.0 * f64::EPSILON * largest;
        Ok(curve)
    }

    /// The exact locus on the surface, near a point that lies within the cubic's error of it.
    fn refine(
        &self,
        image: &Point2<f64>,
        surface: &dyn Surface,
        curve: &HeightCurve,
        start: &Point3<f64>,
    ) -> Result<Point3<f64>, ProjectionError> {
        let at = |h: f64| {
            let p = self.at(image, h)?;
            Ok((p, surface.height_above(&p)))
        };
        let close = |p: &Point3<f64>, f: f64| f.abs() <= 2.0 * f64::EPSILON * p.coords.amax();
        let [low, high] = curve.heights;
        let middle = self.frame.geodetic_from_world(start)?.height().0.clamp(low, high);
        let (p, f) = at(middle)?;
        if close(&p, f) {
            return Ok(p);
        }
        // The nearest change of sign on either side.
        let mut width = f.abs().max(curve.error_bound).max(1e-9);
        let mut bracket = None;
        let mut ends = [(middle, f); 2];
        for _ in 0..MAX_DOUBLINGS {
            let mut moved = false;
            for (end, limit) in ends.iter_mut().zip([low, high]) {
                let next = (middle + (limit - middle).signum() * width).clamp(low, high);
                if next == end.0 {
                    continue;
                }
                moved = true;
                let (p, value) = at(next)?;
                if close(&p, value) {
                    return Ok(p);
                }
                if value * end.1 < 0.0 {
                    bracket = Some((*end, (next, value)));
                    break;
                }
                *end = (next, value);
            }
            if bracket.is_some() || !moved {
                break;
            }
            width *= 2.0;
        }
        let ((mut a, mut fa), (mut b, mut fb)) = bracket.ok_or(ProjectionError::MissesSurface)?;
        // Regula falsi after Illinois (Dowell & Jarratt 1971), with a bisection every third time.
        for round in 1..=MAX_ITERATIONS {
            let secant = b - fb * (b - a) / (fb - fa);
            let half = 0.5 * (a + b);
            let inside = (secant > a.min(b)) && (secant < a.max(b));
            let h = if inside && round % 3 != 0 { secant } else { half };
            let (p, f) = at(h)?;
            if close(&p, f) || h == a || h == b {
                return Ok(p);
            }
            if f * fb < 0.0 {
                (a, fa) = (b, fb);
            } else {
                fa *= 0.5;
            }
            (b, fb) = (h, f);
        }
        Err(ProjectionError::NotConverged { iterations: MAX_ITERATIONS, residual: fb })
    }

    /// ∂(φ, λ, h)/∂(X, Y, Z): north/(M + h), east/((N + h) cos φ), up.
    fn geodetic_jacobian(&self, place: &Geodetic) -> Matrix3<f64> {
        let ellipsoid = self.frame.ellipsoid();
        let (latitude, height) = (place.latitude(), place.height().0);
        let (sp, cp) = float::sin_cos(latitude);
        let (sl, cl) = float::sin_cos(place.longitude());
        let along = ellipsoid.meridian_radius(latitude) + height;
        let around = (ellipsoid.prime_vertical_radius(latitude) + height) * cp;
        let rows = Matrix3::new(
            -sp * cl / along,
            -sp * sl / along,
            cp / along,
            -sl / around,
            cl / around,
            0.0,
            cp * cl,
            cp * sl,
            sp,
        );
        rows * self.frame.pose().rotation.inverse().matrix()
    }
}

impl SensorModel for RpcSensor {
    fn project(&self, world: &Point3<f64>) -> Result<Point2<f64>, ProjectionError> {
        self.rpc.project(&self.frame.geodetic_from_world(world)?)
    }

    fn project_jacobian(
        &self,
        world: &Point3<f64>,
    ) -> Result<(Point2<f64>, Matrix2x3<f64>), ProjectionError> {
        let place = self.frame.geodetic_from_world(world)?;
        let (image, by_place) = self.rpc.project_jacobian(&place)?;
        let by_world = by_place * self.geodetic_jacobian(&place);
        // At a pole the longitude has no derivative.
        if by_world.iter().all(|v| v.is_finite()) {
            Ok((image, by_world))
        } else {
            Err(ProjectionError::NotFinite)
        }
    }

    fn locus(&self, image: &Point2<f64>) -> Result<Locus, ProjectionError> {
        self.curve(image, 1.0, CHECKS).map(Locus::Curve)
    }

    fn ground(
        &self,
        image: &Point2<f64>,
        surface: &dyn Surface,
    ) -> Result<Point3<f64>, ProjectionError> {
        let on = |reach: f64| {
            let curve = self.curve(image, reach, EXTREMA)?;
            let start = surface.meet_curve(&curve)?;
            self.refine(image, surface, &curve, &start)
        };
        match on(1.0) {
            Err(ProjectionError::MissesSurface) => on(self.rpc.domain()),
            found => found,
        }
    }
}

impl Adjustable for RpcSensor {
    fn parameter_group(&self, group: usize) -> Option<ParameterGroup> {
        GROUPS.get(group).copied()
    }

    fn parameters(&self, group: usize, values: &mut [f64]) {
        let correction = self.rpc.correction();
        let (s, a) = (correction.shift(), correction.linear());
        let of = match group {
            0 => [s.x, s.y],
            1 => [a.m12, a.m22],
            2 => [a.m11, a.m21],
            _ => return,
        };
        for (value, v) in values.iter_mut().zip(of) {
            *value = v;
        }
    }

    fn adjust(&mut self, group: usize, step: &[f64]) -> Result<(), Error> {
        if group >= GROUPS.len() {
            return Err(no_group(group));
        }
        let &[x, y] = step else {
            let what = "step and image correction";
            return Err(Error::LengthMismatch { what, left: step.len(), right: 2 });
        };
        let old = self.rpc.correction();
        let (mut shift, mut linear) = (old.shift(), old.linear());
        if group == 0 {
            shift += Vector2::new(x, y);
        } else {
            let column = if group == 1 { 1 } else { 0 };
            linear[(0, column)] += x;
            linear[(1, column)] += y;
        }
        // A linear part that begins acts about the middle of the picture.
        let about =
            if old == ImageCorrection::none() { self.rpc.image_centre() } else { old.about() };
        self.rpc = self.rpc.with_correction(ImageCorrection::new(about, shift, linear)?);
        Ok(())
    }

    fn partials(
        &self,
        object: &Point3<f64>,
        by_object: &mut [f64; 6],
        by_group: &mut [&mut [f64]],
    ) -> Result<Point2<f64>, ProjectionError> {
        let (image, by_world) = self.project_jacobian(object)?;
        collinearity::write_rows(&by_world, by_object);
        if by_group.iter().any(|g| !g.is_empty()) {
            let correction = self.rpc.correction();
            let none = correction == ImageCorrection::none();
            let about = if none { self.rpc.image_centre() } else { correction.about() };
            let from = correction.remove(&image)? - about;
            for (out, factor) in by_group.iter_mut().zip([1.0, from.y, from.x]) {
                if let [xx, xy, yx, yy] = &mut **out {
                    (*xx, *xy, *yx, *yy) = (factor, 0.0, 0.0, factor);
                }
            }
        }
        Ok(image)
    }
}
