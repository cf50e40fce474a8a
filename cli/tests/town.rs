//! The view of the town against the same view cast by brute force, with code that shares nothing with the library.

#[path = "../../examples/town/brute_force/mod.rs"]
mod brute_force;

use std::path::{Path, PathBuf};

use brute_force::camera::Camera;
use brute_force::caster::{Sight, Town, in_parallel};
use brute_force::photographs::dome;
use collinear_cli::render::render_scene;
use collinear_io::Document;
use collinear_io::camera::{CameraFile, Interior};
use collinear_io::picture::Picture;
use collinear_io::scene::{SceneFile, SensorSource};
use collinear_io::sensor::SensorFile;

/// Every STEP-th pixel of every STEP-th row is cast; a prime, so that no pattern of the scene is hit in step.
const STEP: usize = 7;

#[test]
fn the_files_beside_the_photographs_are_what_the_program_writes() {
    let folder: PathBuf = [env!("CARGO_MANIFEST_DIR"), "..", "examples", "town"].iter().collect();
    let town = Town::new();
    let files = brute_force::scene_file::files(&town);
    // The scene, the plane, the points, the dome, and a camera for each photograph, the dome and the projector.
    assert_eq!(files.len(), 4 + town.photographs.len() + 2);
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

/// A picture against casting where nothing stands in the photographs' way: the mean difference, and the pixels compared. Of a fisheye those of
/// its hemisphere.
fn compare(town: &Town, camera: &Camera, picture: &Picture) -> (f64, u32) {
    let (width, height) = (camera.width, camera.height);
    assert_eq!((picture.width as usize, picture.height as usize), (width, height));
    let rows = in_parallel(height / STEP, |j| {
        let y = j * STEP + STEP / 2;
        let (mut sum, mut pixels) = (0.0f64, 0u32);
        for x in (STEP / 2..width).step_by(STEP) {
            let from_middle = (x as f64 + 0.5 - camera.principal_point.0)
                .hypot(y as f64 + 0.5 - camera.principal_point.1);
            let beyond = camera.fisheye && from_middle > width as f64 / 2.0;
            if beyond || town.sight(camera, x, y) != Sight::Unoccluded {
                continue;
            }
            let cast = town.pixel(camera, x, y);
            let at = (y * width + x) * usize::from(picture.channels);
            let drawn = &picture.data[at..at + 3];
            let difference: f64 = cast
                .iter()
                .zip(drawn)
                .map(|(c, d)| ((c + 0.5).floor() - f64::from(*d)).abs())
                .sum();
            sum += difference / 3.0;
            pixels += 1;
        }
        (sum, pixels)
    });
    let (sum, pixels) = rows.into_iter().fold((0.0, 0), |a, r| (a.0 + r.0, a.1 + r.1));
    (sum / f64::from(pixels), pixels)
}

fn town_scene() -> SceneFile {
    let file: PathBuf =
        [env!("CARGO_MANIFEST_DIR"), "..", "examples", "town", "town.json"].iter().collect();
    SceneFile::open(&file).unwrap()
}

#[test]
fn the_new_view_is_what_brute_force_casts_where_nothing_stands_in_the_photographs_way() {
    let rendered = render_scene(&town_scene(), Path::new(""), &|_, _| ()).unwrap();
    assert!(rendered.report.refused.is_empty(), "{:?}", rendered.report.refused);
    let town = Town::new();
    let (mean, pixels) = compare(&town, &town.view, &rendered.picture);
    println!("mean {mean:.4}/255 over {pixels} pixels");
    let all = town.view.width * town.view.height / (STEP * STEP);
    assert!(pixels as usize > all * 8 / 10, "{pixels} pixels compared");
    assert!(mean <= 0.5, "mean difference {mean} of 255");
}

/// The same scene on a fisheye's screen, by lines of sight, and on a pinhole's by them.
#[test]
fn a_dome_master_is_what_brute_force_casts() {
    let town = Town::new();
    let mut scene = town_scene();
    let path: PathBuf =
        [env!("CARGO_MANIFEST_DIR"), "..", "examples", "town", "dome.camera.json"].iter().collect();
    scene.view = SensorSource::Inline(CameraFile::read(&path).unwrap().into());
    let rendered = render_scene(&scene, Path::new(""), &|_, _| ()).unwrap();
    assert!(rendered.report.refused.is_empty(), "{:?}", rendered.report.refused);
    let (mean, pixels) = compare(&town, &dome(), &rendered.picture);
    println!("mean {mean:.4}/255 over {pixels} pixels");
    assert!(pixels > 2000, "{pixels} pixels compared");
    assert!(mean <= 0.8, "mean difference {mean} of 255");
}

/// A lens that does nothing takes the way of lines of sight to the picture of the scanlines.
#[test]
fn by_lines_of_sight_the_new_view_is_the_same() {
    let mut scene = town_scene();
    let SensorSource::Inline(SensorFile::Camera(camera)) = &mut scene.view else {
        panic!("the view is a camera")
    };
    (camera.width, camera.height) = (320, 200);
    let (principal_distance, principal_point) = ([250.0; 2], [160.0, 100.0]);
    let (k, p, skew) = ([0.0; 3], [0.0; 2], 0.0);
    camera.interior = Interior::Pinhole { principal_distance, principal_point, skew };
    let scanned = render_scene(&scene, Path::new(""), &|_, _| ()).unwrap().picture.data;
    let SensorSource::Inline(SensorFile::Camera(camera)) = &mut scene.view else {
        panic!("the view is a camera")
    };
    camera.interior = Interior::Brown { principal_distance, principal_point, skew, k, p };
    let cast = render_scene(&scene, Path::new(""), &|_, _| ()).unwrap().picture.data;
    // An edge within 1/256 of a centre, or the last digit of a coordinate, may turn a pixel.
    let pairs = scanned.chunks(3).zip(cast.chunks(3));
    let apart = |(a, b): &(&[u8], &[u8])| a.iter().zip(*b).any(|(a, b)| a.abs_diff(*b) > 1);
    let different = pairs.filter(apart).count();
    println!("{different} of 64000 pixels differ");
    assert!(different < 320, "{different} of 64000 pixels differ");
}
