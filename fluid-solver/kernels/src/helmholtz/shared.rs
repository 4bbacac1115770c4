//! A solve that ranks share, see [`super::block_columns`].

use super::block_columns::{BlockColumns, Modes};
use super::block_sweep::GROUP;
use super::edges::Sent;
use super::space_columns::{Memory, Solve, SpaceColumns, mean};
use crate::threads::share;
use std::ops::Range;

/// The lines of modes that rank `rank` of `size` owns, of `lines`.
fn owned(lines: usize, rank: usize, size: usize) -> Range<usize> {
    lines * rank / size..lines * (rank + 1) / size
}

/// Calls `task` for every share with its part of `numbers`, which has `each` of them for a line.
fn for_shares(
    shares: &mut [Solve<'_, '_>],
    numbers: &mut [f64],
    each: usize,
    task: impl Fn(&mut Solve<'_, '_>, &mut [f64]) + Sync,
) {
    let mut rest = numbers;
    let cut = |share| {
        let share: &mut Solve<'_, '_> = share;
        let (part, after) = std::mem::take(&mut rest).split_at_mut(share.lines.len() * each);
        rest = after;
        (share, part)
    };
    let mut parts: Vec<_> = shares.iter_mut().map(cut).collect();
    let count = parts.len();
    share(&mut parts[..], 0..count, 1, &|_, parts| {
        parts.iter_mut().for_each(|(share, part)| task(share, part));
    });
}

impl SpaceColumns {
    /// Groups of a line.
    fn groups(&self) -> usize {
        self.modes.div_ceil(GROUP)
    }

    /// Calls `task` with every group of `share`: its number in the share, and its modes.
    fn for_groups(
        &self,
        share: &mut Solve<'_, '_>,
        mut task: impl FnMut(usize, &Modes<'_>, &mut Solve<'_, '_>),
    ) {
        let (lines, operator, row) = (share.lines.clone(), share.operator, share.row);
        for (line, j) in lines.enumerate() {
            for group in 0..self.groups() {
                let i = group * GROUP;
                let lambda = self.lambda([i, j]);
                let modes = Modes {
                    operator,
                    scale: self.scale,
                    lambda: &lambda,
                    at: line * row + i..line * row + self.modes.min(i + GROUP),
                    singular: operator[0] == 0.0 && lambda[0] == 0.0,
                };
                task(line * self.groups() + group, &modes, share);
            }
        }
    }

    /// First pass: the edges of what the blocks make, of all modes, line after line.
    fn edges(&self, blocks: &BlockColumns, shares: &mut [Solve<'_, '_>], lines: usize) -> Vec<f64> {
        let [size, _] = blocks.sizes_of(blocks.ranks.rank());
        let mut edges = vec![0.0; lines * self.groups() * size];
        for_shares(shares, &mut edges, self.groups() * size, |share, out| {
            self.for_groups(share, |group, modes, share| {
                let Solve { planes, memory, .. } = share;
                blocks.first_pass(modes, planes, &mut memory.blocks, &mut out[group * size..][..size]);
            });
        });
        edges
    }

    /// The reduced systems of the lines that this rank owns, from the edges of all ranks.
    fn reduce(
        &self,
        blocks: &BlockColumns,
        operator: [f64; 2],
        lines: Range<usize>,
        edges: &[Vec<f64>],
        memory: &mut Memory,
    ) -> Vec<Vec<f64>> {
        let ranks = 0..blocks.ranks.size();
        let room = |rank| vec![0.0; lines.len() * self.groups() * blocks.sizes_of(rank)[1]];
        let mut beside: Vec<Vec<f64>> = ranks.map(room).collect();
        for group in 0..lines.len() * self.groups() {
            let (j, i) = (lines.start + group / self.groups(), group % self.groups() * GROUP);
            let singular = operator[0] == 0.0 && self.lambda([i, j])[0] == 0.0;
            blocks.reduce(group, singular, &mut memory.blocks, edges, &mut beside);
        }
        beside
    }

    /// Edges go to the owners of the modes, and what stands beside the blocks comes back.
    fn exchange(
        &self,
        blocks: &BlockColumns,
        operator: [f64; 2],
        lines: usize,
        edges: &[f64],
        memory: &mut Memory,
    ) -> Vec<f64> {
        let ranks = &blocks.ranks;
        let (me, size) = (ranks.rank(), ranks.size());
        let mine = owned(lines, me, size);
        let [edge, beside] = blocks.sizes_of(me).map(|numbers| numbers * self.groups());
        let part = |rank: usize, each: usize| {
            let lines = owned(lines, rank, size);
            lines.start * each..lines.end * each
        };
        let others = || (0..size).filter(|rank| *rank != me);
        let room = |rank| vec![0.0; mine.len() * self.groups() * blocks.sizes_of(rank)[0]];
        let known = memory.blocks.recall(operator);
        let sent = if known.is_some() { Sent::Constants } else { Sent::All };
        let mut received: Vec<Vec<f64>> = known.unwrap_or_else(|| (0..size).map(room).collect());
        received[me].copy_from_slice(&edges[part(me, edge)]);
        let packed: Vec<_> = others().map(|rank| (rank, sent.pack(&edges[part(rank, edge)]))).collect();
        let mut coming: Vec<_> =
            others().map(|rank| (rank, vec![0.0; sent.length(received[rank].len())])).collect();
        let out: Vec<_> = packed.iter().map(|(rank, numbers)| (*rank, &numbers[..])).collect();
        let mut into: Vec<_> = coming.iter_mut().map(|(rank, numbers)| (*rank, &mut numbers[..])).collect();
        ranks.exchange(&out, &mut into);
        for (rank, numbers) in &coming {
            sent.unpack(numbers, &mut received[*rank]);
        }
        let found = self.reduce(blocks, operator, mine, &received, memory);
        memory.blocks.keep(operator, received);
        let mut all = vec![0.0; lines * beside];
        let mut rest = &mut all[..];
        let mut into = Vec::new();
        for rank in 0..size {
            let (to, after) = std::mem::take(&mut rest).split_at_mut(part(rank, beside).len());
            rest = after;
            if rank == me {
                to.copy_from_slice(&found[me]);
            } else {
                into.push((rank, to));
            }
        }
        let out: Vec<_> = others().map(|rank| (rank, &found[rank][..])).collect();
        ranks.exchange(&out, &mut into);
        all
    }

    /// Solves the columns of which each rank has its blocks; `shares` are those of the threads.
    pub(super) fn solve_shared(&self, blocks: &BlockColumns, shares: &mut [Solve<'_, '_>], lines: usize) {
        let operator = shares[0].operator;
        let edges = self.edges(blocks, shares, lines);
        let mut beside = self.exchange(blocks, operator, lines, &edges, shares[0].memory);
        let [_, size] = blocks.sizes_of(blocks.ranks.rank());
        for_shares(shares, &mut beside, self.groups() * size, |share, beside| {
            self.for_groups(share, |group, modes, share| {
                let Solve { planes, memory, .. } = share;
                let beside = &beside[group * size..][..size];
                blocks.last_pass(modes, planes, &mut memory.blocks, beside);
            });
        });
        if operator[0] == 0.0 && self.lambda([0, 0])[0] == 0.0 {
            let own: Vec<f64> = shares[0].planes.iter().map(|plane| plane[0]).collect();
            let all = blocks.ranks.gather(&own).concat();
            let mut mean = [if all.is_empty() { 0.0 } else { mean(&blocks.sweep, all.iter()) }];
            blocks.ranks.spread(&mut mean);
            shares[0].planes.iter_mut().for_each(|plane| plane[0] -= mean[0]);
        }
    }
}
