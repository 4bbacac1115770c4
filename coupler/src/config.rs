//! The `[coupling]` section of the scene.

use bedload_scene::{CheckedScene, Retired, SceneError, SceneSource};
use protocol::facts::FluidFacts;
use protocol::scheme::{Iterations, Scheme, SchemeKey};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::bounds::names::NAMES;

/// How many DEM sub-steps a window gets.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Substeps {
    /// One where no contact and no lubrication can begin within the window, else `full`.
    #[default]
    Auto,
    /// ceil(dt_fluid/dt_dem), always.
    Full,
}

/// `[coupling]`.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Coupling {
    /// `auto`, `explicit`, `semi-implicit` or `iterated`; the fluid must be able to follow the one that is
    /// named.
    pub scheme: SchemeKey,
    /// How windows are repeated where the scheme is `iterated`.
    pub iterations: Iterations,
    /// `auto` or `full`.
    pub substeps: Substeps,
    /// Largest dt_fluid/t_c. An adaptive fluid step is held below it, a fixed one refused above it.
    pub max_dt_over_contact_time: f64,
    /// DEM sub-steps per contact time t_c. The DEM's own sub-step wins where it is smaller.
    pub steps_per_contact: f64,
    /// Longest time for a solver to answer within a window, s.
    pub deadline: f64,
    /// Longest time for the solvers to start and join, s.
    pub startup_deadline: f64,
    /// Write `exchange.mcap`?
    pub record: bool,
    /// Names of bounds that the run may break (with a warning).
    pub force: Vec<String>,
    /// Wait for messages without sleeping; only with a core for each process.
    pub spin: bool,
    /// Wall time between checkpoints, s; 0: only at the end and on interruption.
    pub checkpoint_every: f64,
}

impl Default for Coupling {
    fn default() -> Self {
        Self {
            scheme: SchemeKey::Auto,
            iterations: Iterations::default(),
            substeps: Substeps::Auto,
            max_dt_over_contact_time: 100.0,
            steps_per_contact: 20.0,
            deadline: 10.0,
            startup_deadline: 30.0,
            record: true,
            force: Vec::new(),
            spin: false,
            checkpoint_every: 60.0,
        }
    }
}

/// Names that this section had before.
const RETIRED: &[Retired] = &[
    Retired::key("coupling.iterations.most", "coupling.iterations.max_iterations"),
    Retired::dropped(
        "coupling.iterations.relaxation",
        "leave it out: attempts are mixed by Anderson's method",
    ),
    Retired::dropped(
        "coupling.iterations.depth",
        "leave it out: an attempt is mixed with the five before it",
    ),
    Retired::value("coupling.scheme", "overlapped", "\"semi-implicit\""),
];

/// The document as far as the coupler owns it.
#[derive(Deserialize)]
struct Owned {
    #[serde(default)]
    coupling: Coupling,
}

impl Coupling {
    /// Reads and checks the section.
    ///
    /// # Errors
    /// [`SceneError`] at the key that is unknown, of the wrong type or out of range. What `force` names
    /// is checked with the plan, which knows the solvers' own bounds.
    pub fn read(scene: &CheckedScene) -> Result<Self, SceneError> {
        let source = &scene.source;
        source.refuse_retired(RETIRED)?;
        let coupling = source.section::<Owned>()?.coupling;
        coupling.check_numbers(source)?;
        Ok(coupling)
    }

    fn check_numbers(&self, source: &SceneSource) -> Result<(), SceneError> {
        let check = |key: &str, value: String, holds: bool, allowed: &str, remedy: &str| {
            let wrong = || {
                source.error(&format!("coupling.{key}"), format!("is {value}; allowed: {allowed}"), remedy)
            };
            if holds { Ok(()) } else { Err(wrong()) }
        };
        for (key, value) in [
            ("max_dt_over_contact_time", self.max_dt_over_contact_time),
            ("steps_per_contact", self.steps_per_contact),
            ("deadline", self.deadline),
            ("startup_deadline", self.startup_deadline),
        ] {
            let (holds, allowed) = (value > 0.0 && value <= 1e9, format!("0 < {key} ≤ 1e9"));
            check(key, value.to_string(), holds, &allowed, "give a positive number")?;
        }
        let (every, allowed) = (self.checkpoint_every, "0 ≤ checkpoint_every ≤ 1e9");
        let remedy = "give seconds of wall time, or 0";
        check("checkpoint_every", every.to_string(), (0.0..=1e9).contains(&every), allowed, remedy)?;
        let Iterations { tolerance, max_iterations, repeat_above } = self.iterations;
        let (holds, allowed) = (tolerance > 0.0 && tolerance < 1.0, "0 < tolerance < 1");
        let remedy = "give the relative change of the motion to stop at, such as 1e-4";
        check("iterations.tolerance", tolerance.to_string(), holds, allowed, remedy)?;
        let (holds, allowed) = ((2..=1000).contains(&max_iterations), "2 to 1000 attempts");
        let remedy = "a change takes two attempts to see: give 2 or more, or scheme = \"semi-implicit\"";
        check("iterations.max_iterations", max_iterations.to_string(), holds, allowed, remedy)?;
        let (holds, allowed) = ((0.0..1.0).contains(&repeat_above), "0 ≤ repeat_above < 1");
        let remedy =
            "give 0 to repeat every window, or such as 1e-3 to repeat those that go otherwise than expected";
        check("iterations.repeat_above", repeat_above.to_string(), holds, allowed, remedy)
    }

    /// Refuses a name in `force` that is no bound: neither one of ours nor one of `own`, those that the
    /// solvers of this run send.
    ///
    /// # Errors
    /// [`SceneError`] at `coupling.force`, with all names.
    pub fn check_force<'a>(
        &self,
        own: impl IntoIterator<Item = &'a str>,
        source: &SceneSource,
    ) -> Result<(), SceneError> {
        let mut names = NAMES.to_vec();
        names.extend(own.into_iter().filter(|name| !NAMES.contains(name)));
        match self.force.iter().find(|name| !names.contains(&name.as_str())) {
            None => Ok(()),
            Some(name) => Err(source.error(
                "coupling.force",
                format!("names `{name}`, which is no bound; bounds: {}", names.join(", ")),
                "name a bound that `bedload check` prints, or leave it out",
            )),
        }
    }

    /// The order of the exchange that the scene names, or the fluid's own.
    ///
    /// # Errors
    /// [`SceneError`] at `coupling.scheme` where the fluid cannot follow the named one.
    pub fn scheme(&self, fluid: &FluidFacts, source: &SceneSource) -> Result<Scheme, SceneError> {
        let allowed = fluid.schemes();
        let named = self.scheme.named().unwrap_or(allowed[0]);
        if allowed.contains(&named) {
            return Ok(named);
        }
        let names: Vec<String> = allowed.iter().map(Scheme::to_string).collect();
        Err(source.error(
            "coupling.scheme",
            format!(
                "is {named}, which the fluid's method cannot follow; allowed: auto, {}",
                names.join(", ")
            ),
            "leave the key out, or choose a method of the fluid that can follow it",
        ))
    }
}
