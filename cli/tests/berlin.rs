//! Three real photographs: each resected from the reconstruction's points, and the points intersected from the photographs.

use std::fmt::Write;
use std::path::PathBuf;

use collinear_cli::intersect::{Photograph, run as intersect};
use collinear_cli::resect::{Options, run as resect};
use collinear_io::control::ControlRow;
use collinear_io::convert::Camera;
use collinear_io::observations::ObservationRow;
use collinear_io::opensfm::{read_reconstruction, read_tracks};

/// The folder of the photographs' reconstruction, or a printed line where it is not there.
fn data() -> Option<PathBuf> {
    let repository: PathBuf = [env!("CARGO_MANIFEST_DIR"), "..", ".."].iter().collect();
    let shared = std::env::var_os("COLLINEAR_DATA");
    let folder =
        shared.map_or_else(|| repository.join("shared/data"), PathBuf::from).join("berlin");
    if folder.join("reconstruction_example.json").exists() {
        return Some(folder);
    }
    let mut line = String::new();
    let _ = write!(
        line,
        "skipped: {} is not there (COLLINEAR_DATA names its folder)",
        folder.display()
    );
    std::io::Write::write_all(&mut std::io::stderr(), line.as_bytes()).unwrap();
    None
}

#[test]
fn photographs_stand_where_their_reconstruction_put_them_and_points_too() {
    let Some(folder) = data() else { return };
    let model = read_reconstruction(&folder.join("reconstruction_example.json"), 0).unwrap();
    let tracks = read_tracks(&folder.join("tracks_example.csv")).unwrap();
    let mut photographs = Vec::new();
    let mut rows = Vec::new();
    for name in model.shots.keys() {
        let file = model.camera(name).unwrap();
        let mut control = Vec::new();
        for track in tracks.iter().filter(|t| t.image == *name) {
            let Some(point) = model.points.get(&track.track) else { continue };
            let image = track.pixel(file.width, file.height);
            rows.push(ObservationRow {
                photo: name.clone(),
                id: track.track.clone(),
                image,
                sigma: None,
            });
            control.push(ControlRow {
                id: Some(track.track.clone()),
                world: point.coordinates,
                image: Some(image),
                ..ControlRow::default()
            });
        }
        let options =
            Options { sigma: 1.0, estimate: vec![], robust: Some(8.0), seed: 0, trust: false };
        let outcome = resect(&file, &control, &options).unwrap();
        // OpenSfM's own adjustment of all three with another loss: the same within a centimetre, of a building 40 m away.
        let (found, given) = (&outcome.camera.exterior, &file.exterior);
        for i in 0..3 {
            let off = found.projection_center[i] - given.projection_center[i];
            assert!(off.abs() < 0.01, "{name}: {off}");
        }
        let used = outcome.points.iter().filter(|p| p.used).count();
        assert!(used as f64 > 0.95 * control.len() as f64, "{name}: {used} of {}", control.len());
        let sensor = file.camera().map(Camera::into_sensor).unwrap();
        photographs.push(Photograph { name: name.clone(), sensor });
    }
    let points = intersect(&photographs, &rows, 1.0, false, &|_, _| {}).unwrap();
    assert_eq!(points.len(), 1430);
    let mut off: Vec<f64> = points
        .iter()
        .map(|p| {
            let found = p.found.as_ref().unwrap().point;
            let given = model.points[&p.id].coordinates;
            (0..3).map(|i| (found[i] - given[i]).powi(2)).sum::<f64>().sqrt()
        })
        .collect();
    off.sort_by(f64::total_cmp);
    assert!(off[off.len() / 2] < 0.01, "median {}", off[off.len() / 2]);
}
