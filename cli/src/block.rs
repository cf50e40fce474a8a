//! Blocks of photographs out of other programs' files, and back.

use std::path::Path;

use anyhow::{Result, anyhow, bail};
use collinear::adjust::bundle::{Adjusted, Bundle, CameraId, ImageId, PointId};
use collinear::adjust::{Precision, Unknown};
use collinear::camera::{Brown, BrownCamera, EvenRadial};
use collinear::nalgebra::{Matrix3, Point2, Point3, Rotation3};
use collinear::{ExteriorOrientation, Frame, InteriorOrientation};
use collinear_io::bal::{Bal, BalCamera, Camera as BalFileCamera, Observation};
use collinear_io::camera::CameraFile;
use collinear_io::colmap::Encoding;
use collinear_io::opensfm::Observation as Track;
use collinear_io::{bundler, colmap, opensfm};

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
    point_ids: Vec<PointId>,
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

    /// The block, every image point with the same standard deviation.
    ///
    /// # Errors
    /// A camera that is neither a pinhole nor Brown's; numbers that are none.
    pub fn block(&self, estimate: &[Estimated], sigma: f64) -> Result<Block> {
        let bare = |e: &Estimated| {
            matches!(e, Estimated::PrincipalDistance | Estimated::Radial(0) | Estimated::Radial(1))
        };
        if matches!(self, Self::Bal(_) | Self::Bundler(_)) && !estimate.iter().all(bare) {
            bail!(
                "has cameras of f, k1 and k2 only: of what --estimate says it can hold distance, k1, k2"
            );
        }
        let mut block = Block::new();
        let unknowns: Vec<Unknown> = estimate.iter().flat_map(|e| e.unknowns(0)).collect();
        match self {
            Self::Bal(bal) => block.add_bal(bal, &unknowns, sigma)?,
            Self::Bundler(bundle) => block.add_bal(&bal_of(bundle)?, &unknowns, sigma)?,
            Self::Colmap(model, _) => {
                let mut cameras = std::collections::BTreeMap::new();
                let mut points = std::collections::BTreeMap::new();
                for (id, point) in &model.points {
                    points.insert(*id, block.add_point(id.to_string(), point.world)?);
                }
                for ((name, file), image) in model.photographs()?.iter().zip(model.images.values())
                {
                    let camera = match cameras.get(&image.camera) {
                        Some(camera) => *camera,
                        None => {
                            let name = image.camera.to_string();
                            let camera = block.add_camera(name, file, &unknowns)?;
                            cameras.insert(image.camera, camera);
                            camera
                        }
                    };
                    let photograph = block.add_photograph(name.clone(), file, camera)?;
                    for seen in &image.observations {
                        let place = seen.point.and_then(|id| points.get(&id));
                        if let Some(&point) = place {
                            block.observe(photograph, point, seen.image, sigma)?;
                        }
                    }
                }
            }
            Self::OpenSfm(model, tracks) => {
                let mut cameras = std::collections::BTreeMap::new();
                let mut photographs = std::collections::BTreeMap::new();
                let mut points = std::collections::BTreeMap::new();
                for (id, point) in &model.points {
                    points.insert(id.as_str(), block.add_point(id.clone(), point.coordinates)?);
                }
                for (name, shot) in &model.shots {
                    let file = model.camera(name)?;
                    let camera = match cameras.get(&shot.camera) {
                        Some(camera) => *camera,
                        None => {
                            let camera = block.add_camera(shot.camera.clone(), &file, &unknowns)?;
                            cameras.insert(shot.camera.clone(), camera);
                            camera
                        }
                    };
                    let photograph = block.add_photograph(name.clone(), &file, camera)?;
                    photographs.insert(name.as_str(), (photograph, [file.width, file.height]));
                }
                for track in tracks {
                    let seen = photographs.get(track.image.as_str());
                    let point = points.get(track.track.as_str());
                    if let (Some(&(photograph, [w, h])), Some(&point)) = (seen, point) {
                        block.observe(photograph, point, track.pixel(w, h), sigma)?;
                    }
                }
            }
        }
        Ok(block)
    }

    /// Writes the block with its adjusted numbers in the format it came in; COLMAP's into a folder.
    ///
    /// # Errors
    /// A camera that the format cannot hold; those of writing.
    pub fn write(
        mut self,
        block: &Block,
        adjusted: &Adjusted<BrownCamera>,
        path: &Path,
    ) -> Result<()> {
        let frames: Vec<Frame<BrownCamera>> = block.frames(adjusted)?;
        let points = adjusted.points();
        match &mut self {
            Self::Bal(bal) => {
                for (to, frame) in bal.cameras.iter_mut().zip(&frames) {
                    *to = bal_camera(frame)?;
                }
                for (to, point) in bal.points.iter_mut().zip(points) {
                    *to = (*point).into();
                }
                bal.write(path)?;
            }
            Self::Bundler(bundle) => {
                let registered = bundle.cameras.iter_mut().filter(|c| c.focal != 0.0);
                for (to, frame) in registered.zip(&frames) {
                    let from = bal_camera(frame)?;
                    let r = Rotation3::from_scaled_axis(from.rotation.into());
                    to.rotation = [0, 1, 2].map(|i| [0, 1, 2].map(|j| r[(i, j)]));
                    (to.translation, to.focal, to.k) = (from.translation, from.focal, from.k);
                }
                for (to, point) in bundle.points.iter_mut().zip(points) {
                    to.world = (*point).into();
                }
                let text = bundle.to_text();
                collinear_io::write_atomically(path, |w| w.write_all(text.as_bytes()))?;
            }
            Self::Colmap(model, encoding) => {
                let files = block.files(&frames);
                let new = colmap::Reconstruction::from_photographs(&files)?;
                for (to, from) in model.images.values_mut().zip(new.images.values()) {
                    to.quaternion_wxyz = from.quaternion_wxyz;
                    to.translation = from.translation;
                    if let Some(camera) = new.cameras.get(&from.camera) {
                        model.cameras.insert(to.camera, camera.clone());
                    }
                }
                let errors = block.mean_errors(adjusted);
                for ((to, point), error) in model.points.values_mut().zip(points).zip(errors) {
                    to.world = (*point).into();
                    to.error = error;
                }
                model.write(path, *encoding)?;
            }
            Self::OpenSfm(model, _) => {
                let files = block.files(&frames);
                let new = opensfm::Reconstruction::from_photographs(&files)?;
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
                model.write(path)?;
            }
        }
        Ok(())
    }
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
    fn new() -> Self {
        Self {
            bundle: Bundle::new(),
            photographs: vec![],
            images: vec![],
            cameras: vec![],
            sizes: vec![],
            points: vec![],
            observations: vec![],
            point_ids: vec![],
        }
    }

    fn add_bal(&mut self, bal: &Bal, unknowns: &[Unknown], sigma: f64) -> Result<()> {
        for (i, camera) in bal.cameras.iter().enumerate() {
            let interior = InteriorOrientation::new([camera.focal; 2], Point2::origin(), 0.0)?;
            let [k1, k2] = camera.k;
            let model = BrownCamera::new(interior, Brown::new([k1, k2, 0.0], [0.0; 2])?);
            let id = self.bundle.add_camera(model, unknowns)?;
            self.cameras.push(i.to_string());
            self.sizes.push(None);
            self.add_image(i.to_string(), camera.exterior()?, id)?;
        }
        for (i, point) in bal.points.iter().enumerate() {
            self.add_point(i.to_string(), *point)?;
        }
        for seen in &bal.observations {
            let place = (seen.camera as usize, seen.point as usize);
            self.observe(place.0, place.1, seen.pixel().into(), sigma)?;
        }
        Ok(())
    }

    fn add_camera(
        &mut self,
        name: String,
        file: &CameraFile,
        unknowns: &[Unknown],
    ) -> Result<CameraId> {
        let camera = file.frame().map_err(|e| anyhow!("camera {name}: {e}"))?.camera;
        let id = self.bundle.add_camera(camera, unknowns)?;
        self.cameras.push(name);
        self.sizes.push(Some([file.width, file.height]));
        Ok(id)
    }

    fn add_photograph(
        &mut self,
        name: String,
        file: &CameraFile,
        camera: CameraId,
    ) -> Result<usize> {
        self.add_image(name, file.exterior.orientation()?, camera)
    }

    fn add_image(
        &mut self,
        name: String,
        exterior: ExteriorOrientation,
        camera: CameraId,
    ) -> Result<usize> {
        let id = self.bundle.add_image(exterior, camera)?;
        self.photographs.push(name);
        self.images.push((id, camera));
        Ok(self.photographs.len() - 1)
    }

    fn add_point(&mut self, name: String, place: [f64; 3]) -> Result<usize> {
        let id = self.bundle.add_point(Point3::from(place))?;
        self.points.push(name);
        self.point_ids.push(id);
        Ok(self.points.len() - 1)
    }

    fn observe(
        &mut self,
        photograph: usize,
        point: usize,
        image: [f64; 2],
        sigma: f64,
    ) -> Result<()> {
        let (image_id, point_id) = (self.images[photograph].0, self.point_ids[point]);
        let at = Point2::from(image);
        self.bundle.observe(image_id, point_id, at, Precision::Sigma(sigma))?;
        self.observations.push((photograph, point, at));
        Ok(())
    }

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
