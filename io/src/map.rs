//! Map files: the coefficients of a map from one picture into another.

use serde::{Deserialize, Serialize};

use crate::check::{determinant, finite};
use crate::error::{FieldError, FieldProblem};
use crate::json::Document;

/// A matrix scaled to entries of one with a smaller determinant than this has no inverse in `f64`.
const SINGULAR: f64 = 1e-300;

/// A map of the plane as its file states it: from a point of the new picture to the point of the old one that is shown
/// there, both in pixels. Coefficients and their order: `docs/formats.md`, "map".
///
/// ```
/// use collinear_io::Document;
/// use collinear_io::map::MapFile;
///
/// let map = MapFile::parse(
///     r#"{"collinear": "map", "version": 1, "kind": "affine", "a": [5, 2, 0], "b": [7, 0, 2]}"#,
/// )?;
/// assert_eq!(map, MapFile::Affine { a: [5.0, 2.0, 0.0], b: [7.0, 0.0, 2.0] });
/// # Ok::<(), collinear_io::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "RawMap", into = "RawMap")]
pub enum MapFile {
    /// x = (h₁₁X + h₁₂Y + h₁₃)/w, y = (h₂₁X + h₂₂Y + h₂₃)/w, w = h₃₁X + h₃₂Y + h₃₃.
    Homography {
        /// The rows.
        matrix: [[f64; 3]; 3],
    },
    /// x = A₀ + A₁X + A₂Y, y likewise with B.
    Affine {
        /// A₀, A₁, A₂.
        a: [f64; 3],
        /// B₀, B₁, B₂.
        b: [f64; 3],
    },
    /// x = A₀ + A₁X + A₂Y + A₃XY, y likewise with B.
    Bilinear {
        /// A₀ … A₃.
        a: [f64; 4],
        /// B₀ … B₃.
        b: [f64; 4],
    },
    /// x = A₀ + A₁X + A₂Y + A₃XY + A₄X² + A₅Y², y likewise with B.
    Quadratic {
        /// A₀ … A₅.
        a: [f64; 6],
        /// B₀ … B₅.
        b: [f64; 6],
    },
    /// x = A₀ + A₁X + A₂Y + A₃XY + A₄X² + A₅Y² + A₆X²Y + A₇XY² + A₈X³ + A₉Y³, y likewise with B.
    Cubic {
        /// A₀ … A₉.
        a: [f64; 10],
        /// B₀ … B₉.
        b: [f64; 10],
    },
}

impl Document for MapFile {
    const KIND: &'static str = "map";
    const VERSION: u64 = 1;

    fn check(&self) -> Result<(), FieldError> {
        let both = |a: &[f64], b: &[f64]| finite("a", a).and_then(|()| finite("b", b));
        match self {
            Self::Homography { matrix } => {
                for (i, row) in matrix.iter().enumerate() {
                    finite(&format!("matrix[{i}]"), row)?;
                }
                let largest = matrix.iter().flatten().fold(0.0_f64, |m, v| m.max(v.abs()));
                let determinant = if largest == 0.0 {
                    0.0
                } else {
                    determinant(&matrix.map(|r| r.map(|v| v / largest)))
                };
                if determinant.abs() < SINGULAR {
                    return Err(FieldError::new("matrix", FieldProblem::Singular { determinant }));
                }
                Ok(())
            }
            Self::Affine { a, b } => both(a, b),
            Self::Bilinear { a, b } => both(a, b),
            Self::Quadratic { a, b } => both(a, b),
            Self::Cubic { a, b } => both(a, b),
        }
    }
}

#[derive(Clone, Copy, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
enum Kind {
    Homography,
    Affine,
    Bilinear,
    Quadratic,
    Cubic,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct RawMap {
    kind: Kind,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    matrix: Option<[[f64; 3]; 3]>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    a: Option<Vec<f64>>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    b: Option<Vec<f64>>,
}

impl TryFrom<RawMap> for MapFile {
    type Error = String;

    fn try_from(raw: RawMap) -> Result<Self, String> {
        let (a, b) = match (raw.kind, raw.matrix, raw.a, raw.b) {
            (Kind::Homography, Some(matrix), None, None) => return Ok(Self::Homography { matrix }),
            (Kind::Homography, ..) => {
                return Err("the kind `homography` has `matrix` and no other coefficients".into());
            }
            (_, None, Some(a), Some(b)) => (a, b),
            _ => return Err("this kind has the lists `a` and `b` and no `matrix`".into()),
        };
        Ok(match raw.kind {
            Kind::Homography | Kind::Affine => {
                Self::Affine { a: sized("a", a)?, b: sized("b", b)? }
            }
            Kind::Bilinear => Self::Bilinear { a: sized("a", a)?, b: sized("b", b)? },
            Kind::Quadratic => Self::Quadratic { a: sized("a", a)?, b: sized("b", b)? },
            Kind::Cubic => Self::Cubic { a: sized("a", a)?, b: sized("b", b)? },
        })
    }
}

fn sized<const N: usize>(name: &str, list: Vec<f64>) -> Result<[f64; N], String> {
    list.try_into()
        .map_err(|l: Vec<f64>| format!("`{name}` has {} coefficients, this kind has {N}", l.len()))
}

impl From<MapFile> for RawMap {
    fn from(map: MapFile) -> Self {
        let lists = |kind, a: &[f64], b: &[f64]| Self {
            kind,
            matrix: None,
            a: Some(a.to_vec()),
            b: Some(b.to_vec()),
        };
        match map {
            MapFile::Homography { matrix } => {
                Self { kind: Kind::Homography, matrix: Some(matrix), a: None, b: None }
            }
            MapFile::Affine { a, b } => lists(Kind::Affine, &a, &b),
            MapFile::Bilinear { a, b } => lists(Kind::Bilinear, &a, &b),
            MapFile::Quadratic { a, b } => lists(Kind::Quadratic, &a, &b),
            MapFile::Cubic { a, b } => lists(Kind::Cubic, &a, &b),
        }
    }
}
