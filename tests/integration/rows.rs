//! Rows of texture coordinates: which pixels share an origin, and where a row ends.

use collinear::mapping::{Map, RowCoords};
use collinear::nalgebra::{Matrix2, Point2};
use collinear::{ProjectionError, geometry::Affine2};

/// (pixels, origin, u, v) of a run, u and v with their origins.
type Read = (std::ops::Range<i32>, [i32; 2], Vec<f64>, Vec<f64>);

fn read(row: &RowCoords) -> Vec<Read> {
    let whole = |offsets: &[f32], origin: i32| {
        offsets.iter().map(|&o| f64::from(origin) + f64::from(o)).collect::<Vec<_>>()
    };
    row.runs()
        .iter()
        .map(|run| {
            let (u, v) = row.offsets(run);
            assert_eq!(run.len(), u.len());
            (run.pixels(), run.origin, whole(u, run.origin[0]), whole(v, run.origin[1]))
        })
        .collect()
}

#[test]
fn a_gap_or_another_origin_starts_another_run() {
    // Origins are multiples of 128, each for the 128 texels about it: 63 belongs to 0 and 64 to 128.
    let pushed = |pixels: &[(i32, f64, f64)]| {
        let mut row = RowCoords::new();
        for &(x, u, v) in pixels {
            row.push(x, u, v);
        }
        read(&row)
    };
    let one = pushed(&[(3, 61.5, 8.25), (4, 62.5, 9.25), (5, 63.75, 10.25)]);
    assert_eq!(one, [(3..6, [0, 0], vec![61.5, 62.5, 63.75], vec![8.25, 9.25, 10.25])]);
    let gap = pushed(&[(3, 61.5, 8.25), (5, 62.5, 9.25)]);
    assert_eq!(gap.iter().map(|r| r.0.clone()).collect::<Vec<_>>(), [3..4, 5..6]);
    // Only u, then only v, leaves its origin; below zero the origins go on.
    for (a, b, origins) in [
        ((63.5, 8.0), (64.5, 8.0), [[0, 0], [128, 0]]),
        ((8.0, 63.5), (8.0, 64.5), [[0, 0], [0, 128]]),
        ((8.0, -65.5), (8.0, -63.5), [[0, -128], [0, 0]]),
        ((65_000.25, 200.0), (65_000.5, 180.0), [[65_024, 256], [65_024, 128]]),
    ] {
        let runs = pushed(&[(0, a.0, a.1), (1, b.0, b.1)]);
        assert_eq!(runs.iter().map(|r| r.1).collect::<Vec<_>>(), origins, "{a:?} {b:?}");
        assert_eq!((&runs[0].2[..], &runs[0].3[..]), (&[a.0][..], &[a.1][..]));
        assert_eq!((&runs[1].2[..], &runs[1].3[..]), (&[b.0][..], &[b.1][..]));
    }
}

#[test]
fn blocks_are_their_pixels_pushed_one_by_one() {
    let limit = RowCoords::COORDINATE_LIMIT;
    let blocks: [(&[f64], &[f64]); 7] = [
        (&[60.0, 61.0, 62.0], &[1.0, 1.5, 2.0]),
        (&[60.0, 62.0, 66.0], &[1.0, 1.5, 2.0]),
        (&[1.0, 1.5, 2.0], &[62.0, 63.5, 65.0]),
        (&[1.0, f64::NAN, 2.0], &[1.0, 1.5, 2.0]),
        (&[1.0, 1.5, 2.0], &[1.0, 2.0 * limit, 2.0]),
        (&[limit, -limit, limit], &[-limit, limit, limit]),
        (&[], &[]),
    ];
    for first in blocks {
        for second in blocks {
            // The second block follows at once, or after a gap.
            for gap in [0, 1, 5] {
                let (mut whole, mut single) = (RowCoords::new(), RowCoords::new());
                for (start, (u, v)) in [(-2, first), (1 + gap, second)] {
                    whole.push_block(start, u, v);
                    for (i, (&u, &v)) in u.iter().zip(v).enumerate() {
                        single.push(start + i as i32, u, v);
                    }
                }
                assert_eq!(read(&whole), read(&single), "{first:?} {second:?} {gap}");
            }
        }
    }
    let mut row = RowCoords::new();
    row.push_block(-2, blocks[0].0, blocks[0].1);
    row.push_block(10, blocks[0].0, blocks[0].1);
    assert_eq!(read(&row).into_iter().map(|r| r.0).collect::<Vec<_>>(), [-2..1, 10..13]);
}

#[test]
fn a_coordinate_may_reach_the_limit_and_not_pass_it() {
    let limit = 1_073_741_824.0;
    let next = 1_073_741_824.000_000_2;
    for (u, v, kept) in [
        (limit, 0.0, true),
        (-limit, limit, true),
        (0.0, -limit, true),
        (next, 0.0, false),
        (0.0, next, false),
        (-next, 0.0, false),
        (f64::NAN, 0.0, false),
        (0.0, f64::NAN, false),
    ] {
        let mut row = RowCoords::new();
        row.push(0, u, v);
        assert_eq!(read(&row).len(), usize::from(kept), "{u} {v}");
        if kept {
            assert_eq!((read(&row)[0].2[0], read(&row)[0].3[0]), (u, v));
        }
    }
}

/// u = S², v = 10 L, and nothing in column 2.
#[derive(Debug)]
struct Squares;

impl Map for Squares {
    fn at(&self, p: &Point2<f64>) -> Result<Point2<f64>, ProjectionError> {
        if p.x.floor() == 2.0 {
            return Err(ProjectionError::MissesSurface);
        }
        Ok(Point2::new(p.x * p.x, 10.0 * p.y))
    }

    fn jacobian(&self, p: &Point2<f64>) -> Result<Matrix2<f64>, ProjectionError> {
        Ok(Matrix2::new(2.0 * p.x, 0.0, 0.0, 10.0))
    }
}

#[test]
fn a_row_is_asked_at_the_centres_of_its_pixels() {
    let mut row = RowCoords::new();
    row.push(77, 1.0, 1.0);
    Squares.row(3, 0..5, &mut row);
    let expected = [
        (0..2, [0, 0], vec![0.25, 2.25], vec![35.0; 2]),
        (3..5, [0, 0], vec![12.25, 20.25], vec![35.0; 2]),
    ];
    assert_eq!(read(&row), expected);
    Squares.row(-4, 5..5, &mut row);
    assert!(row.runs().is_empty());
}

#[test]
fn an_affine_map_that_overflows_has_no_value() {
    let wide = Affine2::from_coefficients([0.0, 1e200, 0.0], [0.0, 0.0, 1.0]);
    let high = Affine2::from_coefficients([0.0, 1.0, 0.0], [0.0, 0.0, 1e200]);
    let p = Point2::new(1e150, 1e150);
    for map in [wide, high] {
        assert_eq!(map.at(&p), Err(ProjectionError::NotFinite));
        assert_eq!(map.jacobian(&p), Err(ProjectionError::NotFinite));
        assert!(map.at(&Point2::new(1.0, 1.0)).is_ok());
    }
}
