//! Scene files: photographs with their cameras, polygons, and the view to make.

mod polygon;

use std::collections::HashMap;
use std::fmt;
use std::path::{Path, PathBuf};

use serde::de::value::MapAccessDeserializer;
use serde::de::{
    self, Deserialize, DeserializeSeed, Deserializer, IntoDeserializer, MapAccess, Visitor,
};
use serde::ser::{SerializeMap, Serializer};
use serde::{Deserialize as DeriveDeserialize, Serialize};

pub use polygon::{Fill, Polygon, TexturePoint};

use crate::camera::CameraFile;
use crate::check::{in_range, norm};
use crate::error::{Error, FieldError, FieldProblem};
use crate::json::{Document, object};
use crate::sensor::SensorFile;

/// The near distance, where the file gives none, as a part of the distance to the farthest vertex.
const NEAR: f64 = 1e-6;

/// A scene as its file states it. Fields, units and defaults: `docs/formats.md`, "scene".
#[derive(Clone, Debug, PartialEq, Serialize, DeriveDeserialize)]
#[serde(deny_unknown_fields)]
pub struct SceneFile {
    /// The photographs that polygons may show.
    #[serde(default, skip_serializing_if = "Vec::is_empty", deserialize_with = "object::list")]
    pub photographs: Vec<Photograph>,
    /// The pictures that polygons may show by coordinates at their vertices.
    #[serde(default, skip_serializing_if = "Vec::is_empty", deserialize_with = "object::list")]
    pub textures: Vec<Texture>,
    /// What is to be seen.
    pub polygons: Vec<Polygon>,
    /// The camera of the picture to make, or the scanner.
    pub view: SensorSource,
    /// The colour where no polygon is: red, green, blue.
    #[serde(default)]
    pub background: [u8; 3],
    /// The depth, in world units along the view's axis, before which nothing is drawn; along the line of sight where the view
    /// is neither pinhole nor orthographic.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub near: Option<f64>,
    /// Which polygons are drawn, by the side that they show.
    #[serde(default)]
    pub cull: Cull,
    /// How a colour is taken from between pixels.
    #[serde(default)]
    pub filter: Filter,
    /// How texture coordinates go from vertex to vertex.
    #[serde(default)]
    pub interpolation: Interpolation,
}

/// A photograph and its camera.
#[derive(Clone, Debug, PartialEq, Serialize, DeriveDeserialize)]
#[serde(deny_unknown_fields)]
pub struct Photograph {
    /// Its name, by which polygons refer to it.
    pub name: String,
    /// The picture, relative to the scene file.
    pub image: PathBuf,
    /// Its camera or scanner.
    pub camera: SensorSource,
}

/// A picture to be laid on by texture coordinates.
#[derive(Clone, Debug, PartialEq, Serialize, DeriveDeserialize)]
#[serde(deny_unknown_fields)]
pub struct Texture {
    /// Its name, by which polygons refer to it.
    pub name: String,
    /// The picture, relative to the scene file.
    pub image: PathBuf,
    /// What is beyond its edge.
    #[serde(default)]
    pub border: Border,
}

/// A camera or a scanner, or the file that has it.
#[derive(Clone, Debug, PartialEq)]
pub enum SensorSource {
    /// The camera itself; the scanner under the key `scanner`, the rational polynomial camera under `rpc`.
    Inline(SensorFile),
    /// The file of one of them, relative to the scene file.
    File(PathBuf),
}

/// What is beyond the edge of a texture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, DeriveDeserialize)]
#[serde(rename_all = "lowercase")]
pub enum Border {
    /// The colour at the edge.
    #[default]
    Clamp,
    /// The texture again.
    Repeat,
    /// The texture again, every other time mirrored.
    Mirror,
    /// Nothing: what lies behind is seen.
    Transparent,
}

/// Which polygons are drawn, by the side that they show.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, DeriveDeserialize)]
#[serde(rename_all = "lowercase")]
pub enum Cull {
    /// Both sides.
    #[default]
    None,
    /// The front alone, whose vertices go counter-clockwise as seen.
    Back,
}

/// How a colour is taken from between pixels.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, DeriveDeserialize)]
#[serde(rename_all = "lowercase")]
pub enum Filter {
    /// The pixel that the point lies in.
    Nearest,
    /// The four pixels around the point, by distance.
    #[default]
    Bilinear,
}

/// How texture coordinates go from vertex to vertex.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, DeriveDeserialize)]
#[serde(rename_all = "lowercase")]
pub enum Interpolation {
    /// As perspective has it: hyperbolically along a line.
    #[default]
    Perspective,
    /// Linearly on the screen, triangle by triangle: wrong, to be seen.
    Linear,
    /// Bilinearly on the screen over a quadrilateral: wrong, to be seen.
    Bilinear,
}

impl Document for SceneFile {
    const KIND: &'static str = "scene";
    const VERSION: u64 = 1;

    fn check(&self) -> Result<(), FieldError> {
        let mut photographs = Names::new("photographs");
        for (i, p) in self.photographs.iter().enumerate() {
            photographs.add(i, &p.name)?;
            p.camera.check().map_err(|e| e.under(&format!("photographs[{i}].camera")))?;
        }
        let mut textures = Names::new("textures");
        for (i, t) in self.textures.iter().enumerate() {
            textures.add(i, &t.name)?;
        }
        let mut polygons = Names::new("polygons");
        for (i, p) in self.polygons.iter().enumerate() {
            let under = |e: FieldError| e.under(&format!("polygons[{i}]"));
            if let Some(name) = &p.name {
                polygons.add(i, name)?;
            }
            p.check().map_err(under)?;
            match &p.fill {
                Fill::Photograph(name) => {
                    photographs.find("a photograph", "photograph", name).map_err(under)?;
                }
                Fill::Texture { name, .. } => {
                    textures.find("a texture", "texture", name).map_err(under)?;
                }
                Fill::Color(_) => {}
            }
        }
        self.view.check().map_err(|e| e.under("view"))?;
        self.near.map_or(Ok(()), |n| in_range("near", n, "a finite number above 0", |v| v > 0.0))
    }
}

impl SceneFile {
    /// Reads a scene and every camera file it names; its pictures' paths then start from the working folder.
    ///
    /// # Errors
    /// As [`Document::read`], for the scene or for the first bad camera file, which the error names with the field that
    /// names it.
    pub fn open(path: &Path) -> Result<Self, Error> {
        let folder = path.parent().unwrap_or(Path::new(""));
        Self::read(path)?.resolved(folder).map_err(|e| e.in_file(path))
    }

    /// The same scene with every path joined to the scene file's folder, and every camera file read.
    ///
    /// # Errors
    /// That of the first camera file that cannot be read; its path and the field that names it are in the error.
    pub fn resolved(&self, folder: &Path) -> Result<Self, Error> {
        let mut scene = self.clone();
        for (i, photograph) in scene.photographs.iter_mut().enumerate() {
            photograph.image = folder.join(&photograph.image);
            let field = || format!("photographs[{i}].camera");
            photograph.camera.resolve(folder).map_err(|e| e.named_by(field()))?;
        }
        for texture in &mut scene.textures {
            texture.image = folder.join(&texture.image);
        }
        scene.view.resolve(folder).map_err(|e| e.named_by("view"))?;
        scene.check()?;
        Ok(scene)
    }

    /// The files that the scene names, each with its field: pictures and camera files, their paths joined to the scene
    /// file's folder. Cameras that [`resolved`](Self::resolved) has read are not among them.
    ///
    /// ```
    /// use collinear_io::Document;
    /// use collinear_io::scene::SceneFile;
    /// use std::path::Path;
    ///
    /// let scene = SceneFile::parse(r#"{ "collinear": "scene", "version": 1, "view": "view.json", "polygons": [],
    ///     "textures": [{ "name": "brick", "image": "brick.png" }] }"#)?;
    /// let files = scene.files(Path::new("town"));
    /// let [(brick, _), (view, path)] = &files[..] else { panic!("{files:?}") };
    /// assert_eq!((brick.as_str(), view.as_str()), ("textures[0].image", "view"));
    /// assert_eq!(path, Path::new("town/view.json"));
    /// # Ok::<(), collinear_io::Error>(())
    /// ```
    #[must_use]
    pub fn files(&self, folder: &Path) -> Vec<(String, PathBuf)> {
        let mut files = Vec::new();
        for (i, photograph) in self.photographs.iter().enumerate() {
            files.push((format!("photographs[{i}].image"), folder.join(&photograph.image)));
            if let SensorSource::File(path) = &photograph.camera {
                files.push((format!("photographs[{i}].camera"), folder.join(path)));
            }
        }
        for (i, texture) in self.textures.iter().enumerate() {
            files.push((format!("textures[{i}].image"), folder.join(&texture.image)));
        }
        if let SensorSource::File(path) = &self.view {
            files.push(("view".into(), folder.join(path)));
        }
        files
    }

    /// The near distance: the file's, or 10⁻⁶ of the distance from the eye to the farthest vertex.
    #[must_use]
    pub fn near_distance(&self, eye: &[f64; 3]) -> f64 {
        if let Some(near) = self.near {
            return near;
        }
        let distance = |v: &[f64; 3]| norm(&[v[0] - eye[0], v[1] - eye[1], v[2] - eye[2]]);
        let farthest =
            self.polygons.iter().flat_map(|p| &p.vertices).map(distance).fold(0.0, f64::max);
        // All vertices in the eye: nothing will be drawn, and any positive distance says so.
        let near = if farthest > 0.0 { NEAR * farthest.min(f64::MAX) } else { NEAR };
        // A subnormal distance has no millionth.
        near.max(f64::MIN_POSITIVE)
    }
}

impl SensorSource {
    /// The camera or scanner, read from its file where it stands in one.
    ///
    /// # Errors
    /// That of the file.
    pub fn sensor(&self, folder: &Path) -> Result<SensorFile, Error> {
        match self {
            Self::Inline(sensor) => Ok(sensor.clone()),
            Self::File(path) => SensorFile::read(&folder.join(path)),
        }
    }

    fn resolve(&mut self, folder: &Path) -> Result<(), Error> {
        *self = Self::Inline(self.sensor(folder)?);
        Ok(())
    }

    fn check(&self) -> Result<(), FieldError> {
        match self {
            Self::Inline(SensorFile::Camera(camera)) => camera.check(),
            Self::Inline(SensorFile::Scanner(scanner)) => {
                scanner.check().map_err(|e| e.under(SCANNER))
            }
            Self::Inline(SensorFile::Rpc(rpc)) => {
                rpc.check().and_then(|()| rpc.size().map(|_| ())).map_err(|e| e.under(RPC))
            }
            Self::File(_) => Ok(()),
        }
    }
}

/// The keys of a scanner and of a rational polynomial camera that stand where a camera may.
const SCANNER: &str = "scanner";
const RPC: &str = "rpc";

impl Serialize for SensorSource {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::Inline(SensorFile::Camera(camera)) => camera.serialize(serializer),
            Self::Inline(SensorFile::Scanner(scanner)) => under(serializer, SCANNER, scanner),
            Self::Inline(SensorFile::Rpc(rpc)) => under(serializer, RPC, rpc),
            Self::File(path) => path.serialize(serializer),
        }
    }
}

/// An object with one key.
fn under<S: Serializer>(
    serializer: S,
    key: &'static str,
    value: &impl Serialize,
) -> Result<S::Ok, S::Error> {
    let mut map = serializer.serialize_map(Some(1))?;
    map.serialize_entry(key, value)?;
    map.end()
}

// By hand, since an untagged enum forgets where in the file an error is.
impl<'de> Deserialize<'de> for SensorSource {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Source;

        impl<'de> Visitor<'de> for Source {
            type Value = SensorSource;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a camera or the path of a camera file")
            }

            fn visit_str<E: de::Error>(self, path: &str) -> Result<SensorSource, E> {
                Ok(SensorSource::File(path.into()))
            }

            fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<SensorSource, A::Error> {
                let first: Option<String> = map.next_key()?;
                let sensor = match first.as_deref() {
                    Some(SCANNER) => SensorFile::Scanner(map.next_value()?),
                    Some(RPC) => SensorFile::Rpc(map.next_value()?),
                    _ => {
                        let whole = MapAccessDeserializer::new(WithFirst { first, map });
                        let camera = CameraFile::deserialize(whole)?;
                        return Ok(SensorSource::Inline(SensorFile::Camera(camera)));
                    }
                };
                match map.next_key::<String>()? {
                    None => Ok(SensorSource::Inline(sensor)),
                    Some(key) => Err(de::Error::unknown_field(&key, &[SCANNER, RPC])),
                }
            }
        }

        deserializer.deserialize_any(Source)
    }
}

/// The entries of a map whose first key has been read.
struct WithFirst<A> {
    first: Option<String>,
    map: A,
}

impl<'de, A: MapAccess<'de>> MapAccess<'de> for WithFirst<A> {
    type Error = A::Error;

    fn next_key_seed<K: DeserializeSeed<'de>>(
        &mut self,
        seed: K,
    ) -> Result<Option<K::Value>, A::Error> {
        match self.first.take() {
            Some(key) => seed.deserialize(key.into_deserializer()).map(Some),
            None => self.map.next_key_seed(seed),
        }
    }

    fn next_value_seed<V: DeserializeSeed<'de>>(&mut self, seed: V) -> Result<V::Value, A::Error> {
        self.map.next_value_seed(seed)
    }
}

/// The names of one list, and where each stands.
struct Names<'a> {
    list: &'static str,
    seen: HashMap<&'a str, usize>,
    order: Vec<&'a str>,
}

impl<'a> Names<'a> {
    fn new(list: &'static str) -> Self {
        Self { list, seen: HashMap::new(), order: Vec::new() }
    }

    fn add(&mut self, index: usize, name: &'a str) -> Result<(), FieldError> {
        self.order.push(name);
        match self.seen.insert(name, index) {
            None => Ok(()),
            Some(first) => Err(FieldError::new(
                format!("{}[{index}].name", self.list),
                FieldProblem::DuplicateName {
                    name: name.to_owned(),
                    first: format!("{}[{first}].name", self.list),
                },
            )),
        }
    }

    fn find(&self, what: &'static str, field: &str, name: &str) -> Result<(), FieldError> {
        if self.seen.contains_key(name) {
            return Ok(());
        }
        let known = self.order.iter().map(|n| (*n).to_owned()).collect();
        Err(FieldError::new(
            field,
            FieldProblem::UnknownName { what, name: name.to_owned(), known },
        ))
    }
}
