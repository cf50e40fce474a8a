//! Least-squares fits of table 2's polynomials.

use alloc::vec::Vec;

use nalgebra::{Point2, Vector2};

use super::{EXPONENTS, Polynomial, Rectangle, powers};
use crate::error::Error;
use crate::numeric::least_squares::unit_weight;
use crate::numeric::triangular::Triangular;

/// A polynomial map fitted to control points, with what is left.
#[derive(Clone, Debug, PartialEq)]
pub struct PolynomialFit<M> {
    /// The map, image from object.
    pub map: M,
    /// Image point minus mapped object point, for each pair.
    pub residuals: Vec<Vector2<f64>>,
    /// √(Σ‖v‖² / (2n − 2·terms)), the standard deviation of one image coordinate; `None` without redundancy.
    pub sigma0: Option<f64>,
    /// The ratio of the largest to the smallest singular value of the design matrix in normalised coordinates: how much
    /// an error of the image points can grow in the coefficients.
    pub condition: f64,
}

/// Smallest over largest singular value, at or below which points do not determine the terms.
const DEGENERATE: f64 = 1e-12;

/// The rectangle that bounds the points.
fn bounds(points: &[Point2<f64>]) -> Rectangle {
    let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
    for p in points {
        for (i, c) in [p.x, p.y].into_iter().enumerate() {
            low[i] = low[i].min(c);
            high[i] = high[i].max(c);
        }
    }
    Rectangle {
        centre: core::array::from_fn(|i| 0.5 * low[i] + 0.5 * high[i]),
        half: core::array::from_fn(|i| 0.5 * high[i] - 0.5 * low[i]),
    }
}

/// The fit with N terms; M is N + 1.
pub(super) fn fit<const N: usize, const M: usize, P>(
    object: &[Point2<f64>],
    image: &[Point2<f64>],
    wrap: impl FnOnce(Polynomial<N>) -> P,
) -> Result<PolynomialFit<P>, Error> {
    let n = object.len();
    if n != image.len() {
        return Err(Error::LengthMismatch {
            what: "object and image points",
            left: n,
            right: image.len(),
        });
    }
    if n < N {
        return Err(Error::TooFewPoints { needed: N, got: n });
    }
    if !object.iter().chain(image).all(|p| p.x.is_finite() && p.y.is_finite()) {
        return Err(Error::NotFinite { what: "polynomial control point" });
    }
    let frame = bounds(object);
    let offset = bounds(image).centre;
    let degenerate =
        |measure| Error::Degenerate { what: "polynomial fit", measure, limit: DEGENERATE };
    if !(frame.half[0] > 0.0 && frame.half[1] > 0.0) {
        return Err(degenerate(0.0));
    }
    let mut design = Triangular::<N>::new();
    let mut systems = [Triangular::<M>::new(), Triangular::<M>::new()];
    for (o, i) in object.iter().zip(image) {
        let [x, y] = frame.normalise([o.x, o.y]);
        let (px, py) = (powers(x), powers(y));
        let basis: [f64; N] = core::array::from_fn(|k| {
            let (i, j) = EXPONENTS[k];
            px[i] * py[j]
        });
        design.add_row(basis);
        for (system, value) in systems.iter_mut().zip([i.x - offset[0], i.y - offset[1]]) {
            let row: [f64; M] = core::array::from_fn(|k| basis.get(k).copied().unwrap_or(value));
            system.add_row(row);
        }
    }
    let (singular, _) = design.singular();
    let ratio = singular[N - 1] / singular[0];
    if !(ratio > DEGENERATE) {
        return Err(degenerate(if ratio.is_finite() { ratio } else { 0.0 }));
    }
    let mut coefficients = [[0.0; N]; 2];
    for (c, system) in coefficients.iter_mut().zip(&systems) {
        let solution = system.solve(0.0).ok_or_else(|| degenerate(ratio))?;
        c.copy_from_slice(&solution[..N]);
    }
    let [a, b] = coefficients;
    let polynomial = Polynomial { frame, offset, a, b, domain: frame };
    // Residuals relative to the offset, where they are exact.
    let residuals: Vec<Vector2<f64>> = object
        .iter()
        .zip(image)
        .map(|(o, i)| {
            let [x, y] = frame.normalise([o.x, o.y]);
            let [u, v] = polynomial.value(x, y);
            Vector2::new((i.x - offset[0]) - u, (i.y - offset[1]) - v)
        })
        .collect();
    let sum: f64 = residuals.iter().map(|r| r.norm_squared()).sum();
    if !sum.is_finite() {
        return Err(Error::NotFinite { what: "residual of a polynomial fit" });
    }
    let redundancy = 2 * (n - N);
    let sigma0 = unit_weight(sum, redundancy);
    Ok(PolynomialFit { map: wrap(polynomial), residuals, sigma0, condition: 1.0 / ratio })
}
