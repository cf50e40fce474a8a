//! Any sensor as the screen: domes, panoramas, pre-warping, against numbers of `tests/data/oracles/output_models.py`.

use collinear::camera::{
    Brown, BrownCamera, CentralCamera, CentralModel, ExteriorOrientation, Fisheye, Frame,
    InteriorOrientation, NoDistortion, Orthographic, Panorama, PolynomialTrajectory, ScanTime,
    Scanner, SensorModel,
};
use collinear::geometry::{Affine2, Dome, Plane, Ray, Sphere, Surface};
use collinear::mapping::{FractionalLinear, Map, SensorMap};
use collinear::nalgebra::{
    Matrix2, Matrix2x3, Matrix3, Point2, Point3, Quaternion, Rotation3, UnitQuaternion, Vector3,
};
use collinear::{Error, ProjectionError};
use proptest::prelude::*;
use serde_json::Value;

use crate::support;

fn numbers<const N: usize>(value: &Value) -> [f64; N] {
    let list = value.as_array().unwrap();
    assert_eq!(list.len(), N);
    std::array::from_fn(|i| list[i].as_f64().unwrap())
}

/// A central model of any kind.
#[derive(Debug)]
struct Any(Box<dyn CentralModel>);

impl CentralModel for Any {
    fn project_direction(&self, d: &Vector3<f64>) -> Result<Point2<f64>, ProjectionError> {
        self.0.project_direction(d)
    }
    fn project_direction_jacobian(
        &self,
        d: &Vector3<f64>,
    ) -> Result<(Point2<f64>, Matrix2x3<f64>), ProjectionError> {
        self.0.project_direction_jacobian(d)
    }
    fn direction(&self, image: &Point2<f64>) -> Result<Vector3<f64>, ProjectionError> {
        self.0.direction(image)
    }
}

fn camera(case: &Value) -> Frame<Any> {
    let [w, x, y, z] = numbers(&case["quaternion"]);
    let rotation = UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z));
    let center = Point3::from(numbers::<3>(&case["center"]));
    let exterior = ExteriorOrientation::new(center, rotation.to_rotation_matrix());
    let point = Point2::from(numbers::<2>(&case["principal_point"]));
    let interior =
        InteriorOrientation::new(numbers(&case["principal_distance"]), point, 0.0).unwrap();
    let panorama = |p| Any(Box::new(CentralCamera::ideal(interior, p)));
    let fisheye = |p| Any(Box::new(CentralCamera::ideal(interior, p)));
    let model = match case["projection"].as_str().unwrap() {
        "perspective" => {
            let lens = Brown::new(numbers(&case["k"]), numbers(&case["p"])).unwrap();
            Any(Box::new(BrownCamera::new(interior, lens)))
        }
        "equirectangular" => panorama(Panorama::Equirectangular),
        "cylindrical" => panorama(Panorama::Cylindrical),
        "equidistant" => fisheye(Fisheye::Equidistant),
        "stereographic" => fisheye(Fisheye::Stereographic),
        "equisolid" => fisheye(Fisheye::Equisolid),
        other => panic!("{other}"),
    };
    Frame::new(exterior, model)
}

fn surface(case: &Value) -> Box<dyn Surface> {
    let vector = |name: &str| Vector3::from(numbers::<3>(&case[name]));
    match case["kind"].as_str().unwrap() {
        "plane" => Box::new(
            Plane::from_point_and_normal(Point3::from(vector("point")), vector("normal")).unwrap(),
        ),
        "dome" => {
            let half_angle = case["half_angle_deg"].as_f64().unwrap().to_radians();
            let radius = case["radius"].as_f64().unwrap();
            let center = Point3::from(vector("center"));
            Box::new(Dome::new(center, radius, vector("axis"), half_angle).unwrap())
        }
        other => panic!("{other}"),
    }
}

#[test]
fn every_output_model_agrees_with_fifty_digits() {
    let text = include_str!("../data/oracles/output_models.json");
    let oracle: Value = serde_json::from_str(text).unwrap();
    let (mut seen, mut missed, mut worst) = (0, 0, 0.0_f64);
    for case in oracle["cases"].as_array().unwrap() {
        let (screen, texture) = (camera(&case["screen"]), camera(&case["texture"]));
        let map: Box<dyn Map> = if case["surface"]["kind"] == "infinity" {
            Box::new(SensorMap::distant(screen, texture))
        } else {
            Box::new(SensorMap::new(screen, surface(&case["surface"]), texture))
        };
        for point in case["points"].as_array().unwrap() {
            let pixel = Point2::from(numbers::<2>(&point["pixel"]));
            let found = map.at(&pixel);
            if point["texture"].is_null() {
                assert_eq!(found, Err(ProjectionError::MissesSurface), "{} {pixel}", case["name"]);
                missed += 1;
                continue;
            }
            let expected = Point2::from(numbers::<2>(&point["texture"]));
            let off = (found.unwrap() - expected).norm();
            assert!(off < 2e-9, "{} {pixel}: off by {off}", case["name"]);
            let rows = point["jacobian"].as_array().unwrap();
            let [a, b]: [[f64; 2]; 2] = [numbers(&rows[0]), numbers(&rows[1])];
            let expected = Matrix2::new(a[0], a[1], b[0], b[1]);
            let slope = (map.jacobian(&pixel).unwrap() - expected).norm() / expected.norm();
            assert!(slope < 1e-11, "{} {pixel}: slopes off by {slope}", case["name"]);
            (seen, worst) = (seen + 1, worst.max(off));
        }
    }
    assert_eq!((seen, missed), (21, 4));
    println!("{seen} points, largest difference {worst:.1e} px");
}

/// A dome master about an eye, looking up.
fn master(eye: Point3<f64>) -> Frame<CentralCamera<Fisheye, NoDistortion>> {
    let up = eye + Vector3::z();
    let exterior = ExteriorOrientation::look_at(eye, up, Vector3::y()).unwrap();
    let interior = InteriorOrientation::from_dome_master(4096.0, 200f64.to_radians()).unwrap();
    Frame::new(exterior, CentralCamera::ideal(interior, Fisheye::Equidistant))
}

proptest! {
    /// What the projector throws on the dome, seen from the eye point, is the picture that was made for the eye.
    #[test]
    fn the_audience_sees_the_picture_that_was_made_for_it(
        eye in support::point(0.4), place in support::point(1.0), target in support::point(0.6),
        radius in 1.5..300.0, k1 in -0.12..0.05, x in 0.0..1920.0, y in 0.0..1080.0,
    ) {
        let dome = Dome::new(Point3::origin(), radius, Vector3::z(), 95f64.to_radians()).unwrap();
        let (eye, place) = (eye * radius, place * (0.55 * radius));
        let target = Point3::new(target.x, target.y, 1.0) * radius;
        let Ok(pose) = ExteriorOrientation::look_at(place, target, Vector3::new(0.1, 1.0, 0.2)) else {
            return Ok(());
        };
        let interior = InteriorOrientation::new([1400.0, 1390.0], Point2::new(950.0, 700.0), 0.0).unwrap();
        let lens = Brown::new([k1, 0.01, 0.0], [1e-3, -5e-4]).unwrap();
        let projector = Frame::new(pose, BrownCamera::new(interior, lens));
        let master = master(eye);
        let prewarp = SensorMap::new(projector, dome, master);
        let pixel = Point2::new(x, y);
        if let Ok(content) = prewarp.at(&pixel) {
            // The light of the pixel falls on the dome, and from there into the eye.
            let lit = projector.ground(&pixel, &dome).unwrap();
            prop_assert!((lit.coords.norm() - radius).abs() < 1e-13 * radius * 10.0);
            // By its direction from the eye alone: θ from the zenith, c θ from the middle.
            let d = lit - eye;
            let angle = d.x.hypot(d.y).atan2(d.z);
            let c = 4096.0 / 200f64.to_radians();
            let from_middle = content - Point2::new(2048.0, 2048.0);
            prop_assert!((from_middle.norm() - c * angle).abs() < 1e-8);
            // +Y of the world is up in the picture, +X is on its left: the audience looks up.
            if from_middle.norm() > 1.0 {
                let turn = from_middle.normalize();
                prop_assert!((turn.y + d.y / d.x.hypot(d.y)).abs() < 1e-8);
                prop_assert!((turn.x + d.x / d.x.hypot(d.y)).abs() < 1e-8);
            }
        }
    }

    /// A plane and two frame cameras: the same as [WD] eq. 1.
    #[test]
    fn through_a_plane_between_frames_it_is_the_fractional_linear_map(
        screen in support::exterior(), texture in support::exterior(), normal in support::point(1.0),
        interior in support::interior(), x in 0.0..1000.0, y in 0.0..800.0,
    ) {
        let Ok(plane) = Plane::from_point_and_normal(Point3::origin(), normal.coords) else {
            return Ok(());
        };
        let (screen, texture) = (Frame::new(screen, interior), Frame::new(texture, interior));
        let map = SensorMap::new(screen, plane, texture);
        let Ok(linear) = FractionalLinear::from_plane(&plane, &texture.homogeneous(), &screen.homogeneous()) else {
            return Ok(());
        };
        let pixel = Point2::new(x, y);
        match (map.at(&pixel), linear.at(&pixel)) {
            (Ok(a), Ok(b)) => {
                let slopes = linear.jacobian(&pixel).unwrap();
                // A pixel's rounding, as the map enlarges it.
                let tolerance = 1e-11 * (1000.0 + b.coords.norm()) * (1.0 + slopes.norm());
                prop_assert!((a - b).norm() < tolerance, "{a} {b}");
                let own = map.jacobian(&pixel).unwrap();
                prop_assert!((own - slopes).norm() < 1e-9 * (1.0 + slopes.norm()).powi(2), "{own} {slopes}");
            }
            (a, b) => prop_assert_eq!(a.is_ok(), b.is_ok(), "{:?} {:?}", a, b),
        }
    }
}

#[test]
fn a_strip_is_an_output_model_as_any_other() {
    // A push broom 100 above the ground, 0.1 further east with each line, c = 1000 px: a pixel is a tenth of a unit in both directions.
    let down = Rotation3::from_matrix_unchecked(rows([
        [0.0, 1.0, 0.0],
        [1.0, 0.0, 0.0],
        [0.0, 0.0, -1.0],
    ]));
    let start = ExteriorOrientation::new(Point3::new(5.0, 7.0, 100.0), down);
    let east = Vector3::new(1.0, 0.0, 0.0);
    let flight = PolynomialTrajectory::constant_velocity(start, 0.0, east, Vector3::zeros());
    let line = InteriorOrientation::new([1000.0; 2], Point2::new(50.0, 0.0), 0.0).unwrap();
    let time = ScanTime::by_line(0.0, 0.1, [0.0, 200.0]).unwrap();
    let strip = Scanner::line_scan(line, flight.unwrap(), 0.0, time).unwrap();
    let ground = Plane::from_point_and_normal(Point3::origin(), Vector3::z()).unwrap();
    // The map of the ground, a quarter unit a pixel, north up, its corner at (0, 20).
    let flat = ExteriorOrientation::new(
        Point3::new(0.0, 20.0, 50.0),
        Rotation3::from_matrix_unchecked(rows([
            [1.0, 0.0, 0.0],
            [0.0, -1.0, 0.0],
            [0.0, 0.0, -1.0],
        ])),
    );
    let scale = Affine2::from_coefficients([0.0, 4.0, 0.0], [0.0, 0.0, 4.0]);
    let orthophoto = Orthographic::new(flat, scale).unwrap();
    let map = SensorMap::new(strip, ground, orthophoto);
    // Line 30.5 is flown at 3.05: X = 5 + 3.05, Y = 7 + (80 − 50)/10.
    let at = map.at(&Point2::new(80.0, 30.5)).unwrap();
    assert!((at - Point2::new(4.0 * 8.05, 4.0 * (20.0 - 10.0))).norm() < 1e-10, "{at}");
    let slopes = map.jacobian(&Point2::new(80.0, 30.5)).unwrap();
    assert!((slopes - Matrix2::new(0.0, 0.4, -0.4, 0.0)).norm() < 1e-9, "{slopes}");
}

fn rows(rows: [[f64; 3]; 3]) -> Matrix3<f64> {
    Matrix3::from_fn(|i, j| rows[i][j])
}

#[test]
fn a_globe_hides_its_far_side_from_a_photograph() {
    let from = |x: f64, y: f64, z: f64| {
        let place = Point3::new(x, y, z);
        let exterior =
            ExteriorOrientation::look_at(place, Point3::origin(), Vector3::new(0.1, 0.2, 1.0));
        let interior = InteriorOrientation::new([500.0; 2], Point2::new(300.0, 300.0), 0.0);
        Frame::new(exterior.unwrap(), interior.unwrap())
    };
    let globe = Sphere::new(Point3::origin(), 2.0).unwrap();
    let (view, photograph) = (from(0.0, -9.0, 3.0), from(8.0, -1.0, -2.0));
    let open = SensorMap::new(view, globe, photograph);
    let map = open.clone().hiding(1e-6).unwrap();
    let (mut shown, mut hidden) = (0, 0);
    for i in 0..60 {
        for j in 0..60 {
            let pixel = Point2::new(10.0 * f64::from(i) + 5.0, 10.0 * f64::from(j) + 5.0);
            let Ok(world) = view.ground(&pixel, &globe) else {
                assert_eq!(map.at(&pixel), Err(ProjectionError::MissesSurface));
                continue;
            };
            // The photograph sees the cap on its side of its polar plane.
            let center = photograph.exterior.projection_center();
            let facing = world.coords.dot(&center.coords) - 4.0;
            if facing.abs() < 1e-3 {
                continue;
            }
            assert!(open.at(&pixel).is_ok());
            if facing > 0.0 {
                assert_eq!(map.at(&pixel), open.at(&pixel));
                shown += 1;
            } else {
                let Err(ProjectionError::Hidden { distance }) = map.at(&pixel) else {
                    panic!("{pixel} is hidden");
                };
                assert_eq!(map.jacobian(&pixel), Err(ProjectionError::Hidden { distance }));
                // The chord from where the line of sight enters the globe.
                let chord = {
                    let d = (world - center).normalize();
                    let b = center.coords.dot(&d);
                    2.0 * (b * b - center.coords.norm_squared() + 4.0).sqrt()
                };
                assert!((distance - chord).abs() < 1e-9, "{distance} {chord}");
                hidden += 1;
            }
        }
    }
    assert!(shown > 100 && hidden > 100, "{shown} {hidden}");
}

#[test]
fn spheres_are_met_in_front_and_from_within() {
    let sphere = Sphere::new(Point3::new(1e6, 2e6, 300.0), 10.0).unwrap();
    let ray = |o: [f64; 3], d: [f64; 3]| {
        Ray::new(Point3::new(1e6 + o[0], 2e6 + o[1], 300.0 + o[2]), Vector3::from(d)).unwrap()
    };
    let met = |o, d| sphere.meet_ray(&ray(o, d)).map(|p| (p - sphere.center()).into());
    let near = |a: Result<[f64; 3], _>, b: [f64; 3]| {
        let a: [f64; 3] = a.unwrap();
        assert!((Vector3::from(a) - Vector3::from(b)).norm() < 1e-9, "{a:?} {b:?}");
    };
    near(met([-30.0, 6.0, 0.0], [1.0, 0.0, 0.0]), [-8.0, 6.0, 0.0]);
    near(met([0.0, 6.0, 0.0], [1.0, 0.0, 0.0]), [8.0, 6.0, 0.0]);
    near(met([0.0, 0.0, 0.0], [0.0, 0.0, -3.0]), [0.0, 0.0, -10.0]);
    for (o, d) in [([30.0, 6.0, 0.0], [1.0, 0.0, 0.0]), ([-30.0, 10.1, 0.0], [1.0, 0.0, 0.0])] {
        assert_eq!(met(o, d), Err(ProjectionError::MissesSurface));
    }
    // On it, going in and going out.
    let unit = Sphere::UNIT;
    let on = |d| unit.meet_ray(&Ray::new(Point3::new(0.0, 0.0, 1.0), d).unwrap()).unwrap();
    assert_eq!(on(Vector3::z()), Point3::new(0.0, 0.0, 1.0));
    // From far away the root that does not cancel: 1e8 − 1 from 1e8.
    let far = Ray::new(Point3::new(0.6, 0.0, 1e8), -Vector3::z()).unwrap();
    let hit = unit.meet_ray(&far).unwrap();
    assert!((hit - Point3::new(0.6, 0.0, 0.8)).norm() < 2e-8, "{hit}");
    assert!((unit.height_above(&Point3::new(0.0, 3.0, 4.0)) - 4.0).abs() < 1e-15);
}

#[test]
fn a_dome_is_open_below_its_rim() {
    let axis = Vector3::new(0.0, 3.0, 4.0);
    let dome = Dome::new(Point3::origin(), 5.0, axis, 60f64.to_radians()).unwrap();
    assert!((dome.axis().into_inner() - Vector3::new(0.0, 0.6, 0.8)).norm() < 1e-15);
    // 59° from the axis in the plane of x, and 61°.
    for (degrees, inside) in [(59.0_f64, true), (61.0, false)] {
        let (s, c) = degrees.to_radians().sin_cos();
        let d = dome.axis().into_inner() * c + Vector3::x() * s;
        let ray = Ray::new(Point3::origin(), d).unwrap();
        assert_eq!(dome.meet_ray(&ray).is_ok(), inside);
        let at = dome.height_above(&Point3::from(d * 7.0));
        assert!(if inside { (at - 2.0).abs() < 1e-14 } else { at.is_nan() }, "{at}");
    }
    // A projector on the sphere itself, below the rim, shines on the far side: 3² + 4² + 12² = 13².
    let wide = Dome::new(Point3::origin(), 13.0, Vector3::z(), 1.5).unwrap();
    let place = Point3::new(3.0, 4.0, -12.0);
    let hit = wide.meet_ray(&Ray::new(place, Vector3::z()).unwrap()).unwrap();
    assert_eq!(hit, Point3::new(3.0, 4.0, 12.0));
    assert!(wide.meet_ray(&Ray::new(place, -Vector3::z()).unwrap()).is_err());
    // A whole sphere is closed, straight opposite too.
    let whole = Dome::new(Point3::origin(), 5.0, axis, std::f64::consts::PI).unwrap();
    assert!(whole.meet_ray(&Ray::new(Point3::origin(), -axis).unwrap()).is_ok());
    for k in 0..200 {
        let axis = Vector3::new(f64::from(k).sin(), (2.3 * f64::from(k)).cos(), 0.37);
        let whole = Dome::new(Point3::origin(), 5.0, axis, std::f64::consts::PI).unwrap();
        assert!(whole.meet_ray(&Ray::new(Point3::origin(), -axis).unwrap()).is_ok(), "{axis}");
    }
    let normal = dome.normal(&Point3::new(0.0, 3.0, 4.0)).unwrap();
    assert!((normal.into_inner() - Vector3::new(0.0, 0.6, 0.8)).norm() < 1e-15);
}

#[test]
fn normals_of_surfaces_without_a_formula_are_good_to_eight_digits() {
    /// z = x³, with its height only.
    #[derive(Debug)]
    struct Steep;
    impl Surface for Steep {
        fn height_above(&self, p: &Point3<f64>) -> f64 {
            p.z - p.x * p.x * p.x
        }
        fn meet_ray(&self, _: &Ray) -> Result<Point3<f64>, ProjectionError> {
            Err(ProjectionError::MissesSurface)
        }
    }
    let found = Steep.normal(&Point3::new(0.5, 7.0, 0.125)).unwrap().into_inner();
    assert!((found - Vector3::new(-0.75, 0.0, 1.0).normalize()).norm() < 1e-8, "{found}");

    /// z = x²/8 + y/4, with its height only.
    #[derive(Debug)]
    struct Valley;
    impl Surface for Valley {
        fn height_above(&self, p: &Point3<f64>) -> f64 {
            p.z - p.x * p.x / 8.0 - p.y / 4.0
        }
        fn meet_ray(&self, _: &Ray) -> Result<Point3<f64>, ProjectionError> {
            Err(ProjectionError::MissesSurface)
        }
    }
    let points =
        [Point3::new(2.0, -3.0, 0.25), Point3::new(-100.0, 800.0, 1450.0), Point3::origin()];
    for p in points {
        let exact = Vector3::new(-p.x / 4.0, -0.25, 1.0).normalize();
        let found = (&Valley as &dyn Surface).normal(&p).unwrap().into_inner();
        assert!((found - exact).norm() < 1e-8, "{found} {exact}");
    }
    assert_eq!(Valley.normal(&Point3::new(f64::NAN, 0.0, 0.0)), Err(ProjectionError::NotFinite));
}

#[test]
fn bad_domes_and_pixels_are_refused_with_numbers() {
    let origin = Point3::origin();
    let refused = |r: Result<Dome, Error>, part: &str| {
        let text = r.unwrap_err().to_string();
        assert!(text.contains(part), "{text}");
    };
    refused(Dome::new(origin, 0.0, Vector3::z(), 1.0), "radius of a sphere is 0");
    refused(Dome::new(origin, f64::INFINITY, Vector3::z(), 1.0), "radius of a sphere is inf");
    refused(Dome::new(origin, 1.0, Vector3::zeros(), 1.0), "axis of a dome");
    refused(Dome::new(origin, 1.0, Vector3::new(0.0, f64::NAN, 1.0), 1.0), "axis of a dome");
    refused(Dome::new(origin, 1.0, Vector3::z(), 3.2), "half angle of a dome is 3.2");
    refused(Dome::new(origin, 1.0, Vector3::z(), f64::NAN), "half angle of a dome is NaN");
    refused(Dome::new(Point3::new(f64::NAN, 0.0, 0.0), 1.0, Vector3::z(), 1.0), "centre");

    let map = SensorMap::new(master(origin), Sphere::UNIT, master(Point3::new(0.1, 0.0, 0.0)));
    assert!(map.clone().hiding(0.0).is_err() && map.clone().hiding(f64::NAN).is_err());
    for pixel in [[f64::NAN, 0.0], [f64::INFINITY, 1.0], [1e300, -1e300], [-50_000.0, 0.0]] {
        assert!(map.at(&pixel.into()).is_err() && map.jacobian(&pixel.into()).is_err());
    }
    // A tangent line of sight meets the sphere, and has no slope.
    let grazing = ExteriorOrientation::new(Point3::new(1.0, 0.0, -3.0), Rotation3::identity());
    let interior = InteriorOrientation::new([1.0; 2], Point2::origin(), 0.0).unwrap();
    let view = Frame::new(grazing, interior);
    let map = SensorMap::new(view, Sphere::UNIT, master(origin));
    assert!(map.at(&Point2::origin()).is_ok());
    assert_eq!(map.jacobian(&Point2::origin()), Err(ProjectionError::NotFinite));
}

/// A homogeneous camera is the frame that it was made from, by collinearity equations written out.
#[test]
fn a_homogeneous_camera_is_a_sensor() {
    let place = Point3::new(1e6, 2e6, 300.0);
    let target = place + Vector3::new(30.0, 70.0, -40.0);
    let pose = ExteriorOrientation::look_at(place, target, Vector3::new(0.2, 0.1, 1.0)).unwrap();
    let interior =
        InteriorOrientation::new([900.0, 880.0], Point2::new(510.0, 390.0), 1.5).unwrap();
    let camera = Frame::new(pose, interior).homogeneous();
    let plain = support::PlainCamera::new(&pose, &interior);
    let world = target + Vector3::new(3.0, -5.0, 8.0);
    let [x, y, _] = plain.project(world.into());
    let (image, slopes) = camera.project_jacobian(&world).unwrap();
    assert!((image - Point2::new(x, y)).norm() < 1e-8);
    let h = 1e-3;
    for k in 0..3 {
        let step = Vector3::ith(k, h);
        let [[ax, ay, _], [bx, by, _]] =
            [world + step, world - step].map(|p| plain.project(p.into()));
        let expected = [(ax - bx) / (2.0 * h), (ay - by) / (2.0 * h)];
        for i in 0..2 {
            assert!((slopes[(i, k)] - expected[i]).abs() < 1e-4, "{slopes} {expected:?}");
        }
    }
    assert!(matches!(
        camera.project(&(place - (target - place))),
        Err(ProjectionError::BehindCamera { .. })
    ));
    let ground = Plane::from_point_and_normal(world, Vector3::new(0.1, -0.3, 0.9)).unwrap();
    assert!((camera.ground(&image, &ground).unwrap() - world).norm() < 1e-8);
    // A parallel projection 20 above a level sees it, and what is behind its plane Z′ = 0 too.
    let flat = ExteriorOrientation::look_at(
        Point3::new(10.0, 0.0, 20.0),
        Point3::new(10.0, 0.0, 0.0),
        Vector3::y(),
    )
    .unwrap();
    let scale = Affine2::from_coefficients([50.0, 4.0, 0.0], [60.0, 0.0, 4.0]);
    let parallel = Orthographic::new(flat, scale).unwrap().homogeneous();
    for height in [0.0, 35.0] {
        let level = Plane::from_point_and_normal(Point3::new(0.0, 0.0, height), Vector3::z());
        let hit = parallel.ground(&Point2::new(58.0, 72.0), &level.unwrap()).unwrap();
        // 8/4 to the right of x = 10, 12/4 below y = 0.
        assert!((hit - Point3::new(12.0, -3.0, height)).norm() < 1e-12, "{hit}");
        let (image, slopes) = parallel.project_jacobian(&hit).unwrap();
        assert!((image - Point2::new(58.0, 72.0)).norm() < 1e-12);
        assert!((slopes - Matrix2x3::new(4.0, 0.0, 0.0, 0.0, -4.0, 0.0)).norm() < 1e-12);
    }
}

#[test]
fn a_projector_on_the_dome_itself_shines_on_the_other_side() {
    // At the side of a sphere of radius 9 along (4, 3, 0)/5, and up: by hand, at 2 · 9 · cos of the angle with the inward normal.
    for center in [Point3::origin(), Point3::new(1_234_567.0, 5_678_901.0, 321.0)] {
        let dome = Dome::new(center, 9.0, Vector3::z(), 100f64.to_radians()).unwrap();
        let place = center + Vector3::new(-7.2, -5.4, 0.0);
        let inwards = Ray::new(place, Vector3::new(4.0, 3.0, 0.0)).unwrap();
        let hit = dome.meet_ray(&inwards).unwrap();
        assert!((hit - center - Vector3::new(7.2, 5.4, 0.0)).norm() < 1e-8, "{hit}");
        let up = Ray::new(place, Vector3::new(4.0, 3.0, 5.0)).unwrap();
        let hit = dome.meet_ray(&up).unwrap();
        assert!((hit - center - Vector3::new(0.0, 0.0, 9.0)).norm() < 1e-8, "{hit}");
        // Past the rim, 0.17 r below the centre, nothing is met.
        let down = Ray::new(place, Vector3::new(4.0, 3.0, -5.0)).unwrap();
        assert_eq!(dome.meet_ray(&down), Err(ProjectionError::MissesSurface));
        // A little outside it is the near side that is met.
        let outside =
            Ray::new(place - Vector3::new(0.8, 0.6, 0.0) * 1e-3, Vector3::new(4.0, 3.0, 0.0));
        let hit = dome.meet_ray(&outside.unwrap()).unwrap();
        assert!((hit - place).norm() < 1e-8, "{hit}");
    }
}
