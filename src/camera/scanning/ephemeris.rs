//! Trajectories given as tables.

use alloc::vec::Vec;

use nalgebra::{Point3, Rotation3, Vector3, Vector4};

use super::interpolation::{MOST_NODES, Nodes};
use super::{PlatformState, Trajectory, trajectory};
use crate::error::{Error, ProjectionError};
use crate::geometry::rotation::{Quaternion, RotationVector};
use crate::numeric::float;

/// How a table is read between its nodes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Interpolation {
    /// Positions along straight lines, attitudes along great circles (slerp; Shoemake 1985): one constant velocity and angular
    /// velocity an interval.
    #[doc(alias("slerp"))]
    Linear,
    /// Lagrange's polynomial through this even number of nodes, 2 to 12; attitudes by the four components of their
    /// quaternions, brought to length one. Eight is usual for satellites.
    Lagrange(usize),
}

/// An orbit or a flight path as measured: positions and attitudes at given times, each table with its own nodes.
///
/// Positions are projection centres in world units, attitudes are camera_from_world. Both are read between their nodes as
/// [`Interpolation`] says. Nothing is extrapolated.
///
/// # Accuracy
/// Positions are interpolated as differences from a node, so that coordinates of 10⁷ m keep their nanometres. The state is
/// continuous; its velocity has a step at a node, large with [`Interpolation::Linear`] and tiny with eight nodes.
///
/// # Example
/// x = t³ at t = 0, 1, 2, 3: a cubic gives (2.5)³ = 15.625 and the slope 18.75, a line 8 + 19/2.
///
/// ```
/// use collinear::camera::{Ephemeris, Interpolation, Trajectory};
/// use nalgebra::{Point3, Rotation3};
///
/// let times = [0.0, 1.0, 2.0, 3.0];
/// let positions = times.map(|t| Point3::new(t * t * t, 0.0, 700.0));
/// let attitudes = times.map(|t| Rotation3::from_euler_angles(0.0, 0.0, 0.2 * t));
/// let table = |how| Ephemeris::new((&times, &positions, how), (&times, &attitudes, Interpolation::Linear));
/// let state = table(Interpolation::Lagrange(4))?.state(2.5)?;
/// assert!((state.center - Point3::new(15.625, 0.0, 700.0)).norm() < 1e-13);
/// assert!((state.velocity.x - 18.75).abs() < 1e-13);
/// assert!((state.angular_velocity.z - 0.2).abs() < 1e-15);
/// assert_eq!(table(Interpolation::Linear)?.state(2.5)?.center.x, 17.5);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
#[doc(alias("orbit", "state vectors", "IMU", "quaternions"))]
pub struct Ephemeris {
    position_times: Nodes,
    positions: Vec<Point3<f64>>,
    position_between: Interpolation,
    attitude_times: Nodes,
    attitudes: Vec<Vector4<f64>>,
    /// Of the great circles: the rotation vectors from each attitude to the next.
    turns: Vec<Vector3<f64>>,
    attitude_between: Interpolation,
}

/// A node, the way from it, and the velocity.
struct Place {
    node: Point3<f64>,
    way: Vector3<f64>,
    velocity: Vector3<f64>,
}

/// Neighbours whose quaternions have a smaller product are more than 2.6 rad apart: which way round is a guess.
const LEAST_PRODUCT: f64 = 0.25;

impl Ephemeris {
    /// From times, values and interpolation of the positions (world units), and those of the attitudes
    /// (camera_from_world).
    ///
    /// # Errors
    /// [`Error::LengthMismatch`], [`Error::TooFewPoints`] for fewer nodes than the interpolation needs or than two,
    /// [`Error::NotFinite`], [`Error::OutOfRange`] for times that do not ascend, tables that share no time, an interpolation through an odd
    /// number of nodes or more than twelve, and neighbouring attitudes more than 2.6 rad apart.
    pub fn new(
        positions: (&[f64], &[Point3<f64>], Interpolation),
        attitudes: (&[f64], &[Rotation3<f64>], Interpolation),
    ) -> Result<Self, Error> {
        let position_times =
            nodes("times of positions", positions.0, positions.1.len(), positions.2)?;
        let attitude_times =
            nodes("times of attitudes", attitudes.0, attitudes.1.len(), attitudes.2)?;
        if !positions.1.iter().all(|p| p.iter().all(|c| c.is_finite())) {
            return Err(Error::NotFinite { what: "ephemeris position" });
        }
        let mut quaternions: Vec<Vector4<f64>> = Vec::with_capacity(attitudes.1.len());
        for rotation in attitudes.1 {
            if !rotation.matrix().iter().all(|c| c.is_finite()) {
                return Err(Error::NotFinite { what: "ephemeris attitude" });
            }
            let Quaternion { w, x, y, z } = Quaternion::from_rotation(rotation);
            let mut q = Vector4::new(w, x, y, z);
            if let Some(before) = quaternions.last() {
                // q and −q are one rotation; neighbours are the nearer of the two.
                if q.dot(before) < 0.0 {
                    q = -q;
                }
                let half = q.dot(before).min(1.0);
                if !(half > LEAST_PRODUCT) {
                    let turn = 2.0 * float::atan2(float::sqrt(1.0 - half * half), half);
                    return Err(Error::OutOfRange {
                        what: "turn between neighbouring attitudes",
                        value: turn,
                        expected: "at most 2.6 radians: give more attitudes",
                    });
                }
            }
            quaternions.push(q);
        }
        let table = Self {
            position_times,
            positions: positions.1.to_vec(),
            position_between: positions.2,
            attitude_times,
            turns: attitudes
                .1
                .windows(2)
                .map(|pair| RotationVector::from_rotation(&(pair[1] * pair[0].inverse())).vector())
                .collect(),
            attitudes: quaternions,
            attitude_between: attitudes.2,
        };
        let [first, last] = table.span();
        if !(last > first) {
            return Err(Error::OutOfRange {
                what: "time that positions and attitudes share",
                value: last - first,
                expected: "more than none",
            });
        }
        Ok(table)
    }

    fn place(&self, time: f64) -> Result<Place, ProjectionError> {
        match self.position_between {
            Interpolation::Linear => {
                let (i, share, step) = self.position_times.between(time)?;
                let (a, b) = (self.positions[i], self.positions[i + 1]);
                Ok(Place { node: a, way: (b - a) * share, velocity: (b - a) / step })
            }
            Interpolation::Lagrange(count) => {
                let window = self.position_times.lagrange(time)?;
                let nodes = &self.positions[window.first..window.first + count];
                let middle = nodes[count / 2];
                let (mut way, mut velocity) = (Vector3::zeros(), Vector3::zeros());
                for (j, node) in nodes.iter().enumerate() {
                    // The weights add up to one, their slopes to zero.
                    let away = node - middle;
                    way += away * window.weights[j];
                    velocity += away * window.slopes[j];
                }
                Ok(Place { node: middle, way, velocity })
            }
        }
    }

    fn attitude(&self, time: f64) -> Result<(Rotation3<f64>, Vector3<f64>), ProjectionError> {
        match self.attitude_between {
            Interpolation::Linear => {
                let (i, share, step) = self.attitude_times.between(time)?;
                let turn = self.turns[i];
                let moved = RotationVector::new(turn * share).rotation();
                Ok((moved * rotation(&self.attitudes[i])?, turn / step))
            }
            Interpolation::Lagrange(count) => {
                let window = self.attitude_times.lagrange(time)?;
                let nodes = &self.attitudes[window.first..window.first + count];
                let (mut q, mut slope) = (Vector4::zeros(), Vector4::zeros());
                for (j, node) in nodes.iter().enumerate() {
                    q += node * window.weights[j];
                    slope += node * window.slopes[j];
                }
                Ok((rotation(&q)?, angular_velocity(&q, &slope)))
            }
        }
    }
}

/// The vector part of 2 q̇ q⁻¹, whatever the length of q.
fn angular_velocity(q: &Vector4<f64>, slope: &Vector4<f64>) -> Vector3<f64> {
    let ([w, x, y, z], [a, b, c, d]) = ((*q).into(), (*slope).into());
    let (v, u): (Vector3<f64>, Vector3<f64>) = (Vector3::new(x, y, z), Vector3::new(b, c, d));
    let (w, a): (f64, f64) = (w, a);
    (u * w - v * a - u.cross(&v)) * (2.0 / q.norm_squared())
}

fn rotation(q: &Vector4<f64>) -> Result<Rotation3<f64>, ProjectionError> {
    let quaternion = Quaternion { w: q[0], x: q[1], y: q[2], z: q[3] };
    quaternion.rotation().map_err(|_| ProjectionError::NotFinite)
}

/// The times of a table of `len` values, enough of them for their interpolation.
fn nodes(
    what: &'static str,
    times: &[f64],
    len: usize,
    between: Interpolation,
) -> Result<Nodes, Error> {
    if times.len() != len {
        return Err(Error::LengthMismatch { what, left: times.len(), right: len });
    }
    let needed = match between {
        Interpolation::Linear => 2,
        Interpolation::Lagrange(count) => {
            if count < 2 || count % 2 != 0 || count > MOST_NODES {
                return Err(Error::OutOfRange {
                    what: "nodes of an interpolation",
                    value: count as f64,
                    expected: "an even number from 2 to 12",
                });
            }
            count
        }
    };
    Nodes::new(times, needed, what)
}

impl Trajectory for Ephemeris {
    fn span(&self) -> [f64; 2] {
        let ([a, b], [c, d]) = (self.position_times.span(), self.attitude_times.span());
        [a.max(c), b.min(d)]
    }

    fn state(&self, time: f64) -> Result<PlatformState, ProjectionError> {
        let Place { node, way, velocity } = self.place(time)?;
        let (center, center_rest) = trajectory::moved(&node, &way);
        let (camera_from_world, angular_velocity) = self.attitude(time)?;
        Ok(PlatformState { center, center_rest, camera_from_world, velocity, angular_velocity })
    }
}
