//! A scene file's view, drawn by the reference texturer.

mod rays;

use std::collections::HashMap;
use std::fmt;
use std::path::Path;

use anyhow::{Result, anyhow};
use collinear::camera::HomogeneousCamera;
use collinear::error::Brief;
use collinear::geometry::Plane;
use collinear::mapping::Map;
use collinear::nalgebra::{Point3, Vector3};
use collinear::resample::{Border, Filter, ImageView, ImageViewMut};
use collinear::texturer::{
    Canvas, Facing, Paint, ScreenPolygon, bilinear_quad, from_vertices, linear_triangles,
};
use collinear_io::convert::Camera;
use collinear_io::picture::Picture;
use collinear_io::scene::{self, Fill, Interpolation, Polygon, SceneFile};

use crate::photograph::{Photograph, PlaneMap};
use crate::picture::{Rgb, check_size};

/// Vertices farther from their common plane than this, as a part of the polygon's size, are told in the report.
const UNEVEN: f64 = 1e-6;

/// The picture of a scene, and what became of its polygons.
#[derive(Clone, Debug)]
pub struct RenderedScene {
    /// Red, green, blue.
    pub picture: Picture,
    /// What became of the polygons.
    pub report: Report,
}

/// What became of a scene's polygons.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Report {
    /// Polygons drawn, hidden ones among them.
    pub drawn: usize,
    /// Polygons that show the side which is not drawn.
    pub culled: usize,
    /// Polygons before the near distance, or of no area on the screen.
    pub outside: usize,
    /// Those of them that would be seen if the near distance were smaller.
    pub nearer: Vec<Remark>,
    /// Polygons that could not be drawn.
    pub refused: Vec<Remark>,
    /// Polygons that were drawn otherwise than the scene asks.
    pub notes: Vec<Remark>,
}

/// Something to say about a polygon.
#[derive(Clone, Debug, PartialEq)]
pub struct Remark {
    /// Its place in the scene file, from 0.
    pub polygon: usize,
    /// Its name, where it has one.
    pub name: Option<String>,
    /// What there is to say.
    pub text: String,
}

impl fmt::Display for Remark {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "polygons[{}]", self.polygon)?;
        if let Some(name) = &self.name {
            write!(f, " `{name}`")?;
        }
        write!(f, ": {}", self.text)
    }
}

/// Draws the view of a scene.
///
/// Paths in the scene start from `folder`; of a scene from [`SceneFile::open`] they start from the working folder, and
/// `folder` is empty. `progress` is called with the number of steps done and of all steps: a picture read is a step, a
/// polygon is another.
///
/// A polygon whose photograph's camera has no lens errors is drawn through
/// [`FractionalLinear`](collinear::mapping::FractionalLinear) alone, one with Brown's lens through
/// [`PhotographMap`](collinear::mapping::PhotographMap), any other through
/// [`CentralPhotographMap`](collinear::mapping::CentralPhotographMap), one of a scanner point by point. A view that is neither pinhole nor
/// orthographic, as a fisheye, a panorama or a scanner, is cast pixel by pixel with a
/// [`RayCaster`](collinear::texturer::RayCaster). What lies outside its photograph stays undrawn. Opacity in pictures is passed over; grey becomes colour. A polygon that cannot be drawn, as one whose plane passes through the eye, is left out and
/// [reported](Report::refused).
///
/// # Errors
/// A file that cannot be read, a photograph of another size than its camera's, a view larger than
/// [`LARGEST_SIDE`](crate::LARGEST_SIDE) or [`LARGEST_AREA`](crate::LARGEST_AREA).
pub fn render_scene(
    scene: &SceneFile,
    folder: &Path,
    progress: &dyn Fn(usize, usize),
) -> Result<RenderedScene> {
    let scene = scene.resolved(folder)?;
    let view = scene.view.sensor(Path::new(""))?;
    let [width, height] = view.size();
    check_size(width, height).map_err(|e| anyhow!("view: {e}"))?;
    let taken = Photograph::new(&view).map_err(|e| anyhow!("view: {e}"))?;
    // A parallel view has no near distance, nor has one whose middle sees nothing a place to measure it from.
    let eye = taken.eye([width, height]).unwrap_or_else(Point3::origin);
    let near = scene.near_distance(&eye.into());
    let screen = match taken.camera() {
        Some(Camera::Pinhole(frame)) => Some(frame.homogeneous()),
        Some(Camera::Orthographic(camera)) => Some(camera.homogeneous()),
        _ => None,
    };
    if screen.is_none() && scene.interpolation != Interpolation::Perspective {
        return Err(anyhow!(
            "interpolation: wrong ones are drawn in a view of the model `pinhole` or `orthographic` alone"
        ));
    }
    let work = if screen.is_some() { scene.polygons.len() } else { height as usize };
    let total = scene.photographs.len() + scene.textures.len() + work;
    let mut done = 0;
    let mut step = || {
        done += 1;
        progress(done, total);
    };
    progress(0, total);
    let sources = Sources::read(&scene, &mut step)?;
    let filter = match scene.filter {
        scene::Filter::Nearest => Filter::Nearest,
        scene::Filter::Bilinear => Filter::Bilinear,
    };
    let facing = match scene.cull {
        scene::Cull::None => Facing::Both,
        scene::Cull::Back => Facing::Front,
    };
    let mut data = scene.background.repeat(width as usize * height as usize);
    let (columns, rows) = (width as usize, height as usize);
    let report = match &screen {
        Some(screen) => {
            let mut canvas = Canvas::new(ImageViewMut::<u8, 3>::new(&mut data, columns, rows)?);
            let interpolation = scene.interpolation;
            let mut draw = Draw {
                sources: &sources,
                screen,
                near,
                filter,
                facing,
                interpolation,
                canvas: &mut canvas,
            };
            draw.polygons(&scene.polygons, &mut step)
        }
        None => {
            let sensor = taken.sensor();
            let size = [width, height];
            let cast = rays::Cast { sources: &sources, sensor, size, near, filter, facing };
            cast.polygons(&scene.polygons, &mut data, columns, &mut step)?
        }
    };
    let picture = Picture { width, height, channels: 3, data, orientation: 1 };
    Ok(RenderedScene { picture, report })
}

/// The pictures of a scene in memory, by name.
struct Sources<'a> {
    photographs: HashMap<&'a str, (Rgb, Photograph)>,
    textures: HashMap<&'a str, (Rgb, Border)>,
}

impl<'a> Sources<'a> {
    /// Reads the pictures that a polygon shows.
    fn read(scene: &'a SceneFile, step: &mut dyn FnMut()) -> Result<Self> {
        let shown = |fill: &dyn Fn(&Fill) -> bool| scene.polygons.iter().any(|p| fill(&p.fill));
        let mut photographs = HashMap::new();
        for (i, p) in scene.photographs.iter().enumerate() {
            if shown(&|f| matches!(f, Fill::Photograph(name) if *name == p.name)) {
                let file = p.camera.sensor(Path::new(""))?;
                let camera =
                    Photograph::new(&file).map_err(|e| anyhow!("photographs[{i}].camera: {e}"))?;
                let picture = Rgb::read_sized(&p.image, &file)
                    .map_err(|e| anyhow!("photographs[{i}].image: {e}"))?;
                photographs.insert(p.name.as_str(), (picture, camera));
            }
            step();
        }
        let mut textures = HashMap::new();
        for (i, t) in scene.textures.iter().enumerate() {
            if shown(&|f| matches!(f, Fill::Texture { name, .. } if *name == t.name)) {
                let border = match t.border {
                    scene::Border::Clamp => Border::Clamp,
                    scene::Border::Repeat => Border::Repeat,
                    scene::Border::Mirror => Border::Mirror,
                    scene::Border::Transparent => Border::Transparent,
                };
                let picture =
                    Rgb::read(&t.image).map_err(|e| anyhow!("textures[{i}].image: {e}"))?;
                textures.insert(t.name.as_str(), (picture, border));
            }
            step();
        }
        Ok(Self { photographs, textures })
    }
}

enum Outcome {
    Drawn {
        notes: Vec<String>,
    },
    Culled,
    Outside,
    /// Wholly before the near distance, and seen otherwise.
    Nearer {
        /// That of its farthest vertex.
        depth: f64,
    },
}

/// A polygon may be so much nearer than the near distance, as a part of its farthest vertex's depth, and is still looked
/// for. It is far from what makes a vertex in the eye's own plane.
const STILL_BEFORE_THE_EYE: f64 = 1e-9;

/// What every polygon of a scene is drawn with.
struct Draw<'a, 'b> {
    sources: &'a Sources<'a>,
    screen: &'a HomogeneousCamera,
    near: f64,
    filter: Filter,
    facing: Facing,
    interpolation: Interpolation,
    canvas: &'a mut Canvas<'b, u8, 3>,
}

impl Draw<'_, '_> {
    /// Draws polygons, and tells what became of them.
    fn polygons(&mut self, polygons: &[Polygon], step: &mut dyn FnMut()) -> Report {
        let mut report = Report::default();
        for (index, polygon) in polygons.iter().enumerate() {
            let remark = |text| Remark { polygon: index, name: polygon.name.clone(), text };
            match self.polygon(polygon) {
                Ok(Outcome::Drawn { notes }) => {
                    report.drawn += 1;
                    report.notes.extend(notes.into_iter().map(remark));
                }
                Ok(Outcome::Culled) => report.culled += 1,
                Ok(Outcome::Outside) => report.outside += 1,
                Ok(Outcome::Nearer { depth }) => {
                    report.outside += 1;
                    let (depth, near) = (Brief(depth), Brief(self.near));
                    let text = format!("lies up to a depth of {depth}, nearer than `near`, {near}");
                    report.nearer.push(remark(text));
                }
                Err(reason) => report.refused.push(remark(reason)),
            }
            step();
        }
        report
    }

    /// Whether a polygon of which nothing is left would be seen with a smaller near distance.
    fn hidden_by_near(&self, world: &[Point3<f64>]) -> Outcome {
        let depth_of = |p: &Point3<f64>| {
            let row = self.screen.image_from_world().row(2).into_owned();
            (row * (p - self.screen.origin()).push(1.0)).x
        };
        let depth = world.iter().map(depth_of).fold(f64::NEG_INFINITY, f64::max);
        let nearer = depth * STILL_BEFORE_THE_EYE;
        if self.screen.is_parallel() || !(depth < self.near && nearer > 0.0) {
            return Outcome::Outside;
        }
        let mut seen = false;
        if let Ok(outline) = ScreenPolygon::project(world, self.screen, nearer) {
            let (width, height) = (self.canvas.width(), self.canvas.height());
            outline.spans(width, height, |_| seen = true);
            seen &= outline.shows(self.facing);
        }
        if seen { Outcome::Nearer { depth } } else { Outcome::Outside }
    }

    /// Draws one polygon, or says why it cannot be drawn.
    fn polygon(&mut self, polygon: &Polygon) -> Result<Outcome, String> {
        let world: Vec<Point3<f64>> = polygon.vertices.iter().map(|v| Point3::from(*v)).collect();
        let outline = ScreenPolygon::project(&world, self.screen, self.near).map_err(text)?;
        if outline.is_empty() {
            return Ok(self.hidden_by_near(&world));
        }
        if !outline.shows(self.facing) {
            return Ok(Outcome::Culled);
        }
        let (plane, uneven) = plane_of(&world)?;
        let nearness = self.screen.nearness(&plane).map_err(|e| match e {
            collinear::Error::Degenerate { measure, .. } => format!(
                "the view's eye lies in its plane and sees it as a line: it is {} off it",
                Brief(measure)
            ),
            other => other.to_string(),
        })?;
        let sources = self.sources;
        let (image, border, map): (ImageView<'_, u8, 3>, Border, Box<dyn Map>) = match &polygon.fill
        {
            Fill::Color(color) => {
                self.canvas.draw(&outline, nearness, &Paint::Flat(*color)).map_err(text)?;
                return Ok(Outcome::Drawn { notes: uneven.into_iter().collect() });
            }
            Fill::Photograph(name) => {
                let (picture, camera) =
                    sources.photographs.get(name.as_str()).ok_or("its photograph is not there")?;
                let map = PlaneMap::new(&plane, camera, self.screen)
                    .map_err(|e| format!("photograph `{name}`: {e}"))?;
                (picture.view().map_err(text)?, Border::Transparent, map.boxed())
            }
            Fill::Texture { name, coordinates } => {
                let (picture, border) =
                    sources.textures.get(name.as_str()).ok_or("its texture is not there")?;
                let uvw: Vec<Vector3<f64>> =
                    coordinates.iter().map(|c| Vector3::new(c.u / c.w, c.v / c.w, c.w)).collect();
                let map = from_vertices(&world, &uvw, self.screen)
                    .map_err(|e| format!("texture `{name}`: {e}"))?;
                (picture.view().map_err(text)?, *border, Box::new(map))
            }
        };
        let filter = self.filter;
        let draw = |canvas: &mut Canvas<'_, u8, 3>, outline: &ScreenPolygon, map: &dyn Map| {
            let paint = Paint::Texture { image, map, filter, border };
            canvas.draw(outline, nearness, &paint).map_err(text)
        };
        let mut notes = Vec::from_iter(uneven);
        let bilinear = match self.interpolation {
            Interpolation::Perspective => {
                draw(self.canvas, &outline, map.as_ref())?;
                return Ok(Outcome::Drawn { notes });
            }
            Interpolation::Bilinear => bilinear_quad(&outline, map.as_ref())
                .map_err(|e| notes.push(format!("drawn linearly instead of bilinearly: {e}")))
                .ok(),
            Interpolation::Linear => None,
        };
        if let Some(map) = bilinear {
            draw(self.canvas, &outline, &map)?;
        } else {
            for (piece, map) in linear_triangles(&outline, map.as_ref()).map_err(text)? {
                draw(self.canvas, &piece, &map)?;
            }
        }
        Ok(Outcome::Drawn { notes })
    }
}

/// A polygon's plane; and, where its vertices do not lie in one, a remark on how far they are off it.
fn plane_of(world: &[Point3<f64>]) -> Result<(Plane, Option<String>), String> {
    if let [a, b, c] = world {
        return Ok((Plane::through(a, b, c).map_err(no_plane)?, None));
    }
    let fit = Plane::fit(world).map_err(no_plane)?;
    let size = world.iter().map(|p| (p - fit.plane.point()).norm()).fold(0.0, f64::max);
    let off = fit.largest_residual;
    let note = (off > UNEVEN * size)
        .then(|| format!("drawn in the plane of best fit: vertices lie up to {off:.3e} off it"));
    Ok((fit.plane, note))
}

fn no_plane(error: collinear::Error) -> String {
    match error {
        collinear::Error::Degenerate { .. } => "its vertices lie on one line".into(),
        other => other.to_string(),
    }
}

fn text(error: impl fmt::Display) -> String {
    error.to_string()
}
