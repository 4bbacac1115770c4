//! The step of the fluid in space: few sweeps over the planes, each doing all it can with a plane
//! while it is in the cache.
//!
//! One stage of explicit viscosity is one sweep and one pass over the columns of the pressure. The
//! sweep takes plane after plane: back-transform φ and correct the velocity of plane k + 1 (the
//! projection of the stage before), momentum on plane k in place, divergence of plane k − 1 and its
//! transforms. A last sweep ends the step. Implicit viscosity needs three sweeps a stage, since all
//! columns of the velocity must be solved in between.
//!
//! With a projection after every stage and explicit viscosity, a pressure gradient in the predictor
//! would be undone by the projection: it is left out, and the φ of the last stage *is* the pressure.
//!
//! Threads own slabs of planes ([`slab`]) and meet where one needs what another has done; every
//! value is computed by the same operations whatever their number.

mod flux;
mod halo;
mod momentum;
mod project;
pub(crate) mod shape;
mod slab;
mod sweep;

use crate::field::State;
use crate::grid::Grid;
use crate::helmholtz::Unknown;
use crate::helmholtz::space::Space;
use crate::scheme::{Projections, Scheme, Stage, Viscous};
use crate::step::{Options, Pending};
use crate::timings::{Part, Timings};
use crate::work::Work;
use momentum::Factors;
use shape::Shape;
use slab::{Fields, Private};
use sweep::{Before, Diverge, Sweep};

/// Planes below which a slab is not worth a thread.
const LEAST_PLANES: usize = 4;
/// Cells below which a slab is not worth a thread.
const LEAST_CELLS: usize = 16_384;

/// What one stage does.
pub(crate) struct StageTask<'a> {
    pub(crate) stage: Stage,
    pub(crate) dt: f64,
    /// Whether a later stage or step asks for N.
    pub(crate) keep: bool,
    /// Force of the caller, three fields.
    pub(crate) force: Option<[&'a [f64]; 3]>,
    /// Projection of the stage before, already solved; without one the velocity may be the caller's.
    pub(crate) before: Option<Pending>,
    /// Projection of this stage, to be solved.
    pub(crate) after: Option<Pending>,
}

/// Working memory and solvers of the step in space.
pub(crate) struct SpaceStep {
    shape: Shape,
    pressure: Space,
    /// One solver per component with implicit viscosity.
    viscous: Vec<Space>,
    work: [Vec<f64>; 3],
    privates: Vec<Private>,
    /// Whether the predictor has the pressure gradient.
    carry: bool,
}

impl SpaceStep {
    /// Plans a step. Working memory is sized for the current rayon pool.
    pub(crate) fn new<const D: usize>(grid: &Grid<D>, options: &Options<D>) -> Self {
        let shape = Shape::new(grid);
        let implicit = options.viscous == Viscous::Implicit && options.viscosity > 0.0;
        let once = options.scheme == Scheme::RungeKutta3 { projections: Projections::OncePerStep };
        let carry = implicit || once;
        let pressure = Space::new(grid, Unknown::Pressure);
        let components = if implicit { 0..D } else { 0..0 };
        let viscous: Vec<Space> = components.map(|d| Space::new(grid, Unknown::Component(d))).collect();
        let most = (shape.n[2] / LEAST_PLANES).min(grid.cell_count() / LEAST_CELLS);
        let slabs = rayon::current_num_threads().min(most).max(1);
        let field = |wanted: bool| if wanted { grid.new_field() } else { Vec::new() };
        Self {
            privates: (0..slabs).map(|_| Private::new(&shape, &pressure, &viscous)).collect(),
            work: [field(carry), field(implicit), field(implicit)],
            shape,
            pressure,
            viscous,
            carry,
        }
    }

    /// From now on the predictor has the pressure gradient: what is between predictor and projection
    /// may depend on it.
    pub(crate) fn carry_pressure<const D: usize>(&mut self, grid: &Grid<D>) {
        if !self.carry {
            self.carry = true;
            self.work[0] = grid.new_field();
        }
    }

    /// Takes over the walls of `grid`.
    pub(crate) fn refresh<const D: usize>(&mut self, grid: &Grid<D>) {
        self.shape.refresh(grid);
    }

    /// One stage.
    pub(crate) fn stage<const D: usize>(
        &mut self,
        options: &Options<D>,
        state: &mut State<D>,
        task: &StageTask<'_>,
        timings: &mut Timings,
    ) -> bool {
        let begin = Work::begin();
        let StageTask { stage, dt, keep, force, before, after } = *task;
        let share = 2.0 * stage.alpha * dt;
        let implicit = !self.viscous.is_empty();
        let nu = options.viscosity;
        let factors = Factors {
            explicit: if implicit { 0.0 } else { nu },
            implicit: if implicit { share * nu } else { 0.0 },
            convection: options.convection,
            now: dt * stage.gamma,
            old: dt * stage.zeta,
            keep,
            share,
            body: std::array::from_fn(|d| options.body_force[d]),
        };
        let Self { shape, pressure, viscous, work, privates, carry } = self;
        let sweep = Sweep { shape, pressure, viscous, carry: *carry };
        let mut fields = fields(state, work, *carry);
        let before = before.map_or(Before::Fill, |before| Before::Correct(before.weight));
        sweep.open(&mut fields, privates, before);
        sweep.look_around(&fields, privates);
        let diverge = after.map(Diverge::of);
        sweep.momentum(&mut fields, privates, &factors, force, before, diverge.filter(|_| !implicit));
        timings.add(Part::Momentum, begin);
        if implicit {
            let begin = Work::begin();
            let c = stage.alpha * nu * dt;
            for (solver, field) in viscous.iter_mut().zip(&mut fields.work) {
                solver.solve_columns([1.0, c], field);
            }
            let sweep = Sweep { shape, pressure, viscous, carry: *carry };
            sweep.viscous(&mut fields, privates, diverge);
            timings.add(Part::Viscous, begin);
        }
        if diverge.is_some() {
            let begin = Work::begin();
            pressure.solve_columns([0.0, -1.0], fields.work[0]);
            timings.add_pressure(begin);
            return is_solved(shape, fields.work[0]);
        }
        true
    }

    /// Divergence and solution for φ, where the stage did not do it. Halos are filled.
    pub(crate) fn solve<const D: usize>(
        &mut self,
        state: &mut State<D>,
        pending: Pending,
        timings: &mut Timings,
    ) -> bool {
        let begin = Work::begin();
        let Self { shape, pressure, viscous, work, privates, carry } = self;
        let mut fields = fields(state, work, *carry);
        let sweep = Sweep { shape, pressure, viscous, carry: *carry };
        sweep.diverge(&mut fields, privates, Diverge::of(pending));
        timings.add(Part::Projection, begin);
        let begin = Work::begin();
        pressure.solve_columns([0.0, -1.0], fields.work[0]);
        timings.add_pressure(begin);
        is_solved(shape, fields.work[0])
    }

    /// The end of a step: velocity and pressure from the solved φ. Halos along z are left.
    pub(crate) fn finish<const D: usize>(
        &mut self,
        state: &mut State<D>,
        pending: Pending,
        timings: &mut Timings,
    ) {
        let begin = Work::begin();
        let Self { shape, pressure, viscous, work, privates, carry } = self;
        let mut fields = fields(state, work, *carry);
        let sweep = Sweep { shape, pressure, viscous, carry: *carry };
        sweep.finish(&mut fields, privates, pending.weight);
        timings.add(Part::Projection, begin);
    }

    /// Makes the velocity divergence-free and leaves the pressure. Halos are filled.
    pub(crate) fn project_velocity<const D: usize>(&mut self, grid: &Grid<D>, state: &mut State<D>) {
        let pending = Pending { weight: 1.0, correction: 0.0 };
        let mut phi = [grid.new_field(), Vec::new(), Vec::new()];
        let Self { shape, pressure, viscous, privates, .. } = self;
        let mut fields = fields(state, &mut phi, true);
        fields.pressure = Default::default();
        let sweep = Sweep { shape, pressure, viscous, carry: false };
        sweep.diverge(&mut fields, privates, Diverge::of(pending));
        pressure.solve_columns([0.0, -1.0], fields.work[0]);
        let sweep = Sweep { shape, pressure, viscous, carry: false };
        sweep.finish(&mut fields, privates, 1.0);
    }
}

/// Whether φ, transformed along x and y, is finite: every amplitude of a column depends on every cell,
/// so one in the middle is enough to know.
fn is_solved(shape: &Shape, phi: &[f64]) -> bool {
    let middle = (shape.n[2] / 2) as isize;
    let plane = &phi[shape.planes(middle, middle + 1)];
    plane[shape.at((shape.n[1] / 2) as isize) + shape.n[0] / 2].is_finite()
}

/// The fields of `state` and `work`; where the pressure is not carried, φ stands in its place.
fn fields<'a, const D: usize>(
    state: &'a mut State<D>,
    work: &'a mut [Vec<f64>; 3],
    carry: bool,
) -> Fields<'a> {
    let State { velocity, pressure, history, .. } = state;
    let three = |fields: &'a mut [Vec<f64>; D]| {
        let mut fields = fields.iter_mut().map(Vec::as_mut_slice);
        std::array::from_fn(|_| fields.next().unwrap_or_default())
    };
    let [x, y, z] = work.each_mut().map(Vec::as_mut_slice);
    let (work, pressure) =
        if carry { ([x, y, z], &mut pressure[..]) } else { ([&mut pressure[..], y, z], x) };
    Fields { velocity: three(velocity), history: three(history), work, pressure }
}
