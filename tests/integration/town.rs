//! The town in `examples/town`: its files are what its program makes, and the photographs are fine enough that
//! the new view can be resampled from them. Nothing of the library is in here.

#[path = "../../examples/town/brute_force/mod.rs"]
mod brute_force;

use std::path::PathBuf;
use std::sync::LazyLock;

use brute_force::camera::Camera;
use brute_force::caster::{Sight, Town, in_parallel};
use brute_force::picture::Image;
use brute_force::scene_file::scene_json;
use brute_force::vector::v3;
use serde_json::Value;

static TOWN: LazyLock<Town> = LazyLock::new(Town::new);

fn file(name: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("examples/town").join(name)
}

/// Equal but for the last digits of numbers, which sine and cosine of different machines may turn.
fn same(a: &Value, b: &Value) -> bool {
    match (a, b) {
        (Value::Number(a), Value::Number(b)) => {
            let (Some(a), Some(b)) = (a.as_f64(), b.as_f64()) else { return false };
            (a - b).abs() < 1e-9 + 1e-12 * b.abs()
        }
        (Value::Array(a), Value::Array(b)) => {
            a.len() == b.len() && a.iter().zip(b).all(|(a, b)| same(a, b))
        }
        (Value::Object(a), Value::Object(b)) => {
            a.len() == b.len() && a.iter().all(|(k, v)| b.get(k).is_some_and(|w| same(v, w)))
        }
        _ => a == b,
    }
}

#[test]
fn the_scene_file_is_what_the_program_writes() {
    let stored: Value =
        serde_json::from_str(&std::fs::read_to_string(file("town.json")).unwrap()).unwrap();
    let made: Value = serde_json::from_str(&scene_json(&TOWN)).unwrap();
    assert!(same(&stored, &made), "run `cargo run --release --example town`");
}

#[test]
fn every_polygon_is_plane() {
    for polygon in &TOWN.polygons {
        let frame = &polygon.frame;
        for p in &polygon.vertices {
            let off = frame.n.dot(*p - frame.origin);
            assert!(off.abs() < 1e-9, "{}: {off}", polygon.name);
        }
    }
}

#[test]
fn the_quaternion_of_a_camera_turns_the_world_into_its_axes() {
    for step in 0..360_u32 {
        let turn = f64::from(step) * 2.399;
        let target = v3(turn.cos(), turn.sin(), 1.9 * (0.7 * turn).sin());
        let camera = Camera::looking((8, 6), 7.0, v3(0.0, 0.0, 0.0), target, 1.3 * turn);
        let [w, x, y, z] = camera.quaternion();
        let rows = [
            v3(1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)),
            v3(2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)),
            v3(2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)),
        ];
        for (row, axis) in rows.into_iter().zip([camera.right, camera.down, camera.forward]) {
            assert!((row - axis).length() < 1e-14, "step {step}: {row:?} {axis:?}");
        }
    }
}

#[test]
fn the_photographs_show_what_the_caster_sees() {
    for photograph in &TOWN.photographs {
        let camera = &photograph.camera;
        let image = Image::read(&file(&format!("{}.png", photograph.name))).unwrap();
        assert_eq!((image.width, image.height), (camera.width, camera.height), "size");
        let off = in_parallel(camera.height / 67, |j| {
            let y = 67 * j + 20;
            let mut worst = 0.0_f64;
            for x in (11..camera.width).step_by(97) {
                let cast = TOWN.pixel(camera, x, y);
                for (c, value) in cast.iter().enumerate() {
                    let stored = f64::from(image.data[3 * (y * image.width + x) + c]);
                    worst = worst.max((stored - value).abs());
                }
            }
            worst
        });
        let worst = off.into_iter().fold(0.0, f64::max);
        assert!(worst < 1.0, "{}: {worst} of 255", photograph.name);
    }
}

#[test]
fn the_new_view_resampled_from_the_photographs_is_the_new_view() {
    const STEP: usize = 9;
    let town = &*TOWN;
    let images: Vec<Image> = town
        .photographs
        .iter()
        .map(|p| Image::read(&file(&format!("{}.png", p.name))).unwrap())
        .collect();
    let view = &town.view;
    let rows = in_parallel(view.height / STEP, |j| {
        let y = STEP * j + 4;
        let (mut sum, mut clear, mut hidden, mut count) = (0.0, 0_u32, 0_u32, 0_u32);
        for x in (4..view.width).step_by(STEP) {
            count += 1;
            let sight = town.sight(view, x, y);
            hidden += u32::from(sight == Sight::Hidden);
            if sight != Sight::Unoccluded {
                continue;
            }
            clear += 1;
            let hit = town.look(view, (x as f64 + 0.5, y as f64 + 0.5)).unwrap();
            let photograph = town.assigned[hit.polygon];
            let place = town.photographs[photograph].camera.project(hit.point).unwrap();
            let textured = images[photograph].bilinear(place);
            let cast = town.pixel(view, x, y);
            let difference =
                |c: usize| ((textured[c] + 0.5).floor() - (cast[c] + 0.5).floor()).abs();
            sum += (difference(0) + difference(1) + difference(2)) / 3.0;
        }
        (sum, clear, hidden, count)
    });
    let total =
        rows.into_iter().fold((0.0, 0, 0, 0), |a, b| (a.0 + b.0, a.1 + b.1, a.2 + b.2, a.3 + b.3));
    let mean = total.0 / f64::from(total.1);
    assert!(mean <= 0.4, "mean difference {mean} of 255");
    assert!(total.1 * 100 >= total.3 * 85, "unoccluded: {} of {}", total.1, total.3);
    assert!(total.2 * 100 <= total.3, "hidden: {} of {}", total.2, total.3);
}
