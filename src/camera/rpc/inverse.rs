//! From the image to the ground, at a height.

use core::f64::consts::{FRAC_PI_2, PI, TAU};

use nalgebra::Point2;

use super::model::{Linearised, Rpc};
use crate::error::{Error, ProjectionError};
use crate::geometry::geodetic::{EllipsoidalHeight, Geodetic, GeoidGrid, OrthometricHeight};
use crate::numeric::float;

/// Newton's iterations allowed; four are usual.
const MAX_ITERATIONS: u32 = 40;

/// A step that brings nothing after this many halvings is at the rounding floor, or stuck.
const MAX_HALVINGS: u32 = 12;

/// The largest residual of a result, in pixels.
const TOLERANCE: f64 = 1e-9;

/// An iterate may leave the domain by this factor on its way.
const DETOUR: f64 = 4.0;

/// The iterations in which a height above the geoid settles; three are usual.
const MAX_GEOID_ITERATIONS: u32 = 50;

/// How far a settled height may be from the one asked for, in metres.
const HEIGHT_TOLERANCE: f64 = 1e-8;

impl Rpc {
    /// The position that images here, at a height above the ellipsoid.
    ///
    /// Newton's method on (L, P) from the centre of the domain, whose first step is the solution of the linear terms; a
    /// step that does not bring the image closer is halved. It ends at the rounding floor.
    ///
    /// *Accuracy*: the residual is at most 10⁻⁹ px, or 8 units in the last place of the picture's half size where that is
    /// more. On the way and at the end ∂(line, sample)/∂(L, P) has the sign that it has at the centre: the result is
    /// never behind a fold of the polynomials.
    ///
    /// # Errors
    /// [`ProjectionError::OutsideDomain`] where the height or the result is; [`ProjectionError::NotConverged`] with the
    /// residual in pixels where no such position exists; [`ProjectionError::NotFinite`].
    #[doc(alias("imageToGround", "ground_at_height", "localization"))]
    pub fn at_height(
        &self,
        image: &Point2<f64>,
        height: EllipsoidalHeight,
    ) -> Result<Geodetic, ProjectionError> {
        let h = self.normalised_height(height.0);
        self.inside(h)?;
        let target = self.normalised_from_image(&self.correction.remove(image)?);
        if !target.iter().all(|t| t.is_finite()) {
            return Err(ProjectionError::NotFinite);
        }
        let [l, p] = self.solve(target, h)?;
        self.inside(l)?;
        self.inside(p)?;
        let (latitude, longitude) = (self.latitude.angle(p), self.longitude.angle(l));
        let turns = if longitude > PI {
            -TAU
        } else if longitude < -PI {
            TAU
        } else {
            0.0
        };
        Geodetic::new(latitude, longitude + turns, height)
            // Past the pole, where the polynomials mean nothing.
            .map_err(|_| ProjectionError::OutsideDomain { value: latitude.abs(), limit: FRAC_PI_2 })
    }

    /// The position that images here, at a height above the geoid. The height in the result is ellipsoidal.
    ///
    /// The undulation is looked up where the last height leads, until the height settles: a geoid is smooth, and each
    /// round brings four digits.
    ///
    /// *Accuracy*: the height above the geoid within 10⁻⁸ m.
    ///
    /// # Errors
    /// As [`at_height`](Self::at_height) and [`GeoidGrid::undulation`]; [`ProjectionError::NotConverged`] with the last
    /// change of the height in metres where the geoid is so steep that none settles.
    pub fn at_orthometric_height(
        &self,
        image: &Point2<f64>,
        height: OrthometricHeight,
        geoid: &GeoidGrid,
    ) -> Result<Geodetic, Error> {
        let (latitude, longitude) = (self.latitude.angle(0.0), self.longitude.angle(0.0));
        // The centre may lie outside a grid that covers the point.
        let start = geoid.undulation(latitude, longitude).unwrap_or(0.0);
        let mut ellipsoidal = height.0 + start;
        let mut change = f64::INFINITY;
        for _ in 0..MAX_GEOID_ITERATIONS {
            let place = self.at_height(image, EllipsoidalHeight(ellipsoidal))?;
            let next = height.0 + geoid.undulation(place.latitude(), place.longitude())?;
            let last = change;
            change = (next - ellipsoidal).abs();
            // Settled to the last digit, or no longer getting closer.
            if change == 0.0 || (change >= last && last <= HEIGHT_TOLERANCE) {
                return Ok(place);
            }
            ellipsoidal = next;
        }
        let iterations = MAX_GEOID_ITERATIONS;
        Err(ProjectionError::NotConverged { iterations, residual: change }.into())
    }

    /// (L, P) for a normalised (line, sample) and H.
    fn solve(&self, target: [f64; 2], h: f64) -> Result<[f64; 2], ProjectionError> {
        let record = self.record();
        let (lines, samples) = (record.line_scale, record.sample_scale);
        let floor = f64::EPSILON * lines.max(samples);
        let missing = |at: &Linearised| [target[0] - at.value[0], target[1] - at.value[1]];
        let pixels = |m: [f64; 2]| float::hypot(m[0] * lines, m[1] * samples);
        // `None` past the domain, where a denominator vanishes, and behind a fold.
        let at = |place: [f64; 2]| {
            let reach = DETOUR * self.domain();
            let near = place.iter().all(|c| c.abs() <= reach);
            let found = near.then(|| self.linearised([place[0], place[1], h]).ok()).flatten()?;
            (found.determinant() * self.orientation > 0.0).then_some(found)
        };

        let mut place = [0.0; 2];
        let mut here = at(place)
            .ok_or(ProjectionError::NotConverged { iterations: 0, residual: f64::INFINITY })?;
        let mut residual = pixels(missing(&here));
        let mut iterations = 0;
        while residual > 0.5 * floor && iterations < MAX_ITERATIONS {
            iterations += 1;
            let ([a, b], d) = (here.slopes, here.determinant());
            let [u, v] = missing(&here);
            let step = [(u * b[1] - v * a[1]) / d, (v * a[0] - u * b[0]) / d];
            let halvings = if residual <= TOLERANCE { 1 } else { MAX_HALVINGS };
            let closer = (0..halvings).find_map(|k| {
                let share = 1.0 / f64::from(1 << k);
                let next = [place[0] + share * step[0], place[1] + share * step[1]];
                let found = at(next)?;
                let left = pixels(missing(&found));
                (left < residual).then_some((next, found, left))
            });
            let Some((next, found, left)) = closer else { break };
            (place, here, residual) = (next, found, left);
        }
        if residual <= TOLERANCE.max(8.0 * floor) {
            Ok(place)
        } else {
            Err(ProjectionError::NotConverged { iterations, residual })
        }
    }
}
