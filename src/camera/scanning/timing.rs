//! When each pixel of a scan is exposed.

use nalgebra::{Point2, Vector2};

use crate::error::Error;

/// When the pixels of a scan are exposed: a linear function of the image point, over an interval.
///
/// ```text
/// t(x, y) = start + x · per_column + y · per_line,      first ≤ t ≤ last
/// ```
///
/// The unit is that of the trajectory: seconds, or lines where `per_line` is 1. x and y are continuous image
/// coordinates, so the centre of the first pixel is exposed at t(0.5, 0.5). Outside the interval nothing is looked for.
///
/// # Precision
/// Times are `f64`: a line of 10⁻⁴ s has nanolines only where |t| stays below some 450 s. Count from an epoch near the scan; one
/// that is too far off is refused.
///
/// # Example
/// Landsat's multispectral scanner swept 6 lines in 73.42 ms, so the line whose middle is y = 1000.5 is reached after
/// 12.2428 s.
///
/// ```
/// use collinear::camera::ScanTime;
/// use nalgebra::Point2;
///
/// let timing = ScanTime::by_line(0.0, 73.42e-3 / 6.0, [0.0, 2340.0])?;
/// assert!((timing.at(&Point2::new(1600.0, 1000.5)) - 12.242785).abs() < 1e-12);
/// # Ok::<(), collinear::Error>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[doc(alias("line rate", "readout time", "rolling shutter time"))]
pub struct ScanTime {
    start: f64,
    per_pixel: Vector2<f64>,
    interval: [f64; 2],
}

/// The spacing of floats near `t`.
fn spacing(t: f64) -> f64 {
    f64::EPSILON * t.abs()
}

impl ScanTime {
    /// One time a line, for y from `lines[0]` to `lines[1]`: pushbroom, strip, rolling shutter.
    ///
    /// # Errors
    /// [`Error::NotFinite`]; [`Error::OutOfRange`] for a line that takes no time, an empty interval, or an epoch so far off that
    /// floats cannot tell 10⁻⁹ lines.
    pub fn by_line(start: f64, per_line: f64, lines: [f64; 2]) -> Result<Self, Error> {
        Self::by_pixel(start, 0.0, per_line, [[0.0, 0.0], lines])
    }

    /// One time a column, for x from `columns[0]` to `columns[1]`: panoramic cameras.
    ///
    /// # Errors
    /// As [`by_line`](Self::by_line).
    pub fn by_column(start: f64, per_column: f64, columns: [f64; 2]) -> Result<Self, Error> {
        Self::by_pixel(start, per_column, 0.0, [columns, [0.0, 0.0]])
    }

    /// One time a pixel, for x and y of the rectangle `[columns, lines]`: whiskbroom scanners.
    ///
    /// # Errors
    /// As [`by_line`](Self::by_line).
    pub fn by_pixel(
        start: f64,
        per_column: f64,
        per_line: f64,
        [columns, lines]: [[f64; 2]; 2],
    ) -> Result<Self, Error> {
        let ends = [columns[0], columns[1], lines[0], lines[1], start, per_column, per_line];
        if !ends.iter().all(|v| v.is_finite()) {
            return Err(Error::NotFinite { what: "scan time" });
        }
        let (mut first, mut last) = (f64::INFINITY, f64::NEG_INFINITY);
        for x in columns {
            for y in lines {
                let t = start + x * per_column + y * per_line;
                (first, last) = (first.min(t), last.max(t));
            }
        }
        let timing =
            Self { start, per_pixel: Vector2::new(per_column, per_line), interval: [first, last] };
        let expected = "an interval of some time";
        if !(last > first && (last - first).is_finite()) {
            return Err(Error::OutOfRange { what: "scan time", value: last - first, expected });
        }
        let coarse = spacing(first.abs().max(last.abs()).max(start.abs()));
        if coarse > 1e-9 * timing.unit() {
            return Err(Error::OutOfRange {
                what: "spacing of floats in lines of the scan",
                value: coarse / timing.unit(),
                expected: "at most 1e-9: count the time from an epoch near the scan",
            });
        }
        Ok(timing)
    }

    /// t of an image point.
    #[must_use]
    pub fn at(&self, image: &Point2<f64>) -> f64 {
        self.start + self.per_pixel.dot(&image.coords)
    }

    /// First and last time.
    #[must_use]
    pub fn interval(&self) -> [f64; 2] {
        self.interval
    }

    /// ∂t/∂(x, y): the times of a column and of a line.
    #[must_use]
    pub fn per_pixel(&self) -> Vector2<f64> {
        self.per_pixel
    }

    /// y of the column `x` at time `t`, where a line takes some time.
    pub(super) fn line(&self, t: f64, x: f64) -> f64 {
        ((t - self.start) - self.per_pixel.x * x) / self.per_pixel.y
    }

    /// t − t(image).
    pub(super) fn lag(&self, t: f64, image: &Point2<f64>) -> f64 {
        (t - self.start) - self.per_pixel.dot(&image.coords)
    }

    /// The time of a line, or of a column where lines take none.
    pub(super) fn unit(&self) -> f64 {
        if self.per_pixel.y == 0.0 { self.per_pixel.x.abs() } else { self.per_pixel.y.abs() }
    }
}
