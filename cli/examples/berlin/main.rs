//! Three photographs of the Berlin cathedral, from the reconstruction's points to a new view.
//!
//! ```sh
//! cargo run --release -p collinear-cli --example berlin [-- DATA_DIR OUT_DIR]
//! ```
//!
//! Planes are found in the points; the façade is rectified face-on from each photograph; a model of planes is textured
//! from the photographs through [WD] eq. 1 and the lens, and seen from where no photograph was taken; and the same is drawn
//! with linear and bilinear texture coordinates, as in [WD] figure 2. The data is not part of the repository: without it
//! the program says so and ends.
#![allow(clippy::print_stdout, reason = "the program's output")]

mod compare;
mod facade;
mod model;
mod patches;
mod planes;
mod sight;
mod site;
mod view;

use std::path::{Path, PathBuf};

use anyhow::{Context, Result};

use collinear_io::Document;
use collinear_io::scene::Interpolation;

use model::Stairs;
use planes::Found;
use sight::Sight;
use site::{Site, plane_file};

/// Where the new view is seen from and what it looks at, in building coordinates: metres to the right, into the façade and
/// up from the camera of photograph 01.
const EYE: [f64; 3] = [3.4, 3.5, 1.4];
const TARGET: [f64; 3] = [0.8, 24.0, 5.4];

fn main() -> Result<()> {
    let workspace = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let mut arguments = std::env::args_os().skip(1).map(PathBuf::from);
    let data = arguments.next().unwrap_or_else(|| {
        let shared = std::env::var_os("COLLINEAR_DATA");
        shared.map_or_else(|| workspace.join("../shared/data"), PathBuf::from).join("berlin")
    });
    let out = arguments.next().unwrap_or_else(|| workspace.join("target/berlin"));
    if !data.join("reconstruction_example.json").exists() {
        println!(
            "skipped: {} has no reconstruction (COLLINEAR_DATA names its folder)",
            data.display()
        );
        return Ok(());
    }
    std::fs::create_dir_all(&out).with_context(|| out.display().to_string())?;
    let site = Site::read(&data)?;
    print_planes(&site, &out)?;
    println!("rectified, {}:", out.join("facade_*.png").display());
    facade::rectify(&site, &out)?;
    new_view(&site, &out)?;
    Ok(())
}

/// The model from where no photograph was taken.
fn new_view(site: &Site, out: &Path) -> Result<()> {
    let stairs = Stairs::find(site)?;
    for (name, flight) in [("lower", &stairs.lower), ("upper", &stairs.upper)] {
        let file = plane_file(flight, *site.axes.up, &site.origin)?;
        print_plane(&format!("{name} flight of steps"), flight, &file);
        file.write(&out.join(format!("plane_steps_{name}.json")))?;
    }
    let faces = model::faces(site, &stairs)?;
    let sight = Sight::new(&faces)?;
    let camera = view::look(site, [1400, 1200], 1150.0, EYE, TARGET)?;
    println!("the new view, {} polygons:", faces.len());
    for (i, face) in faces.iter().enumerate() {
        let seen: Vec<String> = sight
            .views(i, &site.photographs)
            .iter()
            .map(|v| {
                let name = &site.photographs[v.photograph].name;
                format!("{name} ({:.0} %, {:.0} pixels/m)", 100.0 * v.share, v.pixels)
            })
            .collect();
        println!("  {}: {}", face.name, seen.join(", "));
    }
    view::overlays(site, &faces, &camera, out)?;
    let gains = view::gains(site);
    let photographs = view::expose(site, &gains, out)?;
    let polygons = patches::polygons(site, &faces, &sight, &gains)?;
    println!("  cut into {} patches that one photograph sees", polygons.len());
    view::lens_offsets(site, &faces, &sight, &camera)?;
    let scene = view::scene(&photographs, polygons, camera, Interpolation::Perspective);
    view::draw(&scene, out, "berlin")?;
    println!("perspective, linear and bilinear texture coordinates:");
    compare::compare(site, &photographs, out)
}

fn print_planes(site: &Site, out: &Path) -> Result<()> {
    println!("{} points; the largest planes, one after another:", site.points.len());
    for (i, found) in site.largest.iter().enumerate() {
        let file = plane_file(found, collinear::nalgebra::Vector3::z(), &site.origin)?;
        print_plane(&format!("{}", i + 1), found, &file);
        file.write(&out.join(format!("plane_{}.json", i + 1)))?;
    }
    let tilt = site.axes.up.z.acos().to_degrees();
    println!(
        "the building's axes: up {:.4?}, {tilt:.2}° from the reconstruction's +Z; into the façade {:.4?}",
        site.axes.up.as_slice(),
        site.axes.inward.as_slice()
    );
    println!(
        "planes parallel to the façade, by depth behind photograph {}:",
        site.photographs[0].name
    );
    for found in &site.sheets {
        let file = plane_file(found, *site.axes.up, &site.origin)?;
        print_plane(&format!("{:.2}", site.depth(found)), found, &file);
    }
    println!("  {} points on none of them", site.rest.len());
    Ok(())
}

fn print_plane(name: &str, found: &Found, file: &collinear_io::plane::PlaneFile) {
    let [x, y, z] = file.normal;
    print!(
        "  {name}: {} points, rms {:.3} m, normal ({x:.3}, {y:.3}, {z:.3})",
        found.points.len(),
        found.rms
    );
    if let Some(r) = file.rectangle {
        print!(", {:.2} to {:.2} right, {:.2} to {:.2} up", r.left, r.right, r.bottom, r.top);
    }
    println!();
}
