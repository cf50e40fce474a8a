//! Nearest and bilinear lookups, one row of coordinates at a time.

use nalgebra::Point2;

use super::border::{Border, Clamp, Constant, Edge, Mirror, Repeat, Transparent};
use super::image::{ImageView, Sample};
use crate::mapping::RowCoords;

/// How a value is taken between texel centres.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Filter {
    /// The texel that contains the position. Reproduces texels; jagged when magnified, aliases when minified.
    Nearest,
    /// The mean of the four texels whose centres surround the position, weighted by the opposite areas. Reproduces a
    /// ramp exactly away from the edge; weights in `f32`. Aliases when minified.
    #[default]
    Bilinear,
}

/// Called for each pixel of a row that a filter has a value for.
pub(crate) trait Visit<T, const C: usize> {
    /// Whether the pixel is wanted; asked before the texels are read.
    fn wants(&mut self, x: i32) -> bool;
    /// The pixel's value.
    fn paint(&mut self, x: i32, value: [T; C]);
}

/// A lookup: the value at origin + offset, or nothing.
trait Lookup<T: Sample, const C: usize> {
    fn value(&self, origin: [i32; 2], u: f32, v: f32) -> Option<[T; C]>;
}

struct Nearest<'a, T, const C: usize, E> {
    view: ImageView<'a, T, C>,
    size: [i32; 2],
    constant: [T; C],
    edge: E,
}

struct Bilinear<'a, T, const C: usize, E> {
    view: ImageView<'a, T, C>,
    size: [i32; 2],
    constant: [T; C],
    edge: E,
}

/// ⌊x⌋ for |x| < 2³¹. The cast truncates; without SSE4.1 it is cheaper than the library's floor.
#[inline]
fn floor(x: f32) -> i32 {
    let truncated = x as i32;
    truncated - i32::from(x < truncated as f32)
}

#[inline]
fn texel<T: Sample, const C: usize, E: Edge>(
    view: &ImageView<'_, T, C>,
    _edge: E,
    size: [i32; 2],
    constant: [T; C],
    i: i32,
    j: i32,
) -> [T; C] {
    match (E::texel(i, size[0]), E::texel(j, size[1])) {
        (Some(x), Some(y)) => view.pixel(x, y).unwrap_or(constant),
        _ => constant,
    }
}

#[inline]
fn outside(i: i32, j: i32, size: [i32; 2]) -> bool {
    // One unsigned comparison tests both ends.
    i as u32 >= size[0] as u32 || j as u32 >= size[1] as u32
}

impl<T: Sample, const C: usize, E: Edge> Lookup<T, C> for Nearest<'_, T, C, E> {
    #[inline]
    fn value(&self, origin: [i32; 2], u: f32, v: f32) -> Option<[T; C]> {
        let (i, j) = (origin[0] + floor(u), origin[1] + floor(v));
        if E::TRANSPARENT {
            if outside(i, j, self.size) {
                return None;
            }
            return self.view.pixel(i as usize, j as usize);
        }
        Some(texel(&self.view, self.edge, self.size, self.constant, i, j))
    }
}

impl<T: Sample, const C: usize, E: Edge> Lookup<T, C> for Bilinear<'_, T, C, E> {
    #[inline]
    fn value(&self, origin: [i32; 2], u: f32, v: f32) -> Option<[T; C]> {
        if E::TRANSPARENT && outside(origin[0] + floor(u), origin[1] + floor(v), self.size) {
            return None;
        }
        // Half a texel is exact in f32: offsets are below 2⁷.
        let (u, v) = (u - 0.5, v - 0.5);
        let (i, j) = (floor(u), floor(v));
        let (fu, fv) = (u - i as f32, v - j as f32);
        let (i, j) = (origin[0] + i, origin[1] + j);
        let at = |i, j| texel(&self.view, self.edge, self.size, self.constant, i, j);
        let [a, b, c, d] = if i >= 0 && j >= 0 && i + 1 < self.size[0] && j + 1 < self.size[1] {
            let (x, y) = (i as usize, j as usize);
            let inner = |x, y| self.view.pixel(x, y).unwrap_or(self.constant);
            [inner(x, y), inner(x + 1, y), inner(x, y + 1), inner(x + 1, y + 1)]
        } else {
            [at(i, j), at(i + 1, j), at(i, j + 1), at(i + 1, j + 1)]
        };
        Some(core::array::from_fn(|k| {
            let top = a[k].to_f32() + fu * (b[k].to_f32() - a[k].to_f32());
            let bottom = c[k].to_f32() + fu * (d[k].to_f32() - c[k].to_f32());
            T::from_f32(top + fv * (bottom - top))
        }))
    }
}

fn visit_with<T: Sample, const C: usize>(
    lookup: &impl Lookup<T, C>,
    coords: &RowCoords,
    visit: &mut impl Visit<T, C>,
) {
    for run in coords.runs() {
        let (u, v) = coords.offsets(run);
        for ((x, &u), &v) in run.pixels().zip(u).zip(v) {
            if visit.wants(x)
                && let Some(value) = lookup.value(run.origin, u, v)
            {
                visit.paint(x, value);
            }
        }
    }
}

/// The constant of a border in the picture's own samples.
pub(super) fn constant<T: Sample, const C: usize>(border: Border) -> [T; C] {
    match border {
        Border::Constant(value) => {
            core::array::from_fn(|k| T::from_f32(value.get(k).copied().unwrap_or(0.0)))
        }
        _ => [T::default(); C],
    }
}

/// The position has no value in a picture without pixels.
pub(crate) struct Nothing;

/// Looks up every pixel of a row and hands the values to `visit`. The filter and the border are chosen once a row.
///
/// # Errors
/// [`Nothing`] for a picture without pixels.
pub(crate) fn visit_row<T: Sample, const C: usize>(
    view: ImageView<'_, T, C>,
    filter: Filter,
    border: Border,
    coords: &RowCoords,
    visit: &mut impl Visit<T, C>,
) -> Result<(), Nothing> {
    if view.width() == 0 || view.height() == 0 {
        return Err(Nothing);
    }
    let size = [view.width() as i32, view.height() as i32];
    let constant = constant(border);
    macro_rules! with {
        ($edge:expr) => {
            match filter {
                Filter::Nearest => {
                    visit_with(&Nearest { view, size, constant, edge: $edge }, coords, visit);
                }
                Filter::Bilinear => {
                    visit_with(&Bilinear { view, size, constant, edge: $edge }, coords, visit);
                }
            }
        };
    }
    match border {
        Border::Transparent => with!(Transparent),
        Border::Constant(_) => with!(Constant),
        Border::Clamp => with!(Clamp),
        Border::Repeat => with!(Repeat),
        Border::Mirror => with!(Mirror),
    }
    Ok(())
}

/// The value of a picture at one position, in pixels from its top-left corner; `None` outside a transparent border, for
/// NaN, and in a picture without pixels.
///
/// ```
/// use collinear::nalgebra::Point2;
/// use collinear::resample::{Border, Filter, ImageView, sample};
///
/// // Texel centres lie at 0.5 and 1.5: a quarter of the way between them is 10 + 0.25 · 80.
/// let view = ImageView::<u8, 1>::new(&[10, 90], 2, 1)?;
/// assert_eq!(sample(view, &Point2::new(0.75, 0.5), Filter::Bilinear, Border::Clamp), Some([30]));
/// assert_eq!(sample(view, &Point2::new(2.0, 0.5), Filter::Nearest, Border::Transparent), None);
/// # Ok::<(), collinear::Error>(())
/// ```
#[must_use]
pub fn sample<T: Sample, const C: usize>(
    view: ImageView<'_, T, C>,
    position: &Point2<f64>,
    filter: Filter,
    border: Border,
) -> Option<[T; C]> {
    sample_with(view, position, filter, border, &mut RowCoords::new())
}

/// As [`sample`], with the memory of a row to work in.
pub(crate) fn sample_with<T: Sample, const C: usize>(
    view: ImageView<'_, T, C>,
    position: &Point2<f64>,
    filter: Filter,
    border: Border,
    coords: &mut RowCoords,
) -> Option<[T; C]> {
    struct One<P>(Option<P>);
    impl<T, const C: usize> Visit<T, C> for One<[T; C]> {
        fn wants(&mut self, _: i32) -> bool {
            true
        }
        fn paint(&mut self, _: i32, value: [T; C]) {
            self.0 = Some(value);
        }
    }
    coords.clear();
    coords.push(0, position.x, position.y);
    let mut one = One(None);
    visit_row(view, filter, border, coords, &mut one).ok()?;
    one.0
}
