//! The window.

use nalgebra::{Matrix4, Point3, Vector4};

use super::clip::ClipConvention;
use crate::error::{Error, ProjectionError};

/// The rectangle of a window that the clip volume fills, and the range of its depth buffer.
///
/// ```text
/// x = x₀ + (1 + x_ndc) width/2
/// y = y₀ + (1 ∓ y_ndc) height/2        − where NDC y points up, + where it points down (Vulkan)
/// z = d₀ + (z_ndc − n₀)/(n₁ − n₀) (d₁ − d₀)        NDC z in [n₀, n₁]
/// ```
///
/// Window coordinates are pixels from the top-left corner of the window, y down, pixel centres at ½. This is the transformation
/// of Direct3D, Vulkan (*Controlling the Viewport*) and WebGPU; OpenGL's glViewport counts y from the lower edge, see
/// [`from_lower_left`](Self::from_lower_left).
///
/// # Example
/// ```
/// use collinear::geometry::projection::{ClipConvention, Viewport};
/// use collinear::nalgebra::Point3;
///
/// // glViewport: x_w = (x_nd + 1)(width/2) + x = 1.5 · 320 = 480, y_w = 1.25 · 240 = 300 above the lower edge.
/// let window = Viewport::new(0.0, 0.0, 640.0, 480.0)?;
/// let pixel = window.window_from_ndc(ClipConvention::OpenGl, &Point3::new(0.5, 0.25, 0.0));
/// assert_eq!(pixel, Point3::new(480.0, 480.0 - 300.0, 0.5));
/// # Ok::<(), collinear::Error>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[doc(alias("glViewport", "D3D11_VIEWPORT", "VkViewport", "set_viewport"))]
pub struct Viewport {
    x: f64,
    y: f64,
    width: f64,
    height: f64,
    depth: [f64; 2],
}

impl Viewport {
    /// The rectangle with this upper left corner and size, in pixels; depths from 0 to 1.
    ///
    /// # Errors
    /// [`Error::NotFinite`] for the corner, [`Error::OutOfRange`] unless width and height are positive and finite.
    pub fn new(x: f64, y: f64, width: f64, height: f64) -> Result<Self, Error> {
        if !(x.is_finite() && y.is_finite()) {
            return Err(Error::NotFinite { what: "viewport corner" });
        }
        for value in [width, height] {
            if !(value > 0.0 && value < f64::INFINITY) {
                return Err(Error::OutOfRange {
                    what: "viewport size",
                    value,
                    expected: "positive and finite",
                });
            }
        }
        Ok(Self { x, y, width, height, depth: [0.0, 1.0] })
    }

    /// The rectangle of glViewport: its lower left corner, y counted upwards from the lower edge of the window.
    ///
    /// # Errors
    /// As [`new`](Self::new).
    pub fn from_lower_left(
        [x, y]: [f64; 2],
        [width, height]: [f64; 2],
        window_height: f64,
    ) -> Result<Self, Error> {
        Self::new(x, window_height - (y + height), width, height)
    }

    /// With window depths from `near` to `far`, the ends of normalised device z; they may fall.
    ///
    /// # Errors
    /// [`Error::NotFinite`], and [`Error::OutOfRange`] where the two are equal.
    #[doc(alias("glDepthRange", "minDepth", "maxDepth"))]
    pub fn with_depth_range(self, near: f64, far: f64) -> Result<Self, Error> {
        if !(near.is_finite() && far.is_finite() && (far - near).is_finite()) {
            return Err(Error::NotFinite { what: "viewport depth range" });
        }
        if near == far {
            return Err(Error::OutOfRange {
                what: "viewport depth range",
                value: near,
                expected: "two different depths",
            });
        }
        Ok(Self { depth: [near, far], ..self })
    }

    /// (factor, shift) of x, y and z: window = factor · ndc + shift.
    fn coefficients(&self, convention: ClipConvention) -> [[f64; 2]; 3] {
        let (half_width, half_height) = (0.5 * self.width, 0.5 * self.height);
        let [n0, n1] = convention.ndc_depth();
        let [d0, d1] = self.depth;
        let slope = (d1 - d0) / (n1 - n0);
        [
            [half_width, self.x + half_width],
            [-convention.y_sign() * half_height, self.y + half_height],
            [slope, d0 - n0 * slope],
        ]
    }

    /// The matrix on homogeneous columns; applied to clip coordinates it gives (x w, y w, z w, w) of the window, which is what a
    /// scanline interpolates.
    #[must_use]
    pub fn window_from_clip_matrix(&self, convention: ClipConvention) -> Matrix4<f64> {
        let [[ax, bx], [ay, by], [az, bz]] = self.coefficients(convention);
        #[rustfmt::skip]
        let matrix = Matrix4::new(
            ax, 0.0, 0.0, bx,
            0.0, ay, 0.0, by,
            0.0, 0.0, az, bz,
            0.0, 0.0, 0.0, 1.0,
        );
        matrix
    }

    /// A point of the window (pixels, pixels, depth).
    #[must_use]
    pub fn window_from_ndc(&self, convention: ClipConvention, ndc: &Point3<f64>) -> Point3<f64> {
        let c = self.coefficients(convention);
        Point3::from([0, 1, 2].map(|i| c[i][0] * ndc[i] + c[i][1]))
    }

    /// The normalised device coordinates of a point of the window.
    #[must_use]
    pub fn ndc_from_window(&self, convention: ClipConvention, window: &Point3<f64>) -> Point3<f64> {
        let c = self.coefficients(convention);
        Point3::from([0, 1, 2].map(|i| (window[i] - c[i][1]) / c[i][0]))
    }

    /// Divides by w and goes on to the window.
    ///
    /// # Errors
    /// [`ProjectionError::BehindCamera`] with w where w ≤ 0, and [`ProjectionError::NotFinite`].
    pub fn window_from_clip(
        &self,
        convention: ClipConvention,
        clip: &Vector4<f64>,
    ) -> Result<Point3<f64>, ProjectionError> {
        let window = self.window_from_ndc(convention, &divided(clip)?);
        if window.coords.iter().all(|c| c.is_finite()) {
            Ok(window)
        } else {
            Err(ProjectionError::NotFinite)
        }
    }
}

/// (x, y, z) / w.
pub(super) fn divided(homogeneous: &Vector4<f64>) -> Result<Point3<f64>, ProjectionError> {
    let [x, y, z, w]: [f64; 4] = (*homogeneous).into();
    if !homogeneous.iter().all(|c| c.is_finite()) {
        return Err(ProjectionError::NotFinite);
    }
    if w <= 0.0 {
        return Err(ProjectionError::BehindCamera { depth: w });
    }
    let point = Point3::new(x / w, y / w, z / w);
    if point.coords.iter().all(|c| c.is_finite()) {
        Ok(point)
    } else {
        Err(ProjectionError::NotFinite)
    }
}
