//! Where a platform is, and how it moves.

use nalgebra::{Point3, Rotation3, Vector3, Vector6};

use crate::camera::{ExteriorOrientation, ParameterGroup, no_group};
use crate::error::{Error, ProjectionError};

/// A platform at one moment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlatformState {
    /// C: the projection centre, world units.
    pub center: Point3<f64>,
    /// What rounding took from `center`; zero will do. At 10⁷ m floats are a nanometre apart, and so are lines of a metre then
    /// told apart by a nanoline only.
    pub center_rest: Vector3<f64>,
    /// R: camera_from_world.
    pub camera_from_world: Rotation3<f64>,
    /// dC/dt, world units for each unit of time.
    pub velocity: Vector3<f64>,
    /// ω of dR/dt = \[ω\]× R: in camera axes, radians for each unit of time.
    pub angular_velocity: Vector3<f64>,
}

impl PlatformState {
    /// R (X − C).
    pub(super) fn in_camera(&self, world: &Point3<f64>) -> Vector3<f64> {
        self.camera_from_world * ((world - self.center) - self.center_rest)
    }

    /// d/dt of R (X − C), which is `in_camera`.
    pub(super) fn drift(&self, in_camera: &Vector3<f64>) -> Vector3<f64> {
        self.angular_velocity.cross(in_camera) - self.camera_from_world * self.velocity
    }

    /// The exterior orientation of the moment.
    #[must_use]
    pub fn exterior(&self) -> ExteriorOrientation {
        ExteriorOrientation::new(self.center, self.camera_from_world)
    }
}

/// Exterior orientation as a function of time.
///
/// An [`ExteriorOrientation`] stands still; [`Ephemeris`](super::Ephemeris) is a table; a
/// [`PolynomialTrajectory`](super::PolynomialTrajectory) moves either by polynomials, whose coefficients can be estimated.
///
/// The world is any Cartesian frame: for satellites the rotating Earth's, into which orbits given in inertial axes are
/// turned first.
///
/// # Example
/// A circular orbit of one's own, radius 7000 km, 0.001 rad/s, looking at the centre with y along the flight:
///
/// ```
/// use collinear::ProjectionError;
/// use collinear::camera::{PlatformState, Trajectory};
/// use nalgebra::{Matrix3, Point3, Rotation3, Vector3};
///
/// #[derive(Debug)]
/// struct Circle;
///
/// impl Trajectory for Circle {
///     fn span(&self) -> [f64; 2] {
///         [f64::NEG_INFINITY, f64::INFINITY]
///     }
///     fn state(&self, t: f64) -> Result<PlatformState, ProjectionError> {
///         let (s, c) = (1e-3 * t).sin_cos();
///         let (up, along) = (Vector3::new(c, s, 0.0), Vector3::new(-s, c, 0.0));
///         let rows = [along.cross(&-up), along, -up].map(|r| r.transpose());
///         Ok(PlatformState {
///             center: Point3::from(up * 7e6),
///             center_rest: Vector3::zeros(),
///             camera_from_world: Rotation3::from_matrix_unchecked(Matrix3::from_rows(&rows)),
///             velocity: along * 7e3,
///             // The world ahead turns towards z, about the axis across the flight.
///             angular_velocity: Vector3::new(-1e-3, 0.0, 0.0),
///         })
///     }
/// }
///
/// let ahead = |t: f64| Ok::<_, ProjectionError>(Circle.state(t)?.camera_from_world);
/// let turned = (ahead(1e-3)?.matrix() - ahead(-1e-3)?.matrix()) / 2e-3;
/// let state = Circle.state(0.0)?;
/// let expected = state.angular_velocity.cross_matrix() * state.camera_from_world.matrix();
/// assert!((turned - expected).norm() < 1e-12);
/// # Ok::<(), ProjectionError>(())
/// ```
#[doc(alias("orbit", "ephemeris", "attitude", "flight path"))]
pub trait Trajectory: core::fmt::Debug + Send + Sync {
    /// The first and the last time for which there is a state; infinite where there is one always.
    fn span(&self) -> [f64; 2];

    /// Where the platform is.
    ///
    /// # Errors
    /// [`ProjectionError::OutsideScan`] outside the [`span`](Self::span).
    fn state(&self, time: f64) -> Result<PlatformState, ProjectionError>;

    /// The `group`-th group of parameters, in a fixed order; `None` past the last.
    fn parameter_group(&self, group: usize) -> Option<ParameterGroup> {
        let _ = group;
        None
    }

    /// The current values of a group. Nothing is written past the last.
    fn parameters(&self, group: usize, values: &mut [f64]) {
        let _ = (group, values);
    }

    /// Moves a group by a step.
    ///
    /// # Errors
    /// [`Error::OutOfRange`], [`Error::LengthMismatch`], [`Error::NotFinite`]; the trajectory is then unchanged.
    fn adjust(&mut self, group: usize, step: &[f64]) -> Result<(), Error> {
        let _ = step;
        Err(no_group(group))
    }

    /// What each parameter of a group does to the state: a column a parameter, of ∂C in world units and the left rotation
    /// vector ∂δ, camera_from_world ← exp(\[δ\]×) R.
    ///
    /// # Errors
    /// As [`state`](Self::state).
    fn partials(
        &self,
        time: f64,
        group: usize,
        columns: &mut [Vector6<f64>],
    ) -> Result<(), ProjectionError> {
        let _ = (time, group, columns);
        Ok(())
    }
}

/// It stands still, and nothing of it is estimated.
impl Trajectory for ExteriorOrientation {
    fn span(&self) -> [f64; 2] {
        [f64::NEG_INFINITY, f64::INFINITY]
    }

    fn state(&self, _: f64) -> Result<PlatformState, ProjectionError> {
        Ok(PlatformState {
            center: self.projection_center(),
            center_rest: Vector3::zeros(),
            camera_from_world: self.camera_from_world(),
            velocity: Vector3::zeros(),
            angular_velocity: Vector3::zeros(),
        })
    }
}

/// `base + moved` as a rounded point and what rounding took from it (Knuth's sum, exact).
pub(super) fn moved(base: &Point3<f64>, moved: &Vector3<f64>) -> (Point3<f64>, Vector3<f64>) {
    let sum = base + moved;
    let of_moved = sum - base;
    let of_base = sum - of_moved;
    (sum, (base - of_base) + (moved - of_moved))
}
