//! The law of contact of a run: as a scene says it, and as the loops use it.

use crate::error::SpecError;
use crate::laws::coefficients::LinearPair;
use crate::laws::linear::LinearSpringDashpot;
use crate::laws::rolling::Rolling;
use crate::laws::wan_turek::WanTurek;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Law of contact between two surfaces.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "law", rename_all = "kebab-case")]
pub enum ContactLaw {
    /// Spring and dashpot along the normal, spring, dashpot and slider along the tangent
    /// (Cundall & Strack 1979; Izard et al. 2014, eqs 13–18).
    LinearSpringDashpot(LinearSpringDashpot),
    /// Short-range repulsion without friction (Wan & Turek 2007), as Verjus & Guillou use it.
    WanTurek(WanTurek),
}

impl ContactLaw {
    /// Checks ranges.
    pub fn validate(&self) -> Result<(), SpecError> {
        match self {
            Self::LinearSpringDashpot(law) => law.validate(),
            Self::WanTurek(law) => law.validate(),
        }
    }

    /// The law of springs and dashpots, if it is that.
    #[must_use]
    pub fn linear(&self) -> Option<&LinearSpringDashpot> {
        match self {
            Self::LinearSpringDashpot(law) => Some(law),
            Self::WanTurek(_) => None,
        }
    }

    /// Gap below which the law acts, m: zero but for a law with a range.
    #[must_use]
    pub fn range(&self) -> f64 {
        match self {
            Self::LinearSpringDashpot(_) => 0.0,
            Self::WanTurek(law) => law.range,
        }
    }

    /// The law as the loops use it.
    #[must_use]
    pub fn pair(&self) -> PairLaw {
        match self {
            Self::LinearSpringDashpot(law) => match law.stiffness {
                Some(stiffness) => PairLaw::Stiff { unit: law.pair(), stiffness },
                None => PairLaw::Linear(law.pair()),
            },
            Self::WanTurek(law) => PairLaw::WanTurek(*law),
        }
    }

    /// Resistance to rolling, if it has one.
    #[must_use]
    pub fn rolling(&self) -> Option<Rolling> {
        self.linear()?.rolling
    }
}

/// A law ready for the loops.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PairLaw {
    /// Linear spring and dashpot, one contact time for all.
    Linear(LinearPair),
    /// Linear spring and dashpot, one stiffness for all.
    Stiff {
        /// Coefficients per unit effective mass for a contact time of one second.
        unit: LinearPair,
        /// k_n, N/m.
        stiffness: f64,
    },
    /// Repulsion of Wan & Turek.
    WanTurek(WanTurek),
}

impl PairLaw {
    /// Coefficients of springs and dashpots at effective mass `mass`; none of a law without them.
    #[inline(always)]
    #[must_use]
    pub fn at(&self, mass: f64) -> Option<LinearPair> {
        match self {
            Self::Linear(pair) => Some(*pair),
            Self::Stiff { unit, stiffness } => {
                // rates scale with 1/t_c
                let rate2 = stiffness / (mass * unit.stiffness);
                let rate = rate2.sqrt();
                Some(LinearPair {
                    stiffness: unit.stiffness * rate2,
                    damping: unit.damping * rate,
                    tangential_stiffness: unit.tangential_stiffness * rate2,
                    tangential_damping: unit.tangential_damping * rate,
                    ..*unit
                })
            }
            Self::WanTurek(_) => None,
        }
    }
}
