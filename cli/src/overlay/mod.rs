//! Wire frames over the photograph they were measured in (Weinhaus & Devarajan 1997, figure 8b).

mod curves;
mod lines;
mod png;
mod svg;

use std::collections::HashSet;
use std::path::Path;

use anyhow::{Result, anyhow};
use collinear::nalgebra::{Point2, Point3};
use collinear_io::plane::PlaneFile;
use collinear_io::scene::SceneFile;
use collinear_io::sensor::SensorFile;

use crate::obj::{self, Element, Object};

pub use svg::Photograph;
pub(crate) use svg::escaped;

use lines::Tracer;

/// Colours that stay apart for every kind of colour vision: Okabe and Ito's eight (2002) without the black.
const PALETTE: [[u8; 3]; 7] = [
    [240, 228, 66],
    [86, 180, 233],
    [230, 159, 0],
    [0, 158, 115],
    [204, 121, 167],
    [213, 94, 0],
    [0, 114, 178],
];

/// The dark casing of a line, as wide as so many lines.
const CASING_WIDTH: f64 = 2.0;

/// How much of what is below a casing it covers.
const CASING_OPACITY: f64 = 0.5;

/// Edges of the world that share a name and a colour.
#[derive(Clone, Debug, PartialEq)]
pub struct Figure {
    /// Its name, written at the middle of its vertices.
    pub name: Option<String>,
    /// Its edges.
    pub edges: Vec<[Point3<f64>; 2]>,
    /// Where its name stands.
    pub middle: Point3<f64>,
}

/// The figures of a scene: one for each polygon.
#[must_use]
pub fn scene_figures(scene: &SceneFile) -> Vec<Figure> {
    let figure = |polygon: &collinear_io::scene::Polygon| {
        let vertices: Vec<_> = polygon.vertices.iter().map(|v| Point3::from(*v)).collect();
        outline(polygon.name.clone(), &vertices)
    };
    scene.polygons.iter().map(figure).collect()
}

/// The figure of a plane's rectangle, divided into `cells` × `cells`.
///
/// # Errors
/// A plane without a rectangle.
pub fn plane_figure(plane: &PlaneFile, cells: u32) -> Result<Figure> {
    let r = plane
        .rectangle
        .as_ref()
        .ok_or_else(|| anyhow!("has no `rectangle`, and a plane by itself has no edges to draw"))?;
    let at = |i: u32, j: u32| -> Result<Point3<f64>> {
        let part = |k: u32, from: f64, to: f64| {
            let t = f64::from(k) / f64::from(cells);
            from * (1.0 - t) + to * t
        };
        let world = plane.world_from_plane(part(i, r.left, r.right), part(j, r.bottom, r.top));
        Ok(Point3::from(world.map_err(collinear_io::Error::from)?))
    };
    let mut edges = Vec::new();
    for k in 0..=cells {
        edges.push([at(k, 0)?, at(k, cells)?]);
        edges.push([at(0, k)?, at(cells, k)?]);
    }
    let (a, c) = (at(0, 0)?, at(cells, cells)?);
    Ok(Figure { name: None, edges, middle: a + (c - a) / 2.0 })
}

/// The figures of a Wavefront OBJ file: one for each of its objects and groups. Vertices, faces, lines and names are read,
/// everything else is passed over.
///
/// # Errors
/// A file that cannot be read, that is no text, or that has nothing to draw; a line that makes no sense, with its number.
pub fn mesh_figures(path: &Path) -> Result<Vec<Figure>> {
    let figure = |object: Object| {
        let mut edges = Vec::new();
        for Element { corners, is_face } in &object.elements {
            let closed = *is_face && corners.len() > 2;
            let next = corners.iter().skip(1).chain(corners.first().filter(|_| closed));
            edges.extend(corners.iter().zip(next).map(|(a, b)| [*a, *b]));
        }
        let vertices: Vec<_> = object.elements.into_iter().flat_map(|e| e.corners).collect();
        Figure { name: object.name, edges, middle: middle(&vertices) }
    };
    Ok(obj::read(path)?.into_iter().map(figure).collect())
}

fn outline(name: Option<String>, vertices: &[Point3<f64>]) -> Figure {
    let edges = vertices.iter().zip(vertices.iter().cycle().skip(1)).map(|(a, b)| [*a, *b]);
    Figure { name, edges: edges.collect(), middle: middle(vertices) }
}

fn middle(vertices: &[Point3<f64>]) -> Point3<f64> {
    let Some(first) = vertices.first() else { return Point3::origin() };
    let sum = vertices.iter().fold(Point3::origin().coords, |s, v| s + (v - first));
    first + sum / vertices.len() as f64
}

/// A wire frame on its picture.
#[derive(Clone, Debug, PartialEq)]
pub struct Overlay {
    /// Width of the picture in pixels.
    pub width: u32,
    /// Height of the picture in pixels.
    pub height: u32,
    /// What is drawn.
    pub drawings: Vec<Drawing>,
}

/// A figure on the picture.
#[derive(Clone, Debug, PartialEq)]
pub struct Drawing {
    /// Its name.
    pub name: Option<String>,
    /// Red, green, blue.
    pub color: [u8; 3],
    /// The visible parts of its edges: vertices of polylines, in pixels.
    pub lines: Vec<Vec<Point2<f64>>>,
    /// Where its name stands, in pixels, if that is in the picture.
    pub label: Option<Point2<f64>>,
}

impl Overlay {
    /// Traces figures through a camera or another sensor: each edge once, cut off where it leaves the lens's domain or the picture's
    /// surroundings, bent as the lens bends it to within a tenth of a pixel. Nothing hides anything.
    ///
    /// # Errors
    /// A camera out of its domain.
    pub fn trace(figures: &[Figure], camera: &SensorFile) -> Result<Self> {
        let tracer = Tracer::new(camera, figures)?;
        let mut seen = HashSet::new();
        let mut drawings = Vec::with_capacity(figures.len());
        for (figure, color) in figures.iter().zip(PALETTE.iter().cycle()) {
            let mut lines = Vec::new();
            for edge in &figure.edges {
                if seen.insert(key(edge)) {
                    lines.extend(tracer.trace(edge));
                }
            }
            let label = tracer.point(&figure.middle);
            drawings.push(Drawing { name: figure.name.clone(), color: *color, lines, label });
        }
        let [width, height] = camera.size();
        Ok(Self { width, height, drawings })
    }

    /// Lines: visible edges, those of a curved picture perhaps in several parts.
    #[must_use]
    pub fn line_count(&self) -> usize {
        self.drawings.iter().map(|d| d.lines.len()).sum()
    }
}

/// An edge whichever way it goes.
fn key([a, b]: &[Point3<f64>; 2]) -> [[u64; 3]; 2] {
    // Adding zero makes −0 into 0.
    let bits = |p: &Point3<f64>| [p.x, p.y, p.z].map(|c| (c + 0.0).to_bits());
    let mut ends = [bits(a), bits(b)];
    ends.sort_unstable();
    ends
}
