//! Vertices, faces and lines of Wavefront OBJ files.

use std::fs;
use std::path::Path;

use anyhow::{Result, anyhow, bail, ensure};
use collinear::nalgebra::Point3;

/// An object or a group of a file.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Object {
    pub(crate) name: Option<String>,
    pub(crate) elements: Vec<Element>,
}

/// A face or a line.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Element {
    pub(crate) corners: Vec<Point3<f64>>,
    pub(crate) is_face: bool,
}

/// The objects and groups that have faces or lines. Vertices, faces, lines and names are read, everything else is passed over.
///
/// # Errors
/// A file that cannot be read, that is no text, or that has no face and no line; a line that makes no sense, with its number.
pub(crate) fn read(path: &Path) -> Result<Vec<Object>> {
    let name = path.display();
    let bytes = fs::read(path).map_err(|e| anyhow!("{name}: cannot be read: {e}"))?;
    if bytes.contains(&0) {
        bail!("{name}: is no text: a Wavefront OBJ file is needed here");
    }
    // Comments and names may be in any encoding.
    parse(&String::from_utf8_lossy(&bytes)).map_err(|e| anyhow!("{name}: {e}"))
}

fn parse(text: &str) -> Result<Vec<Object>> {
    let mut vertices = Vec::new();
    let mut objects = vec![Object::default()];
    for (i, line) in text.lines().enumerate() {
        let number = i + 1;
        let mut words = line.split_whitespace();
        match words.next() {
            Some("v") => vertices.push(vertex(words, number)?),
            Some(kind @ ("f" | "l")) => {
                let corners = words
                    .map(|w| corner(w, &vertices).ok_or_else(|| unknown(w, &vertices, number)))
                    .collect::<Result<Vec<_>>>()?;
                if let Some(object) = objects.last_mut() {
                    object.elements.push(Element { corners, is_face: kind == "f" });
                }
            }
            Some("o" | "g") => {
                let name = words.collect::<Vec<_>>().join(" ");
                let name = Some(name).filter(|n| !n.is_empty());
                objects.push(Object { name, elements: Vec::new() });
            }
            _ => {}
        }
    }
    objects.retain(|o| o.elements.iter().any(|e| e.corners.len() > 1));
    ensure!(
        !objects.is_empty(),
        "there are no faces and no lines in it (`f`, `l` of a Wavefront OBJ file) and {} vertices: nothing to draw",
        vertices.len()
    );
    Ok(objects)
}

fn vertex<'a>(words: impl Iterator<Item = &'a str>, number: usize) -> Result<Point3<f64>> {
    let numbers: Vec<f64> =
        words.take(3).map_while(|w| w.parse().ok()).filter(|v: &f64| v.is_finite()).collect();
    match numbers.as_slice() {
        [x, y, z] => Ok(Point3::new(*x, *y, *z)),
        _ => Err(anyhow!("line {number}: a vertex needs three finite numbers")),
    }
}

/// The vertex that `7`, `7/1` or `-1//2` names: from 1, or backwards from the last.
fn corner(word: &str, vertices: &[Point3<f64>]) -> Option<Point3<f64>> {
    let index: i64 = word.split('/').next()?.parse().ok()?;
    let place = if index < 0 {
        vertices.len().checked_sub(usize::try_from(index.unsigned_abs()).ok()?)?
    } else {
        usize::try_from(index).ok()?.checked_sub(1)?
    };
    vertices.get(place).copied()
}

fn unknown(word: &str, vertices: &[Point3<f64>], number: usize) -> anyhow::Error {
    anyhow!("line {number}: `{word}` names no vertex, there are {} so far", vertices.len())
}
