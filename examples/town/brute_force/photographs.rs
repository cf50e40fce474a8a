//! Where the photographs were taken, the new view, and which photograph each polygon is textured from.

use super::camera::Camera;
use super::caster::{Town, in_parallel};
use super::polygon::Polygon;
use super::vector::{V3, v3};

#[derive(Clone, Debug)]
pub(crate) struct Photograph {
    pub(crate) name: &'static str,
    pub(crate) camera: Camera,
}

/// The new view: no photograph was taken there.
pub(crate) fn view() -> Camera {
    Camera::looking((1280, 800), 1000.0, v3(2.0, -58.0, 24.5), v3(-1.0, 20.0, 10.2), 0.0)
}

/// The dome master: a hemisphere about a place over the square, as of a simulator that looks north and 16° down.
pub(crate) fn dome() -> Camera {
    let center = v3(2.0, -40.0, 18.0);
    let quarter = std::f64::consts::FRAC_PI_2;
    let camera = Camera::looking((1024, 1024), 512.0 / quarter, center, center + dome_axis(), 0.0);
    Camera { fisheye: true, ..camera }
}

/// A projector behind and above the audience of that dome, which is open to the back.
pub(crate) fn projector() -> Camera {
    let target = dome().center + dome_axis() * DOME_RADIUS;
    Camera::looking((1280, 800), 640.0, v3(2.0, -44.0, 22.0), target, 0.0)
}

/// The direction of the dome's middle.
pub(crate) fn dome_axis() -> V3 {
    v3(0.0, 0.96, -0.28)
}

/// The radius of the dome.
pub(crate) const DOME_RADIUS: f64 = 9.0;

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
    vec![
        shot(
            "square",
            (1360, 1000),
            1250.0,
            v3(-3.0, -40.0, 31.0),
            v3(-1.0, 30.0, 16.0),
            0.01,
            lens,
            decentred,
        ),
        shot(
            "south",
            (1260, 920),
            1050.0,
            v3(-20.0, -76.0, 56.0),
            v3(-12.5, 6.0, 1.0),
            0.02,
            lens,
            decentred,
        ),
        shot(
            "west",
            (1300, 975),
            1400.0,
            v3(-64.0, -30.0, 50.0),
            v3(9.0, 4.0, 1.0),
            -0.03,
            lens,
            decentred,
        ),
        shot(
            "east",
            (1100, 825),
            1100.0,
            v3(66.0, -26.0, 50.0),
            v3(-6.0, 2.0, 1.0),
            0.025,
            lens,
            decentred,
        ),
        shot(
            "north",
            (720, 540),
            693.0,
            v3(18.0, 104.0, 66.0),
            v3(4.0, 22.0, 0.0),
            -0.015,
            lens,
            decentred,
        ),
        shot(
            "above",
            (1000, 960),
            1150.0,
            v3(1.0, -3.0, 84.0),
            v3(1.0, 1.0, 0.0),
            0.0,
            lens,
            decentred,
        ),
        shot(
            "horizon",
            (1320, 704),
            757.0,
            v3(0.0, -10.0, 80.0),
            v3(-5.0, 90.0, 58.0),
            0.01,
            lens,
            decentred,
        ),
    ]
}

/// For each polygon the photograph that sees it best: unhidden first, then finest.
pub(crate) fn assign(town: &Town) -> Vec<usize> {
    in_parallel(town.polygons.len(), |i| best(town, i, &town.polygons[i]))
}

fn best(town: &Town, index: usize, polygon: &Polygon) -> usize {
    let all = samples(polygon);
    // What the new view shows of the polygon counts; all of it where the view shows nothing.
    let shown: Vec<_> =
        all.iter().copied().filter(|&p| town.sees(&town.view, index, p).is_some()).collect();
    let points = if shown.is_empty() { all } else { shown };
    let rate = |photograph: &Photograph| {
        let camera = &photograph.camera;
        let mut sum = 0.0;
        let mut seen = 0.0;
        let mut framed = 0.0;
        for &p in &points {
            if camera.project(p).is_none() {
                continue;
            }
            framed += 1.0;
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
        // Hidden parts show something else, parts outside the frame nothing at all.
        let count = points.len() as f64;
        let (share, framed) = (seen / count, f64::powi(framed / count, 500));
        if seen > 0.0 { sum / seen * f64::powi(share, 30) * framed } else { 0.0 }
    };
    let rates: Vec<f64> = town.photographs.iter().map(rate).collect();
    (0..rates.len()).max_by(|&i, &j| rates[i].total_cmp(&rates[j])).unwrap_or(0)
}

/// A lattice of points inside the polygon.
fn samples(polygon: &Polygon) -> Vec<V3> {
    let (low, high) = polygon.extent();
    let across = (high.0 - low.0).max(high.1 - low.1);
    let n = ((across / 0.4) as usize).clamp(5, 45);
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
