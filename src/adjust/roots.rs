//! The few poses that a minimal problem has.

use core::ops::Deref;

use crate::geometry::Pose;

/// Up to `N` poses, kept in place.
///
/// It is a slice of [`Pose`], and gives its poses up by value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Roots<const N: usize> {
    poses: [Pose; N],
    len: usize,
}

impl<const N: usize> Roots<N> {
    pub(super) fn none() -> Self {
        Self { poses: [Pose::identity(); N], len: 0 }
    }

    /// Adds a pose, where there is room.
    pub(super) fn push(&mut self, pose: Pose) {
        if let Some(place) = self.poses.get_mut(self.len) {
            *place = pose;
            self.len += 1;
        }
    }
}

impl<const N: usize> Deref for Roots<N> {
    type Target = [Pose];
    fn deref(&self) -> &[Pose] {
        &self.poses[..self.len]
    }
}

impl<const N: usize> IntoIterator for Roots<N> {
    type Item = Pose;
    type IntoIter = core::iter::Take<core::array::IntoIter<Pose, N>>;
    fn into_iter(self) -> Self::IntoIter {
        self.poses.into_iter().take(self.len)
    }
}

impl<'a, const N: usize> IntoIterator for &'a Roots<N> {
    type Item = &'a Pose;
    type IntoIter = core::slice::Iter<'a, Pose>;
    fn into_iter(self) -> Self::IntoIter {
        self.iter()
    }
}
