//! One pair of image points, and its smallest correction that lets the rays meet.

use nalgebra::{
    Matrix2, Matrix2x3, Matrix3x2, Matrix4, Point2, Rotation3, SVector, Vector2, Vector3, Vector4,
};

use super::ImagePair;
use crate::adjust::five_point::{coplanarity, tangents};
use crate::camera::CentralModel;
use crate::error::Error;

/// A measured pair.
#[derive(Clone)]
pub(super) struct Sight {
    images: [Point2<f64>; 2],
    covariances: [Matrix2<f64>; 2],
    /// The directions of the measured points.
    pub(super) directions: [Vector3<f64>; 2],
    /// ∂ direction / ∂ image at the measured points.
    slopes: [Matrix3x2<f64>; 2],
}

/// A pair corrected for one motion.
pub(super) struct Settled {
    /// v: measured minus corrected, in pixels.
    pub(super) corrections: Vector4<f64>,
    /// c = B v, with the slopes B of the triple product by the four image coordinates.
    pub(super) misclosure: f64,
    /// m = B Σ Bᵀ.
    pub(super) variance: f64,
    /// Σ Bᵀ.
    pub(super) gain: Vector4<f64>,
    /// The slopes of the triple product by the five parameters.
    pub(super) row: SVector<f64, 5>,
    /// The corrected directions.
    pub(super) directions: [Vector3<f64>; 2],
}

impl Settled {
    /// vᵀPv = c²/m.
    pub(super) fn squared(&self) -> f64 {
        self.misclosure * self.misclosure / self.variance
    }
}

/// A direction with its slopes by the image: the image does not change along the direction, so they are across it, and the
/// pseudo-inverse of the image's slopes.
fn direction(
    camera: &dyn CentralModel,
    image: &Point2<f64>,
) -> Result<(Vector3<f64>, Matrix3x2<f64>), Error> {
    let direction = camera.direction(image)?;
    let (_, by_direction) = camera.project_direction_jacobian(&direction)?;
    let gram: Matrix2<f64> = by_direction * by_direction.transpose();
    let what = "slopes of a camera";
    let inverse = gram.try_inverse().ok_or(Error::NotFinite { what })?;
    let by_direction: Matrix2x3<f64> = by_direction;
    Ok((direction, by_direction.transpose() * inverse))
}

impl Sight {
    pub(super) fn new(
        first: &dyn CentralModel,
        second: &dyn CentralModel,
        pair: &ImagePair,
    ) -> Result<Self, Error> {
        let finite = |p: &Point2<f64>| p.x.is_finite() && p.y.is_finite();
        if !(finite(&pair.first) && finite(&pair.second)) {
            return Err(Error::NotFinite { what: "image pair" });
        }
        let [p1, p2] = pair.precisions;
        let (d1, s1) = direction(first, &pair.first)?;
        let (d2, s2) = direction(second, &pair.second)?;
        Ok(Self {
            images: [pair.first, pair.second],
            covariances: [p1.covariance()?, p2.covariance()?],
            directions: [d1, d2],
            slopes: [s1, s2],
        })
    }

    /// Σ of the four coordinates.
    pub(super) fn covariance(&self) -> Matrix4<f64> {
        let mut all = Matrix4::zeros();
        all.fixed_view_mut::<2, 2>(0, 0).copy_from(&self.covariances[0]);
        all.fixed_view_mut::<2, 2>(2, 2).copy_from(&self.covariances[1]);
        all
    }

    /// The triple product and the parts of its slopes B by the image coordinates of either picture.
    fn slopes(
        rotation: &Rotation3<f64>,
        base: &Vector3<f64>,
        directions: &[Vector3<f64>; 2],
        slopes: &[Matrix3x2<f64>; 2],
    ) -> (f64, [Vector2<f64>; 2]) {
        let other = rotation.inverse() * directions[1];
        let plane = base.cross(&directions[0]);
        let by_first = slopes[0].tr_mul(&other.cross(base));
        let by_second = slopes[1].tr_mul(&(rotation * plane));
        (plane.dot(&other), [by_first, by_second])
    }

    /// vᵀPv after one linear step.
    pub(super) fn sampson(&self, rotation: &Rotation3<f64>, base: &Vector3<f64>) -> f64 {
        let (value, by) = Self::slopes(rotation, base, &self.directions, &self.slopes);
        let variance =
            by[0].dot(&(self.covariances[0] * by[0])) + by[1].dot(&(self.covariances[1] * by[1]));
        // Both rays along the base: any motion that keeps them there agrees.
        if variance > 0.0 { value * value / variance } else { 0.0 }
    }

    /// The correction to rounding; `None` where it leaves a camera's domain.
    pub(super) fn settle(
        &self,
        cameras: &[&dyn CentralModel; 2],
        rotation: &Rotation3<f64>,
        base: &Vector3<f64>,
    ) -> Option<Settled> {
        let (mut directions, mut slopes) = (self.directions, self.slopes);
        let mut corrections = Vector4::zeros();
        // What rounding leaves of an image coordinate.
        let largest = self.images[0].coords.amax().max(self.images[1].coords.amax());
        let floor = 4.0 * f64::EPSILON * largest;
        for round in 0.. {
            let (value, by) = Self::slopes(rotation, base, &directions, &slopes);
            let gains = [self.covariances[0] * by[0], self.covariances[1] * by[1]];
            let variance = by[0].dot(&gains[0]) + by[1].dot(&gains[1]);
            if !(variance > 0.0) {
                return None;
            }
            let gain = Vector4::new(gains[0].x, gains[0].y, gains[1].x, gains[1].y);
            let all = Vector4::new(by[0].x, by[0].y, by[1].x, by[1].y);
            let misclosure = value + all.dot(&corrections);
            let next = gain * (misclosure / variance);
            let change = (next - corrections).amax();
            corrections = next;
            if change <= floor || round == ROUNDS {
                let across = tangents(base);
                let (_, row) = coplanarity(rotation, base, &across, &directions[0], &directions[1]);
                return Some(Settled { corrections, misclosure, variance, gain, row, directions });
            }
            for side in 0..2 {
                let shift = Vector2::new(corrections[2 * side], corrections[2 * side + 1]);
                let image = self.images[side] - shift;
                (directions[side], slopes[side]) = direction(cameras[side], &image).ok()?;
            }
        }
        None
    }
}

/// Corrections of a pair that are no small part of its distance from the base need more.
const ROUNDS: u32 = 20;
