//! (in preparation)
use crate::error::Error;
use nalgebra::{Matrix3, Point2};
/// tmp
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Homography {
    matrix: Matrix3<f64>,
}
impl Homography {
    /// tmp
    pub fn from_matrix(matrix: Matrix3<f64>) -> Result<Self, Error> {
        Ok(Self { matrix })
    }
    /// tmp
    #[must_use]
    pub fn matrix(&self) -> &Matrix3<f64> {
        &self.matrix
    }
    /// tmp
    pub fn from_quads(s: &[Point2<f64>; 4], t: &[Point2<f64>; 4]) -> Result<Self, Error> {
        let mut a = nalgebra::SMatrix::<f64, 8, 8>::zeros();
        let mut b = nalgebra::SVector::<f64, 8>::zeros();
        for i in 0..4 {
            let (x, y, u, v) = (s[i].x, s[i].y, t[i].x, t[i].y);
            a.set_row(
                2 * i,
                &nalgebra::RowSVector::<f64, 8>::from_row_slice(&[
                    x,
                    y,
                    1.,
                    0.,
                    0.,
                    0.,
                    -x * u,
                    -y * u,
                ]),
            );
            b[2 * i] = u;
            a.set_row(
                2 * i + 1,
                &nalgebra::RowSVector::<f64, 8>::from_row_slice(&[
                    0.,
                    0.,
                    0.,
                    x,
                    y,
                    1.,
                    -x * v,
                    -y * v,
                ]),
            );
            b[2 * i + 1] = v;
        }
        let h = a.lu().solve(&b).ok_or(Error::NotFinite { what: "x" })?;
        let m = Matrix3::new(h[0], h[1], h[2], h[3], h[4], h[5], h[6], h[7], 1.0);
        let w = (m * nalgebra::Vector3::new(s[0].x, s[0].y, 1.0)).z;
        Ok(Self { matrix: if w < 0.0 { -m } else { m } })
    }
}
