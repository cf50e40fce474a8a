//! Homogeneous 4×4 projection: from camera axes through clip coordinates to the window, and into a texture.
//!
//! ```text
//! world ─ Pose ─► camera ─ Projection ─► clip ─ ÷w ─► NDC ─ Viewport ─► window (pixels, y down)
//!                                         └─ texture_from_clip ─► (s, t, r, q) ─ ÷q ─► texture
//! ```
//!
//! Matrices act on columns, a name reads `<to>_from_<from>`. Camera axes are x right, y down, z forward; OpenGL's eye axes
//! (x right, y up, looking along −z) are the photogrammetric ones, and each [`Projection`] gives its matrix for either.
//!
//! | [`ClipConvention`] | NDC z   | NDC y | Clip volume (w > 0)                    | NDC (−1, −1) is the window's |
//! |--------------------|---------|-------|----------------------------------------|------------------------------|
//! | `OpenGl`           | [−1, 1] | up    | −w ≤ x ≤ w, −w ≤ y ≤ w, −w ≤ z ≤ w     | lower left corner            |
//! | `Direct3d`         | [0, 1]  | up    | −w ≤ x ≤ w, −w ≤ y ≤ w,  0 ≤ z ≤ w     | lower left corner            |
//! | `Vulkan`           | [0, 1]  | down  | −w ≤ x ≤ w, −w ≤ y ≤ w,  0 ≤ z ≤ w     | upper left corner            |
//! | `Wgpu`             | [0, 1]  | up    | −w ≤ x ≤ w, −w ≤ y ≤ w,  0 ≤ z ≤ w     | lower left corner            |
//!
//! Direct3D's manuals write rows, v M: their matrices are the transposes of these.
//!
#![doc = include_str!("../../../docs/figures/projection.svg")]

mod clip;
mod depth;
mod perspective;
pub mod survey;
pub mod texture;
mod viewport;

pub use clip::{ClipConvention, Outcode};
pub use depth::DepthRange;
pub use perspective::Projection;
pub use viewport::Viewport;
