//! Rows of positions with the derivatives that area filters need.

use nalgebra::Matrix2;

use super::span::BLOCK;

/// Where neighbouring pixels look, and how large they are there.
///
/// All slices have the length of `u`, at most 64.
///
/// ```
/// use collinear::geometry::Affine2;
/// use collinear::mapping::Map;
///
/// // u = 3 S + L: a step along the row is three texels, one down it one.
/// let map = Affine2::from_coefficients([0.0, 3.0, 1.0], [0.0, 0.0, 1.0]);
/// map.footprints(0, 0..2, &mut |block| {
///     assert_eq!((block.x, block.u), (0, [2.0, 5.0].as_slice()));
///     assert_eq!((block.by_sample[0], block.by_line[0]), ([3.0; 2].as_slice(), [1.0; 2].as_slice()));
/// });
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FootprintBlock<'a> {
    /// The first pixel's x.
    pub x: i32,
    /// u of each pixel's centre.
    pub u: &'a [f64],
    /// v of each pixel's centre.
    pub v: &'a [f64],
    /// ∂u/∂S and ∂v/∂S of each.
    pub by_sample: [&'a [f64]; 2],
    /// ∂u/∂L and ∂v/∂L of each.
    pub by_line: [&'a [f64]; 2],
}

/// Takes neighbouring pixels of a row with their derivatives.
pub type FootprintSink<'a> = dyn FnMut(&FootprintBlock<'_>) + 'a;

/// Hands out a block whose derivatives are those of `jacobian` at each pixel's centre.
pub(super) fn ask(
    jacobian: impl Fn(f64, f64) -> Option<Matrix2<f64>>,
    line: i32,
    [u, v]: [&[f64]; 2],
    first: i32,
    emit: &mut FootprintSink<'_>,
) {
    let y = f64::from(line) + 0.5;
    let mut x = f64::from(first) + 0.5;
    for (start, (u, v)) in (first..).step_by(BLOCK).zip(u.chunks(BLOCK).zip(v.chunks(BLOCK))) {
        let mut derivatives = [[f64::NAN; BLOCK]; 4];
        for i in 0..u.len() {
            if let Some(j) = jacobian(x, y) {
                for (each, value) in derivatives.iter_mut().zip([j.m11, j.m21, j.m12, j.m22]) {
                    each[i] = value;
                }
            }
            x += 1.0;
        }
        let [us, vs, ul, vl] = derivatives.each_ref().map(|d| &d[..u.len()]);
        emit(&FootprintBlock { x: start, u, v, by_sample: [us, vs], by_line: [ul, vl] });
    }
}
