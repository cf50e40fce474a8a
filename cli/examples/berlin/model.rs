//! The model: plane polygons, their planes from the points, their outlines measured by hand.
//!
//! Building coordinates are x to the right, y into the façade, z up, from the first photograph's camera, in the
//! reconstruction's metres. Walls lie on the planes found parallel to the façade. Their outlines were read off rectified
//! pictures of these planes, so they are constants here.

use anyhow::Result;
use collinear::nalgebra::Point3;

use crate::planes::Found;
use crate::site::Site;

/// A polygon of the model.
pub(crate) struct Face {
    pub(crate) name: String,
    /// World coordinates, in one plane.
    pub(crate) outline: Vec<Point3<f64>>,
}

/// The vault's and the lunette's arcs: centre x, springing z, half width, height.
const FRONT_ARC: [f64; 4] = [1.28, 9.6, 4.78, 4.78];
const BACK_ARC: [f64; 4] = [1.46, 9.05, 4.62, 5.0];
/// The lunette's depth: the median of the few points on the mosaic.
const LUNETTE: f64 = 30.0;
/// The parts into which arcs are divided.
const ARC_PARTS: usize = 16;
/// The edges of the steps, by depth: the foot of the lower flight, its head, the foot of the upper flight, its head.
const STEPS: [f64; 4] = [16.05, 17.9, 19.2, 22.62];
/// How far stairs and pavement go to the left and right.
const WIDTH: [f64; 2] = [-14.0, 15.0];
/// The depth of the giant columns' front: two points on a drum, and their parallax in photographs 01 and 02.
const GIANT: f64 = 20.1;

/// Where the pedestals' inner flanks stand.
const FLANKS: [f64; 2] = [-6.05, 7.25];
/// How steps and pavement lean to the right against the building's cornices, radians: measured in photographs 01 and 02.
const LEAN: f64 = -0.0175;

/// The parts of photographs that passers-by hide: left, top, right, bottom, pixels.
pub(crate) const PASSERS_BY: [(&str, [f64; 4]); 16] = [
    ("01", [895.0, 2245.0, 975.0, 2448.0]),
    ("01", [975.0, 2250.0, 1065.0, 2448.0]),
    ("01", [1080.0, 2235.0, 1180.0, 2448.0]),
    ("01", [1180.0, 2255.0, 1250.0, 2448.0]),
    ("01", [1440.0, 2095.0, 1535.0, 2320.0]),
    ("01", [1690.0, 2105.0, 1865.0, 2320.0]),
    ("01", [2390.0, 2230.0, 2525.0, 2448.0]),
    ("01", [3180.0, 2235.0, 3264.0, 2448.0]),
    ("02", [340.0, 1760.0, 485.0, 2035.0]),
    ("02", [645.0, 1765.0, 865.0, 2035.0]),
    ("02", [985.0, 1935.0, 1125.0, 2125.0]),
    ("02", [990.0, 2125.0, 1095.0, 2335.0]),
    ("02", [1785.0, 1905.0, 1885.0, 2000.0]),
    ("02", [1755.0, 2000.0, 1920.0, 2280.0]),
    ("02", [1725.0, 2180.0, 1935.0, 2280.0]),
    ("02", [2680.0, 1895.0, 3264.0, 2410.0]),
];

/// A column with its capital, the entablature over it and the angel on top; on the plane of the columns.
const LEFT_PORTICO: [[f64; 2]; 35] = [
    [-5.69, -1.88],
    [-5.64, -0.71],
    [-5.03, 0.04],
    [-4.88, 6.1],
    [-5.01, 7.26],
    [-5.09, 8.01],
    [-5.56, 8.9],
    [-5.56, 9.14],
    [-4.77, 9.24],
    [-4.75, 9.75],
    [-4.6, 9.88],
    [-4.67, 10.77],
    [-5.03, 11.2],
    [-5.03, 12.3],
    [-4.67, 12.15],
    [-4.52, 12.43],
    [-4.09, 12.43],
    [-3.82, 12.15],
    [-3.54, 12.43],
    [-3.41, 11.62],
    [-3.5, 10.88],
    [-3.84, 10.56],
    [-3.92, 9.86],
    [-3.79, 9.75],
    [-3.75, 9.18],
    [-3.39, 9.11],
    [-3.39, 8.86],
    [-3.84, 8.54],
    [-3.92, 7.26],
    [-3.96, 6.2],
    [-4.09, 6.05],
    [-4.03, 0.04],
    [-3.79, -0.32],
    [-3.54, -0.81],
    [-3.54, -1.5],
];

/// As [`LEFT_PORTICO`], on the other side.
const RIGHT_PORTICO: [[f64; 2]; 37] = [
    [5.39, -1.5],
    [5.39, -0.81],
    [5.98, -0.32],
    [6.11, 0.04],
    [6.18, 6.05],
    [5.96, 6.52],
    [6.07, 7.26],
    [6.03, 8.01],
    [5.64, 8.65],
    [5.64, 9.07],
    [6.24, 9.18],
    [6.285, 9.75],
    [6.41, 9.88],
    [6.07, 10.88],
    [5.75, 11.2],
    [5.75, 12.47],
    [6.11, 12.26],
    [6.54, 12.15],
    [6.71, 12.47],
    [6.98, 12.26],
    [7.24, 12.43],
    [7.39, 12.15],
    [7.3, 11.41],
    [6.96, 10.88],
    [6.92, 9.86],
    [7.05, 9.71],
    [7.09, 9.18],
    [7.88, 9.14],
    [7.88, 8.9],
    [7.24, 8.54],
    [7.07, 7.9],
    [7.09, 7.16],
    [6.84, 6.2],
    [6.79, 0.04],
    [7.03, -0.49],
    [7.6, -0.8],
    [7.6, -1.88],
];

/// The giant columns with their capitals, on [`GIANT`].
const GIANTS: [&[[f64; 2]]; 3] = [
    &[
        [-10.58, 4.43],
        [-10.42, 4.98],
        [-10.15, 9.17],
        [-10.03, 14.14],
        [-10.38, 14.82],
        [-10.65, 15.76],
        [-8.67, 15.76],
        [-8.72, 15.02],
        [-8.96, 14.14],
        [-9.06, 9.17],
        [-9.25, 4.98],
        [-9.02, 4.43],
    ],
    &[
        [-7.4, 4.43],
        [-7.22, 4.98],
        [-6.91, 9.17],
        [-6.81, 14.08],
        [-7.2, 14.82],
        [-7.34, 15.8],
        [-5.35, 15.8],
        [-5.51, 14.82],
        [-5.74, 14.08],
        [-5.82, 9.17],
        [-5.94, 4.98],
        [-5.66, 4.43],
    ],
    &[
        [7.91, 4.43],
        [8.06, 5.03],
        [8.24, 9.17],
        [8.3, 14.24],
        [8.3, 15.02],
        [8.04, 16.03],
        [10.09, 16.03],
        [9.8, 15.21],
        [9.35, 14.24],
        [9.35, 9.17],
        [9.31, 5.03],
        [9.62, 4.43],
    ],
];

/// A relief between pilasters under a gable, and the two apostles on it; on the plane of the pedestals.
const LEFT_RELIEF: [[f64; 2]; 23] = [
    [-12.17, -1.84],
    [-12.17, 4.46],
    [-9.14, 4.17],
    [-9.2, 4.66],
    [-9.18, 5.63],
    [-9.28, 6.38],
    [-8.89, 6.81],
    [-8.79, 7.34],
    [-8.44, 7.34],
    [-8.34, 6.91],
    [-8.12, 6.89],
    [-8.07, 7.34],
    [-7.81, 7.39],
    [-7.69, 7.04],
    [-7.36, 6.81],
    [-7.21, 6.51],
    [-7.4, 5.83],
    [-7.42, 4.6],
    [-7.52, 4.11],
    [-6.99, 3.48],
    [-6.85, 3.19],
    [-7.09, 2.8],
    [-7.03, -1.84],
];

/// As [`LEFT_RELIEF`], on the other side.
const RIGHT_RELIEF: [[f64; 2]; 22] = [
    [8.95, -1.95],
    [8.95, 2.8],
    [8.71, 3.19],
    [9.44, 3.87],
    [9.69, 4.11],
    [9.69, 4.5],
    [9.38, 4.46],
    [9.44, 6.61],
    [9.73, 6.91],
    [10.02, 6.96],
    [10.08, 7.34],
    [10.36, 7.34],
    [10.51, 7.0],
    [10.71, 7.34],
    [11.0, 7.26],
    [11.14, 6.71],
    [11.69, 6.22],
    [11.59, 5.73],
    [11.26, 5.05],
    [11.3, 4.11],
    [13.06, 3.19],
    [13.06, -1.95],
];

/// Points on an arc from left to right.
fn arc([x, z, a, b]: [f64; 4]) -> impl Iterator<Item = [f64; 2]> {
    (0..=ARC_PARTS).map(move |i| {
        let (sine, cosine) = (std::f64::consts::PI * i as f64 / ARC_PARTS as f64).sin_cos();
        [x - a * cosine, z + b * sine]
    })
}

/// The planes of stairs, found in the points that lie on them.
pub(crate) struct Stairs {
    pub(crate) lower: Found,
    pub(crate) upper: Found,
}

impl Stairs {
    /// Searches for both flights between the pedestals.
    pub(crate) fn find(site: &Site) -> Result<Self> {
        let slope = 18_f64.to_radians();
        let lower = site.rising([-5.0, 16.0, -3.0], [5.2, 18.2, -1.7], slope, LEAN)?;
        let upper = site.rising([2.0, 20.5, -1.6], [5.2, 22.4, -0.8], slope, LEAN)?;
        Ok(Self { lower, upper })
    }

    /// The height of a flight's plane at a depth, straight ahead.
    fn height(site: &Site, flight: &Found, depth: f64) -> f64 {
        let [x, y, z] = site.building(&flight.plane.point());
        let normal = flight.plane.normal();
        let [nx, ny, nz] =
            [site.axes.right, site.axes.inward, site.axes.up].map(|a| normal.dot(&a));
        z - ((depth - y) * ny - x * nx) / nz
    }

    /// The heights of the edges of [`STEPS`].
    pub(crate) fn heights(&self, site: &Site) -> [f64; 4] {
        let [a, b, c, d] = STEPS;
        [(&self.lower, a), (&self.lower, b), (&self.upper, c), (&self.upper, d)]
            .map(|(flight, depth)| Self::height(site, flight, depth))
    }
}

/// All polygons of the model.
pub(crate) fn faces(site: &Site, stairs: &Stairs) -> Result<Vec<Face>> {
    let depth = |near: f64| site.sheet(near).map(|f| site.depth(f));
    let (columns, portal, wall) = (depth(21.17)?, depth(29.16)?, depth(22.51)?);
    let (relief, block) = (depth(19.45)?, depth(19.74)?);
    let mut faces = Vec::new();
    let mut solid = |name: &str, outline: &[[f64; 3]]| {
        let outline = outline.iter().map(|p| site.world(*p)).collect();
        faces.push(Face { name: name.to_owned(), outline });
    };
    let upright = |y: f64, outline: &[[f64; 2]]| -> Vec<[f64; 3]> {
        outline.iter().map(|[x, z]| [*x, y, *z]).collect()
    };

    // The wall with the arch cut out.
    let [foot, _, _, floor] = stairs.heights(site);
    // Walls go on below the floor, which hides what is too much.
    let base = floor - 0.4;
    let (left_jamb, right_jamb, springing) = (-3.15, 5.6, FRONT_ARC[1]);
    let mut outline = vec![[-14.0, -2.0], [left_jamb, -2.0], [left_jamb, springing - 0.55]];
    outline.extend(arc(FRONT_ARC));
    outline.extend([[right_jamb, springing - 0.55], [right_jamb, -2.0], [15.0, -2.0]]);
    outline.extend([[15.0, 18.2], [-14.0, 18.2]]);
    solid("wall", &upright(wall, &outline));

    // The portico: both columns, the vault, the lunette, the portal.
    solid("left portico", &upright(columns, &LEFT_PORTICO));
    solid("right portico", &upright(columns, &RIGHT_PORTICO));
    let front: Vec<_> = arc(FRONT_ARC).collect();
    let back: Vec<_> = arc(BACK_ARC).collect();
    for (i, (f, b)) in front.windows(2).zip(back.windows(2)).enumerate() {
        let ([f0, f1], [b0, b1]) = ([f[0], f[1]], [b[0], b[1]]);
        let at = |[x, z]: [f64; 2], y: f64| [x, y, z];
        // Two triangles, since the four corners are in no plane.
        solid(&format!("vault {i}a"), &[at(f0, wall), at(f1, wall), at(b1, LUNETTE)]);
        solid(&format!("vault {i}b"), &[at(f0, wall), at(b1, LUNETTE), at(b0, LUNETTE)]);
    }
    let (ledge, cornice) = (BACK_ARC[1] - 0.3, 6.95);
    let [bx, bz, ba, _] = BACK_ARC;
    let mut lunette = vec![[bx - ba, ledge]];
    lunette.extend(&back);
    lunette.push([bx + ba, ledge]);
    solid("lunette", &upright(LUNETTE, &lunette));
    for (name, front_x, back_x, corner) in
        [("left", left_jamb, bx - ba, -4.4), ("right", right_jamb, bx + ba, 6.5)]
    {
        solid(
            &format!("{name} architrave"),
            &[
                [front_x, wall, 7.1],
                [front_x, wall, springing - 0.55],
                [back_x, LUNETTE, bz],
                [back_x, LUNETTE, cornice],
            ],
        );
        let spring = if name == "left" { front[0] } else { front[ARC_PARTS] };
        solid(
            &format!("{name} impost"),
            &[
                [spring[0], wall, spring[1]],
                [front_x, wall, springing - 0.55],
                [back_x, LUNETTE, bz],
            ],
        );
        solid(
            &format!("{name} soffit"),
            &[[front_x, wall, 7.1], [back_x, LUNETTE, cornice], [corner, portal, 7.1]],
        );
        solid(
            &format!("{name} aisle"),
            &[
                [front_x, wall, base],
                [front_x, wall, 7.1],
                [corner, portal, 7.1],
                [corner, portal, base],
            ],
        );
    }
    solid("portal", &upright(portal, &[[-4.4, base], [6.5, base], [6.5, ledge], [-4.4, ledge]]));

    // The pedestals of the giant columns, and what stands on and before them.
    for (i, outline) in GIANTS.iter().enumerate() {
        solid(&format!("giant column {}", i + 1), &upright(GIANT, outline));
    }
    solid("left relief", &upright(relief, &LEFT_RELIEF));
    solid("right relief", &upright(relief, &RIGHT_RELIEF));
    for (name, inner, outer) in [("left", FLANKS[0], -14.0), ("right", FLANKS[1], 15.0)] {
        let outline = [[outer, foot], [inner, foot], [inner, 4.45], [outer, 4.45]];
        solid(&format!("{name} pedestal"), &upright(block, &outline));
        solid(
            &format!("{name} flank"),
            &[[inner, block, foot], [inner, wall, foot], [inner, wall, 4.45], [inner, block, 4.45]],
        );
    }

    // The ground.
    let across = |y0: f64, z0: f64, y1: f64, z1: f64| {
        let [left, right] = WIDTH;
        [[left, y0, z0], [right, y0, z0], [right, y1, z1], [left, y1, z1]]
            .map(|[x, y, z]| [x, y, z + x * LEAN.tan()])
    };
    let ([y0, y1, y2, y3], [z0, z1, z2, z3]) = (STEPS, stairs.heights(site));
    solid("pavement", &across(4.0, z0, y0, z0));
    solid("lower flight", &across(y0, z0, y1, z1));
    // The landing goes on beside the upper flight, up to the pedestals' plinths.
    let [left, right] = WIDTH;
    let landing = |x: f64, y: f64| [x, y, z1 + (z2 - z1) * (y - y1) / (y2 - y1) + x * LEAN.tan()];
    let ([inner_left, inner_right], plinth) = (FLANKS, relief - 0.35);
    solid(
        "landing",
        &[
            landing(left, y1),
            landing(right, y1),
            landing(right, plinth),
            landing(inner_right, plinth),
            landing(inner_right, y2),
            landing(inner_left, y2),
            landing(inner_left, plinth),
            landing(left, plinth),
        ],
    );
    let between = |mut outline: [[f64; 3]; 4]| {
        for p in &mut outline {
            let x = p[0].clamp(inner_left, inner_right);
            *p = [x, p[1], p[2] + (x - p[0]) * LEAN.tan()];
        }
        outline
    };
    solid("upper flight", &between(across(y2, z2, y3, z3)));
    solid("floor", &across(y3, z3, portal, z3));
    Ok(faces)
}
