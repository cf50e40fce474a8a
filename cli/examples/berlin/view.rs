//! The new view: the model as a scene file, each polygon with the photograph that sees it best.

use std::collections::HashMap;
use std::path::Path;

use anyhow::{Result, anyhow};
use collinear::camera::{ExteriorOrientation, Frame, InteriorOrientation, SensorModel};
use collinear::nalgebra::Point2;
use collinear_cli::overlay::{Overlay, scene_figures};
use collinear_cli::render::render_scene;
use collinear_io::Document;
use collinear_io::camera::{CameraFile, Exterior, Interior};
use collinear_io::picture::{Picture, write_picture};
use collinear_io::scene::{
    self, Cull, Fill, Filter, Interpolation, Polygon, SceneFile, SensorSource,
};

use crate::model::Face;
use crate::sight::Sight;
use crate::site::Site;

/// A view without a lens: size and principal distance in pixels, eye and target in building coordinates.
pub(crate) fn look(
    site: &Site,
    [width, height]: [u32; 2],
    distance: f64,
    eye: [f64; 3],
    target: [f64; 3],
) -> Result<CameraFile> {
    let exterior =
        ExteriorOrientation::look_at(site.world(eye), site.world(target), *site.axes.up)?;
    Ok(CameraFile {
        width,
        height,
        interior: Interior::Pinhole {
            principal_distance: [distance; 2],
            principal_point: [f64::from(width) / 2.0, f64::from(height) / 2.0],
            skew: 0.0,
        },
        exterior: Exterior::from_orientation(&exterior),
    })
}

/// The gain that brings each photograph to the exposure of the first: the median ratio of the brightness of tracks that
/// both show.
pub(crate) fn gains(site: &Site) -> Vec<f64> {
    let mut by_photograph: Vec<HashMap<&str, f64>> = vec![HashMap::new(); site.photographs.len()];
    for o in &site.observations {
        let sum: f64 = o.color.iter().map(|c| f64::from(*c)).sum();
        let usable = o.color.iter().all(|c| (20..240).contains(c));
        let place = site.photographs.iter().position(|p| o.image.starts_with(&p.name));
        if let (true, Some(place)) = (usable, place) {
            by_photograph[place].insert(&o.track, sum);
        }
    }
    let Some(first) = by_photograph.first() else { return Vec::new() };
    let gain = |other: &HashMap<&str, f64>| {
        let mut ratios: Vec<f64> =
            other.iter().filter_map(|(track, sum)| Some(first.get(track)? / sum)).collect();
        ratios.sort_by(f64::total_cmp);
        ratios.get(ratios.len() / 2).copied().unwrap_or(1.0)
    };
    by_photograph.iter().map(gain).collect()
}

/// The photographs at one exposure, written beside the scene.
pub(crate) fn expose(site: &Site, gains: &[f64], out: &Path) -> Result<Vec<scene::Photograph>> {
    let mut photographs = Vec::new();
    for (p, gain) in site.photographs.iter().zip(gains) {
        println!("  photograph {}: gain {gain:.3}", p.name);
        let data = p.picture.data.iter().map(|v| (f64::from(*v) * gain).round() as u8).collect();
        let image = format!("photograph_{}.jpg", p.name);
        write_picture(&out.join(&image), &Picture { data, ..p.picture.clone() })?;
        photographs.push(scene::Photograph {
            name: p.name.clone(),
            image: image.into(),
            camera: SensorSource::Inline(p.camera.clone().into()),
        });
    }
    Ok(photographs)
}

/// A scene of the model.
pub(crate) fn scene(
    photographs: &[scene::Photograph],
    polygons: Vec<Polygon>,
    view: CameraFile,
    interpolation: Interpolation,
) -> SceneFile {
    SceneFile {
        photographs: photographs.to_vec(),
        textures: Vec::new(),
        polygons,
        view: SensorSource::Inline(view.into()),
        background: [24, 26, 30],
        near: Some(0.5),
        cull: Cull::None,
        filter: Filter::Bilinear,
        interpolation,
    }
}

/// Writes a scene, draws it, and says what was not drawn.
pub(crate) fn draw(scene: &SceneFile, out: &Path, name: &str) -> Result<Picture> {
    scene.write(&out.join(format!("{name}.json")))?;
    let rendered = render_scene(scene, out, &|_, _| ())?;
    for remark in rendered.report.refused.iter().chain(&rendered.report.notes) {
        println!("  {name}: {remark}");
    }
    write_picture(&out.join(format!("{name}.png")), &rendered.picture)?;
    Ok(rendered.picture)
}

/// The model as wire frames over each photograph.
pub(crate) fn overlays(site: &Site, faces: &[Face], view: &CameraFile, out: &Path) -> Result<()> {
    let polygon = |f: &Face| Polygon {
        name: Some(f.name.clone()),
        vertices: f.outline.iter().map(|p| (*p).into()).collect(),
        fill: Fill::Color([0; 3]),
    };
    let model =
        scene(&[], faces.iter().map(polygon).collect(), view.clone(), Interpolation::Perspective);
    let figures = scene_figures(&model);
    for p in &site.photographs {
        let picture =
            Overlay::trace(&figures, &p.camera.clone().into())?.draw_on(&p.picture, 4.0)?;
        write_picture(&out.join(format!("overlay_{}.jpg", p.name)), &picture)?;
    }
    Ok(())
}

/// How far off equation 1 alone would be, in pixels of the photograph, at the points that the view shows: median and
/// largest, over all of them and over those between a third and two thirds of the way from the photograph's middle to its
/// corner.
pub(crate) fn lens_offsets(
    site: &Site,
    faces: &[Face],
    sight: &Sight,
    view: &CameraFile,
) -> Result<()> {
    const STEP: usize = 4;
    let screen: Frame<InteriorOrientation> = match view.camera()? {
        collinear_io::convert::Camera::Pinhole(frame) => frame,
        _ => return Err(anyhow!("the view is not a pinhole")),
    };
    let best: Vec<_> =
        (0..faces.len()).map(|i| sight.views(i, &site.photographs).first().copied()).collect();
    let (mut all, mut middle) = (Vec::new(), Vec::new());
    for y in (0..view.height).step_by(STEP) {
        for x in (0..view.width).step_by(STEP) {
            let pixel = Point2::new(f64::from(x) + 0.5, f64::from(y) + 0.5);
            let collinear::geometry::Locus::Ray(ray) = screen.locus(&pixel)? else { continue };
            let Some((face, distance)) = sight.first(&ray) else { continue };
            let Some(seen) = best[face] else { continue };
            let photograph = &site.photographs[seen.photograph];
            let world = ray.at(distance);
            let (Ok(ideal), Ok(image)) =
                (photograph.frame.ideal().project(&world), photograph.frame.project(&world))
            else {
                continue;
            };
            let size = [photograph.camera.width, photograph.camera.height].map(f64::from);
            if !(0.0..size[0]).contains(&image.x) || !(0.0..size[1]).contains(&image.y) {
                continue;
            }
            let off = (ideal - image).norm();
            all.push(off);
            let radius = (image.x - size[0] / 2.0).hypot(image.y - size[1] / 2.0);
            let part = radius / (size[0] / 2.0).hypot(size[1] / 2.0);
            if (1.0 / 3.0..2.0 / 3.0).contains(&part) {
                middle.push(off);
            }
        }
    }
    for (what, offsets) in [("over the view", &mut all), ("in mid-field", &mut middle)] {
        offsets.sort_by(f64::total_cmp);
        if let (Some(median), Some(largest)) = (offsets.get(offsets.len() / 2), offsets.last()) {
            println!(
                "  equation 1 without the lens would be off by {median:.2} pixels in the median, {largest:.2} at most \
                 {what} ({} points)",
                offsets.len()
            );
        }
    }
    Ok(())
}
