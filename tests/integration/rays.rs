//! Pictures by lines of sight: against the scanline texturer, and against numbers taken by hand.

use collinear::camera::{
    CentralCamera, ExteriorOrientation, Fisheye, Frame, ImageMotionCompensation,
    InteriorOrientation, Panorama, PolynomialTrajectory, ScanTime, Scanner, SensorModel,
};
use collinear::geometry::{HeightCurve, Locus, Plane, Ray, Surface};
use collinear::nalgebra::{Matrix2x3, Point2, Point3, Rotation3, Vector3};
use collinear::resample::{Border, Filter, ImageView, ImageViewMut};
use collinear::texturer::{
    Canvas, Facets, Facing, Paint, PlaneTexture, RayCaster, RayPaint, ScreenPolygon,
};
use collinear::{Error, ProjectionError};
use proptest::prelude::*;

use crate::support;

const SIZE: [usize; 2] = [100, 80];

/// The tenth part of a camera of 1000 × 800 pixels.
fn small(interior: &InteriorOrientation) -> InteriorOrientation {
    let c = interior.principal_distance().map(|c| c / 10.0);
    InteriorOrientation::new(c, interior.principal_point() / 10.0, 0.0).unwrap()
}

/// Polygons about the origin: triangles, and quadrilaterals that may be concave, each in a plane.
fn polygons() -> impl Strategy<Value = Vec<Vec<Point3<f64>>>> {
    let corners =
        (support::point(4.0), support::point(3.0), support::point(3.0), any::<bool>(), 0.1..0.9)
            .prop_filter_map("degenerate", |(p, u, v, four, inner)| {
                let (u, v) = (u.coords, v.coords);
                (u.cross(&v).norm() > 0.5).then(|| match four {
                    false => vec![p, p + u, p + v],
                    // An arrowhead where the fourth vertex is within the triangle of the others.
                    true => vec![p, p + u, p + (u + v) * inner, p + v],
                })
            });
    prop::collection::vec(corners, 1..8)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn a_perspective_picture_is_the_scanline_texturers(
        exterior in support::exterior(), interior in support::interior(), polygons in polygons(), cull in 0..3,
    ) {
        let screen = Frame::new(exterior, small(&interior));
        let homogeneous = screen.homogeneous();
        let facing = [Facing::Both, Facing::Front, Facing::Back][cull as usize];
        // A ramp of 16 bits along the world's x tells the place, its channel the polygon.
        let texture: Vec<f32> = (0..64 * 64).map(|i| (i % 64) as f32 + 64.0 * (i / 64) as f32).collect();
        let image = ImageView::<f32, 1>::new(&texture, 64, 64).unwrap();
        let coordinates = |world: &[Point3<f64>]| -> Vec<Vector3<f64>> {
            world.iter().enumerate().map(|(i, _)| {
                let corner = [(2.0, 3.0), (60.0, 4.0), (31.0, 33.5), (2.0, 63.0)];
                let corner = if world.len() == 3 { [corner[0], corner[1], corner[3], corner[3]] } else { corner };
                Vector3::new(corner[i].0, corner[i].1, 1.0)
            }).collect()
        };
        // Vertices off one affine map of their plane have no texture here; their polygons are flat.
        let textures: Vec<Option<PlaneTexture>> = polygons.iter().map(|p| {
            PlaneTexture::from_vertices(p, &coordinates(p)).ok()
        }).collect();

        let mut drawn = vec![-1.0_f32; SIZE[0] * SIZE[1]];
        {
            let mut canvas = Canvas::new(ImageViewMut::<f32, 1>::new(&mut drawn, SIZE[0], SIZE[1]).unwrap());
            for (i, polygon) in polygons.iter().enumerate() {
                let outline = ScreenPolygon::project(polygon, &homogeneous, 0.05).unwrap();
                let plane = Plane::fit(polygon).unwrap().plane;
                let Ok(nearness) = homogeneous.nearness(&plane) else { return Ok(()) };
                if outline.is_empty() || !outline.shows(facing) {
                    continue;
                }
                let paint = match &textures[i] {
                    Some(_) => {
                        let map = collinear::texturer::from_vertices(polygon, &coordinates(polygon), &homogeneous);
                        let Ok(map) = map else { return Ok(()) };
                        let paint = Paint::Texture { image, map: &map, filter: Filter::Bilinear, border: Border::Clamp };
                        canvas.draw(&outline, nearness, &paint).unwrap();
                        continue;
                    }
                    None => Paint::Flat([10_000.0 + i as f32]),
                };
                canvas.draw(&outline, nearness, &paint).unwrap();
            }
        }

        let (facets, refused) = Facets::new(&polygons).unwrap();
        prop_assert!(refused.is_empty());
        let places: Vec<_> = textures.iter().map(|t| move |p: &Point3<f64>| {
            t.as_ref().map_or(Err(ProjectionError::NotFinite), |t| t.at(p))
        }).collect();
        let paints: Vec<RayPaint<'_, f32, 1>> = textures.iter().zip(&places).enumerate().map(|(i, (t, place))| match t {
            Some(_) => RayPaint::Picture { image, coordinates: place, filter: Filter::Bilinear, border: Border::Clamp },
            None => RayPaint::Flat([10_000.0 + i as f32]),
        }).collect();
        let mut cast = vec![-1.0_f32; SIZE[0] * SIZE[1]];
        let caster = RayCaster { screen: &screen, facets: &facets, paints: &paints, facing, near: 0.0 };
        caster.draw(&mut ImageViewMut::<f32, 1>::new(&mut cast, SIZE[0], SIZE[1]).unwrap());

        // Pixels may differ where the centre is within a snapped vertex's reach of an edge, or where two polygons cross.
        let different = drawn.iter().zip(&cast).filter(|(a, b)| (*a - *b).abs() > 0.05 * (1.0 + a.abs() / 100.0)).count();
        let allowed = 4 + SIZE[0] * SIZE[1] / 400;
        prop_assert!(different <= allowed, "{different} pixels differ");
    }
}

/// A level square about the axis at height z, with its corners counter-clockwise from above.
fn square(half: f64, z: f64) -> Vec<Point3<f64>> {
    [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)]
        .map(|(x, y)| Point3::new(x * half, y * half, z))
        .to_vec()
}

fn one(
    screen: &dyn SensorModel,
    facets: &Facets,
    paints: &[RayPaint<'_, u8, 1>],
    facing: Facing,
    near: f64,
) -> u8 {
    let mut pixel = [0];
    RayCaster { screen, facets, paints, facing, near }.row(0, &mut pixel, |_, _| ());
    pixel[0]
}

/// A camera 10 up that looks down through one pixel.
fn down() -> Frame<InteriorOrientation> {
    let exterior =
        ExteriorOrientation::look_at(Point3::new(0.0, 0.0, 10.0), Point3::origin(), Vector3::y());
    let interior = InteriorOrientation::new([1.0; 2], Point2::new(0.5, 0.5), 0.0);
    Frame::new(exterior.unwrap(), interior.unwrap())
}

#[test]
fn what_has_no_value_shows_what_lies_behind() {
    let (facets, _) = Facets::new(&[square(1.0, 4.0), square(1.0, 6.0), square(1.0, 2.0)]).unwrap();
    let texture = [77_u8];
    let image = ImageView::<u8, 1>::new(&texture, 1, 1).unwrap();
    let inside = |_: &Point3<f64>| Ok(Point2::new(0.5, 0.5));
    let beyond = |_: &Point3<f64>| Ok(Point2::new(1.5, 0.5));
    let nothing = |_: &Point3<f64>| Err(ProjectionError::BehindCamera { depth: -1.0 });
    let picture = |coordinates, border| RayPaint::Picture {
        image,
        coordinates,
        filter: Filter::Nearest,
        border,
    };
    let below = RayPaint::Flat([5]);
    let show = |paint| one(&down(), &facets, &[below, paint], Facing::Both, 0.1);
    assert_eq!(show(picture(&inside, Border::Transparent)), 77);
    assert_eq!(show(picture(&beyond, Border::Transparent)), 5);
    assert_eq!(show(picture(&beyond, Border::Clamp)), 77);
    assert_eq!(show(picture(&nothing, Border::Clamp)), 5);
    assert_eq!(show(RayPaint::Nothing), 5);
    // The third polygon has no paint.
    assert_eq!(one(&down(), &facets, &[RayPaint::Nothing; 2], Facing::Both, 0.1), 0);
}

#[test]
fn sides_near_and_equal_distances_decide_as_on_the_canvas() {
    let mut turned = square(1.0, 6.0);
    turned.reverse();
    let (facets, _) = Facets::new(&[square(1.0, 4.0), turned, square(1.0, 4.0)]).unwrap();
    let paints = [RayPaint::Flat([1]), RayPaint::Flat([2]), RayPaint::Flat([3])];
    assert_eq!(one(&down(), &facets, &paints, Facing::Both, 0.1), 2);
    assert_eq!(one(&down(), &facets, &paints, Facing::Front, 0.1), 1);
    assert_eq!(one(&down(), &facets, &paints, Facing::Back, 0.1), 2);
    // The second lies 4 away, the others 6; of equal ones the first.
    assert_eq!(one(&down(), &facets, &paints, Facing::Both, 4.5), 1);
    assert_eq!(one(&down(), &facets, &paints, Facing::Both, 6.5), 0);
    let paints = [RayPaint::Nothing, RayPaint::Nothing, RayPaint::Flat([3])];
    assert_eq!(one(&down(), &facets, &paints, Facing::Both, 0.1), 3);
}

#[test]
fn a_dome_master_shows_rings_at_their_angles() {
    // Level squares over the eye: the rim of each is seen at 45° where its half side is its height.
    let (facets, _) = Facets::new(&[square(5.0, 5.0), square(30.0, 6.0)]).unwrap();
    let up =
        ExteriorOrientation::look_at(Point3::origin(), Point3::new(0.0, 0.0, 1.0), Vector3::y());
    let interior = InteriorOrientation::from_dome_master(180.0, std::f64::consts::PI).unwrap();
    let screen = Frame::new(up.unwrap(), CentralCamera::ideal(interior, Fisheye::Equidistant));
    let paints = [RayPaint::Flat([1]), RayPaint::Flat([2])];
    let mut pixels = vec![0_u8; 180 * 180];
    let caster = RayCaster {
        screen: &screen,
        facets: &facets,
        paints: &paints,
        facing: Facing::Both,
        near: 0.1,
    };
    caster.draw(&mut ImageViewMut::<u8, 1>::new(&mut pixels, 180, 180).unwrap());
    // One pixel is one degree. Along the middle row: 45° to the first one's edge, atan 5 = 78.69° to the second's, then nothing.
    let row: Vec<u8> = pixels[90 * 180 + 90..91 * 180].to_vec();
    let expected: Vec<u8> = (0..90)
        .map(|x| match f64::from(x) + 0.5 {
            a if a < 45.0 => 1,
            a if a < 78.69 => 2,
            _ => 0,
        })
        .collect();
    assert_eq!(row, expected);
    // Along the diagonal its corner is at atan √2 = 54.7°.
    let diagonal = |k: usize| pixels[(90 + k) * 180 + 90 + k];
    assert_eq!([diagonal(38), diagonal(39)], [1, 2]);
}

#[test]
fn a_panoramic_strip_is_drawn_with_its_moving_camera() {
    // The slit turns a radian in a second, and the camera rises by 2 in it: the far wall's upper edge falls along the strip.
    let wall: Vec<Vec<Point3<f64>>> = (0..40)
        .map(|k| {
            let at = |k: i32, y: f64| {
                let (s, c) = (f64::from(k) * 0.05 - 0.5).sin_cos();
                Point3::new(10.0 * s, y, 10.0 * c)
            };
            vec![at(k, 0.0), at(k + 1, 0.0), at(k + 1, 5.0), at(k, 5.0)]
        })
        .collect();
    let (facets, _) = Facets::new(&wall).unwrap();
    let pose = ExteriorOrientation::new(Point3::origin(), Rotation3::identity());
    let drift = Vector3::new(0.0, -2.0, 0.0);
    let rise = PolynomialTrajectory::constant_velocity(pose, 0.0, drift, Vector3::zeros()).unwrap();
    let interior = InteriorOrientation::new([100.0; 2], Point2::new(0.0, 20.0), 0.0).unwrap();
    let compensation = ImageMotionCompensation::new(0.0).unwrap();
    let time = ScanTime::by_column(0.0, 0.01, [0.0, 100.0]).unwrap();
    let strip = Scanner::panoramic(interior, compensation, rise, time).unwrap();
    let paints = vec![RayPaint::Flat([9_u8]); 40];
    let (width, height) = (100, 60);
    let mut pixels = vec![0_u8; width * height];
    let caster = RayCaster {
        screen: &strip,
        facets: &facets,
        paints: &paints,
        facing: Facing::Both,
        near: 0.1,
    };
    caster.draw(&mut ImageViewMut::<u8, 1>::new(&mut pixels, width, height).unwrap());
    for x in [0, 25, 50, 75, 99] {
        // y is down: at 2 t above its start the camera sees the edge 2 t below its level, at the wall's distance there.
        let t = 0.01 * (x as f64 + 0.5);
        let from_middle = (t - 0.5 + 0.5) % 0.05 - 0.025;
        let distance = 10.0 * 0.025_f64.cos() / from_middle.cos();
        let edge = 20.0 + 100.0 * 2.0 * t / distance;
        let first = (0..height).find(|y| pixels[y * width + x] == 9).unwrap();
        assert!((first as f64 - edge).abs() <= 0.51, "column {x}: {first}, {edge}");
    }
}

/// A sensor whose lines of sight are curves over height: x = X − z²/100, y = Y.
#[derive(Debug)]
struct Bent;

impl SensorModel for Bent {
    fn project(&self, p: &Point3<f64>) -> Result<Point2<f64>, ProjectionError> {
        Ok(Point2::new(p.x - p.z * p.z / 100.0, p.y))
    }
    fn project_jacobian(
        &self,
        p: &Point3<f64>,
    ) -> Result<(Point2<f64>, Matrix2x3<f64>), ProjectionError> {
        Ok((self.project(p)?, Matrix2x3::new(1.0, 0.0, -p.z / 50.0, 0.0, 1.0, 0.0)))
    }
    fn locus(&self, image: &Point2<f64>) -> Result<Locus, ProjectionError> {
        Ok(Locus::Curve(HeightCurve {
            coefficients: [
                Vector3::new(image.x, image.y, 0.0),
                Vector3::z(),
                Vector3::new(0.01, 0.0, 0.0),
                Vector3::zeros(),
            ],
            reference_height: 0.0,
            heights: [-5.0, 30.0],
            error_bound: 0.0,
        }))
    }
}

#[test]
fn a_curve_over_height_meets_polygons_from_the_top() {
    let (facets, _) = Facets::new(&[square(20.0, 3.0), square(4.0, 20.0)]).unwrap();
    let sight = |x: f64| {
        facets
            .first(&Bent.locus(&Point2::new(x, 0.5)).unwrap(), |_| true)
            .map(|s| (s.polygon, s.point))
    };
    // At z = 20 the curve is 4 further: the upper square is met by x from −8 to 0.
    let (polygon, point) = sight(-1.0).unwrap();
    assert_eq!(polygon, 1);
    assert!((point - Point3::new(3.0, 0.5, 20.0)).norm() < 1e-12, "{point}");
    let (polygon, point) = sight(1.0).unwrap();
    assert_eq!(polygon, 0);
    assert!((point - Point3::new(1.09, 0.5, 3.0)).norm() < 1e-12, "{point}");
    assert_eq!(sight(50.0), None);
    // Passed over, the lower one is seen.
    let locus = Bent.locus(&Point2::new(-1.0, 0.5)).unwrap();
    let below = facets.first(&locus, |s| s.polygon == 0).unwrap();
    assert!((below.point - Point3::new(-0.91, 0.5, 3.0)).norm() < 1e-12);
}

#[test]
fn a_panorama_of_a_room_has_no_gap_at_its_corners() {
    let wall = |k: f64| {
        let turn = Rotation3::from_axis_angle(&Vector3::y_axis(), k * std::f64::consts::FRAC_PI_2);
        [(-3.0, -9.0), (3.0, -9.0), (3.0, 9.0), (-3.0, 9.0)]
            .map(|(x, y)| turn * Point3::new(x, y, 3.0) + Vector3::new(1000.0, 50.0, -400.0))
            .to_vec()
    };
    let (facets, _) = Facets::new(&[0.0, 1.0, 2.0, 3.0].map(wall)).unwrap();
    let eye = ExteriorOrientation::new(Point3::new(1000.4, 50.3, -400.7), Rotation3::identity());
    let interior = InteriorOrientation::new(
        [2000.0 / std::f64::consts::TAU; 2],
        Point2::new(1000.0, 10.0),
        0.0,
    );
    let screen = Frame::new(eye, CentralCamera::ideal(interior.unwrap(), Panorama::Cylindrical));
    let paints = [1, 2, 3, 4].map(|c| RayPaint::Flat([c]));
    let mut pixels = vec![0_u8; 2000 * 20];
    let caster = RayCaster {
        screen: &screen,
        facets: &facets,
        paints: &paints,
        facing: Facing::Both,
        near: 0.1,
    };
    caster.draw(&mut ImageViewMut::<u8, 1>::new(&mut pixels, 2000, 20).unwrap());
    assert!(pixels.iter().all(|p| *p != 0));
    // The corner between ahead and right, (3, 3) less (0.4, −0.7): where the line changes.
    let change = (0..2000).find(|&x| pixels[x] == 2 && x > 900).unwrap();
    let exact = 1000.0 + 2000.0 / std::f64::consts::TAU * (2.6_f64).atan2(3.7);
    assert!((change as f64 - exact).abs() <= 0.51, "{change} {exact}");
}

#[test]
fn polygons_that_are_none_are_refused_by_their_numbers() {
    let line = vec![Point3::origin(), Point3::new(1.0, 1.0, 1.0), Point3::new(2.0, 2.0, 2.0)];
    let nan = vec![Point3::origin(), Point3::new(f64::NAN, 1.0, 1.0), Point3::new(2.0, 2.0, 0.0)];
    let two = vec![Point3::origin(), Point3::new(2.0, 2.0, 0.0)];
    let all = [line, square(1.0, 0.0), nan, two];
    let (facets, refused) = Facets::new(&all).unwrap();
    assert_eq!(refused.iter().map(|r| r.0).collect::<Vec<_>>(), [0, 2, 3]);
    assert!(matches!(refused[0].1, Error::Degenerate { .. }));
    assert!(matches!(refused[2].1, Error::TooFewPoints { needed: 3, got: 2 }));
    let ray = Ray::new(Point3::new(0.2, 0.1, 5.0), -Vector3::z()).unwrap();
    assert_eq!(facets.first(&Locus::Ray(ray), |_| true).map(|s| s.polygon), Some(1));
    assert!(Facets::new(&all[2..]).is_err());
    assert!(Facets::new::<Vec<Point3<f64>>>(&[]).is_err());
}

#[test]
fn of_a_polygon_that_crosses_itself_the_even_odd_rule_decides() {
    // A pentagram about the axis: its points are in it, its middle is not.
    let star: Vec<_> = (0..5)
        .map(|k| {
            let (s, c) = (f64::from(k) * 4.0 * std::f64::consts::PI / 5.0).sin_cos();
            Point3::new(5.0 * s, 5.0 * c, 2.0)
        })
        .collect();
    let bow_tie = [(-3.0, -3.0), (3.0, 3.0), (3.0, -3.0), (-3.0, 3.0)];
    let bow_tie = bow_tie.map(|(x, y)| Point3::new(x + 20.0, y, 2.0)).to_vec();
    let (facets, refused) = Facets::new(&[star, bow_tie]).unwrap();
    assert!(refused.is_empty());
    let sees = |x: f64, y: f64| {
        let ray = Ray::new(Point3::new(x, y, 9.0), -Vector3::z()).unwrap();
        facets.first(&Locus::Ray(ray), |_| true).map(|s| s.polygon)
    };
    assert_eq!(sees(0.0, 0.0), None);
    for k in 0..5 {
        let (s, c) = (f64::from(k) * std::f64::consts::TAU / 5.0).sin_cos();
        assert_eq!(sees(3.0 * s, 3.0 * c), Some(0), "point {k}");
        // Between two points it is open.
        let (s, c) = ((f64::from(k) + 0.5) * std::f64::consts::TAU / 5.0).sin_cos();
        assert_eq!(sees(3.0 * s, 3.0 * c), None, "gap {k}");
    }
    assert_eq!([sees(22.0, 0.5), sees(18.0, -0.5)], [Some(1), Some(1)]);
    assert_eq!([sees(20.5, 2.0), sees(19.5, -2.0)], [None, None]);
    // A figure of two equal parts has no front, one of unequal parts has that of the larger.
    let ray = Ray::new(Point3::new(22.0, 0.5, 9.0), -Vector3::z()).unwrap();
    assert_eq!(facets.first(&Locus::Ray(ray), |_| true).unwrap().from_front, None);
    let uneven = [(-3.0, -3.0), (1.0, 3.0), (-1.0, 3.0), (3.0, -3.0)];
    let uneven = uneven.map(|(x, y)| Point3::new(x, y, 2.0)).to_vec();
    let front = |polygon: Vec<Point3<f64>>| {
        let (facets, _) = Facets::new(&[polygon]).unwrap();
        let ray = Ray::new(Point3::new(0.0, -2.0, 9.0), -Vector3::z()).unwrap();
        facets.first(&Locus::Ray(ray), |_| true).unwrap().from_front
    };
    // Its larger part, below, goes clockwise as seen from above.
    let mut reversed = uneven.clone();
    reversed.reverse();
    assert_eq!([front(uneven), front(reversed)], [Some(false), Some(true)]);
}

#[test]
fn polygons_are_a_surface() {
    let bow_tie = [(-3.0, -3.0), (3.0, 3.0), (3.0, -3.0), (-3.0, 3.0)];
    let bow_tie = bow_tie.map(|(x, y)| Point3::new(x, y, 6.0)).to_vec();
    let (facets, _) = Facets::new(&[square(9.0, 2.0), square(9.0, 4.0), bow_tie]).unwrap();
    let surface: &dyn Surface = &facets;
    let from = |x: f64, y: f64, z: f64, down: f64| {
        surface.meet_ray(&Ray::new(Point3::new(x, y, z), Vector3::new(0.0, 0.0, down)).unwrap())
    };
    assert_eq!(from(2.0, 0.5, 9.0, -1.0), Ok(Point3::new(2.0, 0.5, 6.0)));
    // Through the open part of the bow tie, and from below.
    assert_eq!(from(0.5, 2.0, 9.0, -1.0), Ok(Point3::new(0.5, 2.0, 4.0)));
    assert_eq!(from(0.5, 2.0, 0.0, 1.0), Ok(Point3::new(0.5, 2.0, 2.0)));
    assert_eq!(from(0.5, 2.0, 5.0, 1.0), Err(ProjectionError::MissesSurface));
    assert_eq!(surface.normal(&Point3::new(0.0, 0.0, 4.1)).unwrap().z, 1.0);
    assert!((surface.height_above(&Point3::new(1.0, 1.0, 4.5)) - 0.5).abs() < 1e-15);
}

/// A polygon in the plane y = 5 of corners (x, z), and which of these points of it are met from the origin.
fn met(corners: &[[f64; 2]], points: &[[f64; 2]]) -> Vec<bool> {
    let world: Vec<Point3<f64>> = corners.iter().map(|[x, z]| Point3::new(*x, 5.0, *z)).collect();
    let (facets, refused) = Facets::new(&[world]).unwrap();
    assert!(refused.is_empty(), "{refused:?}");
    let at = |[x, z]: &[f64; 2]| {
        let ray = Ray::new(Point3::origin(), Vector3::new(*x, 5.0, *z)).unwrap();
        facets.first(&Locus::Ray(ray), |_| true).is_some()
    };
    points.iter().map(at).collect()
}

#[test]
fn polygons_of_a_hundred_thousand_vertices_are_cut_in_seconds() {
    let polar = |r: f64, angle: f64| [r * angle.cos(), r * angle.sin()];
    let turn = std::f64::consts::TAU;
    let n = 100_000;
    let part = |k: usize| turn * k as f64 / n as f64;
    // A circle; a wheel of 50 000 teeth from 1 to 2.
    let circle: Vec<_> = (0..n).map(|k| polar(2.0, part(k))).collect();
    let points = [polar(0.0, 0.0), polar(1.999, 1.0), polar(2.001, 1.0)];
    assert_eq!(met(&circle, &points), [true, true, false]);
    let wheel: Vec<_> = (0..n).map(|k| polar(1.0 + (k % 2) as f64, part(k))).collect();
    // On the axis of a tooth and of a gap.
    let points = [polar(0.99, 1.0), polar(1.9, part(33_331)), polar(1.9, part(33_332))];
    assert_eq!(met(&wheel, &points), [true, true, false]);
    // A band half as wide as the spiral's turns are apart: r − 1 − angle/turn is from 0 to ½, or to as much above a whole number.
    let winding = |k: usize| 20.0 * turn * k as f64 / (n / 2) as f64;
    let outer = (0..n / 2).map(|k| polar(1.5 + winding(k) / turn, winding(k)));
    let inner = (0..n / 2).rev().map(|k| polar(1.0 + winding(k) / turn, winding(k)));
    let spiral: Vec<_> = outer.chain(inner).collect();
    let points: Vec<_> =
        (0..200).map(|k| polar(3.0 + 0.05 * f64::from(k) + 0.003, 2.39 * f64::from(k))).collect();
    let expected: Vec<bool> = points
        .iter()
        .map(|[x, z]| (x.hypot(*z) - 1.0 - z.atan2(*x) / turn).rem_euclid(1.0) < 0.5)
        .collect();
    assert_eq!(met(&spiral, &points), expected);
    // A comb: below the tip of a tooth, and above the bottom of a gap.
    let tooth = |k: usize| [k as f64 / n as f64, (k % 2) as f64];
    let mut comb: Vec<_> = (0..n).map(tooth).collect();
    comb.extend([[1.0, -1.0], [0.0, -1.0]]);
    let points = [[0.500_01, -0.5], [0.500_01, 0.999], [0.500_02, 0.001], [-0.001, 0.5]];
    assert_eq!(met(&comb, &points), [true, true, false, false]);
}

#[test]
fn a_thousand_polygons_that_show_nothing_are_passed_in_seconds() {
    // Walls at 1, 2, 3, …, 3000, each of two triangles, the ray through both.
    let wall = |k: usize| {
        let y = 1.0 + k as f64;
        [(-9.0, -9.0), (9.0, -9.0), (9.0, 9.0), (-9.0, 9.0)].map(|(x, z)| Point3::new(x, y, z))
    };
    let walls: Vec<_> = (0..3000).map(wall).collect();
    let (facets, _) = Facets::new(&walls).unwrap();
    let ray = Ray::new(Point3::origin(), Vector3::y()).unwrap();
    for last in [0, 7, 8, 9, 2999] {
        let mut asked = Vec::new();
        let sight = facets.first(&Locus::Ray(ray), |sight| {
            asked.push(sight.polygon);
            sight.polygon == last
        });
        assert_eq!(asked, (0..=last).collect::<Vec<_>>());
        assert_eq!(sight.map(|s| s.point), Some(Point3::new(0.0, 1.0 + last as f64, 0.0)));
    }
    for _ in 0..100 {
        assert_eq!(facets.first(&Locus::Ray(ray), |_| false), None);
    }
}
