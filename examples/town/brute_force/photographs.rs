//! Where the photographs were taken, the new view, and which photograph each polygon is textured from.

use super::camera::Camera;
use super::caster::Town;
use super::paint::Paint;
use super::polygon::Polygon;
use super::vector::v3;

#[derive(Clone, Debug)]
pub(crate) struct Photograph {
    pub(crate) name: &'static str,
    pub(crate) camera: Camera,
}

/// The new view: no photograph was taken there.
pub(crate) fn view() -> Camera {
    Camera::looking((1280, 800), 1120.0, v3(-6.0, -66.0, 25.0), v3(0.5, 20.0, 7.0), 0.0)
}

pub(crate) fn all() -> Vec<Photograph> {
    let shot = |name, size, principal_distance, center, target, roll, k, p| {
        let mut camera = Camera::looking(size, principal_distance, center, target, roll);
        let (x, y) = camera.principal_point;
        camera.principal_point = (x + 4.3, y - 2.8);
        camera.k = k;
        camera.p = p;
        Photograph { name, camera }
    };
    let lens = [-0.062, 0.018, -0.0021];
    let decentred = [0.0006, -0.0004];
    let ring = (1500, 1125);
    vec![
        shot("south", ring, 1450.0, v3(-14.0, -88.0, 58.0), v3(-1.0, 7.0, 2.0), 0.02, lens, decentred),
        shot("west", ring, 1450.0, v3(-88.0, -20.0, 60.0), v3(3.0, 6.0, 2.0), -0.03, lens, decentred),
        shot("east", ring, 1450.0, v3(88.0, -22.0, 60.0), v3(-4.0, 6.0, 2.0), 0.025, lens, decentred),
        shot("north", ring, 1450.0, v3(18.0, 104.0, 66.0), v3(0.0, 10.0, 0.0), -0.015, lens, decentred),
        shot("above", (1300, 1300), 1300.0, v3(2.0, 3.0, 105.0), v3(1.0, 7.0, 0.0), 0.0, lens, decentred),
        shot("horizon", (1500, 600), 1180.0, v3(-2.0, 20.0, 78.0), v3(4.0, 120.0, 55.0), 0.01, lens, decentred),
    ]
}

/// For each polygon the photograph that sees it best: unhidden first, then finest.
pub(crate) fn assign(town: &Town) -> Vec<usize> {
    town.polygons.iter().enumerate().map(|(i, polygon)| best(town, i, polygon)).collect()
}

fn best(town: &Town, index: usize, polygon: &Polygon) -> usize {
    let points = samples(polygon);
    let rate = |photograph: &Photograph| {
        let camera = &photograph.camera;
        let mut sum = 0.0;
        let mut seen = 0.0;
        for &p in &points {
            if town.sees(camera, index, p).is_none() {
                continue;
            }
            let d = camera.center - p;
            let grazing = polygon.frame.n.dot(d) / d.length();
            // A surface seen from behind shows its other face: only sheets have one.
            if grazing <= 0.0 {
                continue;
            }
            seen += 1.0;
            sum += grazing * (camera.principal_distance.0 / d.length()).powi(2);
        }
        let share = seen / points.len() as f64;
        if seen > 0.0 { sum / seen * f64::powi(share, 8) } else { 0.0 }
    };
    let rates: Vec<f64> = town.photographs.iter().map(rate).collect();
    (0..rates.len()).max_by(|&i, &j| rates[i].total_cmp(&rates[j])).unwrap_or(0)
}

/// A lattice of points inside the polygon.
fn samples(polygon: &Polygon) -> Vec<super::vector::V3> {
    let (low, high) = polygon.extent();
    let n = if matches!(polygon.paint, Paint::Backdrop) { 41 } else { 13 };
    let mut points = Vec::new();
    for j in 0..n {
        for i in 0..n {
            let part = |k: usize| (k as f64 + 0.5) / n as f64;
            let s = low.0 + part(i) * (high.0 - low.0);
            let t = low.1 + part(j) * (high.1 - low.1);
            if polygon.contains(s, t) {
                points.push(polygon.frame.point(s, t));
            }
        }
    }
    points
}
