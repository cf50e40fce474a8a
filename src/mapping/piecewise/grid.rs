//! A regular grid on the screen, a bilinear map in each cell.

use alloc::vec::Vec;
use core::ops::Range;

use nalgebra::{Matrix2, Point2, Vector2};

use super::affine::Stretch;
use super::triangulation::between;
use crate::error::{Error, ProjectionError};
use crate::mapping::blocks::{Gather, centre, first_beyond, first_from};
use crate::mapping::{BlockSink, Map};

/// A grid of bilinear maps: texture points at the nodes of a regular screen grid, bilinear in every cell.
///
/// ```text
/// p = origin + (i + s, j + t) · spacing,   0 ≤ s, t ≤ 1
/// u = (1 − t) ((1 − s) uⱼᵢ + s uⱼ,ᵢ₊₁) + t ((1 − s) uⱼ₊₁,ᵢ + s uⱼ₊₁,ᵢ₊₁)
/// ```
///
/// Satellite scenes are rectified so: the sensor's model is asked at the nodes alone (Rifman 1973). The error in a cell
/// is at most (h² |∂²u/∂S²| + k² |∂²u/∂L²|) / 8 for a cell of h by k pixels.
///
/// *Domain.* The grid's rectangle with its border. *Smoothness.* Continuous. *Cost.* One addition and one product a pixel
/// and coordinate, and six products where a row enters a cell.
///
/// # Example
/// ```
/// use collinear::mapping::{Map, piecewise::BilinearGrid};
/// use nalgebra::{Point2, Vector2};
///
/// let nodes = [(0., 0.), (10., 1.), (20., 0.), (0., 8.), (12., 9.), (20., 8.)];
/// let nodes = nodes.map(|(u, v)| Point2::new(u, v));
/// let grid = BilinearGrid::new(Point2::new(0.0, 0.0), Vector2::new(4.0, 2.0), 3, &nodes)?;
/// // s = ¼, t = ½ in the second cell: u = ½ (12.5 + 14), v = ½ (0.75 + 8.75).
/// assert_eq!(grid.at(&Point2::new(5.0, 1.0))?, Point2::new(13.25, 4.75));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
#[doc(alias("geolocation array", "grid of bilinears"))]
pub struct BilinearGrid {
    origin: Point2<f64>,
    spacing: Vector2<f64>,
    columns: usize,
    rows: usize,
    nodes: Vec<Point2<f64>>,
}

impl BilinearGrid {
    /// From the texture points at the nodes, row by row, `columns` in each.
    ///
    /// # Errors
    /// [`Error::TooFewPoints`] below two columns and two rows; [`Error::LengthMismatch`] where nodes do not fill their rows;
    /// [`Error::OutOfRange`] for a spacing that is not positive, [`Error::NotFinite`].
    pub fn new(
        origin: Point2<f64>,
        spacing: Vector2<f64>,
        columns: usize,
        nodes: &[Point2<f64>],
    ) -> Result<Self, Error> {
        let rows = nodes.len().checked_div(columns).unwrap_or(0);
        if columns < 2 || rows < 2 {
            return Err(Error::TooFewPoints { needed: 2, got: columns.min(rows) });
        }
        if rows * columns != nodes.len() {
            return Err(Error::LengthMismatch {
                what: "nodes of a grid and its rows",
                left: nodes.len(),
                right: rows * columns,
            });
        }
        let finite = |x: f64, y: f64| x.is_finite() && y.is_finite();
        let end = origin + spacing.component_mul(&Vector2::new(columns as f64, rows as f64));
        if !(finite(origin.x, origin.y) && finite(end.x, end.y)) {
            return Err(Error::NotFinite { what: "place of a grid" });
        }
        if !nodes.iter().all(|p| finite(p.x, p.y)) {
            return Err(Error::NotFinite { what: "node of a grid" });
        }
        for value in [spacing.x, spacing.y] {
            if !(value > 0.0) {
                let expected = "a positive distance";
                return Err(Error::OutOfRange { what: "spacing of a grid", value, expected });
            }
        }
        Ok(Self { origin, spacing, columns, rows, nodes: nodes.to_vec() })
    }

    /// The grid over pixels 0 to `width` and 0 to `height` whose nodes, `step` pixels apart, are those of another map.
    ///
    /// The last nodes may lie outside the picture. How far the grid is from the map inside the cells is not looked at:
    /// [`Approximated`](crate::mapping::Approximated) keeps a tolerance.
    ///
    /// # Errors
    /// As [`new`](Self::new), and [`Error::Projection`] where the map has no value at a node.
    pub fn sampled(map: &dyn Map, width: u32, height: u32, step: u32) -> Result<Self, Error> {
        let cells = |pixels: u32| pixels.div_ceil(step.max(1)).max(1);
        let (columns, rows) = (cells(width) + 1, cells(height) + 1);
        let spacing = f64::from(step);
        let mut nodes = Vec::new();
        for j in 0..rows {
            for i in 0..columns {
                nodes.push(map.at(&Point2::new(f64::from(i) * spacing, f64::from(j) * spacing))?);
            }
        }
        Self::new(Point2::origin(), Vector2::repeat(spacing), columns as usize, &nodes)
    }

    /// The cell of a coordinate along one axis, and the share of it.
    fn cell(
        c: f64,
        origin: f64,
        spacing: f64,
        nodes: usize,
    ) -> Result<(usize, f64), ProjectionError> {
        let along = (c - origin) / spacing;
        let limit = (nodes - 1) as f64;
        if along.is_nan() {
            return Err(ProjectionError::NotFinite);
        }
        if !(along >= 0.0 && along <= limit) {
            let value = (-along).max(along - limit) * spacing;
            return Err(ProjectionError::OutsideDomain { value, limit: 0.0 });
        }
        let index = (along as usize).min(nodes - 2);
        Ok((index, along - index as f64))
    }

    fn column(&self, x: f64) -> Result<(usize, f64), ProjectionError> {
        Self::cell(x, self.origin.x, self.spacing.x, self.columns)
    }

    fn row_of(&self, y: f64) -> Result<(usize, f64), ProjectionError> {
        Self::cell(y, self.origin.y, self.spacing.y, self.rows)
    }

    /// The screen x of a column of nodes.
    fn node_x(&self, i: usize) -> f64 {
        self.origin.x + self.spacing.x * i as f64
    }

    /// The texture point of a row where it meets a column of nodes.
    fn on_column(&self, i: usize, j: usize, t: f64) -> [f64; 2] {
        let [p, q] = [j, j + 1].map(|j| self.nodes[j * self.columns + i]);
        [between(p.x, q.x, t), between(p.y, q.y, t)]
    }

    fn stretch(&self, i: usize, j: usize, t: f64) -> Stretch {
        let (left, right) = (self.on_column(i, j, t), self.on_column(i + 1, j, t));
        Stretch::new(self.node_x(i), left, self.node_x(i + 1), right)
    }
}

impl Map for BilinearGrid {
    /// [`ProjectionError::OutsideDomain`] outside the grid, with the distance and the limit zero.
    fn at(&self, screen: &Point2<f64>) -> Result<Point2<f64>, ProjectionError> {
        let ((i, _), (j, t)) = (self.column(screen.x)?, self.row_of(screen.y)?);
        Ok(self.stretch(i, j, t).at(screen.x).into())
    }

    /// In a cell's border, that of the cell to the right and below.
    fn jacobian(&self, screen: &Point2<f64>) -> Result<Matrix2<f64>, ProjectionError> {
        let ((i, s), (j, t)) = (self.column(screen.x)?, self.row_of(screen.y)?);
        let node = |i: usize, j: usize| self.nodes[j * self.columns + i];
        let (top, bottom) = (node(i + 1, j) - node(i, j), node(i + 1, j + 1) - node(i, j + 1));
        let (left, right) = (node(i, j + 1) - node(i, j), node(i + 1, j + 1) - node(i + 1, j));
        let by_x = (top * (1.0 - t) + bottom * t) / self.spacing.x;
        let by_y = (left * (1.0 - s) + right * s) / self.spacing.y;
        Ok(Matrix2::from_columns(&[by_x, by_y]))
    }

    fn blocks(&self, line: i32, samples: Range<i32>, emit: &mut BlockSink<'_>) {
        let Ok((j, t)) = self.row_of(centre(line)) else { return };
        let mut row = Gather::new(emit);
        let mut rest = samples;
        rest.start = first_from(self.origin.x, &rest);
        rest.end = first_beyond(self.node_x(self.columns - 1), &rest);
        // Truncated towards zero, and zero for what is left of the grid.
        let along = (centre(rest.start) - self.origin.x) / self.spacing.x;
        let first = (along as usize).min(self.columns - 2);
        for i in first..self.columns - 1 {
            if rest.is_empty() {
                break;
            }
            let last = i + 2 == self.columns;
            let stop = if last { rest.end } else { first_from(self.node_x(i + 1), &rest) };
            let stretch = self.stretch(i, j, t);
            row.run(rest.start..stop, |x, u, v| stretch.fill(x, u, v));
            rest.start = stop;
        }
        row.flush();
    }
}
