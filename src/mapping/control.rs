//! Pairs of control points, as every estimator of maps takes them.

use nalgebra::Point2;

use crate::error::Error;

/// Refuses pairs that are too few, of different number, or not finite.
pub(super) fn check(
    screen: &[Point2<f64>],
    texture: &[Point2<f64>],
    needed: usize,
) -> Result<(), Error> {
    if screen.len() != texture.len() {
        return Err(Error::LengthMismatch {
            what: "screen and texture points",
            left: screen.len(),
            right: texture.len(),
        });
    }
    if screen.len() < needed {
        return Err(Error::TooFewPoints { needed, got: screen.len() });
    }
    if !screen.iter().chain(texture).all(|p| p.x.is_finite() && p.y.is_finite()) {
        return Err(Error::NotFinite { what: "control point" });
    }
    Ok(())
}

/// The centre of the points' bounding rectangle.
pub(super) fn centre(points: &[Point2<f64>]) -> Point2<f64> {
    let (mut low, mut high) = (points[0], points[0]);
    for p in points {
        low = low.inf(p);
        high = high.sup(p);
    }
    Point2::from(low.coords * 0.5 + high.coords * 0.5)
}
