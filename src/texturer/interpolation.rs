//! Texture coordinates interpolated on the screen: what goes wrong without the division.
//!
//! \[WD\] figure 2 compares three ways of filling a polygon whose vertices know their texture coordinates: linearly over
//! triangles, bilinearly over a quadrilateral, and in perspective. The first two are here to be seen beside the third;
//! they fold along the triangles' common edge, bend straight lines, and swim when the eye moves.

use alloc::vec::Vec;

use nalgebra::{Matrix2, Point2};

use super::polygon::ScreenPolygon;
use crate::error::Error;
use crate::geometry::Affine2;
use crate::mapping::polynomial::{Bilinear, InverseBilinear};
use crate::mapping::{Composed, Map};

/// The texture coordinates of an outline's vertices, by the exact map.
fn at_vertices(polygon: &ScreenPolygon, exact: &dyn Map) -> Result<Vec<Point2<f64>>, Error> {
    polygon.vertices().iter().map(|v| exact.at(v).map_err(Error::from)).collect()
}

/// The polygon as triangles, each with the affine map through its three vertices (\[WD\] figure 2b).
///
/// # Errors
/// [`Error::Projection`] where a vertex has no place in the texture.
pub fn linear_triangles(
    polygon: &ScreenPolygon,
    exact: &dyn Map,
) -> Result<Vec<(ScreenPolygon, Affine2)>, Error> {
    let texture = at_vertices(polygon, exact)?;
    let mut triangles = Vec::new();
    for corners in polygon.triangles() {
        let (Some(piece), [Some(&a), Some(&b), Some(&c)]) =
            (polygon.piece(&corners), corners.map(|i| texture.get(i)))
        else {
            continue;
        };
        let [p, q, r] = [0, 1, 2].map(|i| piece.vertices()[i]);
        let sides = Matrix2::from_columns(&[q - p, r - p]);
        // A triangle without area covers no pixel.
        let Some(inverse) = sides.try_inverse() else { continue };
        let linear = Matrix2::from_columns(&[b - a, c - a]) * inverse;
        triangles.push((piece, Affine2 { linear, translation: a.coords - linear * p.coords }));
    }
    Ok(triangles)
}

/// The bilinear map of a quadrilateral, texture from screen (\[WD\] figure 2c): the inverse of the bilinear map from the
/// unit square to the screen, which is a quadratic, followed by the one from the unit square to the texture.
///
/// # Errors
/// [`Error::LengthMismatch`] for an outline that has not four vertices on the screen, [`Error::Projection`] where a vertex
/// has no place in the texture, [`Error::Degenerate`] and [`Error::FoldedQuad`] for an outline without area or folded.
pub fn bilinear_quad(
    polygon: &ScreenPolygon,
    exact: &dyn Map,
) -> Result<Composed<Bilinear, InverseBilinear>, Error> {
    let texture = at_vertices(polygon, exact)?;
    let (&[a, b, c, d], &[p, q, r, s]) = (polygon.vertices(), &texture[..]) else {
        return Err(Error::LengthMismatch {
            what: "vertices of a bilinear quadrilateral and four",
            left: texture.len(),
            right: 4,
        });
    };
    let inner = Bilinear::from_quad(&[a, b, c, d])?.inverted();
    // Bilinear in the unit square: (0,0) → p, (1,0) → q, (1,1) → r, (0,1) → s, with table 2's terms 1, X, Y, XY.
    let terms = |f: fn(&Point2<f64>) -> f64| {
        let [p, q, r, s] = [f(&p), f(&q), f(&r), f(&s)];
        [p, q - p, s - p, (p - q) + (r - s)]
    };
    let outer = Bilinear::from_coefficients(terms(|t| t.x), terms(|t| t.y))?;
    Ok(Composed { outer, inner })
}
