//! Convection near grains, where the flow changes within a cell or two.
//!
//! Two terms are added to N = −∇·(u u_d), as fluxes, so momentum is conserved:
//!
//! - **Interpolation of fourth order.** The mass flux is that of [`crate::step`]; the value that it carries
//!   is `(−u₋ + 7u + 7u₊ − u₊₊)/12` in place of `(u + u₊)/2`. With an even mass flux the difference of two
//!   such fluxes is the derivative of fourth order. It removes what the plain mean leaves of a body that
//!   moves over the grid, U Δx²/6 u''', and of the layer at its surface, Δx²/8 u''.
//! - **The gradient stress of the mask**, −∂_j (σ² ∂_k u_i ∂_k u_j) (Leonard 1974; Clark, Ferziger & Reynolds
//!   1979). Mask and cells smear the flow with a kernel of variance σ²; the mean of a product is then the
//!   product of the means and this. Of the mask, −∂α/∂s = sech²(s/w)/(2w), σ² = π² w²/12, of a cell Δx²/12;
//!   with the mean thickness w = 0.3 Δx, and the 0.0047 Δx² of the mask's wave, both make 0.162 Δx². The mask
//!   of exact shear has Δx²/12, as a cell.
//!
//! A uniform stream has neither, and both are quadratic in the velocity, so Stokes flow has none. They act
//! within two cells of a grain and fade over a third; fluxes whose nodes would lie beyond a wall have none.

mod bands;
mod factors;
mod fluxes;
mod planes;
mod terms;
#[cfg(test)]
mod tests;

use crate::grid::Grid;
use crate::lanes::dispatch;
use bands::{Ball, Bands};
use factors::Factors;
use planes::Planes;
use std::ops::Range;
use terms::{Fluxes, PlaneTerms, Shared};

/// Cells below which a thread is not worth its while.
const WORTH_A_THREAD: usize = 4096;

/// The terms of all components.
#[derive(Clone, Debug)]
pub struct NearConvection<const D: usize> {
    bands: Bands<D>,
    /// Terms of the last [`NearConvection::evaluate`], m/s².
    values: [Vec<f64>; D],
    balls: Vec<Ball<D>>,
    factors: Factors<D>,
    /// Of each thread.
    rooms: Vec<(Planes, Fluxes)>,
}

impl<const D: usize> NearConvection<D> {
    /// For fluid of viscosity `viscosity`, m²/s. Working memory is sized for the current rayon pool.
    pub fn new(grid: &Grid<D>, viscosity: f64) -> Self {
        let planes = Planes::new(grid);
        let threads = if D == 3 { rayon::current_num_threads() } else { 1 };
        Self {
            bands: Bands::new(grid),
            values: std::array::from_fn(|_| Vec::new()),
            balls: Vec::new(),
            factors: Factors::new(grid, viscosity, planes.row),
            rooms: (0..threads).map(|_| (planes.clone(), Fluxes::new(&planes, D))).collect(),
        }
    }

    /// Declares where the grains are: centres (laboratory axes) and radii, m. Where none has moved nothing is
    /// done.
    pub fn set(&mut self, grid: &Grid<D>, spheres: impl Iterator<Item = ([f64; 3], f64)> + Clone) {
        let balls = spheres.map(|(centre, radius)| Ball::new(grid, centre, radius));
        if balls.clone().eq(self.balls.iter().copied()) {
            return;
        }
        self.balls.clear();
        self.balls.extend(balls);
        self.bands.set(grid, &self.balls);
        for values in &mut self.values {
            values.resize(self.bands.count, 0.0);
        }
    }

    /// The terms of component `d` on a row: the first node of each run of nodes, and their values, m/s².
    #[inline(always)]
    pub(crate) fn terms(&self, d: usize, row: usize) -> impl Iterator<Item = (usize, &[f64])> {
        let values = &self.values[d];
        let segments = self.bands.row(row).iter();
        segments.map(|segment| (segment.from, &values[segment.at..][..segment.to - segment.from]))
    }

    /// Computes the terms from a velocity (m/s) known on all planes of this process and two more on each
    /// side.
    pub(crate) fn evaluate(&mut self, grid: &Grid<D>, velocity: &[Vec<f64>; D]) {
        let Self { bands, values, factors, rooms, .. } = self;
        let rows = bands.rows.clone();
        if rows.is_empty() {
            return;
        }
        let planes = if D == 3 { grid.division.own() } else { 0..1 };
        let at = bands.values(grid.own_rows());
        let threads = rooms.len().min(at.len() / WORTH_A_THREAD).clamp(1, planes.len());
        let values = values.each_mut().map(|values| &mut values[at.clone()]);
        let shared = Shared { grid, velocity, bands, factors, rows };
        shared.divide(planes, values, &mut rooms[..threads]);
    }
}

impl<const D: usize> Shared<'_, D> {
    /// Where the values of the rows of plane `k` stand.
    fn values(&self, k: usize) -> Range<usize> {
        let first = k * self.grid.cells[1];
        self.bands.values(first + self.rows.start..first + self.rows.end)
    }

    /// Divides `planes` among the threads that have `rooms`.
    fn divide(&self, planes: Range<usize>, values: [&mut [f64]; D], rooms: &mut [(Planes, Fluxes)]) {
        if let [(planes_about, fluxes)] = rooms {
            return self.sweep(planes, values, planes_about, fluxes);
        }
        // Where half of the values lie on either side.
        let [first, last] = [self.values(planes.start).start, self.values(planes.end - 1).end];
        let below = |k: &usize| self.values(*k).start < first.midpoint(last);
        let middle = (planes.start + 1..planes.end - 1).find(|k| !below(k)).unwrap_or(planes.end - 1);
        let cut = self.values(middle).start - first;
        let mut cuts = values.map(|values| values.split_at_mut(cut));
        let low = cuts.each_mut().map(|(low, _)| std::mem::take(low));
        let high = cuts.map(|(_, high)| high);
        let (some, others) = rooms.split_at_mut(rooms.len() / 2);
        rayon::join(
            || self.divide(planes.start..middle, low, some),
            || self.divide(middle..planes.end, high, others),
        );
    }

    /// Takes block after block of rows.
    fn sweep(
        &self,
        planes: Range<usize>,
        mut values: [&mut [f64]; D],
        about: &mut Planes,
        fluxes: &mut Fluxes,
    ) {
        let (rows, first) = (&self.rows, self.values(planes.start).start);
        let blocks = rows.len().div_ceil(about.rows);
        let cut = |block: usize| rows.start + block * rows.len() / blocks;
        for block in 0..blocks {
            let block = Shared { rows: cut(block)..cut(block + 1), ..*self };
            let values = values.each_mut().map(|values| &mut **values);
            block.sweep_block(planes.clone(), (values, first), about, fluxes);
        }
    }

    /// Takes plane after plane of a block of rows, upwards; `values` begin with value `first` of all.
    fn sweep_block(
        &self,
        planes: Range<usize>,
        (mut values, first): ([&mut [f64]; D], usize),
        about: &mut Planes,
        fluxes: &mut Fluxes,
    ) {
        about.begin(self.rows.start);
        let place = |k: usize| {
            let at = self.values(k);
            at.start - first..at.end - first
        };
        let holds = |k: usize| !self.values(k).is_empty();
        let (mut below, last) = (false, if D == 3 { planes.end } else { planes.end - 1 });
        for k in planes.start..=last {
            let here = k < planes.end && holds(k);
            if !here && !below {
                continue;
            }
            // What comes through its lower side, where the plane below was not taken.
            let (k, first_of_many) = (k as isize, here && !below && D == 3);
            for step in k - isize::from(first_of_many)..=k {
                let depth = if D == 3 { -2..=2 } else { 0..=0 };
                for near in depth {
                    about.load(self.grid, self.velocity, step + near, &self.rows);
                }
                for near in if D == 3 { -1..=0 } else { 0..=0 } {
                    about.weigh(self.grid, self.bands, step + near, &self.rows);
                }
                fluxes.turn();
                dispatch(PlaneTerms {
                    shared: self,
                    about,
                    fluxes,
                    k: step,
                    velocity: about.velocities(step),
                    weights: [about.weights(step - 1), about.weights(step)],
                    only_along: step < k,
                    values: values.each_mut().map(|values| &mut **values),
                    here: (step == k && here).then(|| place(k as usize)),
                    below: (step == k && below).then(|| place(k as usize - 1)),
                });
            }
            below = here;
        }
    }
}
