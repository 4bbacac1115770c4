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
    /// Time between field files, s; 0: none besides `fields_at`.
    pub fields_every: f64,
    /// Coarse-grained profile of the grains: written with the fields and at the end of a DEM run.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub profile: Option<Profile>,
    /// Averages of fluid and grains over planes of cells.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub planes: Option<ObservedPlanes>,
    /// Columns of elastic, gravitational and dissipated energy in `series.csv` (dry scenes).
    pub energy: bool,
    /// Forces on chosen grains in each sub-step of chosen windows, from `bedload-dem`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub substeps: Option<ObservedSubsteps>,
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
    #[must_use]
    pub fn has(&self, start: f64, end: f64) -> bool {
        start < self.to && end > self.from
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
}

impl ObservedPlanes {
    /// Is a sample due in the window from `start` to `end`, s?
    #[must_use]
    pub fn due(&self, start: f64, end: f64) -> bool {
        periods(end, self.every) > periods(start, self.every)
    }
}

/// Whole periods up to `t`; a multiple that is missed by rounding counts as reached.
fn periods(t: f64, every: f64) -> f64 {
    (t / every * (1.0 + 1e-12)).floor()
}

fn upward() -> Axis {
    Axis::Z
}

impl Profile {
    /// Component across the slabs; 3 for an axis that grains have not.
    #[must_use]
    pub fn axis(&self) -> usize {
        match self.axis {
            Axis::X => 0,
            Axis::Y => 1,
            Axis::Z => 2,
            Axis::R => 3,
        }
    }
}

/// A number for `summary.json`.
#[derive(Clone, Debug, Deserialize, Serialize, JsonSchema)]
pub struct Metric {
    /// Name in `summary.json`.
    pub name: String,
    /// What it measures; see the kinds.
    #[serde(flatten)]
    pub kind: MetricKind,
    /// Published or exact value to compare with.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reference: Option<f64>,
    /// A value to stand beside it that is no reference, such as another code's: no error is made of it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub compared_with: Option<f64>,
    /// Where the reference, or the value beside it, comes from.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub source: Option<String>,
    /// What to know about the number, such as why it differs from its reference.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub remark: Option<String>,
}

impl Observe {
    /// Are fields due in the window from `start` to `end`, s? At t = 0 only in the first window.
    #[must_use]
    pub fn fields_due(&self, start: f64, end: f64) -> bool {
        let asked = self.fields_at.iter().any(|t| (start < *t || (start == 0.0 && *t <= 0.0)) && *t <= end);
        let every = self.fields_every;
        asked || (every > 0.0 && periods(end, every) > periods(start, every))
    }
}

/// Kinds of metric. D = 2 R of the grain, V_T its terminal speed: the largest settling speed before
/// the first contact.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields)]
pub enum MetricKind {
    /// ρ V D/μ with V the mean speed over the last tenth of the run.
    TerminalReynolds {
        /// Grain.
        #[serde(default)]
        grain: usize,
    },
    /// Velocity gained in the first window over its length and g.
    InitialAcceleration {
        /// Grain.
        #[serde(default)]
        grain: usize,
    },
    /// V_C/V_T: normal speed at the first touch over V_T.
    ImpactVelocityRatio {
        /// Grain.
        #[serde(default)]
        grain: usize,
    },
    /// V_R/V_T: normal speed at the end of the first contact over V_T.
    ReboundVelocityRatio {
        /// Grain.
        #[serde(default)]
        grain: usize,
    },
    /// Speed out over speed in at a stated gap, first rebound.
    RestitutionAtGap {
        /// Grain.
        #[serde(default)]
        grain: usize,
        /// Gap over R.
        gap: f64,
    },
    /// Largest gap after the first contact over D.
    ReboundHeight {
        /// Grain.
        #[serde(default)]
        grain: usize,
    },
    /// Largest gap between the second and the third contact over D.
    SecondReboundHeight {
        /// Grain.
        #[serde(default)]
        grain: usize,
    },
    /// Time from the first touch to the top of the first rebound over (D/g)^½.
    ReboundRiseTime {
        /// Grain.
        #[serde(default)]
        grain: usize,
    },
    /// Time from the first touch to the second over (D/g)^½.
    ReboundDuration {
        /// Grain.
        #[serde(default)]
        grain: usize,
    },
    /// (ρ_p + ρ/2) V_T D/(9 μ) (Izard et al. 2014, eq. 23).
    Stokes {
        /// Grain.
        #[serde(default)]
        grain: usize,
    },
    /// ρ V_T D/μ.
    Reynolds {
        /// Grain.
        #[serde(default)]
        grain: usize,
    },
    /// Mean contact force over submerged weight in the last tenth of the run.
    RestingForceRatio {
        /// Grain.
        #[serde(default)]
        grain: usize,
    },
    /// Mean of a column of `series.csv` from a time on.
    Mean {
        /// Column.
        column: String,
        /// Start, s.
        #[serde(default)]
        from: f64,
    },
    /// Standard deviation of a column of `series.csv` over time, from an instant on.
    Deviation {
        /// Column.
        column: String,
        /// Start, s.
        #[serde(default)]
        from: f64,
    },
    /// Last value of a column of `series.csv`.
    Final {
        /// Column.
        column: String,
    },
    /// Largest value of a column of `series.csv` from a time on.
    Max {
        /// Column.
        column: String,
        /// Start, s.
        #[serde(default)]
        from: f64,
    },
    /// Frequency of a column of `series.csv`: upward passages of `level` per time between the first
    /// and the last of them.
    Frequency {
        /// Column.
        column: String,
        /// Start, s.
        #[serde(default)]
        from: f64,
        /// Value that is passed, in the unit of the column.
        #[serde(default)]
        level: f64,
    },
    /// Largest difference between a column of `series.csv` and a published course, at the table's times.
    SeriesDifference {
        /// Column.
        column: String,
        /// CSV file with the columns `t` (s) and `value` (in the unit of the column), from the scene's
        /// folder.
        file: std::path::PathBuf,
    },
    /// Largest difference between the velocity of the fluid along a line at the end of a run without
    /// free grains and a published table; the profile goes to `<name>.csv`.
    VelocityDifference {
        /// Component of the velocity.
        component: Axis,
        /// Axis of the line.
        along: Axis,
        /// A point that it passes through (x, y, z), m.
        through: [f64; 3],
        /// CSV file whose column `x`, `y`, `z` or `r`, as `along` says, holds the coordinate, from the
        /// scene's folder.
        file: std::path::PathBuf,
        /// Its column that holds the velocity.
        column: String,
    },
    /// Length of the backward flow behind a grain over its width along the same axis, on the line through its
    /// centre, at the end of a run without free grains.
    WakeLength {
        /// Grain.
        #[serde(default)]
        grain: usize,
        /// Axis of the stream, which runs towards larger coordinates.
        along: Axis,
    },
    /// Largest relative error of Ψ₂(Ψ₁) over the pairs of grains (0, 1), (2, 3), … that have collided,
    /// against a published table. The curve goes to `oblique.csv`.
    ObliqueError {
        /// CSV file with the columns psi1 and psi2, from the scene's folder.
        file: std::path::PathBuf,
        /// Rows of the file that count: text of a column by its name.
        #[serde(default, skip_serializing_if = "std::collections::BTreeMap::is_empty")]
        select: std::collections::BTreeMap<String, String>,
    },
    /// (L∞ − L₀)/L₀ of the final heap, L∞ its mean half-length. The heap goes to `deposit.csv`.
    DepositRunOut(Column),
    /// H∞/L₀ of the final heap.
    DepositHeight(Column),
    /// H₀/L₀ of the column as it is let go.
    DepositAspectRatio(Column),
    /// Part of the column that grains fill as it is let go, between a tenth and four fifths of its height.
    ColumnSolidFraction(Column),
    /// Root mean square of the difference between the final heap's profile and a published one, over
    /// L₀; both are the means of their two sides.
    DepositProfileDifference(HeapReference),
    /// Slope of the surface of the final heap, degrees.
    HeapAngle(HeapSlope),
    /// τ of the best fit of Haff's law (1983), E₀/(1 + t/τ)², to the kinetic energy: a straight line
    /// through E^(−1/2).
    HaffTime(Span),
    /// Root mean square of E^(−1/2) about that line, over its mean.
    HaffMisfit(Span),
    /// f_w K of the best fit of Janssen's curve (Izard et al. 2014, eq. 22) to the profile of
    /// granular pressure.
    JanssenFit {
        /// Part of the profile, m.
        range: [f64; 2],
    },
    /// f_w K measured: friction at the side walls over granular pressure, mean over slabs.
    JanssenDirect {
        /// Part of the profile, m.
        range: [f64; 2],
    },
    /// Mean granular pressure of the profile, Pa.
    PlateauPressure {
        /// Part of the profile, m.
        range: [f64; 2],
    },
    /// Mean velocity of the fluid over its volume and the time of the mean of `observe.planes`.
    MeanFluidVelocity {
        /// Component.
        component: Axis,
    },
    /// The same of the grains.
    MeanGrainVelocity {
        /// Component.
        component: Axis,
    },
    /// θ = μ γ̇/((ρ_p − ρ) g D), γ̇ the shear of the mean fluid velocity at the surface of the bed
    /// (Loiseleux et al. 2005).
    Shields {
        /// Time of the sample of `observe.planes`, s; by default their mean.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        at: Option<f64>,
        /// Solid fraction that marks the surface.
        #[serde(default = "surface")]
        surface: f64,
    },
    /// First time at which so many free grains move as fast as the whole bed is to.
    MobilisationTime {
        /// Speed, m/s.
        speed: f64,
        /// Part of the free grains.
        #[serde(default = "most")]
        share: f64,
    },
}

/// Half the solid fraction of a dense bed.
fn surface() -> f64 {
    0.3
}

fn most() -> f64 {
    0.9
}

/// Part of a run.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Span {
    /// Start, s.
    #[serde(default)]
    pub from: f64,
    /// End, s.
    #[serde(default = "crate::walls::forever")]
    pub to: f64,
}

/// Where the surface of a heap is measured.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct HeapSlope {
    /// Middle of the heap along x, m; a heap against a wall has one flank only.
    #[serde(default)]
    pub centre: f64,
    /// Width of the bins of the profile, m; by default three mean radii.
    #[serde(default)]
    pub bin: f64,
    /// Part of the height that counts: neither the rounded top nor the foot.
    #[serde(default = "flank")]
    pub between: [f64; 2],
}

fn flank() -> [f64; 2] {
    [0.2, 0.8]
}

/// A granular column that is let go.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Column {
    /// Half-length L₀, m.
    pub half_length: f64,
    /// Middle along x, m.
    pub centre: f64,
    /// Time at which it is let go, s.
    #[serde(default)]
    pub release: f64,
    /// Width of the bins of the profile, m; by default three mean radii (the 1.5 d of Staron's
    /// profiles).
    #[serde(default)]
    pub bin: f64,
    /// Where the heap ends.
    #[serde(default)]
    pub end: HeapEnd,
    /// Height of the floor, m; by default the lower z face.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub floor: Option<f64>,
}

/// Where the heap of a column ends: single grains roll on over a smooth floor, and publications
/// count them or not.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum HeapEnd {
    /// Before the first two empty bins in a row, from the middle outward.
    #[default]
    Gap,
    /// At the outermost grain that contacts join to the largest cluster.
    Contact,
    /// At the outermost grain of all.
    Outermost,
}

/// A published profile of a heap.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct HeapReference {
    /// CSV file with the columns x_over_half_length and height_over_half_length, from the
    /// scene's folder.
    pub file: std::path::PathBuf,
    /// Half-length L₀ of the column, m.
    pub half_length: f64,
    /// Middle along x, m.
    pub centre: f64,
    /// Height of the floor, m; by default the lower z face.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub floor: Option<f64>,
}

impl HeapReference {
    /// The column that left the heap.
    #[must_use]
    pub fn column(&self) -> Column {
        let (half_length, centre, floor) = (self.half_length, self.centre, self.floor);
        Column { half_length, centre, release: 0.0, bin: 0.0, end: HeapEnd::Gap, floor }
    }
}

impl MetricKind {
    /// The grain it is about, if it is about one.
    #[must_use]
    pub fn grain(&self) -> Option<usize> {
        match self {
            Self::TerminalReynolds { grain }
            | Self::WakeLength { grain, .. }
            | Self::InitialAcceleration { grain }
            | Self::ImpactVelocityRatio { grain }
            | Self::ReboundVelocityRatio { grain }
            | Self::RestitutionAtGap { grain, .. }
            | Self::ReboundHeight { grain }
            | Self::SecondReboundHeight { grain }
            | Self::ReboundRiseTime { grain }
            | Self::ReboundDuration { grain }
            | Self::Stokes { grain }
            | Self::Reynolds { grain }
            | Self::RestingForceRatio { grain } => Some(*grain),
            _ => None,
        }
    }

    /// The column that it is about, if it is about one.
    #[must_use]
    pub fn column(&self) -> Option<Column> {
        match self {
            Self::DepositRunOut(column)
            | Self::DepositHeight(column)
            | Self::DepositAspectRatio(column)
            | Self::ColumnSolidFraction(column) => Some(*column),
            Self::DepositProfileDifference(reference) => Some(reference.column()),
            _ => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fields_are_due_once_each() {
        let observe = Observe { fields_at: vec![0.0, 0.25], fields_every: 0.1, ..Observe::default() };
        let dt = 0.05;
        let due: Vec<bool> =
            (0..8).map(|k| observe.fields_due(f64::from(k) * dt, f64::from(k + 1) * dt)).collect();
        // t = 0 in the first window, 0.1, 0.2, 0.25, 0.3, 0.4 at the ends of others
        assert_eq!(due, [true, true, false, true, true, true, false, true]);
    }
}
