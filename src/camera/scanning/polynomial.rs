//! Trajectories moved by polynomials of time.

use alloc::vec;
use alloc::vec::Vec;

use nalgebra::{Vector3, Vector6};

use super::{PlatformState, Trajectory, trajectory};
use crate::camera::{ExteriorOrientation, ParameterGroup, no_group};
use crate::error::{Error, ProjectionError};
use crate::geometry::rotation::RotationVector;

/// A trajectory moved by polynomials: of itself a flight of constant velocity or a smooth path, over an ephemeris its
/// correction.
///
/// # Model
/// ```text
/// C(t) = C₀(t) + p₀ + p₁ s + p₂ s² + …            s = (t − t₀) / T
/// R(t) = exp([w₀ + w₁ s + w₂ s² + …]×) R₀(t)
/// ```
/// C₀ and R₀ are those of the base: an [`ExteriorOrientation`], which stands still, or an [`Ephemeris`](super::Ephemeris). p is in
/// world units and axes, w a rotation vector in radians and camera axes. T brings s into −1 … 1 over the scan, so that
/// the coefficients are of one size.
///
/// # Parameters
/// Group 0 is p, group 1 is w, three numbers a power, each where it has any.
///
/// # Accuracy
/// The rotation is singular as a function of w at a whole turn; corrections and scans turn less.
///
/// # Example
/// Constant velocity 70 along x and a turn of 0.1 a second about the camera's z axis; after 2 seconds:
///
/// ```
/// use collinear::camera::{ExteriorOrientation, PolynomialTrajectory, Trajectory};
/// use nalgebra::{Point3, Vector3};
///
/// let start = ExteriorOrientation::look_at(Point3::new(5.0, 0.0, 800.0), Point3::new(5.0, 0.0, 0.0), Vector3::y())?;
/// let flight = PolynomialTrajectory::constant_velocity(start, 10.0, Vector3::new(70.0, 0.0, 0.0), Vector3::new(0.0, 0.0, 0.1))?;
/// let state = flight.state(12.0)?;
/// assert_eq!(state.center, Point3::new(145.0, 0.0, 800.0));
/// // What lay along x lies 0.2 rad from it.
/// let turned = state.camera_from_world * Vector3::x();
/// assert!((turned - Vector3::new(0.980066577841242, 0.198669330795061, 0.0)).norm() < 1e-15);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
#[doc(alias("velocity", "orbit correction", "drift", "bias"))]
pub struct PolynomialTrajectory<B> {
    base: B,
    origin: f64,
    unit: f64,
    position: Vec<Vector3<f64>>,
    attitude: Vec<Vector3<f64>>,
}

impl PolynomialTrajectory<ExteriorOrientation> {
    /// A platform that is at `exterior` at the time `origin` and moves on at a constant velocity (world units for each unit
    /// of time) and angular velocity (camera axes, radians for each unit of time).
    ///
    /// # Errors
    /// [`Error::NotFinite`].
    pub fn constant_velocity(
        exterior: ExteriorOrientation,
        origin: f64,
        velocity: Vector3<f64>,
        angular_velocity: Vector3<f64>,
    ) -> Result<Self, Error> {
        let position = vec![Vector3::zeros(), velocity];
        let attitude = vec![Vector3::zeros(), angular_velocity];
        Self::new(exterior, origin, 1.0, position, attitude)
    }
}

impl<B: Trajectory> PolynomialTrajectory<B> {
    /// From its base, t₀, T and the coefficients of p and w, lowest power first.
    ///
    /// # Errors
    /// [`Error::NotFinite`]; [`Error::OutOfRange`] where T is zero.
    pub fn new(
        base: B,
        origin: f64,
        unit: f64,
        position: Vec<Vector3<f64>>,
        attitude: Vec<Vector3<f64>>,
    ) -> Result<Self, Error> {
        let numbers = position.iter().chain(&attitude).flat_map(|v| v.iter());
        if !numbers.chain([&origin, &unit]).all(|v| v.is_finite()) {
            return Err(Error::NotFinite { what: "polynomial trajectory" });
        }
        if unit == 0.0 {
            let expected = "a time other than zero";
            return Err(Error::OutOfRange { what: "unit of time", value: unit, expected });
        }
        Ok(Self { base, origin, unit, position, attitude })
    }

    /// C₀ and R₀.
    #[must_use]
    pub fn base(&self) -> &B {
        &self.base
    }

    /// t₀ and T.
    #[must_use]
    pub fn time_scale(&self) -> [f64; 2] {
        [self.origin, self.unit]
    }

    /// p₀, p₁, …
    #[must_use]
    pub fn position(&self) -> &[Vector3<f64>] {
        &self.position
    }

    /// w₀, w₁, …
    #[must_use]
    pub fn attitude(&self) -> &[Vector3<f64>] {
        &self.attitude
    }

    fn scaled(&self, time: f64) -> f64 {
        (time - self.origin) / self.unit
    }

    fn coefficients(&self, group: usize) -> Option<(Kind, &[Vector3<f64>])> {
        let groups = [(Kind::Position, &self.position), (Kind::Attitude, &self.attitude)];
        let mut present = groups.into_iter().filter(|(_, c)| !c.is_empty());
        present.nth(group).map(|(kind, c)| (kind, c.as_slice()))
    }
}

#[derive(Clone, Copy)]
enum Kind {
    Position,
    Attitude,
}

/// The value and the slope of a polynomial with vectors for coefficients.
fn horner(coefficients: &[Vector3<f64>], s: f64) -> (Vector3<f64>, Vector3<f64>) {
    let zero = Vector3::zeros();
    coefficients
        .iter()
        .rev()
        .fold((zero, zero), |(value, slope), c| (value * s + c, slope * s + value))
}

impl<B: Trajectory> Trajectory for PolynomialTrajectory<B> {
    fn span(&self) -> [f64; 2] {
        self.base.span()
    }

    fn state(&self, time: f64) -> Result<PlatformState, ProjectionError> {
        let base = self.base.state(time)?;
        let s = self.scaled(time);
        let (moved, velocity) = horner(&self.position, s);
        let (center, rest) = trajectory::moved(&base.center, &(moved + base.center_rest));
        let mut state = PlatformState {
            center,
            center_rest: rest,
            velocity: base.velocity + velocity / self.unit,
            ..base
        };
        if !self.attitude.is_empty() {
            let (turned, rate) = horner(&self.attitude, s);
            let (turn, left) = RotationVector::new(turned).rotation_with_left();
            state.camera_from_world = turn * base.camera_from_world;
            state.angular_velocity = turn * base.angular_velocity + left * (rate / self.unit);
        }
        Ok(state)
    }

    fn parameter_group(&self, group: usize) -> Option<ParameterGroup> {
        self.coefficients(group).map(|(kind, c)| ParameterGroup {
            name: match kind {
                Kind::Position => "position polynomial",
                Kind::Attitude => "attitude polynomial",
            },
            len: 3 * c.len(),
        })
    }

    fn parameters(&self, group: usize, values: &mut [f64]) {
        if let Some((_, c)) = self.coefficients(group) {
            for (value, own) in values.iter_mut().zip(c.iter().flat_map(|v| v.iter())) {
                *value = *own;
            }
        }
    }

    fn adjust(&mut self, group: usize, step: &[f64]) -> Result<(), Error> {
        let (kind, c) = self.coefficients(group).ok_or_else(|| no_group(group))?;
        if step.len() != 3 * c.len() {
            return Err(Error::LengthMismatch {
                what: "parameter group and step",
                left: 3 * c.len(),
                right: step.len(),
            });
        }
        let moved: Vec<Vector3<f64>> = c
            .iter()
            .zip(step.chunks_exact(3))
            .map(|(c, s)| c + Vector3::new(s[0], s[1], s[2]))
            .collect();
        if !moved.iter().flat_map(|v| v.iter()).all(|v| v.is_finite()) {
            return Err(Error::NotFinite { what: "polynomial trajectory" });
        }
        match kind {
            Kind::Position => self.position = moved,
            Kind::Attitude => self.attitude = moved,
        }
        Ok(())
    }

    fn partials(
        &self,
        time: f64,
        group: usize,
        columns: &mut [Vector6<f64>],
    ) -> Result<(), ProjectionError> {
        let Some((kind, _)) = self.coefficients(group) else { return Ok(()) };
        let s = self.scaled(time);
        let (mut upper, mut lower) = (nalgebra::Matrix3::zeros(), nalgebra::Matrix3::zeros());
        match kind {
            Kind::Position => upper.fill_diagonal(1.0),
            Kind::Attitude => {
                let turned = horner(&self.attitude, s).0;
                lower = RotationVector::new(turned).left_from_vector();
            }
        }
        let mut power = 1.0;
        for three in columns.chunks_exact_mut(3) {
            for (i, column) in three.iter_mut().enumerate() {
                column.fixed_rows_mut::<3>(0).copy_from(&(upper.column(i) * power));
                column.fixed_rows_mut::<3>(3).copy_from(&(lower.column(i) * power));
            }
            power *= s;
        }
        Ok(())
    }
}
