//! What a file says of a block, before it is known which photographs can take part.

use anyhow::{Result, anyhow};
use collinear::adjust::bundle::{Bundle, CameraId};
use collinear::adjust::{Precision, Unknown};
use collinear::camera::BrownCamera;
use collinear::nalgebra::{Point2, Point3, Rotation3};
use collinear::{ExteriorOrientation, Frame, SensorModel};
use collinear_io::camera::CameraFile;

use crate::block::{Block, Idle};
use crate::given::{Antenna, Known};
use crate::reason::reason;

/// A photograph's six unknowns need three image points.
const NEEDED: usize = 3;

/// A block as its file has it.
#[derive(Debug)]
pub(crate) struct Draft {
    pub(crate) unknowns: Vec<Unknown>,
    pub(crate) sigma: f64,
    pub(crate) cameras: Vec<(String, BrownCamera, Option<[u32; 2]>)>,
    pub(crate) photographs: Vec<(String, ExteriorOrientation, usize)>,
    pub(crate) points: Vec<(String, Point3<f64>, Kind)>,
    pub(crate) observations: Vec<Seen>,
    /// Observed positions and attitudes of photographs.
    pub(crate) positions: Vec<(usize, Antenna)>,
    pub(crate) attitudes: Vec<(usize, (Rotation3<f64>, Precision<3>))>,
    /// The points of the block's own file, before those that were clicked.
    pub(crate) own_points: usize,
    /// Of the distances of `known`.
    pub(crate) distance_sigmas: Vec<f64>,
    pub(crate) known: Known,
}

/// What is known of a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Kind {
    /// Nothing.
    Pass,
    /// Its place, with this precision.
    Control(Precision<3>),
    /// Its place, free of error.
    Exact,
}

/// An image point.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Seen {
    pub(crate) photograph: usize,
    pub(crate) point: usize,
    /// As measured, and with the corrections for air and the Earth's curvature.
    pub(crate) at: Point2<f64>,
    pub(crate) corrected: Point2<f64>,
    pub(crate) precision: Precision<2>,
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
            positions: vec![],
            attitudes: vec![],
            own_points: usize::MAX,
            distance_sigmas: vec![],
            known: Known::default(),
        }
    }

    /// The precision of an image point, of which a list may state the standard deviations.
    pub(crate) fn precision(&self, stated: Option<[f64; 2]>) -> Precision<2> {
        stated.map_or(Precision::Sigma(self.sigma), Precision::Sigmas)
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
        self.points.push((name, Point3::from(place), Kind::Pass));
        self.points.len() - 1
    }

    /// Adds an image point, with its standard deviations where they are stated.
    pub(crate) fn observe(
        &mut self,
        photograph: usize,
        point: usize,
        image: [f64; 2],
        sigma: Option<[f64; 2]>,
    ) {
        let (at, precision) = (Point2::from(image), self.precision(sigma));
        self.observations.push(Seen { photograph, point, at, corrected: at, precision });
    }

    /// For each photograph how many of its image points can take part, and whether they are enough. A photograph that is left
    /// out may leave a point with one ray, which then takes no part in another.
    pub(crate) fn usable(&self, formula: bool) -> Vec<(usize, bool)> {
        let imaged: Vec<bool> = self
            .observations
            .iter()
            .map(|seen| {
                let (_, exterior, camera) = &self.photographs[seen.photograph];
                let frame = Frame::new(*exterior, self.cameras[*camera].1);
                formula || frame.project(&self.points[seen.point].1).is_ok()
            })
            .collect();
        let mut usable = vec![(0, true); self.photographs.len()];
        loop {
            let taken = |i: &usize| imaged[*i] && usable[self.observations[*i].photograph].1;
            let taken: Vec<usize> = (0..imaged.len()).filter(taken).collect();
            let mut rays = vec![0_u32; self.points.len()];
            for i in &taken {
                rays[self.observations[*i].point] += 1;
            }
            for (count, _) in usable.iter_mut().filter(|(_, enough)| *enough) {
                *count = 0;
            }
            for i in taken {
                let Seen { photograph, point, .. } = self.observations[i];
                let enough = rays[point] > 1 || self.points[point].2 != Kind::Pass;
                usable[photograph].0 += usize::from(enough);
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
            clicks: 0,
            known: self.known,
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
        for (name, place, kind) in self.points {
            let added = match kind {
                Kind::Pass => block.bundle.add_point(place),
                Kind::Control(precision) => block.bundle.add_control(place, precision),
                Kind::Exact => block.bundle.add_fixed(place),
            };
            points.push(added.map_err(|e| anyhow!("point {name}: {}", reason(&e)))?);
            block.points.push(name);
        }
        for seen in self.observations {
            let Some(place) = block.places[seen.photograph] else { continue };
            let (image, point) = (block.images[place].0, points[seen.point]);
            let added = block.bundle.observe(image, point, seen.corrected, seen.precision);
            added.map_err(|e| {
                let (photograph, point) = (&block.photographs[place], &block.points[seen.point]);
                anyhow!("point {point} in photograph {photograph}: {}", reason(&e))
            })?;
            block.observations.push((place, seen.point, seen.at));
            block.clicks += usize::from(seen.point >= self.own_points);
        }
        for (photograph, (antenna, lever_arm, precision)) in self.positions {
            let Some(place) = block.places[photograph] else { continue };
            let image = block.images[place].0;
            let added = block.bundle.observe_position(image, antenna, lever_arm, precision);
            let name = &block.photographs[place];
            added.map_err(|e| anyhow!("--positions: photograph {name}: {}", reason(&e)))?;
            block.known.oriented = true;
        }
        for (photograph, (camera_from_world, precision)) in self.attitudes {
            let Some(place) = block.places[photograph] else { continue };
            let image = block.images[place].0;
            let added = block.bundle.observe_attitude(image, camera_from_world, precision);
            let name = &block.photographs[place];
            added.map_err(|e| anyhow!("--attitudes: photograph {name}: {}", reason(&e)))?;
            block.known.oriented = true;
        }
        for ((ends, length), sigma) in block.known.distances.iter().zip(self.distance_sigmas) {
            let added = block.bundle.observe_distance(ends.map(|e| points[e]), *length, sigma);
            added.map_err(|e| {
                let [from, to] = ends.map(|e| &block.points[e]);
                anyhow!("--distances: from {from} to {to}: {}", reason(&e))
            })?;
        }
        Ok(block)
    }
}
