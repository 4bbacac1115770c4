//! The step in space: few sweeps over the planes, each doing all it can with a plane while it is in
//! the cache.
//!
//! One stage of explicit viscosity is one sweep and one pass over the columns along z of the pressure.
//! The sweep takes plane after plane: back-transform φ and correct the velocity of plane k + 1 (the
//! projection of the stage before), momentum on plane k in place, divergence of plane k − 1 and its
//! transforms. A last sweep ends the step. Implicit viscosity needs three sweeps a stage, since all
//! columns of the velocity must be solved in between. Which parts go in one sweep is planned
//! beforehand ([`crate::stages`]).
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
mod shape;
mod slab;
mod sweep;

use crate::engine::Engine;
use crate::factors::Factors;
use crate::field::State;
use crate::flow::Flow;
use crate::ghosts::Side;
use crate::grid::Grid;
use crate::halo::{fill_scalar_across, fill_velocity_across};
use crate::helmholtz::Unknown;
use crate::helmholtz::space::Space;
use crate::scheme::{Options, Viscous};
use crate::stages::{PlannedStage, PressureUpdate};
use momentum::Given;
use shape::Shape;
use slab::{Fields, Private};
use sweep::{Before, Diverge, Sweep};

/// Planes below which a slab is not worth a thread.
const MIN_PLANES: usize = 4;
/// Cells below which a slab is not worth a thread.
const MIN_CELLS: usize = 16_384;

/// Working memory and solvers of the step in space.
pub(crate) struct SpaceEngine {
    shape: Shape,
    pressure: Space,
    /// One solver per component with implicit viscosity.
    viscous: Vec<Space>,
    /// φ, which needs no field where it is the pressure; increments of implicit viscosity.
    work: [Vec<f64>; 3],
    privates: Vec<Private>,
    /// φ of a projection outside of a step; made with the first one.
    apart: [Vec<f64>; 3],
    /// Whether the predictor has the pressure gradient; else φ stands in the place of the pressure.
    has_gradient: bool,
}

impl SpaceEngine {
    /// Plans a step. Working memory is sized for the current rayon pool.
    pub(crate) fn new<const D: usize>(grid: &Grid<D>, options: &Options<D>) -> Self {
        let shape = Shape::new(grid);
        let implicit = options.viscous == Viscous::Implicit && options.viscosity > 0.0;
        let has_gradient = implicit;
        let pressure = Space::new(grid, Unknown::Pressure);
        let components = if implicit { 0..D } else { 0..0 };
        let viscous: Vec<Space> = components.map(|d| Space::new(grid, Unknown::Component(d))).collect();
        let own = shape.own.len();
        let most = (own / MIN_PLANES).min(grid.cell_count() / shape.n[2] * own / MIN_CELLS);
        let slabs = rayon::current_num_threads().min(most).max(1);
        let field = |wanted: bool| if wanted { grid.new_field() } else { Vec::new() };
        Self {
            privates: (0..slabs).map(|_| Private::new(&shape, &pressure, &viscous)).collect(),
            work: [field(has_gradient), field(implicit), field(implicit)],
            apart: Default::default(),
            shape,
            pressure,
            viscous,
            has_gradient,
        }
    }

    /// Whether viscosity is solved for.
    fn is_implicit(&self) -> bool {
        !self.viscous.is_empty()
    }

    /// Calls `task` with the sweeps, the fields of `state` and the memory of the threads.
    fn sweep<const D: usize>(
        &mut self,
        state: &mut State<D>,
        task: impl FnOnce(Sweep<'_>, &mut Fields<'_>, &mut [Private]),
    ) {
        let Self { shape, pressure, viscous, work, privates, has_gradient, .. } = self;
        let sweep = Sweep { shape, pressure, viscous, has_gradient: *has_gradient };
        task(sweep, &mut fields(state, work, *has_gradient), privates);
    }
}

/// The divergence that is due in a sweep of the stage.
fn divergence_of(stage: &PlannedStage) -> Option<Diverge> {
    stage.projection.filter(|_| stage.fuses_divergence).map(Diverge::of)
}

impl<const D: usize> Engine<D> for SpaceEngine {
    fn fuses(&self) -> bool {
        true
    }

    fn predict(&mut self, flow: &mut Flow<D>, stage: &PlannedStage, force: Option<&[Vec<f64>; D]>) {
        self.shape.refresh(&flow.grid);
        let factors = Factors::new(&flow.options, stage);
        let force = force.map(|force| std::array::from_fn(|d| force[d].as_slice()));
        let before = stage.corrects.map_or(Before::Fill, |update| Before::Correct(update.duration));
        let diverge = divergence_of(stage).filter(|_| !self.is_implicit());
        let given = Given { force, near: flow.near.as_deref() };
        self.sweep(&mut flow.state, |sweep, fields, privates| {
            sweep.prepare_ends(fields, privates, before);
            sweep.exchange_planes(fields, privates, before);
            sweep.momentum(fields, privates, &factors, given, before, diverge);
        });
    }

    fn diffuse(&mut self, flow: &mut Flow<D>, stage: &PlannedStage) {
        if !self.is_implicit() {
            return;
        }
        let c = stage.diffusion(flow.options.viscosity);
        for (solver, increment) in self.viscous.iter_mut().zip(&mut self.work) {
            solver.solve_columns([1.0, c], increment);
        }
        self.sweep(&mut flow.state, |sweep, fields, privates| {
            sweep.viscous(fields, privates, divergence_of(stage));
        });
    }

    fn project(&mut self, flow: &mut Flow<D>, update: PressureUpdate, divergence_done: bool) -> bool {
        if !divergence_done {
            flow.fill_halos();
            self.sweep(&mut flow.state, |sweep, fields, privates| {
                sweep.diverge(fields, privates, Diverge::of(update));
            });
        }
        let phi = if self.has_gradient { &mut self.work[0] } else { &mut flow.state.pressure };
        self.pressure.solve_columns([0.0, -1.0], phi);
        flow.grid.division.ranks().all(is_solved(&self.shape, phi))
    }

    fn correct(&mut self, flow: &mut Flow<D>, update: PressureUpdate) {
        self.shape.refresh(&flow.grid);
        self.sweep(&mut flow.state, |sweep, fields, privates| {
            sweep.finish(fields, privates, update.duration);
        });
        // Halos along x and y are filled.
        if flow.is_open() {
            flow.fill_halos();
        } else {
            let w = &mut flow.state.velocity[D - 1];
            self.shape.ghosts.fetch(1, &mut [(w, Side::Above)]);
            for (d, u) in flow.state.velocity.iter_mut().enumerate() {
                fill_velocity_across(&flow.grid, d, D - 1, u);
            }
        }
        fill_scalar_across(&flow.grid, D - 1, &mut flow.state.pressure);
    }

    fn project_velocity(&mut self, flow: &mut Flow<D>) {
        self.shape.refresh(&flow.grid);
        let once = PressureUpdate { duration: 1.0, viscosity: 0.0 };
        if self.apart[0].is_empty() {
            self.apart[0] = flow.grid.new_field();
        }
        let Self { shape, pressure, viscous, privates, apart, .. } = self;
        let mut fields = fields(&mut flow.state, apart, true);
        fields.pressure = Default::default();
        let sweep = Sweep { shape, pressure, viscous, has_gradient: false };
        sweep.diverge(&mut fields, privates, Diverge::of(once));
        pressure.solve_columns([0.0, -1.0], fields.work[0]);
        let sweep = Sweep { shape, pressure, viscous, has_gradient: false };
        sweep.finish(&mut fields, privates, once.duration);
    }

    fn keep_pressure_gradient(&mut self, flow: &Flow<D>) {
        if !self.has_gradient {
            self.has_gradient = true;
            self.work[0] = flow.grid.new_field();
        }
    }
}

/// Whether φ, transformed along x and y, is finite: every amplitude of a column depends on every cell,
/// so one in the middle is enough to know; a rank without that plane has nothing to say against it.
fn is_solved(shape: &Shape, phi: &[f64]) -> bool {
    let middle = (shape.n[2] / 2) as isize;
    let plane = &phi[shape.planes(middle, middle + 1)];
    !shape.own.contains(&(shape.n[2] / 2))
        || plane[shape.at((shape.n[1] / 2) as isize) + shape.n[0] / 2].is_finite()
}

/// The fields of `state` and `work`; without a gradient in the predictor φ stands in the place of the
/// pressure.
fn fields<'a, const D: usize>(
    state: &'a mut State<D>,
    work: &'a mut [Vec<f64>; 3],
    has_gradient: bool,
) -> Fields<'a> {
    let State { velocity, pressure, history, .. } = state;
    let three = |fields: &'a mut [Vec<f64>; D]| {
        let mut fields = fields.iter_mut().map(Vec::as_mut_slice);
        std::array::from_fn(|_| fields.next().unwrap_or_default())
    };
    let [x, y, z] = work.each_mut().map(Vec::as_mut_slice);
    let (work, pressure) =
        if has_gradient { ([x, y, z], &mut pressure[..]) } else { ([&mut pressure[..], y, z], x) };
    Fields { velocity: three(velocity), history: three(history), work, pressure }
}
