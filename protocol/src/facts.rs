//! What a solver says of itself before a run, so that the coupler can plan and refuse without knowing
//! its insides. `bedload-fluid check SCENE --json` and `bedload-dem check SCENE --json` print these.

use serde::{Deserialize, Serialize};

/// How the loads are formed from the immersed-boundary forcing (docs/numerics.md, Forms of the loads).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub enum LoadsForm {
    /// −ρρ_p/(ρ_p−ρ) ∫f dV (Izard et al. 2014, eqs 5–6): singular at ρ_p = ρ.
    #[serde(rename = "izard-2014")]
    Izard2014,
    /// −ρ∫f dV + ρ d/dt∫αu dV (Kempe & Fröhlich 2012).
    #[serde(rename = "kempe-froehlich-2012")]
    KempeFroehlich2012,
    /// −ρ∫f dV + ρV dU/dt (Uhlmann 2005).
    #[serde(rename = "uhlmann-2005")]
    Uhlmann2005,
    /// Force before forcing (after Yu & Shao 2007); imposes (2−β)λ at steady state.
    #[serde(rename = "yu-shao-2007")]
    YuShao2007,
    /// Force before forcing with λ as a true fixed point.
    #[default]
    #[serde(rename = "yu-shao-fixed-point")]
    YuShaoFixedPoint,
}

impl LoadsForm {
    /// Does the fluid wait for the new motion before it imposes it (semi-implicit order)?
    #[must_use]
    pub fn is_semi_implicit(self) -> bool {
        matches!(self, Self::YuShao2007 | Self::YuShaoFixedPoint)
    }
}

impl std::fmt::Display for LoadsForm {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Izard2014 => "izard-2014",
            Self::KempeFroehlich2012 => "kempe-froehlich-2012",
            Self::Uhlmann2005 => "uhlmann-2005",
            Self::YuShao2007 => "yu-shao-2007",
            Self::YuShaoFixedPoint => "yu-shao-fixed-point",
        })
    }
}

/// How the immersed boundary imposes the motion.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum Forcing {
    /// f = α(U − u)/Δt anew each step (Izard et al. 2014, eq. 7).
    Direct,
    /// λ carried from step to step (docs/equations-immersed.md, section 3).
    #[default]
    Carried,
    /// λ on points of the bodies (Yu & Shao 2007; docs/equations-immersed.md, section 9).
    FictitiousDomain,
}

impl Forcing {
    /// Is the force carried from step to step?
    #[must_use]
    pub fn is_carried(self) -> bool {
        self != Self::Direct
    }
}

/// Facts of the fluid solver.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize)]
#[serde(default)]
pub struct FluidFacts {
    /// Cells.
    pub cells: u64,
    /// Estimated memory, bytes.
    pub memory: u64,
    /// Largest step it proposes, s: the scene's dt, or from CFL and an estimated speed.
    pub dt: f64,
    /// May the step be changed while the run goes (dt from CFL)?
    pub adaptive: bool,
    /// CFL number it keeps when adaptive.
    pub cfl: f64,
    /// Largest CFL number at which its time scheme is stable.
    pub cfl_limit: f64,
    /// Smallest spacing, m.
    pub spacing: f64,
    /// Form of the loads.
    pub loads: LoadsForm,
    /// Virtual mass coefficient C_v it sends for grains with nothing near them: the smallest one.
    pub virtual_mass: f64,
    /// Does it take off the mass that a grain displaces on the grid, not that of its true volume?
    pub displaced_mass: bool,
    /// How the motion is imposed.
    pub forcing: Forcing,
    /// Does the carried force move with the grains? Such windows cannot be repeated.
    pub advected_force: bool,
    /// Is it another's solver? What our maps say of a form of loads is not known of it.
    #[serde(skip)]
    pub foreign: bool,
    /// Its own bounds.
    pub bounds: Vec<SolverBound>,
    /// Estimated cost of a step, s.
    pub step_cost: f64,
    /// Things the user should know (fallbacks, say).
    pub notices: Vec<String>,
    /// The `[fluid]` section with every default written out.
    pub resolved: toml::Table,
}

/// Facts of the DEM solver.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize)]
#[serde(default)]
pub struct DemFacts {
    /// Grains.
    pub grains: u64,
    /// Estimated memory, bytes.
    pub memory: u64,
    /// Sub-step it asks for, s.
    pub dt: f64,
    /// Shortest contact duration over all pairs, s (infinite: nothing can touch).
    pub contact_time: f64,
    /// Did the user accept sub-steps above t_c/10?
    pub coarse_dt: bool,
    /// Range within which contact or lubrication acts, as a gap, m.
    pub interaction_range: f64,
    /// Its own bounds.
    pub bounds: Vec<SolverBound>,
    /// Estimated cost of a sub-step, s.
    pub substep_cost: f64,
    /// Things the user should know.
    pub notices: Vec<String>,
    /// The `[dem]` section with every default written out.
    pub resolved: toml::Table,
}

impl DemFacts {
    /// Fewest sub-steps in a contact time: at 10 the restitution is 1 % off, at 5 three, at 2 wrong.
    pub const LEAST_CONTACT_STEPS: f64 = 10.0;
}

/// What a broken bound does.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Level {
    /// The run is refused.
    Refuse,
    /// The run goes on with a warning.
    Warn,
}

/// On which side of the limit the value must lie.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Side {
    /// value ≥ limit.
    AtLeast,
    /// value ≤ limit.
    AtMost,
}

/// What a solver's bound is proportional to: only the coupler knows the time steps.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Measure {
    /// Nothing: the factor is the value.
    One,
    /// Length of a full window, s.
    Window,
    /// Length of a sub-step in a full window, s.
    Substep,
    /// Length of a full window over the contact time.
    WindowOverContact,
}

/// A bound as a solver knows it: `factor` times a measure of the plan against `limit`.
///
/// The coupler puts the time steps in, prints the bound among its own and enforces it.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
pub struct SolverBound {
    /// Name, which `coupling.force` takes.
    pub name: String,
    /// What is compared, as a formula.
    pub quantity: String,
    /// What the value is proportional to.
    pub measure: Measure,
    /// Value for a measure of 1; 1/s for [`Measure::Window`] and [`Measure::Substep`].
    pub factor: f64,
    /// Side of the limit.
    pub side: Side,
    /// Limit.
    pub limit: f64,
    /// What happens where it is broken.
    pub level: Level,
    /// Where another measure reaches a number, the bound is void.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub void_from: Option<(Measure, f64)>,
    /// What goes wrong beyond it.
    pub why: String,
    /// Where the limit comes from.
    pub source: String,
    /// What to do.
    pub remedy: String,
}

impl SolverBound {
    /// A bound that refuses; what goes wrong, the source and the remedy are added by
    /// [`SolverBound::because`].
    #[must_use]
    pub fn new(name: &str, quantity: &str, value: (f64, Measure), side: Side, limit: f64) -> Self {
        Self {
            name: name.to_owned(),
            quantity: quantity.to_owned(),
            measure: value.1,
            factor: value.0,
            side,
            limit,
            level: Level::Refuse,
            void_from: None,
            why: String::new(),
            source: String::new(),
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
    pub fn because(mut self, why: &str, source: &str, remedy: impl Into<String>) -> Self {
        self.why = why.to_owned();
        self.source = source.to_owned();
        self.remedy = remedy.into();
        self
    }
}
