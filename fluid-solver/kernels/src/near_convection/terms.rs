//! The terms on one plane.

use super::bands::{Bands, Segment};
use super::factors::{Factors, Lines};
use super::fluxes::{Centre, Edge, Line, over_edge, through_centre};
use super::planes::{LEAD, Planes, layer_of, wrapped};
use crate::grid::Grid;
use crate::lanes::{Aligned, Kernel};
use pulp::Simd;
use std::ops::Range;

/// What all threads read.
pub(super) struct Shared<'a, const D: usize> {
    pub(super) grid: &'a Grid<D>,
    pub(super) velocity: &'a [Vec<f64>; D],
    pub(super) bands: &'a Bands<D>,
    pub(super) factors: &'a Factors<D>,
    /// Rows of a plane with terms.
    pub(super) rows: Range<usize>,
}

/// Fluxes of a plane, with rows as [`Planes`] have them; zero where there is none.
#[derive(Clone, Debug)]
pub(super) struct Fluxes {
    /// Of each component along its own axis, through the centres; along the third axis of the plane below,
    /// too.
    own: [Aligned; 3],
    own_below: Aligned,
    /// Over the lower edges of axes 0 and 1, 0 and 2, 1 and 2: of the first component and of the second.
    edges: [[Aligned; 2]; 3],
}

impl Fluxes {
    pub(super) fn new(planes: &Planes, axes: usize) -> Self {
        let plane = |wanted: bool| if wanted { planes.zeros() } else { Aligned::default() };
        let deep = axes == 3;
        Self {
            own: [plane(true), plane(true), plane(deep)],
            own_below: plane(deep),
            edges: [true, deep, deep].map(|wanted| [plane(wanted), plane(wanted)]),
        }
    }

    /// The plane goes up.
    pub(super) fn turn(&mut self) {
        std::mem::swap(&mut self.own[2], &mut self.own_below);
    }
}

/// The terms of plane `k`, and what those of the plane below lack until then.
pub(super) struct PlaneTerms<'a, const D: usize> {
    pub(super) shared: &'a Shared<'a, D>,
    pub(super) about: &'a Planes,
    pub(super) fluxes: &'a mut Fluxes,
    pub(super) k: isize,
    /// Planes of the velocity from two below to two above, by component.
    pub(super) velocity: [[&'a [f64]; 5]; 3],
    /// Weights on the plane below and on this one.
    pub(super) weights: [&'a [f64]; 2],
    /// Whether only the flux along the third axis is wanted.
    pub(super) only_along: bool,
    pub(super) values: [&'a mut [f64]; D],
    /// Where the values of the plane and of the one below stand, if they are wanted.
    pub(super) here: Option<Range<usize>>,
    pub(super) below: Option<Range<usize>>,
}

/// Nodes of a row: its number, the first of them and how many there are.
#[derive(Clone, Copy)]
struct Run {
    j: isize,
    first: isize,
    count: usize,
}

/// Displacements along each axis from those along two.
#[inline(always)]
fn steps([a, b]: [usize; 2], by: [isize; 2]) -> [isize; 3] {
    let mut steps = [0; 3];
    steps[a] += by[0];
    steps[b] += by[1];
    steps
}

#[inline(always)]
fn vectors<S: Simd>(values: &[f64]) -> Line<'_, S> {
    S::as_simd_f64s(values).0
}

impl<const D: usize> Kernel for PlaneTerms<'_, D> {
    #[inline(always)]
    fn run<S: Simd>(mut self, simd: S) {
        let rows = self.shared.rows.clone();
        for j in rows.start as isize - 1..=rows.end as isize {
            self.fluxes_of_row(simd, j);
        }
        if let Some(here) = self.here.clone() {
            self.each(self.k, here, |terms, segment, j, at| terms.here(segment, j, at));
        }
        if let Some(below) = self.below.clone() {
            self.each(self.k - 1, below, |terms, segment, j, at| terms.below(segment, j, at));
        }
    }
}

impl<'a, const D: usize> PlaneTerms<'a, D> {
    /// Calls `task` for every segment of plane `k`, with its row and where its values stand.
    #[inline(always)]
    fn each(&mut self, k: isize, at: Range<usize>, task: impl Fn(&mut Self, &Segment, isize, usize)) {
        let (bands, rows) = (self.shared.bands, self.shared.rows.clone());
        let layer = layer_of(self.shared.grid, k).unwrap_or(0);
        let mut at = at.start;
        for j in rows {
            for segment in bands.row(layer + j) {
                task(self, segment, j as isize, at);
                at += segment.to - segment.from;
            }
        }
    }

    /// All fluxes of row `j`.
    #[inline(always)]
    fn fluxes_of_row<S: Simd>(&mut self, simd: S, j: isize) {
        let Shared { grid, bands, ref rows, .. } = *self.shared;
        let begin = self.about.at(j) - LEAD;
        let row = begin..begin + self.about.row;
        self.fluxes.own[D - 1][row.clone()].fill(0.0);
        if !self.only_along {
            let Fluxes { own: [first, second, _], edges, .. } = &mut *self.fluxes;
            let planes = edges.as_flattened_mut().iter_mut().filter(|plane| !plane.is_empty());
            planes.chain([first, second]).for_each(|plane| plane[row.clone()].fill(0.0));
        }
        let inside = grid.periodic(1) || (0..grid.cells[1] as isize).contains(&j);
        let Some(layer) = layer_of(grid, self.k).filter(|_| inside) else { return };
        for segment in bands.row(layer + wrapped(grid, 1, j)) {
            // From the vector on that holds the node before the first.
            let from = segment.from / 8 * 8;
            let run = Run { j, first: from as isize - 1, count: (segment.to - from + 2).next_multiple_of(8) };
            // Of the row below the first only what flows along axis 1 is wanted, of that above the last only
            // what flows over edges. With the axes as constants, all displacements are.
            let [starts, ends] = [j >= rows.start as isize, j < rows.end as isize];
            if !self.only_along && ends {
                if starts {
                    self.centre(simd, 0, run);
                }
                self.centre(simd, 1, run);
            }
            if D == 3 && starts && ends {
                self.centre(simd, 2, run);
            }
            if !self.only_along && starts {
                self.edge(simd, [0, 1], 0, run);
                if D == 3 {
                    self.edge(simd, [0, 2], 1, run);
                    self.edge(simd, [1, 2], 2, run);
                }
            }
        }
    }

    /// Values of component `c`, displaced by `steps` along the axes.
    #[inline(always)]
    fn line<S: Simd>(&self, c: usize, run: Run, steps: [isize; 3]) -> Line<'a, S> {
        let at = self.about.at(run.j + steps[1]) as isize + run.first + steps[0];
        vectors::<S>(&self.velocity[c][(steps[2] + 2) as usize][at as usize..][..run.count])
    }

    /// Four values of component `c` along axis `a`, from `from` on.
    #[inline(always)]
    fn along<S: Simd>(&self, c: usize, a: usize, from: isize, run: Run) -> [Line<'a, S>; 4] {
        [
            self.line::<S>(c, run, steps([a, a], [0, from])),
            self.line::<S>(c, run, steps([a, a], [0, from + 1])),
            self.line::<S>(c, run, steps([a, a], [0, from + 2])),
            self.line::<S>(c, run, steps([a, a], [0, from + 3])),
        ]
    }

    /// Values of component `c` one place down and up along axis `b`: at the lower and the upper one of the
    /// two nodes along `a` that a flux lies between, which for its own component are here and the next one.
    #[inline(always)]
    fn beside<S: Simd>(&self, c: usize, run: Run, [a, b]: [usize; 2]) -> [Line<'a, S>; 4] {
        let lower = if a == c { 0 } else { -1 };
        [
            self.line::<S>(c, run, steps([a, b], [lower, -1])),
            self.line::<S>(c, run, steps([a, b], [lower, 1])),
            self.line::<S>(c, run, steps([a, b], [lower + 1, -1])),
            self.line::<S>(c, run, steps([a, b], [lower + 1, 1])),
        ]
    }

    /// Weights, displaced likewise.
    #[inline(always)]
    fn weight<S: Simd>(&self, run: Run, steps: [isize; 3]) -> Line<'a, S> {
        let at = self.about.at(run.j + steps[1]) as isize + run.first + steps[0];
        vectors::<S>(&self.weights[(steps[2] + 1) as usize][at as usize..][..run.count])
    }

    /// Part of a line of factors along axis 0.
    #[inline(always)]
    fn part<S: Simd>(line: &[f64], run: Run, step: isize) -> Line<'_, S> {
        vectors::<S>(&line[(LEAD as isize + run.first + step) as usize..][..run.count])
    }

    /// Where the plane lies along axis `a`, for the lines of factors.
    #[inline(always)]
    fn index(&self, a: usize, j: isize) -> usize {
        let index = if a == 1 { j } else { self.k };
        let n = self.shared.grid.cells[a] as isize;
        // Beyond a periodic end they repeat.
        let index = if (-1..=n + 1).contains(&index) { index } else { index.rem_euclid(n) };
        (LEAD as isize + index) as usize
    }

    /// The flux of component `d` along its own axis.
    #[inline(always)]
    fn centre<S: Simd>(&mut self, simd: S, d: usize, run: Run) {
        let mut out = std::mem::take(&mut self.fluxes.own[d]);
        let factors = self.shared.factors;
        let [b, c] = [(d + 1) % 3, (d + 2) % 3];
        let Lines { half_area, centre_area, centre, .. } = &factors.axes[0];
        let [one, half] = [&factors.one, &factors.half].map(|line| vectors::<S>(&line[..run.count]));
        let centre = Centre {
            u: self.along::<S>(d, d, -1, run),
            beside: self.beside::<S>(d, run, [d, if b < D { b } else { c }]),
            third: if D == 3 { Some(self.beside::<S>(d, run, [d, c])) } else { None },
            mass: if d == 0 {
                [Self::part::<S>(half_area, run, 0), Self::part::<S>(half_area, run, 1)]
            } else {
                [half; 2]
            },
            area: if d == 0 { Self::part::<S>(centre_area, run, 0) } else { one },
            weight: self.weight::<S>(run, [0; 3]),
            open: if d == 0 { Self::part::<S>(centre, run, 0) } else { one },
            scale: if d == 0 { 1.0 } else { factors.axes[d].centre[self.index(d, run.j)] },
        };
        let at = (self.about.at(run.j) as isize + run.first) as usize;
        through_centre(simd, &mut out[at..][..run.count], &centre, factors.parts);
        self.fluxes.own[d] = out;
    }

    /// The fluxes over the lower edge along axes `d` and `a`, `d` < `a`.
    #[inline(always)]
    fn edge<S: Simd>(&mut self, simd: S, [d, a]: [usize; 2], number: usize, run: Run) {
        let [mut out, mut across] = std::mem::take(&mut self.fluxes.edges[number]);
        let factors = self.shared.factors;
        let b = 3 - a - d;
        let (first, own, last) = (&factors.axes[0], &factors.axes[d], &factors.axes[a]);
        let one = vectors::<S>(&factors.one[..run.count]);
        let (n, m) = (self.index(a, run.j), if d == 0 { 0 } else { self.index(d, run.j) });
        let edge = Edge {
            u: self.along::<S>(d, a, -2, run),
            u_along: self.beside::<S>(d, run, [a, d]),
            v: self.along::<S>(a, d, -2, run),
            v_along: self.beside::<S>(a, run, [d, a]),
            third: if b < D {
                Some([self.beside::<S>(d, run, [a, b]), self.beside::<S>(a, run, [d, b])])
            } else {
                None
            },
            weights: [
                self.weight::<S>(run, [0; 3]),
                self.weight::<S>(run, steps([d, a], [-1, 0])),
                self.weight::<S>(run, steps([d, a], [0, -1])),
                self.weight::<S>(run, steps([d, a], [-1, -1])),
            ],
            open: if d == 0 { Self::part::<S>(&first.edge, run, 0) } else { one },
            shares: if d == 0 {
                [Self::part::<S>(&first.shares[0], run, 0), Self::part::<S>(&first.shares[1], run, 0)]
            } else {
                [one; 2]
            },
            shares_across: [last.shares[0][n], last.shares[1][n]],
            scale: last.edge[n] * if d == 0 { 1.0 } else { own.edge[m] },
            share_scale: if d == 0 { [1.0; 2] } else { [own.shares[0][m], own.shares[1][m]] },
        };
        let at = (self.about.at(run.j) as isize + run.first) as usize;
        let outs = [&mut out, &mut across].map(|out| &mut out[at..][..run.count]);
        over_edge(simd, outs, &edge, factors.parts);
        self.fluxes.edges[number] = [out, across];
    }

    /// The terms of plane `k` but for the fluxes of components 0 and 1 through its upper side.
    #[inline(always)]
    fn here(&mut self, segment: &Segment, j: isize, at: usize) {
        let Shared { grid, factors, .. } = *self.shared;
        let (m, place, row) = (segment.to - segment.from, self.about.at(j) + segment.from, self.about.row);
        let (second, third) = (self.index(1, j), if D == 3 { self.index(D - 1, j) } else { 0 });
        let Self {
            fluxes: Fluxes { own: [xx, yy, zz], own_below, edges: [xy, xz, yz] },
            values,
            velocity,
            weights,
            ..
        } = self;
        let (first, along) = (&factors.axes[0], &factors.axes[1]);
        let inverse_face = &first.inverse_face[LEAD + segment.from..][..m];
        let inverse_cell = &first.inverse_cell[LEAD + segment.from..][..m];
        let areas = &first.area[LEAD + segment.from..][..m + 1];
        let mut outs = values.iter_mut().map(|values| &mut values[at..][..m]);
        let deep = &factors.axes[D - 1];
        if let Some(out) = outs.next() {
            let along = (along.inverse_cell[second], [&xy[0][place..][..m], &xy[0][place + row..][..m]]);
            let x = [&xx[place - 1..][..m], &xx[place..][..m]];
            if D == 3 {
                let through = (deep.inverse_cell[third], &xz[0][place..][..m]);
                let flux = |i: usize| inverse_face[i] * (x[1][i] - x[0][i]);
                sum(out, flux, along, |i| through.0 * through.1[i]);
            } else {
                sum(out, |i| inverse_face[i] * (x[1][i] - x[0][i]), along, |_| 0.0);
            }
            if grid.axes[0].radial {
                let u = &velocity[0][2][place..][..m];
                hoop(out, &grid.axes[0].faces[segment.from..][..m], u, &weights[1][place..][..m], factors);
            }
        }
        if let Some(out) = outs.next() {
            let along = (along.inverse_face[second], [&yy[place - row..][..m], &yy[place..][..m]]);
            let x = &xy[1][place..][..m + 1];
            let flux = |i: usize| inverse_cell[i] * (areas[i + 1] * x[i + 1] - areas[i] * x[i]);
            if D == 3 {
                let through = (deep.inverse_cell[third], &yz[0][place..][..m]);
                sum(out, flux, along, |i| through.0 * through.1[i]);
            } else {
                sum(out, flux, along, |_| 0.0);
            }
        }
        if let Some(out) = outs.next() {
            let along = (along.inverse_cell[second], [&yz[1][place..][..m], &yz[1][place + row..][..m]]);
            let x = &xz[1][place..][..m + 1];
            let flux = |i: usize| inverse_cell[i] * (areas[i + 1] * x[i + 1] - areas[i] * x[i]);
            let (weight, low, high) = (deep.inverse_face[third], &own_below[place..][..m], &zz[place..][..m]);
            sum(out, flux, along, |i| -(weight * (high[i] - low[i])));
        }
    }

    /// The fluxes of components 0 and 1 from the plane below through the lower side of plane `k`.
    #[inline(always)]
    fn below(&mut self, segment: &Segment, j: isize, at: usize) {
        let (m, place) = (segment.to - segment.from, self.about.at(j) + segment.from);
        let n = self.shared.grid.cells[D - 1];
        let k = (self.k - 1).rem_euclid(n as isize) as usize;
        let weight = -self.shared.factors.axes[D - 1].inverse_cell[LEAD + k];
        let [_, xz, yz] = &self.fluxes.edges;
        for (values, flux) in self.values.iter_mut().zip([&xz[0], &yz[0]]) {
            take(&mut values[at..][..m], weight, &flux[place..][..m]);
        }
    }
}

/// out = x + factor (high − low) − z.
#[inline(always)]
fn sum(
    out: &mut [f64],
    x: impl Fn(usize) -> f64,
    (factor, [low, high]): (f64, [&[f64]; 2]),
    z: impl Fn(usize) -> f64,
) {
    let n = out.len();
    let (low, high) = (&low[..n], &high[..n]);
    for i in 0..n {
        out[i] = x(i) + factor * (high[i] - low[i]) - z(i);
    }
}

/// out −= factor flux.
#[inline(always)]
fn take(out: &mut [f64], factor: f64, flux: &[f64]) {
    let n = out.len();
    let flux = &flux[..n];
    for i in 0..n {
        out[i] -= factor * flux[i];
    }
}

/// The stress round the axis, σ² (u/r)², pulls inwards.
#[inline(always)]
fn hoop<const D: usize>(out: &mut [f64], radii: &[f64], u: &[f64], weights: &[f64], factors: &Factors<D>) {
    let n = out.len();
    let (radii, u, weights) = (&radii[..n], &u[..n], &weights[..n]);
    let scale = factors.parts.stress * factors.width * factors.width;
    for i in 0..n {
        let r = radii[i];
        let inverse = if r > 0.0 { 1.0 / r } else { 0.0 };
        let rate = u[i] * inverse;
        out[i] += scale * weights[i] * rate * rate * inverse;
    }
}
