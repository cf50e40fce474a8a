//! Area filters at one position, texel by texel: what the rows of blocks are held to.

use nalgebra::{Matrix2, Point2};

use super::filter::AreaFilter;
use super::pyramid::Pyramid;
use super::spread::{Derivatives, Ellipse, Limits, floor, integer, mix, nearest};
use crate::mapping::RowCoords;
use crate::resample::border::Border;
use crate::resample::image::Sample;
use crate::resample::kernel::bilinear;

/// A position in a picture and how much of it a pixel covers there.
///
/// ```
/// use collinear::mapping::{FractionalLinear, Map};
/// use collinear::nalgebra::Point2;
/// use collinear::resample::Footprint;
///
/// // u = 3 S, v = 4 S + L: the axes' squares are the eigenvalues of ((9, 12), (12, 17)), 13 ± √160.
/// let map = FractionalLinear::from_coefficients(
///     [0.0, 3.0, 0.0], [0.0, 4.0, 1.0], [1.0, 0.0, 0.0], [1.0, 0.0, 0.0])?;
/// let pixel = Footprint::of(&map, &Point2::new(10.5, 20.5))?;
/// assert_eq!(pixel.position, Point2::new(31.5, 62.5));
/// let [longest, shortest] = pixel.axes();
/// assert!((longest - (13.0 + 160f64.sqrt()).sqrt()).abs() < 1e-12);
/// assert!((shortest - (13.0 - 160f64.sqrt()).sqrt()).abs() < 1e-12);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Footprint {
    /// The position, in texels from the picture's top-left corner.
    pub position: Point2<f64>,
    /// ∂(u, v)/∂(S, L).
    pub jacobian: Matrix2<f64>,
}

impl Footprint {
    /// What a map shows at a screen point.
    ///
    /// # Errors
    /// Those of [`Map::at`](crate::mapping::Map::at) and [`Map::jacobian`](crate::mapping::Map::jacobian).
    pub fn of(
        map: &dyn crate::mapping::Map,
        screen: &Point2<f64>,
    ) -> Result<Self, crate::error::ProjectionError> {
        Ok(Self { position: map.at(screen)?, jacobian: map.jacobian(screen)? })
    }

    /// The half axes of the ellipse that the pixel's unit circle becomes, the longer one first: J's singular values.
    #[must_use]
    pub fn axes(&self) -> [f64; 2] {
        let j = &self.jacobian;
        // |a| and |b| of J = a rotation and scaling + b reflection and scaling.
        let plus = (j.m11 + j.m22).hypot(j.m21 - j.m12);
        let minus = (j.m11 - j.m22).hypot(j.m21 + j.m12);
        let longest = 0.5 * (plus + minus);
        let shortest = if longest > 0.0 { j.determinant().abs() / longest } else { 0.0 };
        [longest, shortest]
    }

    pub(super) fn derivatives(&self) -> Derivatives {
        let j = &self.jacobian;
        Derivatives::new([j.m11, j.m21, j.m12, j.m22])
    }
}

/// A level as lookups need it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Place {
    /// Number of its first sample.
    pub(super) start: usize,
    pub(super) size: [i32; 2],
    pub(super) scale: [f64; 2],
    /// The variance of its texels, texels².
    pub(super) own: f32,
}

/// A pyramid with at least one level, a filter and a border.
pub(super) struct Lookup<'a, T, const C: usize> {
    pub(super) samples: &'a [T],
    pub(super) places: alloc::vec::Vec<Place>,
    pub(super) border: Border,
    pub(super) constant: [T; C],
    pub(super) filter: AreaFilter,
    pub(super) limits: Limits,
}

/// The number of the last texel centre before a position, and how far behind it the position is.
#[inline(always)]
fn before(x: f64) -> (i32, f32) {
    crate::resample::position::split(x, 0.5)
}

/// A coordinate within the first of n texels that are repeated; what is too large stays.
#[inline(always)]
pub(super) fn in_first_period(x: f64, n: f64) -> f64 {
    let known = x.abs() <= RowCoords::COORDINATE_LIMIT;
    if (x >= 0.0 && x < n) || !known { x } else { x.rem_euclid(n) }
}

impl<'a, T: Sample, const C: usize> Lookup<'a, T, C> {
    /// `None` for a pyramid without levels.
    pub(super) fn new(
        pyramid: &'a Pyramid<T, C>,
        filter: AreaFilter,
        border: Border,
    ) -> Option<Self> {
        let (samples, levels) = pyramid.parts();
        let places: alloc::vec::Vec<Place> = levels
            .iter()
            .map(|level| Place {
                start: level.start,
                size: level.size.map(|n| n as i32),
                scale: level.scale,
                // A mean of n texels one 1/n apart.
                own: ((1.0 - level.scale[0].max(level.scale[1]).powi(2)) / 12.0) as f32,
            })
            .collect();
        let anisotropy = match filter {
            AreaFilter::Ewa { anisotropy } => f32::from(anisotropy),
            _ => 1.0,
        };
        (!places.is_empty()).then(|| Self {
            samples,
            places,
            border,
            constant: border.constant(),
            filter,
            limits: Limits::new(anisotropy, pyramid.ratio(), levels.len()),
        })
    }

    /// The value of a pixel; `None` outside a transparent border, for NaN and beyond
    /// [`COORDINATE_LIMIT`](RowCoords::COORDINATE_LIMIT).
    pub(super) fn at(&self, u: f64, v: f64, derivatives: Derivatives) -> Option<[T; C]> {
        let limit = RowCoords::COORDINATE_LIMIT;
        if !(u.abs() <= limit && v.abs() <= limit) {
            return None;
        }
        let [w, h] = self.places[0].size.map(f64::from);
        let inside = (0.0..w).contains(&u) && (0.0..h).contains(&v);
        if self.border == Border::Transparent && !inside {
            return None;
        }
        let (u, v) = match self.border {
            Border::Repeat => (in_first_period(u, w), in_first_period(v, h)),
            _ => (u, v),
        };
        let value = match self.filter {
            AreaFilter::NearestLevel => {
                let level = self.limits.level_of_detail(derivatives) as usize;
                self.bilinear(level, u, v)
            }
            AreaFilter::Trilinear => {
                let (whole, share) = self.limits.between(derivatives);
                let level = whole as usize;
                let next = (level + 1).min(self.places.len() - 1);
                let (fine, coarse) = (self.bilinear(level, u, v), self.bilinear(next, u, v));
                core::array::from_fn(|k| mix(fine[k], coarse[k], share))
            }
            AreaFilter::Ewa { .. } => self.ewa(u, v, derivatives),
        };
        Some(value.map(T::from_f32))
    }

    fn texel(&self, place: &Place, i: i32, j: i32) -> [f32; C] {
        let [w, h] = place.size;
        let at = match (self.border.texel(i, w), self.border.texel(j, h)) {
            (Some(x), Some(y)) => self
                .samples
                .get(place.start + (y * w as usize + x) * C..)
                .and_then(|s| s.first_chunk::<C>()),
            _ => None,
        };
        at.unwrap_or(&self.constant).map(T::to_f32)
    }

    fn bilinear(&self, level: usize, u: f64, v: f64) -> [f32; C] {
        let place = &self.places[level.min(self.places.len() - 1)];
        let ((i, fu), (j, fv)) = (before(u * place.scale[0]), before(v * place.scale[1]));
        let taps = [(i, j), (i + 1, j), (i, j + 1), (i + 1, j + 1)];
        let taps = taps.map(|(i, j)| self.texel(place, i, j));
        core::array::from_fn(|k| bilinear(taps.map(|t| t[k]), fu, fv))
    }

    fn ewa(&self, u: f64, v: f64, derivatives: Derivatives) -> [f32; C] {
        let level = floor(self.limits.level(derivatives)) as usize;
        let place = &self.places[level];
        let scale = place.scale.map(|s| s as f32);
        let ellipse = Ellipse::new(derivatives, scale, place.own, &self.limits);
        let ((ou, fu), (ov, fv)) = (before(u * place.scale[0]), before(v * place.scale[1]));
        if let Border::Constant(_) = self.border {
            let [w, h] = place.size;
            let reach = ellipse.reach();
            let (left, right) = (integer(fu - reach) - 1, integer(fu + reach) + 1);
            let (top, bottom) =
                (integer(fv - ellipse.height) - 1, integer(fv + ellipse.height) + 1);
            if ou + right < 0 || ou + left >= w || ov + bottom < 0 || ov + top >= h {
                // Not the constant times a sum of weights, which rounding takes a little from one.
                return self.constant.map(T::to_f32);
            }
        }
        let (first, last) =
            (nearest(fv - ellipse.height + 0.5), nearest(fv + ellipse.height - 0.5));
        let rows = integer(last) - integer(first) + 1;
        let (mut total, mut sums) = (0.0, [0.0; C]);
        for r in 0..rows {
            let dy = first + r as f32 - fv;
            let middle = fu + ellipse.slope * dy;
            let down = dy * dy * ellipse.down;
            let left = nearest(middle - ellipse.width + 0.5);
            for i in 0..4 * ellipse.groups() {
                let dx = left + i as f32 - middle;
                let near = 1.0 - (down + dx * dx * ellipse.across);
                if near > 0.0 {
                    let weight = near * near;
                    total += weight;
                    let texel = self.texel(place, ou + integer(left) + i, ov + integer(first) + r);
                    for k in 0..C {
                        sums[k] += weight * texel[k];
                    }
                }
            }
        }
        sums.map(|sum| sum / total)
    }
}
