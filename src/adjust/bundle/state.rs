//! The unknowns of a block at one place.

use alloc::vec::Vec;

use nalgebra::{Point3, Vector3};

use super::layout::{Layout, Role};
use super::parallel;
use super::problem::Bundle;
use crate::camera::{Adjustable, CentralModel, ExteriorOrientation};

/// Cameras, photographs and points at one place.
#[derive(Clone, Debug)]
pub(super) struct State<C> {
    pub(super) exteriors: Vec<ExteriorOrientation>,
    pub(super) cameras: Vec<C>,
    pub(super) points: Vec<Point3<f64>>,
    /// Whether the last step led to valid models.
    pub(super) valid: bool,
}

/// A step of all unknowns.
#[derive(Clone, Debug)]
pub(super) struct Step {
    /// Of the reduced system.
    pub(super) reduced: Vec<f64>,
    /// Of the eliminated points.
    pub(super) points: Vec<Vector3<f64>>,
}

impl<C: CentralModel + Adjustable + Clone> State<C> {
    /// The approximate values.
    pub(super) fn start(bundle: &Bundle<C>) -> Self {
        Self {
            exteriors: bundle.images.iter().map(|i| i.exterior).collect(),
            cameras: bundle.cameras.iter().map(|c| c.model.clone()).collect(),
            points: bundle.points.iter().map(|p| p.start).collect(),
            valid: true,
        }
    }

    /// Moved by a step.
    pub(super) fn moved(&self, bundle: &Bundle<C>, layout: &Layout, step: &Step) -> Self {
        let mut moved = self.clone();
        let images = bundle.images.len();
        for (i, image) in bundle.images.iter().enumerate() {
            let own = &step.reduced[i * layout.own..][..layout.own];
            if !image.held {
                match moved.exteriors[i].moved(&own[..6]) {
                    Ok(exterior) => moved.exteriors[i] = exterior,
                    Err(_) => moved.valid = false,
                }
            }
            if layout.own == layout.total {
                moved.move_camera(bundle, image.camera as usize, &own[6..]);
            }
        }
        if layout.own < layout.total {
            for camera in 0..bundle.cameras.len() {
                let own = &step.reduced[layout.camera_column(images, camera)..];
                moved.move_camera(bundle, camera, own);
            }
        }
        let mut parts: Vec<_> = moved.points.chunks_mut(parallel::MANY).collect();
        parallel::for_each(&mut parts, |part, points| {
            for (own, point) in points.iter_mut().enumerate() {
                let i = part * parallel::MANY + own;
                match layout.roles[i] {
                    Role::Eliminated => *point += step.points[i],
                    Role::Kept(place) => {
                        let column = layout.kept_column(bundle, place as usize);
                        *point += Vector3::from_column_slice(&step.reduced[column..][..3]);
                    }
                    Role::Constant => {}
                }
            }
        });
        moved
    }

    fn move_camera(&mut self, bundle: &Bundle<C>, camera: usize, step: &[f64]) {
        let columns = &bundle.cameras[camera].columns;
        if columns.len() == 0 {
            return;
        }
        match columns.moved(&self.cameras[camera], &step[..columns.len()]) {
            Ok(model) => self.cameras[camera] = model,
            Err(_) => self.valid = false,
        }
    }
}
