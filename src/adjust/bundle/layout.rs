//! What takes part in an adjustment, in the order in which it is worked through.

use alloc::vec;
use alloc::vec::Vec;

use super::datum::Similarity;
use super::problem::{Bundle, Kind, Seen};
use super::{Exclusion, OutsideRule, parallel, state::State};
use crate::camera::{Adjustable, CentralModel};
use crate::error::{Error, ProjectionError};

/// How a point enters the normal equations.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Role {
    /// It is eliminated before the photographs.
    Eliminated,
    /// It stays in the reduced system, at this place among those that do: a distance ties it to another.
    Kept(u32),
    /// It is known, or nothing observes it: no unknown.
    Constant,
}

/// The observations that take part, sorted by point and photograph, and the places of the unknowns.
#[derive(Clone, Debug)]
pub(super) struct Layout {
    /// The numbers of the observations, sorted.
    pub(super) order: Vec<u32>,
    /// Where the observations of each point begin, and the end.
    pub(super) first: Vec<usize>,
    /// For each photograph, the places of its observations in `order`.
    pub(super) by_image: Vec<u32>,
    /// Where those of each photograph begin, and the end.
    pub(super) image_first: Vec<usize>,
    pub(super) roles: Vec<Role>,
    /// The points that are kept.
    pub(super) kept: Vec<u32>,
    /// Observations that take no part, with the reason.
    pub(super) excluded: Vec<(u32, Exclusion)>,
    /// Columns of a photograph's own block.
    pub(super) own: usize,
    /// All columns of a photograph: its own block and, where cameras are shared, its camera's.
    pub(super) total: usize,
    /// For each camera, the points it sees; empty where no camera is shared.
    pub(super) camera_points: Vec<Vec<u32>>,
    /// For each camera its first photograph, where it has any.
    pub(super) camera_image: Vec<Option<u32>>,
    /// How many of the seven numbers of each part's place nothing was given for.
    pub(super) free: usize,
    /// The spread of the object points, by which lengths are judged.
    pub(super) extent: f64,
}

impl Layout {
    pub(super) fn new<C: CentralModel + Adjustable + Clone>(
        bundle: &Bundle<C>,
        state: &State<C>,
        outside: OutsideRule,
    ) -> Result<Self, Error> {
        let (images, points) = (bundle.images.len(), bundle.points.len());
        let mut excluded = Vec::new();
        let mut takes_part = vec![true; bundle.seen.len()];
        let mut parts: Vec<_> =
            bundle.seen.chunks(parallel::MANY).map(|seen| (seen, Vec::new())).collect();
        parallel::for_each(&mut parts, |part, (seen, out)| {
            for (own, seen) in seen.iter().enumerate() {
                let reason = match super::evaluate::image_of(bundle, state, seen, outside) {
                    Ok(_) => continue,
                    Err(ProjectionError::BehindCamera { .. }) => Exclusion::BehindCamera,
                    Err(_) => Exclusion::OutsideDomain,
                };
                out.push(((part * parallel::MANY + own) as u32, reason));
            }
        });
        for (i, reason) in parts.into_iter().flat_map(|(_, out)| out) {
            takes_part[i as usize] = false;
            excluded.push((i, reason));
        }
        // A point with one ray and no coordinates of its own says nothing of the block; its image measured twice in one
        // photograph is one ray.
        let mut rays = vec![0_u32; points];
        let mut first_ray = vec![u32::MAX; points];
        for (seen, _) in bundle.seen.iter().zip(&takes_part).filter(|(_, takes)| **takes) {
            let (rays, first) =
                (&mut rays[seen.point as usize], &mut first_ray[seen.point as usize]);
            if *rays == 0 {
                (*rays, *first) = (1, seen.image);
            } else if *first != seen.image {
                *rays = 2;
            }
        }
        let mut roles: Vec<Role> = bundle
            .points
            .iter()
            .zip(&rays)
            .map(|(object, rays)| match object.kind {
                Kind::Fixed => Role::Constant,
                Kind::Pass if *rays < 2 => Role::Constant,
                _ => Role::Eliminated,
            })
            .collect();
        for (i, seen) in bundle.seen.iter().enumerate() {
            let point = seen.point as usize;
            if takes_part[i] && rays[point] < 2 && bundle.points[point].kind == Kind::Pass {
                takes_part[i] = false;
                excluded.push((i as u32, Exclusion::SingleRay));
            }
        }
        excluded.sort_unstable_by_key(|(i, _)| *i);
        let mut kept: Vec<u32> = bundle.distances.iter().flat_map(|d| d.ends).collect();
        kept.sort_unstable();
        kept.dedup();
        for end in &kept {
            let (object, rays) = (&bundle.points[*end as usize], rays[*end as usize]);
            if object.kind == Kind::Pass && rays < 2 {
                return Err(Error::TooFewPoints { needed: 2, got: rays as usize });
            }
        }
        kept.retain(|p| roles[*p as usize] == Role::Eliminated);
        for (place, point) in kept.iter().enumerate() {
            roles[*point as usize] = Role::Kept(place as u32);
        }
        let mut order: Vec<u32> = (0..bundle.seen.len() as u32).collect();
        order.retain(|i| takes_part[*i as usize]);
        order.shrink_to_fit();
        let key = |i: &u32| {
            let seen = &bundle.seen[*i as usize];
            (seen.point, seen.image, *i)
        };
        if !order.is_sorted_by_key(key) {
            order.sort_unstable_by_key(key);
        }
        let mut first = vec![0; points + 1];
        let mut image_first = vec![0; images + 1];
        for i in &order {
            let seen = &bundle.seen[*i as usize];
            first[seen.point as usize + 1] += 1;
            image_first[seen.image as usize + 1] += 1;
        }
        for list in [&mut first, &mut image_first] {
            for i in 1..list.len() {
                list[i] += list[i - 1];
            }
        }
        let mut by_image = vec![0; order.len()];
        let mut next = image_first.clone();
        for (place, i) in order.iter().enumerate() {
            let slot = &mut next[bundle.seen[*i as usize].image as usize];
            by_image[*slot] = place as u32;
            *slot += 1;
        }
        let of_camera = bundle.cameras.iter().map(|c| c.columns.len()).max().unwrap_or(0);
        let mut users = vec![0_u32; bundle.cameras.len()];
        let mut camera_image = vec![None; bundle.cameras.len()];
        for (i, image) in bundle.images.iter().enumerate() {
            users[image.camera as usize] += 1;
            camera_image[image.camera as usize].get_or_insert(i as u32);
        }
        let shared = of_camera > 0 && users.iter().any(|u| *u > 1);
        let total = 6 + of_camera;
        let mut layout = Self {
            order,
            first,
            by_image,
            image_first,
            roles,
            kept,
            excluded,
            own: if shared { 6 } else { total },
            total,
            camera_points: Vec::new(),
            camera_image,
            free: 0,
            extent: Similarity::about(bundle.points.iter().map(|p| p.start)).scale(),
        };
        if shared {
            layout.list_camera_points(bundle);
        }
        layout.free = layout.check(bundle, state)?;
        Ok(layout)
    }

    fn list_camera_points<C>(&mut self, bundle: &Bundle<C>) {
        let mut lists = vec![Vec::new(); bundle.cameras.len()];
        for point in 0..bundle.points.len() {
            for place in self.first[point]..self.first[point + 1] {
                let seen = &bundle.seen[self.order[place] as usize];
                let list: &mut Vec<u32> =
                    &mut lists[bundle.images[seen.image as usize].camera as usize];
                if list.last() != Some(&(point as u32)) {
                    list.push(point as u32);
                }
            }
        }
        self.camera_points = lists;
    }

    /// The observation at a place.
    #[inline]
    pub(super) fn seen<'a, C>(&self, bundle: &'a Bundle<C>, place: usize) -> &'a Seen {
        &bundle.seen[self.order[place] as usize]
    }

    /// Columns of a camera's block in the reduced system.
    pub(super) fn of_camera(&self) -> usize {
        self.total - self.own
    }

    /// The number of cameras with a block of their own in the reduced system.
    pub(super) fn camera_nodes<C>(&self, bundle: &Bundle<C>) -> usize {
        if self.of_camera() > 0 { bundle.cameras.len() } else { 0 }
    }

    /// Where the columns of a camera begin in the reduced system.
    #[inline]
    pub(super) fn camera_column(&self, images: usize, camera: usize) -> usize {
        images * self.own + camera * self.of_camera()
    }

    /// Where the columns of a kept point begin.
    pub(super) fn kept_column<C>(&self, bundle: &Bundle<C>, place: usize) -> usize {
        self.camera_column(bundle.images.len(), bundle.cameras.len()) + 3 * place
    }

    /// The size of the reduced system.
    pub(super) fn reduced<C>(&self, bundle: &Bundle<C>) -> usize {
        self.kept_column(bundle, self.kept.len())
    }
}
