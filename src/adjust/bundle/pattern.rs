//! Which blocks the reduced system has.
//!
//! Its nodes are the photographs, the cameras with blocks of their own and the points that are kept, in this order. Two of them
//! have a block in common where an eliminated point is seen from both, or an observation ties them.

use alloc::borrow::Cow;
use alloc::vec;
use alloc::vec::Vec;
use core::ops::Range;

use super::layout::{Layout, Role};
use super::parallel;
use super::problem::Bundle;

/// The blocks of the upper triangle, in rows of nodes.
#[derive(Clone, Debug)]
pub(super) struct Pattern {
    /// Where the unknowns of each node begin in the reduced system, and the end.
    begin: Vec<usize>,
    /// `None`: all there can be, and the rows are those of the square matrix.
    lists: Option<Lists>,
}

#[derive(Clone, Debug)]
struct Lists {
    /// For each node its neighbours from itself on, ascending.
    neighbours: Vec<Vec<u32>>,
    /// Where the numbers of each node begin, and the end.
    rows: Vec<usize>,
}

impl Pattern {
    /// The whole square.
    pub(super) fn full<C>(bundle: &Bundle<C>, layout: &Layout) -> Self {
        let (images, cameras) = (bundle.images.len(), layout.camera_nodes(bundle));
        let sizes = core::iter::repeat_n(layout.own, images)
            .chain(core::iter::repeat_n(layout.of_camera(), cameras))
            .chain(core::iter::repeat_n(3, layout.kept.len()));
        let mut begin = vec![0];
        let mut end = 0;
        begin.extend(sizes.map(|size| {
            end += size;
            end
        }));
        Self { begin, lists: None }
    }

    /// The blocks that the observations tie.
    pub(super) fn sparse<C: Sync>(bundle: &Bundle<C>, layout: &Layout) -> Self {
        let full = Self::full(bundle, layout);
        let (images, cameras) = (bundle.images.len(), layout.camera_nodes(bundle));
        let nodes = full.nodes();
        let camera = |image: u32| images + bundle.images[image as usize].camera as usize;
        let mut neighbours = vec![vec![]; nodes];
        parallel::for_each(&mut neighbours[..images + cameras], |node, list| {
            let mut met = vec![false; nodes];
            met[node] = true;
            let mut meet = |point: u32, places: Range<usize>| match layout.roles[point as usize] {
                Role::Constant => {}
                Role::Kept(kept) => met[images + cameras + kept as usize] = true,
                Role::Eliminated => {
                    for place in places {
                        let image = layout.seen(bundle, place).image;
                        met[image as usize] = true;
                        if cameras > 0 {
                            met[camera(image)] = true;
                        }
                    }
                }
            };
            if node < images {
                for place in
                    &layout.by_image[layout.image_first[node]..layout.image_first[node + 1]]
                {
                    let point = layout.seen(bundle, *place as usize).point;
                    meet(point, layout.first[point as usize]..layout.first[point as usize + 1]);
                }
                if cameras > 0 {
                    met[camera(node as u32)] = true;
                }
            } else {
                for point in &layout.camera_points[node - images] {
                    let point = *point;
                    meet(point, layout.first[point as usize]..layout.first[point as usize + 1]);
                }
            }
            *list = (node..nodes).filter(|n| met[*n]).map(|n| n as u32).collect();
        });
        let first = images + cameras;
        for (node, list) in neighbours.iter_mut().enumerate().skip(first) {
            list.push(node as u32);
        }
        for distance in &bundle.distances {
            let ends = distance.ends.map(|p| layout.roles[p as usize]);
            let [Role::Kept(a), Role::Kept(b)] = ends else { continue };
            neighbours[first + a.min(b) as usize].push((first as u32) + a.max(b));
        }
        for list in &mut neighbours[first..] {
            list.sort_unstable();
            list.dedup();
        }
        let mut rows = vec![0];
        let mut end = 0;
        for (node, list) in neighbours.iter().enumerate() {
            let width: usize = list.iter().map(|n| full.size(*n as usize)).sum();
            end += width * full.size(node);
            rows.push(end);
        }
        Self { begin: full.begin, lists: Some(Lists { neighbours, rows }) }
    }

    /// The number of nodes.
    pub(super) fn nodes(&self) -> usize {
        self.begin.len() - 1
    }

    /// The unknowns of a node.
    pub(super) fn size(&self, node: usize) -> usize {
        self.begin[node + 1] - self.begin[node]
    }

    /// Where the unknowns of a node begin.
    pub(super) fn begin(&self, node: usize) -> usize {
        self.begin[node]
    }

    /// The number of unknowns.
    pub(super) fn unknowns(&self) -> usize {
        self.begin.last().copied().unwrap_or(0)
    }

    /// How many numbers are kept.
    pub(super) fn len(&self) -> usize {
        match &self.lists {
            None => self.unknowns() * self.unknowns(),
            Some(lists) => lists.rows.last().copied().unwrap_or(0),
        }
    }

    /// Where the numbers of a node's rows are.
    pub(super) fn rows(&self, node: usize) -> Range<usize> {
        match &self.lists {
            None => self.begin[node] * self.unknowns()..self.begin[node + 1] * self.unknowns(),
            Some(lists) => lists.rows[node]..lists.rows[node + 1],
        }
    }

    /// The length of a row of a node.
    pub(super) fn stride(&self, node: usize) -> usize {
        match &self.lists {
            None => self.unknowns(),
            Some(_) => self.rows(node).len() / self.size(node).max(1),
        }
    }

    /// A node's neighbours from itself on; none of the whole square.
    pub(super) fn neighbours(&self, node: usize) -> &[u32] {
        self.lists.as_ref().map_or(&[], |lists| &lists.neighbours[node])
    }

    /// For each node its column in the rows of one; what it has no block with is never asked for.
    pub(super) fn columns(&self, node: usize) -> Cow<'_, [usize]> {
        let Some(lists) = &self.lists else { return Cow::Borrowed(&self.begin) };
        let mut columns = vec![0; self.nodes()];
        let mut at = 0;
        for neighbour in &lists.neighbours[node] {
            columns[*neighbour as usize] = at;
            at += self.size(*neighbour as usize);
        }
        Cow::Owned(columns)
    }

    /// The column of one node in the rows of another.
    pub(super) fn column(&self, node: usize, other: usize) -> usize {
        let Some(lists) = &self.lists else { return self.begin[other] };
        let before = lists.neighbours[node].iter().take_while(|n| (**n as usize) < other);
        before.map(|n| self.size(*n as usize)).sum()
    }

    /// Where the diagonal element of an unknown is.
    pub(super) fn diagonal(&self, unknown: usize) -> usize {
        let node = self.begin.partition_point(|b| *b <= unknown) - 1;
        let own = unknown - self.begin[node];
        self.rows(node).start + own * self.stride(node) + self.column(node, node) + own
    }
}
