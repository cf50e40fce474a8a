//! The polygons of a scene.

use std::fmt;

use serde::de::{self, Deserialize, Deserializer, SeqAccess, Visitor};
use serde::ser::{Serialize, Serializer};
use serde::{Deserialize as DeriveDeserialize, Serialize as DeriveSerialize};

use crate::check::{finite, in_range};
use crate::error::{FieldError, FieldProblem};
use crate::json::object::Object;

/// A plane polygon of the world and what is on it.
#[derive(Clone, Debug, PartialEq, DeriveSerialize, DeriveDeserialize)]
#[serde(try_from = "Object<RawPolygon>", into = "RawPolygon")]
pub struct Polygon {
    /// Its name, for people and for messages.
    pub name: Option<String>,
    /// Its corners in order, world coordinates; at least three.
    pub vertices: Vec<[f64; 3]>,
    /// What is on it.
    pub fill: Fill,
}

/// What is on a polygon.
#[derive(Clone, Debug, PartialEq)]
pub enum Fill {
    /// The photograph of this name, projected from its camera.
    Photograph(String),
    /// A texture, by coordinates at the vertices.
    Texture {
        /// The texture's name.
        name: String,
        /// One for each vertex.
        coordinates: Vec<TexturePoint>,
    },
    /// One colour: red, green, blue.
    Color([u8; 3]),
}

/// A point of a texture, (u, v) pixels from its top-left corner, and its weight: (w u, w v, w) is affine over the polygon.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TexturePoint {
    /// Pixels to the right.
    pub u: f64,
    /// Pixels down.
    pub v: f64,
    /// The weight, above 0, as the depth from the projector of a projected texture; 1 where the file gives two numbers.
    pub w: f64,
}

impl Polygon {
    pub(super) fn check(&self) -> Result<(), FieldError> {
        const CORNERS: usize = 3;
        let (found, needed) = (self.vertices.len(), CORNERS);
        if found < needed {
            return Err(FieldError::new("vertices", FieldProblem::TooFew { found, needed }));
        }
        for (i, v) in self.vertices.iter().enumerate() {
            finite(&format!("vertices[{i}]"), v)?;
        }
        if let Fill::Texture { coordinates, .. } = &self.fill {
            if coordinates.len() != found {
                let problem = FieldProblem::Count {
                    found: coordinates.len(),
                    expected: found,
                    of: "the vertices",
                };
                return Err(FieldError::new("coordinates", problem));
            }
            for (i, c) in coordinates.iter().enumerate() {
                finite(&format!("coordinates[{i}]"), &[c.u, c.v, c.w])?;
                let field = format!("coordinates[{i}][2]");
                in_range(&field, c.w, "a weight above 0", |w| w > 0.0)?;
            }
        }
        Ok(())
    }
}

#[derive(DeriveSerialize, DeriveDeserialize)]
#[serde(deny_unknown_fields)]
struct RawPolygon {
    #[serde(default, skip_serializing_if = "Option::is_none")]
    name: Option<String>,
    vertices: Vec<[f64; 3]>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    photograph: Option<String>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    texture: Option<String>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    coordinates: Option<Vec<TexturePoint>>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    color: Option<[u8; 3]>,
}

impl TryFrom<Object<RawPolygon>> for Polygon {
    type Error = String;

    fn try_from(Object(raw): Object<RawPolygon>) -> Result<Self, String> {
        let fill = match (raw.photograph, raw.texture, raw.color) {
            (Some(name), None, None) => Fill::Photograph(name),
            (None, Some(name), None) => {
                let coordinates = raw
                    .coordinates
                    .ok_or("has a `texture` and needs `coordinates`, one for each vertex")?;
                return Ok(Self {
                    name: raw.name,
                    vertices: raw.vertices,
                    fill: Fill::Texture { name, coordinates },
                });
            }
            (None, None, Some(color)) => Fill::Color(color),
            _ => return Err("give exactly one of `photograph`, `texture`, `color`".into()),
        };
        if raw.coordinates.is_some() {
            return Err("has `coordinates`, which only a `texture` uses".into());
        }
        Ok(Self { name: raw.name, vertices: raw.vertices, fill })
    }
}

impl From<Polygon> for RawPolygon {
    fn from(polygon: Polygon) -> Self {
        let mut raw = Self {
            name: polygon.name,
            vertices: polygon.vertices,
            photograph: None,
            texture: None,
            coordinates: None,
            color: None,
        };
        match polygon.fill {
            Fill::Photograph(name) => raw.photograph = Some(name),
            Fill::Texture { name, coordinates } => {
                raw.texture = Some(name);
                raw.coordinates = Some(coordinates);
            }
            Fill::Color(color) => raw.color = Some(color),
        }
        raw
    }
}

impl Serialize for TexturePoint {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        if self.w == 1.0 {
            [self.u, self.v].serialize(serializer)
        } else {
            [self.u, self.v, self.w].serialize(serializer)
        }
    }
}

impl<'de> Deserialize<'de> for TexturePoint {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct TwoOrThree;

        impl<'de> Visitor<'de> for TwoOrThree {
            type Value = TexturePoint;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a list of 2 or 3")
            }

            fn visit_seq<A: SeqAccess<'de>>(self, mut seq: A) -> Result<TexturePoint, A::Error> {
                let missing = |n| move || de::Error::invalid_length(n, &"a list of 2 or 3");
                let u = seq.next_element()?.ok_or_else(missing(0))?;
                let v = seq.next_element()?.ok_or_else(missing(1))?;
                let w = seq.next_element()?.unwrap_or(1.0);
                Ok(TexturePoint { u, v, w })
            }
        }

        deserializer.deserialize_seq(TwoOrThree)
    }
}
