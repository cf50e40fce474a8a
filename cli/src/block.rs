//! Blocks of photographs out of other programs' files, and back.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use anyhow::{Result, anyhow, bail};
use collinear::adjust::bundle::{Adjusted, Bundle, CameraId, ImageId};
use collinear::camera::{Brown, BrownCamera, EvenRadial};
use collinear::nalgebra::{Matrix3, Point2, Rotation3};
use collinear::{Frame, InteriorOrientation};
use collinear_io::bal::{Bal, BalCamera, Camera as BalFileCamera, Observation};
use collinear_io::camera::CameraFile;
use collinear_io::colmap::Encoding;
use collinear_io::opensfm::Observation as Track;
use collinear_io::{bundler, colmap, opensfm};

use crate::draft::Draft;
use crate::given::{Given, Known};
use crate::resect::Estimated;

/// A file with photographs, points and what was measured of them.
#[derive(Clone, Debug)]
pub enum BlockFile {
    /// A problem of *Bundle Adjustment in the Large*.
    Bal(Bal),
    /// Bundler's `bundle.out`.
    Bundler(bundler::Bundle),
    /// COLMAP's folder.
    Colmap(Box<colmap::Reconstruction>, Encoding),
    /// OpenSfM's reconstruction with its tracks.
    OpenSfm(Box<opensfm::Reconstruction>, Vec<Track>),
}

/// A block ready for adjustment, with the names of its parts.
#[derive(Debug)]
pub struct Block {
    /// The block.
    pub bundle: Bundle<BrownCamera>,
    /// The photographs' names.
    pub photographs: Vec<String>,
    /// For each photograph its number and that of its camera in the block.
    pub images: Vec<(ImageId, CameraId)>,
    /// The cameras' names.
    pub cameras: Vec<String>,
    /// Width and height of the cameras' pictures, where the file says them.
    pub sizes: Vec<Option<[u32; 2]>>,
    /// The points' names.
    pub points: Vec<String>,
    /// For each observation the place of its photograph, of its point, and the image point, pixels.
    pub observations: Vec<(usize, usize, Point2<f64>)>,
    /// The photographs that were left out: they stay as they are.
    pub idle: Vec<Idle>,
    /// How many of the observations, the last ones, are of clicked points.
    pub clicks: usize,
    /// What was given besides image points.
    pub known: Known,
    /// For each photograph of the file its place in the block.
    pub(crate) places: Vec<Option<usize>>,
}

/// A photograph with too few image points to find its pose.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Idle {
    /// Its name.
    pub name: String,
    /// How many of its image points could take part: of points that lie before it and that another photograph shows too.
    pub image_points: usize,
}

impl BlockFile {
    /// Reads a block: COLMAP's folder, OpenSfM's reconstruction with its tracks, Bundler's file, or a problem of BAL, plain or
    /// gzip. The content says which.
    ///
    /// # Errors
    /// Those of the format it is; an OpenSfM reconstruction without tracks.
    pub fn read(path: &Path, tracks: Option<&Path>) -> Result<Self> {
        if path.is_dir() {
            let binary = path.join("cameras.bin").exists();
            let encoding = if binary { Encoding::Binary } else { Encoding::Text };
            return Ok(Self::Colmap(Box::new(colmap::Reconstruction::read(path)?), encoding));
        }
        let mut start = [0; 64];
        let read = std::fs::File::open(path)
            .and_then(|mut f| std::io::Read::read(&mut f, &mut start))
            .map_err(|e| anyhow!("{}: cannot be read: {e}", path.display()))?;
        let start = start[..read].trim_ascii_start();
        if start.starts_with(b"[") {
            let Some(tracks) = tracks else {
                bail!("{}: is OpenSfM's: give its tracks (--tracks)", path.display());
            };
            let model = opensfm::read_reconstruction(path, 0)?;
            return Ok(Self::OpenSfm(Box::new(model), opensfm::read_tracks(tracks)?));
        }
        if start.starts_with(b"# Bundle file") {
            return Ok(Self::Bundler(bundler::Bundle::read(path)?));
        }
        Ok(Self::Bal(Bal::read(path)?))
    }

    /// What is estimated beside poses and points where the user does not say it: as the format's own program does.
    #[must_use]
    pub fn usually_estimated(&self) -> Vec<Estimated> {
        match self {
            Self::Bal(_) | Self::Bundler(_) => {
                vec![Estimated::PrincipalDistance, Estimated::Radial(0), Estimated::Radial(1)]
            }
            Self::Colmap(..) | Self::OpenSfm(..) => vec![],
        }
    }

    /// The block, every image point with the same standard deviation unless a click states its own, with what was given besides: the
    /// block is brought to the frame of that unless it is in place. Photographs with fewer than three image points that can take
    /// part are left out; with `formula` points behind their cameras can.
    ///
    /// # Errors
    /// A camera that is neither a pinhole nor Brown's; numbers that are none; no photograph that can take part. Of what was given:
    /// photographs and points that are not there or there twice; fewer than three points or positions to place the block by.
    pub fn block(
        &self,
        estimate: &[Estimated],
        sigma: f64,
        formula: bool,
        given: &Given,
    ) -> Result<Block> {
        let bare = |e: &Estimated| {
            matches!(e, Estimated::PrincipalDistance | Estimated::Radial(0) | Estimated::Radial(1))
        };
        if matches!(self, Self::Bal(_) | Self::Bundler(_)) && !estimate.iter().all(bare) {
            bail!(
                "has cameras of f, k1 and k2 only: of what --estimate says it can hold distance, k1, k2"
            );
        }
        let mut draft = Draft::new(estimate.iter().flat_map(|e| e.unknowns(0)).collect(), sigma);
        match self {
            Self::Bal(bal) => add_bal(&mut draft, bal)?,
            Self::Bundler(bundle) => add_bal(&mut draft, &bal_of(bundle)?)?,
            Self::Colmap(model, _) => add_colmap(&mut draft, model)?,
            Self::OpenSfm(model, tracks) => add_opensfm(&mut draft, model, tracks)?,
        }
        draft.give(given)?;
        draft.block(formula)
    }

    /// The files with the adjusted numbers in the format they came in, not yet written: COLMAP's are three in a folder. Photographs that
    /// were left out are as they were, but for the camera that they share with others.
    ///
    /// # Errors
    /// A camera that the format cannot hold.
    pub fn adjusted(
        mut self,
        block: &Block,
        adjusted: &Adjusted<BrownCamera>,
        path: &Path,
    ) -> Result<Vec<(PathBuf, Vec<u8>)>> {
        let frames: Vec<Frame<BrownCamera>> = block.frames(adjusted)?;
        let points = adjusted.points();
        let place = |photograph: usize| block.places.get(photograph).copied().flatten();
        let frame = |photograph: usize| place(photograph).and_then(|p| frames.get(p));
        let text = match &mut self {
            Self::Bal(bal) => {
                for (i, to) in bal.cameras.iter_mut().enumerate() {
                    if let Some(frame) = frame(i) {
                        *to = bal_camera(frame)?;
                    }
                }
                for (to, point) in bal.points.iter_mut().zip(points) {
                    *to = (*point).into();
                }
                bal.to_text()
            }
            Self::Bundler(bundle) => {
                let registered = bundle.cameras.iter_mut().filter(|c| c.focal != 0.0);
                for (i, to) in registered.enumerate() {
                    let Some(frame) = frame(i) else { continue };
                    let from = bal_camera(frame)?;
                    let r = Rotation3::from_scaled_axis(from.rotation.into());
                    to.rotation = [0, 1, 2].map(|i| [0, 1, 2].map(|j| r[(i, j)]));
                    (to.translation, to.focal, to.k) = (from.translation, from.focal, from.k);
                }
                for (to, point) in bundle.points.iter_mut().zip(points) {
                    to.world = (*point).into();
                }
                bundle.to_text()
            }
            Self::Colmap(model, encoding) => {
                let files = colmap::Reconstruction::from_photographs(&block.files(&frames))?;
                let new: Vec<&colmap::Image> = files.images.values().collect();
                for (i, to) in model.images.values_mut().enumerate() {
                    let Some(from) = place(i).and_then(|p| new.get(p)) else { continue };
                    to.quaternion_wxyz = from.quaternion_wxyz;
                    to.translation = from.translation;
                    if let Some(camera) = files.cameras.get(&from.camera) {
                        let old = model.cameras.get(&to.camera);
                        let same = old.and_then(|old| camera.in_model(old.model));
                        model.cameras.insert(to.camera, same.unwrap_or_else(|| camera.clone()));
                    }
                }
                let errors = block.mean_errors(adjusted);
                for ((to, point), error) in model.points.values_mut().zip(points).zip(errors) {
                    to.world = (*point).into();
                    to.error = error;
                }
                return Ok(model.files(path, *encoding)?);
            }
            Self::OpenSfm(model, _) => {
                let new = opensfm::Reconstruction::from_photographs(&block.files(&frames))?;
                for (name, to) in &mut model.shots {
                    let Some(from) = new.shots.get(name) else { continue };
                    to.rotation = from.rotation;
                    to.translation = from.translation;
                    if let Some(camera) = new.cameras.get(&from.camera) {
                        model.cameras.insert(to.camera.clone(), camera.clone());
                    }
                }
                for (to, point) in model.points.values_mut().zip(points) {
                    to.coordinates = (*point).into();
                }
                model.to_json().map_err(|e| e.in_file(path))?
            }
        };
        Ok(vec![(path.to_owned(), text.into_bytes())])
    }
}

fn add_bal(draft: &mut Draft, bal: &Bal) -> Result<()> {
    for (i, camera) in bal.cameras.iter().enumerate() {
        let named = |e: &dyn std::fmt::Display| anyhow!("camera {i}: {e}");
        let interior = InteriorOrientation::new([camera.focal; 2], Point2::origin(), 0.0);
        let [k1, k2] = camera.k;
        let lens = Brown::new([k1, k2, 0.0], [0.0; 2]).map_err(|e| named(&e))?;
        let model = BrownCamera::new(interior.map_err(|e| named(&e))?, lens);
        let id = draft.add_camera(i.to_string(), model, None);
        draft.add_photograph(i.to_string(), camera.exterior().map_err(|e| named(&e))?, id);
    }
    for (i, point) in bal.points.iter().enumerate() {
        draft.add_point(i.to_string(), *point);
    }
    for seen in &bal.observations {
        draft.observe(seen.camera as usize, seen.point as usize, seen.pixel().into(), None);
    }
    Ok(())
}

fn add_colmap(draft: &mut Draft, model: &colmap::Reconstruction) -> Result<()> {
    let mut cameras = BTreeMap::new();
    let mut points = BTreeMap::new();
    for (id, point) in &model.points {
        points.insert(*id, draft.add_point(id.to_string(), point.world));
    }
    for ((name, file), image) in model.photographs()?.iter().zip(model.images.values()) {
        let camera = match cameras.get(&image.camera) {
            Some(camera) => *camera,
            None => {
                let camera = draft.add_camera_file(image.camera.to_string(), file)?;
                cameras.insert(image.camera, camera);
                camera
            }
        };
        let exterior = file.exterior.orientation()?;
        let photograph = draft.add_photograph(name.clone(), exterior, camera);
        for seen in &image.observations {
            if let Some(&point) = seen.point.and_then(|id| points.get(&id)) {
                draft.observe(photograph, point, seen.image, None);
            }
        }
    }
    Ok(())
}

fn add_opensfm(draft: &mut Draft, model: &opensfm::Reconstruction, tracks: &[Track]) -> Result<()> {
    let mut cameras = BTreeMap::new();
    let mut photographs = BTreeMap::new();
    let mut points = BTreeMap::new();
    for (id, point) in &model.points {
        points.insert(id.as_str(), draft.add_point(id.clone(), point.coordinates));
    }
    for (name, shot) in &model.shots {
        let file = model.camera(name)?;
        let camera = match cameras.get(&shot.camera) {
            Some(camera) => *camera,
            None => {
                let camera = draft.add_camera_file(shot.camera.clone(), &file)?;
                cameras.insert(shot.camera.clone(), camera);
                camera
            }
        };
        let exterior = file.exterior.orientation()?;
        let photograph = draft.add_photograph(name.clone(), exterior, camera);
        photographs.insert(name.as_str(), (photograph, [file.width, file.height]));
    }
    for track in tracks {
        let seen = photographs.get(track.image.as_str());
        let point = points.get(track.track.as_str());
        if let (Some(&(photograph, [w, h])), Some(&point)) = (seen, point) {
            draft.observe(photograph, point, track.pixel(w, h), None);
        }
    }
    Ok(())
}

/// Bundler's model is BAL's; photographs that were not registered, whose f is 0, are left out.
fn bal_of(bundle: &bundler::Bundle) -> Result<Bal> {
    let mut bal = Bal::default();
    let mut places = vec![None; bundle.cameras.len()];
    for (place, camera) in places.iter_mut().zip(&bundle.cameras).filter(|(_, c)| c.focal != 0.0) {
        *place = Some(u32::try_from(bal.cameras.len())?);
        let matrix = Matrix3::from_fn(|i, j| camera.rotation[i][j]);
        let rotation = collinear::geometry::rotation::orthonormalised(&matrix)?;
        bal.cameras.push(BalFileCamera {
            rotation: rotation.scaled_axis().into(),
            translation: camera.translation,
            focal: camera.focal,
            k: camera.k,
        });
    }
    for (i, point) in bundle.points.iter().enumerate() {
        bal.points.push(point.world);
        for view in &point.views {
            if let Some(camera) = places.get(view.camera).copied().flatten() {
                bal.observations.push(Observation {
                    camera,
                    point: u32::try_from(i)?,
                    image: view.image,
                });
            }
        }
    }
    Ok(bal)
}

fn bal_camera(frame: &Frame<BrownCamera>) -> Result<BalFileCamera> {
    let (interior, lens) = (frame.camera.interior(), frame.camera.distortion());
    let [k1, k2, _] = lens.radial();
    let lens = EvenRadial::new([k1, k2, 0.0, 0.0])?;
    let camera = BalCamera::from_parts(*interior, collinear::camera::Gnomonic, lens);
    Ok(BalFileCamera::from_parts(&frame.exterior, &camera)?)
}

impl Block {
    /// The adjusted photographs.
    fn frames(&self, adjusted: &Adjusted<BrownCamera>) -> Result<Vec<Frame<BrownCamera>>> {
        self.images
            .iter()
            .map(|(image, camera)| {
                let exterior = adjusted.exterior(*image).ok_or_else(|| anyhow!("no photograph"))?;
                let camera = adjusted.camera(*camera).ok_or_else(|| anyhow!("no camera"))?;
                Ok(Frame::new(*exterior, *camera))
            })
            .collect()
    }

    /// The adjusted photographs as camera files.
    fn files(&self, frames: &[Frame<BrownCamera>]) -> Vec<(String, CameraFile)> {
        let sizes = self.images.iter().map(|(_, camera)| self.sizes[camera.number()]);
        let named = self.photographs.iter().zip(frames).zip(sizes);
        named
            .map(|((name, frame), size)| {
                let [width, height] = size.unwrap_or([1, 1]);
                (name.clone(), CameraFile::from_frame(frame, width, height))
            })
            .collect()
    }

    /// The mean distance in the image of each point's observations that have one, pixels.
    fn mean_errors(&self, adjusted: &Adjusted<BrownCamera>) -> Vec<f64> {
        let mut sums = vec![(0.0, 0u32); self.points.len()];
        for (i, (_, point, _)) in self.observations.iter().enumerate() {
            let rule = collinear::adjust::bundle::OutsideRule::Exclude;
            if let Ok([x, y]) = self.bundle.residual(adjusted, i, rule) {
                let (sum, count) = sums[*point];
                sums[*point] = (sum + x.hypot(y), count + 1);
            }
        }
        sums.into_iter().map(|(s, n)| if n > 0 { s / f64::from(n) } else { 0.0 }).collect()
    }
}
