//! The binary form: little-endian, without padding.

use collinear::camera::COLMAP_MODELS;

use super::{Camera, Image, Observation, Point, Reconstruction};
use crate::error::{BinaryProblem, Error};

/// The identifier of no point.
const NO_POINT: u64 = u64::MAX;

/// Bytes, read from the front.
struct Reader<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl<'a> Reader<'a> {
    fn take(&mut self, len: usize, what: &'static str) -> Result<&'a [u8], Error> {
        let cut_off = || BinaryProblem::CutOff { what, offset: self.at as u64 };
        let end = self.at.checked_add(len).ok_or_else(cut_off)?;
        let taken = self.bytes.get(self.at..end).ok_or_else(cut_off)?;
        self.at = end;
        Ok(taken)
    }

    fn array<const N: usize>(&mut self, what: &'static str) -> Result<[u8; N], Error> {
        let mut array = [0; N];
        array.copy_from_slice(self.take(N, what)?);
        Ok(array)
    }

    fn u32(&mut self, what: &'static str) -> Result<u32, Error> {
        self.array(what).map(u32::from_le_bytes)
    }

    fn u64(&mut self, what: &'static str) -> Result<u64, Error> {
        self.array(what).map(u64::from_le_bytes)
    }

    fn number(&mut self, what: &'static str) -> Result<f64, Error> {
        let offset = self.at as u64;
        let value = self.array(what).map(f64::from_le_bytes)?;
        if value.is_finite() {
            Ok(value)
        } else {
            Err(BinaryProblem::NotFinite { what, offset }.into())
        }
    }

    fn numbers<const N: usize>(&mut self, what: &'static str) -> Result<[f64; N], Error> {
        let mut values = [0.0; N];
        for value in &mut values {
            *value = self.number(what)?;
        }
        Ok(values)
    }

    /// A number of things of at least `size` bytes each, no more than the rest of the file can hold.
    fn count(&mut self, size: u64, what: &'static str) -> Result<u64, Error> {
        let offset = self.at as u64;
        let found = self.u64(what)?;
        let most = (self.bytes.len() - self.at) as u64 / size;
        if found > most {
            return Err(BinaryProblem::Value { what, offset, found }.into());
        }
        Ok(found)
    }

    /// A text up to its zero.
    fn text(&mut self, what: &'static str) -> Result<String, Error> {
        let rest = &self.bytes[self.at..];
        let offset = self.at as u64;
        let Some(len) = rest.iter().position(|b| *b == 0) else {
            return Err(BinaryProblem::CutOff { what, offset }.into());
        };
        let text = self.take(len + 1, what)?;
        match std::str::from_utf8(&text[..len]) {
            Ok(text) => Ok(text.to_owned()),
            Err(_) => Err(BinaryProblem::NotText { what, offset }.into()),
        }
    }

    fn end(&self) -> Result<(), Error> {
        let extra = (self.bytes.len() - self.at) as u64;
        if extra == 0 {
            return Ok(());
        }
        Err(BinaryProblem::Extra { bytes: extra, offset: self.at as u64 }.into())
    }
}

fn twice(what: &'static str, offset: usize, found: u64) -> Error {
    BinaryProblem::Value { what, offset: offset as u64, found }.into()
}

pub(super) fn cameras(bytes: &[u8], model: &mut Reconstruction) -> Result<(), Error> {
    let mut r = Reader { bytes, at: 0 };
    // The shortest camera is EQUIRECTANGULAR, which has two parameters.
    for _ in 0..r.count(40, "number of cameras")? {
        let start = r.at;
        let id = r.u32("camera's identifier")?;
        let offset = r.at as u64;
        let number = r.u32("camera's model")?;
        let Some((name, parameters)) = COLMAP_MODELS.get(number as usize) else {
            let found = u64::from(number);
            return Err(BinaryProblem::Value { what: "camera's model", offset, found }.into());
        };
        let mut side = || -> Result<u32, Error> {
            let (what, offset) = ("camera's picture size", r.at as u64);
            let found = r.u64(what)?;
            u32::try_from(found).map_err(|_| BinaryProblem::Value { what, offset, found }.into())
        };
        let (width, height) = (side()?, side()?);
        let parameters = parameters.iter().map(|_| r.number("camera's parameters"));
        let camera = Camera {
            model: name,
            width,
            height,
            parameters: parameters.collect::<Result<_, _>>()?,
        };
        if model.cameras.insert(id, camera).is_some() {
            return Err(twice("camera's identifier, which stands there twice,", start, id.into()));
        }
    }
    r.end()
}

pub(super) fn images(bytes: &[u8], model: &mut Reconstruction) -> Result<(), Error> {
    let mut r = Reader { bytes, at: 0 };
    for _ in 0..r.count(73, "number of images")? {
        let start = r.at;
        let id = r.u32("image's identifier")?;
        let quaternion_wxyz = r.numbers("image's quaternion")?;
        let translation = r.numbers("image's translation")?;
        let camera = r.u32("image's camera")?;
        let name = r.text("image's name")?;
        let count = r.count(24, "number of image points")?;
        let mut observations = Vec::with_capacity(count as usize);
        for _ in 0..count {
            let image = r.numbers("image point")?;
            let point = Some(r.u64("image point's identifier")?).filter(|id| *id != NO_POINT);
            observations.push(Observation { image, point });
        }
        let image = Image { name, camera, quaternion_wxyz, translation, observations };
        if model.images.insert(id, image).is_some() {
            return Err(twice("image's identifier, which stands there twice,", start, id.into()));
        }
    }
    r.end()
}

pub(super) fn points(bytes: &[u8], model: &mut Reconstruction) -> Result<(), Error> {
    if bytes.is_empty() {
        return Ok(());
    }
    let mut r = Reader { bytes, at: 0 };
    for _ in 0..r.count(51, "number of points")? {
        let start = r.at;
        let id = r.u64("point's identifier")?;
        let world = r.numbers("point's coordinates")?;
        let color = r.array("point's colour")?;
        let error = r.number("point's error")?;
        let count = r.count(8, "length of a track")?;
        let mut track = Vec::with_capacity(count as usize);
        for _ in 0..count {
            track.push((r.u32("track")?, r.u32("track")?));
        }
        if model.points.insert(id, Point { world, color, error, track }).is_some() {
            return Err(twice("point's identifier, which stands there twice,", start, id));
        }
    }
    r.end()
}

pub(super) fn write(model: &Reconstruction) -> [Vec<u8>; 3] {
    let counted = |n: usize| (n as u64).to_le_bytes().to_vec();
    let mut cameras = counted(model.cameras.len());
    for (id, c) in &model.cameras {
        let number =
            COLMAP_MODELS.iter().position(|(name, _)| *name == c.model).unwrap_or(0) as u32;
        cameras.extend(id.to_le_bytes());
        cameras.extend(number.to_le_bytes());
        [c.width, c.height].iter().for_each(|s| cameras.extend(u64::from(*s).to_le_bytes()));
        c.parameters.iter().for_each(|p| cameras.extend(p.to_le_bytes()));
    }
    let mut images = counted(model.images.len());
    for (id, image) in &model.images {
        images.extend(id.to_le_bytes());
        let pose = image.quaternion_wxyz.iter().chain(&image.translation);
        pose.for_each(|v| images.extend(v.to_le_bytes()));
        images.extend(image.camera.to_le_bytes());
        images.extend(image.name.as_bytes());
        images.push(0);
        images.extend((image.observations.len() as u64).to_le_bytes());
        for Observation { image: [x, y], point } in &image.observations {
            images.extend(x.to_le_bytes());
            images.extend(y.to_le_bytes());
            images.extend(point.unwrap_or(NO_POINT).to_le_bytes());
        }
    }
    let mut points = counted(model.points.len());
    for (id, point) in &model.points {
        points.extend(id.to_le_bytes());
        point.world.iter().for_each(|v| points.extend(v.to_le_bytes()));
        points.extend(point.color);
        points.extend(point.error.to_le_bytes());
        points.extend((point.track.len() as u64).to_le_bytes());
        for (image, index) in &point.track {
            points.extend(image.to_le_bytes());
            points.extend(index.to_le_bytes());
        }
    }
    [cameras, images, points]
}
