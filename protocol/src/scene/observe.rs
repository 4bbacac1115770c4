//! What a run writes down.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// What is written to `series.csv` and `fields/`.
#[derive(Clone, Debug, Default, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Observe {
    /// Time between rows of `series.csv`, s; 0: every window.
    pub every: f64,
    /// Grains with columns of their own; by default the first 16.
    pub grains: Option<Vec<usize>>,
    /// Times at which the fluid's fields are written, s.
    pub fields_at: Vec<f64>,
    /// Time between field files, s; 0: none besides `fields_at`.
    pub fields_every: f64,
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
    /// Where the reference comes from.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub source: Option<String>,
}

impl Observe {
    /// Are fields due in the window from `start` to `end`, s? At t = 0 only in the first window.
    #[must_use]
    pub fn fields_due(&self, start: f64, end: f64) -> bool {
        let asked = self.fields_at.iter().any(|t| (start < *t || (start == 0.0 && *t <= 0.0)) && *t <= end);
        // A multiple that is missed by rounding counts as reached.
        let count = |t: f64| (t / self.fields_every * (1.0 + 1e-12)).floor();
        asked || (self.fields_every > 0.0 && count(end) > count(start))
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
    /// Last value of a column of `series.csv`.
    Final {
        /// Column.
        column: String,
    },
    /// Largest value of a column of `series.csv`.
    Max {
        /// Column.
        column: String,
    },
}

impl MetricKind {
    /// The grain it is about, if it is about one.
    #[must_use]
    pub fn grain(&self) -> Option<usize> {
        match self {
            Self::TerminalReynolds { grain }
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
            Self::Mean { .. } | Self::Final { .. } | Self::Max { .. } => None,
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
