//! The view of the town against the same view cast by brute force, with code that shares nothing with the library.

#[path = "../../examples/town/brute_force/mod.rs"]
mod brute_force;

use std::path::{Path, PathBuf};

use brute_force::caster::{Sight, Town, in_parallel};
use collinear_cli::render::render_scene;
use collinear_io::scene::SceneFile;

/// Every STEP-th pixel of every STEP-th row is cast; a prime, so that no pattern of the scene is hit in step.
const STEP: usize = 7;

#[test]
fn the_files_beside_the_photographs_are_what_the_program_writes() {
    let folder: PathBuf = [env!("CARGO_MANIFEST_DIR"), "..", "examples", "town"].iter().collect();
    let town = Town::new();
    let files = brute_force::scene_file::files(&town);
    // The scene, the plane, the points, and a camera for each photograph.
    assert_eq!(files.len(), 3 + town.photographs.len());
    // Sine and cosine of different machines may turn a number's last digits.
    let split = |text: &str| -> (String, Vec<f64>) {
        let is_number = |c: char| c.is_ascii_digit() || "+-.e".contains(c);
        let words = text.split(|c| !is_number(c)).filter_map(|w| w.parse().ok()).collect();
        (text.split(is_number).collect(), words)
    };
    for (name, made) in files {
        let stored = std::fs::read_to_string(folder.join(&name)).unwrap();
        let ((made, numbers), (stored, old)) = (split(&made), split(&stored));
        assert!(made == stored && numbers.len() == old.len(), "{name}: run the example `town`");
        for (a, b) in numbers.iter().zip(&old) {
            assert!((a - b).abs() < 1e-9 + 1e-12 * b.abs(), "{name}: {a} is {b}");
        }
    }
}

#[test]
fn the_new_view_is_what_brute_force_casts_where_nothing_stands_in_the_photographs_way() {
    let file: PathBuf =
        [env!("CARGO_MANIFEST_DIR"), "..", "examples", "town", "town.json"].iter().collect();
    let scene = SceneFile::open(&file).unwrap();
    let rendered = render_scene(&scene, Path::new(""), &|_, _| ()).unwrap();
    assert!(rendered.report.refused.is_empty(), "{:?}", rendered.report.refused);
    let picture = rendered.picture;
    let town = Town::new();
    let (width, height) = (town.view.width, town.view.height);
    assert_eq!((picture.width as usize, picture.height as usize), (width, height));
    let rows = in_parallel(height / STEP, |j| {
        let y = j * STEP + STEP / 2;
        let (mut sum, mut pixels, mut worst) = (0.0f64, 0u32, 0.0f64);
        for x in (STEP / 2..width).step_by(STEP) {
            if town.sight(&town.view, x, y) != Sight::Unoccluded {
                continue;
            }
            let cast = town.pixel(&town.view, x, y);
            let at = (y * width + x) * usize::from(picture.channels);
            let drawn = &picture.data[at..at + 3];
            let difference: f64 = cast
                .iter()
                .zip(drawn)
                .map(|(c, d)| ((c + 0.5).floor() - f64::from(*d)).abs())
                .sum();
            sum += difference / 3.0;
            worst = worst.max(difference / 3.0);
            pixels += 1;
        }
        (sum, pixels, worst)
    });
    let (sum, pixels, worst) =
        rows.into_iter().fold((0.0, 0, 0.0f64), |a, r| (a.0 + r.0, a.1 + r.1, a.2.max(r.2)));
    let mean = sum / f64::from(pixels);
    println!("mean {mean:.4}/255 over {pixels} pixels, largest {worst:.1}");
    assert!(pixels as usize > width * height / (STEP * STEP) * 8 / 10, "{pixels} pixels compared");
    assert!(mean <= 0.5, "mean difference {mean} of 255");
}
