//! Points through a camera, either way.

use anyhow::Result;
use collinear::nalgebra::{Point2, Point3};
use collinear_io::plane::PlaneFile;
use collinear_io::points::{ImagePointRow, PointRow, quoted};
use collinear_io::sensor::SensorFile;

/// The status of a point that has both coordinates, in the picture.
pub const OK: &str = "ok";

/// The status of a point whose image lies beyond the picture's edge.
pub const OUTSIDE: &str = "outside the picture";

/// A point of the world with its image.
#[derive(Clone, Debug, PartialEq)]
pub struct ProjectedRow {
    /// Its name.
    pub id: Option<String>,
    /// X, Y, Z in the world.
    pub world: Option<[f64; 3]>,
    /// x, y in the picture, pixels.
    pub image: Option<[f64; 2]>,
    /// [`OK`], [`OUTSIDE`], or why one of the two is missing.
    pub status: String,
}

/// The images of world points. One beyond the picture's edge is given too, and says so.
///
/// # Errors
/// Those of a camera out of its domain. A point without an image has its reason in its status.
pub fn project(camera: &SensorFile, points: &[PointRow]) -> Result<Vec<ProjectedRow>> {
    let sensor = camera.sensor()?;
    let row = |point: &PointRow| {
        let image = sensor.project(&Point3::from(point.world));
        let (image, status) = match image {
            Ok(p) => (Some([p.x, p.y]), place(camera, &p).to_owned()),
            Err(reason) => (None, reason.to_string()),
        };
        ProjectedRow { id: point.id.clone(), world: Some(point.world), image, status }
    };
    Ok(points.iter().map(row).collect())
}

/// The points of a plane that image points show.
///
/// # Errors
/// Those of a camera or a plane out of its domain. An image point without a place has its reason in its status.
pub fn ground(
    camera: &SensorFile,
    plane: &PlaneFile,
    points: &[ImagePointRow],
) -> Result<Vec<ProjectedRow>> {
    let (sensor, plane) = (camera.sensor()?, plane.plane()?);
    let row = |point: &ImagePointRow| {
        let image = Point2::from(point.image);
        let (world, status) = match sensor.ground(&image, &plane) {
            Ok(p) => (Some(p.into()), place(camera, &image).to_owned()),
            Err(reason) => (None, reason.to_string()),
        };
        ProjectedRow { id: point.id.clone(), world, image: Some(point.image), status }
    };
    Ok(points.iter().map(row).collect())
}

fn place(camera: &SensorFile, p: &Point2<f64>) -> &'static str {
    let [width, height] = camera.size().map(f64::from);
    let inside = (0.0..width).contains(&p.x) && (0.0..height).contains(&p.y);
    if inside { OK } else { OUTSIDE }
}

/// The table `id,X,Y,Z,x,y,status`. Numbers are written so that reading gives the same bits.
#[must_use]
pub fn to_csv(rows: &[ProjectedRow]) -> String {
    table("X,Y,Z", rows)
}

/// The table with other names for the three coordinates of the world.
pub(crate) fn table(world: &str, rows: &[ProjectedRow]) -> String {
    let mut text = format!("id,{world},x,y,status\n");
    for row in rows {
        let mut fields = vec![quoted(row.id.as_deref().unwrap_or_default())];
        fields.extend(numbers(row.world));
        fields.extend(numbers(row.image));
        fields.push(quoted(&row.status));
        text.push_str(&fields.join(","));
        text.push('\n');
    }
    text
}

fn numbers<const N: usize>(values: Option<[f64; N]>) -> [String; N] {
    values.map_or_else(|| std::array::from_fn(|_| String::new()), |v| v.map(|v| format!("{v:?}")))
}
