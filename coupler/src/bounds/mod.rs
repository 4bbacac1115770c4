//! Every stability and accuracy bound that the coupler knows, one model a function.
//!
//! A bound is a value, a limit and a direction; `bedload check` prints each with its margin, and a
//! run refuses to start while one of level [`Level::Refuse`] is broken and not forced.

mod density;
mod light;
mod resolution;
mod steps;
mod viscous;

use protocol::facts::{DemFacts, FluidFacts};
use protocol::scene::CheckedScene;
use protocol::scheme::Scheme;
use serde::Serialize;

pub(crate) use density::lightest;
pub use density::{Method, Motion, lowest_density_ratio};

use crate::config::Coupling;

/// Names of all bounds, as printed and as `coupling.force` takes them.
pub const NAMES: &[&str] = &[
    "density-ratio",
    "density-range",
    "loads-singular",
    "resting-weight",
    "cfl",
    "direct-forcing",
    "direct-forcing-accuracy",
    "dense-bed-forcing",
    "explicit-viscosity",
    "explicit-viscosity-ab2",
    "contact-steps",
    "contact-accuracy",
    "contact-dashpot",
    "window-over-contact",
    "tangential-dashpot",
    "explicit-lubrication",
    "resolution",
    "resolution-accuracy",
    "memory",
    "overlap",
];

/// The only bound that cannot be forced: behind it stands a division by zero.
pub const SINGULAR: &str = "loads-singular";

/// The bound that decides whether windows are to be repeated.
pub const DENSITY_RATIO: &str = "density-ratio";

/// What a broken bound does.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Level {
    /// The run is refused.
    Refuse,
    /// The run goes on with a warning.
    Warn,
}

/// On which side of the limit the value must lie.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Side {
    /// value ≥ limit.
    AtLeast,
    /// value ≤ limit.
    AtMost,
}

/// One bound of a plan.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Bound {
    /// Name, one of [`NAMES`].
    pub name: &'static str,
    /// What is compared, as a formula.
    pub quantity: &'static str,
    /// Its value in this plan.
    pub value: f64,
    /// Side of the limit.
    pub side: Side,
    /// Limit.
    pub limit: f64,
    /// By what factor the value keeps the limit: 1 at the limit, less where it is broken.
    pub margin: f64,
    /// Is it kept?
    pub holds: bool,
    /// What happens if not.
    pub level: Level,
    /// What goes wrong beyond it.
    pub why: String,
    /// Where the limit comes from.
    pub source: &'static str,
    /// What to do.
    pub remedy: String,
}

impl Bound {
    /// A bound that the value keeps or breaks; a limit is met with a tolerance of rounding.
    #[must_use]
    pub fn new(name: &'static str, quantity: &'static str, value: f64, side: Side, limit: f64) -> Self {
        debug_assert!(NAMES.contains(&name), "{name} is missing in NAMES");
        let margin = match side {
            Side::AtLeast => value / limit,
            Side::AtMost => limit / value,
        };
        // 0/0 at a value and limit of zero is a bound met; any other NaN is not.
        let holds = value == limit || margin >= 1.0 - 1e-9;
        Self {
            name,
            quantity,
            value,
            side,
            limit,
            margin,
            holds,
            level: Level::Refuse,
            why: String::new(),
            source: "",
            remedy: String::new(),
        }
    }

    /// Only a warning.
    #[must_use]
    pub fn warning(mut self) -> Self {
        self.level = Level::Warn;
        self
    }

    /// With what goes wrong, where that is known from, and what to do.
    #[must_use]
    pub fn because(
        mut self,
        why: impl Into<String>,
        source: &'static str,
        remedy: impl Into<String>,
    ) -> Self {
        self.why = why.into();
        self.source = source;
        self.remedy = remedy.into();
        self
    }

    /// Does it stop a run whose scene forces `forced`?
    #[must_use]
    pub fn refuses(&self, forced: &[String]) -> bool {
        let overridden = self.name != SINGULAR && forced.iter().any(|name| name == self.name);
        !self.holds && self.level == Level::Refuse && !overridden
    }

    /// `value ≤ limit` as text.
    #[must_use]
    pub fn relation(&self) -> String {
        let sign = if self.side == Side::AtLeast { '≥' } else { '≤' };
        format!("{} = {:.4}, must be {sign} {:.4}", self.quantity, Short(self.value), Short(self.limit))
    }
}

/// A number with few digits, whatever its size.
#[derive(Clone, Copy, Debug)]
pub struct Short(pub f64);

impl std::fmt::Display for Short {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let digits = f.precision().unwrap_or(4);
        let size = self.0.abs();
        if self.0 == 0.0 || !self.0.is_finite() {
            return write!(f, "{}", self.0);
        }
        if !(1e-3..1e6).contains(&size) {
            return write!(f, "{:.*e}", digits - 1, self.0);
        }
        let places = (digits as i32 - 1 - size.log10().floor() as i32).max(0) as usize;
        let text = format!("{:.places$}", self.0);
        f.write_str(if places > 0 { text.trim_end_matches('0').trim_end_matches('.') } else { &text })
    }
}

/// A choice that a solver resolved, as in `[section] key`; what a foreign solver does not tell is not known.
pub(crate) fn choice<'a>(resolved: &'a toml::Table, section: &str, key: &str) -> Option<&'a toml::Value> {
    resolved.get(section)?.get(key)
}

/// The time steps of a plan, without which no bound can be judged.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Ladder {
    /// Window: the fluid's step, or the DEM's where there is no fluid, s.
    pub dt_fluid: f64,
    /// Sub-step as it comes out: window over sub-steps, s.
    pub dt_dem: f64,
    /// Sub-steps in a full window.
    pub substeps: u64,
    /// Shortest contact duration, s; infinite where nothing can touch.
    pub contact_time: f64,
}

/// What the bounds are judged on.
#[derive(Clone, Copy, Debug)]
pub struct Facts<'a> {
    /// Scene.
    pub scene: &'a CheckedScene,
    /// The fluid, where one takes part.
    pub fluid: Option<&'a FluidFacts>,
    /// The DEM, where one takes part.
    pub dem: Option<&'a DemFacts>,
    /// `[coupling]`.
    pub coupling: &'a Coupling,
    /// Order of the exchange; none where nothing is exchanged.
    pub scheme: Option<Scheme>,
    /// Time steps.
    pub ladder: Ladder,
    /// Memory that the machine can still give, bytes.
    pub memory: Option<u64>,
}

impl Facts<'_> {
    /// Kinematic viscosity ν, m²/s.
    fn viscosity(&self) -> Option<f64> {
        self.scene.scene.medium.as_ref().map(protocol::scene::Medium::kinematic_viscosity)
    }
}

/// Every bound that applies to this plan.
#[must_use]
pub fn all(facts: &Facts<'_>) -> Vec<Bound> {
    let mut bounds = Vec::new();
    density::add(facts, &mut bounds);
    viscous::add(facts, &mut bounds);
    steps::add(facts, &mut bounds);
    resolution::add(facts, &mut bounds);
    bounds
}
