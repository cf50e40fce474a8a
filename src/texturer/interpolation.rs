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
/// *Accuracy.* Exact at the vertices. Elsewhere it is off by whole texels, the more the depth varies over the polygon; the
/// maps of neighbouring triangles agree along their common edge and fold there.
///
/// # Errors
/// [`Error::Projection`] where a vertex has no place in the texture.
///
/// # Example
/// A floor one below the eye, from depth 1 (v = 0, line 100) to depth 3 (v = 32, line 33⅓). Line 50 shows it half way, at
/// v = 16; on the screen it is three quarters of the way, where both wrong maps have v = 24.
///
/// ```
/// use collinear::camera::{ExteriorOrientation, Frame, InteriorOrientation};
/// use nalgebra::{Point2, Point3, Rotation3, Vector3};
///
/// let eye = ExteriorOrientation::new(Point3::origin(), Rotation3::identity());
/// let interior = InteriorOrientation::new([100.0; 2], Point2::origin(), 0.0)?;
/// let screen = Frame::new(eye, interior).homogeneous();
/// let floor = [(-1.0, 1.0), (1.0, 1.0), (1.0, 3.0), (-1.0, 3.0)].map(|(x, z)| Point3::new(x, 1.0, z));
/// let corners = [(0.0, 0.0), (64.0, 0.0), (64.0, 32.0), (0.0, 32.0)];
/// let coordinates = corners.map(|(u, v)| Vector3::new(u, v, 1.0));
/// use collinear::mapping::Map;
/// use collinear::texturer::{ScreenPolygon, bilinear_quad, from_vertices, linear_triangles};
///
/// let exact = from_vertices(&floor, &coordinates, &screen)?;
/// let polygon = ScreenPolygon::project(&floor, &screen, 0.1)?;
/// let middle = Point2::new(0.0, 50.0);
/// for (_, map) in linear_triangles(&polygon, &exact)? {
///     assert!((map.at(&middle)?.y - 24.0).abs() < 1e-12);
/// }
/// assert!((bilinear_quad(&polygon, &exact)?.at(&middle)?.y - 24.0).abs() < 1e-12);
/// assert!((exact.at(&middle)?.y - 16.0).abs() < 1e-12);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
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
/// *Accuracy.* Exact at the corners and, for affine coordinates, continuous along edges; lines that are not parallel to
/// the texture's axes come out curved. [`linear_triangles`] has an example of both.
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
