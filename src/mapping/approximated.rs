//! Expensive maps made cheap, to a tolerance that is kept.

use alloc::vec::Vec;
use core::ops::Range;

use nalgebra::{Matrix2, Point2};

use super::blocks::Gather;
use super::span::BLOCK;
use super::{BlockSink, Map};
use crate::error::{Error, ProjectionError};
use crate::numeric::{float, vectorised};

/// Another map's rows within a tolerance, from cubics in the cells of an adaptive grid.
///
/// ```text
/// u ≈ Σ aᵢⱼ (x − xₘ)ⁱ (y − yₘ)ʲ,   0 ≤ i, j ≤ 3,   (xₘ, yₘ) the middle of a cell; v likewise
/// ```
///
/// The rectangle is cut into cells of 64 × 64 pixels. In each the cubic meets the map at 4 × 4 pixels, placed as Chebyshev's
/// points; then **every pixel** is compared with the map. A cell with a pixel beyond the tolerance is halved both ways,
/// down to 8 × 8 pixels. What then still misses it, and cells in which the map has holes, stay exact: there, as outside
/// the rectangle, rows are those of the map itself. So no row is ever farther from the map than the tolerance, and the
/// same pixels show nothing.
///
/// [`at`](Map::at) and [`jacobian`](Map::jacobian) are the map's own, anywhere: only [`blocks`](Map::blocks) and
/// [`row`](Map::row) approximate.
///
/// *Units.* The tolerance is the distance ‖(Δu, Δv)‖ in texels. *Cost.* To make it, the map at each pixel and some 10
/// operations a pixel and level; then six additions and multiplications a pixel and coordinate. *Memory.* 256 bytes a cell.
///
/// # Example
/// A thin plate costs a logarithm for every pixel and control point. Here it bends so little that 20 cells hold it:
///
/// ```
/// use collinear::mapping::{Approximated, Map, ThinPlate};
/// use nalgebra::Point2;
///
/// let points = |c: [(f64, f64); 5]| c.map(|(x, y)| Point2::new(x, y));
/// let screen = points([(0., 0.), (320., 0.), (0., 256.), (320., 256.), (400., 300.)]);
/// let texture = points([(3., 1.), (325., 0.), (0., 250.), (323., 262.), (402., 307.)]);
/// let plate = ThinPlate::fit(&screen, &texture, 0.0)?;
/// let quick = Approximated::new(plate.clone(), 0..320, 0..256, 0.01)?;
/// let mut worst = 0.0f64;
/// quick.blocks(100, 0..320, &mut |x, u, v| {
///     for (i, (u, v)) in u.iter().zip(v).enumerate() {
///         let exact = plate.at(&Point2::new(f64::from(x) + i as f64 + 0.5, 100.5)).unwrap();
///         worst = worst.max((exact - Point2::new(*u, *v)).norm());
///     }
/// });
/// assert!(worst > 0.0 && worst <= quick.report().largest && quick.report().largest <= 0.01);
/// assert_eq!(quick.report().exact_pixels, 0);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
#[doc(alias("warp grid", "approximating transformer", "mesh warp"))]
pub struct Approximated<M> {
    map: M,
    x: Range<i32>,
    y: Range<i32>,
    /// Cells of 64 pixels in a row.
    columns: usize,
    /// The nodes of the uncut cells, row by row, then those they are cut into.
    nodes: Vec<Node>,
    cubics: Vec<Cubic>,
    report: ApproximationReport,
}

/// What an approximation consists of and how far it is from the map.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub struct ApproximationReport {
    /// Cells with a cubic.
    pub cells: usize,
    /// Pixels in cells with a cubic.
    pub approximated_pixels: u64,
    /// Pixels that are looked up in the map itself, holes among them.
    pub exact_pixels: u64,
    /// The greatest distance from the map at a pixel's centre, in texels.
    pub largest: f64,
}

/// Side of an uncut cell: rows come in blocks of as many pixels.
const SIDE: i32 = BLOCK as i32;
/// A cell no wider and no higher than this is cut no more.
const SMALLEST: i32 = 8;
/// Longest side of the rectangle.
const LONGEST: i64 = 1 << 24;
/// The pixels of a cell.
const INDEX: [f64; BLOCK] = {
    let mut index = [0.0; BLOCK];
    let mut i = 0;
    while i < BLOCK {
        index[i] = i as f64;
        i += 1;
    }
    index
};

#[derive(Clone, Copy, Debug, PartialEq)]
enum Node {
    Cubic(u32),
    Exact,
    /// The first of four: upper left, upper right, lower left, lower right.
    Cut(u32),
}

/// Pixels of the rectangle: x and y from its corner, width and height.
#[derive(Clone, Copy, Debug)]
struct Cell {
    x: i32,
    y: i32,
    width: i32,
    height: i32,
}

/// Where a side is cut.
fn half(side: i32) -> i32 {
    if side <= SMALLEST { side } else { (side + 1) / 2 }
}

impl Cell {
    /// One of the four parts; it may be empty.
    fn part(self, k: usize) -> Self {
        let (w, h) = (half(self.width), half(self.height));
        let (right, lower) = (k % 2 == 1, k / 2 == 1);
        Self {
            x: if right { self.x + w } else { self.x },
            y: if lower { self.y + h } else { self.y },
            width: if right { self.width - w } else { w },
            height: if lower { self.height - h } else { h },
        }
    }

    fn pixels(self) -> u64 {
        self.width as u64 * self.height as u64
    }
}

/// u and v as polynomials about a cell's middle: `[j][i]` is that of yʲ xⁱ.
#[derive(Clone, Copy, Debug)]
struct Cubic {
    u: [[f64; 4]; 4],
    v: [[f64; 4]; 4],
}

/// A cubic on one row: the coefficients of powers of x − middle.
#[derive(Clone, Copy, Debug)]
struct CubicRow {
    middle: f64,
    u: [f64; 4],
    v: [f64; 4],
}

/// c₀ + x (c₁ + x (c₂ + x c₃)).
#[inline(always)]
fn horner(c: &[f64; 4], x: f64) -> f64 {
    c[0] + x * (c[1] + x * (c[2] + x * c[3]))
}

/// The middle of pixels 0 to n − 1.
#[inline(always)]
fn middle(n: i32) -> f64 {
    0.5 * f64::from(n - 1)
}

impl Cubic {
    /// On the cell's row `y`, counted from its first.
    #[inline(always)]
    fn row(&self, cell: Cell, y: i32) -> CubicRow {
        let y = f64::from(y) - middle(cell.height);
        let collapse = |c: &[[f64; 4]; 4]| {
            core::array::from_fn(|i| horner(&[c[0][i], c[1][i], c[2][i], c[3][i]], y))
        };
        CubicRow { middle: middle(cell.width), u: collapse(&self.u), v: collapse(&self.v) }
    }
}

impl CubicRow {
    /// The pixels from `first` on, counted from the cell's first.
    #[inline(always)]
    fn fill(&self, first: usize, u: &mut [f64], v: &mut [f64]) {
        for ((index, u), v) in INDEX[first..].iter().zip(u).zip(v) {
            let x = index - self.middle;
            *u = horner(&self.u, x);
            *v = horner(&self.v, x);
        }
    }
}

/// Interpolation on n pixels: at which of them, and from the values there to coefficients.
#[derive(Clone, Copy, Debug)]
struct Basis {
    count: usize,
    pixels: [usize; 4],
    /// `[power][pixel]`.
    matrix: [[f64; 4]; 4],
}

impl Basis {
    fn new(n: i32) -> Self {
        let count = n.clamp(1, 4) as usize;
        // (1 − cos((2k + 1) π/8)) / 2.
        const CHEBYSHEV: [f64; 4] = [
            0.038_060_233_744_356_63,
            0.308_658_283_817_455_1,
            0.691_341_716_182_544_9,
            0.961_939_766_255_643_4,
        ];
        let pixels = core::array::from_fn(|k| {
            if n <= 4 { k } else { float::round(f64::from(n - 1) * CHEBYSHEV[k]) as usize }
        });
        let place = |k: usize| pixels[k] as f64 - middle(n);
        let mut matrix = [[0.0; 4]; 4];
        for q in 0..count {
            // Lagrange's polynomial of the pixel q, by its factors.
            let mut polynomial = [1.0, 0.0, 0.0, 0.0];
            for r in (0..count).filter(|r| *r != q) {
                let scale = 1.0 / (place(q) - place(r));
                for power in (0..4).rev() {
                    let lower = if power > 0 { polynomial[power - 1] } else { 0.0 };
                    polynomial[power] = (lower - place(r) * polynomial[power]) * scale;
                }
            }
            for (row, c) in matrix.iter_mut().zip(polynomial) {
                row[q] = c;
            }
        }
        Self { count, pixels, matrix }
    }
}

/// The exact coordinates of some rows of the rectangle, NaN where there are none.
struct Strip {
    width: usize,
    first: i32,
    u: Vec<f64>,
    v: Vec<f64>,
}

impl Strip {
    fn row<'a>(&self, values: &'a [f64], cell: Cell, y: i32) -> &'a [f64] {
        let start = (cell.y + y - self.first) as usize * self.width + cell.x as usize;
        &values[start..start + cell.width as usize]
    }

    fn whole(&self, cell: Cell) -> bool {
        [&self.u, &self.v].iter().all(|values| {
            (0..cell.height).all(|y| self.row(values, cell, y).iter().all(|c| c.is_finite()))
        })
    }

    fn interpolate(&self, values: &[f64], cell: Cell, x: &Basis, y: &Basis) -> [[f64; 4]; 4] {
        let mut coefficients = [[0.0; 4]; 4];
        for q in 0..y.count {
            let row = self.row(values, cell, y.pixels[q] as i32);
            for i in 0..4 {
                let along: f64 = (0..x.count).map(|p| x.matrix[i][p] * row[x.pixels[p]]).sum();
                for j in 0..4 {
                    coefficients[j][i] += y.matrix[j][q] * along;
                }
            }
        }
        coefficients
    }

    /// The greatest distance of a cubic from the exact coordinates, squared.
    fn worst(&self, cell: Cell, cubic: &Cubic) -> f64 {
        let mut worst = 0.0f64;
        let (mut u, mut v) = ([0.0; BLOCK], [0.0; BLOCK]);
        let n = cell.width as usize;
        for y in 0..cell.height {
            let row = cubic.row(cell, y);
            vectorised(
                #[inline(always)]
                || row.fill(0, &mut u[..n], &mut v[..n]),
            );
            let exact = self.row(&self.u, cell, y).iter().zip(self.row(&self.v, cell, y));
            for ((u, v), (eu, ev)) in u.iter().zip(&v).zip(exact) {
                let (du, dv) = (u - eu, v - ev);
                let square = du * du + dv * dv;
                // NaN and overflow are beyond every tolerance.
                worst = if square.is_finite() { worst.max(square) } else { f64::INFINITY };
            }
            if worst == f64::INFINITY {
                break;
            }
        }
        worst
    }
}

impl<M: Map> Approximated<M> {
    /// The approximation over the pixels `x` of the rows `y`, to `tolerance` texels.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] for a tolerance that is not positive and finite, and a rectangle that is empty or has a side
    /// over 2²⁴ pixels.
    pub fn new(map: M, x: Range<i32>, y: Range<i32>, tolerance: f64) -> Result<Self, Error> {
        if !(tolerance > 0.0 && tolerance.is_finite()) {
            return Err(Error::OutOfRange {
                what: "tolerance of an approximation",
                value: tolerance,
                expected: "a positive distance",
            });
        }
        for side in [&x, &y].map(|r| i64::from(r.end) - i64::from(r.start)) {
            if !(1..=LONGEST).contains(&side) {
                return Err(Error::OutOfRange {
                    what: "side of an approximation's rectangle",
                    value: side as f64,
                    expected: "1 to 16777216 pixels",
                });
            }
        }
        let (width, height) = (x.end - x.start, y.end - y.start);
        let columns = (width as usize).div_ceil(BLOCK);
        let rows = (height as usize).div_ceil(BLOCK);
        let nodes = alloc::vec![Node::Exact; columns * rows];
        let report = ApproximationReport::default();
        let mut made = Self { map, x, y, columns, nodes, cubics: Vec::new(), report };
        let size = width as usize * SIDE.min(height) as usize;
        let mut strip = Strip {
            width: width as usize,
            first: 0,
            u: alloc::vec![0.0; size],
            v: alloc::vec![0.0; size],
        };
        let bases: Vec<Basis> = (0..=SIDE).map(Basis::new).collect();
        for row in 0..rows {
            made.read(&mut strip, row as i32 * SIDE);
            for column in 0..columns {
                let cell = made.uncut(column, row);
                let node = made.settle(cell, &strip, &bases, tolerance);
                made.nodes[row * columns + column] = node;
            }
        }
        Ok(made)
    }

    /// The cell of 64 pixels, or what is left of it at the rectangle's end.
    fn uncut(&self, column: usize, row: usize) -> Cell {
        let (x, y) = (column as i32 * SIDE, row as i32 * SIDE);
        Cell {
            x,
            y,
            width: SIDE.min(self.x.end - self.x.start - x),
            height: SIDE.min(self.y.end - self.y.start - y),
        }
    }

    /// Fills the strip with rows of the map, from `first` on.
    fn read(&self, strip: &mut Strip, first: i32) {
        strip.first = first;
        strip.u.fill(f64::NAN);
        strip.v.fill(f64::NAN);
        let last = (self.y.end - self.y.start).min(first + SIDE);
        let width = strip.width;
        for y in first..last {
            let start = (y - first) as usize * width;
            let (ru, rv) = (&mut strip.u[start..start + width], &mut strip.v[start..start + width]);
            self.map.blocks(self.y.start + y, self.x.clone(), &mut |x, u, v| {
                let offset = i64::from(x) - i64::from(self.x.start);
                for (i, (u, v)) in (offset..).zip(u.iter().zip(v)) {
                    let place = usize::try_from(i).unwrap_or(usize::MAX);
                    if let (Some(ru), Some(rv)) = (ru.get_mut(place), rv.get_mut(place)) {
                        (*ru, *rv) = (*u, *v);
                    }
                }
            });
        }
    }

    /// A cell's node: its cubic, if that keeps the tolerance, or its parts.
    fn settle(&mut self, cell: Cell, strip: &Strip, bases: &[Basis], tolerance: f64) -> Node {
        if cell.pixels() == 0 {
            return Node::Exact;
        }
        if strip.whole(cell) {
            let (bx, by) = (&bases[cell.width as usize], &bases[cell.height as usize]);
            let cubic = Cubic {
                u: strip.interpolate(&strip.u, cell, bx, by),
                v: strip.interpolate(&strip.v, cell, bx, by),
            };
            let worst = float::sqrt(strip.worst(cell, &cubic));
            if worst <= tolerance {
                self.report.cells += 1;
                self.report.approximated_pixels += cell.pixels();
                self.report.largest = self.report.largest.max(worst);
                self.cubics.push(cubic);
                return Node::Cubic(self.cubics.len() as u32 - 1);
            }
        }
        if cell.width <= SMALLEST && cell.height <= SMALLEST {
            self.report.exact_pixels += cell.pixels();
            return Node::Exact;
        }
        let first = self.nodes.len();
        self.nodes.extend([Node::Exact; 4]);
        for k in 0..4 {
            let node = self.settle(cell.part(k), strip, bases, tolerance);
            self.nodes[first + k] = node;
        }
        // Four parts that are exact are so as one.
        if self.nodes.len() == first + 4 && self.nodes[first..].iter().all(|n| *n == Node::Exact) {
            self.nodes.truncate(first);
            return Node::Exact;
        }
        Node::Cut(first as u32)
    }

    /// What the approximation consists of.
    #[must_use]
    pub fn report(&self) -> &ApproximationReport {
        &self.report
    }

    /// The map that is approximated.
    #[must_use]
    pub fn exact(&self) -> &M {
        &self.map
    }

    /// The leaf that holds a pixel of the rectangle, counted from its corner.
    #[inline(always)]
    fn leaf(&self, x: i32, y: i32) -> (Cell, Node) {
        let (column, row) = ((x / SIDE) as usize, (y / SIDE) as usize);
        let mut cell = self.uncut(column, row);
        let mut node = self.nodes[row * self.columns + column];
        while let Node::Cut(first) = node {
            let (w, h) = (half(cell.width), half(cell.height));
            let k = usize::from(x >= cell.x + w) + 2 * usize::from(y >= cell.y + h);
            cell = cell.part(k);
            node = self.nodes[first as usize + k];
        }
        (cell, node)
    }

    #[inline(always)]
    fn inside(&self, line: i32, samples: Range<i32>, emit: &mut BlockSink<'_>) {
        let (x0, y) = (self.x.start, line - self.y.start);
        let mut row = Gather::new(emit);
        let mut x = samples.start - x0;
        let end = samples.end - x0;
        while x < end {
            let (cell, node) = self.leaf(x, y);
            let stop = end.min(cell.x + cell.width);
            let range = x0 + x..x0 + stop;
            if let Node::Cubic(index) = node {
                let cubic = self.cubics[index as usize].row(cell, y - cell.y);
                let origin = x0 + cell.x;
                row.run(
                    range,
                    #[inline(always)]
                    |x, u, v| cubic.fill((x - origin) as usize, u, v),
                );
            } else {
                self.exactly(line, range, &mut row);
            }
            x = stop;
        }
        row.flush();
    }

    /// Pixels of the map itself.
    fn exactly(&self, line: i32, samples: Range<i32>, row: &mut Gather<'_, '_>) {
        self.map.blocks(line, samples, &mut |first, u, v| {
            let end = first.saturating_add(u.len().min(v.len()) as i32);
            row.run(first..end, |x, ru, rv| {
                let start = (x - first) as usize;
                let range = start..start + ru.len();
                ru.copy_from_slice(&u[range.clone()]);
                rv.copy_from_slice(&v[range]);
            });
        });
    }
}

impl<M: Map> Map for Approximated<M> {
    fn at(&self, screen: &Point2<f64>) -> Result<Point2<f64>, ProjectionError> {
        self.map.at(screen)
    }

    fn jacobian(&self, screen: &Point2<f64>) -> Result<Matrix2<f64>, ProjectionError> {
        self.map.jacobian(screen)
    }

    /// Within the tolerance of the map's own blocks.
    fn blocks(&self, line: i32, samples: Range<i32>, emit: &mut BlockSink<'_>) {
        let start = samples.start.max(self.x.start);
        let end = samples.end.min(self.x.end);
        if !self.y.contains(&line) || start >= end {
            self.map.blocks(line, samples, emit);
            return;
        }
        if samples.start < start {
            self.map.blocks(line, samples.start..start, emit);
        }
        vectorised(
            #[inline(always)]
            || self.inside(line, start..end, emit),
        );
        if end < samples.end {
            self.map.blocks(line, end..samples.end, emit);
        }
    }
}
