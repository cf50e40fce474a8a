//! The scene and what belongs to it as files, in map coordinates: cameras, a plane, points.

use std::fmt::Write;

use super::camera::Camera;
use super::caster::{BACKGROUND, Town};
use super::photographs::{DOME_RADIUS, dome, dome_axis, projector};
use super::polygon::Polygon;
use super::scene::MAP;
use super::vector::V3;

/// The façade of the plane file.
const FACADE: &str = "town hall front";

/// The points of the list: a name, a polygon's name and the number of its vertex.
const POINTS: [(&str, &str, usize); 7] = [
    ("spire", "spire 0.0", 2),
    ("tower, south-west foot", "tower south", 0),
    ("tower, south-east foot", "tower south", 1),
    ("town hall, left foot", FACADE, 0),
    ("town hall, right foot", FACADE, 1),
    ("town hall, right eaves", "town hall right", 3),
    ("behind the square", "ground 2.0", 0),
];

fn in_map(p: V3) -> [f64; 3] {
    [p.x + MAP[0], p.y + MAP[1], p.z + MAP[2]]
}

/// The fields of a camera: its size, its interior and its exterior orientation.
fn camera_fields(camera: &Camera) -> [String; 3] {
    let (f, c) = (camera.principal_distance, camera.principal_point);
    let [x0, y0, z0] = in_map(camera.center);
    let [w, x, y, z] = camera.quaternion();
    let [k1, k2, k3] = camera.k;
    let [p1, p2] = camera.p;
    let distorted = camera.k != [0.0; 3] || camera.p != [0.0; 2];
    let model = match distorted {
        _ if camera.fisheye => "fisheye",
        true => "brown",
        false => "pinhole",
    };
    let lens = if distorted {
        format!(", \"k\": [{k1}, {k2}, {k3}], \"p\": [{p1}, {p2}]")
    } else {
        String::new()
    };
    [
        format!("\"width\": {}, \"height\": {}", camera.width, camera.height),
        format!(
            "\"interior\": {{ \"model\": \"{model}\", \"principal_distance\": [{}, {}], \
             \"principal_point\": [{}, {}]{lens} }}",
            f.0, f.1, c.0, c.1
        ),
        format!(
            "\"exterior\": {{ \"projection_center\": [{x0}, {y0}, {z0}], \
             \"quaternion_wxyz\": [{w}, {x}, {y}, {z}] }}"
        ),
    ]
}

/// The files beside the scene, each with its name: the photographs' cameras, the plane of a façade, a list of points; a dome, the camera of
/// its dome master, a projector for it.
pub(crate) fn files(town: &Town) -> Vec<(String, String)> {
    let mut files = vec![
        ("town.json".to_owned(), scene_json(town)),
        ("town_hall.plane.json".to_owned(), plane_json(town)),
        ("points.csv".to_owned(), points_csv(town)),
    ];
    files.push(("dome.json".to_owned(), dome_json()));
    let screens = [("dome", &dome()), ("projector", &projector())];
    let photographs = town.photographs.iter().map(|p| (p.name, &p.camera));
    for (name, camera) in photographs.chain(screens) {
        let fields = camera_fields(camera).join(",\n  ");
        let text = format!("{{\n  \"collinear\": \"camera\", \"version\": 1,\n  {fields}\n}}\n");
        files.push((camera_file(name), text));
    }
    files
}

/// The dome about its dome master's place.
fn dome_json() -> String {
    let ([x, y, z], axis) = (in_map(dome().center), dome_axis());
    format!(
        "{{\n  \"collinear\": \"dome\", \"version\": 1,\n  \"center\": [{x}, {y}, {z}], \"radius\": {DOME_RADIUS}, \
         \"axis\": [{}, {}, {}]\n}}\n",
        axis.x, axis.y, axis.z
    )
}

fn camera_file(photograph: &str) -> String {
    format!("{photograph}.camera.json")
}

/// The first polygon whose name starts so.
fn named<'a>(town: &'a Town, name: &str) -> &'a Polygon {
    let found = town.polygons.iter().find(|p| p.name.starts_with(name));
    found.unwrap_or(&town.polygons[0])
}

fn plane_json(town: &Town) -> String {
    let facade = named(town, FACADE);
    let ((left, bottom), (right, top)) = facade.extent();
    let [x, y, z] = in_map(facade.frame.origin);
    let n = facade.frame.n;
    format!(
        "{{\n  \"collinear\": \"plane\", \"version\": 1,\n  \"point\": [{x}, {y}, {z}], \"normal\": [{}, {}, {}],\n  \
         \"rectangle\": {{ \"left\": {left}, \"bottom\": {bottom}, \"right\": {right}, \"top\": {top} }}\n}}\n",
        n.x + 0.0,
        n.y + 0.0,
        n.z + 0.0
    )
}

fn points_csv(town: &Town) -> String {
    let mut out = String::from("id,X,Y,Z\n");
    for (label, polygon, vertex) in POINTS {
        let [x, y, z] = in_map(named(town, polygon).vertices[vertex]);
        let _ = writeln!(out, "\"{label}\",{x},{y},{z}");
    }
    out
}

/// The scene file: photographs, polygons in map coordinates, the new view.
pub(crate) fn scene_json(town: &Town) -> String {
    let mut out = String::from("{\"collinear\":\"scene\",\"version\":1,\n\"photographs\":[\n");
    let comma = |i: usize, n: usize| if i + 1 < n { ",\n" } else { "\n" };
    for (i, photograph) in town.photographs.iter().enumerate() {
        let name = photograph.name;
        let camera = camera_file(name);
        let end = comma(i, town.photographs.len());
        let _ = write!(
            out,
            "{{\"name\":\"{name}\",\"image\":\"{name}.png\",\"camera\":\"{camera}\"}}{end}"
        );
    }
    out.push_str("],\n\"textures\":[],\n\"polygons\":[\n");
    for (i, polygon) in town.polygons.iter().enumerate() {
        let vertices: Vec<String> = polygon
            .vertices
            .iter()
            .map(|p| {
                let [x, y, z] = in_map(*p);
                format!("[{x},{y},{z}]")
            })
            .collect();
        let _ = write!(
            out,
            "{{\"name\":\"{}\",\"vertices\":[{}],\"photograph\":\"{}\"}}{}",
            polygon.name,
            vertices.join(","),
            town.photographs[town.assigned[i]].name,
            comma(i, town.polygons.len())
        );
    }
    let [r, g, b] = BACKGROUND;
    let _ = write!(
        out,
        "],\n\"view\":{{ {} }},\n\"background\":[{r},{g},{b}],\n\"near\":0.5,\"cull\":\"none\",\
         \"filter\":\"bilinear\",\"interpolation\":\"perspective\"}}\n",
        camera_fields(&town.view).join(", ")
    );
    out
}
