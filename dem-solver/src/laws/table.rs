//! Laws of contact between two surfaces; each model is a file of its own.
//!
//! | law | file |
//! |---|---|
//! | linear spring and dashpot (Cundall & Strack 1979; Izard et al. 2014) | [`crate::laws::linear`] |
//! | Hertz–Mindlin (Hertz 1882; Mindlin 1949; Tsuji et al. 1992) | [`crate::laws::hertz_mindlin`] |
//! | repulsion of Wan & Turek (2007) | [`crate::laws::wan_turek`] |
//! | resistance to rolling, part of the first two (Ai et al. 2011) | [`crate::laws::rolling`] |

use crate::error::SpecError;
use crate::laws::coefficients::LinearPair;
use crate::laws::hertz_mindlin::{HertzMindlin, HertzPair};
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
    /// Hertz's normal force, Mindlin's tangential stiffness, restitution-based damping.
    HertzMindlin(HertzMindlin),
    /// Short-range repulsion without friction (Wan & Turek 2007), as Verjus & Guillou use it.
    WanTurek(WanTurek),
}

impl ContactLaw {
    /// Checks ranges.
    pub fn validate(&self) -> Result<(), SpecError> {
        match self {
            Self::LinearSpringDashpot(law) => law.validate(),
            Self::HertzMindlin(law) => law.validate(),
            Self::WanTurek(law) => law.validate(),
        }
    }

    /// Gap below which the law acts, m: zero but for a law with a range.
    #[must_use]
    pub fn range(&self) -> f64 {
        match self {
            Self::LinearSpringDashpot(_) | Self::HertzMindlin(_) => 0.0,
            Self::WanTurek(law) => law.range,
        }
    }

    /// Contact time t_c that bounds the sub-step, s, for the smallest effective mass and effective
    /// radius of all contacts; none for a law without one.
    #[must_use]
    pub fn contact_time(&self, mass: f64, radius: f64) -> Option<f64> {
        match self {
            Self::LinearSpringDashpot(law) => Some(law.contact_time_of(mass)),
            Self::HertzMindlin(law) => Some(law.contact_time_of(mass, radius)),
            Self::WanTurek(_) => None,
        }
    }

    /// γ_t/m* of a contact of effective mass `mass`, 1/s; zero for a law whose dashpots are not those of a linear spring.
    #[must_use]
    pub fn tangential_rate(&self, mass: f64) -> f64 {
        match self {
            Self::LinearSpringDashpot(law) => law.tangential_rate(mass),
            Self::HertzMindlin(_) | Self::WanTurek(_) => 0.0,
        }
    }

    /// Coefficient of friction and γ_t/γ_n of a law with a tangential spring.
    #[must_use]
    pub fn tangential(&self) -> Option<(f64, f64)> {
        match self {
            Self::LinearSpringDashpot(law) => Some((law.friction, law.damping_ratio)),
            Self::HertzMindlin(law) => Some((law.friction, law.damping_ratio)),
            Self::WanTurek(_) => None,
        }
    }

    /// Resistance to rolling, if it has one.
    #[must_use]
    pub fn rolling(&self) -> Option<Rolling> {
        match self {
            Self::LinearSpringDashpot(law) => law.rolling,
            Self::HertzMindlin(law) => law.rolling,
            Self::WanTurek(_) => None,
        }
    }

    /// The law as the loops use it.
    #[must_use]
    pub fn pair(&self) -> PairLaw {
        match self {
            Self::LinearSpringDashpot(law) => match law.stiffness {
                Some(stiffness) => PairLaw::Stiff(StiffPair { unit: law.pair(), stiffness }),
                None => PairLaw::Linear(law.pair()),
            },
            Self::HertzMindlin(law) => PairLaw::Hertz(law.pair()),
            Self::WanTurek(law) => PairLaw::WanTurek(*law),
        }
    }
}

/// A law ready for the loops.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PairLaw {
    /// Linear spring and dashpot, one contact time for all.
    Linear(LinearPair),
    /// Linear spring and dashpot, one stiffness for all.
    Stiff(StiffPair),
    /// Hertz–Mindlin.
    Hertz(HertzPair),
    /// Repulsion of Wan & Turek.
    WanTurek(WanTurek),
}

/// Linear coefficients of one stiffness for every mass.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StiffPair {
    /// Coefficients per unit effective mass for a contact time of one second.
    pub unit: LinearPair,
    /// k_n, N/m.
    pub stiffness: f64,
}

impl StiffPair {
    /// Coefficients per unit effective mass at effective mass `mass`: rates scale with 1/t_c.
    #[inline(always)]
    #[must_use]
    pub fn at(&self, mass: f64) -> LinearPair {
        let rate2 = self.stiffness / (mass * self.unit.stiffness);
        let rate = rate2.sqrt();
        LinearPair {
            stiffness: self.unit.stiffness * rate2,
            damping: self.unit.damping * rate,
            tangential_stiffness: self.unit.tangential_stiffness * rate2,
            tangential_damping: self.unit.tangential_damping * rate,
            ..self.unit
        }
    }
}

/// Laws of all pairs of materials: a square table, row by row.
#[derive(Clone, Debug, PartialEq)]
pub struct LawTable {
    count: usize,
    law: Vec<PairLaw>,
    rolling: Vec<Option<Rolling>>,
}

impl LawTable {
    /// Table with one law everywhere.
    #[must_use]
    pub fn new(count: usize, law: &ContactLaw) -> Self {
        Self { count, law: vec![law.pair(); count * count], rolling: vec![law.rolling(); count * count] }
    }

    /// Puts `law` between materials `a` and `b`.
    pub fn set(&mut self, a: usize, b: usize, law: &ContactLaw) {
        for place in [a * self.count + b, b * self.count + a] {
            self.law[place] = law.pair();
            self.rolling[place] = law.rolling();
        }
    }

    /// Resistance to rolling between materials `a` and `b`.
    #[inline(always)]
    #[must_use]
    pub fn rolling(&self, a: usize, b: usize) -> Option<&Rolling> {
        self.rolling[a * self.count + b].as_ref()
    }

    /// Whether any pair of materials resists rolling.
    #[must_use]
    pub fn any_rolling(&self) -> bool {
        self.rolling.iter().any(Option::is_some)
    }

    /// The linear law with one contact time between materials `a` and `b`, if they have one.
    #[must_use]
    pub fn linear(&self, a: usize, b: usize) -> Option<LinearPair> {
        match self.between(a, b) {
            PairLaw::Linear(law) => Some(*law),
            _ => None,
        }
    }

    /// Number of materials.
    #[must_use]
    pub fn count(&self) -> usize {
        self.count
    }

    /// Whether all pairs of materials have a linear law with one contact time, and none resists rolling.
    #[must_use]
    pub fn all_linear(&self) -> bool {
        !self.any_rolling() && self.law.iter().all(|law| matches!(law, PairLaw::Linear(_)))
    }

    /// Law between materials `a` and `b`.
    #[inline(always)]
    #[must_use]
    pub fn between(&self, a: usize, b: usize) -> &PairLaw {
        &self.law[a * self.count + b]
    }
}
