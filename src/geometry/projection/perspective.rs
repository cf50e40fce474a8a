//! Perspective and orthographic projection into clip coordinates.

use nalgebra::{Matrix4, Point2};

use super::clip::ClipConvention;
use super::depth::DepthRange;
use crate::error::{Error, ProjectionError};
use crate::numeric::float;

/// A view volume: what lies in it reaches the window.
///
/// *Model*, in eye axes (x right, y up) with the depth Z > 0 before the eye, y up in the window:
///
/// ```text
/// perspective    x_ndc = a x/Z − A    y_ndc = b y/Z − B    z_ndc = α + β/Z    w = Z
/// orthographic   x_ndc = a x   − A    y_ndc = b y   − B    z_ndc = α Z + β    w = 1
/// ```
///
/// | Constructor                                             | a             | A                   |
/// |---------------------------------------------------------|---------------|---------------------|
/// | [`from_field_of_view`](Self::from_field_of_view)        | cot(φ/2) / aspect | 0               |
/// | [`from_principal_distance`](Self::from_principal_distance) | 2 c / width | (width − 2 x₀) / width |
/// | [`from_window_at_near`](Self::from_window_at_near)      | 2 near / (r − l) | (r + l) / (r − l) |
/// | [`orthographic`](Self::orthographic)                    | 2 / (r − l)   | (r + l) / (r − l)   |
///
/// α and β put the ends of the [`DepthRange`] at those of the [`ClipConvention`]. The first row is that of gluPerspective, the
/// third that of glFrustum, the fourth that of glOrtho (OpenGL 2.1 reference pages); with z in [0, 1] they are Direct3D's
/// `D3DXMatrixPerspectiveFovRH`, `…OffCenterRH` and `D3DXMatrixOrthoOffCenterRH`, transposed.
///
/// *Accuracy*: the elements are correct to 3 ulp. A point images through matrix and viewport where the collinearity
/// equations put it, to a few ulp of the window's width.
///
/// # Example
/// gluPerspective(60, 4/3, 0.1, 100), evaluated in 30 digits with mpmath 1.3.0.
/// ```
/// use collinear::geometry::projection::{ClipConvention, DepthRange, Projection};
///
/// let depth = DepthRange::new(0.1, 100.0)?;
/// let view = Projection::from_field_of_view(60f64.to_radians(), 4.0 / 3.0, depth)?;
/// let m = view.clip_from_eye(ClipConvention::OpenGl);
/// assert!((m[(0, 0)] - 1.299038105676658).abs() < 1e-15);
/// assert!((m[(1, 1)] - 1.732050807568877).abs() < 1e-15);
/// assert!((m[(2, 2)] + 1.002002002002002).abs() < 1e-15);
/// assert!((m[(2, 3)] + 0.2002002002002002).abs() < 1e-15);
/// assert_eq!(m[(3, 2)], -1.0);
/// # Ok::<(), collinear::Error>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[doc(alias("frustum", "Perspective3", "view volume"))]
pub struct Projection {
    perspective: bool,
    /// a and b.
    scale: [f64; 2],
    /// A and B.
    offset: [f64; 2],
    depth: DepthRange,
}

const WINDOW: &str = "different from each other, by a representable amount";

impl Projection {
    /// A symmetric perspective view of the given vertical angle (radians) and aspect, width over height.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] unless 0 < angle < π, 0 < aspect < ∞ and near > 0; NaN among them.
    #[doc(alias("gluPerspective", "perspectiveRH", "fovy"))]
    pub fn from_field_of_view(
        vertical: f64,
        aspect: f64,
        depth: DepthRange,
    ) -> Result<Self, Error> {
        if !(vertical > 0.0 && vertical < core::f64::consts::PI) {
            return Err(Error::OutOfRange {
                what: "vertical field of view",
                value: vertical,
                expected: "between 0 and π",
            });
        }
        positive("aspect", aspect)?;
        let (sine, cosine) = float::sin_cos(0.5 * vertical);
        let cotangent = cosine / sine;
        Self::checked(true, [cotangent / aspect, cotangent], [0.0, 0.0], depth)
    }

    /// The perspective view of a photograph: principal distances, principal point and image size in pixels, from the
    /// top-left corner of the top-left pixel.
    ///
    /// ```text
    /// x = c_x X/Z + x₀,    y = c_y Y/Z + y₀        (camera axes)
    /// ```
    ///
    /// A point that images at (x, y) lands at (x, y) in a [`Viewport`](super::Viewport) of the image's size. The principal
    /// point may lie anywhere, outside of the image too: the view of a tile of a photograph has the photograph's principal
    /// distance, and its principal point less the tile's corner.
    ///
    /// # Errors
    /// [`Error::NotFinite`] for the principal point, and [`Error::OutOfRange`] unless principal distances, sizes and near are
    /// positive.
    ///
    /// ```
    /// use collinear::geometry::projection::{ClipConvention, DepthRange, Projection, Viewport};
    /// use collinear::nalgebra::{Point2, Vector4};
    ///
    /// // 1000 · 0.2 + 310 = 510, 1000 · 0.1 + 250 = 350.
    /// let depth = DepthRange::new(1.0, 1e4)?;
    /// let view = Projection::from_principal_distance([1000.0; 2], Point2::new(310.0, 250.0), [640.0, 480.0], depth)?;
    /// let window = Viewport::new(0.0, 0.0, 640.0, 480.0)?;
    /// for convention in [ClipConvention::OpenGl, ClipConvention::Direct3d, ClipConvention::Vulkan, ClipConvention::Wgpu] {
    ///     let clip = view.clip_from_camera(convention) * Vector4::new(2.0, 1.0, 10.0, 1.0);
    ///     let pixel = window.window_from_clip(convention, &clip)?;
    ///     assert!((pixel.x - 510.0).abs() < 1e-12 && (pixel.y - 350.0).abs() < 1e-12);
    /// }
    /// # Ok::<(), collinear::Error>(())
    /// ```
    #[doc(alias("intrinsics", "off-axis"))]
    pub fn from_principal_distance(
        principal_distance: [f64; 2],
        principal_point: Point2<f64>,
        image_size: [f64; 2],
        depth: DepthRange,
    ) -> Result<Self, Error> {
        for c in principal_distance {
            positive("principal distance", c)?;
        }
        for size in image_size {
            positive("image size", size)?;
        }
        if !(principal_point.x.is_finite() && principal_point.y.is_finite()) {
            return Err(Error::NotFinite { what: "principal point" });
        }
        let [width, height] = image_size;
        let [cx, cy] = principal_distance;
        Self::checked(
            true,
            [2.0 * (cx / width), 2.0 * (cy / height)],
            // The window's y points up.
            [
                (width - 2.0 * principal_point.x) / width,
                (2.0 * principal_point.y - height) / height,
            ],
            depth,
        )
    }

    /// The perspective view through the window [left, right, bottom, top] in the near plane, in world units, y up.
    ///
    /// Left may exceed right and bottom exceed top: the picture is then mirrored.
    ///
    /// # Errors
    /// [`Error::NotFinite`], and [`Error::OutOfRange`] where left = right or bottom = top, or near ≤ 0.
    #[doc(alias("glFrustum", "off-axis", "OffCenter"))]
    pub fn from_window_at_near(
        [left, right, bottom, top]: [f64; 4],
        depth: DepthRange,
    ) -> Result<Self, Error> {
        let [(width, a), (height, b)] = [edges(left, right)?, edges(bottom, top)?];
        let near = 2.0 * depth.near();
        Self::checked(true, [near / width, near / height], [a, b], depth)
    }

    /// The orthographic view of the box over the window [left, right, bottom, top], in world units, y up.
    ///
    /// # Errors
    /// [`Error::NotFinite`], and [`Error::OutOfRange`] where left = right or bottom = top, or where the depth range has no
    /// end.
    #[doc(alias("glOrtho", "parallel projection"))]
    pub fn orthographic(
        [left, right, bottom, top]: [f64; 4],
        depth: DepthRange,
    ) -> Result<Self, Error> {
        let [(width, a), (height, b)] = [edges(left, right)?, edges(bottom, top)?];
        Self::checked(false, [2.0 / width, 2.0 / height], [a, b], depth)
    }

    fn checked(
        perspective: bool,
        scale: [f64; 2],
        offset: [f64; 2],
        depth: DepthRange,
    ) -> Result<Self, Error> {
        if perspective {
            positive("near depth", depth.near())?;
        } else if depth.far() == f64::INFINITY {
            return Err(Error::OutOfRange {
                what: "far depth",
                value: depth.far(),
                expected: "finite for an orthographic view",
            });
        }
        let this = Self { perspective, scale, offset, depth };
        for a in scale {
            if !(a.is_finite() && a != 0.0) {
                return Err(Error::OutOfRange {
                    what: "scale of the view",
                    value: a,
                    expected: "finite and not zero",
                });
            }
        }
        let [alpha, beta] = this.depth_coefficients(ClipConvention::OpenGl);
        let of_depth = if perspective { beta } else { alpha };
        let finite = [offset[0], offset[1], alpha, beta].iter().all(|a| a.is_finite());
        if !finite || of_depth == 0.0 {
            return Err(Error::OutOfRange {
                what: "element of the projection matrix",
                value: of_depth,
                expected: "finite and not zero",
            });
        }
        Ok(this)
    }

    fn depth_coefficients(&self, convention: ClipConvention) -> [f64; 2] {
        let ndc = convention.ndc_depth();
        if self.perspective { self.depth.perspective(ndc) } else { self.depth.orthographic(ndc) }
    }

    /// The range of depths.
    #[must_use]
    pub fn depth(&self) -> DepthRange {
        self.depth
    }

    /// The matrix from camera axes (x right, y down, z forward).
    #[must_use]
    pub fn clip_from_camera(&self, convention: ClipConvention) -> Matrix4<f64> {
        let ([a, b], [offset_x, offset_y]) = (self.scale, self.offset);
        let up = convention.y_sign();
        let [alpha, beta] = self.depth_coefficients(convention);
        #[rustfmt::skip]
        let matrix = if self.perspective {
            Matrix4::new(
                a, 0.0, -offset_x, 0.0,
                0.0, -up * b, -up * offset_y, 0.0,
                0.0, 0.0, alpha, beta,
                0.0, 0.0, 1.0, 0.0,
            )
        } else {
            Matrix4::new(
                a, 0.0, 0.0, -offset_x,
                0.0, -up * b, 0.0, -up * offset_y,
                0.0, 0.0, alpha, beta,
                0.0, 0.0, 0.0, 1.0,
            )
        };
        matrix
    }

    /// The matrix from OpenGL's eye axes (x right, y up, looking along −z), which are the photogrammetric photo axes.
    #[must_use]
    #[doc(alias = "GL_PROJECTION")]
    pub fn clip_from_eye(&self, convention: ClipConvention) -> Matrix4<f64> {
        let mut m = self.clip_from_camera(convention);
        m.column_mut(1).neg_mut();
        m.column_mut(2).neg_mut();
        m
    }

    /// The depth along the optical axis that a normalised device z stands for, as read from a depth buffer.
    ///
    /// # Errors
    /// [`ProjectionError::OutsideDomain`] where no finite depth does, with z and the value it must not reach (that of infinity), and
    /// [`ProjectionError::NotFinite`].
    #[doc(alias("linearize depth", "unproject"))]
    pub fn depth_from_ndc(
        &self,
        convention: ClipConvention,
        z: f64,
    ) -> Result<f64, ProjectionError> {
        if !z.is_finite() {
            return Err(ProjectionError::NotFinite);
        }
        let [alpha, beta] = self.depth_coefficients(convention);
        let depth = if self.perspective { beta / (z - alpha) } else { (z - beta) / alpha };
        let before_the_eye = !self.perspective || depth > 0.0;
        if depth.is_finite() && before_the_eye {
            Ok(depth)
        } else {
            Err(ProjectionError::OutsideDomain { value: z, limit: alpha })
        }
    }
}

fn positive(what: &'static str, value: f64) -> Result<(), Error> {
    if value > 0.0 && value < f64::INFINITY {
        Ok(())
    } else {
        Err(Error::OutOfRange { what, value, expected: "positive and finite" })
    }
}

/// (high − low, (high + low) / (high − low)).
fn edges(low: f64, high: f64) -> Result<(f64, f64), Error> {
    if !(low.is_finite() && high.is_finite()) {
        return Err(Error::NotFinite { what: "window edge" });
    }
    let width = high - low;
    if !(width.is_finite() && width != 0.0) {
        return Err(Error::OutOfRange { what: "window edge", value: high, expected: WINDOW });
    }
    // Halves first: the sum may overflow where the difference does not.
    Ok((width, (0.5 * high + 0.5 * low) / (0.5 * width)))
}
