//! The `[coupling]` section of the scene.

use protocol::facts::LoadsForm;
use protocol::scene::{CheckedScene, SceneError, SceneSource};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Order of the exchange within a window.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Scheme {
    /// The fluid takes its whole step with the grains' last motion and sends the loads of it.
    Explicit,
    /// The fluid predicts, sends the loads, waits for the new motion, and only then imposes it.
    SemiImplicit,
}

impl Scheme {
    /// The order that a form of the loads stands for.
    #[must_use]
    pub fn of(loads: LoadsForm) -> Self {
        if loads.is_semi_implicit() { Self::SemiImplicit } else { Self::Explicit }
    }
}

impl std::fmt::Display for Scheme {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Explicit => "explicit",
            Self::SemiImplicit => "semi-implicit",
        })
    }
}

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
    /// `semi-implicit` or `explicit`. Follows the fluid's form of the loads; written out, it must
    /// agree with it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub scheme: Option<Scheme>,
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
            scheme: None,
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
    /// [`SceneError`] at the key that is unknown, of the wrong type or out of range.
    pub fn read(scene: &CheckedScene) -> Result<Self, SceneError> {
        let source = &scene.source;
        let coupling = source.section::<Owned>()?.coupling;
        coupling.check_numbers(source)?;
        coupling.check_names(source)?;
        Ok(coupling)
    }

    fn check_numbers(&self, source: &SceneSource) -> Result<(), SceneError> {
        let positive = [
            ("max_dt_over_contact_time", self.max_dt_over_contact_time),
            ("steps_per_contact", self.steps_per_contact),
            ("deadline", self.deadline),
            ("startup_deadline", self.startup_deadline),
        ];
        for (key, value) in positive {
            if !(value > 0.0 && value <= 1e9) {
                let message = format!("is {value}; allowed: 0 < {key} ≤ 1e9");
                return Err(source.error(&format!("coupling.{key}"), message, "give a positive number"));
            }
        }
        if !(self.checkpoint_every >= 0.0 && self.checkpoint_every <= 1e9) {
            let message = format!("is {}; allowed: 0 ≤ checkpoint_every ≤ 1e9", self.checkpoint_every);
            return Err(source.error(
                "coupling.checkpoint_every",
                message,
                "give seconds of wall time, or 0",
            ));
        }
        Ok(())
    }

    fn check_names(&self, source: &SceneSource) -> Result<(), SceneError> {
        let unknown = self.force.iter().find(|name| !crate::bounds::NAMES.contains(&name.as_str()));
        match unknown {
            None => Ok(()),
            Some(name) => Err(source.error(
                "coupling.force",
                format!("names `{name}`, which is no bound; bounds: {}", crate::bounds::NAMES.join(", ")),
                "name a bound that `bedload check` prints, or leave it out",
            )),
        }
    }

    /// Refuses a scheme that the fluid's loads cannot follow.
    ///
    /// # Errors
    /// [`SceneError`] at `coupling.scheme`.
    pub fn agree_with(&self, loads: LoadsForm, source: &SceneSource) -> Result<Scheme, SceneError> {
        let theirs = Scheme::of(loads);
        match self.scheme {
            Some(ours) if ours != theirs => Err(source.error(
                "coupling.scheme",
                format!("is {ours}, but loads of form {loads:?} are exchanged in {theirs} order"),
                "leave the key out, or choose a form of that order (explicit: F1, F2, F3; semi-implicit: F5, F5b)",
            )),
            _ => Ok(theirs),
        }
    }
}
