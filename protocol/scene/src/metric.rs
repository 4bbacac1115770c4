//! Numbers for `summary.json`: what a scene asks for. How each kind is measured stands in `metrics/` of
//! `bedload-output`, what the solvers alone can measure with them.

use std::collections::BTreeMap;
use std::path::PathBuf;

use schemars::JsonSchema;
use serde::de::{Error as _, Unexpected};
use serde::{Deserialize, Deserializer, Serialize};

use crate::domain::Axis;
use crate::walls::forever;

/// How metrics begin that a fluid alone has unasked, the letter of an axis behind it.
pub const SUPERFICIAL: &str = "superficial_velocity_";

/// A number for `summary.json`.
#[derive(Clone, Debug, Deserialize, Serialize, JsonSchema)]
pub struct Metric {
    /// Name in `summary.json`.
    pub name: String,
    /// What it measures; see the kinds.
    #[serde(flatten)]
    pub kind: MetricKind,
    /// Published or exact value to compare with.
    pub reference: Option<f64>,
    /// A value to stand beside it that is no reference, such as another code's: no error is made of it.
    pub compared_with: Option<f64>,
    /// Where the reference, or the value beside it, comes from.
    pub source: Option<String>,
    /// What to know about the number, such as why it differs from its reference.
    pub remark: Option<String>,
}

/// Kinds of metric. D = 2 R of the grain, V_T its terminal speed: the largest settling speed before
/// the first contact.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields)]
pub enum MetricKind {
    /// ρ V D/μ with V the mean speed over the last tenth of the run.
    TerminalReynolds(OfGrain),
    /// Velocity gained in the first window over its length and g.
    InitialAcceleration(OfGrain),
    /// V_C/V_T: normal speed at the first touch over V_T.
    ImpactVelocityRatio(OfGrain),
    /// V_R/V_T: normal speed at the end of the first contact over V_T.
    ReboundVelocityRatio(OfGrain),
    /// Speed out over speed in at a stated gap, first rebound.
    RestitutionAtGap {
        /// Grain.
        #[serde(default)]
        grain: usize,
        /// Gap over R.
        gap: f64,
    },
    /// Largest gap after the first contact over D.
    ReboundHeight(OfGrain),
    /// Largest gap between the second and the third contact over D.
    SecondReboundHeight(OfGrain),
    /// Time from the first touch to the top of the first rebound over (D/g)^½.
    ReboundRiseTime(OfGrain),
    /// Time from the first touch to the second over (D/g)^½.
    ReboundDuration(OfGrain),
    /// (ρ_p + ρ/2) V_T D/(9 μ) (Izard et al. 2014, eq. 23).
    Stokes(OfGrain),
    /// ρ V_T D/μ.
    Reynolds(OfGrain),
    /// Mean contact force over submerged weight in the last tenth of the run.
    RestingForceRatio(OfGrain),
    /// Mean of a column of `series.csv` over time, from an instant on: trapezoidal where its values are of
    /// the ends of windows, weighed with their lengths where they are of whole windows.
    Mean(MeanOf),
    /// Standard deviation of a column of `series.csv` over time, from an instant on.
    Deviation(OfColumn),
    /// Last value of a column of `series.csv`.
    Final {
        /// Column.
        column: String,
    },
    /// Largest value of a column of `series.csv` from a time on.
    Max(OfColumn),
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
        file: PathBuf,
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
        file: PathBuf,
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
        file: PathBuf,
        /// Rows of the file that count: text of a column by its name.
        #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
        select: BTreeMap<String, String>,
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
    JanssenFit(InRange),
    /// f_w K measured: friction at the side walls over granular pressure, mean over slabs.
    JanssenDirect(InRange),
    /// Mean granular pressure of the profile, Pa.
    PlateauPressure(InRange),
    /// Shear stress over normal stress across the slabs of the profile, sums over those of the range.
    StressRatio(InRange),
    /// I = γ̇ d/√(σ/ρ_p) of the profile (GDR MiDi 2004), mean over slabs; σ is the normal stress across them.
    InertialNumber(InRange),
    /// n of the best fit of v = a − b (h − z)^n to the velocity of the profile, h its top; 3/2 is Bagnold's.
    ShearExponent(InRange),
    /// Mean velocity of the fluid over its volume and the time of the mean of `observe.planes`.
    MeanFluidVelocity(OfComponent),
    /// The same of the grains.
    MeanGrainVelocity(OfComponent),
    /// θ = τ/((ρ_p − ρ) g D), τ the whole shear stress at the surface of the bed, of fluid and grains, from
    /// the balance of the layers above it in steady flow.
    Shields(OfSurface),
    /// The fluid's part of it: μ γ̇/((ρ_p − ρ) g D), γ̇ the shear of the mean fluid velocity at the surface.
    FluidShields(OfSurface),
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
pub(crate) fn surface() -> f64 {
    0.3
}

fn most() -> f64 {
    0.9
}

fn flank() -> [f64; 2] {
    [0.2, 0.8]
}

/// Of one grain.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct OfGrain {
    /// Grain.
    #[serde(default)]
    pub grain: usize,
}

/// Of one column of `series.csv`.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct OfColumn {
    /// Column.
    pub column: String,
    /// Start, s.
    #[serde(default)]
    pub from: f64,
}

/// What a mean over time is of.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MeanOf {
    /// Column.
    pub column: String,
    /// Where it begins.
    #[serde(default)]
    pub from: MeanFrom,
}

/// Where a mean over time begins.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, JsonSchema)]
#[serde(untagged)]
pub enum MeanFrom {
    /// At this time, s.
    Time(f64),
    /// Where a test finds the column stationary; then the mean has a standard error.
    Test(MeanTest),
}

/// Tests of where a mean begins.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum MeanTest {
    /// MSER-5 (White 1997).
    Stationary,
}

impl<'de> Deserialize<'de> for MeanFrom {
    // By hand, so that an error has the value, by which its place is found.
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        #[derive(Deserialize)]
        #[serde(untagged, expecting = "expected a time in s, or \"stationary\"")]
        enum Written {
            Time(f64),
            Test(String),
        }
        match Written::deserialize(from)? {
            Written::Time(time) => Ok(Self::Time(time)),
            Written::Test(name) if name == "stationary" => Ok(Self::Test(MeanTest::Stationary)),
            Written::Test(name) => {
                Err(D::Error::invalid_value(Unexpected::Str(&name), &"a time in s, or \"stationary\""))
            }
        }
    }
}

impl Default for MeanFrom {
    fn default() -> Self {
        Self::Time(0.0)
    }
}

/// At the surface of a bed.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct OfSurface {
    /// Time of the sample of `observe.planes`, s; by default their mean.
    pub at: Option<f64>,
    /// Solid fraction that marks the surface.
    #[serde(default = "surface")]
    pub surface: f64,
}

/// Of one component of a velocity.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct OfComponent {
    /// Component.
    pub component: Axis,
}

/// Of a part of the profile of the grains.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct InRange {
    /// Part of the profile, m.
    pub range: [f64; 2],
}

/// Part of a run.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Span {
    /// Start, s.
    #[serde(default)]
    pub from: f64,
    /// End, s.
    #[serde(default = "forever")]
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
    pub file: PathBuf,
    /// Half-length L₀ of the column, m.
    pub half_length: f64,
    /// Middle along x, m.
    pub centre: f64,
    /// Height of the floor, m; by default the lower z face.
    pub floor: Option<f64>,
}

impl Column {
    /// A column that ends at the first gap, let go at once, with bins of the default width.
    pub fn at_rest(half_length: f64, centre: f64) -> Self {
        Self { half_length, centre, release: 0.0, bin: 0.0, end: HeapEnd::Gap, floor: None }
    }
}

impl MetricKind {
    /// The values of its keys, as `scene.toml` has them.
    pub fn keys(&self) -> toml::Table {
        toml::Table::try_from(self).unwrap_or_default()
    }

    /// The table that a metric of this kind and of this name leaves in the output folder under its own name,
    /// if it leaves one.
    pub fn table(&self, name: &str) -> Option<String> {
        matches!(self, Self::VelocityDifference { .. }).then(|| format!("{name}.csv"))
    }

    /// The grain that it is about, if it is about one.
    pub fn grain(&self) -> Option<usize> {
        self.keys().get("grain")?.as_integer()?.try_into().ok()
    }

    /// The column that it is about, if it is about one.
    pub fn column(&self) -> Option<Column> {
        match self {
            Self::DepositRunOut(column)
            | Self::DepositHeight(column)
            | Self::DepositAspectRatio(column)
            | Self::ColumnSolidFraction(column) => Some(*column),
            Self::DepositProfileDifference(HeapReference { half_length, centre, floor, .. }) => {
                Some(Column { floor: *floor, ..Column::at_rest(*half_length, *centre) })
            }
            _ => None,
        }
    }
}
