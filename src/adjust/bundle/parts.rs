//! Whether a block hangs together, and what is known of its place.
//!
//! Photographs that see the same points are parts of one block. What was given of a part (known points, positions, attitudes,
//! distances, held photographs) determines up to seven numbers of its place, attitude and scale: as many as the
//! rank of Σ GᵀAᵀA G, A the partials of what was given, G the directions of a similarity.

use alloc::collections::BTreeMap;
use alloc::vec::Vec;

use nalgebra::{Point3, SMatrix, Vector3};

use super::datum::{LEAST_SPREAD, Similarity};
use super::layout::{Layout, Role};
use super::problem::{Bundle, Image, Kind};
use super::state::State;
use crate::error::Error;

/// Sets of things that are merged: photographs first, then points.
struct Parts {
    parent: Vec<u32>,
}

impl Parts {
    fn root(&mut self, mut of: u32) -> u32 {
        while self.parent[of as usize] != of {
            let up = self.parent[self.parent[of as usize] as usize];
            self.parent[of as usize] = up;
            of = up;
        }
        of
    }

    fn merge(&mut self, a: u32, b: u32) {
        let (a, b) = (self.root(a), self.root(b));
        self.parent[a.max(b) as usize] = a.min(b);
    }
}

impl Layout {
    /// Refuses photographs that too little is known of, blocks in parts that nothing ties, and fewer observations than
    /// unknowns. Returns how many numbers of the block's place nothing was given for.
    pub(super) fn check<C>(&self, bundle: &Bundle<C>, state: &State<C>) -> Result<usize, Error> {
        if self.order.is_empty() {
            return Err(Error::TooFewPoints { needed: 3, got: 0 });
        }
        for (image, range) in bundle.images.iter().zip(self.image_first.windows(2)) {
            // Six numbers are unknown, a point gives two.
            if !image.held && range[1] - range[0] < 3 {
                return Err(Error::TooFewPoints { needed: 3, got: range[1] - range[0] });
            }
        }
        let ranks = self.ranks(bundle, state);
        // Parts that are placed are placed to each other; each other one is beside them.
        let loose = ranks.iter().filter(|rank| **rank < 7).count();
        let parts = loose + usize::from(loose > 0 && loose < ranks.len());
        if parts > 1 {
            return Err(Error::OutOfRange {
                what: "number of parts of the block that nothing ties together",
                value: parts as f64,
                expected: "1, or place, attitude and scale given for each",
            });
        }
        let given = ranks.iter().sum::<usize>();
        let free = 7 * ranks.len() - given;
        self.count(bundle, free)?;
        Ok(free)
    }

    /// Refuses fewer observations, with `free` conditions of the datum, than unknowns.
    fn count<C>(&self, bundle: &Bundle<C>, free: usize) -> Result<(), Error> {
        let points =
            || bundle.points.iter().zip(&self.roles).filter(|(_, r)| **r != Role::Constant);
        let control = points().filter(|(p, _)| matches!(p.kind, Kind::Control { .. })).count();
        let used = || bundle.cameras.iter().zip(&self.camera_image).filter(|(_, i)| i.is_some());
        let columns = || used().flat_map(|(c, _)| &c.columns.list);
        let observations = 2 * self.order.len()
            + 3 * control
            + bundle.images.iter().map(Image::observed_numbers).sum::<usize>()
            + bundle.distances.len()
            + columns().filter(|c| c.weight > 0.0).count();
        let unknowns = 3 * points().count()
            + 6 * bundle.images.iter().filter(|i| !i.held).count()
            + columns().count();
        if observations + free < unknowns {
            let needed = (unknowns - free).div_ceil(2);
            return Err(Error::TooFewPoints { needed, got: observations / 2 });
        }
        Ok(())
    }

    /// For each connected part, how many of the seven numbers of its place what was given determines.
    fn ranks<C>(&self, bundle: &Bundle<C>, state: &State<C>) -> Vec<usize> {
        let images = bundle.images.len() as u32;
        let mut parts = Parts { parent: (0..images + bundle.points.len() as u32).collect() };
        for place in 0..self.order.len() {
            let seen = self.seen(bundle, place);
            // A known point ties nothing.
            if self.roles[seen.point as usize] != Role::Constant {
                parts.merge(seen.image, images + seen.point);
            }
        }
        for distance in &bundle.distances {
            let [a, b] = distance.ends.map(|p| p as usize);
            if [a, b].iter().all(|p| self.roles[*p] != Role::Constant) {
                parts.merge(images + a as u32, images + b as u32);
            }
        }
        let about = Similarity::about(state.points.iter().copied());
        let mut grams: BTreeMap<u32, SMatrix<f64, 7, 7>> = BTreeMap::new();
        for (i, (image, exterior)) in bundle.images.iter().zip(&state.exteriors).enumerate() {
            let gram = grams.entry(parts.root(i as u32)).or_insert_with(SMatrix::zeros);
            let mut g = about.of_image(exterior);
            if image.held {
                // Turns are told in the same unit as lengths.
                g.rows_mut(3, 3).iter_mut().for_each(|v| *v *= about.scale());
                *gram += g.transpose() * g;
                continue;
            }
            let position = image.position.map(|p| p.at(exterior).partials);
            let attitude = image.attitude.map(|a| a.at(exterior).partials * about.scale());
            for partials in position.into_iter().chain(attitude) {
                let rows = partials * g;
                *gram += rows.transpose() * rows;
            }
        }
        self.add_known_points(bundle, state, &about, &mut parts, &mut grams);
        for distance in &bundle.distances {
            let [a, b] = distance.ends.map(|p| state.points[p as usize]);
            let along: Vector3<f64> = (a - b) / (a - b).norm().max(f64::MIN_POSITIVE);
            let row = along.transpose() * (about.of_point(&a) - about.of_point(&b));
            for end in distance.ends {
                if let Some(gram) = grams.get_mut(&parts.root(images + end)) {
                    *gram += row.transpose() * row;
                }
            }
        }
        grams.into_values().map(rank).collect()
    }

    /// Adds the points whose coordinates are known, for the photographs that see them.
    fn add_known_points<C>(
        &self,
        bundle: &Bundle<C>,
        state: &State<C>,
        about: &Similarity,
        parts: &mut Parts,
        grams: &mut BTreeMap<u32, SMatrix<f64, 7, 7>>,
    ) {
        for place in 0..self.order.len() {
            let seen = self.seen(bundle, place);
            let point = seen.point as usize;
            let at: &Point3<f64> = match &bundle.points[point].kind {
                Kind::Pass => continue,
                Kind::Control { .. } | Kind::Fixed => &state.points[point],
            };
            if let Some(gram) = grams.get_mut(&parts.root(seen.image)) {
                let g = about.of_point(at);
                *gram += g.transpose() * g;
            }
        }
    }
}

/// The rank of a matrix of squares, in units of the block's spread.
fn rank(gram: SMatrix<f64, 7, 7>) -> usize {
    let values = gram.symmetric_eigenvalues();
    let limit = LEAST_SPREAD * values.max();
    values.iter().filter(|v| **v > limit).count()
}
