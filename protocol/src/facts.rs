//! What a solver says of itself before a run, so that the coupler can plan and refuse without knowing
//! its insides. `bedload-fluid check SCENE --json` and `bedload-dem check SCENE --json` print these.

use crate::scheme::Scheme;
use serde::{Deserialize, Serialize};

/// Facts of the fluid solver.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize)]
#[serde(default)]
pub struct FluidFacts {
    /// Cells.
    pub cells: u64,
    /// Estimated memory, bytes.
    pub memory: u64,
    /// Step it proposes, s: the scene's dt, or from CFL and an estimated speed.
    pub dt: f64,
    /// Its first step, s, where it is another one; zero: `dt`.
    pub first_dt: f64,
    /// May the step be changed while the run goes (dt from CFL)?
    pub adaptive: bool,
    /// CFL number it keeps when adaptive.
    pub cfl: f64,
    /// Largest CFL number at which its time scheme is stable.
    pub cfl_limit: f64,
    /// Smallest spacing, m.
    pub spacing: f64,
    /// Orders of the exchange that it can follow, its own first. Empty: it does not say, and is taken to
    /// follow [`Scheme::SemiImplicit`] and [`Scheme::Iterated`].
    pub schemes: Vec<Scheme>,
    /// Keys of `[dem]` that follow from the fluid's method: the coupler hands them to the DEM where the scene
    /// does not have them.
    pub for_dem: toml::Table,
    /// Is it another's solver? What our measurements say of resolution is not known of it.
    #[serde(skip)]
    pub foreign: bool,
    /// Does it follow values of a scene that change over time? Else such a scene is refused.
    pub values_over_time: bool,
    /// Its own bounds.
    pub bounds: Vec<SolverBound>,
    /// Files of the fields at an instant, bytes; zero: it does not say.
    pub field_bytes: u64,
    /// A checkpoint, bytes; zero: it does not say.
    pub checkpoint_bytes: u64,
    /// Estimated cost of a step, s.
    pub step_cost: f64,
    /// Things the user should know (fallbacks, say).
    pub notices: Vec<String>,
    /// The `[fluid]` section with every default written out.
    pub resolved: toml::Table,
}

impl FluidFacts {
    /// Its first step, s.
    pub fn first(&self) -> f64 {
        if self.first_dt > 0.0 { self.first_dt } else { self.dt }
    }

    /// Orders of the exchange that it can follow, its own first.
    pub fn schemes(&self) -> &[Scheme] {
        if self.schemes.is_empty() { &[Scheme::SemiImplicit, Scheme::Iterated] } else { &self.schemes }
    }
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
    /// Does it follow values of a scene that change over time? Else such a scene is refused.
    pub values_over_time: bool,
    /// Its own bounds.
    pub bounds: Vec<SolverBound>,
    /// Files of the grains at an instant, bytes; zero: it does not say.
    pub field_bytes: u64,
    /// A checkpoint, bytes; zero: it does not say.
    pub checkpoint_bytes: u64,
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
    /// Largest overlap over radius: beyond it a soft contact is no contact any more.
    pub const MOST_OVERLAP: f64 = 0.1;
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

/// Value and limit of a bound up to some length of the measure.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
pub struct BoundRow {
    /// Largest measure to which the row applies; the next row applies beyond it.
    pub up_to: f64,
    /// Value.
    pub value: f64,
    /// Limit; infinite: no value keeps it.
    pub limit: f64,
    /// Where the limit comes from.
    pub source: String,
}

/// A bound as a solver knows it: `factor` times a measure of the plan against `limit`, or the row of a table.
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
    /// Table in place of factor, limit and source: the first row counts whose `up_to` is not below the
    /// measure.
    #[serde(skip_serializing_if = "Vec::is_empty", default)]
    pub rows: Vec<BoundRow>,
    /// Order of the exchange in which it applies; none: in each.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub scheme: Option<Scheme>,
    /// Order of the exchange in which this bound is wider: the coupler takes it where the bound is broken and
    /// the scene names no order.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub wider_in: Option<Scheme>,
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
            rows: Vec::new(),
            scheme: None,
            wider_in: None,
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
