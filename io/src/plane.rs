//! Plane files: a plane of the world, and which part of it to show which way up.

use serde::{Deserialize, Serialize};

use crate::check::{cross, dot, finite, in_range, norm, unit};
use crate::error::{FieldError, FieldProblem};
use crate::json::{Document, object};

/// A plane whose normal is within this angle of ±Z is horizontal: "up" on it is +Y, as on a map. One degree, in radians.
const HORIZONTAL: f64 = 0.017_453_292_519_943_295;

/// The smallest angle, in radians, between a given "up" and the normal.
const PARALLEL: f64 = 1e-6;

/// A plane as its file states it. Fields, units and defaults: `docs/formats.md`, "plane".
///
/// ```
/// use collinear_io::Document;
/// use collinear_io::plane::PlaneFile;
///
/// // A wall that faces south. Seen from there, east is right and +Z is up.
/// let wall = PlaneFile::parse(
///     r#"{"collinear": "plane", "version": 1, "point": [10, 20, 0], "normal": [0, -3, 0]}"#,
/// )?;
/// let axes = wall.axes()?;
/// assert_eq!((axes.right, axes.up), ([1.0, 0.0, 0.0], [0.0, 0.0, 1.0]));
/// # Ok::<(), collinear_io::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PlaneFile {
    /// A point of the plane, world coordinates: the origin of its own coordinates.
    pub point: [f64; 3],
    /// The normal, world coordinates, of any length. The plane is looked at from the side to which it points.
    pub normal: [f64; 3],
    /// The direction that points up in a rectified picture, world coordinates, of any length. It need not lie in the
    /// plane. Without it: +Z, or +Y where the normal is within one degree of ±Z.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub up: Option<[f64; 3]>,
    /// The part of the plane to show.
    #[serde(
        default,
        skip_serializing_if = "Option::is_none",
        deserialize_with = "object::optional"
    )]
    pub rectangle: Option<Rectangle>,
}

/// A rectangle in the coordinates of a plane: world units to the right of its point and up from it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Rectangle {
    /// The least coordinate to the right.
    pub left: f64,
    /// The least coordinate upwards.
    pub bottom: f64,
    /// The greatest coordinate to the right.
    pub right: f64,
    /// The greatest coordinate upwards.
    pub top: f64,
}

/// The axes of a plane's own coordinates: unit vectors in world coordinates, right × up = normal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Axes {
    /// To the right, seen from the side of the normal.
    pub right: [f64; 3],
    /// Up along the plane.
    pub up: [f64; 3],
    /// Towards the viewer.
    pub normal: [f64; 3],
}

impl PlaneFile {
    /// The axes of the plane's coordinates.
    ///
    /// ```text
    /// up = u − (u·n) n, at length one;   right = up × n
    /// ```
    ///
    /// # Errors
    /// A normal without a direction, or an `up` without one or along the normal.
    pub fn axes(&self) -> Result<Axes, FieldError> {
        let no_direction = |field, v: &[f64; 3]| {
            let expected = "a finite length above 0";
            FieldError::new(field, FieldProblem::Length { norm: norm(v), expected })
        };
        let normal = unit(&self.normal).ok_or_else(|| no_direction("normal", &self.normal))?;
        let horizontal = norm(&normal[..2]) <= HORIZONTAL.sin();
        let default = if horizontal { [0.0, 1.0, 0.0] } else { [0.0, 0.0, 1.0] };
        let given = self.up.unwrap_or(default);
        let towards = unit(&given).ok_or_else(|| no_direction("up", &given))?;
        // The cross product keeps its direction however close the two are; the difference u − (u·n) n does not.
        let across = cross(&towards, &normal);
        let right = unit(&across)
            .filter(|_| norm(&across) > PARALLEL)
            .ok_or_else(|| FieldError::new("up", FieldProblem::ParallelToNormal))?;
        Ok(Axes { right, up: cross(&normal, &right), normal })
    }

    /// The world point at plane coordinates (right, up).
    ///
    /// # Errors
    /// As [`axes`](Self::axes).
    pub fn world_from_plane(&self, right: f64, up: f64) -> Result<[f64; 3], FieldError> {
        let axes = self.axes()?;
        let mut world = self.point;
        for ((w, r), u) in world.iter_mut().zip(axes.right).zip(axes.up) {
            *w += right * r + up * u;
        }
        Ok(world)
    }

    /// The plane coordinates (right, up) of the foot of a world point.
    ///
    /// # Errors
    /// As [`axes`](Self::axes).
    pub fn plane_from_world(&self, world: &[f64; 3]) -> Result<[f64; 2], FieldError> {
        let axes = self.axes()?;
        let mut offset = *world;
        for (o, p) in offset.iter_mut().zip(self.point) {
            *o -= p;
        }
        Ok([dot(&offset, &axes.right), dot(&offset, &axes.up)])
    }
}

impl Document for PlaneFile {
    const KIND: &'static str = "plane";
    const VERSION: u64 = 1;

    fn check(&self) -> Result<(), FieldError> {
        finite("point", &self.point)?;
        finite("normal", &self.normal)?;
        if let Some(up) = &self.up {
            finite("up", up)?;
        }
        self.axes()?;
        if let Some(r) = &self.rectangle {
            for (field, value) in [("left", r.left), ("bottom", r.bottom)] {
                in_range(&format!("rectangle.{field}"), value, "a finite number", |_| true)?;
            }
            in_range("rectangle.right", r.right, "a finite number above left", |v| v > r.left)?;
            in_range("rectangle.top", r.top, "a finite number above bottom", |v| v > r.bottom)?;
        }
        Ok(())
    }
}
