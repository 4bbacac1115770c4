//! All columns of a solve whose last axis is cut into blocks: by one process at once, or by several ranks.
//!
//! One process takes group after group of modes through elimination, the tree of blocks and substitution.
//! Ranks eliminate and join their blocks of all modes, send the edges of what these make to those who own the
//! modes (lines are shared among ranks), who join the rest and send back what stands beside. Each eliminates
//! again and substitutes: doing it twice costs less than keeping what the first pass leaves.

use super::block_sweep::{BLOCK, Eliminate, GROUP, Group, Row, Substitute};
use super::block_tree::{self, Close, Join, Nodes, Part};
use crate::division::{self, Division, blocks_of};
use crate::lanes::dispatch;
use crate::ranks::Ranks;
use crate::tridiagonal::Sweep;
use std::ops::Range;

/// A last axis in blocks.
pub(super) struct BlockColumns {
    pub(super) sweep: Sweep,
    /// Unknowns of each block.
    blocks: Vec<Range<usize>>,
    /// Blocks of this rank.
    own: Range<usize>,
    /// The nodes that each rank's blocks make.
    tops: Vec<Vec<usize>>,
    /// Nodes that this rank joins of its blocks, and those that the owner of a mode joins of all tops.
    below: Vec<usize>,
    above: Vec<usize>,
    periodic: bool,
    /// The ranks that share the columns.
    pub(super) ranks: Ranks,
}

/// Working memory of one thread.
#[derive(Default)]
pub(super) struct Memory {
    pub(super) rows: Vec<Row<BLOCK>>,
    nodes: Nodes,
    /// Edges of the modes that this rank owns, by rank, of the operators solved for last.
    known: Vec<([f64; 2], Vec<Vec<f64>>)>,
}

/// Operators of which edges are kept: one for each stage of a scheme.
const KEPT: usize = 3;

impl Memory {
    /// The edges that were kept of an operator. Every rank keeps those of the same operators.
    pub(super) fn recall(&mut self, operator: [f64; 2]) -> Option<Vec<Vec<f64>>> {
        let place = self.known.iter().position(|(known, _)| *known == operator)?;
        Some(self.known.remove(place).1)
    }

    /// Keeps the edges of an operator, and lets go of those that were not needed for longest.
    pub(super) fn keep(&mut self, operator: [f64; 2], edges: Vec<Vec<f64>>) {
        self.known.truncate(KEPT - 1);
        self.known.insert(0, (operator, edges));
    }
}

/// A group of modes where it stands.
pub(super) struct Modes<'a> {
    pub(super) operator: [f64; 2],
    pub(super) scale: f64,
    pub(super) lambda: &'a [f64; GROUP],
    /// Where they stand in each plane.
    pub(super) at: Range<usize>,
    /// Whether the first of them is known up to a constant only.
    pub(super) singular: bool,
}

/// An edge, as numbers.
const EDGE: usize = 6 * GROUP;

/// What stands beside a block, as numbers.
const BESIDE: usize = 2 * GROUP;

/// Edges for each mode that the rank which sends most sends, if so many ranks share so many planes.
pub fn most_edges(planes: usize, ranks: usize) -> usize {
    let count = division::blocks(planes);
    let edges = |rank| block_tree::tops(count, blocks_of(count, rank, ranks)).len();
    (0..ranks).map(edges).max().unwrap_or(0)
}

impl BlockColumns {
    /// `first`: plane of the first unknown.
    pub(super) fn new(sweep: Sweep, division: &Division, first: usize, periodic: bool) -> Self {
        let cuts = &division.cuts;
        let unknown = |plane: usize| plane.max(first) - first;
        let ranks = division.ranks().clone();
        let blocks: Vec<_> = cuts.windows(2).map(|pair| unknown(pair[0])..unknown(pair[1])).collect();
        let slab = |rank: usize| blocks_of(blocks.len(), rank, ranks.size());
        let tops: Vec<_> = (0..ranks.size()).map(|rank| block_tree::tops(blocks.len(), slab(rank))).collect();
        Self {
            sweep,
            own: slab(ranks.rank()),
            below: block_tree::below(blocks.len(), &tops[ranks.rank()]),
            above: block_tree::above(blocks.len(), &tops.concat()),
            blocks,
            tops,
            periodic,
            ranks,
        }
    }

    /// Unknowns of this rank.
    pub(super) fn own_unknowns(&self) -> Range<usize> {
        self.blocks[self.own.start].start..self.blocks[self.own.end - 1].end
    }

    /// Working memory for one thread.
    pub(super) fn memory(&self) -> Memory {
        Memory {
            rows: vec![[[[0.0; 8]; GROUP / 8]; BLOCK]; self.own_unknowns().len()],
            nodes: Nodes::new(self.blocks.len()),
            known: Vec::new(),
        }
    }

    /// Numbers of the nodes of this rank's blocks.
    fn own_nodes(&self) -> Range<usize> {
        self.blocks.len() + self.own.start..self.blocks.len() + self.own.end
    }

    /// Eliminates the own blocks of a group and joins them; `planes` are the own ones.
    fn eliminate(&self, modes: &Modes<'_>, planes: &[&mut [f64]], memory: &mut Memory) {
        let Modes { operator, scale, lambda, .. } = *modes;
        let Memory { rows, nodes: Nodes { edges, .. }, .. } = memory;
        let start = self.own_unknowns().start;
        for (block, edge) in self.blocks[self.own.clone()].iter().zip(&mut edges[self.own_nodes()]) {
            let here = block.start - start..block.end - start;
            dispatch(Eliminate {
                group: Group { sweep: &self.sweep, operator, scale, lambda },
                block: block.clone(),
                at: modes.at.clone(),
                source: &planes[here.clone()],
                rows: &mut rows[here],
                edge: Some(edge),
            });
        }
        dispatch(Join { nodes: &self.below, edges });
    }

    /// What stands beside the own blocks, from what stands beside the nodes that they make; substitutes.
    fn substitute(&self, modes: &Modes<'_>, planes: &mut [&mut [f64]], memory: &mut Memory) {
        let Memory { rows, nodes, .. } = memory;
        dispatch(Part { which: &self.below, nodes });
        let start = self.own_unknowns().start;
        for (block, beside) in self.blocks[self.own.clone()].iter().zip(&nodes.beside[self.own_nodes()]) {
            let here = block.start - start..block.end - start;
            let (rows, target) = (&rows[here.clone()], &mut planes[here]);
            dispatch(Substitute { rows, beside, at: modes.at.clone(), target });
        }
    }

    /// Solves a group of modes where all blocks are this process's.
    pub(super) fn solve(&self, modes: &Modes<'_>, planes: &mut [&mut [f64]], memory: &mut Memory) {
        self.eliminate(modes, planes, memory);
        let (periodic, singular) = (self.periodic, modes.singular);
        dispatch(Close { nodes: &mut memory.nodes, periodic, singular });
        self.substitute(modes, planes, memory);
    }

    /// First pass of a rank: the edges of what its blocks make.
    pub(super) fn first_pass(
        &self,
        modes: &Modes<'_>,
        planes: &[&mut [f64]],
        memory: &mut Memory,
        out: &mut [f64],
    ) {
        self.eliminate(modes, planes, memory);
        for (out, top) in out.chunks_exact_mut(EDGE).zip(&self.tops[self.ranks.rank()]) {
            out.copy_from_slice(memory.nodes.edges[*top].as_flattened());
        }
    }

    /// Last pass of a rank, with what stands beside what its blocks make.
    pub(super) fn last_pass(
        &self,
        modes: &Modes<'_>,
        planes: &mut [&mut [f64]],
        memory: &mut Memory,
        beside: &[f64],
    ) {
        self.eliminate(modes, planes, memory);
        for (from, top) in beside.chunks_exact(BESIDE).zip(&self.tops[self.ranks.rank()]) {
            memory.nodes.beside[*top].as_flattened_mut().copy_from_slice(from);
        }
        self.substitute(modes, planes, memory);
    }

    /// What stands beside the nodes of all ranks in group `group` of those that this rank owns: `edges` and
    /// `beside` hold those of all groups, rank after rank.
    pub(super) fn reduce(
        &self,
        group: usize,
        singular: bool,
        memory: &mut Memory,
        edges: &[Vec<f64>],
        beside: &mut [Vec<f64>],
    ) {
        let nodes = &mut memory.nodes;
        for (tops, from) in self.tops.iter().zip(edges) {
            let from = from[group * EDGE * tops.len()..].chunks_exact(EDGE);
            for (top, from) in tops.iter().zip(from) {
                nodes.edges[*top].as_flattened_mut().copy_from_slice(from);
            }
        }
        dispatch(Join { nodes: &self.above, edges: &mut nodes.edges });
        dispatch(Close { nodes, periodic: self.periodic, singular });
        dispatch(Part { which: &self.above, nodes });
        for (tops, to) in self.tops.iter().zip(beside) {
            let to = to[group * BESIDE * tops.len()..].chunks_exact_mut(BESIDE);
            for (top, to) in tops.iter().zip(to) {
                to.copy_from_slice(nodes.beside[*top].as_flattened());
            }
        }
    }

    /// Numbers of the edges of one group that rank `rank` sends, and of what it gets for them.
    pub(super) fn sizes_of(&self, rank: usize) -> [usize; 2] {
        [EDGE, BESIDE].map(|size| size * self.tops[rank].len())
    }
}
