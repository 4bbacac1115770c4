//! A prescribed flow rate along a periodic axis: the mean pressure gradient follows from it.
//!
//! A step is linear in a uniform force g once convection is known, so the velocity after a stage is
//! u₀ + g s, with u₀ that without the force and s the answer of the stage to a unit force,
//! ```text
//! (1 − α ν dt ∇²) s = 2 α dt      (s = 2 α dt with explicit viscosity)
//! ```
//! and g = (U − ⟨u₀⟩)/⟨s⟩ gives the mean velocity U exactly, with walls respected to the same order
//! as the rest (as Nek5000 does it). Along its axis s does not change, so it is free of divergence
//! and the projection leaves it and the mean alone.

use crate::grid::Grid;
use crate::helmholtz::{Helmholtz, Unknown, Write};
use bedload_over_time::OverTime;

/// Keeps the mean velocity along one axis at a prescribed value.
pub struct FlowRate<const D: usize> {
    axis: usize,
    mean: OverTime<f64>,
    solver: Option<Helmholtz<D>>,
    /// One per stage of the scheme.
    answers: Vec<Answer>,
    work: Vec<f64>,
    /// ∫ g dt over the stages since [`FlowRate::begin`], m/s.
    impulse: f64,
    /// Mean g over the last step, m/s².
    acceleration: f64,
}

/// s/(2 α dt) for one α ν dt.
struct Answer {
    diffusion: f64,
    field: Vec<f64>,
    mean: f64,
}

impl<const D: usize> FlowRate<D> {
    /// Keeps the mean of component `axis` of the velocity at `mean` (m/s), in schemes of `stages`.
    pub fn new(grid: &Grid<D>, axis: usize, mean: OverTime<f64>, stages: usize, implicit: bool) -> Self {
        debug_assert!(grid.periodic(axis), "elsewhere the faces decide what flows");
        let answer = || Answer { diffusion: f64::NAN, field: grid.new_field(), mean: 1.0 };
        Self {
            axis,
            mean,
            solver: implicit.then(|| Helmholtz::new(grid, Unknown::Component(axis))),
            answers: (0..if implicit { stages } else { 0 }).map(|_| answer()).collect(),
            work: if implicit { grid.new_field() } else { Vec::new() },
            impulse: 0.0,
            acceleration: 0.0,
        }
    }

    pub(crate) fn begin(&mut self) {
        self.impulse = 0.0;
    }

    /// After stage `k`, with `diffusion` its α ν dt (0 with explicit viscosity) and `time`, s, its end: gives
    /// `velocity` its mean back.
    pub(crate) fn correct(
        &mut self,
        grid: &Grid<D>,
        k: usize,
        (diffusion, time): (f64, f64),
        velocity: &mut [Vec<f64>; D],
    ) {
        let u = &mut velocity[self.axis];
        let lacking = self.mean.at(time) - mean(grid, self.axis, u);
        let Some(solver) = self.solver.as_mut().filter(|_| diffusion > 0.0) else {
            for row in grid.own_rows() {
                u[grid.row(row)..][..grid.cells[0]].iter_mut().for_each(|u| *u += lacking);
            }
            self.impulse += lacking;
            return;
        };
        let answer = &mut self.answers[k];
        if answer.diffusion != diffusion {
            let own = grid.division.own();
            self.work[grid.planes(own.start as isize, own.end as isize)].fill(1.0);
            solver.solve(grid, [1.0, diffusion], &mut self.work, &mut answer.field, Write::Set);
            answer.mean = mean(grid, self.axis, &answer.field);
            answer.diffusion = diffusion;
        }
        let impulse = lacking / answer.mean;
        for row in grid.own_rows() {
            let at = grid.row(row)..grid.row(row) + grid.cells[0];
            u[at.clone()].iter_mut().zip(&answer.field[at]).for_each(|(u, s)| *u += impulse * s);
        }
        self.impulse += impulse;
    }

    /// The step of length `dt` (s) has ended.
    pub(crate) fn end(&mut self, dt: f64) {
        self.acceleration = self.impulse / dt;
    }

    /// Axis along which the flow rate is prescribed.
    pub fn axis(&self) -> usize {
        self.axis
    }

    /// Mean force per unit mass over the last step, m/s²: minus the pressure gradient over density.
    pub fn acceleration(&self) -> f64 {
        self.acceleration
    }
}

/// Mean of component `d` (`d = D`: of a scalar) over the box. Rows are summed one after the other, by one
/// rank after the other.
pub fn mean<const D: usize>(grid: &Grid<D>, d: usize, u: &[f64]) -> f64 {
    let mut sums = [0.0, 0.0];
    let first = &grid.volumes(d, 0)[..grid.cells[0]];
    let inner: f64 = first.iter().sum();
    grid.division.ranks().relay(&mut sums, |sums| {
        for row in grid.own_rows() {
            let at = [0, row % grid.cells[1], row / grid.cells[1]];
            let weight = (1..D).fold(1.0, |weight, a| weight * grid.volumes(d, a)[at[a]]);
            let u = &u[grid.row(row)..][..grid.cells[0]];
            sums[0] += weight * u.iter().zip(first).map(|(u, v)| u * v).sum::<f64>();
            sums[1] += weight * inner;
        }
    });
    sums[0] / sums[1]
}
