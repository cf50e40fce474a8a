//! Agisoft Metashape's XML, read and written, beside the equations of its manual.

use std::fs;
use std::path::{Path, PathBuf};

use collinear::nalgebra::{Point2, Point3};
use collinear_io::camera::CameraFile;
use collinear_io::{Document, metashape, photographs};
use serde_json::Value;

fn oracle(name: &str) -> PathBuf {
    Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/tests/oracles/metashape")).join(name)
}

/// Every photograph images the points where `tests/oracles/metashape.py` (mpmath, the manual's equations) says.
fn images_as_the_manual_says(file: &str, photographs: &[(String, CameraFile)], tolerance: f64) {
    let expected: Value =
        serde_json::from_str(&fs::read_to_string(oracle("expected.json")).unwrap()).unwrap();
    let expected = &expected[file];
    assert_eq!(photographs.len(), expected["images"].as_object().unwrap().len());
    for (name, camera) in photographs {
        let camera = camera.camera().unwrap();
        let images = expected["images"][name].as_array().unwrap();
        for (world, image) in expected["world"].as_array().unwrap().iter().zip(images) {
            let world: [f64; 3] = serde_json::from_value(world.clone()).unwrap();
            let image: [f64; 2] = serde_json::from_value(image.clone()).unwrap();
            let found = camera.sensor().project(&Point3::from(world)).unwrap();
            let off = (found - Point2::from(image)).norm();
            assert!(off < tolerance, "{file}, {name}: {found} {image:?}");
        }
    }
}

/// The component's transform before the chunk's; geocentric coordinates have half a nanometre.
#[test]
fn exported_cameras_image_as_the_manual_says() {
    for (file, tolerance) in
        [("cameras.xml", 1e-6), ("chunk.xml", 1e-9), ("local.xml", 1e-9), ("calibration.xml", 1e-9)]
    {
        let read = photographs::read(&oracle(file), None).unwrap();
        images_as_the_manual_says(file, &read, tolerance);
    }
    let read = photographs::read(&oracle("local.xml"), None).unwrap();
    let models: Vec<_> = read.iter().map(|(n, c)| (n.as_str(), c.interior.model())).collect();
    // The plainest model that is the same camera, so that other programs may have it too.
    assert_eq!(
        models,
        [
            ("frame.jpg", "brown"),
            ("four.jpg", "metashape"),
            ("eight.jpg", "metashape"),
            ("pinhole.jpg", "pinhole"),
            ("fisheye.jpg", "fisheye"),
            ("decentred.jpg", "thin_prism_fisheye"),
            ("spherical.jpg", "equirectangular"),
            ("cut.jpg", "equirectangular"),
            ("cylindrical.jpg", "cylindrical"),
        ]
    );
}

/// What is written is read as the same cameras; `metashape.py --read` of the file prints the same images. Metashape's
/// cylinder is a full turn wide whatever its height.
#[test]
fn exported_cameras_are_written() {
    let read = photographs::read(&oracle("local.xml"), None).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("cameras.xml");
    metashape::write(&read, &path).unwrap();
    images_as_the_manual_says("local.xml", &metashape::read(&path).unwrap(), 1e-9);
    let text = fs::read_to_string(&path).unwrap();
    assert!(text.contains("<p1>-0.0031</p1><p2>0.0012</p2>"), "{text}");
    assert!(text.contains("type=\"fisheye\" class=\"adjusted\""), "{text}");
    assert!(text.contains("type=\"spherical\"") && text.contains("type=\"cylindrical\""), "{text}");
    // Two photographs of one camera share a sensor, and a label is text.
    let twice: Vec<_> =
        ["a & b.jpg", "<\"c\">\u{1}.jpg"].map(|n| (n.to_owned(), read[0].1.clone())).into();
    let text = metashape::to_text(&twice).unwrap();
    assert_eq!(text.matches("<sensor ").count(), 1);
    let names: Vec<_> = metashape::parse(&text).unwrap().into_iter().map(|(n, _)| n).collect();
    assert_eq!(names, ["a & b.jpg", "<\"c\"> .jpg"]);
}

/// The camera of the real export that geograypher's tests print, in geocentric metres where its own GPS says (39.4119…°,
/// −120.4179…°, 2420.109 m), looking down with the top of its picture to the south (yaw 179.9°, pitch 0.1°, roll 0°).
#[test]
fn a_real_export_lands_where_its_gps_says() {
    let text = r#"<document version="2.0.0"><chunk label="Chunk 1" enabled="true"><sensors next_id="1">
      <sensor id="0" label="M3M (12.29mm)" type="frame"><resolution width="5280" height="3956"/>
        <calibration type="frame" class="adjusted"><resolution width="5280" height="3956"/>
          <f>3705.4728792737214</f><cx>11.6738523909</cx><cy>-27.7497969199</cy><b1>0.5262024073</b1>
          <b2>-0.3058334293</b2><k1>-0.0919367147</k1><k2>-0.0762807468</k2><k3>0.1162639394</k3>
          <k4>-0.0761413904</k4><p1>-0.0003134847</p1><p2>0.0001164035</p2></calibration></sensor></sensors>
      <components next_id="1" active_id="0"><component id="0" label="Component 1"><transform>
          <rotation locked="true">0.8710699454 0.3070967021 -0.3833128821 -0.4909742007 0.5658364395 -0.6623997719 0.0134716110 0.7651932691 0.6436596744</rotation>
          <translation locked="true">-2499366.429888 -4256836.520906 4029217.965003</translation>
          <scale locked="true">12.354192447331316</scale></transform></component></components>
      <cameras next_id="816" next_group_id="2"><group id="0" label="Group 1" type="folder">
        <camera id="0" sensor_id="0" component_id="0" label="1.JPG">
          <transform>-0.99988146 -0.00872749 0.01268391 7.04224697 -0.00842932 0.99969124 0.02337453 7.05403071 -0.01288400 0.02326485 -0.99964631 0.43561421 0 0 0 1</transform>
          <orientation>1</orientation>
          <reference x="-120.417985477" y="39.411917469999999" z="2420.1089999999999" enabled="true"/>
        </camera></group></cameras></chunk></document>"#;
    let (_, camera) = photographs::parse(text, None).unwrap().remove(0);
    // pyproj 3.7.2, EPSG:4979 to 4978: of the GPS, and of places 100 m lower, there and 0.0002° to the south and to the east.
    let gps = Point3::new(-2499265.911398521, -4256833.504440709, 4029289.30489499);
    let center = Point3::from(camera.exterior.projection_center);
    assert!((center - gps).norm() < 0.05, "{center}");
    let camera = camera.camera().unwrap();
    let image = |p: [f64; 3]| camera.sensor().project(&Point3::from(p)).unwrap();
    let below = image([-2499226.7942362013, -4256766.8787781885, 4029225.8157722545]);
    assert!((below - Point2::new(2652.0, 1950.0)).norm() < 80.0, "{below}");
    let (south, east) = (
        image([-2499233.9344773693, -4256779.040276368, 4029208.6541282404]) - below,
        image([-2499211.9353014696, -4256775.602699517, 4029225.8157722545]) - below,
    );
    // 22.2 m and 17.2 m at 100 m with f = 3705 px.
    assert!(south.y < -790.0 && south.x.abs() < 40.0, "{south}");
    assert!(east.x < -600.0 && east.y.abs() < 40.0, "{east}");
}

#[test]
fn bad_documents_are_refused_with_their_place() {
    let good = fs::read_to_string(oracle("chunk.xml")).unwrap();
    let refuses = |from: &str, to: &str, expected: &str| {
        assert!(good.contains(from), "{from}");
        let error = photographs::parse(&good.replacen(from, to, 1), None).unwrap_err().to_string();
        assert!(error.contains(expected), "{error}\n{expected}");
    };
    refuses("<f>1105.25</f>", "<f>0</f>", "sensors[0].f: is 0, expected a number above 0");
    refuses("<f>1105.25</f>", "", "sensors[0].f: is NaN");
    refuses("<f>1105.25</f>", "<f>wide</f>", "sensors[0].f: is `wide`: a number is needed");
    refuses(
        "<f>1105.25</f>",
        "<fx>1105.25</fx>",
        "sensors[0].fx: is `there`: PhotoScan before 1.2",
    );
    refuses("<b1>0.53</b1>", "<b1>-2000</b1>", "sensors[0].b1: is -2000");
    refuses("<k1>-0.091</k1>", "<k1>inf</k1>", "sensors[0].k1: is `inf`");
    refuses(
        "type=\"frame\" class=\"adjusted\"",
        "type=\"rpc\" class=\"adjusted\"",
        "type: is `rpc`",
    );
    refuses(
        "sensor_id=\"0\"",
        "sensor_id=\"77\"",
        "cameras[\"frame.jpg\"].sensor_id: names a sensor `77`",
    );
    refuses(
        " 0 0 0 1</transform>",
        " 0 0 1 1</transform>",
        "cameras[\"frame.jpg\"].transform: is `[0.0, 0.0, 1.0, 1.0]`",
    );
    refuses(" 0 0 0 1</transform>", " 0 0 0</transform>", "sixteen numbers are needed");
    refuses(
        "<scale locked=\"true\">0.5",
        "<scale locked=\"true\">-0.5",
        "chunk.transform.scale: is -0.5",
    );
    refuses("<rotation locked=\"true\">", "<rotation>2 ", "chunk.transform.rotation: is `2 ");
    refuses("</document>", "<chunk/></document>", "chunk: is `2 chunks`");
    refuses("</cameras>", "", "is no file of Metashape's");
    let unposed =
        good.replacen("label=\"unaligned.jpg\"", "label=\"unaligned.jpg\" master_id=\"0\"", 1);
    let error = photographs::parse(&unposed, None).unwrap_err().to_string();
    assert!(
        error.starts_with("cameras[\"unaligned.jpg\"].master_id: is `0`: its pose is"),
        "{error}"
    );
    for text in ["<document/>", "<html></html>", "<document><chunk/></document>"] {
        let read = photographs::parse(text, None);
        assert!(read.map_or(true, |p| p.is_empty()), "{text}");
    }
    let calibration = fs::read_to_string(oracle("calibration.xml")).unwrap();
    let with = |from: &str, to: &str| {
        photographs::parse(&calibration.replacen(from, to, 1), None).unwrap_err().to_string()
    };
    assert_eq!(
        with("<width>1280", "<width>12.5"),
        "width: is 12.5, expected a whole number of pixels"
    );
    assert!(with("<projection>frame", "<projection>spherical").starts_with("k1: is `a lens`"));
    let fisheye = calibration.replace("frame", "fisheye").replace("<p1>", "<p3>0.1</p3><p1>");
    let error = photographs::parse(&fisheye, None).unwrap_err().to_string();
    assert!(error.starts_with("p3: is `0.1, 0`"), "{error}");
}

#[test]
fn what_metashape_does_not_have_is_refused_with_the_photograph() {
    let f = r#""principal_distance": [500, 500], "principal_point": [320, 240]"#;
    for (interior, expected) in [
        (
            format!(r#""model": "rational", {f}, "tau": [0.1, 0]"#),
            "`rational`: Metashape has no such",
        ),
        (format!(r#""model": "thin_prism_fisheye", {f}, "s": [0.1, 0]"#), "no thin prism"),
        (format!(r#""model": "fisheye", "projection": "equisolid", {f}"#), "no such model"),
        (
            r#""model": "equirectangular", "principal_distance": [100, 101]"#.into(),
            "a full turn wide",
        ),
        (r#""model": "cylindrical", "principal_point": [320, 241]"#.into(), "a full turn wide"),
    ] {
        let file = CameraFile::parse(&format!(
            r#"{{ "collinear": "camera", "version": 1, "width": 640, "height": 480, "interior": {{ {interior} }},
            "exterior": {{ "projection_center": [0, 0, 0], "quaternion_wxyz": [1, 0, 0, 0] }} }}"#
        ))
        .unwrap();
        let error = metashape::to_text(&[("p.jpg".into(), file)]).unwrap_err().to_string();
        assert!(
            error.starts_with("p.jpg.interior.model: is ") && error.contains(expected),
            "{error}"
        );
    }
}
