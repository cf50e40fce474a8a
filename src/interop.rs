//! Conversions between nalgebra, where geometry is done in `f64`, and glam, where pixels are made in `f32`.
//!
//! The one file that names both. Matrices keep their meaning: both libraries multiply columns from the left. Going to
//! `f32` loses precision; a map coordinate of 10⁶ m loses centimetres, so subtract an origin first. For the neutral
//! types of mint 0.5 enable the feature `mint`, which passes nalgebra's own conversions on.
//!
//! ```
//! use collinear::interop;
//! use collinear::nalgebra::{Matrix3, Point3};
//!
//! assert_eq!(interop::vec3(&Point3::new(1.5, -2.0, 0.25)), collinear::glam::vec3(1.5, -2.0, 0.25));
//! let m = Matrix3::new(1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0);
//! // The second column of the matrix, in both.
//! assert_eq!(interop::mat3(&m).y_axis, collinear::glam::vec3(2.0, 5.0, 8.0));
//! ```

use nalgebra::{Matrix3, Matrix4, Point2, Point3, Vector3};

/// A point of the plane, rounded.
#[must_use]
pub fn vec2(p: &Point2<f64>) -> glam::Vec2 {
    glam::vec2(p.x as f32, p.y as f32)
}

/// A point of space, rounded.
#[must_use]
pub fn vec3(p: &Point3<f64>) -> glam::Vec3 {
    glam::vec3(p.x as f32, p.y as f32, p.z as f32)
}

/// A direction, rounded.
#[must_use]
pub fn direction(v: &Vector3<f64>) -> glam::Vec3 {
    glam::vec3(v.x as f32, v.y as f32, v.z as f32)
}

/// A 3×3 matrix, rounded.
#[must_use]
pub fn mat3(m: &Matrix3<f64>) -> glam::Mat3 {
    let rounded = m.map(|c| c as f32);
    glam::Mat3::from_cols_slice(rounded.as_slice())
}

/// A 4×4 matrix, rounded.
#[must_use]
pub fn mat4(m: &Matrix4<f64>) -> glam::Mat4 {
    let rounded = m.map(|c| c as f32);
    glam::Mat4::from_cols_slice(rounded.as_slice())
}

/// A point of the plane, exactly.
#[must_use]
pub fn point2(v: glam::Vec2) -> Point2<f64> {
    Point2::new(f64::from(v.x), f64::from(v.y))
}

/// A point of space, exactly.
#[must_use]
pub fn point3(v: glam::Vec3) -> Point3<f64> {
    Point3::new(f64::from(v.x), f64::from(v.y), f64::from(v.z))
}

/// A 4×4 matrix, exactly.
#[must_use]
pub fn matrix4(m: &glam::Mat4) -> Matrix4<f64> {
    Matrix4::from_column_slice(&m.to_cols_array().map(f64::from))
}
