//! Maps stored pixel by pixel, as other programs read and write them.

use alloc::vec::Vec;
use core::ops::Range;

use nalgebra::{Matrix2, Point2};

use super::blocks::Gather;
use super::{BlockSink, Map};
use crate::error::{Error, ProjectionError};

/// A map stored for each pixel of a screen: what `cv2.remap` and fragment shaders read.
///
/// | exchange | a pixel's value | origin |
/// | --- | --- | --- |
/// | [`from_opencv`](Self::from_opencv), [`opencv_maps`](Self::opencv_maps) | (u − ½, v − ½) in texels, `f32` | centre of the first texel |
/// | [`from_texture_coordinates`](Self::from_texture_coordinates), [`texture_coordinates`](Self::texture_coordinates) | (u / W, v / H) or (u / W, 1 − v / H), `f32` | [`TextureOrigin`] |
///
/// NaN stands for a pixel that shows nothing.
///
/// *Precision.* Values are kept as OpenCV's, in `f32`: they are rounded by at most 2⁻²⁵ of the next greater power of two, 1/16,384 texel
/// up to 1,024 texels, 1/2,048 up to 8,192, and **1/512 texel up to 65,536**. Texture coordinates round once more, by as much. [`RowCoords`](super::RowCoords) has no such loss.
///
/// *Domain.* The screen's pixels' centres and what lies between them: there coordinates are interpolated bilinearly.
/// *Cost.* Two loads a pixel, 8 bytes of memory.
///
/// # Example
/// ```
/// use collinear::geometry::Affine2;
/// use collinear::mapping::{LookupTable, Map, TextureOrigin};
/// use nalgebra::Point2;
///
/// // u = 2S, v = L + 3, of two pixels in one row.
/// let map = Affine2::from_coefficients([0.0, 2.0, 0.0], [3.0, 0.0, 1.0]);
/// let table = LookupTable::from_map(&map, 2, 1)?;
/// // Pixel 0 is asked at (½, ½), and finds (1, 3½): in OpenCV's terms (½, 3).
/// assert_eq!(table.opencv_maps(), (&[0.5, 2.5][..], &[3.0, 3.0][..]));
/// assert_eq!(table.at(&Point2::new(1.0, 0.5))?, Point2::new(2.0, 3.5));
/// // In a texture of 4 × 14 texels, v upwards.
/// let gpu = table.texture_coordinates([4, 14], TextureOrigin::BottomLeft)?;
/// assert_eq!(gpu, [[0.25, 0.75], [0.75, 0.75]]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
#[doc(alias("remap", "initUndistortRectifyMap", "ST map", "UV map", "STMap"))]
pub struct LookupTable {
    width: usize,
    height: usize,
    /// u − ½ and v − ½.
    x: Vec<f32>,
    y: Vec<f32>,
}

/// Where texture coordinates begin, and which way v goes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TextureOrigin {
    /// v downwards from the upper left corner: Direct3D, Vulkan, Metal, WebGPU.
    TopLeft,
    /// v upwards from the lower left corner: OpenGL, and what compositors call an ST map.
    BottomLeft,
}

impl TextureOrigin {
    /// The share of the height, counted from the other end where it goes upwards; its own inverse.
    fn turn(self, share: f64) -> f64 {
        match self {
            Self::TopLeft => share,
            Self::BottomLeft => 1.0 - share,
        }
    }
}

/// From OpenCV's coordinates, whose texel centres are integers.
const CENTRE: f64 = 0.5;

fn sides(size: [u32; 2]) -> Result<[f64; 2], Error> {
    if size.contains(&0) {
        let expected = "at least one texel";
        return Err(Error::OutOfRange { what: "side of a texture", value: 0.0, expected });
    }
    Ok(size.map(f64::from))
}

impl LookupTable {
    /// All pixels without a value.
    fn empty(width: u32, height: u32) -> Result<Self, Error> {
        let what = "pixels of a lookup table";
        let too_many = || Error::OutOfRange {
            what,
            value: f64::from(width) * f64::from(height),
            expected: "as many as memory holds",
        };
        let (width_, height_) = (width as usize, height as usize);
        let (Ok(_), Ok(_)) = (i32::try_from(width), i32::try_from(height)) else {
            return Err(too_many());
        };
        let size = width_.checked_mul(height_).ok_or_else(too_many)?;
        let column = || -> Result<Vec<f32>, Error> {
            let mut values = Vec::new();
            values.try_reserve_exact(size).map_err(|_| too_many())?;
            values.resize(size, f32::NAN);
            Ok(values)
        };
        Ok(Self { width: width_, height: height_, x: column()?, y: column()? })
    }

    /// The values of a map at the centres of the pixels of a screen.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] where there is no memory for so many pixels.
    pub fn from_map(map: &dyn Map, width: u32, height: u32) -> Result<Self, Error> {
        let mut table = Self::empty(width, height)?;
        for line in 0..height as i32 {
            let start = line as usize * table.width;
            let range = start..start + table.width;
            let (row_x, row_y) = (&mut table.x[range.clone()], &mut table.y[range]);
            map.blocks(line, 0..width as i32, &mut |first, u, v| {
                for (i, (u, v)) in (i64::from(first)..).zip(u.iter().zip(v)) {
                    let i = usize::try_from(i).unwrap_or(usize::MAX);
                    if let (Some(x), Some(y)) = (row_x.get_mut(i), row_y.get_mut(i)) {
                        *x = (u - CENTRE) as f32;
                        *y = (v - CENTRE) as f32;
                    }
                }
            });
        }
        table.forget_infinite();
        Ok(table)
    }

    /// From the maps that `cv2.remap` takes, row by row. Values that are not finite are pixels that show nothing.
    ///
    /// # Errors
    /// [`Error::LengthMismatch`] where a map has another number of pixels than width times height, [`Error::OutOfRange`] where there
    /// is no memory for so many.
    pub fn from_opencv(width: u32, height: u32, x: &[f32], y: &[f32]) -> Result<Self, Error> {
        let size = u64::from(width) * u64::from(height);
        for map in [x, y] {
            if map.len() as u64 != size {
                let what = "pixels of a lookup table and values";
                return Err(Error::LengthMismatch { what, left: size as usize, right: map.len() });
            }
        }
        let mut table = Self::empty(width, height)?;
        table.x.copy_from_slice(x);
        table.y.copy_from_slice(y);
        table.forget_infinite();
        Ok(table)
    }

    /// From texture coordinates of a texture of `size` texels, row by row. Values that are not finite are pixels that show
    /// nothing.
    ///
    /// # Errors
    /// As [`from_opencv`](Self::from_opencv), and [`Error::OutOfRange`] for a texture without texels.
    pub fn from_texture_coordinates(
        width: u32,
        height: u32,
        coordinates: &[[f32; 2]],
        size: [u32; 2],
        origin: TextureOrigin,
    ) -> Result<Self, Error> {
        let [w, h] = sides(size)?;
        let texels = |share: f64, side: f64| (share * side - CENTRE) as f32;
        let x: Vec<f32> = coordinates.iter().map(|c| texels(f64::from(c[0]), w)).collect();
        let y: Vec<f32> =
            coordinates.iter().map(|c| texels(origin.turn(f64::from(c[1])), h)).collect();
        Self::from_opencv(width, height, &x, &y)
    }

    /// A pixel has both coordinates or none.
    fn forget_infinite(&mut self) {
        for (x, y) in self.x.iter_mut().zip(&mut self.y) {
            if !(x.is_finite() && y.is_finite()) {
                (*x, *y) = (f32::NAN, f32::NAN);
            }
        }
    }

    /// Pixels of a row, and rows.
    #[must_use]
    pub fn size(&self) -> [u32; 2] {
        [self.width as u32, self.height as u32]
    }

    /// The maps for `cv2.remap`: x and y, row by row, with integers at texels' centres and NaN where a pixel shows nothing.
    ///
    /// OpenCV does not say what it paints at NaN: put a value outside the image there for its border.
    #[must_use]
    pub fn opencv_maps(&self) -> (&[f32], &[f32]) {
        (&self.x, &self.y)
    }

    /// Texture coordinates for a texture of `size` texels, row by row: 0 to 1 from border to border, NaN where a pixel shows
    /// nothing.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] for a texture without texels.
    pub fn texture_coordinates(
        &self,
        size: [u32; 2],
        origin: TextureOrigin,
    ) -> Result<Vec<[f32; 2]>, Error> {
        let [w, h] = sides(size)?;
        let share = |c: f32, side: f64| (f64::from(c) + CENTRE) / side;
        let pair = |(x, y): (&f32, &f32)| [share(*x, w) as f32, origin.turn(share(*y, h)) as f32];
        Ok(self.x.iter().zip(&self.y).map(pair).collect())
    }

    /// The value of a pixel.
    fn pixel(&self, x: usize, y: usize) -> Option<Point2<f64>> {
        let i = y * self.width + x;
        let point = Point2::new(f64::from(self.x[i]) + CENTRE, f64::from(self.y[i]) + CENTRE);
        (!point.x.is_nan()).then_some(point)
    }

    /// The four pixels about a point, upper left, upper right, lower left, lower right, and its shares of the way between them.
    fn around(&self, p: &Point2<f64>) -> Result<([Point2<f64>; 4], [f64; 2]), ProjectionError> {
        let axis = |c: f64, n: usize| {
            let (along, last) = (c - CENTRE, n as f64 - 1.0);
            if along.is_nan() {
                return Err(ProjectionError::NotFinite);
            }
            if !(along >= 0.0 && along <= last) {
                let value = (-along).max(along - last);
                return Err(ProjectionError::OutsideDomain { value, limit: 0.0 });
            }
            let index = along as usize;
            Ok((index, along - index as f64))
        };
        let ((i, s), (j, t)) = (axis(p.x, self.width)?, axis(p.y, self.height)?);
        // A pixel without a share need not be there.
        let (right, below) = (i + usize::from(s > 0.0), j + usize::from(t > 0.0));
        let mut found = [Point2::origin(); 4];
        for (place, (x, y)) in
            found.iter_mut().zip([(i, j), (right, j), (i, below), (right, below)])
        {
            *place = self
                .pixel(x, y)
                .ok_or(ProjectionError::OutsideDomain { value: 0.0, limit: 0.0 })?;
        }
        Ok((found, [s, t]))
    }
}

impl Map for LookupTable {
    /// [`ProjectionError::OutsideDomain`] beyond the outermost centres, with the distance and the limit zero; and beside a
    /// pixel that shows nothing, with twice zero.
    fn at(&self, screen: &Point2<f64>) -> Result<Point2<f64>, ProjectionError> {
        let ([a, b, c, d], [s, t]) = self.around(screen)?;
        let (above, below) = (a + (b - a) * s, c + (d - c) * s);
        Ok(above + (below - above) * t)
    }

    /// That of the interpolation; at a pixel's centre, of the four pixels to the right and below (of the last ones, to the
    /// left and above).
    fn jacobian(&self, screen: &Point2<f64>) -> Result<Matrix2<f64>, ProjectionError> {
        self.around(screen)?;
        let start = |c: f64, n: usize| ((c - CENTRE) as usize).min(n.saturating_sub(2));
        let (i, j) = (start(screen.x, self.width), start(screen.y, self.height));
        let (s, t) = (screen.x - CENTRE - i as f64, screen.y - CENTRE - j as f64);
        let none = ProjectionError::OutsideDomain { value: 0.0, limit: 0.0 };
        let pixel = |x: usize, y: usize| {
            if x < self.width && y < self.height { self.pixel(x, y).ok_or(none) } else { Err(none) }
        };
        let (a, b) = (pixel(i, j)?, pixel(i + 1, j)?);
        let (c, d) = (pixel(i, j + 1)?, pixel(i + 1, j + 1)?);
        let by_x = (b - a) * (1.0 - t) + (d - c) * t;
        let by_y = (c - a) * (1.0 - s) + (d - b) * s;
        Ok(Matrix2::from_columns(&[by_x, by_y]))
    }

    fn blocks(&self, line: i32, samples: Range<i32>, emit: &mut BlockSink<'_>) {
        let Ok(y) = usize::try_from(line) else { return };
        if y >= self.height {
            return;
        }
        let width = self.width as i32;
        let (start, end) = (samples.start.clamp(0, width), samples.end.clamp(0, width));
        let place = y * self.width;
        let (row_x, row_y) = (&self.x[place..][..self.width], &self.y[place..][..self.width]);
        let mut row = Gather::new(emit);
        let mut x = start;
        while x < end {
            let shown = row_x[x as usize..end as usize].iter().take_while(|c| !c.is_nan()).count();
            let stop = x + shown as i32;
            row.run(x..stop, |first, u, v| {
                let first = first as usize;
                for (u, x) in u.iter_mut().zip(&row_x[first..]) {
                    *u = f64::from(*x) + CENTRE;
                }
                for (v, y) in v.iter_mut().zip(&row_y[first..]) {
                    *v = f64::from(*y) + CENTRE;
                }
            });
            // The one that ended the stretch shows nothing.
            x = stop + 1;
        }
        row.flush();
    }
}
