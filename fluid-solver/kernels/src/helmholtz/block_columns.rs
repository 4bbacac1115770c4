//! All columns of a solve whose last axis is cut into blocks: by one process at once, or by several ranks.
//!
//! One process takes group after group of modes through elimination, reduced system and substitution. Ranks
//! eliminate their blocks of all modes, send the edges to those who own the modes (lines are shared among
//! ranks), solve the reduced systems there, send back what stands beside each block, eliminate again and
//! substitute: doing it twice costs less than keeping what the first pass leaves.

use super::block_sweep::{BLOCK, Beside, Edge, Eliminate, GROUP, Group, Row, Substitute};
use super::reduced::{Between, Reduce};
use crate::division::Division;
use crate::lanes::dispatch;
use crate::ranks::Ranks;
use crate::tridiagonal::Sweep;
use pulp::bytemuck;
use std::ops::Range;

/// A last axis in blocks.
pub(super) struct BlockColumns {
    pub(super) sweep: Sweep,
    /// Unknowns of each block.
    blocks: Vec<Range<usize>>,
    /// Blocks of each rank.
    slabs: Vec<Range<usize>>,
    periodic: bool,
    /// The ranks that share the columns.
    pub(super) ranks: Ranks,
}

/// Working memory of one thread.
#[derive(Default)]
pub(super) struct Memory {
    pub(super) rows: Vec<Row<BLOCK>>,
    edges: Vec<Edge>,
    between: Vec<Between>,
    beside: Vec<Beside>,
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

impl BlockColumns {
    /// `first`: plane of the first unknown.
    pub(super) fn new(sweep: Sweep, division: &Division, first: usize, periodic: bool) -> Self {
        let cuts = &division.cuts;
        let unknown = |plane: usize| plane.max(first) - first;
        let place = |plane: usize| cuts.iter().position(|cut| *cut == plane).expect("slabs are whole blocks");
        let ranks = division.ranks().clone();
        Self {
            sweep,
            blocks: cuts.windows(2).map(|pair| unknown(pair[0])..unknown(pair[1])).collect(),
            slabs: (0..ranks.size())
                .map(|rank| place(division.of(rank).start)..place(division.of(rank).end))
                .collect(),
            periodic,
            ranks,
        }
    }

    /// Blocks of this rank.
    fn own(&self) -> Range<usize> {
        self.slabs[self.ranks.rank()].clone()
    }

    /// Unknowns of this rank.
    pub(super) fn own_unknowns(&self) -> Range<usize> {
        let own = self.own();
        self.blocks[own.start].start..self.blocks[own.end - 1].end
    }

    /// Working memory for one thread.
    pub(super) fn memory(&self) -> Memory {
        let count = self.blocks.len();
        Memory {
            rows: vec![[[[0.0; 8]; GROUP / 8]; BLOCK]; self.own_unknowns().len()],
            edges: vec![[[0.0; GROUP]; 6]; count],
            between: vec![[[0.0; GROUP]; 6]; count - 1],
            beside: vec![[[0.0; GROUP]; 2]; count],
            known: Vec::new(),
        }
    }

    /// Eliminates the own blocks of a group, the first pass of a rank; `planes` are the own ones.
    pub(super) fn eliminate(
        &self,
        modes: &Modes<'_>,
        planes: &[&mut [f64]],
        rows: &mut [Row<BLOCK>],
        edges: &mut [Edge],
    ) {
        let Modes { operator, scale, lambda, .. } = *modes;
        let start = self.own_unknowns().start;
        for (block, edge) in self.blocks[self.own()].iter().zip(edges) {
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
    }

    /// Substitutes in the own blocks of a group.
    fn substitute(
        &self,
        modes: &Modes<'_>,
        rows: &[Row<BLOCK>],
        beside: &[Beside],
        planes: &mut [&mut [f64]],
    ) {
        let start = self.own_unknowns().start;
        for (block, beside) in self.blocks[self.own()].iter().zip(beside) {
            let here = block.start - start..block.end - start;
            let (rows, target) = (&rows[here.clone()], &mut planes[here]);
            dispatch(Substitute { rows, beside, at: modes.at.clone(), target });
        }
    }

    /// Solves a group of modes where all blocks are this process's.
    pub(super) fn solve(&self, modes: &Modes<'_>, planes: &mut [&mut [f64]], memory: &mut Memory) {
        let Memory { rows, edges, between, beside, .. } = memory;
        self.eliminate(modes, planes, rows, edges);
        dispatch(Reduce { edges, between, beside, periodic: self.periodic, singular: modes.singular });
        self.substitute(modes, rows, beside, planes);
    }

    /// Last pass of a rank, with what stands beside its blocks.
    pub(super) fn close(
        &self,
        modes: &Modes<'_>,
        planes: &mut [&mut [f64]],
        memory: &mut Memory,
        beside: &[f64],
    ) {
        let count = self.own().len();
        self.eliminate(modes, planes, &mut memory.rows, &mut memory.edges[..count]);
        self.substitute(modes, &memory.rows, bytemuck::cast_slice(beside), planes);
    }

    /// The reduced system of group `group` of those that this rank owns: `edges` and `beside` hold those of
    /// all groups, rank after rank.
    pub(super) fn reduce(
        &self,
        group: usize,
        singular: bool,
        memory: &mut Memory,
        edges: &[Vec<f64>],
        beside: &mut [Vec<f64>],
    ) {
        let all = &mut memory.edges;
        for (slab, from) in self.slabs.iter().zip(edges) {
            let size = EDGE * slab.len();
            let from = &from[group * size..][..size];
            all[slab.clone()].as_flattened_mut().as_flattened_mut().copy_from_slice(from);
        }
        let Memory { between, beside: found, .. } = memory;
        dispatch(Reduce { edges: all, between, beside: found, periodic: self.periodic, singular });
        for (slab, to) in self.slabs.iter().zip(beside) {
            let size = BESIDE * slab.len();
            let to = &mut to[group * size..][..size];
            to.copy_from_slice(found[slab.clone()].as_flattened().as_flattened());
        }
    }

    /// Numbers of the edges of one group that rank `rank` sends, and of what it gets for them.
    pub(super) fn sizes_of(&self, rank: usize) -> [usize; 2] {
        [EDGE, BESIDE].map(|size| size * self.slabs[rank].len())
    }
}
