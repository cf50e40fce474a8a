//! Rigid motions against motions by hand.

use collinear::geometry::Pose;
use collinear::nalgebra::{Matrix3, Point3, Rotation3, Vector3};
use proptest::prelude::*;

use crate::support::point;

/// Rows (0 0 1), (1 0 0), (0 1 0): (x, y, z) ↦ (z, x, y).
fn cycle() -> Rotation3<f64> {
    Rotation3::from_matrix_unchecked(Matrix3::new(0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0))
}

/// A quarter about z: (x, y, z) ↦ (−y, x, z).
fn quarter() -> Rotation3<f64> {
    Rotation3::from_matrix_unchecked(Matrix3::new(0.0, -1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0))
}

#[test]
fn a_motion_its_inverse_and_its_matrix_by_hand() {
    let pose = Pose::new(cycle(), Point3::new(10.0, 20.0, 30.0));
    let (from, to) = (Point3::new(11.0, 22.0, 33.0), Point3::new(3.0, 1.0, 2.0));
    assert_eq!(pose.apply(&from), to);
    assert_eq!(pose.apply_inverse(&to), from);
    assert_eq!(pose.translation(), Vector3::new(-30.0, -10.0, -20.0));
    // Back: the origin of the first frame, seen in the second.
    assert_eq!(pose.inverse().origin, Point3::new(-30.0, -10.0, -20.0));
    assert_eq!(pose.inverse().apply(&to), from);
    assert_eq!(Pose::from_rotation_translation(cycle(), pose.translation()), pose);
    let matrix = pose.to_matrix();
    let rows = [[0., 0., 1., -30.], [1., 0., 0., -10.], [0., 1., 0., -20.], [0., 0., 0., 1.]];
    for (i, row) in rows.iter().enumerate() {
        for (j, value) in row.iter().enumerate() {
            assert_eq!(matrix[(i, j)], *value, "({i}, {j})");
        }
    }
    assert_eq!(Pose::identity().apply(&from), from);
}

#[test]
fn motions_compose_from_right_to_left() {
    let b_from_a = Pose::new(cycle(), Point3::new(1.0, 2.0, 3.0));
    let c_from_b = Pose::new(quarter(), Point3::new(10.0, 0.0, -5.0));
    // (2, 4, 6): less (1, 2, 3) is (1, 2, 3), cycled (3, 1, 2); less (10, 0, −5) is (−7, 1, 7), turned (−1, −7, 7).
    let p = Point3::new(2.0, 4.0, 6.0);
    let c_from_a = c_from_b.after(&b_from_a);
    assert_eq!(c_from_a.apply(&p), Point3::new(-1.0, -7.0, 7.0));
    // Its origin: what c_from_b sends to zero, (10, 0, −5), uncycled (0, −5, 10), plus (1, 2, 3).
    assert_eq!(c_from_a.origin, Point3::new(1.0, -3.0, 13.0));
}

#[test]
fn map_coordinates_keep_their_bits() {
    let origin = Point3::new(500_000.25, 5_400_000.5, 1200.75);
    let pose = Pose::new(quarter(), origin);
    let step = Vector3::new(1.0, 2.0, 3.0) / 1_048_576.0;
    assert_eq!(pose.apply(&(origin + step)).coords, quarter() * step);
}

fn pose() -> impl Strategy<Value = Pose> {
    (point(3.0), point(50.0)).prop_map(|(r, o)| Pose::new(Rotation3::from_scaled_axis(r.coords), o))
}

proptest! {
    #[test]
    fn motions_form_a_group(a in pose(), b in pose(), c in pose(), p in point(50.0)) {
        let close = |x: Point3<f64>, y: Point3<f64>| (x - y).norm() < 1e-11;
        prop_assert!(close(a.after(&b).apply(&p), a.apply(&b.apply(&p))));
        prop_assert!(close(a.after(&b).after(&c).apply(&p), a.after(&b.after(&c)).apply(&p)));
        prop_assert!(close(a.after(&a.inverse()).apply(&p), p));
        prop_assert!(close(a.inverse().after(&a).apply(&p), p));
        prop_assert!(close(a.inverse().apply(&p), a.apply_inverse(&p)));
        let h = a.to_matrix() * p.to_homogeneous();
        prop_assert!(close(Point3::new(h.x, h.y, h.z), a.apply(&p)) && h.w == 1.0);
        // Rigid: lengths stay, and so does the hand.
        prop_assert!(((a.apply(&p) - a.apply(&Point3::origin())).norm() - p.coords.norm()).abs() < 1e-11);
    }
}
