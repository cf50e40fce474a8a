//! The eight numbers: a plane of the world, seen by a texture camera and by a screen.

use core::ops::Range;

use nalgebra::{
    Matrix2, Matrix3, Matrix3x4, Matrix4x3, Point2, Point3, RowVector3, Vector3, Vector4,
};

use super::footprint::ask;
use super::span::{BLOCK, Span};
use super::{FootprintBlock, FootprintSink, Map};
use crate::camera::HomogeneousCamera;
use crate::error::{Error, ProjectionError};
use crate::geometry::{Homography, Plane};
use crate::numeric::scalar::Scalar;
use crate::numeric::vectorised;

/// A fractional-linear map from screen to texture, with its two conditions of validity.
///
/// # Model
/// ```text
/// u = (P₀ + P₁S + P₂L) / (R₀ + R₁S + R₂L)
/// v = (Q₀ + Q₁S + Q₂L) / (R₀ + R₁S + R₂L)                                        [WD] eq. 1
/// ```
/// (S, L) are sample and line on the screen, (u, v) in the texture, both in pixels. The nine numbers have eight degrees of
/// freedom; R₀ is not assumed to be one, for it vanishes whenever the screen's origin lies on the texture camera's focal
/// plane, as with a level camera over a floor.
///
/// # Domain
/// Two signs, not one. A pixel is textured where its ray meets the plane before the eye, E₀ + E₁S + E₂L > 0, and where the
/// point it meets lies before the texture camera, R₀ + R₁S + R₂L > 0. E is a fourth linear form; its zero is the plane's
/// horizon. R's zero is the texture camera's focal plane. With both cameras at one place the map is the identity and R
/// never changes sign, so R alone cannot know the horizon.
///
/// # Accuracy
/// Each linear form is evaluated as R₁S + (R₂L + R₀) in `f64`; u and v are the numerators times one reciprocal. Rows are
/// [spans](crate::mapping::span::Span), whose forms do not cancel.
///
/// # Example
/// A photograph taken straight down from 100 m (f = 1000 px) textures the ground z = 0; an eye 10 m above it looks level
/// to the north. The screen pixel 100 rows below the horizon shows the ground 1000 · 10 / 100 = 100 m ahead, which is
/// 1000 px from the photograph's centre. By hand, from similar triangles:
///
/// ```
/// use collinear::camera::{ExteriorOrientation, Frame, InteriorOrientation};
/// use collinear::geometry::Plane;
/// use collinear::mapping::{FractionalLinear, Map};
/// use nalgebra::{Point2, Point3, Vector3};
///
/// let camera = InteriorOrientation::new([1000.0, 1000.0], Point2::new(500.0, 400.0), 0.0)?;
/// let above = ExteriorOrientation::look_at(Point3::new(0.0, 0.0, 100.0), Point3::origin(), Vector3::y())?;
/// let level = ExteriorOrientation::look_at(Point3::new(0.0, 0.0, 10.0), Point3::new(0.0, 1.0, 10.0), Vector3::z())?;
/// let ground = Plane::from_point_and_normal(Point3::origin(), Vector3::z())?;
/// let map = FractionalLinear::from_plane(
///     &ground,
///     &Frame::new(above, camera).homogeneous(),
///     &Frame::new(level, camera).homogeneous(),
/// )?;
/// let p = map.at(&Point2::new(500.0, 500.0))?;
/// assert!((p - Point2::new(500.0, 400.0 - 1000.0)).norm() < 1e-10);
/// // Above the horizon there is no ground.
/// assert!(map.at(&Point2::new(500.0, 399.0)).is_err());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[doc(alias("plane-induced homography", "projective texture", "texgen"))]
pub struct FractionalLinear {
    /// Rows P, Q, R over (S, L, 1).
    matrix: Matrix3<f64>,
    /// E over (S, L, 1).
    eye: RowVector3<f64>,
}

/// A ratio below which a plane counts as passing through a camera: the distance of the projection centre from the plane
/// against its distance from the plane's anchor point.
const GRAZING: f64 = 1e-13;

/// a S + (b L + c), the one order in which every linear form of the module is evaluated.
#[inline]
fn linear<S: Scalar>(form: [S; 3], sample: S, line: S) -> S {
    form[0] * sample + (form[1] * line + form[2])
}

impl FractionalLinear {
    /// The map that a plane and two cameras share, in closed form from the cameras' parameters.
    ///
    /// With the screen's line of sight B σ + μ c through the pixel σ = (S, L, 1), and the plane π = (n, n·(O − P)) about
    /// the screen's origin O, the point met is
    ///
    /// ```text
    /// X̃ = B σ − c (π·B σ)/(π·c),          H = M_t T(O − O_t) (B − c πᵀB/(π·c))
    /// ```
    ///
    /// homogeneous, with its fourth component E·σ. For a perspective screen E·σ is the inverse depth 1/Z of the point; for
    /// a parallel one it is 1. H is the product of \[WD\]'s two transformations (texture from object, object from screen;
    /// after Devich & Weinhaus 1980), derived here from eq. 4a and 4b.
    ///
    /// # Errors
    /// [`Error::Degenerate`] where the plane passes through the eye or through the texture camera, or is seen edge on by a
    /// parallel projection; the measure is the distance of the centre from the plane (for a parallel projection the sine
    /// of the grazing angle).
    pub fn from_plane(
        plane: &Plane,
        texture: &HomogeneousCamera,
        screen: &HomogeneousCamera,
    ) -> Result<Self, Error> {
        clear_of(plane, texture, "plane through the texture camera")?;
        // The texture camera's frame has another origin: X − O_t = (X − O) + (O − O_t).
        let shift = screen.origin - texture.origin;
        let mut about_screen = texture.image_from_world;
        let moved = texture.image_from_world * shift.push(1.0);
        about_screen.set_column(3, &moved);
        Self::from_plane_texture(plane, &about_screen, screen)
    }

    /// The map of a plane whose texture is any linear function of the world: (w u, w v, w) from (X − O, 1), O the screen's
    /// origin. A camera is one such function, coordinates laid on the plane are another.
    ///
    /// # Errors
    /// [`Error::Degenerate`] where the plane passes through the eye, [`Error::NotFinite`].
    pub fn from_plane_texture(
        plane: &Plane,
        texture_from_world: &Matrix3x4<f64>,
        screen: &HomogeneousCamera,
    ) -> Result<Self, Error> {
        let world = world_from_screen(plane, screen)?;
        Self::from_forms(texture_from_world * world, world.row(3).into_owned())
    }

    /// The map through four points of a plane, projected into both cameras (\[WD\] after eq. 2: four pairs determine the
    /// eight unknowns).
    ///
    /// # Errors
    /// [`Error::Projection`] where a point lies behind a camera, [`Error::Degenerate`] and [`Error::FoldedQuad`] where
    /// the projected points are no quadrilateral.
    pub fn from_four_points(
        world: &[Point3<f64>; 4],
        texture: &HomogeneousCamera,
        screen: &HomogeneousCamera,
    ) -> Result<Self, Error> {
        let mut from = [Point2::origin(); 4];
        let mut to = [Point2::origin(); 4];
        for ((w, f), t) in world.iter().zip(&mut from).zip(&mut to) {
            *f = screen.project_offset(&(w - screen.origin))?.0;
            *t = texture.project_offset(&(w - texture.origin))?.0;
        }
        let plane = Plane::fit(world)?.plane;
        let eye = world_from_screen(&plane, screen)?.row(3).into_owned();
        Self::from_forms(*Homography::from_quads(&from, &to)?.matrix(), eye)
    }

    /// The map of a triangle from three pairs of homogeneous points, \[WD\] eq. 3: M = T S⁻¹.
    ///
    /// `texture[i]` is (w u, w v, w), with w = 1 where the texture is laid on by coordinates or orthogonally and w its
    /// camera's depth where it is projected; `screen[i]` is (W S, W L, W), W the depth. Nine numbers are determined, R₀
    /// among them. The numerators are then \[S\]'s xˡ/w, yˡ/w and the denominator wˡ/w (eq. 7); E is 1/W.
    ///
    /// # Errors
    /// [`Error::NotFinite`]; [`Error::OutOfRange`] for a W that is not positive (clip first); [`Error::Degenerate`] where
    /// the triangle is seen edge on, the measure being the determinant over the product of the columns' lengths.
    pub fn from_triangle(
        texture: &[Vector3<f64>; 3],
        screen: &[Vector3<f64>; 3],
    ) -> Result<Self, Error> {
        if let Some(s) = screen.iter().find(|s| !(s.z > 0.0)) {
            return Err(Error::OutOfRange {
                what: "W of a triangle's vertex",
                value: s.z,
                expected: "more than 0",
            });
        }
        let s = Matrix3::from_columns(screen);
        let lengths: f64 = screen.iter().map(Vector3::norm).product();
        let measure = s.determinant().abs() / lengths;
        let limit = 1e-14;
        let inverse = match s.try_inverse() {
            Some(inverse) if measure > limit => inverse,
            _ => {
                let measure = if measure.is_finite() { measure } else { 0.0 };
                return Err(Error::Degenerate { what: "triangle seen edge on", measure, limit });
            }
        };
        Self::from_forms(Matrix3::from_columns(texture) * inverse, inverse.row_sum())
    }

    /// The map of a triangle through its vertices and its centroid (\[WD\], before eq. 3). The centroid is that of the
    /// triangle in space, projected; the centroid of the projected vertices is another point.
    ///
    /// # Errors
    /// As [`from_four_points`](Self::from_four_points).
    pub fn from_triangle_and_centroid(
        world: &[Point3<f64>; 3],
        texture: &HomogeneousCamera,
        screen: &HomogeneousCamera,
    ) -> Result<Self, Error> {
        let [a, b, c] = world;
        // From a vertex: the sum of map coordinates would lose the digits that their differences keep.
        let centroid_from_a = ((b - a) + (c - a)) / 3.0;
        let plane = Plane::through(a, b, c)?;
        let eye = world_from_screen(&plane, screen)?.row(3).into_owned();
        // Three vertices and an inner point are no convex quadrilateral; their homogeneous form needs none:
        // columns scaled so that they sum to the fourth point, on both sides.
        let basis = |camera: &HomogeneousCamera| -> Result<Matrix3<f64>, Error> {
            let columns = [a, b, c].map(|p| camera.project_offset(&(p - camera.origin)));
            let mut matrix = Matrix3::zeros();
            for (i, column) in columns.into_iter().enumerate() {
                let (p, _) = column?;
                matrix.set_column(i, &Vector3::new(p.x, p.y, 1.0));
            }
            let (middle, _) = camera.project_offset(&(a - camera.origin + centroid_from_a))?;
            let edge_on =
                Error::Degenerate { what: "triangle seen edge on", measure: 0.0, limit: 0.0 };
            let weights =
                matrix.lu().solve(&Vector3::new(middle.x, middle.y, 1.0)).ok_or(edge_on)?;
            Ok(matrix * Matrix3::from_diagonal(&weights))
        };
        let (from, to) = (basis(screen)?, basis(texture)?);
        let edge_on = Error::Degenerate { what: "triangle seen edge on", measure: 0.0, limit: 0.0 };
        Self::from_forms(to * from.try_inverse().ok_or(edge_on)?, eye)
    }

    /// The map of a plane homography, valid where its denominator is positive.
    #[must_use]
    pub fn from_homography(texture_from_screen: &Homography) -> Self {
        Self { matrix: *texture_from_screen.matrix(), eye: RowVector3::new(0.0, 0.0, 1.0) }
    }

    /// From \[WD\]'s coefficients (P₀, P₁, P₂), (Q₀, Q₁, Q₂), (R₀, R₁, R₂) and the eye's form (E₀, E₁, E₂).
    ///
    /// # Errors
    /// [`Error::NotFinite`].
    pub fn from_coefficients(
        p: [f64; 3],
        q: [f64; 3],
        r: [f64; 3],
        e: [f64; 3],
    ) -> Result<Self, Error> {
        let row = |c: [f64; 3]| RowVector3::new(c[1], c[2], c[0]);
        Self::from_forms(Matrix3::from_rows(&[row(p), row(q), row(r)]), row(e))
    }

    fn from_forms(matrix: Matrix3<f64>, eye: RowVector3<f64>) -> Result<Self, Error> {
        if matrix.iter().chain(eye.iter()).all(|c| c.is_finite()) {
            Ok(Self { matrix, eye })
        } else {
            Err(Error::NotFinite { what: "fractional-linear coefficient" })
        }
    }

    /// (P₀, P₁, P₂), (Q₀, Q₁, Q₂), (R₀, R₁, R₂) of \[WD\] eq. 1.
    #[must_use]
    pub fn coefficients(&self) -> [[f64; 3]; 3] {
        [0, 1, 2].map(|i| {
            let r = self.matrix.row(i);
            [r[2], r[0], r[1]]
        })
    }

    /// (E₀, E₁, E₂), positive where the ray meets the plane before the eye: the inverse depth for a map that was made
    /// from a plane and a perspective screen.
    #[must_use]
    pub fn eye_coefficients(&self) -> [f64; 3] {
        [self.eye[2], self.eye[0], self.eye[1]]
    }

    /// The homography texture_from_screen, without the eye's condition.
    ///
    /// # Errors
    /// As [`Homography::from_matrix`].
    pub fn homography(&self) -> Result<Homography, Error> {
        Homography::from_matrix(self.matrix)
    }

    /// Whether the denominator is constant: both projections parallel, or the plane parallel to both image planes.
    #[must_use]
    pub fn is_affine(&self) -> bool {
        self.matrix.m31 == 0.0 && self.matrix.m32 == 0.0
    }

    /// (denominator, E) at a screen point.
    #[inline]
    fn signs(&self, sample: f64, line: f64) -> (f64, f64) {
        let m = &self.matrix;
        (
            linear([m.m31, m.m32, m.m33], sample, line),
            linear([self.eye[0], self.eye[1], self.eye[2]], sample, line),
        )
    }

    fn checked(&self, screen: &Point2<f64>) -> Result<f64, ProjectionError> {
        let (w, eye) = self.signs(screen.x, screen.y);
        if w > 0.0 && eye > 0.0 {
            return Ok(w);
        }
        Err(if w.is_nan() || eye.is_nan() {
            ProjectionError::NotFinite
        } else if eye <= 0.0 {
            ProjectionError::BeyondHorizon { w: eye }
        } else {
            ProjectionError::BehindCamera { depth: w / eye }
        })
    }

    /// The pixels of a row whose centres satisfy both conditions: one interval, since both are linear. The signs are
    /// exact; [`at`](Map::at) decides by rounded ones, which differ only where a condition is zero to rounding.
    #[must_use]
    pub fn valid_samples(&self, line: i32, samples: Range<i32>) -> Range<i32> {
        let [_, _, r] = self.coefficients();
        [r, self.eye_coefficients()].into_iter().fold(samples, |range, form| {
            let empty = range.start..range.start;
            let span = Span::<0>::on_line([], to_unit_magnitude(form), line);
            span.map_or(empty, |span| span.valid_interval(range))
        })
    }
}

impl HomogeneousCamera {
    /// How near a plane is at each pixel, as a linear function of the screen: (N₀, N₁, N₂) of N₀ + N₁S + N₂L, larger for
    /// nearer points.
    ///
    /// For a perspective camera it is the inverse depth 1/Z (\[WD\] after Fuchs et al. 1985), zero on the plane's horizon and
    /// negative beyond. For a parallel one, which has no such depth, it is −Z′.
    ///
    /// # Errors
    /// [`Error::Degenerate`] where the plane passes through the eye.
    pub fn nearness(&self, plane: &Plane) -> Result<[f64; 3], Error> {
        let world = world_from_screen(plane, self)?;
        let row = if self.is_parallel() {
            -(self.center.xyz().transpose() * world.fixed_view::<3, 3>(0, 0))
        } else {
            world.row(3).into_owned()
        };
        Ok([row[2], row[0], row[1]])
    }
}

/// A form scaled by the power of two that brings its largest coefficient to [1, 2). What is then below 10⁻²⁴⁰ decides no
/// sign, and a span does not take it.
fn to_unit_magnitude(form: [f64; 3]) -> [f64; 3] {
    let largest = form.iter().fold(0.0, |m: f64, c| m.max(c.abs()));
    let power = f64::from_bits(largest.to_bits() & f64::INFINITY.to_bits()).max(f64::MIN_POSITIVE);
    form.map(|c| c / power).map(|c| if c.abs() < 1e-240 { 0.0 } else { c })
}

/// π about a camera's origin: (n, n·(O − P)).
fn plane_about(plane: &Plane, camera: &HomogeneousCamera) -> Vector4<f64> {
    plane.normal().into_inner().push(plane.signed_distance(&camera.origin))
}

/// π·c, refused where the plane passes through the camera.
fn clear_of(plane: &Plane, camera: &HomogeneousCamera, what: &'static str) -> Result<f64, Error> {
    let clearance = plane_about(plane, camera).dot(&camera.center);
    // For a parallel projection the clearance is a sine, to be judged against one.
    let scale = if camera.is_parallel() { 1.0 } else { (camera.origin - plane.point()).norm() };
    let limit = GRAZING * scale;
    if clearance.abs() > limit {
        Ok(clearance)
    } else {
        Err(Error::Degenerate { what, measure: clearance.abs(), limit })
    }
}

/// (X − O, 1) of the plane's point at a pixel, homogeneous, as a matrix on (S, L, 1). The fourth row is the inverse depth
/// for a perspective screen and 1 for a parallel one.
fn world_from_screen(plane: &Plane, screen: &HomogeneousCamera) -> Result<Matrix4x3<f64>, Error> {
    let clearance = clear_of(plane, screen, "plane through the eye")?;
    let pi = plane_about(plane, screen);
    Ok(screen.back_projection
        - screen.center * (pi.transpose() * screen.back_projection) / clearance)
}

impl Map for FractionalLinear {
    #[inline]
    fn at(&self, screen: &Point2<f64>) -> Result<Point2<f64>, ProjectionError> {
        let inverse = 1.0 / self.checked(screen)?;
        let m = &self.matrix;
        let u = linear([m.m11, m.m12, m.m13], screen.x, screen.y) * inverse;
        let v = linear([m.m21, m.m22, m.m23], screen.x, screen.y) * inverse;
        if u.is_finite() && v.is_finite() {
            Ok(Point2::new(u, v))
        } else {
            Err(ProjectionError::NotFinite)
        }
    }

    fn jacobian(&self, screen: &Point2<f64>) -> Result<Matrix2<f64>, ProjectionError> {
        let w = self.checked(screen)?;
        let p = self.at(screen)?;
        let m = &self.matrix;
        Ok(Matrix2::new(
            m.m11 - p.x * m.m31,
            m.m12 - p.x * m.m32,
            m.m21 - p.y * m.m31,
            m.m22 - p.y * m.m32,
        ) / w)
    }

    /// ∂u/∂S = (P₁ − u R₁)/w and so on; 1/w is a third attribute of the row's span.
    fn footprints(&self, line: i32, samples: Range<i32>, emit: &mut FootprintSink<'_>) {
        let [p, q, r] = self.coefficients();
        let Ok(span) = Span::on_line([p, q, [1.0, 0.0, 0.0]], r, line) else {
            let by_map = |x, y| self.jacobian(&Point2::new(x, y)).ok();
            return self.blocks(line, samples, &mut |x, u, v| ask(by_map, line, [u, v], x, emit));
        };
        let valid = span.valid_interval(self.valid_samples(line, samples));
        vectorised(
            #[inline(always)]
            || {
                span.walk(
                    valid,
                    #[inline(always)]
                    |x, [u, v, inverse]| {
                        let mut by = [[0.0; BLOCK]; 4];
                        let forms =
                            [(u, p[1], r[1]), (v, q[1], r[1]), (u, p[2], r[2]), (v, q[2], r[2])];
                        for (by, (at, numerator, denominator)) in by.iter_mut().zip(forms) {
                            for (by, (at, inverse)) in by.iter_mut().zip(at.iter().zip(inverse)) {
                                *by = (numerator - at * denominator) * inverse;
                            }
                        }
                        let [us, vs, ul, vl] = by.each_ref().map(|by| &by[..u.len()]);
                        let (by_sample, by_line) = ([us, vs], [ul, vl]);
                        emit(&FootprintBlock { x, u, v, by_sample, by_line });
                    },
                );
            },
        );
    }

    /// Solves both conditions for their interval; `None` for coefficients too small or too large for a span, which no camera
    /// has.
    fn span(&self, line: i32, samples: Range<i32>) -> Option<(Span<2>, Range<i32>)> {
        let [p, q, r] = self.coefficients();
        let span = Span::on_line([p, q], r, line).ok()?;
        if !Span::<2>::reaches(&samples) {
            return None;
        }
        let valid = span.valid_interval(self.valid_samples(line, samples));
        Some((span, valid))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::scalar::Dual;

    #[test]
    fn jacobian_agrees_with_dual_numbers() {
        let map = FractionalLinear::from_coefficients(
            [3.0, 0.7, -0.2],
            [-5.0, 0.1, 0.9],
            [1.0, 2e-3, -1e-3],
            [1.0, 0.0, 0.0],
        )
        .unwrap();
        let screen = Point2::new(210.0, 150.0);
        let (s, l) = (Dual::<2>::variable(screen.x, 0), Dual::<2>::variable(screen.y, 1));
        let forms = [0, 1, 2].map(|i| {
            let row: [Dual<2>; 3] = core::array::from_fn(|j| Dual::constant(map.matrix[(i, j)]));
            linear(row, s, l)
        });
        let jacobian = map.jacobian(&screen).unwrap();
        for i in 0..2 {
            let quotient = forms[i] / forms[2];
            for j in 0..2 {
                assert!((quotient.gradient[j] - jacobian[(i, j)]).abs() < 1e-15);
            }
        }
    }
}
