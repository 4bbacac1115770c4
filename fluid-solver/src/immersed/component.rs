//! One velocity component with the grains in it: sums over grains, forcing, integrals.
//!
//! Many grains share a point by their odds (docs/numerics.md, Mask): `b_i = q_i / (1 + Σ q)`, so that
//! with `S = Σ q` and `T = Σ q U` every rule below needs two numbers per cell, smooth and bounded
//! however the grains overlap.

use super::body::{Motion, Shape, laboratory};
use super::by_layer::GrainsByLayer;
use super::layer::Layer;
use super::layers::Layers;
use super::mask::Kernel;
use super::sheet::{Sheet, first, words};
use super::transport::rows::Rows;
use crate::grid::Grid;
use crate::lanes::{self, Lanes, ZERO, dispatch, eight, eight_mut};
use pulp::Simd;
use rayon::prelude::*;
use std::ops::Range;

/// Cells below which a second thread costs more than it brings.
const WORTH_A_THREAD: f64 = 16_384.0;

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

/// What is done to `N` fields where grains are, eight cells at a time.
pub trait Rule<const N: usize>: Sync {
    /// Changes cells with the given sums of odds, and of odds times velocity. Without odds a cell must stay
    /// what it is, unless it held force before.
    fn change(&self, odds: &Lanes, target: &Lanes, fields: [&mut Lanes; N]);
}

/// What a thread works with: it takes one layer after the other.
#[derive(Clone, Debug, Default)]
pub struct Bench {
    pub(super) sheet: Sheet,
    /// Rows that are interpolated between.
    pub(super) rows: Rows,
    /// Grains and their integrals over one layer, in the order of layers.
    moments: Vec<(usize, Moments)>,
}

/// The grains at the nodes of one component.
#[derive(Clone, Debug)]
pub struct Component<const D: usize> {
    pub(super) layers: Layers<D>,
    /// Laboratory component.
    lab: usize,
    /// Eights of cells that may hold force, as in [`Sheet`].
    held: Vec<u64>,
    /// Room for as many.
    pub(super) next: Vec<u64>,
    /// Result of the last integral, one entry per grain.
    pub moments: Vec<Moments>,
}

/// Grains, the mask and the places in which they are taken.
#[derive(Clone, Copy)]
pub struct Placed<'a, const D: usize> {
    /// The grid.
    pub grid: &'a Grid<D>,
    /// The mask.
    pub kernel: &'a Kernel,
    /// What never changes about the grains.
    pub shapes: &'a [Shape],
    /// Where they are and how they move.
    pub motions: &'a [Motion],
}

impl<const D: usize> Component<D> {
    /// Room for `grains` grains at the nodes of component `d`. `keeps`: whether what they hold is kept until they move.
    pub fn new(grid: &Grid<D>, d: usize, grains: usize, keeps: bool) -> Self {
        let rows = grid.stride(D - 1) / grid.stride(1) * grid.cells[D - 1];
        Self {
            layers: Layers::new(grid, d, keeps),
            lab: laboratory(grid.geometry, d),
            held: if grains > 0 { vec![0; rows * words(grid)] } else { Vec::new() },
            next: Vec::new(),
            moments: vec![Moments::default(); grains],
        }
    }

    /// Eights of cells that may hold force: a bit each, layer by layer.
    pub(super) fn held(&self) -> &[u64] {
        &self.held
    }

    /// The same, to be changed.
    pub(super) fn held_mut(&mut self) -> &mut Vec<u64> {
        &mut self.held
    }

    /// Finds the layers of every grain.
    pub(super) fn place(&mut self, placed: Placed<'_, D>) {
        self.layers.place(placed.grid, placed.kernel, placed.shapes, placed.motions);
    }

    /// Splits the layers among as many benches as there is work for; returns layers per bench.
    pub(super) fn split<'b>(&self, grid: &Grid<D>, benches: &'b mut Vec<Bench>) -> (&'b mut [Bench], usize) {
        let threads = rayon::current_num_threads();
        let wanted = if threads > 1 && self.layers.grains.cells() > WORTH_A_THREAD { 4 * threads } else { 1 };
        let layers = grid.cells[D - 1];
        let share = layers.div_ceil(wanted);
        let count = layers.div_ceil(share);
        if benches.len() < count {
            benches.resize_with(count, Bench::default);
        }
        let benches = &mut benches[..count];
        benches.iter_mut().for_each(|bench| bench.sheet.fit(grid));
        (benches, share)
    }

    /// `moments` ← ∫ `value` dV over every grain, in the fixed order of cells; it may depend on `fields`.
    pub fn integrate<const N: usize>(
        &mut self,
        placed: Placed<'_, D>,
        benches: &mut Vec<Bench>,
        fields: [&[f64]; N],
        value: impl Fn(Point<N>) -> f64 + Sync,
    ) {
        self.place(placed);
        let (benches, share) = self.split(placed.grid, benches);
        let n = placed.grid.cells[D - 1];
        let Self { layers, lab, moments, .. } = self;
        let (grains, held, entries) = layers.shared(placed.grid, share);
        let one = |(t, (bench, held)): (usize, (&mut Bench, &mut [Layer]))| {
            let range = t * share..((t + 1) * share).min(n);
            dispatch(Integrate { placed, grains, held, lab: *lab, range, bench, fields, value: &value });
        };
        if benches.len() > 1 {
            benches.par_iter_mut().zip(held.par_chunks_mut(entries)).enumerate().for_each(one);
        } else {
            benches.iter_mut().zip(held.chunks_mut(entries)).enumerate().for_each(one);
        }
        moments.fill(Moments::default());
        for (grain, part) in benches.iter().flat_map(|bench| &bench.moments) {
            let moments = &mut moments[*grain];
            moments.sum += part.sum;
            for c in 0..3 {
                moments.arm[c] += part.arm[c];
            }
        }
    }

    /// Applies `rule` once to every cell of a grain, and to every cell that may have held force before.
    pub fn change<const N: usize>(
        &mut self,
        placed: Placed<'_, D>,
        benches: &mut Vec<Bench>,
        fields: [&mut [f64]; N],
        rule: &impl Rule<N>,
    ) {
        if self.moments.is_empty() {
            return;
        }
        self.place(placed);
        let grid = placed.grid;
        let (benches, share) = self.split(grid, benches);
        let Self { layers, lab, held: marked, .. } = self;
        let (grains, held, entries) = layers.shared(grid, share);
        let n = grid.cells[D - 1];
        let (begin, size) = (first(grid, 0), grid.stride(D - 1));
        let marks = marked.len() / n;
        let mut fields = fields.map(|field| field[begin..begin + n * size].chunks_mut(share * size));
        let parts = benches.iter_mut().zip(held.chunks_mut(entries)).zip(marked.chunks_mut(share * marks));
        let parts = parts.enumerate().map(|(t, ((bench, held), marked))| Change {
            placed,
            grains,
            held,
            lab: *lab,
            first: t * share,
            sheet: &mut bench.sheet,
            marked,
            marks,
            fields: fields.each_mut().map(|chunks| chunks.next().expect("as many as benches")),
            rule,
        });
        if share < n {
            parts.par_bridge().for_each(dispatch);
        } else {
            parts.for_each(dispatch);
        }
    }
}

/// [`Component::integrate`] over some layers.
struct Integrate<'a, F, const N: usize, const D: usize> {
    placed: Placed<'a, D>,
    grains: &'a GrainsByLayer<D>,
    held: &'a mut [Layer],
    lab: usize,
    range: Range<usize>,
    bench: &'a mut Bench,
    fields: [&'a [f64]; N],
    value: &'a F,
}

impl<F: Fn(Point<N>) -> f64, const N: usize, const D: usize> lanes::Kernel for Integrate<'_, F, N, D> {
    #[inline(always)]
    fn run<S: Simd>(self, _: S) {
        let Placed { grid, kernel, motions, .. } = self.placed;
        let Bench { sheet, moments, .. } = self.bench;
        let row = &self.grains.nodes.row;
        let entries = self.held.len();
        moments.clear();
        for k in self.range.clone() {
            let layer = &mut self.held[(k - self.range.start) % entries];
            layer.fill(grid, self.grains, kernel, k, &mut sheet.profiles);
            sheet.gather(layer);
            let begin = first(grid, k);
            let fields = self.fields.map(|field| &field[begin..][..grid.stride(D - 1)]);
            for (part, spans, odds) in layer.parts() {
                let motion = &motions[part.grain];
                let mut sums = [ZERO; 3];
                let mut rest = odds.as_chunks::<8>().0;
                for span in spans {
                    let [base, slope] = span.velocity(motion, self.lab, part.arm);
                    let (mine, after) = rest.split_at(span.count / 8);
                    rest = after;
                    for (b, odds) in mine.iter().enumerate() {
                        let (at, x) = (span.at + 8 * b, span.first + 8 * b);
                        let (x, volume) = (eight(&row.at, x), eight(&row.volume, x));
                        let totals = eight(&sheet.totals, at);
                        let fields = fields.map(|field| eight(field, at));
                        for l in 0..8 {
                            let point = Point {
                                fields: std::array::from_fn(|f| fields[f][l]),
                                odds: odds[l],
                                total: totals[l],
                                solid: base + slope * x[l],
                            };
                            let value = (self.value)(point) * volume[l] * span.weight;
                            sums[0][l] += value;
                            sums[1][l] += value * (x[l] + span.shift);
                            sums[2][l] += value * span.middle;
                        }
                    }
                }
                let [sum, along, middle] = sums.map(total);
                moments.push((part.grain, Moments { sum, arm: [along, middle, sum * part.arm] }));
            }
            sheet.clear(layer);
        }
    }
}

/// Sum of eight values.
#[inline(always)]
fn total(v: Lanes) -> f64 {
    ((v[0] + v[4]) + (v[2] + v[6])) + ((v[1] + v[5]) + (v[3] + v[7]))
}

/// [`Component::change`] in some layers.
struct Change<'a, R, const N: usize, const D: usize> {
    placed: Placed<'a, D>,
    grains: &'a GrainsByLayer<D>,
    held: &'a mut [Layer],
    lab: usize,
    /// First of its layers.
    first: usize,
    sheet: &'a mut Sheet,
    marked: &'a mut [u64],
    /// Words of `marked` per layer.
    marks: usize,
    fields: [&'a mut [f64]; N],
    rule: &'a R,
}

impl<R: Rule<N>, const N: usize, const D: usize> lanes::Kernel for Change<'_, R, N, D> {
    #[inline(always)]
    fn run<S: Simd>(mut self, _: S) {
        let Placed { grid, kernel, motions, .. } = self.placed;
        let (words, stride, size) = (words(grid), grid.stride(1), grid.stride(D - 1));
        let entries = self.held.len();
        for (k, marked) in self.marked.chunks_mut(self.marks).enumerate() {
            let (sheet, layer) = (&mut *self.sheet, &mut self.held[k % entries]);
            layer.fill(grid, self.grains, kernel, self.first + k, &mut sheet.profiles);
            sheet.mark(grid, layer);
            sheet.gather_velocity(layer, &self.grains.nodes.row.at, self.lab, motions);
            for (word, (marked, mark)) in marked.iter_mut().zip(&sheet.marks).enumerate() {
                let mut bits = *marked | mark;
                *marked = *mark;
                let place = word / words * stride + word % words * 512;
                while bits != 0 {
                    let at = place + 8 * bits.trailing_zeros() as usize;
                    bits &= bits - 1;
                    let target = std::mem::replace(eight_mut(&mut sheet.targets, at), ZERO);
                    let odds = std::mem::replace(eight_mut(&mut sheet.totals, at), ZERO);
                    let fields = self.fields.each_mut().map(|field| eight_mut(&mut field[k * size..], at));
                    self.rule.change(&odds, &target, fields);
                }
            }
            sheet.marks.fill(0);
        }
    }
}
