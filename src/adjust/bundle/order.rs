//! In which order the blocks of a sparse matrix are eliminated.
//!
//! Minimum degree (Tinney & Walker 1967; George & Liu 1989, *The evolution of the minimum degree ordering algorithm*): of the
//! nodes left, always the one with the fewest neighbours. What was eliminated is kept as cliques, so that memory
//! does not grow.

use alloc::vec;
use alloc::vec::Vec;

/// The nodes in the order of their elimination. `adjacent` are the neighbours of each node on both sides, without itself; `sizes` the
/// numbers of unknowns.
pub(super) fn minimum_degree(adjacent: Vec<Vec<u32>>, sizes: &[usize]) -> Vec<u32> {
    let n = adjacent.len();
    let mut graph = Graph {
        nodes: adjacent,
        cliques: vec![vec![]; n],
        members: vec![vec![]; n],
        gone: vec![false; n],
        stamp: vec![0; n],
        now: 0,
    };
    let weigh = |list: &[u32]| list.iter().map(|i| sizes[*i as usize]).sum::<usize>();
    let mut degree: Vec<usize> = graph.nodes.iter().map(|list| weigh(list)).collect();
    let mut left: alloc::collections::BTreeSet<(usize, u32)> =
        degree.iter().enumerate().map(|(i, d)| (*d, i as u32)).collect();
    let mut order = Vec::with_capacity(n);
    while let Some((_, pivot)) = left.pop_first() {
        order.push(pivot);
        graph.eliminate(pivot);
        // Nodes whose neighbours are all in the new clique come next: they add nothing to it.
        let mut clique = core::mem::take(&mut graph.members[pivot as usize]);
        let (inside, mut rest): (Vec<u32>, Vec<u32>) = clique.iter().partition(|i| {
            let i = **i as usize;
            graph.nodes[i].is_empty() && graph.cliques[i].len() == 1
        });
        for i in &inside {
            left.remove(&(degree[*i as usize], *i));
            graph.gone[*i as usize] = true;
            order.push(*i);
        }
        core::mem::swap(&mut clique, &mut rest);
        graph.members[pivot as usize] = clique;
        for k in 0..graph.members[pivot as usize].len() {
            let i = graph.members[pivot as usize][k];
            left.remove(&(degree[i as usize], i));
            degree[i as usize] = graph.degree(i, sizes);
            left.insert((degree[i as usize], i));
        }
    }
    order
}

struct Graph {
    /// For each node those it is tied to by an edge of its own.
    nodes: Vec<Vec<u32>>,
    /// For each node the cliques it is in, by the nodes whose elimination made them.
    cliques: Vec<Vec<u32>>,
    members: Vec<Vec<u32>>,
    gone: Vec<bool>,
    /// Nodes met in the search `now`.
    stamp: Vec<u32>,
    now: u32,
}

impl Graph {
    fn eliminate(&mut self, pivot: u32) {
        let p = pivot as usize;
        self.gone[p] = true;
        self.now += 1;
        let now = self.now;
        self.stamp[p] = now;
        let mut clique = vec![];
        let absorbed = core::mem::take(&mut self.cliques[p]);
        let own = core::mem::take(&mut self.nodes[p]);
        let mut meet = |list: &[u32]| {
            for i in list {
                let at = *i as usize;
                if !self.gone[at] && self.stamp[at] != now {
                    self.stamp[at] = now;
                    clique.push(*i);
                }
            }
        };
        meet(&own);
        for c in &absorbed {
            meet(&self.members[*c as usize]);
        }
        for c in &absorbed {
            self.members[*c as usize] = vec![];
        }
        clique.sort_unstable();
        for i in &clique {
            let i = *i as usize;
            // Edges within the clique are the clique's now.
            self.nodes[i].retain(|j| self.stamp[*j as usize] != now);
            self.cliques[i].retain(|c| !absorbed.contains(c));
            self.cliques[i].push(pivot);
        }
        self.members[p] = clique;
    }

    fn degree(&mut self, node: u32, sizes: &[usize]) -> usize {
        self.now += 1;
        let i = node as usize;
        self.stamp[i] = self.now;
        let mut sum = 0;
        let of_cliques = self.cliques[i].iter().flat_map(|c| &self.members[*c as usize]);
        for j in self.nodes[i].iter().chain(of_cliques) {
            let j = *j as usize;
            if !self.gone[j] && self.stamp[j] != self.now {
                self.stamp[j] = self.now;
                sum += sizes[j];
            }
        }
        sum
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn leaves_go_before_the_middle_of_a_star() {
        // Node 0 is tied to all: each leaf has one neighbour, and the middle too once three are gone.
        let star = vec![vec![1, 2, 3, 4], vec![0], vec![0], vec![0], vec![0]];
        assert_eq!(minimum_degree(star, &[1; 5]), [1, 2, 3, 0, 4]);
        // Sizes count: of a chain 0 – 1 – 2 whose ends are large, the middle is left with more to meet than the other end.
        let chain = || vec![vec![1], vec![0, 2], vec![1]];
        assert_eq!(minimum_degree(chain(), &[1; 3]), [0, 1, 2]);
        assert_eq!(minimum_degree(chain(), &[5, 1, 5]), [0, 2, 1]);
    }

    #[test]
    fn what_is_tied_to_everything_goes_as_one_clique() {
        let all = (0..4_u32).map(|i| (0..4).filter(|j| *j != i).collect()).collect();
        assert_eq!(minimum_degree(all, &[6; 4]), [0, 1, 2, 3]);
    }
}
