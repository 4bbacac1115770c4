//! From a scene file to a plan: what `check` prints and `run` starts from.

use std::time::Duration;

use bedload_program::RunOptions;
use bedload_scene::CheckedScene;
use protocol::facts::{DemFacts, FluidFacts};
use protocol::participant::Role;
use protocol::scheme::SchemeKey;

use crate::bounds::Bound;
use crate::config::Coupling;
use crate::failure::Failure;
use crate::plan::{Participants, Plan};
use crate::solvers::{Ask, Solver, dem_facts, fluid_facts};

/// A solver that takes part, and what it says of itself.
#[derive(Clone, Debug)]
pub struct Participant<F> {
    pub(crate) solver: Solver,
    /// Its facts.
    pub facts: F,
}

/// Keys that the fluid's facts have for the DEM and the scene does not say, as `--set` takes them.
fn handed_to_dem(fluid: Option<&FluidFacts>, scene: &CheckedScene) -> Vec<String> {
    let keys = fluid.into_iter().flat_map(|fluid| &fluid.for_dem);
    let missing = keys.filter(|(key, _)| !scene.scene.dem.contains_key(*key));
    missing.map(|(key, value)| format!("dem.{key}={value}")).collect()
}

/// A scene, read, checked and planned.
#[derive(Clone, Debug)]
pub struct Prepared {
    /// Scene.
    pub scene: CheckedScene,
    /// `[coupling]`.
    pub coupling: Coupling,
    /// The fluid, where one takes part.
    pub fluid: Option<Participant<FluidFacts>>,
    /// The DEM, where one takes part.
    pub dem: Option<Participant<DemFacts>>,
    /// The plan.
    pub plan: Plan,
}

impl Prepared {
    /// Reads the scene, asks the solvers it needs, and plans.
    ///
    /// # Errors
    /// [`Failure`]: bad input, or a solver that cannot be asked.
    pub fn new(options: &RunOptions) -> Result<Self, Failure> {
        let scene = options.read_scene()?;
        let coupling = Coupling::read(&scene)?;
        let participants = Participants::of(&scene);
        let limit = Duration::from_secs_f64(coupling.startup_deadline);
        let ask = Ask { limit, commands: !options.no_commands };
        let (path, overrides) = (&options.scene, options.all_overrides());
        let solver = |role| Solver::of(role, &scene);
        let (mut fluid, mut dem) = (None, None);
        if participants.has_fluid() {
            let solver = solver(Role::Fluid)?;
            let facts = fluid_facts(&solver, &scene, path, &overrides, ask)?;
            fluid = Some(Participant { solver, facts });
        }
        if participants.has_dem() {
            let solver = solver(Role::Dem)?;
            let of_fluid = fluid.as_ref().map(|fluid| &fluid.facts);
            let overrides = [overrides, handed_to_dem(of_fluid, &scene)].concat();
            let facts = dem_facts(&solver, &scene, path, &overrides, ask)?;
            dem = Some(Participant { solver, facts });
        }
        let memory = protocol::memory::available().map(|available| available.bytes);
        let of_fluid = fluid.as_ref().map(|fluid| &fluid.facts);
        let plan = Plan::new(&scene, &coupling, of_fluid, dem.as_ref().map(|dem| &dem.facts), memory)?;
        Ok(Self { scene, coupling, fluid, dem, plan })
    }

    /// The solvers of the fluid and of the DEM, as far as they take part.
    pub(crate) fn solvers(&self) -> [Option<&Solver>; 2] {
        [self.fluid.as_ref().map(|fluid| &fluid.solver), self.dem.as_ref().map(|dem| &dem.solver)]
    }

    /// `[coupling]` with the scheme that the plan chose.
    ///
    /// # Errors
    /// [`Failure::Run`] where it is no TOML.
    pub(crate) fn resolved_coupling(&self) -> Result<toml::Table, Failure> {
        let scheme = self.plan.scheme.map_or(self.coupling.scheme, SchemeKey::from);
        let coupling = Coupling { scheme, ..self.coupling.clone() };
        toml::Table::try_from(&coupling).map_err(|error| Failure::Run(error.to_string()))
    }

    /// Does a solver that is not ours take part?
    pub fn has_others(&self) -> bool {
        self.solvers().into_iter().flatten().any(|solver| !solver.is_ours())
    }

    /// Refuses a plan that breaks a bound.
    pub fn refuse_broken(&self) -> Result<(), Failure> {
        let broken: Vec<_> = self.plan.refusals().collect();
        if broken.is_empty() { Ok(()) } else { Err(Bound::broken(&broken)) }
    }

    /// Says before the run what the user should know; where the program is verbose, the whole plan.
    pub(crate) fn tell(&self) {
        self.table().iter().for_each(|line| protocol::detail!("{line}"));
        for line in self.notices() {
            if line.starts_with("warning") {
                protocol::say!("bedload: {line}");
            } else {
                protocol::tell!("bedload: {line}");
            }
        }
    }

    /// What the user should know before the run, line by line.
    pub fn notices(&self) -> Vec<String> {
        let mut lines: Vec<String> =
            self.plan.notices.iter().map(|notice| format!("note: {notice}")).collect();
        for bound in self.plan.warnings() {
            let forced =
                if bound.level == crate::bounds::Level::Refuse { " (forced by coupling.force)" } else { "" };
            lines.push(format!("warning: {}{forced}: {}; {}", bound.name, bound.relation(), bound.why));
        }
        lines
    }
}
