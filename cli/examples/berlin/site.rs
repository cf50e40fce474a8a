//! The place: photographs with their cameras, points, and the planes and axes found in them.

use std::path::Path;

use anyhow::{Result, ensure};
use collinear::camera::{BrownCamera, Frame};
use collinear::geometry::Plane;
use collinear::nalgebra::{Point3, UnitVector3, Vector3};
use collinear_io::camera::CameraFile;
use collinear_io::opensfm::{Observation, read_reconstruction, read_tracks};
use collinear_io::picture::{Picture, read_picture};
use collinear_io::plane::{PlaneFile, Rectangle};

use crate::planes::{self, Axes, Found, Search};

/// How far a point may lie off its plane, in the reconstruction's metres: twice the depth noise of its points.
const THRESHOLD: f64 = 0.15;

/// A photograph.
pub(crate) struct Photograph {
    /// "01", "02" or "03".
    pub(crate) name: String,
    pub(crate) camera: CameraFile,
    pub(crate) frame: Frame<BrownCamera>,
    pub(crate) picture: Picture,
}

/// The photographs, the points, and what was found in them.
pub(crate) struct Site {
    pub(crate) photographs: Vec<Photograph>,
    pub(crate) observations: Vec<Observation>,
    pub(crate) points: Vec<Point3<f64>>,
    /// The largest planes, one after another.
    pub(crate) largest: Vec<Found>,
    pub(crate) axes: Axes,
    /// The planes parallel to the façade.
    pub(crate) sheets: Vec<Found>,
    /// The points on none of them.
    pub(crate) rest: Vec<Point3<f64>>,
    /// The origin of building coordinates: the first photograph's projection centre.
    pub(crate) origin: Point3<f64>,
}

impl Site {
    /// Reads the data and finds planes and axes.
    pub(crate) fn read(folder: &Path) -> Result<Self> {
        let reconstruction = read_reconstruction(&folder.join("reconstruction_example.json"), 0)?;
        let observations = read_tracks(&folder.join("tracks_example.csv"))?;
        let mut photographs = Vec::new();
        for file in reconstruction.shots.keys() {
            let camera = reconstruction.camera(file)?;
            let picture = read_picture(&folder.join(file))?;
            camera.check_picture_size(picture.width, picture.height)?;
            let frame = camera.frame()?;
            let name = file.trim_end_matches(".jpg").to_owned();
            photographs.push(Photograph { name, camera, frame, picture });
        }
        ensure!(!photographs.is_empty(), "the reconstruction has no photographs");
        let points: Vec<Point3<f64>> =
            reconstruction.points.values().map(|p| Point3::from(p.coordinates)).collect();
        let origin = photographs[0].frame.exterior.projection_center();

        let how = Search { threshold: THRESHOLD, least: 50 };
        let largest = planes::one_after_another(&points, how, 6);
        ensure!(!largest.is_empty(), "no plane has {} points", how.least);
        let wall = away_from(&largest[0].plane, &origin);
        let axes = planes::axes(&points, &wall, THRESHOLD);
        let (sheets, rest) = planes::sheets(&points, axes.inward, how);
        Ok(Self { photographs, observations, points, largest, axes, sheets, rest, origin })
    }

    /// The world point at building coordinates: right, into the façade, up, from the first photograph's camera.
    pub(crate) fn world(&self, [x, y, z]: [f64; 3]) -> Point3<f64> {
        let Axes { right, inward, up } = self.axes;
        self.origin + *right * x + *inward * y + *up * z
    }

    /// Building coordinates of a world point.
    pub(crate) fn building(&self, world: &Point3<f64>) -> [f64; 3] {
        let d = world - self.origin;
        [self.axes.right.dot(&d), self.axes.inward.dot(&d), self.axes.up.dot(&d)]
    }

    /// The sheet nearest to a depth.
    pub(crate) fn sheet(&self, depth: f64) -> Result<&Found> {
        let off = |f: &Found| (self.depth(f) - depth).abs();
        let nearest = self.sheets.iter().min_by(|a, b| off(a).total_cmp(&off(b)));
        nearest.ok_or_else(|| anyhow::anyhow!("there is no plane parallel to the façade"))
    }

    /// The depth of a sheet behind the first camera.
    pub(crate) fn depth(&self, sheet: &Found) -> f64 {
        self.building(&sheet.plane.point())[1]
    }

    /// The plane with most points that rises into the façade by `slope` radians, among the points in a box of building
    /// coordinates; its level lines lean by `lean` radians upwards to the right.
    pub(crate) fn rising(
        &self,
        from: [f64; 3],
        to: [f64; 3],
        slope: f64,
        lean: f64,
    ) -> Result<Found> {
        let inside = |p: &&Point3<f64>| {
            let b = self.building(p);
            (0..3).all(|i| b[i] >= from[i] && b[i] <= to[i])
        };
        let points: Vec<_> = self.points.iter().filter(inside).copied().collect();
        let how = Search { threshold: THRESHOLD / 2.0, least: 6 };
        let Axes { right, inward, up } = self.axes;
        let leaning = Axes {
            right: UnitVector3::new_normalize(*right + *up * lean),
            up: UnitVector3::new_normalize(*up - *right * lean),
            inward,
        };
        Ok(planes::rising(&points, &leaning, slope, how)?)
    }
}

/// The plane with its normal turned away from a point.
fn away_from(plane: &Plane, point: &Point3<f64>) -> Plane {
    if plane.signed_distance(point) < 0.0 { *plane } else { plane.flipped() }
}

/// The file of a plane seen from the first camera, with the rectangle that holds its points but for the outermost 2 % on
/// each side.
pub(crate) fn plane_file(
    found: &Found,
    up: Vector3<f64>,
    seen_from: &Point3<f64>,
) -> Result<PlaneFile> {
    let plane = away_from(&found.plane, seen_from).flipped();
    let mut file = PlaneFile {
        point: plane.point().into(),
        normal: (*plane.normal()).into(),
        up: Some(up.into()),
        rectangle: None,
    };
    let (mut across, mut upwards) = (Vec::new(), Vec::new());
    for p in &found.points {
        let [x, y] = file.plane_from_world(&(*p).into()).map_err(collinear_io::Error::from)?;
        across.push(x);
        upwards.push(y);
    }
    let ([left, right], [bottom, top]) = (middle_96_percent(across), middle_96_percent(upwards));
    file.rectangle = Some(Rectangle { left, bottom, right, top });
    Ok(file)
}

fn middle_96_percent(mut values: Vec<f64>) -> [f64; 2] {
    values.sort_by(f64::total_cmp);
    let at = |part: f64| {
        let place = part * (values.len().saturating_sub(1)) as f64;
        values.get(place.round() as usize).copied().unwrap_or(0.0)
    };
    [at(0.02), at(0.98)]
}
