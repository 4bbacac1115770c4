//! Normal contact: linear spring and dashpot, clipped at zero (Cundall & Strack 1979;
//! Izard et al. 2014, eqs 15, 17, 18).
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
//! **t_c or k_n.** With `contact_time` all contacts last t_c and k_n grows with m*; with `stiffness`
//! k_n is the same everywhere and t_c follows, √(m* (π² + ln² e_n)/k_n) in the form `izard-2014`.
//!
//! **Which mass.** m* is built from the masses that the contact really accelerates: grain plus
//! virtual mass when a fluid sends one. Then t_c stays t_c in the fluid; on the dry mass alone the
//! contact would be longer by √(1 + m_a/m_p). Walls, fixed, prescribed and fully locked grains count
//! as infinite masses.

use crate::error::SpecError;
use crate::laws::coefficients::LinearPair;
use crate::laws::rolling::Rolling;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;

/// Parameters of the linear spring–dashpot contact.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LinearSpringDashpot {
    /// Coefficient of normal restitution e_n, in (0, 1].
    pub restitution: f64,
    /// Contact time t_c, s; or else `stiffness`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub contact_time: Option<f64>,
    /// Stiffness k_n of every contact, N/m, in place of t_c.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub stiffness: Option<f64>,
    /// Coefficient of friction μ_c, ≥ 0.
    #[serde(default)]
    pub friction: f64,
    /// Which coefficients realise e_n and t_c.
    #[serde(default)]
    pub form: RestitutionForm,
    /// k_t/k_n; Izard et al. (2014) take 0.2.
    #[serde(default = "default_stiffness_ratio")]
    pub stiffness_ratio: f64,
    /// γ_t/γ_n; 0 is Izard et al. (2014), 1 keeps dense beds quiet in coupled runs.
    #[serde(default = "default_damping_ratio")]
    pub damping_ratio: f64,
    /// Resistance to rolling; none by default.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rolling: Option<Rolling>,
}

/// k_t/k_n of Izard et al. (2014), after eq. 18.
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
    #[serde(rename = "izard-2014")]
    Izard2014,
    /// k_n and γ_n chosen so that the clipped law gives e_n in t_c. Needs e_n > e⁻² ≈ 0.1353, the
    /// restitution of the critically damped clipped law.
    #[default]
    ExactRestitution,
}

impl RestitutionForm {
    /// What is allowed, where this restitution is not.
    fn refuses(self, restitution: f64) -> Option<&'static str> {
        if !(restitution > 0.0 && restitution <= 1.0) {
            return Some("above 0 and at most 1");
        }
        (self == Self::ExactRestitution && restitution <= (-2.0f64).exp() * 1.001).then_some(
            "above 0.1355 in the exact-restitution form (critical damping); use form = \"izard-2014\"",
        )
    }
}

/// Restitution and relative duration of the clipped law for r = b/ω of the damped oscillation.
fn clipped(r: f64) -> (f64, f64) {
    let rest = PI - 2.0 * r.atan();
    ((-r * rest).exp(), rest / PI)
}

/// r with which the clipped law gives `e` back: solves exp(−r(π − 2 atan r)) = e by bisection; the left side
/// falls from 1 to e⁻².
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
            contact_time: Some(contact_time),
            stiffness: None,
            friction,
            form: RestitutionForm::default(),
            stiffness_ratio: default_stiffness_ratio(),
            damping_ratio: default_damping_ratio(),
            rolling: None,
        }
    }

    /// Angular frequency ω and decay rate b of the unclipped damped oscillation, 1/s; `t_c` in s.
    fn oscillation(&self, t_c: f64) -> (f64, f64) {
        match self.form {
            RestitutionForm::Izard2014 => (PI / t_c, -self.restitution.ln() / t_c),
            RestitutionForm::ExactRestitution => {
                let r = clipped_inverse(self.restitution);
                let omega = PI * clipped(r).1 / t_c;
                (omega, r * omega)
            }
        }
    }

    /// t_c of a contact of effective mass `mass`, s.
    #[must_use]
    pub fn contact_time_of(&self, mass: f64) -> f64 {
        let (omega, decay) = self.oscillation(1.0);
        let derived =
            self.stiffness.map(|stiffness| (mass * (omega * omega + decay * decay) / stiffness).sqrt());
        self.contact_time.or(derived).unwrap_or(f64::NAN)
    }

    /// γ_t/m* of a contact of effective mass `mass`, 1/s; zero without friction.
    #[must_use]
    pub fn tangential_rate(&self, mass: f64) -> f64 {
        let (_, decay) = self.oscillation(self.contact_time_of(mass));
        if self.friction > 0.0 { 2.0 * self.damping_ratio * decay } else { 0.0 }
    }

    /// Coefficients per unit effective mass (eqs 17, 18 with m* = 1, or the exact form) for the
    /// contact time, or for one second where the stiffness is given. Without friction nothing holds along the
    /// tangent, and no spring is kept there.
    #[must_use]
    pub fn pair(&self) -> LinearPair {
        let (omega, decay) = self.oscillation(self.contact_time.unwrap_or(1.0));
        let stiffness = omega * omega + decay * decay;
        let damping = 2.0 * decay;
        let held = if self.friction > 0.0 { 1.0 } else { 0.0 };
        LinearPair {
            stiffness,
            damping,
            tangential_stiffness: held * self.stiffness_ratio * stiffness,
            tangential_damping: held * self.damping_ratio * damping,
            friction: self.friction,
        }
    }

    /// Checks ranges.
    pub fn validate(&self) -> Result<(), SpecError> {
        let model = "linear-spring-dashpot";
        let bad = |quantity, value, allowed| Err(SpecError::Model { model, quantity, value, allowed });
        if let Some(allowed) = self.form.refuses(self.restitution) {
            return bad("restitution", self.restitution, allowed);
        }
        match (self.contact_time, self.stiffness) {
            (None, None) => {
                let (quantity, instead) = ("contact_time", "stiffness in N/m");
                return Err(SpecError::Missing { model, quantity, instead });
            }
            (Some(time), Some(_)) => {
                return bad("contact_time", time, "left out where stiffness is given: each sets the other");
            }
            (Some(value), None) => SpecError::unless_positive(model, &[("contact_time", value)])?,
            (None, Some(value)) => SpecError::unless_positive(model, &[("stiffness", value)])?,
        }
        self.rolling.as_ref().map_or(Ok(()), Rolling::validate)?;
        let (friction, ratios) = (self.friction, (self.stiffness_ratio, self.damping_ratio));
        let all = [("friction", friction), ("stiffness_ratio", ratios.0), ("damping_ratio", ratios.1)];
        SpecError::if_negative(model, &all)
    }
}
