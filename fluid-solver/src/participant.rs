//! The fluid as a participant: the number of axes is chosen here, once.

use crate::checkpoint;
use crate::lines::{self, Line};
use crate::measure::mean_velocity;
use crate::solver::Solver;
use crate::{output, planes};
use bedload_output::{MetricValue, OutputFolder};
use protocol::message::{Kinematics, Loads};
use protocol::participant::{Exchange, Participant, Role, SolverError, Window, WindowReport};
use protocol::scene::{CheckedScene, ObservedPlanes, SceneError};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// A fluid solver for any geometry.
pub struct Fluid {
    solver: Any,
    scene: String,
    fields: PathBuf,
    planes: Option<(ObservedPlanes, usize)>,
    lines: Vec<Line>,
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
        crate::facts::facts(scene)?;
        let solver = match scene.scene.domain.dimensions() {
            2 => Any::Two(Box::new(Solver::new(scene)?)),
            _ => Any::Three(Box::new(Solver::new(scene)?)),
        };
        let axes = scene.scene.domain.geometry.axes();
        let axis = |asked: &ObservedPlanes| axes.iter().position(|axis| *axis == asked.axis);
        let planes = scene.scene.observe.planes.clone();
        let planes = planes.and_then(|asked| axis(&asked).map(|axis| (asked, axis)));
        let lines = lines::of(scene)?;
        Ok(Self { solver, scene: scene.state_sha256(), fields: folder.join("fields"), planes, lines })
    }

    /// Metrics of the last state that only the fluid can measure; their tables go to `folder`.
    ///
    /// # Errors
    /// [`SolverError`] if a table cannot be written.
    pub fn measure_lines(
        &mut self,
        folder: &OutputFolder,
    ) -> Result<BTreeMap<String, MetricValue>, SolverError> {
        any!(&mut self.solver, solver => lines::finish(solver, &self.lines, folder))
    }

    /// The solver of a plane or axisymmetric scene.
    pub fn two(&self) -> Option<&Solver<2>> {
        match &self.solver {
            Any::Two(solver) => Some(solver),
            Any::Three(_) => None,
        }
    }

    /// The solver of a scene in space.
    pub fn three(&self) -> Option<&Solver<3>> {
        match &self.solver {
            Any::Two(_) => None,
            Any::Three(solver) => Some(solver),
        }
    }

    /// Mean velocity along grid axis `axis`, m/s.
    pub fn mean_velocity(&self, axis: usize) -> f64 {
        any!(&self.solver, solver => {
            let velocity = &solver.stepper().state().velocity;
            velocity.get(axis).map_or(0.0, |u| mean_velocity(solver.grid(), axis, u))
        })
    }

    /// Step proposed for the first window, s.
    pub fn first_dt(&self) -> f64 {
        any!(&self.solver, solver => solver.plan().first())
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
        let report = any!(&mut self.solver, solver => solver.advance(window, exchange))?;
        if let Some((asked, axis)) = &self.planes
            && asked.due(window.time, window.time + window.dt)
        {
            any!(&mut self.solver, solver => planes::write(solver, *axis, window, &self.fields))?;
        }
        Ok(report)
    }

    fn save(&mut self) {
        any!(&mut self.solver, solver => solver.save());
    }

    fn restore(&mut self) {
        any!(&mut self.solver, solver => solver.restore());
    }

    fn write_checkpoint(&self, folder: &Path) -> Result<(), SolverError> {
        any!(&self.solver, solver => checkpoint::write(solver, &self.scene, folder))
    }

    fn read_checkpoint(&mut self, folder: &Path) -> Result<(), SolverError> {
        any!(&mut self.solver, solver => checkpoint::read(solver, &self.scene, folder))
    }

    fn write_fields(&mut self, window: &Window) -> Result<(), SolverError> {
        any!(&mut self.solver, solver => output::write(solver, window, &self.fields))
    }

    fn solver_seconds(&self) -> f64 {
        any!(&self.solver, solver => solver.seconds())
    }

    fn pressure_gradient(&self) -> f64 {
        any!(&self.solver, solver => solver.pressure_gradient())
    }
}
