//! Affine maps as maps from a screen into a texture.

use nalgebra::{Matrix2, Point2};

use super::Map;
use crate::error::ProjectionError;
use crate::geometry::Affine2;

/// Table 2's first row as a map; defined everywhere.
impl Map for Affine2 {
    fn at(&self, screen: &Point2<f64>) -> Result<Point2<f64>, ProjectionError> {
        let p = self.apply(screen);
        if p.x.is_finite() && p.y.is_finite() { Ok(p) } else { Err(ProjectionError::NotFinite) }
    }

    fn jacobian(&self, screen: &Point2<f64>) -> Result<Matrix2<f64>, ProjectionError> {
        self.at(screen).map(|_| self.linear)
    }
}
