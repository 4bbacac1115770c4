//! Normal contact: linear spring and dashpot, clipped at zero (Cundall & Strack 1979; the seed,
//! eqs 15, 17, 18).
//!
//! F_n = max(0, −k_n δ − γ_n δ̇) for δ < 0, δ the gap. With the effective mass m* = m_i m_j/(m_i + m_j),
//!
//! γ_n = −2 m* ln(e_n)/t_c (eq. 17),  k_n = m* π²/t_c² + γ_n²/(4 m*) (eq. 18).
//!
//! Clipping ends a contact when F_n reaches zero, before the overlap does. With r = −ln(e_n)/π and
//! φ = atan2(2r, 1 − r²) = 2 atan r the contact lasts t_c (1 − φ/π) and gives back exp(−r(π − φ)),
//! more than e_n: 0.97 → 0.9702, 0.87 → 0.8734, 0.5 → 0.5503, 0.3 → 0.3971. The exact form inverts
//! both relations, so that the clipped law gives the asked values.
//!
//! **Which mass.** m* is built from the masses that the contact really accelerates: grain plus
//! virtual mass when a fluid sends one. Then t_c stays t_c in the fluid; on the dry mass alone the
//! contact would be longer by √(1 + m_a/m_p). Walls, fixed, prescribed and fully locked grains count
//! as infinite masses.

use crate::error::SpecError;
use crate::tangential::Sliding;
use crate::wan_turek::WanTurek;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;

/// Law of contact between two surfaces.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "law", rename_all = "kebab-case")]
pub enum ContactLaw {
    /// Spring and dashpot along the normal, spring, dashpot and slider along the tangent
    /// (Cundall & Strack 1979; seed eqs 13–18).
    LinearSpringDashpot(LinearSpringDashpot),
    /// Short-range repulsion without friction (Wan & Turek 2007), as the second seed uses it.
    WanTurek(WanTurek),
}

/// Parameters of the linear spring–dashpot contact.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LinearSpringDashpot {
    /// Coefficient of normal restitution e_n, in (0, 1].
    pub restitution: f64,
    /// Contact time t_c, s.
    pub contact_time: f64,
    /// Coefficient of friction μ_c, ≥ 0.
    #[serde(default)]
    pub friction: f64,
    /// Which coefficients realise e_n and t_c.
    #[serde(default)]
    pub form: RestitutionForm,
    /// k_t/k_n; the seed takes 0.2.
    #[serde(default = "default_stiffness_ratio")]
    pub stiffness_ratio: f64,
    /// γ_t/γ_n; 0 is the seed, 1 keeps dense beds quiet in coupled runs.
    #[serde(default = "default_damping_ratio")]
    pub damping_ratio: f64,
    /// What happens to the tangential spring while the contact slides.
    #[serde(default)]
    pub sliding: Sliding,
    /// Where the tangential force attacks.
    #[serde(default)]
    pub lever_arm: LeverArm,
}

/// The seed's k_t/k_n (after eq. 18).
fn default_stiffness_ratio() -> f64 {
    0.2
}

/// A tangential dashpot as strong as the normal one: without it C_v = ½ feeds a jitter in dense beds.
fn default_damping_ratio() -> f64 {
    1.0
}

/// How e_n and t_c become k_n and γ_n.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum RestitutionForm {
    /// Eqs 17 and 18 as printed: the clipped law gives back more than e_n in less than t_c.
    #[default]
    Seed,
    /// k_n and γ_n chosen so that the clipped law gives e_n in t_c. Needs e_n > e⁻² ≈ 0.1353, the
    /// restitution of the critically damped clipped law.
    ExactRestitution,
}

/// Distance from a grain's centre at which the tangential force attacks.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum LeverArm {
    /// The middle of the overlap, R + δ/2: both arms add up to the distance of the centres, so
    /// angular momentum is kept to round-off and a rigid rotation gives no slip.
    #[default]
    ContactPoint,
    /// The radius, eq. 14 as printed: angular momentum drifts by δ × F_t.
    Radius,
}

/// What the clipped law really does.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Effective {
    /// Coefficient of restitution of an isolated collision.
    pub restitution: f64,
    /// Duration of an isolated collision, s.
    pub contact_time: f64,
}

/// Coefficients of one pair of materials per unit effective mass: multiply by m*.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LinearPair {
    /// k_n/m*, 1/s².
    pub stiffness: f64,
    /// γ_n/m*, 1/s.
    pub damping: f64,
    /// k_t/m*, 1/s².
    pub tangential_stiffness: f64,
    /// γ_t/m*, 1/s.
    pub tangential_damping: f64,
    /// μ_c.
    pub friction: f64,
    /// Whether the tangential spring is cut back while sliding.
    pub capped: bool,
    /// Whether the force attacks at the middle of the overlap (else at the radius).
    pub at_contact_point: bool,
}

/// Restitution and relative duration of the clipped law for r = b/ω of the damped oscillation.
fn clipped(r: f64) -> (f64, f64) {
    let rest = PI - 2.0 * r.atan();
    ((-r * rest).exp(), rest / PI)
}

/// Solves exp(−r(π − 2 atan r)) = e for r by bisection; the left side falls from 1 to e⁻².
fn clipped_inverse(e: f64) -> f64 {
    let (mut low, mut high) = (0.0, 1.0);
    while clipped(high).0 > e && high < 1e12 {
        high *= 2.0;
    }
    for _ in 0..200 {
        let middle = 0.5 * (low + high);
        if middle <= low || middle >= high {
            break;
        }
        if clipped(middle).0 > e {
            low = middle;
        } else {
            high = middle;
        }
    }
    0.5 * (low + high)
}

impl LinearSpringDashpot {
    /// Parameters with everything but e_n, t_c and μ_c at its default.
    #[must_use]
    pub fn new(restitution: f64, contact_time: f64, friction: f64) -> Self {
        Self {
            restitution,
            contact_time,
            friction,
            form: RestitutionForm::Seed,
            stiffness_ratio: default_stiffness_ratio(),
            damping_ratio: default_damping_ratio(),
            sliding: Sliding::Capped,
            lever_arm: LeverArm::ContactPoint,
        }
    }

    /// Angular frequency ω and decay rate b of the unclipped damped oscillation, 1/s.
    fn oscillation(&self) -> (f64, f64) {
        match self.form {
            RestitutionForm::Seed => (PI / self.contact_time, -self.restitution.ln() / self.contact_time),
            RestitutionForm::ExactRestitution => {
                let r = clipped_inverse(self.restitution);
                let omega = PI * clipped(r).1 / self.contact_time;
                (omega, r * omega)
            }
        }
    }

    /// Restitution and duration that an isolated collision really has.
    #[must_use]
    pub fn effective(&self) -> Effective {
        let (omega, decay) = self.oscillation();
        let (restitution, share) = clipped(decay / omega);
        Effective { restitution, contact_time: share * PI / omega }
    }

    /// Coefficients per unit effective mass (eqs 17, 18 with m* = 1, or the exact form).
    #[must_use]
    pub fn pair(&self) -> LinearPair {
        let (omega, decay) = self.oscillation();
        let stiffness = omega * omega + decay * decay;
        let damping = 2.0 * decay;
        LinearPair {
            stiffness,
            damping,
            tangential_stiffness: self.stiffness_ratio * stiffness,
            tangential_damping: self.damping_ratio * damping,
            friction: self.friction,
            capped: self.sliding == Sliding::Capped,
            at_contact_point: self.lever_arm == LeverArm::ContactPoint,
        }
    }

    /// Checks ranges.
    pub fn validate(&self) -> Result<(), SpecError> {
        let bad = |quantity, value, allowed| {
            Err(SpecError::Model { model: "linear-spring-dashpot", quantity, value, allowed })
        };
        let exact = self.form == RestitutionForm::ExactRestitution;
        if !(self.restitution > 0.0 && self.restitution <= 1.0) {
            return bad("restitution", self.restitution, "above 0 and at most 1");
        }
        if exact && self.restitution <= (-2.0f64).exp() * 1.001 {
            return bad(
                "restitution",
                self.restitution,
                "above 0.1355 in the exact-restitution form (critical damping); use form = \"seed\"",
            );
        }
        if !(self.contact_time > 0.0 && self.contact_time.is_finite()) {
            return bad("contact_time", self.contact_time, "positive and finite");
        }
        for (quantity, value) in [
            ("friction", self.friction),
            ("stiffness_ratio", self.stiffness_ratio),
            ("damping_ratio", self.damping_ratio),
        ] {
            if !(value >= 0.0 && value.is_finite()) {
                return bad(quantity, value, "zero or positive, and finite");
            }
        }
        Ok(())
    }
}

impl LinearPair {
    /// F_n of eq. 15, N: `mass` is m*, `gap` δ_n < 0, `rate` its time derivative.
    #[inline(always)]
    #[must_use]
    pub fn normal_force(&self, mass: f64, gap: f64, rate: f64) -> f64 {
        (-mass * (self.stiffness * gap + self.damping * rate)).max(0.0)
    }
}

impl ContactLaw {
    /// Checks ranges.
    pub fn validate(&self) -> Result<(), SpecError> {
        match self {
            Self::LinearSpringDashpot(law) => law.validate(),
            Self::WanTurek(law) => law.validate(),
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

    /// Contact time t_c that bounds the sub-step, s; none for a law without one.
    #[must_use]
    pub fn contact_time(&self) -> Option<f64> {
        match self {
            Self::LinearSpringDashpot(law) => Some(law.contact_time),
            Self::WanTurek(_) => None,
        }
    }

    /// The law as the loops use it.
    #[must_use]
    pub fn pair(&self) -> PairLaw {
        match self {
            Self::LinearSpringDashpot(law) => PairLaw::Linear(law.pair()),
            Self::WanTurek(law) => PairLaw::WanTurek(*law),
        }
    }
}

/// A law ready for the loops.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PairLaw {
    /// Linear spring and dashpot.
    Linear(LinearPair),
    /// Repulsion of Wan & Turek.
    WanTurek(WanTurek),
}

/// Laws of all pairs of materials: a square table, row by row.
#[derive(Clone, Debug, PartialEq)]
pub struct LawTable {
    count: usize,
    law: Vec<PairLaw>,
}

impl LawTable {
    /// Table with one law everywhere.
    #[must_use]
    pub fn new(count: usize, law: &ContactLaw) -> Self {
        Self { count, law: vec![law.pair(); count * count] }
    }

    /// Puts `law` between materials `a` and `b`.
    pub fn set(&mut self, a: usize, b: usize, law: &ContactLaw) {
        self.law[a * self.count + b] = law.pair();
        self.law[b * self.count + a] = law.pair();
    }

    /// Law between materials `a` and `b`.
    #[inline(always)]
    #[must_use]
    pub fn between(&self, a: usize, b: usize) -> &PairLaw {
        &self.law[a * self.count + b]
    }
}
