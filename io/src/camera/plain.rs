//! The plainest form of a camera, by which writers tell whether their program has it.

use super::{FisheyeProjection, Interior, Lens};
use crate::colmap::models;

impl Interior {
    /// The same camera as one of the models with names of their own, where it is one of COLMAP's and there is one; and a lens as the
    /// plainest that images the same: terms that are zero are no reason to refuse a camera.
    pub(crate) fn plain(&self, size: [u32; 2]) -> Self {
        let named = match self {
            Self::Colmap { model, parameters } => models::named(model, parameters, size),
            _ => None,
        };
        named.unwrap_or_else(|| self.clone()).without_zeros()
    }

    /// Without terms that are zero.
    fn without_zeros(self) -> Self {
        let plainer = match self {
            Self::Lens { principal_distance, principal_point, skew, lens } => {
                let brown = |k, p| Self::Brown { principal_distance, principal_point, skew, k, p };
                let with = |lens| Self::Lens {
                    principal_distance,
                    principal_point,
                    skew,
                    lens: Box::new(lens),
                };
                let fisheye =
                    |k| with(Lens::Fisheye { projection: FisheyeProjection::Equidistant, k });
                match *lens {
                    // p₁ and p₂ have each other's places.
                    Lens::Metashape { k: [k1, k2, k3, 0.0], p: [p1, p2, 0.0, 0.0] } => {
                        brown([k1, k2, k3], [p2, p1])
                    }
                    Lens::Rational { k: [k1, k2, k3, 0.0, 0.0, 0.0], p, s, tau }
                        if s == [0.0; 4] && tau == [0.0; 2] =>
                    {
                        brown([k1, k2, k3], p)
                    }
                    Lens::ThinPrismFisheye { k, p: [0.0, 0.0], s: [0.0, 0.0] } => fisheye(k),
                    Lens::Fisheye624 { k: [k0, k1, k2, k3, 0.0, 0.0], p: [0.0, 0.0], s }
                        if s == [0.0; 4] =>
                    {
                        fisheye([k0, k1, k2, k3])
                    }
                    other => with(other),
                }
            }
            other => other,
        };
        match plainer {
            Self::Brown { principal_distance, principal_point, skew, k, p }
                if k == [0.0; 3] && p == [0.0; 2] =>
            {
                Self::Pinhole { principal_distance, principal_point, skew }
            }
            other => other,
        }
    }
}
