//! Cholesky's factorisation of a reduced system most of whose blocks are zero.
//!
//! Multifrontal (Duff & Reid 1983; Liu 1992, *The multifrontal method for sparse matrix solution*): nodes are eliminated in
//! an order of minimum degree, those that fill the same columns together in one dense front; what a front leaves of its other columns
//! is added to the front of the first of them. Fronts that do not wait for each other are worked through at the same time,
//! and each adds its parts in one order: the numbers are the same on any number of threads.

use alloc::vec;
use alloc::vec::Vec;
use core::ops::Range;

use super::layout::Layout;
use super::order::minimum_degree;
use super::pattern::Pattern;
use super::problem::Bundle;
use super::schur::Reduced;
use super::{dense, parallel};

/// A front takes up the one before it where no larger part of it is then zero.
const MOST_ZEROS: f64 = 0.15;

/// How a reduced system is factorised.
#[derive(Clone, Debug)]
pub(super) struct Plan {
    pub(super) pattern: Pattern,
    /// By height: a front stands after all that add to it.
    fronts: Vec<Front>,
    levels: Vec<Range<usize>>,
}

/// A dense part of the factorisation.
#[derive(Clone, Debug)]
struct Front {
    /// The unknowns, in the order of their elimination.
    unknowns: Vec<u32>,
    /// How many of them are eliminated here.
    pivots: usize,
    /// The blocks of the matrix that enter here.
    blocks: Vec<Source>,
    /// The fronts whose rest is added here, and where their unknowns stand.
    children: Vec<(u32, Vec<u32>)>,
}

/// A block of the matrix, and where it goes.
#[derive(Clone, Debug)]
struct Source {
    at: usize,
    stride: usize,
    sizes: [usize; 2],
    place: [usize; 2],
}

/// A front that was worked through: rows of U with the right side as last column, and what it leaves.
#[derive(Clone, Debug, Default)]
struct Done {
    factor: Vec<f64>,
    rest: Vec<f64>,
    regular: bool,
}

/// A set of nodes that are eliminated together.
struct Group {
    /// Positions in the order of elimination.
    pivots: Vec<u32>,
    /// Unknowns of them.
    size: usize,
    /// Numbers that merging made zero.
    zeros: usize,
}

impl Plan {
    pub(super) fn new<C: Sync>(bundle: &Bundle<C>, layout: &Layout) -> Self {
        Self::of_pattern(Pattern::sparse(bundle, layout))
    }

    fn of_pattern(pattern: Pattern) -> Self {
        let nodes = pattern.nodes();
        let sizes: Vec<usize> = (0..nodes).map(|i| pattern.size(i)).collect();
        let mut adjacent = vec![vec![]; nodes];
        for i in 0..nodes {
            for j in pattern.neighbours(i).iter().filter(|j| **j as usize != i) {
                adjacent[i].push(*j);
                adjacent[*j as usize].push(i as u32);
            }
        }
        let order = minimum_degree(adjacent.clone(), &sizes);
        let mut position = vec![0; nodes];
        order.iter().enumerate().for_each(|(at, node)| position[*node as usize] = at as u32);
        // What each node's elimination fills: positions after its own.
        let mut fills: Vec<Vec<u32>> = vec![vec![]; nodes];
        for at in 0..nodes {
            let mut fill = core::mem::take(&mut fills[at]);
            fill.extend(adjacent[order[at] as usize].iter().map(|j| position[*j as usize]));
            fill.retain(|j| *j as usize > at);
            fill.sort_unstable();
            fill.dedup();
            if let Some(parent) = fill.first() {
                fills[*parent as usize].extend_from_slice(&fill[1..]);
            }
            fills[at] = fill;
        }
        let size_at = |at: u32| sizes[order[at as usize] as usize];
        let groups = group(&fills, &size_at);
        Self::with_groups(pattern, &order, &position, &fills, groups)
    }

    fn with_groups(
        pattern: Pattern,
        order: &[u32],
        position: &[u32],
        fills: &[Vec<u32>],
        groups: Vec<Option<Group>>,
    ) -> Self {
        // A group is at the position of its last pivot.
        let mut group_of = vec![0; order.len()];
        let mut height = vec![0_usize; order.len()];
        for (top, group) in groups.iter().enumerate() {
            let Some(group) = group else { continue };
            group.pivots.iter().for_each(|at| group_of[*at as usize] = top);
        }
        let parent = |top: usize| fills[top].first().map(|p| group_of[*p as usize]);
        let tops: Vec<usize> = (0..groups.len()).filter(|top| groups[*top].is_some()).collect();
        for top in &tops {
            if let Some(up) = parent(*top) {
                height[up] = height[up].max(height[*top] + 1);
            }
        }
        let mut sorted = tops;
        sorted.sort_by_key(|top| height[*top]);
        let mut place_of_group = vec![0; order.len()];
        sorted.iter().enumerate().for_each(|(i, top)| place_of_group[*top] = i);
        let mut levels: Vec<Range<usize>> = vec![];
        for (i, top) in sorted.iter().enumerate() {
            match levels.last_mut().filter(|l| height[sorted[l.start]] == height[*top]) {
                Some(level) => level.end = i + 1,
                None => levels.push(i..i + 1),
            }
        }
        // The nodes of each front and where they begin in it.
        let mut fronts = Vec::with_capacity(sorted.len());
        let mut places: Vec<Vec<(u32, usize)>> = Vec::with_capacity(sorted.len());
        for top in &sorted {
            let Some(group) = &groups[*top] else { continue };
            let (mut unknowns, mut nodes) = (vec![], vec![]);
            for at in group.pivots.iter().chain(&fills[*top]) {
                let node = order[*at as usize] as usize;
                nodes.push((*at, unknowns.len()));
                let begin = pattern.begin(node) as u32;
                unknowns.extend(begin..begin + pattern.size(node) as u32);
            }
            let (blocks, children) = (vec![], vec![]);
            fronts.push(Front { unknowns, pivots: group.size, blocks, children });
            places.push(nodes);
        }
        let place = |front: usize, at: u32| {
            let list: &Vec<(u32, usize)> = &places[front];
            list.binary_search_by_key(&at, |(at, _)| *at).map_or(0, |i| list[i].1)
        };
        for node in 0..pattern.nodes() {
            let (mut at, stride) = (pattern.rows(node).start, pattern.stride(node));
            for other in pattern.neighbours(node) {
                let other = *other as usize;
                let [a, b] = [position[node], position[other]];
                let front = place_of_group[group_of[a.min(b) as usize]];
                fronts[front].blocks.push(Source {
                    at,
                    stride,
                    sizes: [pattern.size(node), pattern.size(other)],
                    place: [place(front, a), place(front, b)],
                });
                at += pattern.size(other);
            }
        }
        for (child, top) in sorted.iter().enumerate() {
            let (Some(up), Some(group)) = (parent(*top), &groups[*top]) else { continue };
            let up = place_of_group[up];
            let mut to = vec![];
            for (at, _) in &places[child][group.pivots.len()..] {
                let begin = place(up, *at) as u32;
                to.extend(begin..begin + pattern.size(order[*at as usize] as usize) as u32);
            }
            fronts[up].children.push((child as u32, to));
        }
        Self { pattern, fronts, levels }
    }

    /// Multiplications of the factorisation, about.
    pub(super) fn work(&self) -> f64 {
        let front = |f: &Front| {
            let [all, rest] = [f.unknowns.len(), f.unknowns.len() - f.pivots].map(|n| n as f64);
            (all * all * all - rest * rest * rest) / 6.0
        };
        self.fronts.iter().map(front).sum()
    }

    /// Numbers that are kept of the factor and the matrix.
    pub(super) fn numbers(&self) -> usize {
        let kept: usize = self.fronts.iter().map(|f| f.pivots * (f.unknowns.len() + 1)).sum();
        kept + self.pattern.len()
    }

    /// The solution of the system, whose unknowns are scaled and whose scaled diagonal is raised by the damping; `None` where it is
    /// not positive definite.
    pub(super) fn solve(
        &self,
        system: &Reduced,
        scale: &[f64],
        diagonal: &[f64],
        damping: f64,
    ) -> Option<Vec<f64>> {
        let mut done: Vec<Done> = vec![Done::default(); self.fronts.len()];
        for level in &self.levels {
            let (before, now) = done.split_at_mut(level.start);
            let now = &mut now[..level.len()];
            let before = &*before;
            parallel::for_each(now, |i, out| {
                let front = &self.fronts[level.start + i];
                *out = front.eliminate(system, before, scale, diagonal, damping);
            });
            if now.iter().any(|d| !d.regular) {
                return None;
            }
            for (child, _) in self.fronts[level.clone()].iter().flat_map(|f| &f.children) {
                done[*child as usize].rest = Vec::new();
            }
        }
        let mut x = vec![0.0; scale.len()];
        let mut own = vec![];
        for (front, done) in self.fronts.iter().zip(&done).rev() {
            let n = front.unknowns.len();
            own.clear();
            own.extend(front.unknowns.iter().map(|u| x[*u as usize]));
            for i in (0..front.pivots).rev() {
                let row = &done.factor[i * (n + 1)..][..n + 1];
                let sum: f64 = row[i + 1..n].iter().zip(&own[i + 1..]).map(|(u, x)| u * x).sum();
                own[i] = (row[n] - sum) / row[i];
                x[front.unknowns[i] as usize] = own[i];
            }
        }
        x.iter_mut().zip(scale).for_each(|(x, s)| *x *= s);
        Some(x)
    }
}

/// Groups of nodes that are eliminated together, each at its last position.
fn group(fills: &[Vec<u32>], size_at: &impl Fn(u32) -> usize) -> Vec<Option<Group>> {
    let single = |at| Group { pivots: vec![at], size: size_at(at), zeros: 0 };
    let mut groups: Vec<Option<Group>> =
        (0..fills.len() as u32).map(|at| Some(single(at))).collect();
    let width = |at: usize| fills[at].iter().map(|i| size_at(*i)).sum::<usize>();
    let widths: Vec<usize> = (0..fills.len()).map(width).collect();
    for at in 0..fills.len() {
        let Some(up) = fills[at].first().map(|p| *p as usize) else { continue };
        let (Some(own), Some(parent)) = (groups[at].take(), groups[up].take()) else { continue };
        let size = own.size + parent.size;
        let extra = own.size * (parent.size + widths[up] - widths[at]);
        let zeros = own.zeros + parent.zeros + extra;
        let numbers = size * size / 2 + size * widths[up];
        if zeros as f64 <= MOST_ZEROS * numbers as f64 {
            let mut pivots = own.pivots;
            pivots.extend(parent.pivots);
            pivots.sort_unstable();
            groups[up] = Some(Group { pivots, size, zeros });
        } else {
            groups[at] = Some(own);
            groups[up] = Some(parent);
        }
    }
    groups
}

impl Front {
    fn eliminate(
        &self,
        system: &Reduced,
        before: &[Done],
        scale: &[f64],
        diagonal: &[f64],
        damping: f64,
    ) -> Done {
        let n = self.unknowns.len();
        let stride = n + 1;
        let mut a = vec![0.0; n * stride];
        for block in &self.blocks {
            let ([rows, columns], [r0, c0]) = (block.sizes, block.place);
            for r in 0..rows {
                let from = &system.matrix[block.at + r * block.stride..][..columns];
                let own = scale[self.unknowns[r0 + r] as usize];
                for c in if r0 == c0 { r..columns } else { 0..columns } {
                    let value = own * scale[self.unknowns[c0 + c] as usize] * from[c];
                    let [i, j] = [r0 + r, c0 + c];
                    a[i.min(j) * stride + i.max(j)] = value;
                }
            }
        }
        for (i, unknown) in self.unknowns[..self.pivots].iter().enumerate() {
            let unknown = *unknown as usize;
            let own = &mut a[i * stride + i];
            *own = if diagonal[unknown] > 0.0 { *own + damping } else { 1.0 };
            a[i * stride + n] = system.right[unknown] * scale[unknown];
        }
        for (child, places) in &self.children {
            let rest = &before[*child as usize].rest;
            for (r, (to, from)) in
                places.iter().zip(rest.chunks_exact(places.len() + 1)).enumerate()
            {
                let row = &mut a[*to as usize * stride..][..stride];
                for (c, v) in places[r..].iter().zip(&from[r..]) {
                    row[*c as usize] += v;
                }
                row[n] += from[places.len()];
            }
        }
        let regular = dense::eliminate(&mut a, stride, self.pivots, scale.len()).is_ok();
        let mut rest = Vec::with_capacity((n - self.pivots) * (n - self.pivots + 1));
        for row in a[self.pivots * stride..].chunks_exact(stride) {
            rest.extend_from_slice(&row[self.pivots..]);
        }
        a.truncate(self.pivots * stride);
        a.shrink_to_fit();
        Done { factor: a, rest, regular }
    }
}
