//! Points from the photographs that show them.

use std::collections::HashMap;
use std::fmt::Write;

use anyhow::{Result, anyhow};
use collinear::Error;
use collinear::adjust::{
    CRITICAL_VALUE, ImageObservation, Intersection, IntersectionOptions, Precision, intersect,
};
use collinear::camera::SensorModel;
use collinear::nalgebra::Point2;
use collinear_io::observations::ObservationRow;
use collinear_io::points::quoted;
use serde_json::{Value, json};

use crate::protocol::{Table, decimals_for, fixed, number, rows};
use crate::reason::reason;

/// An oriented sensor with its name.
#[derive(Debug)]
pub struct Photograph {
    /// The name, by which observations call it.
    pub name: String,
    /// The sensor.
    pub sensor: Box<dyn SensorModel>,
}

/// A point with what was found.
#[derive(Clone, Debug)]
pub struct PointResult {
    /// Its name.
    pub id: String,
    /// The photographs that show it.
    pub photos: Vec<String>,
    /// The point with its report, or why there is none.
    pub found: Result<Intersection, String>,
}

/// Intersects every point of a list, in the order in which the list first names them.
///
/// # Errors
/// An observation in a photograph that is not there, or two photographs of one name. A point that cannot be found has its reason.
pub fn run(
    photographs: &[Photograph],
    rows: &[ObservationRow],
    sigma: f64,
    trust: bool,
    progress: &dyn Fn(usize, usize),
) -> Result<Vec<PointResult>> {
    let mut by_name: HashMap<&str, &dyn SensorModel> = HashMap::new();
    for photograph in photographs {
        if by_name.insert(&photograph.name, photograph.sensor.as_ref()).is_some() {
            return Err(anyhow!("two photographs are called `{}`", photograph.name));
        }
    }
    let mut places: HashMap<&str, usize> = HashMap::new();
    let mut points: Vec<(String, Vec<(&str, ImageObservation<'_>)>)> = Vec::new();
    for row in rows {
        let Some(sensor) = by_name.get(row.photo.as_str()) else {
            return Err(anyhow!("no photograph is called `{}`: {}", row.photo, known(&by_name)));
        };
        let precision = row.sigma.map_or(Precision::Sigma(sigma), Precision::Sigmas);
        let observation =
            ImageObservation::new(*sensor, Point2::from(row.image)).with_precision(precision);
        let place = *places.entry(&row.id).or_insert_with(|| {
            points.push((row.id.clone(), Vec::new()));
            points.len() - 1
        });
        points[place].1.push((&row.photo, observation));
    }
    let options = IntersectionOptions { estimate_sigma: !trust, ..Default::default() };
    let total = points.len();
    let result = points.into_iter().enumerate().map(|(i, (id, observations))| {
        progress(i, total);
        let list: Vec<ImageObservation<'_>> = observations.iter().map(|o| o.1).collect();
        let photos = observations.iter().map(|o| o.0.to_owned()).collect();
        let found = intersect(&list, &options);
        let found = found.map_err(|error| match seen_from_nowhere(&error, &observations) {
            Some(photo) => format!("{} (in {photo})", reason(&error)),
            None => reason(&error),
        });
        PointResult { id, photos, found }
    });
    Ok(result.collect())
}

/// The first photograph in which the measured image has no line of sight, where that is the error.
fn seen_from_nowhere<'a>(
    error: &Error,
    observations: &[(&'a str, ImageObservation<'_>)],
) -> Option<&'a str> {
    let none = |o: &&(&'a str, ImageObservation<'_>)| o.1.sensor.locus(&o.1.image).is_err();
    match error {
        Error::Projection(_) => observations.iter().find(none).map(|o| o.0),
        _ => None,
    }
}

/// The names that there are, a few of them.
fn known(by_name: &HashMap<&str, &dyn SensorModel>) -> String {
    let mut names: Vec<&str> = by_name.keys().copied().collect();
    names.sort_unstable();
    let more = if names.len() > 5 { ", …" } else { "" };
    names.truncate(5);
    format!("there are {}{more}", names.join(", "))
}

/// The observation with the largest |w|, its photograph and w.
fn worst<'a>(point: &'a PointResult, found: &Intersection) -> Option<(&'a str, f64)> {
    let index = found.report.most_suspect()?;
    Some((point.photos.get(index / 2)?, found.report.values[index].w))
}

/// The protocol, for people.
#[must_use]
pub fn to_text(points: &[PointResult]) -> String {
    let mut text = String::from("Space intersection\n\n");
    let good = points.iter().filter(|p| p.found.is_ok()).count();
    // Writing to a string cannot fail.
    let _ = write!(text, "points           {good}");
    if good < points.len() {
        let _ = write!(text, ", {} not found", points.len() - good);
    }
    let mut sums = (0.0, 0);
    for found in points.iter().filter_map(|p| p.found.as_ref().ok()) {
        sums = (sums.0 + found.report.weighted_sum, sums.1 + found.report.redundancy);
    }
    if sums.1 > 0 {
        let sigma0 = (sums.0 / sums.1 as f64).sqrt();
        let _ = write!(
            text,
            "\nsigma 0          {sigma0:.4} over all points (1 if the stated precisions are right)"
        );
    }
    text.push_str("\n\n");
    let mut table = Table::new(&[
        "point",
        "rays",
        "X",
        "Y",
        "Z",
        "s X",
        "s Y",
        "s Z",
        "sigma 0",
        "largest w",
        "in",
        "",
    ]);
    for point in points {
        let mut cells = vec![point.id.clone(), point.photos.len().to_string()];
        match &point.found {
            Ok(found) => {
                let deviations = [0, 1, 2].map(|i| found.report.standard_deviation(i));
                let decimals = decimals_for(deviations.into_iter().fold(f64::INFINITY, f64::min));
                cells.extend(found.point.iter().map(|c| fixed(*c, decimals)));
                cells.extend(deviations.map(|d| fixed(d, decimals)));
                cells.push(fixed(found.report.sigma0.unwrap_or(f64::NAN), 3));
                let (photo, w) = worst(point, found).unwrap_or(("–", f64::NAN));
                cells.extend([fixed(w, 2), photo.to_owned()]);
                cells.push(if w.abs() > CRITICAL_VALUE { "<- suspect" } else { "" }.to_owned());
            }
            Err(error) => {
                cells.extend(["–"; 9].map(str::to_owned));
                cells.push(error.clone());
            }
        }
        table.row(cells);
    }
    table.write(&mut text);
    text
}

/// The points as CSV; one that was not found has its reason in `note`.
#[must_use]
pub fn to_csv(points: &[PointResult]) -> String {
    let mut text = String::from("id,X,Y,Z,sigma_X,sigma_Y,sigma_Z,rays,sigma0,note\n");
    for point in points {
        let (id, rays) = (quoted(&point.id), point.photos.len());
        // Writing to a string cannot fail.
        let _ = match &point.found {
            Ok(found) => {
                let [x, y, z]: [f64; 3] = found.point.into();
                let [sx, sy, sz] = [0, 1, 2].map(|i| found.report.standard_deviation(i));
                let sigma0 = found.report.sigma0.map_or(String::new(), |s| format!("{s:?}"));
                writeln!(text, "{id},{x:?},{y:?},{z:?},{sx:?},{sy:?},{sz:?},{rays},{sigma0},")
            }
            Err(error) => writeln!(text, "{id},,,,,,,{rays},,{}", quoted(error)),
        };
    }
    text
}

/// The same for machines.
///
/// # Errors
/// None that is known: the numbers that are not finite become null.
pub fn to_json(points: &[PointResult]) -> Result<String> {
    let list: Vec<Value> = points
        .iter()
        .map(|point| match &point.found {
            Ok(found) => {
                let report = &found.report;
                                let observations: Vec<Value> = point
                    .photos
                    .iter()
                    .zip(report.values.chunks(2))
                    .map(|(photo, values)| {
                        json!({
                            "photo": photo,
                            "residual": values.iter().map(|v| number(v.residual)).collect::<Vec<_>>(),
                            "redundancy": values.iter().map(|v| number(v.redundancy)).collect::<Vec<_>>(),
                            "w": values.iter().map(|v| number(v.w)).collect::<Vec<_>>(),
                            "detectable": values.iter().map(|v| number(v.detectable)).collect::<Vec<_>>(),
                        })
                    })
                    .collect();
                json!({
                    "id": point.id, "point": found.point.coords.as_slice(), "covariance": rows(&report.covariance),
                    "sigma0": report.sigma0, "redundancy": report.redundancy, "observations": observations,
                })
            }
            Err(error) => json!({ "id": point.id, "photos": point.photos, "error": error }),
        })
        .collect();
    serde_json::to_string_pretty(&list).map_err(|e| anyhow!(e))
}
