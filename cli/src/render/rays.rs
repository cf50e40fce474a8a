//! A view whose pixels look each their own way: fisheyes, panoramas, lenses, scanners.

use std::collections::BTreeMap;
use std::num::NonZero;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;

use anyhow::{Result, anyhow};
use collinear::camera::SensorModel;
use collinear::error::Brief;
use collinear::geometry::Locus;
use collinear::nalgebra::{Point3, Vector3};
use collinear::resample::{Border, Filter};
use collinear::texturer::{
    Facets, Facing, PlaneTexture, RayCaster, RayPaint, Sight, TextureCoordinates,
};
use collinear_io::scene::{Fill, Polygon};

use super::{Remark, Report, Sources, no_plane, plane_of, text};

/// Rows drawn by each thread between two reports of progress.
const BAND: usize = 16;

/// What every polygon of a scene is cast with.
pub(super) struct Cast<'a> {
    pub(super) sources: &'a Sources<'a>,
    pub(super) sensor: &'a dyn SensorModel,
    pub(super) size: [u32; 2],
    pub(super) near: f64,
    pub(super) filter: Filter,
    pub(super) facing: Facing,
}

/// Where in its picture a polygon's points are.
type Coordinates<'a> = Box<TextureCoordinates<'a>>;

impl Cast<'_> {
    /// Draws polygons on rows of `width` pixels, red, green and blue, and tells what became of them.
    pub(super) fn polygons(
        &self,
        polygons: &[Polygon],
        data: &mut [u8],
        width: usize,
        step: &mut dyn FnMut(),
    ) -> Result<Report> {
        let mut report = Report::default();
        let worlds: Vec<Vec<Point3<f64>>> = polygons
            .iter()
            .map(|p| p.vertices.iter().map(|v| Point3::from(*v)).collect())
            .collect();
        let coordinates: Vec<Result<Option<Coordinates<'_>>, String>> =
            polygons.iter().zip(&worlds).map(|(p, world)| self.coordinates(p, world)).collect();
        let paints = polygons
            .iter()
            .zip(&coordinates)
            .map(|(p, coordinates)| self.paint(p, coordinates))
            .collect::<Result<Vec<_>>>()?;
        let (facets, none) = match Facets::new(&worlds) {
            Ok((facets, none)) => (Some(facets), none),
            Err(error) => (None, (0..polygons.len()).map(|i| (i, error)).collect()),
        };
        let none: BTreeMap<usize, collinear::Error> = none.into_iter().collect();
        let mut refused = vec![false; polygons.len()];
        for (index, polygon) in polygons.iter().enumerate() {
            let text = match (none.get(&index), &coordinates[index]) {
                // Where all are none, each by its own plane.
                (Some(error), _) => {
                    plane_of(&worlds[index]).err().unwrap_or_else(|| no_plane(*error))
                }
                (None, Err(reason)) => reason.clone(),
                (None, Ok(_)) => continue,
            };
            refused[index] = true;
            report.refused.push(Remark { polygon: index, name: polygon.name.clone(), text });
        }
        let seen: Vec<AtomicBool> = polygons.iter().map(|_| AtomicBool::new(false)).collect();
        if let Some(facets) = &facets {
            let (near, facing) = (self.near, self.facing);
            let caster = RayCaster { screen: self.sensor, facets, paints: &paints, facing, near };
            draw(&caster, data, width, &seen, step);
        }
        report.drawn = seen.iter().filter(|s| s.load(Ordering::Relaxed)).count();
        report.outside = polygons.len() - report.drawn - report.refused.len();
        for (index, polygon) in polygons.iter().enumerate() {
            if refused[index] || seen[index].load(Ordering::Relaxed) {
                continue;
            }
            if let Some(text) = self.nearer(&worlds[index]) {
                report.nearer.push(Remark { polygon: index, name: polygon.name.clone(), text });
            }
        }
        Ok(report)
    }

    /// What there is to say of a polygon that lies wholly before the near distance with a vertex in the picture.
    fn nearer(&self, world: &[Point3<f64>]) -> Option<String> {
        let mut farthest = 0.0_f64;
        let mut in_picture = false;
        for p in world {
            // A vertex without an image is farther than any.
            let image = self.sensor.project(p).ok()?;
            let Ok(Locus::Ray(ray)) = self.sensor.locus(&image) else { return None };
            farthest = farthest.max((p - ray.origin).norm());
            let [width, height] = self.size.map(f64::from);
            in_picture |= (0.0..width).contains(&image.x) && (0.0..height).contains(&image.y);
        }
        (in_picture && farthest < self.near).then(|| {
            let (depth, near) = (Brief(farthest), Brief(self.near));
            format!("lies up to a distance of {depth}, nearer than `near`, {near}")
        })
    }

    /// Where in its picture a polygon's points are, where it has a picture; or why it has none.
    fn coordinates(
        &self,
        polygon: &Polygon,
        world: &[Point3<f64>],
    ) -> Result<Option<Coordinates<'_>>, String> {
        match &polygon.fill {
            Fill::Color(_) => Ok(None),
            Fill::Photograph(name) => {
                let (_, camera) = self
                    .sources
                    .photographs
                    .get(name.as_str())
                    .ok_or("its photograph is not there")?;
                let sensor = camera.sensor();
                Ok(Some(Box::new(move |p| sensor.project(p))))
            }
            Fill::Texture { name, coordinates } => {
                let uvw: Vec<Vector3<f64>> =
                    coordinates.iter().map(|c| Vector3::new(c.u / c.w, c.v / c.w, c.w)).collect();
                let texture = PlaneTexture::from_vertices(world, &uvw)
                    .map_err(|e| format!("texture `{name}`: {e}"))?;
                Ok(Some(Box::new(move |p| texture.at(p))))
            }
        }
    }

    fn paint<'a>(
        &'a self,
        polygon: &'a Polygon,
        coordinates: &'a Result<Option<Coordinates<'_>>, String>,
    ) -> Result<RayPaint<'a, u8, 3>> {
        let (picture, border) = match &polygon.fill {
            Fill::Color(color) => return Ok(RayPaint::Flat(*color)),
            Fill::Photograph(name) => {
                let found = self.sources.photographs.get(name.as_str());
                (found.map(|f| &f.0), Border::Transparent)
            }
            Fill::Texture { name, .. } => {
                let found = self.sources.textures.get(name.as_str());
                (found.map(|f| &f.0), found.map_or(Border::Transparent, |f| f.1))
            }
        };
        let (Some(picture), Ok(Some(coordinates))) = (picture, coordinates) else {
            return Ok(RayPaint::Nothing);
        };
        let image = picture.view().map_err(|e| anyhow!(text(e)))?;
        let filter = self.filter;
        Ok(RayPaint::Picture { image, coordinates: coordinates.as_ref(), filter, border })
    }
}

/// Casts all rows, on all processors; each pixel is its own, so that the picture does not depend on their number.
fn draw(
    caster: &RayCaster<'_, u8, 3>,
    data: &mut [u8],
    width: usize,
    seen: &[AtomicBool],
    step: &mut dyn FnMut(),
) {
    let threads = thread::available_parallelism().map_or(1, NonZero::get);
    let mut rows: Vec<(usize, &mut [u8])> = data.chunks_exact_mut(3 * width).enumerate().collect();
    for band in rows.chunks_mut(BAND * threads) {
        let share = band.len().div_ceil(threads);
        thread::scope(|scope| {
            for part in band.chunks_mut(share) {
                scope.spawn(|| {
                    for (y, row) in part {
                        caster.row(*y, row, |_, sight: &Sight| {
                            if let Some(seen) = seen.get(sight.polygon) {
                                seen.store(true, Ordering::Relaxed);
                            }
                        });
                    }
                });
            }
        });
        band.iter().for_each(|_| step());
    }
}
