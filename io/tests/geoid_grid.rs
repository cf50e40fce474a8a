//! Geoid grids.

use collinear_io::geoid_grid::{GeoidGrid, parse_geoid_grid, read_geoid_grid};

fn bytes(header: [f64; 4], rows: i32, columns: i32, heights: &[f32]) -> Vec<u8> {
    let mut bytes = Vec::new();
    header.iter().for_each(|v| bytes.extend(v.to_be_bytes()));
    [rows, columns].iter().for_each(|v| bytes.extend(v.to_be_bytes()));
    heights.iter().for_each(|v| bytes.extend(v.to_be_bytes()));
    bytes
}

#[test]
fn rows_go_from_the_south_and_columns_from_the_west() {
    let grid = parse_geoid_grid(&bytes(
        [40.0, -10.0, 0.5, 0.25],
        2,
        3,
        &[1.0, 2.0, 3.0, 4.0, -88.8888, -2_147_479_936.0],
    ))
    .unwrap();
    assert_eq!(
        (grid.south_deg, grid.west_deg, grid.latitude_step_deg, grid.longitude_step_deg),
        (40.0, -10.0, 0.5, 0.25)
    );
    assert_eq!((grid.rows, grid.columns), (2, 3));
    assert_eq!((grid.height_m(0, 2), grid.height_m(1, 0)), (Some(3.0), Some(4.0)));
    assert_eq!((grid.height_m(1, 1), grid.height_m(1, 2)), (None, None));
    assert_eq!(
        (grid.height_m(0, 3), grid.height_m(2, 0), grid.height_m(usize::MAX, 1)),
        (None, None, None)
    );
}

#[test]
fn a_header_that_makes_no_sense_is_refused_with_its_number() {
    let good = [40.0, -10.0, 0.5, 0.25];
    let with = |i: usize, v: f64| {
        let mut header = good;
        header[i] = v;
        parse_geoid_grid(&bytes(header, 2, 2, &[0.0; 4])).unwrap_err().to_string()
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
    let sized = |rows, columns| {
        parse_geoid_grid(&bytes(good, rows, columns, &[0.0; 4])).unwrap_err().to_string()
    };
    assert_eq!(sized(1, 4), "the number of rows is 1, expected at least 2: this is no GTX file");
    assert_eq!(
        sized(2, -2),
        "the number of columns is -2, expected at least 2: this is no GTX file"
    );
    assert_eq!(sized(3, 2), "is 56 bytes long, a grid of 3 rows and 2 columns needs 64");
    assert_eq!(
        parse_geoid_grid(&[0; 39]).unwrap_err().to_string(),
        "is 39 bytes long, the header alone has 40"
    );
    let tiny = [-90.0, -180.0, 1e-12, 1e-12];
    let huge =
        parse_geoid_grid(&bytes(tiny, i32::MAX, i32::MAX, &[0.0; 4])).unwrap_err().to_string();
    assert_eq!(
        huge,
        "is 56 bytes long, a grid of 2147483647 rows and 2147483647 columns needs 18446744056529682476"
    );
}

/// Bilinear between the four nodes around a point.
fn interpolated(grid: &GeoidGrid, latitude: f64, longitude: f64) -> f64 {
    let y = (latitude - grid.south_deg) / grid.latitude_step_deg;
    let x = (longitude - grid.west_deg).rem_euclid(360.0) / grid.longitude_step_deg;
    let (row, column) = (y.floor() as usize, x.floor() as usize);
    let (fy, fx) = (y.fract(), x.fract());
    let at = |r, c: usize| f64::from(grid.height_m(r, c % grid.columns).unwrap());
    (1.0 - fy) * ((1.0 - fx) * at(row, column) + fx * at(row, column + 1))
        + fy * ((1.0 - fx) * at(row + 1, column) + fx * at(row + 1, column + 1))
}

#[test]
fn egm96_has_the_heights_that_its_agency_printed() {
    let Some(path) = crate::shared_data("terrain/egm96_15.gtx") else { return };
    let grid = read_geoid_grid(&path).unwrap();
    assert_eq!(
        (grid.rows, grid.columns, grid.south_deg, grid.west_deg),
        (721, 1440, -90.0, -180.0)
    );
    // NGA's OUTINTPT.DAT for EGM96, by splines on the same grid of 15′: bilinear interpolation stays within 0.06 m.
    for (latitude, longitude, height) in [
        (38.6281550, 269.7791550, -31.628),
        (-14.6212170, 305.0211140, -2.969),
        (46.8743190, 102.4487290, -43.575),
        (-23.6174460, 133.8747120, 15.871),
        (38.6254730, 359.9995000, 50.066),
        (-0.4667440, 0.0023000, 17.329),
    ] {
        let got = interpolated(&grid, latitude, longitude);
        assert!((got - height).abs() < 0.06, "{latitude} {longitude}: {got}, printed {height}");
    }
}
