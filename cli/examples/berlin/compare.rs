//! The façade as one quadrilateral, seen obliquely: texture coordinates in perspective, linear and bilinear
//! ([WD] figure 2).

use std::path::Path;

use anyhow::{Result, anyhow};
use collinear::camera::HomogeneousCamera;
use collinear::geometry::Plane;
use collinear::mapping::{Map, PhotographMap};
use collinear::nalgebra::{Point2, Point3};
use collinear::texturer::{ScreenPolygon, bilinear_quad, linear_triangles};
use collinear_io::camera::CameraFile;
use collinear_io::convert::Camera;
use collinear_io::picture::{Picture, write_picture};
use collinear_io::scene::{Fill, Interpolation, Photograph, Polygon};

use crate::site::Site;
use crate::view;

/// The façade's quadrilateral on the plane of the wall: left, bottom, right, top, building coordinates.
const FACADE: [f64; 4] = [-10.2, -1.6, 11.0, 13.6];
/// Two eyes a small step apart, and what they look at.
const EYES: [[f64; 3]; 2] = [[14.0, 11.0, 3.0], [13.2, 10.4, 3.0]];
const TARGET: [f64; 3] = [4.4, 22.5, 5.6];
const SIZE: [u32; 2] = [800, 760];
const DISTANCE: f64 = 600.0;
/// The detail about the middle of the fold: its side in pixels, and how much it is magnified.
const DETAIL_SIDE: u32 = 200;
const MAGNIFIED: u32 = 4;
/// Between the pictures.
const GAP: u32 = 8;
const NEAR: f64 = 0.5;

/// Draws the six pictures, assembles them with their details, and prints how far the texture is off.
pub(crate) fn compare(site: &Site, photographs: &[Photograph], out: &Path) -> Result<()> {
    let depth = site.depth(site.sheet(22.51)?);
    let [left, bottom, right, top] = FACADE;
    let corners = [[left, bottom], [right, bottom], [right, top], [left, top]];
    let quad: Vec<Point3<f64>> = corners.iter().map(|[x, z]| site.world([*x, depth, *z])).collect();
    let kinds = [
        ("perspective", Interpolation::Perspective),
        ("linear", Interpolation::Linear),
        ("bilinear", Interpolation::Bilinear),
    ];
    let polygon = Polygon {
        name: Some("façade".to_owned()),
        vertices: quad.iter().map(|p| (*p).into()).collect(),
        fill: Fill::Photograph(site.photographs[0].name.clone()),
    };
    let mut rows = Vec::new();
    let mut lookups = Vec::new();
    for (i, eye) in EYES.into_iter().enumerate() {
        let camera = view::look(site, SIZE, DISTANCE, eye, TARGET)?;
        let screen = pinhole(&camera)?;
        let middle = fold(&quad, &screen)?;
        let (mut pictures, mut details) = (Vec::new(), Vec::new());
        for (name, kind) in kinds {
            let scene = view::scene(photographs, vec![polygon.clone()], camera.clone(), kind);
            let picture = view::draw(&scene, out, &format!("comparison_{name}_{}", i + 1))?;
            details.push(magnified(&picture, &middle));
            pictures.push(picture);
        }
        rows.push(beside(&pictures));
        rows.push(beside(&details));
        lookups.push(Lookup::new(site, &quad, screen)?);
    }
    write_picture(&out.join("comparison.png"), &below(&rows))?;
    print_offsets(site, depth, &lookups);
    Ok(())
}

/// The middle, on the screen, of the diagonal along which the linear triangles meet: from the second corner to the fourth.
fn fold(quad: &[Point3<f64>], screen: &HomogeneousCamera) -> Result<Point2<f64>> {
    let [_, b, _, d] = quad else { return Err(anyhow!("the façade is not a quadrilateral")) };
    let (b, d) = (screen_point(screen, b)?, screen_point(screen, d)?);
    Ok(b + (d - b) / 2.0)
}

fn pinhole(camera: &CameraFile) -> Result<HomogeneousCamera> {
    match camera.camera()? {
        Camera::Pinhole(frame) => Ok(frame.homogeneous()),
        _ => Err(anyhow!("the view is not a pinhole")),
    }
}

fn screen_point(screen: &HomogeneousCamera, world: &Point3<f64>) -> Result<Point2<f64>> {
    let h = screen.image_from_world() * (world - screen.origin()).push(1.0);
    if h.z > 0.0 {
        Ok(Point2::new(h.x / h.z, h.y / h.z))
    } else {
        Err(anyhow!("a point of the façade is behind the eye"))
    }
}

/// The maps of one view.
struct Lookup {
    screen: HomogeneousCamera,
    exact: PhotographMap,
    linear: Vec<(ScreenPolygon, Box<dyn Map>)>,
    bilinear: Box<dyn Map>,
}

impl Lookup {
    fn new(site: &Site, quad: &[Point3<f64>], screen: HomogeneousCamera) -> Result<Self> {
        let plane = Plane::fit(quad)?.plane;
        let exact = PhotographMap::from_plane(&plane, &site.photographs[0].frame, &screen)?;
        let outline = ScreenPolygon::project(quad, &screen, NEAR)?;
        let linear = linear_triangles(&outline, &exact)?
            .into_iter()
            .map(|(piece, map)| (piece, Box::new(map) as Box<dyn Map>))
            .collect();
        let bilinear = Box::new(bilinear_quad(&outline, &exact)?);
        Ok(Self { screen, exact, linear, bilinear })
    }

    /// The texture point that the linear and the bilinear map show at a world point of the façade, and the right one.
    fn at(&self, world: &Point3<f64>) -> Option<[Point2<f64>; 3]> {
        let p = screen_point(&self.screen, world).ok()?;
        let (_, linear) = self.linear.iter().find(|(piece, _)| holds(piece.vertices(), &p))?;
        Some([linear.at(&p).ok()?, self.bilinear.at(&p).ok()?, self.exact.at(&p).ok()?])
    }
}

/// Whether a triangle holds a point.
fn holds(triangle: &[Point2<f64>], p: &Point2<f64>) -> bool {
    let edges = triangle.iter().zip(triangle.iter().cycle().skip(1));
    let signs: Vec<bool> = edges.map(|(a, b)| (b - a).perp(&(p - a)) >= 0.0).collect();
    signs.iter().all(|s| *s) || signs.iter().all(|s| !*s)
}

/// Prints how far the wrong maps look beside the right place, and how far that place moves when the eye takes its step.
fn print_offsets(site: &Site, depth: f64, lookups: &[Lookup]) {
    const PARTS: usize = 40;
    let [left, bottom, right, top] = FACADE;
    let part = |k: usize, a: f64, b: f64| a + (b - a) * (k as f64 + 0.5) / PARTS as f64;
    let points = (0..PARTS * PARTS)
        .map(|k| site.world([part(k % PARTS, left, right), depth, part(k / PARTS, bottom, top)]));
    let found: Vec<Vec<[Point2<f64>; 3]>> =
        points.filter_map(|p| lookups.iter().map(|l| l.at(&p)).collect()).collect();
    for (k, name) in ["linear", "bilinear"].into_iter().enumerate() {
        let off = |eye: usize| {
            let offsets = found.iter().filter_map(|f| f.get(eye)).map(|f| (f[k] - f[2]).norm());
            offsets.fold(0.0, f64::max)
        };
        let swim = found.iter().filter_map(|f| Some((f.first()?[k] - f.get(1)?[k]).norm()));
        let right = found.iter().filter_map(|f| Some((f.first()?[2] - f.get(1)?[2]).norm()));
        println!(
            "  {name}: up to {:.0} and {:.0} pixels of the photograph beside the right place; the texture swims by up \
             to {:.1} pixels at the eye's step, in perspective by {:.0e}",
            off(0),
            off(1),
            swim.fold(0.0, f64::max),
            right.fold(0.0, f64::max)
        );
    }
}

/// The square about a point, each pixel magnified.
fn magnified(picture: &Picture, middle: &Point2<f64>) -> Picture {
    let corner = [middle.x, middle.y].map(|c| (c - f64::from(DETAIL_SIDE) / 2.0).round() as i64);
    let side = DETAIL_SIDE * MAGNIFIED;
    let mut data = Vec::with_capacity((side * side * 3) as usize);
    for y in 0..side {
        for x in 0..side {
            let [px, py] =
                [(x, corner[0]), (y, corner[1])].map(|(k, c)| c + i64::from(k / MAGNIFIED));
            data.extend(pixel(picture, px, py));
        }
    }
    Picture { width: side, height: side, channels: 3, data, orientation: 1 }
}

fn pixel(picture: &Picture, x: i64, y: i64) -> [u8; 3] {
    let inside =
        (0..i64::from(picture.width)).contains(&x) && (0..i64::from(picture.height)).contains(&y);
    let start = ((y * i64::from(picture.width) + x) * 3) as usize;
    let found = if inside { picture.data.get(start..start + 3) } else { None };
    found.and_then(|p| p.try_into().ok()).unwrap_or([255; 3])
}

/// Pictures in a row on white.
fn beside(pictures: &[Picture]) -> Picture {
    let height = pictures.iter().map(|p| p.height).max().unwrap_or(0);
    let width = pictures.iter().map(|p| p.width + GAP).sum::<u32>().saturating_sub(GAP);
    let mut data = Vec::with_capacity((width * height * 3) as usize);
    for y in 0..i64::from(height) {
        for (i, p) in pictures.iter().enumerate() {
            let gap = if i == 0 { 0 } else { i64::from(GAP) };
            for x in -gap..i64::from(p.width) {
                data.extend(pixel(p, x, y));
            }
        }
    }
    Picture { width, height, channels: 3, data, orientation: 1 }
}

/// Pictures of one width below each other on white.
fn below(rows: &[Picture]) -> Picture {
    let width = rows.iter().map(|p| p.width).max().unwrap_or(0);
    let mut data = Vec::new();
    let mut height = 0;
    for (i, p) in rows.iter().enumerate() {
        let gap = if i == 0 { 0 } else { i64::from(GAP) };
        for y in -gap..i64::from(p.height) {
            for x in 0..i64::from(width) {
                data.extend(pixel(p, x, y));
            }
        }
        height += p.height + gap as u32;
    }
    Picture { width, height, channels: 3, data, orientation: 1 }
}
