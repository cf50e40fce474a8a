//! What a file says of a block, before it is known which photographs can take part.

use anyhow::{Result, anyhow};
use collinear::adjust::bundle::{Bundle, CameraId};
use collinear::adjust::{Precision, Unknown};
use collinear::camera::BrownCamera;
use collinear::nalgebra::{Point2, Point3};
use collinear::{ExteriorOrientation, Frame, SensorModel};
use collinear_io::camera::CameraFile;

use crate::block::{Block, Idle};
use crate::reason::reason;

/// A photograph's six unknowns need three image points.
const NEEDED: usize = 3;

/// A block as its file has it.
#[derive(Debug)]
pub(crate) struct Draft {
    pub(crate) unknowns: Vec<Unknown>,
    pub(crate) sigma: f64,
    cameras: Vec<(String, BrownCamera, Option<[u32; 2]>)>,
    photographs: Vec<(String, ExteriorOrientation, usize)>,
    points: Vec<(String, Point3<f64>)>,
    observations: Vec<(usize, usize, Point2<f64>)>,
}

impl Draft {
    pub(crate) fn new(unknowns: Vec<Unknown>, sigma: f64) -> Self {
        Self {
            unknowns,
            sigma,
            cameras: vec![],
            photographs: vec![],
            points: vec![],
            observations: vec![],
        }
    }

    /// The size of the picture is told where the file says it.
    pub(crate) fn add_camera(
        &mut self,
        name: String,
        camera: BrownCamera,
        size: Option<[u32; 2]>,
    ) -> usize {
        self.cameras.push((name, camera, size));
        self.cameras.len() - 1
    }

    pub(crate) fn add_camera_file(&mut self, name: String, file: &CameraFile) -> Result<usize> {
        let camera = file.frame().map_err(|e| anyhow!("camera {name}: {e}"))?.camera;
        Ok(self.add_camera(name, camera, Some([file.width, file.height])))
    }

    pub(crate) fn add_photograph(
        &mut self,
        name: String,
        exterior: ExteriorOrientation,
        camera: usize,
    ) -> usize {
        self.photographs.push((name, exterior, camera));
        self.photographs.len() - 1
    }

    pub(crate) fn add_point(&mut self, name: String, place: [f64; 3]) -> usize {
        self.points.push((name, Point3::from(place)));
        self.points.len() - 1
    }

    pub(crate) fn observe(&mut self, photograph: usize, point: usize, image: [f64; 2]) {
        self.observations.push((photograph, point, Point2::from(image)));
    }

    /// For each photograph how many of its image points can take part, and whether they are enough. A photograph that is left
    /// out may leave a point with one ray, which then takes no part in another.
    fn usable(&self, formula: bool) -> Vec<(usize, bool)> {
        let imaged: Vec<bool> = self
            .observations
            .iter()
            .map(|(photograph, point, _)| {
                let (_, exterior, camera) = &self.photographs[*photograph];
                let frame = Frame::new(*exterior, self.cameras[*camera].1);
                formula || frame.project(&self.points[*point].1).is_ok()
            })
            .collect();
        let mut usable = vec![(0, true); self.photographs.len()];
        loop {
            let taken = |i: &usize| imaged[*i] && usable[self.observations[*i].0].1;
            let taken: Vec<usize> = (0..imaged.len()).filter(taken).collect();
            let mut rays = vec![0_u32; self.points.len()];
            for i in &taken {
                rays[self.observations[*i].1] += 1;
            }
            for (count, _) in usable.iter_mut().filter(|(_, enough)| *enough) {
                *count = 0;
            }
            for i in taken {
                let (photograph, point, _) = self.observations[i];
                usable[photograph].0 += usize::from(rays[point] > 1);
            }
            let mut fewer = false;
            for (count, enough) in &mut usable {
                let dropped = *enough && *count < NEEDED;
                fewer |= dropped;
                *enough &= !dropped;
            }
            if !fewer {
                return usable;
            }
        }
    }

    /// The block of the photographs that can take part.
    pub(crate) fn block(self, formula: bool) -> Result<Block> {
        let usable = self.usable(formula);
        let mut block = Block {
            bundle: Bundle::new(),
            photographs: vec![],
            images: vec![],
            cameras: vec![],
            sizes: vec![],
            points: vec![],
            observations: vec![],
            idle: vec![],
            places: vec![],
        };
        let mut ids: Vec<Option<CameraId>> = vec![None; self.cameras.len()];
        for ((name, exterior, camera), (count, enough)) in self.photographs.into_iter().zip(usable)
        {
            if !enough {
                block.idle.push(Idle { name, image_points: count });
                block.places.push(None);
                continue;
            }
            let id = if let Some(id) = ids[camera] {
                id
            } else {
                let (name, model, size) = &self.cameras[camera];
                let added = block.bundle.add_camera(*model, &self.unknowns);
                let id = added.map_err(|e| anyhow!("camera {name}: {}", reason(&e)))?;
                block.cameras.push(name.clone());
                block.sizes.push(*size);
                *ids[camera].insert(id)
            };
            let added = block.bundle.add_image(exterior, id);
            let image = added.map_err(|e| anyhow!("photograph {name}: {}", reason(&e)))?;
            block.places.push(Some(block.images.len()));
            block.photographs.push(name);
            block.images.push((image, id));
        }
        if block.images.is_empty() {
            let most = block.idle.iter().max_by_key(|idle| idle.image_points);
            let most = most.map_or(String::new(), |idle| {
                format!("; photograph {} has most, {}", idle.name, idle.image_points)
            });
            return Err(anyhow!(
                "no photograph has {NEEDED} image points of points that another shows too{most}"
            ));
        }
        let mut points = Vec::with_capacity(self.points.len());
        for (name, place) in self.points {
            let added = block.bundle.add_point(place);
            points.push(added.map_err(|e| anyhow!("point {name}: {}", reason(&e)))?);
            block.points.push(name);
        }
        let precision = Precision::Sigma(self.sigma);
        for (photograph, point, at) in self.observations {
            let Some(place) = block.places[photograph] else { continue };
            let added = block.bundle.observe(block.images[place].0, points[point], at, precision);
            added.map_err(|e| {
                let (photograph, point) = (&block.photographs[place], &block.points[point]);
                anyhow!("point {point} in photograph {photograph}: {}", reason(&e))
            })?;
            block.observations.push((place, point, at));
        }
        Ok(block)
    }
}
