//! The screen: colours and depth.

use alloc::vec;
use alloc::vec::Vec;

use super::polygon::ScreenPolygon;
use super::scan::PixelSpan;
use crate::error::Error;
use crate::mapping::{Map, RowCoords};
use crate::resample::{Border, Filter, ImageView, ImageViewMut, Sample, Visit, visit_row};

/// What a polygon is painted with.
///
/// # Example
/// A picture of two pixels laid over a row of four: the map halves x, and the nearest texel of 0.25, 0.75, 1.25, 1.75 is
/// the first, the first, the second, the second.
///
/// ```
/// use collinear::camera::{ExteriorOrientation, Orthographic};
/// use collinear::geometry::Affine2;
/// use collinear::resample::{Border, Filter, ImageView, ImageViewMut};
/// use collinear::texturer::{Canvas, Paint, ScreenPolygon};
/// use nalgebra::{Point3, Rotation3};
///
/// let flat = ExteriorOrientation::new(Point3::origin(), Rotation3::identity());
/// let screen = Orthographic::new(flat, Affine2::identity())?.homogeneous();
/// let strip = [(0.0, 0.0), (4.0, 0.0), (4.0, 1.0), (0.0, 1.0)].map(|(x, y)| Point3::new(x, y, 1.0));
/// let halved = Affine2::from_coefficients([0.0, 0.5, 0.0], [0.0, 0.0, 1.0]);
/// let paint = Paint::Texture {
///     image: ImageView::<u8, 1>::new(&[7, 9], 2, 1)?,
///     map: &halved,
///     filter: Filter::Nearest,
///     border: Border::Transparent,
/// };
/// let mut pixels = [0u8; 4];
/// let mut canvas = Canvas::new(ImageViewMut::<u8, 1>::new(&mut pixels, 4, 1)?);
/// canvas.draw(&ScreenPolygon::project(&strip, &screen, 0.1)?, [1.0, 0.0, 0.0], &paint)?;
/// assert_eq!(pixels, [7, 7, 9, 9]);
/// # Ok::<(), collinear::Error>(())
/// ```
#[derive(Clone, Copy, Debug)]
pub enum Paint<'a, T, const C: usize> {
    /// One value.
    Flat([T; C]),
    /// A picture through a map from the screen.
    Texture {
        /// The picture.
        image: ImageView<'a, T, C>,
        /// Texture from screen.
        map: &'a dyn Map,
        /// How values are taken between texel centres.
        filter: Filter,
        /// What lies beyond the picture. Where a transparent border or the map gives nothing, the pixel stays as it was,
        /// colour and depth.
        border: Border,
    },
}

/// A picture being drawn, with the nearness of what is in each pixel.
///
/// Nearness is a number that is larger for nearer points and linear on the screen over a plane
/// ([`HomogeneousCamera::nearness`](crate::camera::HomogeneousCamera::nearness)): the inverse depth for a perspective
/// screen (\[WD\] after Fuchs et al. 1985). It is kept as `f32`; a pixel is painted if it is strictly nearer than what is
/// there, so of two equal ones the first stays.
///
/// # Example
/// A square of four pixels at depth 5 hides one at depth 9, in whichever order they are drawn:
///
/// ```
/// use collinear::camera::{ExteriorOrientation, Orthographic};
/// use collinear::geometry::{Affine2, Plane};
/// use collinear::resample::ImageViewMut;
/// use collinear::texturer::{Canvas, Paint, ScreenPolygon};
/// use nalgebra::{Point3, Rotation3};
///
/// let flat = ExteriorOrientation::new(Point3::origin(), Rotation3::identity());
/// let screen = Orthographic::new(flat, Affine2::identity())?.homogeneous();
/// let mut pixels = [0u8; 16];
/// let mut canvas = Canvas::new(ImageViewMut::<u8, 1>::new(&mut pixels, 4, 4)?);
/// for depth in [5.0, 9.0] {
///     let square = [(1.0, 1.0), (3.0, 1.0), (3.0, 3.0), (1.0, 3.0)].map(|(x, y)| Point3::new(x, y, depth));
///     let polygon = ScreenPolygon::project(&square, &screen, 0.1)?;
///     let nearness = screen.nearness(&Plane::fit(&square)?.plane)?;
///     canvas.draw(&polygon, nearness, &Paint::Flat([depth as u8]))?;
/// }
/// assert_eq!(canvas.nearness(1, 1), Some(-5.0)); // −Z′ for a parallel screen
/// assert_eq!(pixels, [0, 0, 0, 0, 0, 5, 5, 0, 0, 5, 5, 0, 0, 0, 0, 0]);
/// # Ok::<(), collinear::Error>(())
/// ```
#[derive(Debug)]
#[doc(alias("framebuffer", "z-buffer", "depth buffer"))]
pub struct Canvas<'a, T, const C: usize> {
    color: ImageViewMut<'a, T, C>,
    nearness: Vec<f32>,
    coords: RowCoords,
}

/// Paints pixels of one row that pass the depth test.
struct DepthTested<'a, T> {
    color: &'a mut [T],
    nearness: &'a mut [f32],
    slope: f64,
    constant: f64,
    candidate: f32,
}

impl<T> DepthTested<'_, T> {
    #[inline]
    fn nearness_at(&self, x: i32) -> f32 {
        (self.slope * (f64::from(x) + 0.5) + self.constant) as f32
    }
}

impl<T: Sample, const C: usize> Visit<T, C> for DepthTested<'_, T> {
    #[inline]
    fn wants(&mut self, x: i32) -> bool {
        self.candidate = self.nearness_at(x);
        self.nearness.get(x as usize).is_some_and(|&n| self.candidate > n)
    }

    #[inline]
    fn paint(&mut self, x: i32, value: [T; C]) {
        let x = x as usize;
        if let (Some(pixel), Some(nearness)) =
            (self.color.get_mut(x * C..x * C + C), self.nearness.get_mut(x))
        {
            pixel.copy_from_slice(&value);
            *nearness = self.candidate;
        }
    }
}

impl<'a, T: Sample, const C: usize> Canvas<'a, T, C> {
    /// A canvas over a picture, which keeps its colours; nothing is near.
    #[must_use]
    pub fn new(color: ImageViewMut<'a, T, C>) -> Self {
        let nearness = vec![f32::NEG_INFINITY; color.width() * color.height()];
        Self { color, nearness, coords: RowCoords::new() }
    }

    /// Width in pixels.
    #[must_use]
    pub fn width(&self) -> usize {
        self.color.width()
    }

    /// Height in pixels.
    #[must_use]
    pub fn height(&self) -> usize {
        self.color.height()
    }

    /// The nearness of what is in a pixel; `None` outside the picture and where nothing was painted.
    #[must_use]
    pub fn nearness(&self, x: usize, y: usize) -> Option<f32> {
        if x >= self.width() || y >= self.height() {
            return None;
        }
        self.nearness.get(y * self.width() + x).copied().filter(|n| *n != f32::NEG_INFINITY)
    }

    /// Draws a polygon. `nearness` are the coefficients (N₀, N₁, N₂) of its plane's nearness over (1, S, L).
    ///
    /// # Errors
    /// [`Error::NotFinite`] for nearness coefficients that are not numbers.
    pub fn draw(
        &mut self,
        polygon: &ScreenPolygon,
        nearness: [f64; 3],
        paint: &Paint<'_, T, C>,
    ) -> Result<(), Error> {
        if !nearness.iter().all(|n| n.is_finite()) {
            return Err(Error::NotFinite { what: "nearness coefficient" });
        }
        let (width, height) = (self.width(), self.height());
        polygon.spans(width, height, |span| self.fill(&span, nearness, paint));
        Ok(())
    }

    fn fill(&mut self, span: &PixelSpan, [n0, n1, n2]: [f64; 3], paint: &Paint<'_, T, C>) {
        let y = span.y as usize;
        let width = self.color.width();
        let line = f64::from(span.y) + 0.5;
        let mut row = DepthTested {
            color: self.color.row_mut(y),
            nearness: self.nearness.get_mut(y * width..(y + 1) * width).unwrap_or_default(),
            slope: n1,
            constant: n2 * line + n0,
            candidate: 0.0,
        };
        match *paint {
            Paint::Flat(value) => {
                for x in span.x.clone() {
                    if Visit::<T, C>::wants(&mut row, x) {
                        row.paint(x, value);
                    }
                }
            }
            Paint::Texture { image, map, filter, border } => {
                map.row(span.y, span.x.clone(), &mut self.coords);
                // An empty picture paints nothing.
                let _ = visit_row(image, filter, border, &self.coords, &mut row);
            }
        }
    }
}
