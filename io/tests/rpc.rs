//! Files of rational polynomial cameras: as GDAL writes them, as Airbus and OSSIM do, cut off and hostile.

use std::io::Cursor;
use std::path::{Path, PathBuf};

use collinear::camera::rpc::ImageCorrection;
use collinear::geometry::geodetic::{EllipsoidalHeight, Geodetic};
use collinear::nalgebra::{Matrix2, Point2, Vector2};
use collinear_io::Document;
use collinear_io::rpc::{
    RpcFile, parse, parse_geom, parse_rpb, parse_rpc_txt, parse_xml, read, read_geotiff,
};
use proptest::prelude::*;
use serde_json::Value;

use crate::shared_data;

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/oracles/rpc")
}

fn text_of(name: &str) -> String {
    std::fs::read_to_string(folder().join(name)).unwrap()
}

/// The model of the library's oracle, whose numbers are all different.
fn expected() -> RpcFile {
    let text = include_str!("../../tests/data/oracles/rpc.json");
    let mut model = serde_json::from_str::<Value>(text).unwrap()["model"].take();
    model["collinear"] = "rpc".into();
    model["version"] = 1.into();
    RpcFile::parse(&model.to_string()).unwrap()
}

#[test]
fn every_format_that_gdal_writes_gives_the_same_numbers() {
    let expected = expected();
    for name in ["little.tif", "big.tif", "little.RPB", "little_RPC.TXT", "picture.png.aux.xml"] {
        let file = read(&folder().join(name)).unwrap_or_else(|e| panic!("{e}"));
        assert_eq!(file, expected, "{name}");
    }
}

#[test]
fn what_is_written_is_read_to_the_same_bits() {
    let mut file = expected();
    // A number of 17 digits, and errors that are not known.
    file.latitude_offset_deg = 44.137_165_993_734_47;
    for unknown in [false, true] {
        if unknown {
            (file.error_bias, file.error_random) = (None, None);
        }
        assert_eq!(parse_rpc_txt(&file.to_rpc_txt().unwrap()).unwrap(), file);
        assert_eq!(parse_rpb(&file.to_rpb().unwrap()).unwrap(), file);
        assert_eq!(parse(file.to_json().unwrap().as_bytes()).unwrap(), file);
        let folder = tempfile::tempdir().unwrap();
        for name in ["a.txt", "b.RPB", "c.json"] {
            let path = folder.path().join(name);
            match name {
                "a.txt" => file.write_rpc_txt(&path).unwrap(),
                "b.RPB" => file.write_rpb(&path).unwrap(),
                _ => file.write(&path).unwrap(),
            }
            assert_eq!(read(&path).unwrap(), file, "{name}");
        }
    }
}

#[test]
fn a_correction_is_kept_by_json_alone() {
    let linear = Matrix2::new(1e-4, 2e-4, -3e-4, 4e-4);
    let correction =
        ImageCorrection::new(Point2::new(6000.0, 4000.0), Vector2::new(1.5, -2.5), linear).unwrap();
    let rpc = expected().rpc().unwrap().with_correction(correction);
    let file = RpcFile::from_rpc(&rpc);
    let again = RpcFile::parse(&file.to_json().unwrap()).unwrap();
    assert_eq!(again.rpc().unwrap(), rpc);
    assert_eq!(again.rpc().unwrap().correction(), correction);
    assert_eq!(
        file.to_rpb().unwrap_err().to_string(),
        "correction: is `a correction`: this format has no place for it, write JSON or fit the corrected model"
    );
    assert!(file.to_rpc_txt().is_err());
    assert!(RpcFile::from_rpc(&expected().rpc().unwrap()).correction.is_none());
    let mut flat = file;
    flat.correction.as_mut().unwrap().linear = [[-1.0, 0.0], [0.0, 0.0]];
    let error = flat.rpc().unwrap_err().to_string();
    assert!(error.starts_with("correction: image correction is degenerate"), "{error}");
}

#[test]
fn the_cameras_of_mont_ventoux_project_as_gdal_does() {
    let Some(data) = shared_data("terrain/ventoux") else { return };
    let answers: Value = serde_json::from_str(include_str!("oracles/rpc_ventoux.json")).unwrap();
    let answers = answers.as_object().unwrap();
    assert_eq!(answers.len(), 3);
    let mut worst = [0.0_f64; 2];
    for (name, points) in answers {
        let rpc = read(&data.join(name)).unwrap().rpc().unwrap();
        let points = points.as_array().unwrap();
        assert_eq!(points.len(), 50);
        for point in points {
            let of = |key: &str| point[key].as_f64().unwrap();
            let height = EllipsoidalHeight(of("height"));
            let place =
                Geodetic::from_degrees(of("latitude_deg"), of("longitude_deg"), height).unwrap();
            let p = rpc.project(&place).unwrap();
            let exact =
                rpc.project_degrees(of("latitude_deg"), of("longitude_deg"), height).unwrap();
            let [x, y] = [0, 1].map(|i| point["image"][i].as_f64().unwrap());
            worst[0] = worst[0].max((p.x - x).abs()).max((p.y - y).abs());
            worst[1] = worst[1].max((exact.x - x).abs()).max((exact.y - y).abs());
            let back = rpc.at_height(&p, height).unwrap();
            assert!((rpc.project(&back).unwrap() - p).norm() < 1e-9);
            assert!((back.latitude() - place.latitude()).abs() < 1e-14);
            assert!((back.longitude() - place.longitude()).abs() < 1e-14);
        }
    }
    // Through radians, and in degrees.
    assert!(worst[0] < 1e-9 && worst[1] < 3e-11, "{worst:?}");
}

#[test]
fn dimap_counts_its_first_pixel_from_one_and_ossim_does_not() {
    let Some(data) = shared_data("terrain/ventoux") else { return };
    let dimap = read(&data.join("RPC_PHR1B_P_201308051042194_SEN_690908101-001.XML")).unwrap();
    // OSSIM's list of the same product has 15 digits.
    let geom = read(&data.join("left_image.geom")).unwrap();
    assert!((dimap.line_offset - 21_109.5).abs() < 1e-8 && geom.line_offset == 21_109.5);
    assert!((dimap.sample_offset - 19_207.5).abs() < 1e-8 && geom.sample_offset == 19_207.5);
    for (a, b) in [
        (dimap.line_numerator, geom.line_numerator),
        (dimap.line_denominator, geom.line_denominator),
        (dimap.sample_numerator, geom.sample_numerator),
        (dimap.sample_denominator, geom.sample_denominator),
    ] {
        for (a, b) in a.iter().zip(b) {
            assert!((a - b).abs() <= 1e-14 * a.abs(), "{a} {b}");
        }
    }
}

/// A DIMAP of our own numbers, of either version.
fn dimap(model: &str, origin: Option<[&str; 2]>) -> String {
    let file = expected();
    let list = |name: &str, c: &[f64; 20], factor: f64| -> String {
        let one = |(i, v): (usize, &f64)| {
            format!("<{name}_COEFF_{0}>{1:?}</{name}_COEFF_{0}>", i + 1, v * factor)
        };
        c.iter().enumerate().map(one).collect()
    };
    let polynomials = |factor: f64| {
        list("LINE_NUM", &file.line_numerator, factor)
            + &list("LINE_DEN", &file.line_denominator, 1.0)
            + &list("SAMP_NUM", &file.sample_numerator, factor)
            + &list("SAMP_DEN", &file.sample_denominator, 1.0)
    };
    let other = if model == "Inverse_Model" { "Direct_Model" } else { "ImagetoGround_Values" };
    let origin = origin.map_or_else(String::new, |[row, column]| {
        format!(
            "<ImagetoGround_Validity_Domain><FIRST_ROW>{row}</FIRST_ROW><FIRST_COL>{column}</FIRST_COL></ImagetoGround_Validity_Domain>"
        )
    });
    format!(
        "<?xml version=\"1.0\"?>\n<Dimap_Document><Rational_Function_Model>\n<Resource_Reference><RESOURCE_ID>RPC00B</RESOURCE_ID></Resource_Reference>\n\
         <Global_RFM><{other}>{}</{other}>\n<{model}>{}</{model}><RFM_Validity>{origin}\
         <LINE_OFF>{:?}</LINE_OFF><SAMP_OFF>{:?}</SAMP_OFF><LAT_OFF>44.137</LAT_OFF><LONG_OFF>5.285</LONG_OFF><HEIGHT_OFF>1075</HEIGHT_OFF>\
         <LINE_SCALE>4250.5</LINE_SCALE><SAMP_SCALE>6199.5</SAMP_SCALE><LAT_SCALE>0.0989</LAT_SCALE><LONG_SCALE>0.1287</LONG_SCALE><HEIGHT_SCALE>885</HEIGHT_SCALE>\
         </RFM_Validity></Global_RFM></Rational_Function_Model></Dimap_Document>",
        polynomials(-3.0),
        polynomials(1.0),
        file.line_offset,
        file.sample_offset,
    )
}

#[test]
fn dimap_gives_its_model_from_the_ground_to_the_image() {
    let mut expected = expected();
    (expected.error_bias, expected.error_random) = (None, None);
    let (line, sample) = (expected.line_offset, expected.sample_offset);
    for (model, origin, row, column) in [
        ("Inverse_Model", None, 1.0, 1.0),
        ("GroundtoImage_Values", Some(["0", "0"]), 0.0, 0.0),
        ("GroundtoImage_Values", Some(["1", "1"]), 1.0, 1.0),
        ("GroundtoImage_Values", Some(["1", "0"]), 1.0, 0.0),
    ] {
        let file = parse_xml(&dimap(model, origin)).unwrap();
        (expected.line_offset, expected.sample_offset) = (line - row, sample - column);
        assert_eq!(file, expected, "{model} {origin:?}");
    }
    let error = |text: &str| parse_xml(text).unwrap_err().to_string();
    assert_eq!(
        error(&dimap("GroundtoImage_Values", Some(["0", "-791"]))),
        "line 5: FIRST_COL is `-791`, expected 0 or 1"
    );
    let v2 = dimap("Inverse_Model", None);
    assert_eq!(
        error(&v2.replace("RPC00B", "RPC00X")),
        "line 3: RESOURCE_ID is `RPC00X`, expected RPC00B"
    );
    assert_eq!(error(&v2.replace("RFM_Validity", "Other")), "has no RFM_Validity");
    assert_eq!(
        error(&v2.replace("Inverse_Model", "Other")),
        "has no Inverse_Model or GroundtoImage_Values"
    );
    assert!(error(&v2[..500]).starts_with("is no well-formed XML: "));
    assert!(error("<a/>").starts_with("holds no rational polynomial camera"));
}

#[test]
fn the_older_order_of_terms_is_brought_to_the_newer() {
    // 1, L, P, H, LP, LH, PH, LPH, L², P², H², L³, L²P, L²H, LP², P³, P²H, LH², PH², H³ against
    // 1, L, P, H, LP, LH, PH, L², P², H², PLH, L³, LP², LH², L²P, P³, PH², L²H, P²H, H³, each counted from 1.
    let newer =
        [1, 2, 3, 4, 5, 6, 7, 9, 10, 11, 8, 12, 15, 18, 13, 16, 19, 14, 17, 20].map(f64::from);
    let mut file = expected();
    file.sample_numerator = core::array::from_fn(|i| (i + 1) as f64);
    let rpb = file.to_rpb().unwrap();
    assert_eq!(parse_rpb(&rpb).unwrap(), file);
    let older = parse_rpb(&rpb.replace("RPC00B", "RPC00A")).unwrap();
    assert_eq!(older.sample_numerator, newer);

    let mut geom = String::from("polynomial_format:  B\n");
    for line in file.to_rpc_txt().unwrap().lines() {
        let (name, value) = line.split_once(':').unwrap();
        let (name, number) = (name.to_lowercase(), value.split_whitespace().next().unwrap());
        let name = match name.as_str() {
            "err_bias" => "bias_error".to_owned(),
            "err_rand" => "rand_error".to_owned(),
            _ => match name.split_once("_coeff_") {
                Some((p, i)) => format!("{p}_coeff_{:02}", i.parse::<usize>().unwrap() - 1),
                None => name,
            },
        };
        geom.push_str(&format!("{name}:  {number}\n"));
    }
    assert_eq!(parse_geom(&geom).unwrap(), file);
    assert_eq!(parse(geom.as_bytes()).unwrap(), file);
    let older = parse_geom(&geom.replace(":  B", ":  A")).unwrap();
    assert_eq!(older.sample_numerator, newer);
    let error = parse_geom(&geom.replace(":  B", ":  C")).unwrap_err().to_string();
    assert_eq!(error, "line 1: polynomial_format is `C`, expected A or B");
    let error = parse_rpb(&rpb.replace("RPC00B", "RPC01")).unwrap_err().to_string();
    assert_eq!(error, "line 1: SpecId is `RPC01`, expected RPC00A or RPC00B");
}

#[test]
fn an_error_names_the_line_and_the_field() {
    let txt = text_of("little_RPC.TXT");
    let of = |text: &str| parse_rpc_txt(text).unwrap_err().to_string();
    let without = |name: &str| {
        txt.lines().filter(|l| !l.starts_with(&format!("{name}:"))).collect::<Vec<_>>().join("\n")
    };
    assert_eq!(of(&without("LAT_SCALE")), "has no LAT_SCALE");
    assert_eq!(of(&without("SAMP_DEN_COEFF_20")), "has no SAMP_DEN_COEFF_20");
    assert_eq!(of(&without("LINE_NUM_COEFF_3")), "has no LINE_NUM_COEFF_03");
    // The errors may be missing.
    assert_eq!(parse_rpc_txt(&without("ERR_BIAS")).unwrap().error_bias, None);
    assert_eq!(
        of(&txt.replace("4213.25", "4213,25")),
        "line 3: LINE_OFF is `4213,25`, expected a finite number"
    );
    assert_eq!(
        of(&txt.replace("4213.25", "inf")),
        "line 3: LINE_OFF is `inf`, expected a finite number"
    );
    assert_eq!(of(&format!("{txt}LINE_OFF: 1\n")), "line 93: LINE_OFF stands there a second time");
    assert_eq!(
        of(&txt.replace("1075.0", "1075.0 feet")),
        "line 7: the unit of HEIGHT_OFF is `feet`, expected meters"
    );
    assert_eq!(
        of(&format!("{txt}LINE_NUM_COEFF_21: 1\n")),
        "line 93: LINE_NUM_COEFF is `21`, expected twenty coefficients, counted as the format does"
    );
    assert!(of(&format!("{txt}LINE_NUM_COEFF_0: 1\n")).contains("is `0`"));
    // Ikonos writes signs, zeros and units.
    let ikonos = txt.replace("4213.25", "+004213.25 pixels").replace("885.0", "+0885.000 meters");
    assert_eq!(parse_rpc_txt(&ikonos).unwrap(), expected());
    // The library's own reasons.
    assert_eq!(
        of(&txt.replace("4250.5", "0")),
        "line scale is 0, expected from 10⁻³ to 10⁹ pixels"
    );
    assert!(of("nothing").starts_with("holds no rational polynomial camera: RPB, "));

    let rpb = text_of("little.RPB");
    let of = |text: &str| parse_rpb(text).unwrap_err().to_string();
    assert_eq!(
        of(&rpb.replace("0.0013,\n", "")),
        "line 17: lineNumCoef has 19 coefficients, expected 20"
    );
    assert_eq!(
        of(&rpb.replace("0.0013", "x")),
        "line 17: lineNumCoef is `x`, expected a finite number"
    );
    assert_eq!(
        of(&rpb[..700]),
        "line 17: `lineNumCoef = (` is no statement: expected name = value;"
    );
    assert_eq!(
        of(&rpb.replace("lineNumCoef = (", "lineNumCoef = ")),
        "line 17: `lineNumCoef =` is no statement: expected name = value;"
    );
    assert_eq!(
        of(&format!("{rpb}rubbish\n")),
        "line 103: `rubbish` is no statement: expected name = value;"
    );
    let path = folder().join("none.RPB");
    let error = read(&path).unwrap_err();
    assert_eq!(error.path(), Some(path.as_path()));
}

#[test]
fn an_unknown_file_says_what_is_read() {
    for bytes in [&b""[..], b"hello", b"\xef\xbb\xbf", b"PK\x03\x04"] {
        let error = parse(bytes).unwrap_err().to_string();
        assert!(error.starts_with("holds no rational polynomial camera"), "{error}");
    }
    assert!(parse(b"\xff\xfe").unwrap_err().to_string().starts_with("is not UTF-8"));
    assert!(parse(b"{}").unwrap_err().to_string().starts_with("is not a collinear rpc file"));
    // A mark of the byte order before any of them.
    let txt = format!("\u{feff}{}", text_of("little_RPC.TXT"));
    assert_eq!(parse(txt.as_bytes()).unwrap(), expected());
}

/// Neither says how long it is.
#[cfg(target_os = "linux")]
#[test]
fn a_pipe_is_read_and_a_device_without_end_is_refused() {
    use std::io::Write;
    use std::os::fd::AsRawFd;

    let error = read(Path::new("/dev/zero")).unwrap_err().to_string();
    assert!(error.contains("16777217 bytes"), "{error}");
    let (pipe, mut into) = std::io::pipe().unwrap();
    into.write_all(text_of("little.RPB").as_bytes()).unwrap();
    drop(into);
    let path = format!("/dev/fd/{}", pipe.as_raw_fd());
    assert_eq!(read(Path::new(&path)).unwrap(), expected());
}

#[test]
fn tiff_files_that_are_cut_off_or_wrong_are_refused_with_numbers() {
    for name in ["little.tif", "big.tif"] {
        let bytes = std::fs::read(folder().join(name)).unwrap();
        let of = |bytes: &[u8]| read_geotiff(&mut Cursor::new(bytes)).unwrap_err().to_string();
        assert_eq!(read_geotiff(&mut Cursor::new(&bytes)).unwrap(), expected());
        // Where the file stops within what is read.
        for n in 0..bytes.len() {
            match read_geotiff(&mut Cursor::new(&bytes[..n])) {
                Ok(file) => assert_eq!(file, expected()),
                Err(e) => assert!(e.to_string().contains("is cut off"), "{n}: {e}"),
            }
        }
        // The tag under another number, of another type, with another count.
        let little = name == "little.tif";
        let tag = if little { 50844u16.to_le_bytes() } else { 50844u16.to_be_bytes() };
        let at = bytes.windows(2).position(|w| w == tag).unwrap();
        let with = |offset: usize, value: u8| {
            let mut b = bytes.clone();
            b[at + offset] = value;
            of(&b)
        };
        assert_eq!(
            with(if little { 0 } else { 1 }, 0),
            "is a TIFF file whose number of cameras (tag 50844) is 0, expected one"
        );
        assert_eq!(
            with(if little { 2 } else { 3 }, 11),
            "is a TIFF file whose type of tag 50844 is 11, expected 12, doubles"
        );
        assert_eq!(
            with(if little { 4 } else { 11 }, 91),
            "is a TIFF file whose number of values of tag 50844 is 91, expected 92"
        );
    }
    // A directory of a million million tags, and one at the end of all numbers.
    let mut big = b"MM\0\x2b\0\x08\0\0".to_vec();
    big.extend(16u64.to_be_bytes());
    big.extend(1_000_000_000_000u64.to_be_bytes());
    let error = read_geotiff(&mut Cursor::new(&big)).unwrap_err().to_string();
    assert_eq!(
        error,
        "is a TIFF file whose number of tags is 1000000000000, expected 4096 at most"
    );
    big[8..16].copy_from_slice(&u64::MAX.to_be_bytes());
    let error = read_geotiff(&mut Cursor::new(&big)).unwrap_err().to_string();
    assert!(error.contains("its directory at byte 18446744073709551615 is not there"), "{error}");
    big[5] = 4;
    let error = read_geotiff(&mut Cursor::new(&big)).unwrap_err().to_string();
    assert_eq!(error, "is a TIFF file whose size of offsets is 4, expected 8");
}

#[test]
fn hostile_xml_is_refused() {
    // An entity that names itself many times over, a million open elements, a million of them side by side.
    let laughs = "<!DOCTYPE a [<!ENTITY b \"ha\"><!ENTITY c \"&b;&b;\">]><a>&c;</a>";
    assert!(parse_xml(laughs).unwrap_err().to_string().starts_with("is no well-formed XML"));
    let deep = "<a>".repeat(1_000_000);
    assert!(parse_xml(&deep).unwrap_err().to_string().starts_with("is no well-formed XML"));
    let wide = format!("<a>{}</a>", "<b/>".repeat(1_100_000));
    assert!(parse_xml(&wide).unwrap_err().to_string().starts_with("is no well-formed XML"));
}

proptest! {
    #[test]
    fn bytes_that_no_writer_wrote_are_an_error_or_a_camera(
        which in 0..4usize, at in 0.0..1.0f64, replaced in prop::collection::vec(any::<u8>(), 0..12), cut in 0.0..1.0f64,
    ) {
        let name = ["little.tif", "little.RPB", "little_RPC.TXT", "picture.png.aux.xml"][which];
        let mut bytes = std::fs::read(folder().join(name)).unwrap();
        let from = (at * bytes.len() as f64) as usize;
        let to = (from + replaced.len()).min(bytes.len());
        bytes.splice(from..to, replaced);
        bytes.truncate((cut * 2.0 * bytes.len() as f64) as usize);
        let found = if which == 0 { read_geotiff(&mut Cursor::new(&bytes)) } else { parse(&bytes) };
        if let Ok(file) = found {
            prop_assert!(file.rpc().is_ok());
        }
    }
}
