//! Geoid grids.

use collinear::geometry::geodetic::{GeoidInterpolation, GeoidLayout};
use collinear_io::gtx::{parse_gtx, read_gtx};

fn bytes(header: [f64; 4], rows: i32, columns: i32, heights: &[f32]) -> Vec<u8> {
    let mut bytes = Vec::new();
    header.iter().for_each(|v| bytes.extend(v.to_be_bytes()));
    [rows, columns].iter().for_each(|v| bytes.extend(v.to_be_bytes()));
    heights.iter().for_each(|v| bytes.extend(v.to_be_bytes()));
    bytes
}

#[test]
fn rows_go_from_the_south_and_columns_from_the_west() {
    let heights = [1.0, 2.0, 3.0, 4.0, -88.8888, -2_147_479_936.0];
    let file = parse_gtx(&bytes([40.0, -10.0, 0.5, 0.25], 2, 3, &heights)).unwrap();
    assert_eq!(
        file.layout,
        GeoidLayout {
            south_deg: 40.0,
            west_deg: -10.0,
            latitude_step_deg: 0.5,
            longitude_step_deg: 0.25,
            rows: 2,
            columns: 3,
        }
    );
    assert_eq!(file.undulations_m[..4], heights[..4]);
    assert!(file.undulations_m[4..].iter().all(|v| v.is_nan()));
    let grid = file.geoid_grid().unwrap().with_interpolation(GeoidInterpolation::Bilinear);
    let at = |latitude: f64, longitude: f64| {
        grid.undulation(latitude.to_radians(), longitude.to_radians())
    };
    assert!((at(40.0, -9.5).unwrap() - 3.0).abs() < 1e-6);
    assert!((at(40.5, -10.0).unwrap() - 4.0).abs() < 1e-6);
    assert!(at(40.5, -9.5).is_err());
}

#[test]
fn a_header_that_makes_no_sense_is_refused_with_its_number() {
    let good = [40.0, -10.0, 0.5, 0.25];
    let with = |i: usize, v: f64| {
        let mut header = good;
        header[i] = v;
        parse_gtx(&bytes(header, 2, 2, &[0.0; 4])).unwrap_err().to_string()
    };
    assert_eq!(
        with(0, 91.0),
        "the south latitude is 91, expected −90 … 90 degrees: this is no GTX file"
    );
    assert_eq!(
        with(1, f64::NAN),
        "the west longitude is NaN, expected −360 … 360 degrees: this is no GTX file"
    );
    assert_eq!(
        with(2, 0.0),
        "the latitude step is 0, expected above 0 and up to 90 degrees: this is no GTX file"
    );
    assert_eq!(
        with(3, -0.25),
        "the longitude step is -0.25, expected above 0 and up to 90 degrees: this is no GTX file"
    );
    assert_eq!(
        with(0, 89.9),
        "the north latitude is 90.4, expected up to 90 degrees: this is no GTX file"
    );
    let sized =
        |rows, columns| parse_gtx(&bytes(good, rows, columns, &[0.0; 4])).unwrap_err().to_string();
    assert_eq!(sized(1, 4), "the number of rows is 1, expected at least 2: this is no GTX file");
    assert_eq!(
        sized(2, -2),
        "the number of columns is -2, expected at least 2: this is no GTX file"
    );
    assert_eq!(sized(3, 2), "is 56 bytes long, a grid of 3 rows and 2 columns needs 64");
    assert_eq!(
        parse_gtx(&[0; 39]).unwrap_err().to_string(),
        "is 39 bytes long, the header alone has 40"
    );
    let tiny = [-90.0, -180.0, 1e-12, 1e-12];
    let huge = parse_gtx(&bytes(tiny, i32::MAX, i32::MAX, &[0.0; 4])).unwrap_err().to_string();
    assert_eq!(
        huge,
        "is 56 bytes long, a grid of 2147483647 rows and 2147483647 columns needs 18446744056529682476"
    );
}

#[test]
fn egm96_has_the_heights_that_its_agency_printed() {
    let Some(path) = crate::shared_data("terrain/egm96_15.gtx") else { return };
    let file = read_gtx(&path).unwrap();
    assert_eq!((file.layout.rows, file.layout.columns), (721, 1440));
    let grid = file.geoid_grid().unwrap();
    // NGA's OUTINTPT.DAT for EGM96, by splines on the same grid of 15′: bicubic interpolation stays within 0.01 m.
    for (latitude, longitude, height) in [
        (38.6281550, 269.7791550, -31.628),
        (-14.6212170, 305.0211140, -2.969),
        (46.8743190, 102.4487290, -43.575),
        (-23.6174460, 133.8747120, 15.871),
        (38.6254730, 359.9995000, 50.066),
        (-0.4667440, 0.0023000, 17.329),
    ] {
        let got = grid.undulation(f64::to_radians(latitude), f64::to_radians(longitude)).unwrap();
        assert!((got - height).abs() < 0.01, "{latitude} {longitude}: {got}, printed {height}");
    }
}
