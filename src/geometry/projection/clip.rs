//! What the graphics interfaces mean by clip coordinates.

use nalgebra::Vector4;

/// The clip coordinates of a graphics interface: where z lies between near and far, and which way y points.
///
/// | Variant    | also                | z from near to far | y    |
/// |------------|---------------------|--------------------|------|
/// | `OpenGl`   | OpenGL ES, WebGL    | −w … w             | up   |
/// | `Direct3d` | Metal               | 0 … w              | up   |
/// | `Vulkan`   |                     | 0 … w              | down |
/// | `Wgpu`     | WebGPU              | 0 … w              | up   |
///
/// Sources: OpenGL 2.1 reference pages, glFrustum and glViewport; Microsoft's Direct3D 9 pages on
/// `D3DXMatrixPerspectiveOffCenterRH`; the Vulkan specification, *Primitive Clipping* and *Controlling the Viewport*.
///
/// ```
/// use collinear::geometry::projection::ClipConvention;
/// use collinear::nalgebra::Vector4;
///
/// // z = −w/2 lies in OpenGL's volume and before Vulkan's near plane.
/// let clip = Vector4::new(0.3, -1.9, -1.0, 2.0);
/// assert!(ClipConvention::OpenGl.contains(&clip));
/// assert!(!ClipConvention::Vulkan.contains(&clip));
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum ClipConvention {
    /// z in [−w, w], y up.
    #[doc(alias("WebGL", "GLES"))]
    OpenGl,
    /// z in [0, w], y up.
    #[doc(alias("Metal", "DirectX"))]
    Direct3d,
    /// z in [0, w], y down.
    Vulkan,
    /// z in [0, w], y up.
    #[doc(alias = "WebGPU")]
    Wgpu,
}

impl ClipConvention {
    /// The normalised device z of the near and the far plane: [−1, 1] or [0, 1].
    #[must_use]
    pub const fn ndc_depth(self) -> [f64; 2] {
        match self {
            Self::OpenGl => [-1.0, 1.0],
            Self::Direct3d | Self::Vulkan | Self::Wgpu => [0.0, 1.0],
        }
    }

    /// Whether normalised device y grows downwards.
    #[must_use]
    pub const fn y_down(self) -> bool {
        matches!(self, Self::Vulkan)
    }

    /// −1 where y points down, 1 where it points up.
    pub(super) const fn y_sign(self) -> f64 {
        if self.y_down() { -1.0 } else { 1.0 }
    }

    /// The six half-spaces of the clip volume: a point is inside where plane · clip ≥ 0 for all of them.
    ///
    /// In the order of the bits of [`Outcode`]: x + w, w − x, y + w, w − y, z + w (or z), w − z.
    #[must_use]
    pub fn planes(self) -> [Vector4<f64>; 6] {
        let [lowest, _] = self.ndc_depth();
        [
            Vector4::new(1.0, 0.0, 0.0, 1.0),
            Vector4::new(-1.0, 0.0, 0.0, 1.0),
            Vector4::new(0.0, 1.0, 0.0, 1.0),
            Vector4::new(0.0, -1.0, 0.0, 1.0),
            Vector4::new(0.0, 0.0, 1.0, -lowest),
            Vector4::new(0.0, 0.0, -1.0, 1.0),
        ]
    }

    /// Which half-spaces the point is outside of. A coordinate that is NaN is outside of its own.
    #[must_use]
    pub fn outcode(self, clip: &Vector4<f64>) -> Outcode {
        let [x, y, z, w]: [f64; 4] = (*clip).into();
        let [lowest, _] = self.ndc_depth();
        let inside = [-w <= x, x <= w, -w <= y, y <= w, lowest * w <= z, z <= w];
        let bits = inside.iter().zip(0..).map(|(inside, bit)| u8::from(!inside) << bit).sum();
        Outcode(bits)
    }

    /// Whether the point lies in the clip volume, its boundary included. The point (0, 0, 0, 0) does not.
    #[must_use]
    pub fn contains(self, clip: &Vector4<f64>) -> bool {
        clip.w > 0.0 && self.outcode(clip).is_inside()
    }
}

/// The half-spaces of a clip volume that a point is outside of, a bit each (Cohen & Sutherland).
///
/// "Low" and "high" are those of the coordinate. Under reversed depth the low z is the far side.
///
/// ```
/// use collinear::geometry::projection::{ClipConvention, Outcode};
/// use collinear::nalgebra::Vector4;
///
/// // Both ends lie above the volume: nothing of the line is visible.
/// let a = ClipConvention::Wgpu.outcode(&Vector4::new(-3.0, 2.0, 0.5, 1.0));
/// let b = ClipConvention::Wgpu.outcode(&Vector4::new(0.0, 1.5, 0.5, 1.0));
/// assert_eq!(a.common(b), Outcode::Y_HIGH);
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Outcode(u8);

impl Outcode {
    /// x < −w.
    pub const X_LOW: Self = Self(1);
    /// x > w.
    pub const X_HIGH: Self = Self(2);
    /// y < −w.
    pub const Y_LOW: Self = Self(4);
    /// y > w.
    pub const Y_HIGH: Self = Self(8);
    /// z < −w, or z < 0 where z starts at zero.
    pub const Z_LOW: Self = Self(16);
    /// z > w.
    pub const Z_HIGH: Self = Self(32);

    /// The bits, bit i for the i-th of [`ClipConvention::planes`].
    #[must_use]
    pub const fn bits(self) -> u8 {
        self.0
    }

    /// Outside of nothing.
    #[must_use]
    pub const fn is_inside(self) -> bool {
        self.0 == 0
    }

    /// The half-spaces that both are outside of: where there is one, so is all that lies between the two.
    #[must_use]
    #[doc(alias = "trivial reject")]
    pub const fn common(self, other: Self) -> Self {
        Self(self.0 & other.0)
    }

    /// The half-spaces that either is outside of: where there is none, all between the two is inside.
    #[must_use]
    #[doc(alias = "trivial accept")]
    pub const fn either(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }
}
