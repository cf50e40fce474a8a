//! Texture coordinates of one row of pixels, in single precision without its loss.

use alloc::vec::Vec;
use core::ops::Range;

/// Neighbouring pixels whose texture coordinates share one integer origin.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Run {
    /// The first pixel's x.
    pub x: i32,
    /// Where the run's offsets begin in [`RowCoords::offsets`].
    start: usize,
    /// How many pixels.
    len: usize,
    /// The integer texel that the offsets count from.
    pub origin: [i32; 2],
}

impl Run {
    /// The pixels of the run.
    #[must_use]
    pub fn pixels(&self) -> Range<i32> {
        self.x..self.x + self.len as i32
    }

    /// The number of pixels, at least one.
    #[must_use]
    #[allow(clippy::len_without_is_empty, reason = "a run is never empty")]
    pub fn len(&self) -> usize {
        self.len
    }
}

/// The texture coordinates of one row: u = origin + offset, with integer origins and `f32` offsets.
///
/// A float of 24 bits places a texel of a 65,535-pixel image to 1/256. Here the integer part is split off in `f64`: the
/// origin is the multiple of [`BLOCK`](Self::BLOCK) nearest to the coordinate, so the offset stays within ±65 texels
/// and is exact to 2⁻¹⁸ texel wherever in the image it lies. A pixel's origin and offset depend on its own coordinates
/// alone, not on where its row was cut.
///
/// ```
/// use collinear::mapping::RowCoords;
///
/// let mut row = RowCoords::new();
/// row.push(10, 65_000.25, 40_000.75);
/// let run = row.runs()[0];
/// let (u, v) = row.offsets(&run);
/// assert_eq!((f64::from(run.origin[0]) + f64::from(u[0])), 65_000.25);
/// assert_eq!((f64::from(run.origin[1]) + f64::from(v[0])), 40_000.75);
/// ```
#[derive(Clone, Debug, Default)]
pub struct RowCoords {
    runs: Vec<Run>,
    u: Vec<f32>,
    v: Vec<f32>,
}

impl RowCoords {
    /// The spacing of run origins, in texels.
    pub const BLOCK: i32 = 128;
    /// The largest magnitude of a texture coordinate; pixels beyond are left out of every run.
    pub const COORDINATE_LIMIT: f64 = 1_073_741_824.0;

    /// An empty row.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// Forgets all runs and keeps the memory.
    pub fn clear(&mut self) {
        self.runs.clear();
        self.u.clear();
        self.v.clear();
    }

    /// The runs, ascending in x and disjoint.
    #[must_use]
    pub fn runs(&self) -> &[Run] {
        &self.runs
    }

    /// The offsets (u, v) of a run's pixels from its origin, in texels.
    #[must_use]
    pub fn offsets(&self, run: &Run) -> (&[f32], &[f32]) {
        let range = run.start..run.start + run.len;
        (&self.u[range.clone()], &self.v[range])
    }

    /// Appends the pixel `x`, right of all before it. Coordinates that are NaN or beyond
    /// [`COORDINATE_LIMIT`](Self::COORDINATE_LIMIT) leave the pixel out, and so does the last x there is, which no range
    /// of `i32` can end behind.
    #[inline]
    pub fn push(&mut self, x: i32, u: f64, v: f64) {
        let limit = Self::COORDINATE_LIMIT;
        if !(u.abs() <= limit && v.abs() <= limit) || x == i32::MAX {
            return;
        }
        let origin = [Self::origin(u), Self::origin(v)];
        match self.runs.last_mut() {
            Some(run) if run.origin == origin && run.x + run.len as i32 == x => run.len += 1,
            _ => self.runs.push(Run { x, start: self.u.len(), len: 1, origin }),
        }
        self.u.push((u - f64::from(origin[0])) as f32);
        self.v.push((v - f64::from(origin[1])) as f32);
    }

    /// Appends the neighbouring pixels from `x` on; as [`push`](Self::push) for each.
    #[inline]
    pub fn push_block(&mut self, x: i32, u: &[f64], v: &[f64]) {
        let (Some(&u0), Some(&v0)) = (u.first(), v.first()) else { return };
        let origin = [Self::origin(u0), Self::origin(v0)];
        let limit = Self::COORDINATE_LIMIT;
        let one_origin = |values: &[f64], origin: i32| {
            values.iter().all(|&c| c.abs() <= limit && Self::origin(c) == origin)
        };
        let fits = i32::try_from(u.len()).is_ok_and(|len| x.checked_add(len).is_some());
        if !(fits && u.len() == v.len() && one_origin(u, origin[0]) && one_origin(v, origin[1])) {
            for (x, (&u, &v)) in (x..i32::MAX).zip(u.iter().zip(v)) {
                self.push(x, u, v);
            }
            return;
        }
        match self.runs.last_mut() {
            Some(run) if run.origin == origin && run.x + run.len as i32 == x => run.len += u.len(),
            _ => self.runs.push(Run { x, start: self.u.len(), len: u.len(), origin }),
        }
        let [ou, ov] = origin.map(f64::from);
        self.u.extend(u.iter().map(|u| (u - ou) as f32));
        self.v.extend(v.iter().map(|v| (v - ov) as f32));
    }

    /// The multiple of [`BLOCK`](Self::BLOCK) nearest to a coordinate (to within one texel, as the cast truncates).
    #[inline]
    fn origin(coordinate: f64) -> i32 {
        (coordinate as i32).wrapping_add(Self::BLOCK / 2) & !(Self::BLOCK - 1)
    }
}
