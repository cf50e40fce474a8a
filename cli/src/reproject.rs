//! A picture as another sensor would have it.

use std::path::Path;
use std::sync::Arc;

use anyhow::{Result, anyhow, ensure};
use collinear::geometry::{Dome, Plane, Surface};
use collinear::mapping::{Map, SensorMap};
use collinear::nalgebra::Point3;
use collinear::texturer::Facets;
use collinear_io::sensor::SensorFile;

use crate::obj;
use crate::photograph::Photograph;
use crate::picture::check_size;

/// A point and what the photograph sees at its pixel are the same to this part of the surface's size.
const SAME: f64 = 1e-6;

/// What both sensors look at.
#[derive(Clone, Debug)]
pub enum Scene {
    /// A plane.
    Plane(Plane),
    /// A dome, from either side.
    Dome(Dome),
    /// The faces of a mesh.
    Mesh(Arc<Facets>),
    /// What is so far away that only directions count.
    FarAway,
}

/// The faces of a Wavefront OBJ file as a surface, and how many of them are none.
///
/// # Errors
/// A file that cannot be read, makes no sense or has no face.
pub fn read_mesh(path: &Path) -> Result<(Scene, usize)> {
    let objects = obj::read(path)?;
    let faces: Vec<Vec<Point3<f64>>> = objects
        .into_iter()
        .flat_map(|o| o.elements)
        .filter(|e| e.is_face)
        .map(|e| e.corners)
        .collect();
    let name = path.display();
    ensure!(!faces.is_empty(), "{name}: there are no faces (`f` of a Wavefront OBJ file) in it");
    let (facets, refused) = Facets::new(&faces).map_err(|e| match e {
        collinear::Error::TooFewPoints { .. } => {
            anyhow!("{name}: none of its {} faces has an area", faces.len())
        }
        other => anyhow!("{name}: {other}"),
    })?;
    Ok((Scene::Mesh(Arc::new(facets)), refused.len()))
}

/// What leads from a sensor's picture into a photograph, over what both look at.
///
/// What the scene itself hides from the photograph is left out.
///
/// # Errors
/// A size that [`check_size`] refuses, a sensor out of its domain; far away, a sensor that has no projection centre.
pub fn photograph_from_screen(
    screen: &SensorFile,
    scene: &Scene,
    photograph: &SensorFile,
) -> Result<Box<dyn Map>> {
    let [width, height] = screen.size();
    check_size(width, height).map_err(|e| anyhow!("the new picture: {e}"))?;
    let made = Photograph::new(screen).map_err(|e| anyhow!("the new picture: {e}"))?;
    let taken = Photograph::new(photograph).map_err(|e| anyhow!("the photograph: {e}"))?;
    match scene {
        Scene::FarAway => {
            let central = |of: Photograph, role: &str| {
                of.into_central().ok_or_else(|| {
                    anyhow!(
                        "{role}: has not one projection centre, and so no picture of what is far away: \
                         give a plane, a dome or a mesh"
                    )
                })
            };
            let made = central(made, "the new picture")?;
            Ok(Box::new(SensorMap::distant(made, central(taken, "the photograph")?)))
        }
        Scene::Plane(plane) => over(made, *plane, taken, None),
        Scene::Dome(dome) => over(made, *dome, taken, Some(dome.sphere().radius())),
        Scene::Mesh(facets) => {
            let vertices = facets.mesh().vertices();
            let first = vertices.first().copied().unwrap_or_else(Point3::origin);
            let size = vertices.iter().map(|v| (v - first).norm()).fold(0.0, f64::max);
            over(made, Arc::clone(facets), taken, Some(size))
        }
    }
}

/// The map over a surface; of one that can hide itself, with its size.
fn over<U: Surface + 'static>(
    screen: Photograph,
    surface: U,
    photograph: Photograph,
    size: Option<f64>,
) -> Result<Box<dyn Map>> {
    let map = SensorMap::new(screen.into_sensor(), surface, photograph.into_sensor());
    Ok(match size {
        Some(size) => Box::new(map.hiding(SAME * size)?),
        None => Box::new(map),
    })
}
