//! The planes of a real reconstruction: found in its points, photographed, rectified.

use collinear::camera::{ExteriorOrientation, Orthographic, SensorModel};
use collinear::geometry::{Affine2, Locus, Plane, Surface};
use collinear::mapping::{FractionalLinear, Map, PhotographMap, UndistortMap};
use collinear::nalgebra::{Matrix3, Point2, Point3, Rotation3, Vector3};
use collinear::numeric::consensus::{ConsensusOptions, Estimator, search};
use collinear_io::opensfm::read_reconstruction;
use collinear_io::plane::PlaneFile;

/// World units in a rectified pixel.
const GROUND_SAMPLE: f64 = 0.01;

struct Planes<'a>(&'a [Point3<f64>]);

impl Estimator for Planes<'_> {
    type Model = Plane;
    const SAMPLE: usize = 3;

    fn len(&self) -> usize {
        self.0.len()
    }

    fn minimal(&self, sample: &[usize], models: &mut Vec<Plane>) {
        let [a, b, c] = [0, 1, 2].map(|i| &self.0[sample[i]]);
        models.extend(Plane::through(a, b, c));
    }

    fn squared_residual(&self, plane: &Plane, index: usize) -> f64 {
        plane.signed_distance(&self.0[index]).powi(2)
    }

    fn refine(&self, _: &Plane, inliers: &[bool]) -> Option<Plane> {
        Plane::fit(&on(self.0, inliers)).ok().map(|fit| fit.plane)
    }
}

fn on(points: &[Point3<f64>], inliers: &[bool]) -> Vec<Point3<f64>> {
    points.iter().zip(inliers).filter(|(_, i)| **i).map(|(p, _)| *p).collect()
}

/// Points of the largest plane, seen in each photograph through its lens: the way back over the rectified picture ends at
/// their coordinates in the plane, and so does the line of sight.
#[test]
fn a_rectified_picture_shows_each_point_at_its_plane_coordinates() {
    let Some(folder) = crate::shared_data("berlin") else { return };
    let reconstruction =
        read_reconstruction(&folder.join("reconstruction_example.json"), 0).unwrap();
    let points: Vec<Point3<f64>> =
        reconstruction.points.values().map(|p| Point3::from(p.coordinates)).collect();
    let options = ConsensusOptions { threshold: 0.15, ..ConsensusOptions::default() };
    let found = search(&Planes(&points), &options).unwrap();
    let on_plane = on(&points, &found.inliers);
    let fit = Plane::fit(&on_plane).unwrap();
    assert!(on_plane.len() >= 150 && fit.rms < 0.1, "{} points, {}", on_plane.len(), fit.rms);

    for shot in reconstruction.shots.keys() {
        let camera = reconstruction.camera(shot).unwrap();
        let frame = camera.frame().unwrap();
        let eye = frame.exterior.projection_center();
        let seen =
            if fit.plane.signed_distance(&eye) > 0.0 { fit.plane } else { fit.plane.flipped() };
        let file = PlaneFile {
            point: seen.point().into(),
            normal: (*seen.normal()).into(),
            up: None,
            rectangle: None,
        };
        let axes = file.axes().unwrap();

        // Face-on, 30 by 30 units about the plane's point, as a parallel view from the side of the normal.
        let rows = [axes.right, axes.up.map(|c| -c), axes.normal.map(|c| -c)];
        let toward = Rotation3::from_matrix_unchecked(Matrix3::from_rows(
            &rows.map(|r| Vector3::from(r).transpose()),
        ));
        let scale = 1.0 / GROUND_SAMPLE;
        let pixel = Affine2::from_coefficients([1500.0, scale, 0.0], [1500.0, 0.0, scale]);
        let exterior = ExteriorOrientation::new(seen.point() + *seen.normal(), toward);
        let screen = Orthographic::new(exterior, pixel).unwrap().homogeneous();
        let ideal = frame.ideal().homogeneous();
        let linear = FractionalLinear::from_plane(&seen, &ideal, &screen).unwrap();
        let rectified_from_ideal = linear.homography().unwrap().inverse().unwrap();
        let photograph = PhotographMap::from_plane(&seen, &frame, &screen).unwrap();
        let undistort = UndistortMap::new(frame.camera);

        let (mut checked, mut lens) = (0, 0.0_f64);
        for p in &on_plane {
            let world = seen.foot(p);
            let Ok(image) = frame.project(&world) else { continue };
            let (w, h) = (f64::from(camera.width), f64::from(camera.height));
            if !(0.0..w).contains(&image.x) || !(0.0..h).contains(&image.y) {
                continue;
            }
            let [right, up] = file.plane_from_world(&world.into()).unwrap();
            let expected = Point2::new(1500.0 + right * scale, 1500.0 - up * scale);
            let ideal = undistort.at(&image).unwrap();
            let back = rectified_from_ideal.apply(&ideal).unwrap();
            assert!((back - expected).norm() < 1e-6, "{shot}: {back} for {expected}");
            let there = photograph.at(&expected).unwrap();
            assert!((there - image).norm() < 1e-6, "{shot}: {there} for {image}");
            let Locus::Ray(ray) = frame.locus(&image).unwrap() else { panic!("a ray") };
            assert!((seen.meet_ray(&ray).unwrap() - world).norm() < 1e-8, "{shot}");
            checked += 1;
            lens = lens.max((ideal - image).norm());
        }
        // Without the lens the same points would be pixels away.
        assert!(checked >= 40 && lens > 5.0, "{shot}: {checked} points, lens {lens}");
    }
}
