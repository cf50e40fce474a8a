//! Dome files: the part of a sphere that is projected on.

use serde::{Deserialize, Serialize};

use crate::check::{finite, in_range, unit};
use crate::error::{FieldError, FieldProblem};
use crate::json::Document;

/// A dome as its file states it. Fields, units and defaults: `docs/formats.md`, "dome".
///
/// ```
/// use collinear::geometry::{Ray, Surface};
/// use collinear::nalgebra::{Point3, Vector3};
/// use collinear_io::Document;
/// use collinear_io::dome::DomeFile;
///
/// // A hemisphere of 10 m above (0, 0, 2): straight up its middle is at 12.
/// let file = DomeFile::parse(r#"{"collinear": "dome", "version": 1, "center": [0, 0, 2], "radius": 10}"#)?;
/// let zenith = file.dome()?.meet_ray(&Ray::new(Point3::origin(), Vector3::z())?)?;
/// assert_eq!(zenith, Point3::new(0.0, 0.0, 12.0));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DomeFile {
    /// The centre of the sphere, world coordinates.
    pub center: [f64; 3],
    /// Its radius, world units.
    pub radius: f64,
    /// The direction from the centre to the dome's middle, world coordinates, of any length: +Z without it.
    #[serde(default = "up")]
    pub axis: [f64; 3],
    /// The angle from there to the rim, as seen from the centre, in degrees: 90, a hemisphere, without it.
    #[serde(default = "quarter")]
    pub half_angle_deg: f64,
}

fn up() -> [f64; 3] {
    [0.0, 0.0, 1.0]
}

fn quarter() -> f64 {
    90.0
}

impl Document for DomeFile {
    const KIND: &'static str = "dome";
    const VERSION: u64 = 1;

    fn check(&self) -> Result<(), FieldError> {
        finite("center", &self.center)?;
        in_range("radius", self.radius, "a finite number above 0", |r| r > 0.0)?;
        finite("axis", &self.axis)?;
        if unit(&self.axis).is_none() {
            let expected = "a finite length above 0";
            let norm = crate::check::norm(&self.axis);
            return Err(FieldError::new("axis", FieldProblem::Length { norm, expected }));
        }
        let expected = "above 0, at most 180 degrees";
        in_range("half_angle_deg", self.half_angle_deg, expected, |a| a > 0.0 && a <= 180.0)
    }
}
