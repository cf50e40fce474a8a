//! What was observed besides image points: control points, positions and attitudes of photographs, distances, parameters.
//!
//! ```text
//! G = C + Rᵀ a                v = G − G observed       ∂v/∂C = I    ∂v/∂δ = Rᵀ [a]×
//! φ = log(R R observedᵀ)                               ∂φ/∂δ = J⁻¹(φ)
//! J⁻¹(φ) = I − ½ [φ]× + (1 − ½θ cot ½θ)/θ² [φ]×²,  θ = |φ|
//! ```
//! with δ the left rotation vector, J⁻¹ the inverse of the rotation group's left Jacobian (Bortz 1971).

use nalgebra::{Matrix3, Point3, SMatrix, Vector3};

use super::engine::Engine;
use super::normal::{Normal, add_symmetric};
use super::problem::{Attitude, Image, Kind, Position};
use super::state::State;
use super::width::Width;
use crate::camera::{Adjustable, CentralModel, ExteriorOrientation};

/// Three numbers observed of a photograph, for an exterior orientation.
#[derive(Clone, Copy, Debug)]
pub(super) struct OfImage {
    /// Computed less observed.
    pub(super) off: Vector3<f64>,
    /// By the centre and the left rotation vector.
    pub(super) partials: SMatrix<f64, 3, 6>,
    pub(super) weight: Matrix3<f64>,
}

impl Position {
    /// ∂(Rᵀa) = −Rᵀ (δ × a) = Rᵀ [a]× δ.
    pub(super) fn at(&self, exterior: &ExteriorOrientation) -> OfImage {
        let back = exterior.camera_from_world().inverse();
        let antenna: Point3<f64> = exterior.projection_center() + back * self.lever;
        let mut partials = SMatrix::<f64, 3, 6>::zeros();
        partials.fixed_view_mut::<3, 3>(0, 0).fill_with_identity();
        partials
            .fixed_view_mut::<3, 3>(0, 3)
            .copy_from(&(back.matrix() * self.lever.cross_matrix()));
        OfImage { off: antenna - self.given, partials, weight: self.weight }
    }
}

impl Attitude {
    pub(super) fn at(&self, exterior: &ExteriorOrientation) -> OfImage {
        let off = (exterior.camera_from_world() * self.given.inverse()).scaled_axis();
        let mut partials = SMatrix::<f64, 3, 6>::zeros();
        partials.fixed_view_mut::<3, 3>(0, 3).copy_from(&left_jacobian_inverse(&off));
        OfImage { off, partials, weight: self.weight }
    }
}

/// J⁻¹(φ): how the rotation vector of exp(δ) exp(φ) begins to grow with δ.
fn left_jacobian_inverse(phi: &Vector3<f64>) -> Matrix3<f64> {
    let (cross, squared) = (phi.cross_matrix(), phi.norm_squared());
    let half = 0.5 * squared.sqrt();
    // 1 − x cot x = x²/3 + x⁴/45 + …, x = θ/2; times φ² the rest is below rounding.
    let factor = if half < 1e-3 { 1.0 / 12.0 } else { (1.0 - half / half.tan()) / squared };
    Matrix3::identity() - cross * 0.5 + cross * cross * factor
}

impl Image {
    /// What was observed of the photograph; nothing of one that is held.
    pub(super) fn observed(
        &self,
        exterior: &ExteriorOrientation,
    ) -> impl Iterator<Item = OfImage> + use<> {
        let position = self.position.filter(|_| !self.held).map(|p| p.at(exterior));
        let attitude = self.attitude.filter(|_| !self.held).map(|a| a.at(exterior));
        position.into_iter().chain(attitude)
    }

    /// How many numbers were observed of it.
    pub(super) fn observed_numbers(&self) -> usize {
        let count = usize::from(self.position.is_some()) + usize::from(self.attitude.is_some());
        if self.held { 0 } else { 3 * count }
    }
}

impl<C: CentralModel + Adjustable + Clone, E: Width, K: Width> Engine<'_, C, E, K> {
    /// Half of the weighted squares of what was observed besides image points.
    pub(super) fn given_cost(&self, state: &State<C>) -> f64 {
        let bundle = self.bundle;
        let quadratic = |off: &Vector3<f64>, weight| 0.5 * off.dot(&(weight * off));
        let mut cost = 0.0;
        for (object, point) in bundle.points.iter().zip(&state.points) {
            if let Kind::Control { given, weight } = &object.kind {
                cost += quadratic(&(point - given), *weight);
            }
        }
        for (image, exterior) in bundle.images.iter().zip(&state.exteriors) {
            cost += image.observed(exterior).map(|o| quadratic(&o.off, o.weight)).sum::<f64>();
        }
        for distance in &bundle.distances {
            let [a, b] = distance.ends.map(|e| state.points[e as usize]);
            cost += 0.5 * distance.weight * ((a - b).norm() - distance.length).powi(2);
        }
        cost + self
            .observed_parameters(state)
            .iter()
            .map(|p| 0.5 * p.weight * p.off * p.off)
            .sum::<f64>()
    }

    /// Adds it to the normal equations; the parameters of cameras are added where those are gathered.
    pub(super) fn add_given(&self, state: &State<C>, normal: &mut Normal) {
        let (bundle, k) = (self.bundle, self.total.get());
        for (i, object) in bundle.points.iter().enumerate() {
            if let Kind::Control { given, weight } = &object.kind {
                add_symmetric(&mut normal.v[i], weight);
                let pull = weight * (state.points[i] - given);
                normal.point_gradient[i].iter_mut().zip(pull.iter()).for_each(|(g, p)| *g += p);
            }
        }
        for (i, (image, exterior)) in bundle.images.iter().zip(&state.exteriors).enumerate() {
            let u = &mut normal.u[i * k * k..][..k * k];
            let g = &mut normal.image_gradient[i * k..][..k];
            for OfImage { off, partials, weight } in image.observed(exterior) {
                let weighted = partials.transpose() * weight;
                let (square, pull) = (weighted * partials, weighted * off);
                for a in 0..6 {
                    for b in 0..6 {
                        u[a * k + b] += square[(a, b)];
                    }
                    g[a] += pull[a];
                }
            }
        }
        normal.tied.clear();
        for distance in &bundle.distances {
            let [a, b] = distance.ends.map(|e| e as usize);
            let apart = state.points[a] - state.points[b];
            let length = apart.norm();
            let along = if length > 0.0 { apart / length } else { Vector3::zeros() };
            let block = along * along.transpose() * distance.weight;
            let pull = along * ((length - distance.length) * distance.weight);
            add_symmetric(&mut normal.v[a], &block);
            add_symmetric(&mut normal.v[b], &block);
            for i in 0..3 {
                normal.point_gradient[a][i] += pull[i];
                normal.point_gradient[b][i] -= pull[i];
            }
            normal.tied.push(-block);
        }
    }
}
