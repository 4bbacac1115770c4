//! What a run writes down.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::domain::Axis;

/// What is written to `series.csv` and `fields/`.
#[derive(Clone, Debug, Default, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Observe {
    /// Time between rows of `series.csv`, s; 0: every window.
    pub every: f64,
    /// Grains with columns of their own; by default the first 16.
    pub grains: Option<Vec<usize>>,
    /// Times at which fields and grains are written, s.
    pub fields_at: Vec<f64>,
    /// Time between field files, s; 0: none besides `fields_at`. Without it `bedload run` chooses one, and
    /// others take 0.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub fields_every: Option<f64>,
    /// Coarse-grained profile of the grains: written with the fields and at the end of a DEM run.
    pub profile: Option<Profile>,
    /// Averages of fluid and grains over planes of cells.
    pub planes: Option<ObservedPlanes>,
    /// Columns of the mean velocity and spin of a grain over each window, which its forces are of.
    pub mean_velocity: bool,
    /// Columns of what the scene changes over time (gravity, velocities of walls, …), at the end of each
    /// window.
    pub values_over_time: bool,
    /// Columns of elastic, gravitational and dissipated energy in `series.csv` (dry scenes).
    pub energy: bool,
    /// Forces on chosen grains in each sub-step of chosen windows, from `bedload-dem`.
    pub substeps: Option<ObservedSubsteps>,
    /// Columns of `series.csv` about the whole bed.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub totals: Option<ObservedTotals>,
}

/// What is written down of the whole bed, window by window.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ObservedTotals {
    /// The columns.
    pub columns: Vec<Total>,
    /// Axis across the bed, upwards; it is not periodic.
    #[serde(default = "upward")]
    pub axis: Axis,
    /// Solid fraction that marks the surface of the bed.
    #[serde(default = "crate::metric::surface")]
    pub surface: f64,
    /// Speed from which on a grain counts as moving, m/s.
    pub speed: Option<f64>,
}

impl ObservedTotals {
    /// Is one of these columns asked for?
    pub fn has(&self, columns: &[Total]) -> bool {
        self.columns.iter().any(|column| columns.contains(column))
    }
}

/// A quantity of the whole bed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Total {
    /// Volume flux of the grains per width, m²/s.
    GrainFlux,
    /// Volume flux of the fluid per width, m²/s.
    FluidFlux,
    /// Mean velocity of the grains in each plane, integrated across the bed, m²/s.
    VelocityFlux,
    /// Height of the bed, m.
    BedHeight,
    /// Number of free grains that move.
    MovingGrains,
    /// Shields number of the total stress.
    Shields,
    /// Mean number of contacts of a free grain.
    CoordinationNumber,
    /// Force of the fluid, and of contacts, on each wall of the box, N.
    WallForce,
    /// Force of fluid, contacts and films together per area on the walls across the bed, Pa.
    WallStress,
}

impl Total {
    /// Those that need the forces on the walls of the box.
    pub const ON_WALLS: [Self; 3] = [Self::WallForce, Self::WallStress, Self::Shields];
}

/// Whose forces are written down sub-step by sub-step, and when.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ObservedSubsteps {
    /// Grains, by number.
    pub grains: Vec<usize>,
    /// Start of the windows, s.
    #[serde(default)]
    pub from: f64,
    /// Their end, s.
    #[serde(default = "crate::walls::forever")]
    pub to: f64,
}

impl ObservedSubsteps {
    /// Is the window from `start` to `end`, s, one of them?
    pub fn has(&self, start: f64, end: f64) -> bool {
        start < early(self.to) && early(end) > self.from
    }
}

/// Slabs over which the grains are averaged (Goldhirsch 2010).
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Profile {
    /// Axis across the slabs.
    #[serde(default = "upward")]
    pub axis: Axis,
    /// Lower corner (x, y, z) of the region, m.
    pub lower: [f64; 3],
    /// Upper corner, m.
    pub upper: [f64; 3],
    /// Number of slabs.
    pub slabs: usize,
}

/// Planes of cells over which the fluid averages both phases.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ObservedPlanes {
    /// Axis across the planes.
    #[serde(default = "upward")]
    pub axis: Axis,
    /// Time between samples, s.
    pub every: f64,
    /// Start of the mean over time, s.
    #[serde(default)]
    pub from: f64,
    /// End of the mean over time, s.
    #[serde(default = "crate::walls::forever")]
    pub to: f64,
    /// Times whose nearest samples are kept under their own names, s.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub at: Vec<f64>,
    /// Also stresses, pressure and granular temperature?
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub stress: bool,
}

impl ObservedPlanes {
    /// Is a sample due in the window from `start` to `end`, s?
    pub fn due(&self, start: f64, end: f64) -> bool {
        periods(end, self.every) > periods(start, self.every)
    }

    /// Does a sample of time `time`, s, count for the mean?
    pub fn counts(&self, time: f64) -> bool {
        early(self.from) <= time && early(time) <= self.to
    }
}

/// What rounding may take of a time: the ends of windows are sums of many steps.
const EARLY: f64 = 1e-9;

/// From when on the time `t`, s, counts as reached.
fn early(t: f64) -> f64 {
    t * (1.0 - EARLY)
}

/// Whole periods up to `t`; a multiple that is missed by rounding counts as reached.
fn periods(t: f64, every: f64) -> f64 {
    (t / every * (1.0 + EARLY)).floor()
}

fn upward() -> Axis {
    Axis::Z
}

impl Observe {
    /// Are fields due in the window from `start` to `end`, s? A time is due in the first window that ends
    /// then or later, where rounding does not count; t = 0 in the first of all.
    pub fn fields_due(&self, start: f64, end: f64) -> bool {
        let asked = |t: &f64| (start < early(*t) || (start == 0.0 && *t <= 0.0)) && early(*t) <= end;
        let every = self.fields_every.unwrap_or(0.0);
        self.fields_at.iter().any(asked) || (every > 0.0 && periods(end, every) > periods(start, every))
    }
}
