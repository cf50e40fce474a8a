//! Which pixels a polygon covers.

use alloc::vec::Vec;
use core::ops::Range;

/// Vertices are snapped to 1/256 pixel.
pub(super) const SUBPIXELS: i64 = 256;
const HALF: i64 = SUBPIXELS / 2;

/// A vertex in 1/256 pixel.
pub(super) type Snapped = [i32; 2];

/// The pixels `x` of row `y`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PixelSpan {
    /// The row.
    pub y: i32,
    /// The pixels of the row, left to right.
    pub x: Range<i32>,
}

/// An edge that crosses at least one row of pixel centres, upper end first.
#[derive(Clone, Copy, Debug)]
struct Edge {
    top: Snapped,
    bottom: Snapped,
    /// Rows whose centres y satisfy top.y ≤ y < bottom.y.
    rows: (i32, i32),
}

/// ⌈(a − ½ pixel) / pixel⌉: the first pixel whose centre is at or after `a` (in 1/256 pixel).
fn first_centre(a: i64) -> i64 {
    -(-(a - HALF)).div_euclid(SUBPIXELS)
}

impl Edge {
    fn new(a: Snapped, b: Snapped) -> Option<Self> {
        let (top, bottom) = if a[1] < b[1] { (a, b) } else { (b, a) };
        let first = first_centre(i64::from(top[1]));
        let end = first_centre(i64::from(bottom[1]));
        // A snapped coordinate fits 29 bits, a pixel row 21.
        (first < end).then_some(Self { top, bottom, rows: (first as i32, end as i32) })
    }

    /// The first pixel of the row whose centre is on or right of the edge, in exact integers.
    fn crossing(&self, row: i32) -> i32 {
        let (x0, y0) = (i64::from(self.top[0]), i64::from(self.top[1]));
        let (dx, dy) = (i64::from(self.bottom[0]) - x0, i64::from(self.bottom[1]) - y0);
        let centre = SUBPIXELS * i64::from(row) + HALF;
        // x = x0 + (centre − y0) dx / dy; the pixel is ⌈(x − ½) / 1⌉.
        let numerator = (x0 - HALF) * dy + (centre - y0) * dx;
        (-(-numerator).div_euclid(SUBPIXELS * dy)) as i32
    }
}

/// Visits the spans of a polygon inside a picture, top to bottom and left to right.
///
/// A pixel belongs to the polygon if its centre does. A centre on an edge belongs to the polygon right of a left edge and
/// below a top edge (the top-left rule of Direct3D and OpenGL's common practice), so polygons that share an edge cover
/// each pixel once. Where the outline crosses itself, a pixel is inside if a ray from it crosses the outline an odd
/// number of times. Concave polygons need nothing special.
pub(super) fn scan(
    vertices: &[Snapped],
    width: usize,
    height: usize,
    mut visit: impl FnMut(PixelSpan),
) {
    let mut edges: Vec<Edge> = vertices
        .iter()
        .zip(vertices.iter().cycle().skip(1))
        .filter_map(|(&a, &b)| Edge::new(a, b))
        .collect();
    edges.sort_unstable_by_key(|e| e.rows.0);
    let [width, height] = [width, height].map(|n| i32::try_from(n).unwrap_or(i32::MAX));
    let last = edges.iter().map(|e| e.rows.1).max().unwrap_or(0).min(height);
    let mut waiting = edges.iter().copied().peekable();
    let mut active: Vec<Edge> = Vec::new();
    let mut crossings: Vec<i32> = Vec::new();
    let mut row = edges.first().map_or(0, |e| e.rows.0).max(0);
    while row < last {
        while let Some(edge) = waiting.next_if(|e| e.rows.0 <= row) {
            active.push(edge);
        }
        active.retain(|e| e.rows.1 > row);
        crossings.clear();
        crossings.extend(active.iter().map(|e| e.crossing(row)));
        crossings.sort_unstable();
        for pair in crossings.chunks_exact(2) {
            let x = pair[0].max(0)..pair[1].min(width);
            if !x.is_empty() {
                visit(PixelSpan { y: row, x });
            }
        }
        row += 1;
    }
}
