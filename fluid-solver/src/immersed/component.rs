//! One velocity component with the grains in it: sums over grains, forcing, integrals.
//!
//! Many grains share a point by their odds (numerics, "sum χ"): `b_i = q_i / (1 + Σ q)`, so that
//! with `S = Σ q` and `T = Σ q U` every rule below needs two numbers per cell, smooth and bounded
//! however the grains overlap.

use super::body::{Motion, Shape, laboratory};
use super::cover::{Cover, Nodes, Span};
use super::mask::Kernel;
use crate::grid::Grid;
use crate::lanes::{self, dispatch};
use pulp::Simd;
use rayon::prelude::*;

/// Cells below which a second thread costs more than it brings.
pub const WORTH_A_THREAD: usize = 16_384;

/// Marks a cell that the present pass has already changed; sums of odds are never negative.
pub const DONE: f64 = -1.0;

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
pub struct Point<const N: usize> {
    /// Values of the fields.
    pub fields: [f64; N],
    /// Odds of this grain.
    pub odds: f64,
    /// Odds of all grains here.
    pub total: f64,
    /// Velocity of this grain here, m/s.
    pub solid: f64,
}

impl<const N: usize> Point<N> {
    /// Share b of this grain.
    #[inline(always)]
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
        dispatch(Gather { component: self, along, motions });
    }

    /// Forgets the sums.
    pub fn clear(&mut self) {
        for span in self.covers.iter().chain(&self.held).flat_map(Cover::spans) {
            self.odds[span.cells()].fill(0.0);
            self.target[span.cells()].fill(0.0);
        }
    }

    /// Applies `rule` once to every cell of a grain, and where `old` says so to every cell that held force
    /// before. The sums are used up.
    pub fn change(&mut self, old: bool, rule: impl Rule) {
        dispatch(Change { component: self, old, rule });
        self.clear();
    }

    /// `moments` ← ∫ `value` dV over every grain, in the fixed order of cells; it may depend on `fields`.
    pub fn integrate<const N: usize>(
        &mut self,
        grid: &Grid<D>,
        motions: &[Motion],
        fields: [&[f64]; N],
        value: impl Fn(Point<N>) -> f64,
    ) {
        let d = self.nodes_of();
        let (along, volumes) = (grid.nodes(d, 0), grid.volumes(d, 0));
        dispatch(Integrate { component: self, along, volumes, motions, fields, value });
    }

    /// The `d` that [`Grid::nodes`] wants.
    fn nodes_of(&self) -> usize {
        self.nodes.component()
    }
}

/// Rigid velocity along a row: value at arm 0 along axis 0, and slope along it.
#[inline(always)]
fn line(motion: &Motion, c: usize, span: &Span) -> (f64, f64) {
    (motion.velocity_at(c, [0.0, span.arm[1], span.arm[2]]), motion.slope(c, 0))
}

/// [`Component::gather`].
struct Gather<'a, const D: usize> {
    component: &'a mut Component<D>,
    along: &'a [f64],
    motions: &'a [Motion],
}

impl<const D: usize> lanes::Kernel for Gather<'_, D> {
    #[inline(always)]
    fn run<S: Simd>(self, _: S) {
        let Component { covers, odds: sums, target: targets, lab, .. } = self.component;
        for (cover, motion) in covers.iter().zip(self.motions) {
            for (span, odds) in cover.rows() {
                let (base, slope) = line(motion, *lab, span);
                let n = odds.len();
                let (sums, targets) = (&mut sums[span.start..][..n], &mut targets[span.start..][..n]);
                let along = &self.along[span.first..][..n];
                for k in 0..n {
                    sums[k] += odds[k];
                    targets[k] += odds[k] * (base + slope * (along[k] + span.arm[0]));
                }
            }
        }
    }
}

/// What is done to the fields where grains are.
pub trait Rule {
    /// Changes the cells from place `start` on, unless their Σq is [`DONE`].
    fn row(&mut self, start: usize, odds: &[f64], target: &[f64]);
}

/// [`Component::change`].
struct Change<'a, R, const D: usize> {
    component: &'a mut Component<D>,
    old: bool,
    rule: R,
}

impl<R: Rule, const D: usize> lanes::Kernel for Change<'_, R, D> {
    #[inline(always)]
    fn run<S: Simd>(mut self, _: S) {
        let Component { covers, held, odds, target, .. } = self.component;
        let held: &[Cover] = if self.old { held } else { &[] };
        for span in covers.iter().chain(held).flat_map(Cover::spans) {
            let odds = &mut odds[span.cells()];
            self.rule.row(span.start, odds, &target[span.cells()]);
            odds.fill(DONE);
        }
    }
}

/// Cells of a row that are summed together.
const PIECE: usize = 64;

/// [`Component::integrate`].
struct Integrate<'a, F, const N: usize, const D: usize> {
    component: &'a mut Component<D>,
    along: &'a [f64],
    volumes: &'a [f64],
    motions: &'a [Motion],
    fields: [&'a [f64]; N],
    value: F,
}

impl<F: Fn(Point<N>) -> f64, const N: usize, const D: usize> lanes::Kernel for Integrate<'_, F, N, D> {
    #[inline(always)]
    fn run<S: Simd>(self, _: S) {
        let Component { covers, odds: totals, moments, lab, .. } = self.component;
        let (mut values, mut arms) = ([0.0; PIECE], [0.0; PIECE]);
        for ((cover, motion), moments) in covers.iter().zip(self.motions).zip(moments) {
            *moments = Moments::default();
            for (span, odds) in cover.rows() {
                let (base, slope) = line(motion, *lab, span);
                for (piece, odds) in odds.chunks(PIECE).enumerate() {
                    let (n, first) = (odds.len(), piece * PIECE);
                    let along = &self.along[span.first + first..][..n];
                    let volumes = &self.volumes[span.first + first..][..n];
                    let totals = &totals[span.start + first..][..n];
                    let fields = self.fields.map(|field| &field[span.start + first..][..n]);
                    for k in 0..n {
                        let r = along[k] + span.arm[0];
                        let fields = std::array::from_fn(|f| fields[f][k]);
                        let point =
                            Point { fields, odds: odds[k], total: totals[k], solid: base + slope * r };
                        values[k] = (self.value)(point) * volumes[k];
                        arms[k] = values[k] * r;
                    }
                    let (sum, arm) = (sum(&mut values, n), sum(&mut arms, n));
                    moments.sum += span.weight * sum;
                    moments.arm[0] += span.weight * arm;
                    for c in 1..3 {
                        moments.arm[c] += span.weight * span.arm[c] * sum;
                    }
                }
            }
        }
    }
}

/// Sum of the first `n` of `values`, eight by eight; those up to the next eight are lost.
#[inline(always)]
fn sum(values: &mut [f64; PIECE], n: usize) -> f64 {
    let whole = n.next_multiple_of(8);
    values[n..whole].fill(0.0);
    let mut sums = [0.0; 8];
    for eight in values[..whole].as_chunks::<8>().0 {
        for l in 0..8 {
            sums[l] += eight[l];
        }
    }
    ((sums[0] + sums[4]) + (sums[2] + sums[6])) + ((sums[1] + sums[5]) + (sums[3] + sums[7]))
}
