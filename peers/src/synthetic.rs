//! Synthetic aerial blocks as problems of *Bundle Adjustment in the Large*.
//!
//! Photographs of 1200 × 900 px, c = 1000 px, from 100 m above hilly ground, in parallel strips flown to and fro. All have the
//! same camera. Image points have noise, and everything starts beside its true place, as after a flight with GNSS and inertial
//! navigation. A block is the same for the same numbers, on any machine of the same mathematical library.

use collinear::ExteriorOrientation;
use collinear::camera::CentralModel as _;
use collinear::nalgebra::{Point3, Rotation3, Vector3};
use collinear_io::Error;
use collinear_io::bal::{Bal, Camera, Observation};

/// What block to make.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plan {
    /// Photographs.
    pub cameras: usize,
    /// Image points, about.
    pub observations: usize,
    /// Which block of its kind.
    pub seed: u64,
    /// Overlap along and across the strips, 0 to 0.9.
    pub overlap: [f64; 2],
    /// Standard deviation of an image coordinate, px.
    pub noise: f64,
    /// Whether photographs and points are numbered at random rather than as flown.
    pub shuffled: bool,
}

impl Plan {
    /// A block of 60 % and 30 % overlap, 0.5 px of noise, in the order of the flight.
    #[must_use]
    pub fn new(cameras: usize, observations: usize, seed: u64) -> Self {
        let overlap = [0.6, 0.3];
        Self { cameras, observations, seed, overlap, noise: 0.5, shuffled: false }
    }
}

/// A block: how it is, and where its adjustment starts.
#[derive(Clone, Debug)]
pub struct Block {
    /// The true cameras and points, and the image points with their noise.
    pub truth: Bal,
    /// The same image points with approximate cameras and points.
    pub start: Bal,
}

/// c, half the width and half the height of a photograph, px.
const CAMERA: [f64; 3] = [1000.0, 600.0, 450.0];
/// k₁ and k₂ of the true camera.
const LENS: [f64; 2] = [-0.05, 0.01];
/// The flying height, m.
const HEIGHT: f64 = 100.0;
/// Standard deviations of the starts: centres and points (m), attitudes (radians).
const STARTS: [f64; 3] = [0.5, 0.5, 0.005];
/// The start of c in parts of the true one.
const START_OF_C: f64 = 1.003;

/// Random numbers: xorshift64*.
struct Random(u64);

impl Random {
    fn new(seed: u64) -> Self {
        Self(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ 0x5851_f42d_4c95_7f2d | 1)
    }

    fn bits(&mut self) -> u64 {
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        self.0.wrapping_mul(0x2545_f491_4f6c_dd1d)
    }

    /// Even, from 0 to 1.
    fn even(&mut self) -> f64 {
        (self.bits() >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// Normal, by the sum of twelve.
    fn normal(&mut self) -> f64 {
        (0..12).map(|_| self.even()).sum::<f64>() - 6.0
    }

    fn normals(&mut self, sigma: f64) -> Vector3<f64> {
        Vector3::from_fn(|_, _| sigma * self.normal())
    }

    /// A permutation (Fisher and Yates), or none.
    fn order(&mut self, n: usize, shuffled: bool) -> Vec<usize> {
        let mut order: Vec<usize> = (0..n).collect();
        if shuffled {
            for i in (1..n).rev() {
                order.swap(i, (self.bits() % (i as u64 + 1)) as usize);
            }
        }
        order
    }
}

/// The ground: hills of 12 m, of several hundred metres and of tens.
fn ground(x: f64, y: f64) -> f64 {
    8.0 * (x / 140.0).sin() * (y / 170.0).cos() + 4.0 * (x / 31.0 + 1.0).cos() * (y / 37.0).sin()
}

/// The flight: the photographs of each strip by their places along it.
struct Flight {
    base: f64,
    spacing: f64,
    strips: Vec<usize>,
}

impl Flight {
    fn new(plan: &Plan) -> Self {
        let [c, half_width, half_height] = CAMERA;
        let [along, across] = plan.overlap.map(|o| 1.0 - o.clamp(0.0, 0.9));
        let base = along * 2.0 * half_width / c * HEIGHT;
        let spacing = across * 2.0 * half_height / c * HEIGHT;
        // About a square.
        let count = (plan.cameras as f64 * base / spacing).sqrt().round() as usize;
        let count = count.clamp(1, plan.cameras.max(1));
        let strips =
            (0..count).map(|s| (s + 1) * plan.cameras / count - s * plan.cameras / count).collect();
        Self { base, spacing, strips }
    }

    fn half(&self, strip: usize) -> f64 {
        0.5 * (self.strips[strip] as f64 - 1.0)
    }

    /// The place of a photograph.
    fn at(&self, strip: usize, i: usize) -> [f64; 2] {
        let y = (strip as f64 - 0.5 * (self.strips.len() as f64 - 1.0)) * self.spacing;
        [(i as f64 - self.half(strip)) * self.base, y]
    }

    /// The photographs that may see a place: their numbers in the order of the flight.
    fn near(&self, x: f64, y: f64) -> Vec<usize> {
        // A third more than half a photograph's side on the ground, for tilts and relief.
        let reach = [CAMERA[1], CAMERA[2]].map(|h| 1.35 * h / CAMERA[0] * HEIGHT);
        let mut found = vec![];
        let mut begin = 0;
        for (strip, count) in self.strips.iter().enumerate() {
            if (self.at(strip, 0)[1] - y).abs() < reach[1] {
                let from = ((x - reach[0]) / self.base + self.half(strip)).ceil().max(0.0);
                let to = ((x + reach[0]) / self.base + self.half(strip)).floor();
                let to = to.min(*count as f64 - 1.0);
                if to >= from {
                    found.extend((from as usize..=to as usize).map(|i| begin + i));
                }
            }
            begin += count;
        }
        found
    }
}

/// Makes a block.
///
/// # Errors
/// None for a plan of positive numbers; those of a camera that the format cannot hold.
pub fn block(plan: &Plan) -> Result<Block, Error> {
    let mut random = Random::new(plan.seed);
    let flight = Flight::new(plan);
    let mut exteriors = Vec::with_capacity(plan.cameras);
    for (strip, count) in flight.strips.iter().enumerate() {
        for i in 0..*count {
            let [x, y] = flight.at(strip, i);
            let centre = Point3::new(x, y, HEIGHT) + random.normals(1.5);
            // Strips are flown to and fro.
            let heading = if strip % 2 == 0 { 0.0 } else { std::f64::consts::PI };
            let down = Rotation3::from_axis_angle(&Vector3::x_axis(), std::f64::consts::PI);
            let turn = Rotation3::from_axis_angle(&Vector3::z_axis(), heading);
            let tilt = Rotation3::from_scaled_axis(random.normals(0.02));
            exteriors.push(ExteriorOrientation::new(centre, tilt * turn * down));
        }
    }
    let model = Camera { rotation: [0.0; 3], translation: [0.0; 3], focal: CAMERA[0], k: LENS };
    let model = model.model()?;
    // A first trial tells how many image points a point has.
    let wanted = plan.observations as f64;
    let mut points = 0.3 * wanted;
    let (mut ground, mut rays) = (vec![], vec![]);
    for trial in [0.02, 1.0] {
        let mut random = Random::new(plan.seed.wrapping_add(1));
        (ground, rays) = seen(&flight, &exteriors, &model, trial * points, &mut random);
        let found: usize = rays.iter().map(Vec::len).sum();
        points *= trial * wanted / found.max(1) as f64;
    }
    let camera_order = random.order(exteriors.len(), plan.shuffled);
    let point_order = random.order(ground.len(), plan.shuffled);
    let mut number = vec![0; exteriors.len()];
    camera_order.iter().enumerate().for_each(|(new, old)| number[*old] = new as u32);
    let (mut truth, mut start) = (Bal::default(), Bal::default());
    let starting = Camera {
        rotation: [0.0; 3],
        translation: [0.0; 3],
        focal: START_OF_C * CAMERA[0],
        k: [0.0; 2],
    };
    let starting = starting.model()?;
    for old in camera_order {
        let exterior = &exteriors[old];
        truth.cameras.push(Camera::from_parts(exterior, &model)?);
        let centre = exterior.projection_center() + random.normals(STARTS[0]);
        let turn = Rotation3::from_scaled_axis(random.normals(STARTS[2]));
        let beside = ExteriorOrientation::new(centre, turn * exterior.camera_from_world());
        start.cameras.push(Camera::from_parts(&beside, &starting)?);
    }
    for (new, old) in point_order.into_iter().enumerate() {
        truth.points.push(ground[old].into());
        start.points.push((ground[old] + random.normals(STARTS[1])).into());
        let begin = truth.observations.len();
        for (camera, [x, y]) in &rays[old] {
            let at = [x + plan.noise * random.normal(), y + plan.noise * random.normal()];
            let at = Observation::from_pixel(number[*camera], new as u32, &at.into());
            truth.observations.push(at);
        }
        truth.observations[begin..].sort_by_key(|o| o.camera);
    }
    start.observations.clone_from(&truth.observations);
    Ok(Block { truth, start })
}

/// The camera and the image of a point in it, of each ray.
type Rays = Vec<(usize, [f64; 2])>;

/// Points of the ground that two photographs or more see, of about so many, with their rays.
fn seen(
    flight: &Flight,
    exteriors: &[ExteriorOrientation],
    model: &collinear_io::bal::BalCamera,
    count: f64,
    random: &mut Random,
) -> (Vec<Point3<f64>>, Vec<Rays>) {
    let edge = [CAMERA[1], CAMERA[2]].map(|h| h / CAMERA[0] * HEIGHT);
    let longest = flight.strips.iter().max().map_or(0.0, |n| *n as f64 - 1.0);
    let half_x = 0.5 * longest * flight.base + edge[0];
    let half_y = 0.5 * (flight.strips.len() as f64 - 1.0) * flight.spacing + edge[1];
    let step = (4.0 * half_x * half_y / count.max(1.0)).sqrt();
    let cells = [half_x, half_y].map(|h| (2.0 * h / step).ceil() as usize);
    let (mut points, mut all) = (vec![], vec![]);
    for row in 0..cells[1] {
        for column in 0..cells[0] {
            // One point a cell.
            let x = (column as f64 + random.even()) * step - half_x;
            let y = (row as f64 + random.even()) * step - half_y;
            let point = Point3::new(x, y, ground(x, y) + 2.0 * random.even());
            let mut rays: Rays = vec![];
            for camera in flight.near(x, y) {
                let direction = exteriors[camera].pose().apply(&point).coords;
                if let Ok(image) = model.project_direction(&direction)
                    && image.x.abs() < CAMERA[1]
                    && image.y.abs() < CAMERA[2]
                {
                    rays.push((camera, [image.x, image.y]));
                }
            }
            if rays.len() > 1 {
                points.push(point);
                all.push(rays);
            }
        }
    }
    (points, all)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The published formula of the format: P = R X + t, p = −P/P.z, f (1 + k₁|p|² + k₂|p|⁴) p.
    fn image(camera: &Camera, x: &[f64; 3]) -> [f64; 2] {
        let [a, b, c] = camera.rotation;
        let angle = (a * a + b * b + c * c).sqrt();
        let axis = [a / angle, b / angle, c / angle];
        let (sin, cos) = angle.sin_cos();
        let along: f64 = (0..3).map(|i| axis[i] * x[i]).sum();
        let p: [f64; 3] = std::array::from_fn(|i| {
            let (j, k) = ((i + 1) % 3, (i + 2) % 3);
            let cross = axis[j] * x[k] - axis[k] * x[j];
            x[i] * cos + cross * sin + axis[i] * along * (1.0 - cos) + camera.translation[i]
        });
        let q = [-p[0] / p[2], -p[1] / p[2]];
        let r2 = q[0] * q[0] + q[1] * q[1];
        let factor = camera.focal * (1.0 + camera.k[0] * r2 + camera.k[1] * r2 * r2);
        [factor * q[0], factor * q[1]]
    }

    fn mean_square(bal: &Bal) -> f64 {
        let sum: f64 = (bal.observations.iter())
            .map(|o| {
                let at = image(&bal.cameras[o.camera as usize], &bal.points[o.point as usize]);
                (at[0] - o.image[0]).powi(2) + (at[1] - o.image[1]).powi(2)
            })
            .sum();
        sum / (2 * bal.observations.len()) as f64
    }

    #[test]
    fn image_points_are_beside_the_true_ones_by_their_noise() {
        for shuffled in [false, true] {
            let made = block(&Plan { shuffled, ..Plan::new(60, 20_000, 3) }).unwrap();
            assert_eq!(made.truth.cameras.len(), 60);
            let n = made.truth.observations.len();
            assert!((18_000..22_000).contains(&n), "{n}");
            // 0.5² = 0.25, of 40,000 numbers: ± 0.25 √(2/40,000) = 0.0018.
            let square = mean_square(&made.truth);
            assert!((square - 0.25).abs() < 0.008, "{square}");
            // 5 mrad and half a metre in a hundred are some 7 px.
            let start = mean_square(&made.start).sqrt();
            assert!((3.0..20.0).contains(&start), "{start}");
            assert_eq!(made.truth.observations, made.start.observations);
        }
    }

    #[test]
    fn a_block_is_as_its_plan_says() {
        let made = block(&Plan::new(100, 30_000, 1)).unwrap();
        let again = block(&Plan::new(100, 30_000, 1)).unwrap();
        assert_eq!((made.start, &made.truth), (again.start, &again.truth));
        let other = block(&Plan::new(100, 30_000, 2)).unwrap();
        assert_ne!(made.truth.cameras, other.truth.cameras);
        // 1/(1 − 0.6) · 1/(1 − 0.3) = 3.6 rays a point inside the block, fewer at its edge.
        let rays = made.truth.observations.len() as f64 / made.truth.points.len() as f64;
        assert!((3.0..3.9).contains(&rays), "{rays}");
        let mut of_camera = vec![0; 100];
        made.truth.observations.iter().for_each(|o| of_camera[o.camera as usize] += 1);
        assert!(of_camera.iter().all(|n| (120..450).contains(n)), "{of_camera:?}");
    }
}
