//! The blocks of a column as a binary tree: two blocks beside each other are one, with one edge.
//!
//! Between blocks A (below) and B (above) stand l, the last value of A, and r, the first of B. With x₋ and x₊
//! the values beside the two, their edges (`g, f, s` of the last value, `y, w, v` of the first) say
//! ```text
//! l = g_A + f_A x₋ + s_A r,    r = y_B + w_B l + v_B x₊,
//! ```
//! so that r = (y_B + w_B (g_A + f_A x₋) + v_B x₊) / (1 − w_B s_A). Upward this gives the edge of both,
//! downward what stands beside each. Which blocks are joined depends on their number alone: a rank joins
//! those of its own and sends the edge of what they make, and every number of ranks does the same operations.
//!
//! Node 1 is the whole column, 2n and 2n + 1 are the halves of node n, and block b of `count` is node
//! `count + b`.

use super::block_sweep::{Beside, Edge, GROUP, Wide};
use crate::lanes::Kernel;
use pulp::Simd;
use std::ops::Range;

/// Edges of all nodes and what stands beside them.
#[derive(Default)]
pub(super) struct Nodes {
    pub(super) edges: Vec<Edge>,
    pub(super) beside: Vec<Beside>,
}

impl Nodes {
    /// Room for the nodes above `count` blocks.
    pub(super) fn new(count: usize) -> Self {
        Self { edges: vec![[[0.0; GROUP]; 6]; 2 * count], beside: vec![[[0.0; GROUP]; 2]; 2 * count] }
    }
}

/// The largest nodes below the whole that make up the blocks `blocks` of `count`, from below.
pub(super) fn tops(count: usize, blocks: Range<usize>) -> Vec<usize> {
    let mut found = Vec::new();
    let mut next = blocks.start;
    while next < blocks.end {
        let (mut node, mut size) = (count + next, 1);
        while node % 2 == 0 && node > 2 && next + 2 * size <= blocks.end {
            (node, size) = (node / 2, 2 * size);
        }
        found.push(node);
        next += size;
    }
    found
}

/// The nodes from `tops` down that are no blocks of `count`, the largest numbers first.
pub(super) fn below(count: usize, tops: &[usize]) -> Vec<usize> {
    (2..count).rev().filter(|node| tops.iter().any(|top| is_within(*node, *top))).collect()
}

/// The nodes below the whole that none of `tops` has, the largest numbers first.
pub(super) fn above(count: usize, tops: &[usize]) -> Vec<usize> {
    (2..count).rev().filter(|node| !tops.iter().any(|top| is_within(*node, *top))).collect()
}

fn is_within(mut node: usize, top: usize) -> bool {
    while node > top {
        node /= 2;
    }
    node == top
}

/// 1 / (1 − w_B s_A).
#[inline(always)]
fn inverse(below: &Edge, above: &Edge) -> Wide {
    std::array::from_fn(|l| 1.0 / (1.0 - above[4][l] * below[2][l]))
}

/// The edge of two blocks.
#[inline(always)]
fn join(below: &Edge, above: &Edge, edge: &mut Edge) {
    let inverse = inverse(below, above);
    let ([g, f, s, y, w, v], [ga, fa, sa, ya, wa, va], [gb, fb, sb, yb, wb, vb]) = (edge, below, above);
    for l in 0..GROUP {
        // r = rho + tau x₋ + sigma x₊
        let rho = inverse[l] * (yb[l] + wb[l] * ga[l]);
        let tau = inverse[l] * (wb[l] * fa[l]);
        let sigma = inverse[l] * vb[l];
        g[l] = gb[l] + fb[l] * (ga[l] + sa[l] * rho);
        f[l] = fb[l] * (fa[l] + sa[l] * tau);
        s[l] = sb[l] + fb[l] * (sa[l] * sigma);
        y[l] = ya[l] + va[l] * rho;
        w[l] = wa[l] + va[l] * tau;
        v[l] = va[l] * sigma;
    }
}

/// l and r between two blocks that have `x` beside them.
#[inline(always)]
fn between([below, above]: [&Edge; 2], inverse: &Wide, [x, z]: &Beside) -> Beside {
    let ([g, f, s, ..], [.., y, w, v]) = (below, above);
    let (mut last, mut first) = ([0.0; GROUP], [0.0; GROUP]);
    for l in 0..GROUP {
        let constant = g[l] + f[l] * x[l];
        first[l] = inverse[l] * (y[l] + w[l] * constant + v[l] * z[l]);
        last[l] = constant + s[l] * first[l];
    }
    [last, first]
}

/// Joins the halves of `nodes`.
pub(super) struct Join<'a> {
    pub(super) nodes: &'a [usize],
    pub(super) edges: &'a mut [Edge],
}

impl Kernel for Join<'_> {
    #[inline(always)]
    fn run<S: Simd>(self, _: S) {
        for node in self.nodes {
            let (edges, halves) = self.edges.split_at_mut(2 * node);
            join(&halves[0], &halves[1], &mut edges[*node]);
        }
    }
}

/// What stands beside the two halves of the whole.
pub(super) struct Close<'a> {
    pub(super) nodes: &'a mut Nodes,
    pub(super) periodic: bool,
    /// Whether the first mode is known up to a constant only.
    pub(super) singular: bool,
}

impl Kernel for Close<'_> {
    #[inline(always)]
    fn run<S: Simd>(self, _: S) {
        let Self { nodes: Nodes { edges, beside }, periodic, singular } = self;
        let halves = [&edges[2], &edges[3]];
        let mut inverse = inverse(halves[0], halves[1]);
        let mut ends = [[0.0; GROUP]; 2];
        if periodic {
            let mut whole = [[0.0; GROUP]; 6];
            join(halves[0], halves[1], &mut whole);
            let ([g, f, s, y, w, v], [bottom, top]) = (&whole, &mut ends);
            for l in 0..GROUP {
                // The last value stands below the first one, which stands above the last.
                let first = 1.0 / (1.0 - v[l]);
                let last = (g[l] + s[l] * (first * y[l])) / (1.0 - f[l] - s[l] * (first * w[l]));
                bottom[l] = if singular && l == 0 { 0.0 } else { last };
                top[l] = first * (y[l] + w[l] * bottom[l]);
            }
        } else if singular {
            // Between walls one equation of the singular mode says nothing new: r is zero.
            inverse[0] = 0.0;
        }
        let [last, first] = between(halves, &inverse, &ends);
        (beside[2], beside[3]) = ([ends[0], first], [last, ends[1]]);
    }
}

/// What stands beside the halves of `nodes`, the last of them first.
pub(super) struct Part<'a> {
    pub(super) which: &'a [usize],
    pub(super) nodes: &'a mut Nodes,
}

impl Kernel for Part<'_> {
    #[inline(always)]
    fn run<S: Simd>(self, _: S) {
        let Self { which, nodes: Nodes { edges, beside } } = self;
        for node in which.iter().rev() {
            let (halves, ends) = ([&edges[2 * node], &edges[2 * node + 1]], beside[*node]);
            let [last, first] = between(halves, &inverse(halves[0], halves[1]), &ends);
            (beside[2 * node], beside[2 * node + 1]) = ([ends[0], first], [last, ends[1]]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tops_are_the_largest_nodes_of_a_slab() {
        assert_eq!(tops(8, 0..8), [2, 3]);
        assert_eq!(tops(8, 0..4), [2]);
        assert_eq!(tops(8, 2..5), [5, 12]);
        assert_eq!(tops(8, 5..8), [13, 7]);
        assert_eq!(tops(2, 1..2), [3]);
        assert_eq!((below(8, &[5, 12]), above(8, &[4, 5, 12, 13, 7])), (vec![5], vec![6, 3, 2]));
        assert_eq!((below(8, &[2, 3]), above(8, &[2, 3])), (vec![7, 6, 5, 4, 3, 2], vec![]));
    }
}
