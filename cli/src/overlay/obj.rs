//! Vertices, faces and lines of Wavefront OBJ files.

use std::fs;
use std::path::Path;

use anyhow::{Result, anyhow, bail, ensure};
use collinear::nalgebra::Point3;

use super::{Figure, middle};

pub(super) fn read(path: &Path) -> Result<Vec<Figure>> {
    let name = path.display();
    let bytes = fs::read(path).map_err(|e| anyhow!("{name}: cannot be read: {e}"))?;
    if bytes.contains(&0) {
        bail!("{name}: is no text: a Wavefront OBJ file is needed here");
    }
    // Comments and names may be in any encoding.
    parse(&String::from_utf8_lossy(&bytes)).map_err(|e| anyhow!("{name}: {e}"))
}

/// One object or group while it is read.
#[derive(Default)]
struct Group {
    name: Option<String>,
    edges: Vec<[Point3<f64>; 2]>,
    vertices: Vec<Point3<f64>>,
}

impl Group {
    fn finish(self, figures: &mut Vec<Figure>) {
        let Self { name, edges, vertices } = self;
        if !edges.is_empty() {
            figures.push(Figure { name, edges, middle: middle(&vertices) });
        }
    }
}

fn parse(text: &str) -> Result<Vec<Figure>> {
    let mut vertices = Vec::new();
    let mut figures = Vec::new();
    let mut group = Group::default();
    for (i, line) in text.lines().enumerate() {
        let number = i + 1;
        let mut words = line.split_whitespace();
        match words.next() {
            Some("v") => vertices.push(vertex(words, number)?),
            Some(kind @ ("f" | "l")) => {
                let corners = words
                    .map(|w| corner(w, &vertices).ok_or_else(|| unknown(w, &vertices, number)))
                    .collect::<Result<Vec<_>>>()?;
                let closed = kind == "f" && corners.len() > 2;
                let next = corners.iter().skip(1).chain(corners.first().filter(|_| closed));
                group.edges.extend(corners.iter().zip(next).map(|(a, b)| [*a, *b]));
                group.vertices.extend(corners);
            }
            Some("o" | "g") => {
                let name = words.collect::<Vec<_>>().join(" ");
                let name = Some(name).filter(|n| !n.is_empty());
                std::mem::replace(&mut group, Group { name, ..Group::default() })
                    .finish(&mut figures);
            }
            _ => {}
        }
    }
    group.finish(&mut figures);
    ensure!(
        !figures.is_empty(),
        "there are no faces and no lines in it (`f`, `l` of a Wavefront OBJ file) and {} vertices: nothing to draw",
        vertices.len()
    );
    Ok(figures)
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
