//! The scene as JSON, in map coordinates.

use std::fmt::Write;

use super::camera::Camera;
use super::caster::{BACKGROUND, Town};
use super::scene::MAP;

fn camera_json(camera: &Camera) -> String {
    let (f, c) = (camera.principal_distance, camera.principal_point);
    let at = camera.center.array();
    let [w, x, y, z] = camera.quaternion();
    let [k1, k2, k3] = camera.k;
    let [p1, p2] = camera.p;
    let distorted = camera.k != [0.0; 3] || camera.p != [0.0; 2];
    let model = if distorted { "brown" } else { "pinhole" };
    let lens = if distorted {
        format!(",\"k\":[{k1},{k2},{k3}],\"p\":[{p1},{p2}]")
    } else {
        String::new()
    };
    format!(
        "{{\"width\":{},\"height\":{},\
         \"interior\":{{\"model\":\"{model}\",\"principal_distance\":[{},{}],\"principal_point\":[{},{}],\
         \"skew\":0{lens}}},\
         \"exterior\":{{\"projection_center\":[{},{},{}],\"quaternion_wxyz\":[{w},{x},{y},{z}]}}}}",
        camera.width,
        camera.height,
        f.0,
        f.1,
        c.0,
        c.1,
        at[0] + MAP[0],
        at[1] + MAP[1],
        at[2] + MAP[2],
    )
}

/// The scene file: photographs, polygons in map coordinates, the new view.
pub(crate) fn scene_json(town: &Town) -> String {
    let mut out = String::from("{\"collinear\":\"scene\",\"version\":1,\n\"photographs\":[\n");
    let comma = |i: usize, n: usize| if i + 1 < n { ",\n" } else { "\n" };
    for (i, photograph) in town.photographs.iter().enumerate() {
        let name = photograph.name;
        let camera = camera_json(&photograph.camera);
        let end = comma(i, town.photographs.len());
        let _ = write!(
            out,
            "{{\"name\":\"{name}\",\"image\":\"{name}.png\",\"camera\":{camera}}}{end}"
        );
    }
    out.push_str("],\n\"textures\":[],\n\"polygons\":[\n");
    for (i, polygon) in town.polygons.iter().enumerate() {
        let vertices: Vec<String> = polygon
            .vertices
            .iter()
            .map(|p| format!("[{},{},{}]", p.x + MAP[0], p.y + MAP[1], p.z + MAP[2]))
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
        "],\n\"view\":{},\n\"background\":[{r},{g},{b}],\n\"near\":0.5,\"cull\":\"none\",\
         \"filter\":\"bilinear\",\"interpolation\":\"perspective\"}}\n",
        camera_json(&town.view)
    );
    out
}
