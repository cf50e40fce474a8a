//! The ground cut into tiles: rectangles, and L-shaped pieces at the corners of the map.

use super::backdrop;
use super::build::Builder;
use super::light::LightMap;
use super::paint::Paint;
use super::polygon::{Frame, Polygon};
use super::vector::v3;

/// Where the light map of the ground ends; beyond it nothing casts a shadow.
const LIT: ((f64, f64), (f64, f64)) = ((-135.0, -110.0), (150.0, 135.0));
const TEXEL: f64 = 0.14;

fn lines(near: (f64, f64), step: f64, far: &[f64]) -> Vec<f64> {
    let count = ((near.1 - near.0) / step).round() as usize;
    let mut all: Vec<f64> = (0..=count).map(|i| near.0 + step * i as f64).collect();
    all.extend(far);
    all.sort_by(f64::total_cmp);
    all
}

pub(crate) fn ground(b: &mut Builder) {
    let (side, north) = (backdrop::SIDE, backdrop::NORTH);
    let east = [32.0, 40.0, 48.0, 66.0, 90.0, 130.0, 220.0, 480.0, side];
    let xs = lines((-24.0, 24.0), 4.0, &east.map(|x| [-x, x]).concat());
    let south = [-300.0, -120.0, -48.0, -40.0, -32.0];
    let beyond = [32.0, 40.0, 48.0, 62.0, 84.0, 94.0, 105.0, 130.0, 175.0, 260.0, 420.0, north];
    let ys = lines((-24.0, 24.0), 4.0, &[&south[..], &beyond[..]].concat());
    let frame = Frame {
        origin: v3(0.0, 0.0, 0.0),
        u: v3(1.0, 0.0, 0.0),
        v: v3(0.0, 1.0, 0.0),
        n: v3(0.0, 0.0, 1.0),
    };
    let light = b.lights.len();
    b.lights.push(LightMap::new(frame, LIT.0, LIT.1, TEXEL));
    let mut tile = |name: String, corners: &[(f64, f64)]| {
        let vertices = corners.iter().map(|c| v3(c.0, c.1, 0.0)).collect();
        b.polygons.push(Polygon::new(name, vertices, frame, Paint::Ground, light));
    };
    let (nx, ny) = (xs.len() - 1, ys.len() - 1);
    // The four corners of the map lose their inner cell to a rectangle and are an L of three cells.
    let in_corner = |i: usize, j: usize| (i < 2 || i >= nx - 2) && (j < 2 || j >= ny - 2);
    let inner = |i: usize, j: usize| (i == 1 || i == nx - 2) && (j == 1 || j == ny - 2);
    for j in 0..ny {
        for i in 0..nx {
            if !in_corner(i, j) || inner(i, j) {
                let (x0, x1, y0, y1) = (xs[i], xs[i + 1], ys[j], ys[j + 1]);
                tile(format!("ground {i}.{j}"), &[(x0, y0), (x1, y0), (x1, y1), (x0, y1)]);
            }
        }
    }
    for (name, i, j) in
        [("south-west", 0, 0), ("south-east", nx, 0), ("north-east", nx, ny), ("north-west", 0, ny)]
    {
        // Positions one and two lines inwards from the corner.
        let x = |k: usize| if i == 0 { xs[k] } else { xs[nx - k] };
        let y = |k: usize| if j == 0 { ys[k] } else { ys[ny - k] };
        let mut corners = vec![
            (x(0), y(0)),
            (x(1), y(0)),
            (x(2), y(0)),
            (x(2), y(1)),
            (x(1), y(1)),
            (x(1), y(2)),
            (x(0), y(2)),
            (x(0), y(1)),
        ];
        if (i == 0) != (j == 0) {
            corners.reverse();
        }
        tile(format!("ground {name}"), &corners);
    }
}
