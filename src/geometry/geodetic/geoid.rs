//! Grids of geoid undulations.

use alloc::vec::Vec;

use super::position::{EllipsoidalHeight, Geodetic, OrthometricHeight};
use crate::error::Error;
use crate::numeric::float;

/// Where the nodes of a geoid grid lie, in degrees, as the files state it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GeoidLayout {
    /// Latitude of the first row, in degrees.
    pub south_deg: f64,
    /// Longitude of the first column, in degrees.
    pub west_deg: f64,
    /// From one row to the next one north, in degrees.
    pub latitude_step_deg: f64,
    /// From one column to the next one east, in degrees.
    pub longitude_step_deg: f64,
    /// Number of rows, two at least.
    pub rows: usize,
    /// Number of columns, two at least.
    pub columns: usize,
}

/// How undulations between the nodes are found.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum GeoidInterpolation {
    /// From the 2 × 2 nodes around the point, as PROJ and GDAL do.
    Bilinear,
    /// By the cubic polynomials through the 4 × 4 nodes around the point; at an edge, through the four nodes next to it.
    /// A grid with fewer rows or columns has parabolas or lines instead.
    #[default]
    Bicubic,
}

/// The geoid above an ellipsoid: a regular grid of undulations over latitude and longitude.
///
/// ```text
/// h = H + N        ellipsoidal height = orthometric height + undulation
/// ```
///
/// Rows run from south to north, columns eastward; the longitudes wrap around where the columns span 360°. Nodes that
/// are NaN are void.
///
/// *Accuracy*: of the interpolation, at NGA's six test points for EGM96 on its 15′ grid: bilinear within 56 mm, bicubic
/// within 9 mm.
///
/// ```
/// use collinear::geometry::geodetic::{
///     EllipsoidalHeight, Geodetic, GeoidGrid, GeoidLayout, OrthometricHeight,
/// };
///
/// let layout = GeoidLayout {
///     south_deg: 44.0,
///     west_deg: 5.0,
///     latitude_step_deg: 1.0,
///     longitude_step_deg: 1.0,
///     rows: 2,
///     columns: 2,
/// };
/// // Half-way between 50, 52 (south) and 51, 53 (north).
/// let grid = GeoidGrid::new(layout, vec![50.0, 52.0, 51.0, 53.0])?;
/// let place = Geodetic::from_degrees(44.5, 5.5, EllipsoidalHeight(1051.5))?;
/// let OrthometricHeight(height) = grid.orthometric(&place)?;
/// assert!((height - 1000.0).abs() < 1e-12);
/// # Ok::<(), collinear::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
#[doc(alias("vertical datum", "EGM96", "EGM2008"))]
pub struct GeoidGrid {
    layout: GeoidLayout,
    undulations: Vec<f32>,
    /// The number of columns in 360°, where they wrap around.
    period: Option<usize>,
    interpolation: GeoidInterpolation,
}

/// How far, in steps, a place may lie outside the outermost nodes and count as on them: the rounding of degrees.
const EDGE_SLACK: f64 = 1e-9;

/// How far, in steps, 360° may be from a whole number of columns.
const PERIOD_SLACK: f64 = 1e-3;

/// Up to four neighbouring nodes along one axis, and their weights.
struct Stencil {
    first: usize,
    count: usize,
    weights: [f64; 4],
}

impl GeoidGrid {
    /// From its layout and its undulations in metres, row by row from the south, interpolated bicubically.
    ///
    /// # Errors
    /// [`Error::LengthMismatch`], [`Error::NotFinite`] for the layout's numbers, [`Error::OutOfRange`] for fewer than two
    /// rows or columns, steps that are not positive, rows beyond a pole, columns beyond 360°.
    pub fn new(layout: GeoidLayout, undulations: Vec<f32>) -> Result<Self, Error> {
        let GeoidLayout { south_deg, west_deg, latitude_step_deg, longitude_step_deg, .. } = layout;
        let (rows, columns) = (layout.rows, layout.columns);
        if rows.checked_mul(columns) != Some(undulations.len()) {
            let left = rows.saturating_mul(columns);
            let right = undulations.len();
            return Err(Error::LengthMismatch { what: "geoid nodes and undulations", left, right });
        }
        let numbers = [south_deg, west_deg, latitude_step_deg, longitude_step_deg];
        if !numbers.iter().all(|n| n.is_finite()) {
            return Err(Error::NotFinite { what: "geoid layout" });
        }
        let north = south_deg + latitude_step_deg * (rows as f64 - 1.0);
        let width = longitude_step_deg * (columns as f64 - 1.0);
        let slack = PERIOD_SLACK * latitude_step_deg;
        for (what, value, valid, expected) in [
            ("geoid rows", rows as f64, rows >= 2, "two at least"),
            ("geoid columns", columns as f64, columns >= 2, "two at least"),
            ("latitude step", latitude_step_deg, latitude_step_deg > 0.0, "positive"),
            ("longitude step", longitude_step_deg, longitude_step_deg > 0.0, "positive"),
            ("southern edge", south_deg, south_deg >= -90.0 - slack, "at least −90°"),
            ("northern edge", north, north <= 90.0 + slack, "at most 90°"),
            ("western edge", west_deg, west_deg.abs() <= 360.0, "within ±360°"),
            ("width", width, width <= 360.0 + PERIOD_SLACK * longitude_step_deg, "at most 360°"),
        ] {
            if !valid {
                return Err(Error::OutOfRange { what, value, expected });
            }
        }
        let turns = 360.0 / longitude_step_deg;
        let whole = float::round(turns);
        let wraps = (turns - whole).abs() <= PERIOD_SLACK && columns as f64 >= whole;
        let period = wraps.then_some(whole as usize);
        Ok(Self { layout, undulations, period, interpolation: GeoidInterpolation::default() })
    }

    /// The same grid with another interpolation.
    #[must_use]
    pub fn with_interpolation(mut self, interpolation: GeoidInterpolation) -> Self {
        self.interpolation = interpolation;
        self
    }

    /// The layout.
    #[must_use]
    pub fn layout(&self) -> GeoidLayout {
        self.layout
    }

    /// N, the height of the geoid above the ellipsoid in metres, at a latitude and longitude in radians.
    ///
    /// # Errors
    /// [`Error::NotFinite`], [`Error::OutOfRange`] outside the grid (the value in degrees), [`Error::NoData`] where a node
    /// that the interpolation needs is void.
    pub fn undulation(&self, latitude: f64, longitude: f64) -> Result<f64, Error> {
        if !(latitude.is_finite() && longitude.is_finite()) {
            return Err(Error::NotFinite { what: "geoid position" });
        }
        let rows = self.row_stencil(latitude.to_degrees())?;
        let columns = self.column_stencil(longitude.to_degrees())?;
        let mut sum = 0.0;
        for (i, wi) in rows.weights.iter().take(rows.count).enumerate() {
            for (j, wj) in columns.weights.iter().take(columns.count).enumerate() {
                let weight = wi * wj;
                if weight != 0.0 {
                    sum += weight * self.node(rows.first + i, columns.first + j)?;
                }
            }
        }
        Ok(sum)
    }

    /// h = H + N: the position whose orthometric height is given; latitude and longitude in radians.
    ///
    /// # Errors
    /// As [`undulation`](Self::undulation) and [`Geodetic::new`].
    pub fn geodetic(
        &self,
        latitude: f64,
        longitude: f64,
        height: OrthometricHeight,
    ) -> Result<Geodetic, Error> {
        let n = self.undulation(latitude, longitude)?;
        Geodetic::new(latitude, longitude, EllipsoidalHeight(height.0 + n))
    }

    /// H = h − N: the orthometric height of a position.
    ///
    /// # Errors
    /// As [`undulation`](Self::undulation).
    pub fn orthometric(&self, position: &Geodetic) -> Result<OrthometricHeight, Error> {
        let n = self.undulation(position.latitude(), position.longitude())?;
        Ok(OrthometricHeight(position.height().0 - n))
    }

    fn node(&self, row: usize, column: usize) -> Result<f64, Error> {
        let column = self.period.map_or(column, |period| column % period);
        let index = row * self.layout.columns + column;
        match self.undulations.get(index) {
            Some(n) if n.is_finite() => Ok(f64::from(*n)),
            _ => Err(Error::NoData { what: "the geoid grid", row, column }),
        }
    }

    fn row_stencil(&self, latitude_deg: f64) -> Result<Stencil, Error> {
        let position = (latitude_deg - self.layout.south_deg) / self.layout.latitude_step_deg;
        self.stencil(position, self.layout.rows, false).ok_or(Error::OutOfRange {
            what: "latitude",
            value: latitude_deg,
            expected: "a value inside the geoid grid (degrees)",
        })
    }

    fn column_stencil(&self, longitude_deg: f64) -> Result<Stencil, Error> {
        let step = self.layout.longitude_step_deg;
        let mut position = float::wrap(longitude_deg - self.layout.west_deg, 360.0) / step;
        if let Some(period) = self.period {
            // Shifted by a turn, so that a stencil which begins west of the first column has a positive index.
            position += period as f64;
        } else if 360.0 / step - position <= EDGE_SLACK {
            position = 0.0;
        }
        self.stencil(position, self.layout.columns, self.period.is_some()).ok_or(
            Error::OutOfRange {
                what: "longitude",
                value: longitude_deg,
                expected: "a value inside the geoid grid (degrees)",
            },
        )
    }

    /// The nodes around a position counted in steps; `None` outside.
    fn stencil(&self, position: f64, nodes: usize, wraps: bool) -> Option<Stencil> {
        let last = nodes as f64 - 1.0;
        let inside = position >= -EDGE_SLACK && position <= last + EDGE_SLACK;
        if !(wraps || inside) {
            return None;
        }
        let position = if wraps { position } else { position.clamp(0.0, last) };
        let below = float::floor(position) as usize;
        let (count, back) = match self.interpolation {
            GeoidInterpolation::Bilinear => (2, 0),
            GeoidInterpolation::Bicubic => (nodes.min(4), 1),
        };
        let first = below.saturating_sub(back);
        let first = if wraps { first } else { first.min(nodes - count) };
        let mut weights = [0.0; 4];
        let x = position - first as f64;
        for (i, weight) in weights.iter_mut().enumerate().take(count) {
            *weight = (0..count)
                .filter(|&j| j != i)
                .map(|j| (x - j as f64) / (i as f64 - j as f64))
                .product();
        }
        Some(Stencil { first, count, weights })
    }
}
