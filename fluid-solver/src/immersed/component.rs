//! One velocity component with the grains in it: sums over grains, forcing, integrals.
//!
//! Many grains share a point by their odds (numerics, "sum χ"): `b_i = q_i / (1 + Σ q)`, so that
//! with `S = Σ q` and `T = Σ q U` every rule below needs two numbers per cell, smooth and bounded
//! however the grains overlap.

use super::body::{Motion, Shape, laboratory};
use super::cover::{Cover, Nodes, Span};
use super::mask::Kernel;
use crate::grid::Grid;
use rayon::prelude::*;

/// Cells below which a second thread costs more than it brings.
pub const WORTH_A_THREAD: usize = 16_384;

/// Marks a cell that the present pass has already changed; sums of odds are never negative.
const DONE: f64 = -1.0;

/// ∫ f dV over one grain for one component, and its first moments ∫ f r dV (laboratory axes).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Moments {
    /// ∫ f dV.
    pub sum: f64,
    /// ∫ f r dV, r from the grain's centre.
    pub arm: [f64; 3],
}

/// What an integrand may depend on.
#[derive(Clone, Copy, Debug)]
pub struct Point {
    /// Place in the field.
    pub index: usize,
    /// Odds of this grain.
    pub odds: f64,
    /// Odds of all grains here.
    pub total: f64,
    /// Velocity of this grain here, m/s.
    pub solid: f64,
}

impl Point {
    /// Share b of this grain.
    #[inline]
    pub fn share(&self) -> f64 {
        self.odds / (1.0 + self.total)
    }
}

/// The grains at the nodes of one component.
#[derive(Clone, Debug)]
pub struct Component<const D: usize> {
    nodes: Nodes<D>,
    /// Laboratory component.
    lab: usize,
    /// Where the grains are placed now.
    covers: Vec<Cover>,
    /// Where they were when the force was last imposed: its support.
    held: Vec<Cover>,
    odds: Vec<f64>,
    target: Vec<f64>,
    /// Result of the last integral, one entry per grain.
    pub moments: Vec<Moments>,
}

impl<const D: usize> Component<D> {
    /// Room for `grains` grains at the nodes of component `d`.
    pub fn new(grid: &Grid<D>, d: usize, grains: usize) -> Self {
        Self {
            nodes: Nodes::new(grid, d),
            lab: laboratory(grid.geometry, d.min(D - 1)),
            covers: vec![Cover::default(); grains],
            held: vec![Cover::default(); grains],
            odds: if grains > 0 { grid.new_field() } else { Vec::new() },
            target: if grains > 0 { grid.new_field() } else { Vec::new() },
            moments: vec![Moments::default(); grains],
        }
    }

    /// Number of cells that the grains hold.
    pub fn cells(&self) -> usize {
        self.covers.iter().map(Cover::cells).sum()
    }

    /// Finds the cells of every grain.
    pub fn place(&mut self, grid: &Grid<D>, kernel: &Kernel, shapes: &[Shape], motions: &[Motion]) {
        let nodes = &self.nodes;
        let one = |(cover, (shape, motion)): (&mut Cover, (&Shape, &Motion))| {
            cover.place(grid, nodes, kernel, motion.centre, shape.radius);
        };
        let known: usize = self.covers.iter().map(Cover::cells).sum();
        if rayon::current_num_threads() > 1 && known > WORTH_A_THREAD {
            self.covers.par_iter_mut().zip(shapes.par_iter().zip(motions)).for_each(one);
        } else {
            self.covers.iter_mut().zip(shapes.iter().zip(motions)).for_each(one);
        }
    }

    /// Exchanges the present places with those that hold the force.
    pub fn swap(&mut self) {
        std::mem::swap(&mut self.covers, &mut self.held);
    }

    /// Sums odds, and odds times velocity, over all grains.
    pub fn gather(&mut self, grid: &Grid<D>, motions: &[Motion]) {
        let along = grid.nodes(self.nodes_of(), 0);
        for (cover, motion) in self.covers.iter().zip(motions) {
            for (span, odds) in cover.rows() {
                let (base, slope) = line(motion, self.lab, span);
                let sums = &mut self.odds[span.start..][..span.count];
                let targets = &mut self.target[span.start..][..span.count];
                let along = &along[span.first..][..span.count];
                for (((sum, target), q), x) in sums.iter_mut().zip(targets).zip(odds).zip(along) {
                    *sum += q;
                    *target += q * (base + slope * (x + span.arm[0]));
                }
            }
        }
    }

    /// Forgets the sums.
    pub fn clear(&mut self) {
        for span in self.covers.iter().chain(&self.held).flat_map(Cover::spans) {
            self.odds[span.start..][..span.count].fill(0.0);
            self.target[span.start..][..span.count].fill(0.0);
        }
    }

    /// Calls `change(place, Σq, ΣqU)` once for every cell of a grain, and where `old` says so for
    /// every cell that held force before. The sums are used up.
    pub fn change(&mut self, old: bool, mut change: impl FnMut(usize, f64, f64)) {
        let held: &[Cover] = if old { &self.held } else { &[] };
        for span in self.covers.iter().chain(held).flat_map(Cover::spans) {
            for index in span.start..span.start + span.count {
                let sum = self.odds[index];
                if sum != DONE {
                    change(index, sum, self.target[index]);
                    self.odds[index] = DONE;
                }
            }
        }
        self.clear();
    }

    /// `moments` ← ∫ `value` dV over every grain, in the fixed order of cells.
    pub fn integrate(&mut self, grid: &Grid<D>, motions: &[Motion], value: impl Fn(Point) -> f64) {
        let d = self.nodes_of();
        let (along, volumes) = (grid.nodes(d, 0), grid.volumes(d, 0));
        for ((cover, motion), moments) in self.covers.iter().zip(motions).zip(&mut self.moments) {
            *moments = Moments::default();
            for (span, odds) in cover.rows() {
                let (base, slope) = line(motion, self.lab, span);
                let along = &along[span.first..][..span.count];
                let volumes = &volumes[span.first..][..span.count];
                let totals = &self.odds[span.start..][..span.count];
                let (mut sum, mut arm) = (0.0, 0.0);
                for (k, q) in odds.iter().enumerate() {
                    let r = along[k] + span.arm[0];
                    let solid = base + slope * r;
                    let point = Point { index: span.start + k, odds: *q, total: totals[k], solid };
                    let f = value(point) * volumes[k];
                    sum += f;
                    arm += f * r;
                }
                moments.sum += span.weight * sum;
                moments.arm[0] += span.weight * arm;
                for c in 1..3 {
                    moments.arm[c] += span.weight * span.arm[c] * sum;
                }
            }
        }
    }

    /// The `d` that [`Grid::nodes`] wants.
    fn nodes_of(&self) -> usize {
        self.nodes.component()
    }
}

/// Rigid velocity along a row: value at arm 0 along axis 0, and slope along it.
#[inline]
fn line(motion: &Motion, c: usize, span: &Span) -> (f64, f64) {
    (motion.velocity_at(c, [0.0, span.arm[1], span.arm[2]]), motion.slope(c, 0))
}
