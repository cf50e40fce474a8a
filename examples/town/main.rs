//! Makes the photographs of a small town, their cameras, the scene file that joins them to its polygons, and the plane and
//! the points that the readme's commands use.
//!
//! ```text
//! cargo run --release --example town -- [DIRECTORY]   write the photographs and the files
//!     --only NAME      one photograph; or `view`: the new view itself, cast directly; or `files`: no picture
//!     --preview N      everything at a scale of 1 : N, the new view too, without the files
//!     --check          read the photographs, resample the new view from them, compare it with casting
//! ```

mod brute_force;
mod check;

use std::error::Error;
use std::path::PathBuf;

use brute_force::caster::Town;
use brute_force::picture::write_png;
use brute_force::scene_file::files;

fn main() -> Result<(), Box<dyn Error>> {
    let mut directory = PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/examples/town"));
    let (mut compare, mut preview, mut only) = (false, 1, None);
    let mut arguments = std::env::args().skip(1);
    while let Some(argument) = arguments.next() {
        match argument.as_str() {
            "--check" => compare = true,
            "--preview" => preview = arguments.next().ok_or("--preview needs a number")?.parse()?,
            "--only" => only = Some(arguments.next().ok_or("--only needs a name")?),
            option if option.starts_with('-') => return Err(format!("unknown {option}").into()),
            path => directory = PathBuf::from(path),
        }
    }
    if preview == 0 {
        return Err("--preview needs a number from 1".into());
    }
    std::fs::create_dir_all(&directory)?;
    let town = Town::new();
    eprintln!("{} polygons", town.polygons.len());
    if compare {
        return check::run(&town, &directory);
    }
    let mut pictures: Vec<_> = town.photographs.iter().map(|p| (p.name, &p.camera)).collect();
    if preview > 1 || only.as_deref() == Some("view") {
        pictures.push(("view", &town.view));
    }
    for (name, camera) in pictures {
        if only.as_ref().is_none_or(|o| o == name) {
            let camera = camera.coarser(preview);
            let path = directory.join(format!("{name}.png"));
            let bytes = write_png(&path, &camera, &town.picture(&camera))?;
            eprintln!("{}: {bytes} bytes", path.display());
        }
    }
    if preview == 1 && only.is_none_or(|o| o == "files") {
        for (name, text) in files(&town) {
            std::fs::write(directory.join(name), text)?;
        }
    }
    Ok(())
}
