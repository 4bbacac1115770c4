//! One velocity component with the grains in it: sums over grains, forcing, integrals.
//!
//! Many grains share a point by their mask ratios (docs/numerics.md, Mask): `b_i = q_i / (1 + Σ q)`, so that
//! with `S = Σ q` and `T = Σ q U` every rule below needs two numbers per cell, smooth and bounded
//! however the grains overlap.

use super::body::laboratory;
use super::by_layer::{GrainsByLayer, Placed};
use super::layer::Layer;
use super::layer_sums::{LayerSums, first, words};
use super::layers::Layers;
use super::transport::rows::Rows;
use crate::grid::Grid;
use crate::lanes::{self, Lanes, ZERO, dispatch, lanes_at, lanes_at_mut};
use crate::threads::{Chunks, share};
use crate::vector::Real;
use pulp::Simd;
use std::ops::Range;

/// Cells below which a second thread costs more than it brings.
const WORTH_A_THREAD: f64 = 16_384.0;

/// ∫ f dV over one grain for one component, its first moments ∫ f r dV (laboratory axes), and the grain's
/// volume on the grid.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Moments {
    /// ∫ f dV.
    pub sum: f64,
    /// ∫ b dV.
    pub mask: f64,
    /// ∫ f r dV, r from the grain's centre.
    pub arm: [f64; 3],
}

/// Numbers of a grain and its integrals.
const NUMBERS: usize = 6;

impl Moments {
    /// Adds those of another part of the grain.
    fn add(&mut self, part: &Self) {
        self.sum += part.sum;
        self.mask += part.mask;
        for c in 0..3 {
            self.arm[c] += part.arm[c];
        }
    }

    /// As another rank is told.
    fn numbers(&self, grain: usize) -> [f64; NUMBERS] {
        let [x, y, z] = self.arm;
        [grain as f64, self.sum, self.mask, x, y, z]
    }

    /// What the first rank is told of `parts`, which are in the order of layers. A grain that `begins` here
    /// is summed here; of others every layer is told, since the sum of the layers below must come first.
    fn told<'a>(
        parts: impl Iterator<Item = &'a (usize, Self)>,
        begins: impl Fn(usize) -> bool,
        grains: usize,
    ) -> Vec<[f64; NUMBERS]> {
        let mut told: Vec<[f64; NUMBERS]> = Vec::new();
        let mut places = vec![usize::MAX; grains];
        for (grain, part) in parts {
            if places[*grain] < told.len() {
                let (_, mut sum) = Self::from_numbers(&told[places[*grain]]);
                sum.add(part);
                told[places[*grain]] = sum.numbers(*grain);
                continue;
            }
            if begins(*grain) {
                places[*grain] = told.len();
            }
            let mut first = Self::default();
            first.add(part);
            told.push(first.numbers(*grain));
        }
        told
    }

    fn from_numbers([grain, sum, mask, x, y, z]: &[f64; NUMBERS]) -> (usize, Self) {
        (*grain as usize, Self { sum: *sum, mask: *mask, arm: [*x, *y, *z] })
    }
}

/// What an integrand may depend on, a vector of cells at a time.
#[derive(Clone, Copy)]
pub(crate) struct Point<S: Simd, const N: usize> {
    pub(crate) fields: [Real<S>; N],
    /// Mask ratio of this grain.
    pub(crate) ratio: Real<S>,
    /// Mask ratio of all grains here.
    pub(crate) total: Real<S>,
    /// Velocity of this grain here, m/s.
    pub(crate) solid: Real<S>,
}

impl<S: Simd, const N: usize> Point<S, N> {
    /// Mask b of this grain.
    #[inline(always)]
    pub(crate) fn mask(&self) -> Real<S> {
        self.ratio / (self.total + 1.0)
    }
}

/// What is summed over a grain.
pub(crate) trait Integrand<const N: usize>: Sync {
    /// Its value at each of some cells.
    fn value<S: Simd>(&self, point: Point<S, N>) -> Real<S>;
}

/// What is done to `N` fields where grains are.
pub(crate) trait Rule<const N: usize>: Sync {
    /// What becomes of the fields in cells with the given sums of mask ratios, and of mask ratios times
    /// velocity. Where the sum is zero a cell must stay what it is, unless it held force before.
    fn change<S: Simd>(&self, ratio: Real<S>, target: Real<S>, fields: [Real<S>; N]) -> [Real<S>; N];
}

/// What a thread works with: it takes one layer after the other.
#[derive(Clone, Debug, Default)]
pub struct Workspace {
    pub(super) layer_sums: LayerSums,
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
    /// Groups of eight cells that may hold force: a bit each, layer by layer, as in [`LayerSums`].
    pub(super) forced: Vec<u64>,
    /// Room for as many.
    pub(super) next: Vec<u64>,
    /// Result of the last integral, one entry per grain.
    pub moments: Vec<Moments>,
}

impl<const D: usize> Component<D> {
    /// Room for `grains` grains at the nodes of component `d`. `caches`: whether what they hold is kept until
    /// they move.
    pub fn new(grid: &Grid<D>, d: usize, grains: usize, caches: bool) -> Self {
        let rows = grid.stride(D - 1) / grid.stride(1) * grid.cells[D - 1];
        Self {
            layers: Layers::new(grid, d, caches),
            lab: laboratory(grid.geometry, d),
            forced: if grains > 0 { vec![0; rows * words(grid)] } else { Vec::new() },
            next: Vec::new(),
            moments: vec![Moments::default(); grains],
        }
    }

    /// Splits the layers of this process among as many workspaces as there is work for; returns layers per
    /// workspace.
    pub(super) fn split<'b>(
        &self,
        grid: &Grid<D>,
        workspaces: &'b mut Vec<Workspace>,
    ) -> (&'b mut [Workspace], usize) {
        let threads = rayon::current_num_threads();
        let wanted = if threads > 1 && self.layers.grains.cells() > WORTH_A_THREAD { 4 * threads } else { 1 };
        let layers = grid.division.own().len();
        let layers_each = layers.div_ceil(wanted);
        let count = layers.div_ceil(layers_each);
        if workspaces.len() < count {
            workspaces.resize_with(count, Workspace::default);
        }
        let workspaces = &mut workspaces[..count];
        workspaces.iter_mut().for_each(|workspace| workspace.layer_sums.fit(grid));
        (workspaces, layers_each)
    }

    /// `moments` ← ∫ `integrand` dV over every grain, in the fixed order of cells; it may depend on `fields`.
    /// Of several ranks the first alone knows them.
    pub(crate) fn integrate<const N: usize>(
        &mut self,
        placed: Placed<'_, D>,
        workspaces: &mut Vec<Workspace>,
        fields: [&[f64]; N],
        integrand: &impl Integrand<N>,
    ) {
        self.layers.place(placed);
        let (workspaces, layers_each) = self.split(placed.grid, workspaces);
        let own = placed.grid.division.own();
        let Self { layers, lab, moments, .. } = self;
        let (grains, cache, entries) = layers.shared(placed.grid, layers_each);
        let count = workspaces.len();
        let parts = (&mut *workspaces, Chunks { fields: [cache], size: entries });
        share(parts, 0..count, 1, &|part, (workspaces, Chunks { fields: [cache], .. })| {
            let (first, workspace) = (own.start + part.start * layers_each, &mut workspaces[0]);
            let range = first..(first + layers_each).min(own.end);
            dispatch(Integrate { placed, grains, cache, lab: *lab, range, workspace, fields, integrand });
        });
        moments.fill(Moments::default());
        let parts = workspaces.iter().flat_map(|workspace| &workspace.moments);
        let ranks = placed.grid.division.ranks();
        if ranks.is_alone() {
            parts.for_each(|(grain, part)| moments[*grain].add(part));
            return;
        }
        let own = Moments::told(parts, |grain| grains.lowest(placed.grid, grain) >= own.start, moments.len());
        for numbers in ranks.gather(own.as_flattened()).iter().flat_map(|rank| rank.as_chunks().0) {
            let (grain, part) = Moments::from_numbers(numbers);
            moments[grain].add(&part);
        }
    }

    /// Applies `rule` once to every cell of a grain, and to every cell that may have held force before.
    pub(crate) fn change<const N: usize>(
        &mut self,
        placed: Placed<'_, D>,
        workspaces: &mut Vec<Workspace>,
        fields: [&mut [f64]; N],
        rule: &impl Rule<N>,
    ) {
        if self.moments.is_empty() {
            return;
        }
        let (mut forced, lab) = (std::mem::take(&mut self.forced), self.lab);
        let task = |share: Share<'_, N, D>| dispatch(Change { share, lab, rule });
        self.share(placed, workspaces, &mut forced, fields, &task);
        self.forced = forced;
    }

    /// Places the grains and calls `task` for the layers of each thread, with what it may change of `forced`
    /// and `fields`.
    pub(super) fn share<const N: usize>(
        &mut self,
        placed: Placed<'_, D>,
        workspaces: &mut Vec<Workspace>,
        forced: &mut [u64],
        fields: [&mut [f64]; N],
        task: &(dyn Fn(Share<'_, N, D>) + Sync),
    ) {
        self.layers.place(placed);
        let grid = placed.grid;
        let (workspaces, layers_each) = self.split(grid, workspaces);
        let (grains, cache, entries) = self.layers.shared(grid, layers_each);
        let own = grid.division.own();
        let (begin, size) = (first(grid, own.start), grid.stride(D - 1));
        let words_each = forced.len() / grid.cells[D - 1];
        let forced = &mut forced[own.start * words_each..own.end * words_each];
        let fields = fields.map(|field| &mut field[begin..begin + own.len() * size]);
        let count = workspaces.len();
        let parts = (
            (workspaces, Chunks { fields: [cache], size: entries }),
            (
                Chunks { fields: [forced], size: layers_each * words_each },
                Chunks { fields, size: layers_each * size },
            ),
        );
        share(parts, 0..count, 1, &|part, ((workspaces, cache), (forced, fields))| {
            let ([cache], [forced], fields) = (cache.fields, forced.fields, fields.fields);
            let (first, workspace) = (own.start + part.start * layers_each, &mut workspaces[0]);
            task(Share { placed, grains, cache, first, workspace, forced, words_each, fields });
        });
    }
}

/// Layers that one thread works on.
pub(super) struct Share<'a, const N: usize, const D: usize> {
    pub(super) placed: Placed<'a, D>,
    pub(super) grains: &'a GrainsByLayer<D>,
    pub(super) cache: &'a mut [Layer],
    /// The first of them.
    pub(super) first: usize,
    pub(super) workspace: &'a mut Workspace,
    /// Groups of eight cells that may hold force, as in [`LayerSums`], and words of them per layer.
    pub(super) forced: &'a mut [u64],
    pub(super) words_each: usize,
    pub(super) fields: [&'a mut [f64]; N],
}

/// [`Component::integrate`] over some layers.
struct Integrate<'a, I, const N: usize, const D: usize> {
    placed: Placed<'a, D>,
    grains: &'a GrainsByLayer<D>,
    cache: &'a mut [Layer],
    lab: usize,
    range: Range<usize>,
    workspace: &'a mut Workspace,
    fields: [&'a [f64]; N],
    integrand: &'a I,
}

impl<I: Integrand<N>, const N: usize, const D: usize> lanes::Kernel for Integrate<'_, I, N, D> {
    #[inline(always)]
    #[allow(clippy::needless_range_loop, reason = "one index runs over several arrays")]
    fn run<S: Simd>(self, simd: S) {
        let Placed { grid, model, motions, .. } = self.placed;
        let Workspace { layer_sums, moments, .. } = self.workspace;
        let row = &self.grains.nodes.row;
        let entries = self.cache.len();
        moments.clear();
        for k in self.range.clone() {
            let layer = &mut self.cache[(k - self.range.start) % entries];
            layer.fill(grid, self.grains, model, k, &mut layer_sums.room);
            layer_sums.gather(layer);
            let begin = first(grid, k);
            for (part, spans, ratio) in layer.parts() {
                let motion = &motions[part.grain];
                let mut sums = [ZERO; 4];
                let mut rest = ratio.as_chunks::<8>().0;
                for span in spans {
                    let [base, slope] = span.velocity(motion, self.lab, part.arm);
                    let (mine, after) = rest.split_at(span.count / 8);
                    rest = after;
                    for (b, ratio) in mine.iter().enumerate() {
                        let (at, x) = (span.at + 8 * b, span.first + 8 * b);
                        let (x, volume) = (lanes_at(&row.at, x), lanes_at(&row.volume, x));
                        let totals = lanes_at(&layer_sums.totals, at);
                        for t in 0..8 / S::F64_LANES {
                            let (x, volume) = (Real::of(simd, x, t), Real::of(simd, volume, t));
                            let mut fields = [x; N];
                            for f in 0..N {
                                fields[f] = Real::of(simd, lanes_at(self.fields[f], begin + at), t);
                            }
                            let point = Point {
                                fields,
                                ratio: Real::of(simd, ratio, t),
                                total: Real::of(simd, totals, t),
                                solid: x * slope + base,
                            };
                            let value = self.integrand.value(point) * volume * span.weight;
                            let parts = [
                                value,
                                value * (x + span.shift),
                                value * span.middle,
                                point.mask() * volume * span.weight,
                            ];
                            for s in 0..4 {
                                (Real::of(simd, &sums[s], t) + parts[s]).put(&mut sums[s], t);
                            }
                        }
                    }
                }
                let [sum, along, middle, mask] = sums.map(total);
                moments.push((part.grain, Moments { sum, mask, arm: [along, middle, sum * part.arm] }));
            }
            layer_sums.clear(layer);
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
    share: Share<'a, N, D>,
    lab: usize,
    rule: &'a R,
}

impl<R: Rule<N>, const N: usize, const D: usize> lanes::Kernel for Change<'_, R, N, D> {
    #[inline(always)]
    #[allow(clippy::needless_range_loop, reason = "one index runs over several arrays")]
    fn run<S: Simd>(self, simd: S) {
        let Self {
            share: Share { placed, grains, cache, first, workspace, forced, words_each, fields: out },
            ..
        } = self;
        let (Placed { grid, model, motions, .. }, layer_sums) = (placed, &mut workspace.layer_sums);
        let (words, stride, size) = (words(grid), grid.stride(1), grid.stride(D - 1));
        let entries = cache.len();
        for (k, forced) in forced.chunks_mut(words_each).enumerate() {
            let layer = &mut cache[k % entries];
            layer.fill(grid, grains, model, first + k, &mut layer_sums.room);
            layer_sums.mark_covered(grid, layer);
            layer_sums.gather_velocity(simd, layer, &grains.nodes.row.at, self.lab, motions);
            for (word, (forced, covered)) in forced.iter_mut().zip(&layer_sums.covered).enumerate() {
                let mut bits = *forced | covered;
                *forced = *covered;
                let place = word / words * stride + word % words * 512;
                while bits != 0 {
                    let at = place + 8 * bits.trailing_zeros() as usize;
                    bits &= bits - 1;
                    let target = std::mem::replace(lanes_at_mut(&mut layer_sums.targets, at), ZERO);
                    let ratio = std::mem::replace(lanes_at_mut(&mut layer_sums.totals, at), ZERO);
                    for t in 0..8 / S::F64_LANES {
                        let ratio = Real::of(simd, &ratio, t);
                        let mut fields = [ratio; N];
                        for f in 0..N {
                            fields[f] = Real::of(simd, lanes_at(out[f], k * size + at), t);
                        }
                        fields = self.rule.change(ratio, Real::of(simd, &target, t), fields);
                        for f in 0..N {
                            fields[f].put(lanes_at_mut(out[f], k * size + at), t);
                        }
                    }
                }
            }
            layer_sums.covered.fill(0);
        }
    }
}
