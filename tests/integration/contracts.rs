//! The contracts hold for what they were made for: a frame camera, a pushbroom, a rational polynomial camera, a
//! homography and a cubic map. The last four are stand-ins, small but true to their kind.

use approx::assert_abs_diff_eq;
use collinear::camera::{
    Adjustable, Brown, BrownCamera, ExteriorOrientation, Frame, InteriorOrientation,
    ParameterGroup, SensorModel,
};
use collinear::geometry::{HeightCurve, Homography, Locus, Plane, Ray, Surface};
use collinear::mapping::{FractionalLinear, Map, RowCoords};
use collinear::nalgebra::{Matrix2, Matrix2x3, Matrix3, Point2, Point3, Vector3};
use collinear::{Error, ProjectionError};

/// A line scanner that flies along x at constant height and speed, looking straight down: line y is exposed at
/// X = start + y · step, and there is no single projection centre.
#[derive(Debug)]
struct Pushbroom {
    start: f64,
    step: f64,
    height: f64,
    principal_distance: f64,
    middle: f64,
}

impl SensorModel for Pushbroom {
    fn project(&self, world: &Point3<f64>) -> Result<Point2<f64>, ProjectionError> {
        let depth = self.height - world.z;
        if depth <= 0.0 {
            return Err(ProjectionError::BehindCamera { depth });
        }
        let sample = self.middle + self.principal_distance * world.y / depth;
        Ok(Point2::new(sample, (world.x - self.start) / self.step))
    }

    fn project_jacobian(
        &self,
        world: &Point3<f64>,
    ) -> Result<(Point2<f64>, Matrix2x3<f64>), ProjectionError> {
        let image = self.project(world)?;
        let depth = self.height - world.z;
        let scale = self.principal_distance / depth;
        let by_world =
            Matrix2x3::new(0.0, scale, scale * world.y / depth, 1.0 / self.step, 0.0, 0.0);
        Ok((image, by_world))
    }

    fn locus(&self, image: &Point2<f64>) -> Result<Locus, ProjectionError> {
        let origin = Point3::new(self.start + image.y * self.step, 0.0, self.height);
        let direction = Vector3::new(0.0, image.x - self.middle, -self.principal_distance);
        Ray::new(origin, direction).map(Locus::Ray).map_err(|_| ProjectionError::NotFinite)
    }
}

impl Adjustable for Pushbroom {
    fn parameter_group(&self, group: usize) -> Option<ParameterGroup> {
        (group == 0).then_some(ParameterGroup { name: "trajectory", len: 2 })
    }

    fn parameters(&self, _: usize, values: &mut [f64]) {
        values.copy_from_slice(&[self.start, self.step]);
    }

    fn adjust(&mut self, _: usize, step: &[f64]) -> Result<(), Error> {
        self.start += step[0];
        self.step += step[1];
        Ok(())
    }

    fn partials(
        &self,
        object: &Point3<f64>,
        by_object: &mut [f64; 6],
        by_group: &mut [&mut [f64]],
    ) -> Result<Point2<f64>, ProjectionError> {
        let (image, j) = self.project_jacobian(object)?;
        *by_object = [j.m11, j.m12, j.m13, j.m21, j.m22, j.m23];
        if let [trajectory, ..] = by_group
            && !trajectory.is_empty()
        {
            trajectory.copy_from_slice(&[0.0, 0.0, -1.0 / self.step, -image.y / self.step]);
        }
        Ok(image)
    }
}

/// A rational polynomial camera of first degree over (X, Y, H): no centre, and a curve over height for a locus.
#[derive(Debug)]
struct Rational {
    sample: [[f64; 4]; 2],
    line: [[f64; 4]; 2],
}

impl Rational {
    fn ratio(c: &[[f64; 4]; 2], w: &Point3<f64>) -> f64 {
        let poly = |c: &[f64; 4]| c[0] + c[1] * w.x + c[2] * w.y + c[3] * w.z;
        poly(&c[0]) / poly(&c[1])
    }

    /// The ground point of a pixel at a height: two linear equations.
    fn at_height(&self, image: &Point2<f64>, h: f64) -> Option<Point3<f64>> {
        let row = |c: &[[f64; 4]; 2], m: f64| {
            let d: [f64; 4] = core::array::from_fn(|i| c[0][i] - m * c[1][i]);
            (d[1], d[2], -(d[0] + d[3] * h))
        };
        let ((a, b, e), (c, d, f)) = (row(&self.sample, image.x), row(&self.line, image.y));
        let solved =
            Matrix2::new(a, b, c, d).lu().solve(&collinear::nalgebra::Vector2::new(e, f))?;
        Some(Point3::new(solved.x, solved.y, h))
    }
}

impl SensorModel for Rational {
    fn project(&self, world: &Point3<f64>) -> Result<Point2<f64>, ProjectionError> {
        Ok(Point2::new(Self::ratio(&self.sample, world), Self::ratio(&self.line, world)))
    }

    fn project_jacobian(
        &self,
        world: &Point3<f64>,
    ) -> Result<(Point2<f64>, Matrix2x3<f64>), ProjectionError> {
        let image = self.project(world)?;
        let row = |c: &[[f64; 4]; 2], m: f64| {
            let w = c[1][0] + c[1][1] * world.x + c[1][2] * world.y + c[1][3] * world.z;
            [1, 2, 3].map(|i| (c[0][i] - m * c[1][i]) / w)
        };
        let (s, l) = (row(&self.sample, image.x), row(&self.line, image.y));
        Ok((image, Matrix2x3::new(s[0], s[1], s[2], l[0], l[1], l[2])))
    }

    fn locus(&self, image: &Point2<f64>) -> Result<Locus, ProjectionError> {
        // A cubic through four heights, and the miss half-way between the first two as its error.
        let heights = [0.0, 100.0, 200.0, 300.0];
        let p = heights
            .map(|h| self.at_height(image, h).map_or(Vector3::repeat(f64::NAN), |p| p.coords));
        let t = 100.0;
        let (d1, d2, d3) =
            (p[1] - p[0], p[2] - p[1] * 2.0 + p[0], p[3] - p[2] * 3.0 + p[1] * 3.0 - p[0]);
        let mut curve = HeightCurve {
            coefficients: [
                p[0],
                (d1 - d2 / 2.0 + d3 / 3.0) / t,
                (d2 / 2.0 - d3 / 2.0) / (t * t),
                d3 / (6.0 * t * t * t),
            ],
            reference_height: 0.0,
            heights: [0.0, 300.0],
            error_bound: 0.0,
        };
        let exact = self.at_height(image, 50.0).ok_or(ProjectionError::NotFinite)?;
        curve.error_bound = 2.0 * (curve.at(50.0) - exact).norm();
        Ok(Locus::Curve(curve))
    }
}

/// A polynomial map of third degree.
#[derive(Debug)]
struct Cubic {
    a: [f64; 10],
    b: [f64; 10],
}

impl Cubic {
    fn terms(x: f64, y: f64) -> [f64; 10] {
        [1.0, x, y, x * y, x * x, y * y, x * x * y, x * y * y, x * x * x, y * y * y]
    }
}

impl Map for Cubic {
    fn at(&self, p: &Point2<f64>) -> Result<Point2<f64>, ProjectionError> {
        let sum = |c: &[f64; 10]| Self::terms(p.x, p.y).iter().zip(c).map(|(t, c)| t * c).sum();
        Ok(Point2::new(sum(&self.a), sum(&self.b)))
    }

    fn jacobian(&self, p: &Point2<f64>) -> Result<Matrix2<f64>, ProjectionError> {
        let (x, y) = (p.x, p.y);
        let dx = [0.0, 1.0, 0.0, y, 2.0 * x, 0.0, 2.0 * x * y, y * y, 3.0 * x * x, 0.0];
        let dy = [0.0, 0.0, 1.0, x, 0.0, 2.0 * y, x * x, 2.0 * x * y, 0.0, 3.0 * y * y];
        let sum = |c: &[f64; 10], d: &[f64; 10]| c.iter().zip(d).map(|(c, d)| c * d).sum();
        Ok(Matrix2::new(sum(&self.a, &dx), sum(&self.a, &dy), sum(&self.b, &dx), sum(&self.b, &dy)))
    }
}

/// What every sensor owes: ground and project undo each other, and the Jacobian is the slope.
fn check_sensor(sensor: &dyn SensorModel, image: Point2<f64>, surface: &dyn Surface) {
    let ground = sensor.ground(&image, surface).expect("on the surface");
    assert_abs_diff_eq!(surface.height_above(&ground), 0.0, epsilon = 1e-6);
    let (again, jacobian) = sensor.project_jacobian(&ground).expect("visible");
    assert_abs_diff_eq!(again, image, epsilon = 1e-6);
    for i in 0..3 {
        let mut step = Vector3::zeros();
        step[i] = 1e-4;
        let (a, b) = (sensor.project(&(ground + step)), sensor.project(&(ground - step)));
        let slope = (a.expect("visible") - b.expect("visible")) / 2e-4;
        assert_abs_diff_eq!(slope, jacobian.column(i).into_owned(), epsilon = 1e-6);
    }
}

fn slope() -> Plane {
    Plane::from_point_and_normal(Point3::new(0.0, 0.0, 100.0), Vector3::new(0.1, -0.05, 1.0))
        .unwrap()
}

fn frame() -> Frame<BrownCamera> {
    let exterior = ExteriorOrientation::look_at(
        Point3::new(30.0, -40.0, 900.0),
        Point3::new(10.0, 5.0, 100.0),
        Vector3::y(),
    );
    let interior = InteriorOrientation::new([1500.0, 1490.0], Point2::new(980.0, 760.0), 0.3);
    let lens = Brown::new([-0.1, 0.02, -0.001], [3e-4, -2e-4]).unwrap();
    Frame::new(exterior.unwrap(), BrownCamera::new(interior.unwrap(), lens))
}

#[test]
fn a_frame_camera_a_pushbroom_and_a_rational_camera_meet_one_contract() {
    let pushbroom = Pushbroom {
        start: -50.0,
        step: 0.2,
        height: 800.0,
        principal_distance: 4000.0,
        middle: 2048.0,
    };
    let rational = Rational {
        sample: [[500.0, 2.0, 0.1, 0.3], [1.0, 1e-5, 2e-5, 1e-4]],
        line: [[400.0, -0.1, -1.9, 0.2], [1.0, -1e-5, 1e-5, 2e-5]],
    };
    let sensors: [(&dyn SensorModel, Point2<f64>); 3] = [
        (&frame(), Point2::new(700.0, 1100.0)),
        (&pushbroom, Point2::new(1200.0, 300.0)),
        (&rational, Point2::new(520.0, 380.0)),
    ];
    for (sensor, image) in sensors {
        check_sensor(sensor, image, &slope());
    }
    let Locus::Curve(curve) = rational.locus(&Point2::new(520.0, 380.0)).unwrap() else { panic!() };
    assert!(curve.error_bound < 1e-6, "{}", curve.error_bound);
}

#[test]
fn adjustable_writes_one_block_a_group_and_skips_held_ones() {
    let frame = frame();
    let mut groups = Vec::new();
    while let Some(g) = frame.parameter_group(groups.len()) {
        groups.push(g.len);
    }
    assert_eq!(groups, [6, 5, 5]);
    let object = Point3::new(12.0, 30.0, 105.0);
    let mut by_object = [0.0; 6];
    let (mut exterior, mut lens) = ([0.0; 12], [0.0; 10]);
    let image =
        frame.partials(&object, &mut by_object, &mut [&mut exterior, &mut [], &mut lens]).unwrap();
    assert_eq!(image, frame.project(&object).unwrap());
    // Each column against a central difference through `adjust`.
    for (group, block, len) in [(0, &exterior[..], 6), (2, &lens[..], 5)] {
        for i in 0..len {
            let h = if group == 0 && i < 3 { 1e-3 } else { 1e-5 };
            let moved = |sign: f64| {
                let mut copy = frame;
                let mut step = vec![0.0; len];
                step[i] = sign * h;
                copy.adjust(group, &step).unwrap();
                copy.project(&object).unwrap()
            };
            let slope = (moved(1.0) - moved(-1.0)) / (2.0 * h);
            assert_abs_diff_eq!(slope.x, block[i], epsilon = 1e-5 * (1.0 + block[i].abs()));
            assert_abs_diff_eq!(
                slope.y,
                block[len + i],
                epsilon = 1e-5 * (1.0 + block[len + i].abs())
            );
        }
    }
    let mut scanner: Box<dyn Adjustable> = Box::new(Pushbroom {
        start: 0.0,
        step: 0.2,
        height: 800.0,
        principal_distance: 4e3,
        middle: 2e3,
    });
    scanner.adjust(0, &[1.0, 0.0]).unwrap();
    let mut values = [0.0; 2];
    scanner.parameters(0, &mut values);
    assert_eq!(values, [1.0, 0.2]);
}

#[test]
fn a_homography_and_a_cubic_map_fill_rows() {
    let homography =
        Homography::from_matrix(Matrix3::new(0.9, 0.1, 5.0, -0.2, 1.1, 7.0, 1e-3, -2e-3, 1.0))
            .unwrap();
    let cubic = Cubic {
        a: [1.0, 1.0, 0.01, 1e-4, 2e-5, 0.0, 1e-8, 0.0, 3e-8, 0.0],
        b: [-2.0, 0.02, 0.9, 0.0, 1e-5, 1e-4, 0.0, 2e-8, 0.0, 1e-8],
    };
    let maps: [&dyn Map; 2] = [&FractionalLinear::from_homography(&homography), &cubic];
    for map in maps {
        let mut row = RowCoords::new();
        map.row(41, -100..700, &mut row);
        let mut pixels = 0;
        for run in row.runs() {
            let (u, v) = row.offsets(run);
            for (i, x) in run.pixels().enumerate() {
                let exact = map.at(&Point2::new(f64::from(x) + 0.5, 41.5)).unwrap();
                let p = Point2::new(
                    f64::from(run.origin[0]) + f64::from(u[i]),
                    f64::from(run.origin[1]) + f64::from(v[i]),
                );
                assert!((p - exact).norm() < 6e-6, "{p} {exact}");
                pixels += 1;
            }
        }
        assert_eq!(pixels, 800);
    }
}
