//! Strategies and small oracles that several subjects share. Nothing here calls the code it is used to judge.

use collinear::adjust::bundle::Adjusted;
use collinear::camera::{ExteriorOrientation, InteriorOrientation};
use collinear::nalgebra::{Matrix3, Point2, Point3, Vector3};
use collinear::resample::{Border, ImageViewMut, Sample};
use proptest::prelude::*;

/// A point of a cube of half side `extent` about the origin.
pub fn point(extent: f64) -> impl Strategy<Value = Point3<f64>> {
    let c = -extent..extent;
    (c.clone(), c.clone(), c).prop_map(|(x, y, z)| Point3::new(x, y, z))
}

/// A camera that stands 5 to 40 from the origin and looks near it, with any roll.
pub fn exterior() -> impl Strategy<Value = ExteriorOrientation> {
    (point(1.0), point(2.0), point(1.0), 5.0..40.0).prop_filter_map(
        "degenerate view",
        |(side, target, up, distance)| {
            let direction = side.coords.try_normalize(0.1)?;
            let up = up.coords.try_normalize(0.1)?;
            let center = Point3::from(direction * distance);
            ExteriorOrientation::look_at(center, target, up).ok()
        },
    )
}

/// A 1000 × 800 camera without lens errors.
pub fn interior() -> impl Strategy<Value = InteriorOrientation> {
    (600.0..3000.0, 0.95..1.05, 400.0..600.0, 300.0..500.0, -2.0..2.0).prop_filter_map(
        "no interior orientation",
        |(f, aspect, x, y, skew)| {
            InteriorOrientation::new([f, f * aspect], Point2::new(x, y), skew).ok()
        },
    )
}

/// A camera by its plain numbers: the oracle's own projection.
#[derive(Clone, Debug)]
pub struct PlainCamera {
    pub center: [f64; 3],
    pub rows: [[f64; 3]; 3],
    pub k: [[f64; 3]; 3],
}

impl PlainCamera {
    pub fn new(exterior: &ExteriorOrientation, interior: &InteriorOrientation) -> Self {
        let rows = |m: &Matrix3<f64>| [0, 1, 2].map(|i| [m[(i, 0)], m[(i, 1)], m[(i, 2)]]);
        let c = exterior.projection_center();
        Self {
            center: [c.x, c.y, c.z],
            rows: rows(exterior.camera_from_world().matrix()),
            k: rows(&interior.matrix()),
        }
    }

    /// (x, y, depth) of a world point, by the collinearity equations written out.
    pub fn project(&self, p: [f64; 3]) -> [f64; 3] {
        let d = [p[0] - self.center[0], p[1] - self.center[1], p[2] - self.center[2]];
        let [x, y, z] = self.rows.map(|r| r[0] * d[0] + r[1] * d[1] + r[2] * d[2]);
        let (a, b) = (x / z, y / z);
        [
            self.k[0][0] * a + self.k[0][1] * b + self.k[0][2],
            self.k[1][0] * a + self.k[1][1] * b + self.k[1][2],
            z,
        ]
    }

    /// The direction in the world of the ray through a pixel (K upper triangular).
    pub fn ray(&self, pixel: [f64; 2]) -> [f64; 3] {
        let b = (pixel[1] - self.k[1][2]) / self.k[1][1];
        let a = (pixel[0] - self.k[0][2] - self.k[0][1] * b) / self.k[0][0];
        [0, 1, 2].map(|i| self.rows[0][i] * a + self.rows[1][i] * b + self.rows[2][i])
    }
}

/// The point where a ray from `origin` meets the plane through `point` with this normal, and the ray's parameter.
pub fn cast(
    origin: [f64; 3],
    ray: [f64; 3],
    point: &Point3<f64>,
    normal: &Vector3<f64>,
) -> ([f64; 3], f64) {
    let n = [normal.x, normal.y, normal.z];
    let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    let to_plane = [point.x - origin[0], point.y - origin[1], point.z - origin[2]];
    let t = dot(n, to_plane) / dot(n, ray);
    ([0, 1, 2].map(|i| origin[i] + t * ray[i]), t)
}

/// Every border of a picture.
pub const BORDERS: [collinear::resample::Border; 5] = [
    collinear::resample::Border::Transparent,
    collinear::resample::Border::Constant([40.0, 50.0, 60.0, 70.0]),
    collinear::resample::Border::Clamp,
    collinear::resample::Border::Repeat,
    collinear::resample::Border::Mirror,
];

/// Every number of a JSON value, in its order.
pub fn numbers(value: &serde_json::Value) -> Vec<f64> {
    match value.as_array() {
        Some(list) => list.iter().flat_map(numbers).collect(),
        None => vec![value.as_f64().unwrap()],
    }
}

/// SplitMix64 (Steele, Lea & Flood 2014), so that scenes are the same everywhere.
pub struct Random(pub u64);

impl Random {
    /// In [0, 1).
    pub fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }

    pub fn within(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    /// Of the normal distribution (Box & Muller 1958).
    pub fn normal(&mut self) -> f64 {
        let radius = (-2.0 * (1.0 - self.unit()).ln()).sqrt();
        radius * (core::f64::consts::TAU * self.unit()).cos()
    }
}

/// Numbers in [0, 1) from a seed.
pub fn uniform(seed: u64) -> impl FnMut() -> f64 {
    let mut random = Random(seed);
    move || random.unit()
}

/// Numbers in [−1, 1) from a seed.
pub fn signed(seed: u64) -> impl FnMut() -> f64 {
    let mut next = uniform(seed);
    move || 2.0 * next() - 1.0
}

/// A point of two coordinates.
pub fn point2(value: &serde_json::Value) -> Point2<f64> {
    Point2::from_slice(&numbers(value))
}

/// A list of them.
pub fn points2(value: &serde_json::Value) -> Vec<Point2<f64>> {
    value.as_array().unwrap().iter().map(point2).collect()
}

/// Points of three coordinates, one after the other.
pub fn points3(value: &serde_json::Value) -> Vec<Point3<f64>> {
    numbers(value).chunks(3).map(Point3::from_slice).collect()
}

/// A 3 × 3 matrix by its rows.
pub fn matrix3(value: &serde_json::Value) -> Matrix3<f64> {
    Matrix3::from_row_slice(&numbers(value))
}

/// A block adjusted to the same bytes by 1, 2, 3 and 7 threads.
pub fn same_on_any_number_of_threads<C: PartialEq + std::fmt::Debug + Send>(
    adjust: impl Fn() -> Adjusted<C> + Sync,
) {
    let run = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(&adjust)
    };
    let one = run(1);
    for threads in [2, 3, 7] {
        let other = run(threads);
        assert_eq!(one.points(), other.points());
        assert_eq!(one.exteriors(), other.exteriors());
        assert_eq!(one.cameras(), other.cameras());
    }
}

/// Samples that look like chance, from a seed.
pub fn noise<T>(seed: u32, of: impl Fn(u32) -> T) -> impl FnMut() -> T {
    let mut random = seed | 1;
    move || {
        random ^= random << 13;
        random ^= random >> 17;
        random ^= random << 5;
        of(random)
    }
}

/// Paints a picture over what was there before, and holds it to what each row's pixels should be found to be: the border's
/// constant, or what was there, where nothing is.
pub fn same_as_lookups<T: Sample, const C: usize>(
    what: &str,
    [width, height]: [usize; 2],
    before: Vec<T>,
    border: Border,
    paint: impl FnOnce(&mut ImageViewMut<'_, T, C>),
    mut find: impl FnMut(i32, &mut [Option<[T; C]>]),
) {
    let mut pixels = before.clone();
    paint(&mut ImageViewMut::<T, C>::new(&mut pixels, width, height).unwrap());
    let constant = |k: usize| match border {
        Border::Constant(values) => Some(T::from_f32(values[k])),
        _ => None,
    };
    let mut expected = before;
    for (y, row) in expected.chunks_exact_mut(width * C).enumerate() {
        let mut found = vec![None; width];
        find(y as i32, &mut found);
        for (pixel, value) in row.chunks_exact_mut(C).zip(found) {
            for (k, sample) in pixel.iter_mut().enumerate() {
                *sample = value.map(|v| v[k]).or(constant(k)).unwrap_or(*sample);
            }
        }
    }
    if let Some(i) = pixels.iter().zip(&expected).position(|(p, e)| p != e) {
        let (x, y) = (i / C % width, i / C / width);
        let (value, expected) = (pixels[i], expected[i]);
        panic!("{what}, {border:?}: {value:?} and not {expected:?} at {x}, {y} of {C} channels");
    }
}
