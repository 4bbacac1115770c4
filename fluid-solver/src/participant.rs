//! The fluid as a participant: the number of axes is chosen here, once.

use crate::checkpoint;
use crate::coarse_part::CoarsePart;
use crate::coupling;
use crate::lines::{self, Line};
use crate::measure::{mean_square, mean_velocity};
use crate::methods::calibrated::calibration::Calibration;
use crate::orders::{Leader, Order, tell};
use crate::ranks::Ranks;
use crate::solver::Solver;
use crate::totals::Totals;
use crate::{output, planes};
use bedload_output::{MetricValue, OutputFolder};
use bedload_scene::{CheckedScene, ObservedPlanes, SceneError};
use protocol::message::{Kinematics, Loads};
use protocol::participant::{Exchange, Participant, Role, SolverError, Window, WindowReport};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// How long a rank waits for another one, of `coupling.deadline`: less than the coupler waits for the fluid,
/// so that it is told which rank does not answer.
const EARLIER: f64 = 0.8;

/// A fluid solver for any geometry.
pub struct Fluid {
    solver: Any,
    scene: String,
    fields: PathBuf,
    planes: Option<(ObservedPlanes, usize)>,
    totals: Option<Totals>,
    /// What [`Totals`] found after the last window.
    measured: Vec<f64>,
    lines: Vec<Line>,
    /// Until a grain has been seen there.
    coarse_part: Option<CoarsePart>,
    ranks: Ranks,
}

/// Two or three axes. Boxed: the plans of the transforms are large.
enum Any {
    Two(Box<Solver<2>>),
    Three(Box<Solver<3>>),
}

/// Calls a method on whichever solver there is.
macro_rules! any {
    ($any:expr, $solver:ident => $call:expr) => {
        match $any {
            Any::Two($solver) => $call,
            Any::Three($solver) => $call,
        }
    };
}

impl Fluid {
    /// Reads `[fluid]`, lays out the grid and the grains. Field files go to `folder`/`fields`.
    ///
    /// # Errors
    /// [`SceneError`] naming the key that this solver cannot follow.
    pub fn new(scene: &CheckedScene, folder: &Path) -> Result<Self, SceneError> {
        Self::with_ranks(scene, folder, &Ranks::of_process())
    }

    /// The fluid that `ranks` share, of which this is the first: the others must
    /// [`follow()`](crate::follow::follow).
    ///
    /// # Errors
    /// As [`Fluid::new`], and if a rank cannot build its part.
    pub fn with_ranks(scene: &CheckedScene, folder: &Path, ranks: &Ranks) -> Result<Self, SceneError> {
        let source = &scene.source;
        let gone = |error: SolverError| source.error("fluid", error.to_string(), "start the run anew");
        tell(ranks, &Order::Build(source.file.clone(), source.text.clone(), folder.into())).map_err(gone)?;
        Self::of_rank(scene, folder, ranks, Calibration::default())
    }

    /// A fluid of one process with single parts of the calibrated method switched; tests show with it what
    /// they do.
    pub fn with_calibration(
        scene: &CheckedScene,
        folder: &Path,
        calibration: Calibration,
    ) -> Result<Self, SceneError> {
        Self::of_rank(scene, folder, &Ranks::alone(), calibration)
    }

    /// The part of one rank.
    pub(crate) fn of_rank(
        scene: &CheckedScene,
        folder: &Path,
        ranks: &Ranks,
        calibration: Calibration,
    ) -> Result<Self, SceneError> {
        // What may go wrong on one rank alone, memory and files, comes before the first step together.
        let deadline = coupling::deadline(scene);
        let ready = deadline.and_then(|deadline| {
            crate::facts::of_ranks(scene, Some(ranks))?;
            Ok((lines::of(scene)?, deadline))
        });
        if !ranks.all(ready.is_ok()) && ready.is_ok() {
            return Err(scene.source.error(
                "fluid",
                "cannot be built by another rank",
                "see that all ranks have the memory and the files that `bedload-fluid check` asks for",
            ));
        }
        let (lines, deadline) = ready?;
        let mut solver = match scene.scene.domain.dimensions() {
            2 => Any::Two(Box::new(Solver::with_ranks(scene, ranks, calibration)?)),
            _ => Any::Three(Box::new(Solver::with_ranks(scene, ranks, calibration)?)),
        };
        let axes = scene.scene.domain.geometry.axes();
        let axis = |asked: &ObservedPlanes| axes.iter().position(|axis| *axis == asked.axis);
        let planes = scene.scene.observe.planes.clone();
        let planes = planes.and_then(|asked| axis(&asked).map(|axis| (asked, axis)));
        if planes.as_ref().is_some_and(|(asked, _)| asked.stress) {
            any!(&mut solver, solver => solver.keep_forces());
        }
        ranks.set_patience(deadline.mul_f64(EARLIER));
        let (fields, ranks) = (folder.join("fields"), ranks.clone());
        let (totals, measured) = (Totals::of(scene), Vec::new());
        let coarse_part = CoarsePart::of(scene).filter(|_| ranks.is_first());
        let scene = scene.state_sha256();
        Ok(Self { solver, scene, fields, planes, totals, measured, lines, coarse_part, ranks })
    }

    /// Brings the fields of all ranks to the first one, for what looks at them.
    pub(crate) fn show(&mut self) {
        // A rank that is gone is told at the next order.
        let _ = tell(&self.ranks, &Order::Show);
        any!(&mut self.solver, solver => solver.show());
    }

    /// Metrics of the last state that only the fluid can measure; their tables go to `folder`.
    ///
    /// # Errors
    /// [`SolverError`] if a table cannot be written.
    pub fn measure_lines(
        &mut self,
        folder: &OutputFolder,
    ) -> Result<BTreeMap<String, MetricValue>, SolverError> {
        if !self.lines.is_empty() {
            tell(&self.ranks, &Order::Show)?;
        }
        any!(&mut self.solver, solver => lines::finish(solver, &self.lines, folder))
    }

    /// The solver of a plane or axisymmetric scene.
    pub fn two(&self) -> Option<&Solver<2>> {
        let Any::Two(solver) = &self.solver else { return None };
        Some(solver)
    }

    /// The solver of a scene in space.
    pub fn three(&self) -> Option<&Solver<3>> {
        let Any::Three(solver) = &self.solver else { return None };
        Some(solver)
    }

    /// Mean velocity along grid axis `axis`, m/s; the other ranks add theirs.
    pub fn mean_velocity(&self, axis: usize) -> f64 {
        // A rank that is gone is told at the next order.
        let _ = tell(&self.ranks, &Order::MeanVelocity(axis));
        any!(&self.solver, solver => {
            let velocity = &solver.stepper().state().velocity;
            velocity.get(axis).map_or(0.0, |u| mean_velocity(solver.grid(), axis, u))
        })
    }

    /// Root mean square of the velocity over the box, grains included, m/s; the other ranks add theirs.
    pub(crate) fn mean_speed(&self) -> f64 {
        // A rank that is gone is told at the next order.
        let _ = tell(&self.ranks, &Order::Speed);
        any!(&self.solver, solver => mean_square(solver.grid(), &solver.stepper().state().velocity).sqrt())
    }

    /// How many times faster than now the flow was in the fastest window so far.
    pub(crate) fn peak_over_now(&self) -> f64 {
        any!(&self.solver, solver => solver.peak_over_now())
    }

    /// How fast the fluid still goes through a grain, m/s, and through which; none where no force is carried.
    pub(crate) fn leak(&self) -> Option<(f64, usize)> {
        any!(&self.solver, solver => solver.leak())
    }

    /// Is a flow rate held?
    pub fn holds_flow_rate(&self) -> bool {
        any!(&self.solver, solver => solver.stepper().flow_rate().is_some())
    }

    /// Largest Σ|u|/Δx after the last window times the smallest Δx, m/s.
    pub fn fastest(&self) -> f64 {
        any!(&self.solver, solver => solver.fastest())
    }
}

impl Participant for Fluid {
    type Incoming = Kinematics;
    type Outgoing = Loads;
    const ROLE: Role = Role::Fluid;

    fn grains(&self) -> usize {
        any!(&self.solver, solver => solver.motions().len())
    }

    fn advance(
        &mut self,
        window: &Window,
        exchange: &mut dyn Exchange<Kinematics, Loads>,
    ) -> Result<WindowReport, SolverError> {
        let leads = !self.ranks.is_alone() && self.ranks.is_first();
        if leads {
            tell(&self.ranks, &Order::Advance(*window, rayon::current_num_threads()))?;
        }
        if let Some(totals) = &mut self.totals {
            any!(&self.solver, solver => totals.begin(solver));
        }
        let report = if leads {
            let exchange = &mut Leader { inner: exchange, ranks: &self.ranks };
            any!(&mut self.solver, solver => solver.advance(window, exchange))?
        } else {
            any!(&mut self.solver, solver => solver.advance(window, exchange))?
        };
        let end = window.time + window.dt;
        let motions = any!(&self.solver, solver => solver.motions());
        self.coarse_part = self.coarse_part.take().filter(|part| !part.is_reached(motions, end));
        if let Some((asked, axis)) = &self.planes
            && asked.due(window.time, end)
        {
            any!(&mut self.solver, solver => planes::write(solver, *axis, window, &self.fields))?;
        }
        if let Some(totals) = &mut self.totals {
            self.measured.clear();
            any!(&self.solver, solver => totals.measure(solver, &mut self.measured));
        }
        Ok(report)
    }

    fn totals(&self, out: &mut Vec<f64>) {
        out.extend_from_slice(&self.measured);
    }

    fn save(&mut self) {
        // A rank that is gone is told in the next window.
        let _ = tell(&self.ranks, &Order::Save);
        any!(&mut self.solver, solver => solver.save());
    }

    fn restore(&mut self) {
        let _ = tell(&self.ranks, &Order::Restore);
        self.totals.iter_mut().for_each(Totals::put_back);
        any!(&mut self.solver, solver => solver.restore());
    }

    fn write_checkpoint(&self, folder: &Path) -> Result<(), SolverError> {
        tell(&self.ranks, &Order::WriteCheckpoint(folder.into()))?;
        any!(&self.solver, solver => checkpoint::write(solver, &self.scene, folder))
    }

    fn read_checkpoint(&mut self, folder: &Path) -> Result<(), SolverError> {
        tell(&self.ranks, &Order::ReadCheckpoint(folder.into()))?;
        self.totals.iter_mut().for_each(Totals::put_back);
        let read = any!(&mut self.solver, solver => checkpoint::read(solver, &self.scene, folder));
        self.ranks.report(read.map(|()| Vec::new())).map(drop)
    }

    fn write_fields(&mut self, window: &Window) -> Result<(), SolverError> {
        tell(&self.ranks, &Order::WriteFields(*window))?;
        any!(&mut self.solver, solver => output::write(solver, window, &self.fields))
    }

    fn solver_seconds(&self) -> f64 {
        any!(&self.solver, solver => solver.seconds())
    }

    fn pressure_gradient(&self) -> f64 {
        any!(&self.solver, solver => solver.pressure_gradient())
    }
}

impl Drop for Fluid {
    fn drop(&mut self) {
        // Who is gone has nothing to let go.
        let _ = tell(&self.ranks, &Order::Leave);
    }
}
