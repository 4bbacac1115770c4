//! The plan of a run: who takes part, every time step, every bound, and what it will cost.

use bedload_output::{Observer, Sides};
use bedload_program::alone::Clock;
use bedload_program::log_bytes;
use bedload_scene::{CheckedScene, SceneError};
use protocol::facts::{DemFacts, FluidFacts};
use protocol::participant::Role;
use protocol::scheme::{Scheme, SchemeKey};
use serde::Serialize;

use crate::bounds::{self, Bound, Drag, Facts, TimeSteps};
use crate::config::Coupling;
use crate::files::Files;
use crate::notices;
use crate::number::Short;
use bedload_scene::speeds::Speeds;

/// Which processes a scene needs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Participants {
    /// Fluid and DEM, coupled.
    Coupled,
    /// No grain is free: the fluid alone.
    Fluid,
    /// No fluid: the DEM alone.
    Dem,
}

impl Participants {
    /// Of a scene.
    pub fn of(scene: &CheckedScene) -> Self {
        match (scene.scene.medium.is_some(), scene.has_free_grains()) {
            (false, _) => Self::Dem,
            (true, false) => Self::Fluid,
            (true, true) => Self::Coupled,
        }
    }

    /// What its observer sees.
    pub fn sides(self) -> Sides {
        match self {
            Self::Coupled => Sides::coupled(),
            Self::Fluid => Sides::fluid_alone(true),
            Self::Dem => Sides::dry(),
        }
    }

    /// The solver that runs alone; none where both take part.
    pub fn alone(self) -> Option<Role> {
        match self {
            Self::Coupled => None,
            Self::Fluid => Some(Role::Fluid),
            Self::Dem => Some(Role::Dem),
        }
    }

    /// Does a fluid take part?
    pub fn has_fluid(self) -> bool {
        self != Self::Dem
    }

    /// Does a DEM take part?
    pub fn has_dem(self) -> bool {
        self != Self::Fluid
    }
}

/// Plan of a run.
#[derive(Clone, Debug, Serialize)]
pub struct Plan {
    /// Who takes part.
    pub participants: Participants,
    /// Order of the exchange; none where nothing is exchanged.
    pub scheme: Option<Scheme>,
    /// Cells of the grid.
    pub cells: u64,
    /// Grains, all motions included.
    pub grains: usize,
    /// Memory of the solvers, estimated, bytes.
    pub memory: u64,
    /// Size of `exchange.mcap`, estimated, bytes before compression.
    pub log: u64,
    /// Fields and checkpoints.
    pub files: Files,
    /// Time steps.
    #[serde(flatten)]
    pub steps: TimeSteps,
    /// Sub-step aimed at; a window gets ceil(dt/dt_dem) of them, s.
    pub dt_dem_target: f64,
    /// May the window change while the run goes?
    pub adaptive: bool,
    /// Ratio by which the fluid's own limit on dt may be passed before its scheme is unstable.
    pub cfl_reserve: f64,
    /// First window, s.
    pub dt_first: f64,
    /// Largest window of an adaptive run, s.
    pub dt_max: f64,
    /// End, s.
    pub until: f64,
    /// Windows, estimated.
    pub windows: u64,
    /// Cost of the run on one core, estimated, s; 0 where no solver gave an estimate.
    pub cost: f64,
    /// Error of the drag that the cells leave, as charted; none where nothing moves a grain against the
    /// fluid.
    pub drag: Option<Drag>,
    /// Bounds.
    pub bounds: Vec<Bound>,
    /// Names of bounds that may be broken.
    pub forced: Vec<String>,
    /// What the user should know.
    pub notices: Vec<String>,
}

/// Iterations that a window of the iterated scheme takes, for the estimate of the cost (docs/coupling.md,
/// Schemes).
const ITERATIONS: f64 = 6.0;

/// Takes another order of the exchange where the scene names none, a bound of the fluid is broken, and the
/// fluid says that the bound is wider in that order: the cost of repeated windows is paid only there. A bound
/// that the scene forces asks for nothing.
fn change_scheme_where_asked(facts: &mut Facts<'_>) -> Option<String> {
    if facts.coupling.scheme != SchemeKey::Auto {
        return None;
    }
    let fluid = facts.fluid?;
    let (bound, scheme) = fluid.bounds.iter().find_map(|own| {
        let scheme = own.wider_in.filter(|scheme| fluid.schemes().contains(scheme))?;
        let bound = Bound::of_solver(own, facts.scheme, &facts.steps)?;
        bound.refuses(&facts.coupling.force).then_some((bound, scheme))
    })?;
    facts.scheme = Some(scheme);
    Some(format!(
        "scheme: {scheme}, because {} = {} breaks {} ({}) in windows of this length that are not repeated; \
         coupling.scheme names another order",
        bound.quantity,
        Short(bound.value),
        bound.name,
        Short(bound.limit)
    ))
}

/// ceil(dt/dt_dem), where a ratio that is whole up to rounding counts as whole.
pub fn substeps(dt: f64, dt_dem: f64) -> u64 {
    ((dt / dt_dem) * (1.0 - 1e-12)).ceil().max(1.0) as u64
}

impl Plan {
    /// Plans a run from the scene and what the solvers said of themselves. `memory` is what the
    /// machine can still give, bytes.
    ///
    /// ```
    /// # use coupler::{config::Coupling, plan::Plan};
    /// # use protocol::facts::DemFacts;
    /// # use bedload_scene::{CheckedScene, SceneSource};
    /// let text = r#"
    /// until = 0.1
    /// grains = [{ position = [0.5, 0.5, 0.5], radius = 0.1, density = 2.0 }]
    /// [domain]
    /// geometry = "space"
    /// lower = [0, 0, 0]
    /// upper = [1, 1, 1]
    /// boundary = { x = "no-slip", y = "no-slip", z = "no-slip" }
    /// "#;
    /// let scene = CheckedScene::new(SceneSource { file: "dry.toml".into(), text: text.into() })?;
    /// let dem = DemFacts { dt: 1e-3, contact_time: 2e-2, ..DemFacts::default() };
    /// let plan = Plan::new(&scene, &Coupling::read(&scene)?, None, Some(&dem), None)?;
    /// assert_eq!((plan.windows, plan.refusals().count()), (100, 0));
    /// # Ok::<(), bedload_scene::SceneError>(())
    /// ```
    ///
    /// # Errors
    /// [`SceneError`] where `[coupling]` contradicts the solvers, or a solver gave no usable step.
    pub fn new(
        scene: &CheckedScene,
        coupling: &Coupling,
        fluid: Option<&FluidFacts>,
        dem: Option<&DemFacts>,
        memory: Option<u64>,
    ) -> Result<Self, SceneError> {
        let participants = Participants::of(scene);
        Observer::check(scene, participants.sides())?;
        let (fluid, dem) =
            (fluid.filter(|_| participants.has_fluid()), dem.filter(|_| participants.has_dem()));
        let own = fluid.map(|fluid| &fluid.bounds).into_iter().chain(dem.map(|dem| &dem.bounds));
        coupling.check_force(own.clone().flatten().map(|bound| bound.name.as_str()), &scene.source)?;
        let scheme = match (participants, fluid) {
            (Participants::Coupled, Some(fluid)) => Some(coupling.scheme(fluid, &scene.source)?),
            _ => None,
        };
        let adaptive = fluid.is_some_and(|fluid| fluid.adaptive);
        let contact_time = dem.map_or(f64::INFINITY, |dem| dem.contact_time);
        let by_contact = match participants {
            Participants::Coupled if adaptive => coupling.max_dt_over_contact_time * contact_time,
            _ => f64::INFINITY,
        };
        let dt_dem_target = substep_target(participants, coupling, dem);
        let dt_fluid = fluid.map_or(dt_dem_target, |fluid| fluid.dt).min(by_contact).min(scene.scene.until);
        usable(scene, if participants == Participants::Dem { "dem" } else { "fluid" }, dt_fluid)?;
        usable(scene, "dem", dt_dem_target)?;
        let full = substeps(dt_fluid, dt_dem_target);
        let steps = TimeSteps { dt_fluid, dt_dem: dt_fluid / full as f64, substeps: full, contact_time };
        let mut facts =
            Facts { scene, fluid, dem, coupling, scheme, steps, speeds: Speeds::of(scene), memory };
        let notice = change_scheme_where_asked(&mut facts);
        // Windows that follow what happens keep the bounds that the plan keeps.
        let longest = |bound| Bound::longest_window(bound, facts.scheme, &steps);
        let dt_max = own.flatten().map(longest).fold(by_contact, f64::min);
        let dt_first = fluid.map_or(dt_fluid, FluidFacts::first).min(dt_fluid);
        let windows = (scene.scene.until / dt_fluid).ceil();
        let of_a_window = fluid.map_or(0.0, |fluid| fluid.step_cost)
            + dem.map_or(0.0, |dem| dem.substep_cost) * full as f64;
        let of_solvers = fluid.map(|fluid| &fluid.notices).into_iter().chain(dem.map(|dem| &dem.notices));
        let attempts = match facts.scheme {
            Some(Scheme::Iterated) if coupling.iterations.repeat_above == 0.0 => ITERATIONS,
            _ => 1.0,
        };
        let cost = windows * attempts * of_a_window;
        let exchanged = match participants {
            Participants::Dem => {
                let Clock { window, .. } =
                    Clock::of_dem(dt_dem_target, scene.scene.observe.every, scene.scene.until);
                (scene.scene.until / window).ceil()
            }
            _ => windows * attempts,
        };
        let more = notices::of(&facts, cost, windows * attempts);
        let drag = bounds::drag::of(&facts);
        let bytes = |of_fluid: fn(&FluidFacts) -> u64, of_dem: fn(&DemFacts) -> u64| {
            let mut known = fluid.map(of_fluid).into_iter().chain(dem.map(of_dem));
            // One that does not say its size leaves the sum unknown.
            known.try_fold(0, |sum, part| (part > 0).then_some(sum + part)).unwrap_or(0)
        };
        let files = Files::of(
            &scene.scene.observe,
            scene.scene.until,
            exchanged,
            cost,
            bytes(|fluid| fluid.field_bytes, |dem| dem.field_bytes),
            bytes(|fluid| fluid.checkpoint_bytes, |dem| dem.checkpoint_bytes),
        );
        Ok(Self {
            participants,
            scheme: facts.scheme,
            cells: fluid.map_or(0, |fluid| fluid.cells),
            grains: scene.grains.len(),
            memory: fluid.map_or(0, |fluid| fluid.memory) + dem.map_or(0, |dem| dem.memory),
            log: log_bytes(participants.alone(), scene.grains.len(), exchanged) as u64,
            files,
            steps,
            dt_dem_target,
            adaptive,
            cfl_reserve: fluid.map_or(1.0, cfl_reserve),
            dt_first,
            dt_max,
            until: scene.scene.until,
            windows: windows as u64,
            cost,
            bounds: bounds::all(&facts, drag.as_ref()),
            drag,
            forced: coupling.force.clone(),
            notices: of_solvers.flatten().chain(&scene.notes).cloned().chain(notice).chain(more).collect(),
        })
    }

    /// Bounds that stop the run.
    pub fn refusals(&self) -> impl Iterator<Item = &Bound> {
        self.bounds.iter().filter(|bound| bound.refuses(&self.forced))
    }

    /// Bounds that are broken without stopping the run, by level or because the scene forces them.
    pub fn warnings(&self) -> impl Iterator<Item = &Bound> {
        self.bounds.iter().filter(|bound| !bound.holds && !bound.refuses(&self.forced))
    }

    /// Sub-steps of a full window of length `dt`.
    pub fn full_substeps(&self, dt: f64) -> u64 {
        if self.dt_dem_target.is_finite() { substeps(dt, self.dt_dem_target) } else { 1 }
    }

    /// The plan as lines of text.
    pub fn lines(&self) -> Vec<String> {
        let steps = &self.steps;
        let who = match self.participants {
            Participants::Coupled => "fluid and DEM, coupled",
            Participants::Fluid => "fluid alone (no grain is free)",
            Participants::Dem => "DEM alone (no fluid)",
        };
        let mut lines = vec![
            line("processes", who.to_owned()),
            line("cells", self.cells.to_string()),
            line("grains", self.grains.to_string()),
            line("memory", format!("{:.1} MiB, estimated", self.memory as f64 / f64::from(1 << 20))),
        ];
        if let Some(scheme) = self.scheme {
            lines.push(line("scheme", scheme.to_string()));
        }
        if self.participants.has_fluid() {
            let how = if self.adaptive { " (adaptive)" } else { "" };
            lines.push(line("dt fluid", format!("{} s{how}", Short(steps.dt_fluid))));
        }
        if self.participants.has_dem() {
            lines.push(line("dt dem", format!("{} s", Short(steps.dt_dem))));
            lines.push(line("t_c", format!("{} s", Short(steps.contact_time))));
            lines.push(line("t_c/dt_dem", Short(steps.contact_time / steps.dt_dem).to_string()));
            lines.push(line("dt_fluid/t_c", Short(steps.dt_fluid / steps.contact_time).to_string()));
        }
        if self.participants == Participants::Coupled {
            lines.push(line("sub-steps", format!("{} in a full window", steps.substeps)));
        }
        lines.extend(self.drag.iter().map(|drag| line("drag error", drag.said.clone())));
        let steps = if self.participants == Participants::Dem { "sub-steps" } else { "windows" };
        lines.push(line(steps, format!("{} to t = {} s", self.windows, Short(self.until))));
        let cost = if self.cost > 0.0 {
            format!("{} s on one core, estimated", Short(self.cost))
        } else {
            "unknown".into()
        };
        lines.push(line("cost", cost));
        let log = self.log as f64 / f64::from(1 << 20);
        lines.push(line("log", format!("up to {} MiB before compression (--no-record: none)", Short(log))));
        lines.extend(self.files.lines().map(|(name, said)| line(name, said)));
        lines
    }
}

fn line(name: &str, value: String) -> String {
    format!("{name:<14} {value}")
}

/// How far above the CFL number that the fluid aims at its scheme is still stable.
fn cfl_reserve(fluid: &FluidFacts) -> f64 {
    if fluid.cfl > 0.0 && fluid.cfl_limit > fluid.cfl { fluid.cfl_limit / fluid.cfl } else { 1.0 }
}

/// The DEM's sub-step; in a coupled run at most t_c/`steps_per_contact`.
pub(crate) fn substep_target(participants: Participants, coupling: &Coupling, dem: Option<&DemFacts>) -> f64 {
    let Some(dem) = dem else { return f64::INFINITY };
    match participants {
        Participants::Coupled => dem.dt.min(dem.contact_time / coupling.steps_per_contact),
        _ => dem.dt,
    }
}

/// A step must be a positive number that changes the time; of the DEM also infinite, where nothing can touch.
fn usable(scene: &CheckedScene, section: &str, dt: f64) -> Result<(), SceneError> {
    if dt > 0.0 {
        return scene.step_changes_time(section, dt);
    }
    let message = format!("its solver asks for a step of {dt} s; allowed: a positive number");
    Err(scene.source.error(section, message, "give dt in this section, or mend the solver's `check --json`"))
}
