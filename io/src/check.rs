//! Checks that several formats share.

use crate::error::{Error, ErrorKind, FieldError, FieldProblem};

pub(crate) fn in_range(
    field: &str,
    value: f64,
    expected: &'static str,
    inside: impl Fn(f64) -> bool,
) -> Result<(), FieldError> {
    if value.is_finite() && inside(value) {
        Ok(())
    } else {
        Err(FieldError::new(field, FieldProblem::OutOfRange { value, expected }))
    }
}

pub(crate) fn all_in_range(
    field: &str,
    values: &[f64],
    expected: &'static str,
    inside: impl Fn(f64) -> bool,
) -> Result<(), FieldError> {
    for (i, v) in values.iter().enumerate() {
        in_range(&format!("{field}[{i}]"), *v, expected, &inside)?;
    }
    Ok(())
}

/// Numbers without a domain of their own: JSON has no other, but a program's values may.
pub(crate) fn finite(field: &str, values: &[f64]) -> Result<(), FieldError> {
    all_in_range(field, values, "a finite number", |_| true)
}

/// The length of a vector, without overflow.
pub(crate) fn norm(v: &[f64]) -> f64 {
    let largest = v.iter().fold(0.0_f64, |m, c| m.max(c.abs()));
    if largest == 0.0 || !largest.is_finite() {
        return largest;
    }
    largest * v.iter().map(|c| (c / largest) * (c / largest)).sum::<f64>().sqrt()
}

/// The vector at length one, where it has a direction.
pub(crate) fn unit(v: &[f64; 3]) -> Option<[f64; 3]> {
    let largest = v.iter().fold(0.0_f64, |m, c| m.max(c.abs()));
    if largest == 0.0 || !v.iter().all(|c| c.is_finite()) {
        return None;
    }
    let scaled = v.map(|c| c / largest);
    let n = norm(&scaled);
    Some(scaled.map(|c| c / n))
}

pub(crate) fn dot(a: &[f64; 3], b: &[f64; 3]) -> f64 {
    a.iter().zip(b).map(|(x, y)| x * y).sum()
}

pub(crate) fn cross(a: &[f64; 3], b: &[f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// The determinant of three rows.
pub(crate) fn determinant(m: &[[f64; 3]; 3]) -> f64 {
    dot(&m[0], &cross(&m[1], &m[2]))
}

/// Refuses a picture of another size than its camera's.
pub(crate) fn one_size(picture: [u32; 2], camera: [u32; 2]) -> Result<(), Error> {
    if picture == camera {
        return Ok(());
    }
    Err(ErrorKind::PictureSize { picture, camera }.into())
}
