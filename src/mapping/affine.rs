//! Affine maps as maps from a screen into a texture.

use core::ops::Range;

use nalgebra::{Matrix2, Point2};

use super::Map;
use super::footprint::{FootprintSink, ask};
use super::span::Span;
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

    fn footprints(&self, line: i32, samples: Range<i32>, emit: &mut FootprintSink<'_>) {
        let same = Some(self.linear);
        self.blocks(line, samples, &mut |x, u, v| ask(|_, _| same, line, [u, v], x, emit));
    }

    fn span(&self, line: i32, samples: Range<i32>) -> Option<(Span<2>, Range<i32>)> {
        let (a, b) = (&self.linear, &self.translation);
        let forms = [[b.x, a.m11, a.m12], [b.y, a.m21, a.m22]];
        let span = Span::on_line(forms, [1.0, 0.0, 0.0], line).ok()?;
        if !Span::<2>::reaches(&samples) {
            return None;
        }
        let valid = span.valid_interval(samples);
        Some((span, valid))
    }
}
