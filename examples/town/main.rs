//! Makes the photographs of a small town and the scene file that joins them to its polygons.
//!
//! `cargo run --release --example town -- [DIRECTORY]` writes the files, `--check` compares the new view with one
//! resampled from the photographs, `--preview N` renders everything at a scale of 1 : N.

mod brute_force;
mod check;
mod output;

use std::error::Error;
use std::path::PathBuf;

use brute_force::caster::Town;

fn main() -> Result<(), Box<dyn Error>> {
    let mut directory = PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/examples/town"));
    let (mut check, mut preview) = (false, 1);
    let mut only = None;
    let mut arguments = std::env::args().skip(1);
    while let Some(argument) = arguments.next() {
        match argument.as_str() {
            "--check" => check = true,
            "--preview" => preview = arguments.next().ok_or("--preview needs a number")?.parse()?,
            "--only" => only = Some(arguments.next().ok_or("--only needs a name")?),
            path => directory = PathBuf::from(path),
        }
    }
    std::fs::create_dir_all(&directory)?;
    let town = Town::new();
    eprintln!("{} polygons", town.polygons.len());
    if check {
        return check::run(&town, &directory);
    }
    let wanted = |name: &str| only.as_ref().is_none_or(|o| o == name);
    for photograph in &town.photographs {
        if wanted(photograph.name) {
            let camera = photograph.camera.coarser(preview);
            let path = directory.join(format!("{}.png", photograph.name));
            let bytes = output::write_png(&path, &camera, &town.picture(&camera))?;
            eprintln!("{}: {bytes} bytes", path.display());
        }
    }
    if preview > 1 && wanted("view") {
        let camera = town.view.coarser(preview);
        output::write_png(&directory.join("view.png"), &camera, &town.picture(&camera))?;
    }
    if preview == 1 && only.is_none() {
        std::fs::write(directory.join("town.json"), output::scene_json(&town))?;
    }
    Ok(())
}
