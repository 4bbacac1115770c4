//! What viscosity does with a change of the carried force, within the step that changes it
//! (docs/equations-immersed.md, section 7).
//!
//! A grain that moves changes λ in every step by much, and the step that had the old one knows nothing of it:
//! in a dense bed the fluid slips. With q = χ dt and T = Σ q_i U_i at the predicted place, λ = χ (U − u) and
//! (1 − ½ ν dt ∇²)(u − u*) = dt (λ − λ̂) give for y = u − u*
//! ```text
//! (1 + q − ½ ν dt ∇²) y = T − q u* − dt λ̂
//! ```
//! It is solved near grains only, component by component, without pressure, by Chebyshev's iteration over
//! Jacobi's (Golub & Varga 1961): all eigenvalues lie within 1 ± ϱ, ϱ = c/(1 + c), c = ν dt Σ 1/Δx_a².
//! Whatever y is, force and momentum agree to round-off: with H y = y − ½ ν dt ∇²y
//! ```text
//! where q > 0:  λ ← λ̂ + H y/dt,  u* ← u* + y;      elsewhere:  u* ← u* + ½ ν dt ∇²y
//! ```
//! At walls the sum lacks what y loses to their friction.

use super::by_layer::Placed;
use super::component::Rule;
use super::layer_sums::{bits_of, words};
use super::mask_model::MaskModel;
use super::transport::wrap;
use super::{Immersed, Where};
use crate::ghosts::{Ghosts, Side};
use crate::grid::Grid;
use crate::immersed::body::{Motion, Shape};
use crate::lanes::{Kernel, dispatch};
use crate::stencil::Stencil;
use crate::threads::by_layers;
use crate::vector::Real;
use pulp::Simd;

/// Sweeps at most, and at least where there is anything to do.
const SWEEPS: [u32; 2] = [2, 12];

/// What is left of an error of the iteration.
const LEFT: f64 = 0.1;

/// Estimates of [`lag`] from which on the force is taken along, and viscosity is told of its change.
pub const LAG: [f64; 2] = [0.005, 0.02];

/// Solid fraction of the densest pores that are thought of.
const DENSE: f64 = 0.6;

/// By how much too easily fluid would flow through a dense bed that moves like the fastest of the grains, if
/// the force stayed in its cells: 1.3 (U dt/Δx)(ν dt/Δx²)(Δx/r_h), Δx/r_h = dφ/(1 − φ) Δx/R for grains of d
/// dimensions. Measured on cubic and square arrays (docs/equations-immersed.md, section 7).
pub fn lag<const D: usize>(grid: &Grid<D>, model: &MaskModel, shapes: &[Shape], motions: &[Motion]) -> f64 {
    let dx = grid.smallest_width();
    let mut fastest = 0.0_f64;
    let mut smallest = f64::INFINITY;
    for (shape, motion) in shapes.iter().zip(motions) {
        fastest = fastest.max(motion.velocity.iter().map(|v| v * v).sum());
        smallest = smallest.min(shape.radius);
    }
    let pore = f64::from(grid.geometry.grain_dimensions()) * DENSE / (1.0 - DENSE) * dx / smallest;
    1.3 * (fastest.sqrt() * model.dt / dx) * (model.viscosity * model.dt / (dx * dx)) * pore
}

/// Largest ν dt/D² at which a free sphere of density ratio `ratio` bears the local solve: the torque of a
/// window is then taken at the spin that the window began with, so that I_f (60 ν dt/D² + 5.6 (ν dt/D²)^½) ω,
/// that of steady and of sudden rotation, must stay below 2 (I_p + 2 C_v I_f) ω, C_v = ½. The limits of the
/// map agree: docs/stability.md, With the force that goes with the grains. Of a disc: 80 and 4.5 for 60 and
/// 5.6, from 4πμR²ω/(1 − φ), φ = 0.6, among discs that do not turn (films of discs grow faster than those of
/// spheres) and from 2πμR³ω/(πν dt)^½. A body that is not round has the part `share` of the disc's inertia.
pub fn largest_viscous_number(disc: bool, ratio: f64, share: f64) -> f64 {
    let [steady, sudden] = if disc { [80.0, 4.5] } else { [60.0, 5.6] };
    let bears = 2.0 * (ratio + 1.0) * share;
    let root = (-sudden + f64::sqrt(sudden * sudden + 4.0 * steady * bears)) / (2.0 * steady);
    root * root
}

/// Fields that are worked with: mask ratios q, right sides and the last two iterates.
pub const FIELDS: usize = 4;

/// Rows beside those that grains hold in which y may differ from zero, at most.
const BESIDE: u32 = 4;

/// The velocity that a change of the force entails, component by component.
#[derive(Clone, Debug)]
pub struct Brinkman<const D: usize> {
    stencils: [[Stencil; D]; D],
    /// Largest Σ (lower + upper) of all cells, 1/m².
    steepest: f64,
    ghosts: Ghosts,
    /// Groups of eight cells where y may differ from zero, and those beside: a bit each, row by row.
    near: [Vec<u64>; 2],
    /// Room for as many, and for a row of them.
    spare: Vec<u64>,
    row: Vec<u64>,
}

/// Leaves mask ratios and right sides where grains are.
struct Gather {
    dt: f64,
}

impl Rule<4> for Gather {
    #[inline(always)]
    fn change<S: Simd>(
        &self,
        ratio: Real<S>,
        target: Real<S>,
        [u, lambda, ..]: [Real<S>; 4],
    ) -> [Real<S>; 4] {
        [u, lambda, ratio, target - ratio * u - lambda * self.dt]
    }
}

/// Weights of a row: towards the rows beside it along the axes other than the first.
#[derive(Clone, Copy)]
struct Beside {
    /// Where its neighbours begin in a field, and ½ ν dt times their weights.
    at: [usize; 4],
    weights: [f64; 4],
    /// 1 + ½ ν dt (the weights to all rows beside, and those to none).
    own: f64,
}

impl<const D: usize> Brinkman<D> {
    /// For a grid.
    pub fn new(grid: &Grid<D>) -> Self {
        let stencils: [[Stencil; D]; D] =
            std::array::from_fn(|d| std::array::from_fn(|a| at_walls(grid, d, a)));
        let most = |s: &Stencil| s.lower.iter().zip(&s.upper).fold(0.0, |m: f64, (l, u)| m.max(l + u));
        let steepest = stencils.iter().map(|axes| axes.iter().map(most).sum::<f64>()).fold(0.0, f64::max);
        let bits = vec![0; grid.stride(D - 1) / grid.stride(1) * grid.cells[D - 1] * words(grid)];
        Self {
            stencils,
            steepest,
            ghosts: Ghosts::new(grid),
            row: vec![0; words(grid)],
            near: [bits.clone(), bits.clone()],
            spare: bits,
        }
    }

    /// Changes velocity and force, grains being at `motions`: `model.dt` is the step that led there. `room`:
    /// all zero before and after.
    pub fn respond(
        &mut self,
        immersed: &mut Immersed<D>,
        (grid, model, motions): Where<'_, D>,
        [velocity, lambda]: [&mut [Vec<f64>; D]; 2],
        room: &mut [Vec<f64>; FIELDS],
    ) {
        let half = 0.5 * model.viscosity * model.dt;
        let radius = half * self.steepest / (1.0 + half * self.steepest);
        let sweeps = sweeps(radius);
        if half == 0.0 {
            return;
        }
        let Immersed { shapes, components, workspaces, .. } = immersed;
        let placed = Placed { grid, model, shapes, motions };
        for (d, component) in components.iter_mut().enumerate() {
            let [q, right, ..] = room;
            let rule = Gather { dt: model.dt };
            let fields = [&mut velocity[d][..], &mut lambda[d][..], &mut q[..], &mut right[..]];
            component.change(placed, workspaces, fields, &rule);
            let beside = BESIDE.min(sweeps - 1) as usize;
            let bits = &mut component.forced;
            let each = bits.len() / grid.cells[D - 1];
            let bits: &mut [f64] = pulp::bytemuck::cast_slice_mut(bits);
            Ghosts::packed(grid, each).fetch(beside + 1, &mut [(bits, Side::Both)]);
            self.find(grid, &component.forced, beside);
            // The planes beside the own ones.
            room[2..].iter_mut().for_each(|iterate| self.ghosts.forget(iterate));
            self.solve(grid, d, half, radius, sweeps, room);
            self.take(grid, d, half, model.dt, [&mut velocity[d], &mut lambda[d]], room);
            self.clear(grid, room);
        }
    }

    /// Finds the cells near those that grains hold.
    fn find(&mut self, grid: &Grid<D>, held: &[u64], beside: usize) {
        let (words, eights) = (words(grid), grid.cells[0].div_ceil(8));
        let wraps = grid.periodic(0);
        let Self { near: [near, around], spare, row, .. } = self;
        let mut grow = |from: &[u64], to: &mut Vec<u64>, reach| {
            widen(from, to, row, (words, eights, wraps));
            for axis in 1..D {
                spread(grid, axis, reach, to, spare);
                std::mem::swap(to, spare);
            }
        };
        grow(held, near, beside);
        grow(near, around, 1);
    }

    /// The iteration; its result is the first of the iterates.
    fn solve(
        &self,
        grid: &Grid<D>,
        d: usize,
        half: f64,
        radius: f64,
        sweeps: u32,
        [q, right, now, next]: &mut [Vec<f64>; FIELDS],
    ) {
        let mut factor = 1.0;
        for sweep in 0..sweeps {
            factor = match sweep {
                0 => 1.0,
                1 => 1.0 / (1.0 - 0.5 * radius * radius),
                _ => 1.0 / (1.0 - 0.25 * radius * radius * factor),
            };
            let rows = Rows { grid, d, half, stencils: &self.stencils[d], near: &self.near[0] };
            let (from, given) = (&now[..], [&q[..], &right[..]]);
            by_layers(grid, [&mut *next], |first, [next]| {
                dispatch(SweepLayer { rows, now: from, given, factor, first, next });
            });
            if grid.periodic(0) {
                close(grid, next);
            }
            self.ghosts.fetch(1, &mut [(&mut *next, Side::Both)]);
            std::mem::swap(now, next);
        }
    }

    /// Velocity and force with the result.
    fn take(
        &self,
        grid: &Grid<D>,
        d: usize,
        half: f64,
        dt: f64,
        [velocity, lambda]: [&mut [f64]; 2],
        [ratio, _, now, _]: &[Vec<f64>; FIELDS],
    ) {
        let rows = Rows { grid, d, half, stencils: &self.stencils[d], near: &self.near[1] };
        by_layers(grid, [velocity, lambda], |first, fields| {
            dispatch(TakeLayer { rows, now, ratio, rate: 1.0 / dt, first, fields });
        });
    }

    /// Forgets what was worked with.
    fn clear(&self, grid: &Grid<D>, [q, right, now, next]: &mut [Vec<f64>; FIELDS]) {
        let rows = grid.rows() / grid.cells[D - 1];
        for row in grid.own_rows().step_by(rows) {
            // The halo before a layer.
            let at = grid.row(row) - 1;
            (now[at], next[at]) = (0.0, 0.0);
        }
        by_layers(grid, [q, right, now, next], |first, mut fields| {
            for (j, row) in (first..first + rows).enumerate() {
                if self.near[0][bits_of(grid, row)].iter().any(|bits| *bits != 0) {
                    let at = j * grid.stride(1);
                    // From its left halo on.
                    let places = at.saturating_sub(1)..at + grid.stride(1) - 1;
                    fields.iter_mut().for_each(|field| field[places.clone()].fill(0.0));
                }
            }
        });
    }
}

/// Sweeps after which an error is [`LEFT`] of what it was.
fn sweeps(radius: f64) -> u32 {
    let shrinks = radius / (1.0 + (1.0 - radius * radius).sqrt());
    let wanted = (LEFT.ln() / shrinks.ln()).ceil();
    (wanted as u32).clamp(SWEEPS[0], SWEEPS[1])
}

/// The stencil of component `d` along `axis`, with the conditions at walls in its weights: zero beyond a
/// wall.
fn at_walls<const D: usize>(grid: &Grid<D>, d: usize, axis: usize) -> Stencil {
    let mut stencil = Stencil::of_component(grid, d, axis);
    if grid.periodic(axis) || d == axis {
        return stencil;
    }
    let last = grid.cells[axis] - 1;
    let [low, high] = grid.boundaries[axis].map(|wall| if wall.is_odd() { 2.0 } else { 0.0 });
    stencil.lower[0] *= low;
    stencil.upper[last] *= high;
    stencil
}

/// `to` ← `from`, and a group of eight more at each end.
fn widen(from: &[u64], to: &mut [u64], row: &mut [u64], (words, eights, wraps): (usize, usize, bool)) {
    let has = |row: &[u64], e: usize| row[e / 64] >> (e % 64) & 1;
    for (from, to) in from.chunks(words).zip(to.chunks_mut(words)) {
        row.copy_from_slice(from);
        for word in 0..words {
            let carry = if word > 0 { from[word - 1] >> 63 } else { 0 };
            let borrow = if word + 1 < words { from[word + 1] << 63 } else { 0 };
            row[word] |= from[word] << 1 | carry | from[word] >> 1 | borrow;
        }
        if wraps {
            row[0] |= has(from, eights - 1);
            row[(eights - 1) / 64] |= has(from, 0) << ((eights - 1) % 64);
        }
        // No group beyond the row.
        if !eights.is_multiple_of(64) {
            row[words - 1] &= (1 << (eights % 64)) - 1;
        }
        to.copy_from_slice(row);
    }
}

/// `to` ← `from`, and as much in the `reach` rows beside along `axis`.
fn spread<const D: usize>(grid: &Grid<D>, axis: usize, reach: usize, from: &[u64], to: &mut [u64]) {
    let n = grid.cells[axis];
    // Rows beside along the axis are this far apart.
    let step = if axis == D - 1 { grid.rows() / n } else { 1 };
    to.copy_from_slice(from);
    for row in 0..grid.rows() {
        let bits = &from[bits_of(grid, row)];
        if bits.iter().all(|bits| *bits == 0) {
            continue;
        }
        let index = row / step % n;
        let base = row - index * step;
        for away in 1..=reach.min(n - 1) as isize {
            for other in [-away, away].into_iter().filter_map(|away| beside(grid, axis, index, away)) {
                let to = &mut to[bits_of(grid, base + other * step)];
                to.iter_mut().zip(bits).for_each(|(to, bits)| *to |= bits);
            }
        }
    }
}

/// The index `away` from `index` along `axis`, if there is one.
#[inline(always)]
fn beside<const D: usize>(grid: &Grid<D>, axis: usize, index: usize, away: isize) -> Option<usize> {
    let n = grid.cells[axis];
    let other = index as isize + away;
    let inside = (0..n as isize).contains(&other);
    (inside || grid.periodic(axis)).then(|| wrap(other, n))
}

/// Halo values of a row across a periodic face.
fn close<const D: usize>(grid: &Grid<D>, field: &mut [f64]) {
    let n = grid.cells[0];
    for row in grid.own_rows() {
        let at = grid.row(row);
        (field[at - 1], field[at + n]) = (field[at + n - 1], field[at]);
    }
}

/// The rows of one component.
#[derive(Clone, Copy)]
struct Rows<'a, const D: usize> {
    grid: &'a Grid<D>,
    d: usize,
    half: f64,
    stencils: &'a [Stencil; D],
    /// Which groups of eight are worked on.
    near: &'a [u64],
}

impl<const D: usize> Rows<'_, D> {
    /// Rows beside row `row`.
    #[inline(always)]
    fn beside(&self, row: usize) -> Beside {
        let Self { grid, half, stencils, .. } = *self;
        let mut beside = Beside { at: [grid.row(row); 4], weights: [0.0; 4], own: 1.0 };
        let per_layer = grid.rows() / grid.cells[D - 1];
        for (axis, stencil) in stencils.iter().enumerate().skip(1) {
            let (n, step) = (grid.cells[axis], if axis == D - 1 { per_layer } else { 1 });
            let i = row / step % n;
            let (lower, upper) = (half * stencil.lower[i], half * stencil.upper[i]);
            beside.own += lower + upper + half * stencil.extra[i];
            let base = row - i * step;
            for (side, (away, weight)) in [(-1, lower), (1, upper)].into_iter().enumerate() {
                if let Some(other) = self::beside(grid, axis, i, away) {
                    let slot = 2 * (axis - 1) + side;
                    beside.at[slot] = grid.row(base + other * step);
                    beside.weights[slot] = weight;
                }
            }
        }
        beside
    }

    /// The stencil on the `n` cells of row `row` from cell `from` on, in the field `now`.
    #[inline(always)]
    fn stencil<'b>(
        &'b self,
        now: &'b [f64],
        row: usize,
        beside: &Beside,
        (from, n): (usize, usize),
    ) -> Run<'b> {
        let (here, along) = (self.grid.row(row) + from, &self.stencils[0]);
        Run {
            half: self.half,
            own: beside.own,
            along: [&along.lower[from..][..n], &along.upper[from..][..n], &along.extra[from..][..n]],
            ends: [&now[here - 1..][..n], &now[here + 1..][..n]],
            beside: beside.at.map(|at| &now[at + from..][..n]),
            weights: beside.weights,
        }
    }

    /// The next neighbouring groups of `row` from group `eight` on, which moves behind them: first cell and
    /// number of cells.
    #[inline(always)]
    fn next_run(&self, row: usize, eight: &mut usize) -> Option<(usize, usize)> {
        let bits = &self.near[bits_of(self.grid, row)];
        let end = self.grid.cells[0];
        // A wall face is no unknown.
        let begin = usize::from(self.d == 0 && !self.grid.periodic(0));
        let eights = end.div_ceil(8);
        while *eight < eights && bits[*eight / 64] >> (*eight % 64) & 1 == 0 {
            *eight += 1;
        }
        let first = *eight;
        while *eight < eights && bits[*eight / 64] >> (*eight % 64) & 1 == 1 {
            *eight += 1;
        }
        let (from, to) = ((8 * first).max(begin), (8 * *eight).min(end));
        (from < to).then(|| (from, to - from))
    }
}

/// (1 − ½ ν dt ∇²) on neighbouring cells of a row.
struct Run<'a> {
    half: f64,
    own: f64,
    /// Lower, upper and extra weights along the row.
    along: [&'a [f64]; 3],
    /// Values one place to the left and to the right.
    ends: [&'a [f64]; 2],
    beside: [&'a [f64]; 4],
    weights: [f64; 4],
}

impl Run<'_> {
    /// Weight of cell `i` itself, and the sum over its neighbours.
    #[inline(always)]
    fn at(&self, i: usize) -> [f64; 2] {
        let [lower, upper, extra] = self.along;
        let ([left, right], [a, b, c, d], [wa, wb, wc, wd]) = (self.ends, self.beside, self.weights);
        let (l, u) = (self.half * lower[i], self.half * upper[i]);
        let own = self.own + l + u + self.half * extra[i];
        [own, (l * left[i] + u * right[i]) + (wa * a[i] + wb * b[i]) + (wc * c[i] + wd * d[i])]
    }
}

/// One sweep: `next` ← next + factor ((right + ½ ν dt Σ weights × now)/(1 + q + …) − next).
struct SweepLayer<'a, const D: usize> {
    rows: Rows<'a, D>,
    now: &'a [f64],
    given: [&'a [f64]; 2],
    factor: f64,
    /// First row of the layer.
    first: usize,
    next: &'a mut [f64],
}

impl<const D: usize> Kernel for SweepLayer<'_, D> {
    #[inline(always)]
    fn run<S: Simd>(self, _: S) {
        let Self { rows, now, given: [ratio, right], factor, first, next } = self;
        let grid = rows.grid;
        let origin = grid.row(first);
        for row in first..first + grid.rows() / grid.cells[D - 1] {
            let (at, beside, mut eight) = (grid.row(row), rows.beside(row), 0);
            while let Some((from, n)) = rows.next_run(row, &mut eight) {
                let (here, run) = (at + from, rows.stencil(now, row, &beside, (from, n)));
                let next = &mut next[here - origin..][..n];
                let (ratio, right) = (&ratio[here..][..n], &right[here..][..n]);
                for i in 0..n {
                    let [own, sum] = run.at(i);
                    next[i] += factor * ((right[i] + sum) / (own + ratio[i]) - next[i]);
                }
            }
        }
    }
}

/// Velocity and force with y.
struct TakeLayer<'a, const D: usize> {
    rows: Rows<'a, D>,
    now: &'a [f64],
    ratio: &'a [f64],
    /// 1/dt.
    rate: f64,
    first: usize,
    fields: [&'a mut [f64]; 2],
}

impl<const D: usize> Kernel for TakeLayer<'_, D> {
    #[inline(always)]
    fn run<S: Simd>(self, _: S) {
        let Self { rows, now, ratio, rate, first, fields: [velocity, lambda] } = self;
        let grid = rows.grid;
        let origin = grid.row(first);
        for row in first..first + grid.rows() / grid.cells[D - 1] {
            let (at, beside, mut eight) = (grid.row(row), rows.beside(row), 0);
            while let Some((from, n)) = rows.next_run(row, &mut eight) {
                let (here, run) = (at + from, rows.stencil(now, row, &beside, (from, n)));
                let u = &mut velocity[here - origin..][..n];
                let lambda = &mut lambda[here - origin..][..n];
                let (y, ratio) = (&now[here..][..n], &ratio[here..][..n]);
                for i in 0..n {
                    let [own, sum] = run.at(i);
                    let implied = own * y[i] - sum;
                    let held = ratio[i] > 0.0;
                    u[i] += if held { y[i] } else { y[i] - implied };
                    lambda[i] += if held { rate * implied } else { 0.0 };
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// From which density ratio on the runs of the map (advected) were stable: 0.1, 2 and 8 at ν dt/D² =
    /// 0.024, 0.08 and 0.2; 0.01, 1.5 and 4 were not, nor 8 at 0.8.
    #[test]
    fn the_largest_step_is_that_of_the_map() {
        for (number, stable, unstable) in [(0.024, 0.3, 0.01), (0.08, 4.0, 1.5), (0.2, 8.0, 4.0)] {
            assert!(largest_viscous_number(false, stable, 1.0) > number);
            assert!(largest_viscous_number(false, unstable, 1.0) < number);
        }
        assert!(largest_viscous_number(false, 8.0, 1.0) < 0.8);
        // Beds of twelve discs (light-bed) with the local solve: 4 was stable at 0.08; 2 was not, nor 4 at
        // 0.2.
        assert!(
            largest_viscous_number(true, 4.0, 1.0) > 0.08 && largest_viscous_number(true, 2.0, 1.0) < 0.08
        );
        assert!(largest_viscous_number(true, 4.0, 1.0) < 0.2);
    }

    #[test]
    fn sweeps_follow_the_viscous_number() {
        // ν dt/Δx² = 0.2, 0.85, 1.7, 8 in space
        let radius = |number: f64| 3.0 * number / (1.0 + 3.0 * number);
        assert_eq!([0.2, 0.85, 1.7, 8.0].map(|number| sweeps(radius(number))), [2, 3, 4, 9]);
    }
}
