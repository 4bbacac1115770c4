//! Hertz–Mindlin contact of two spheres of one elastic material.
//!
//! With δ > 0 the overlap, R* = R_i R_j/(R_i + R_j), E* = E/(2(1 − ν²)), G* = G/(2(2 − ν)),
//! G = E/(2(1 + ν)), and k = 4/3 E* √R*:
//!
//! F_n = max(0, k δ^{3/2} + α √(m* k) δ^{1/4} δ̇)  (Hertz 1882; damping of Tsuji, Tanaka & Ishida 1992),
//! F_t = −min(|8 G* √(R* δ) δ_t + γ_t v_t|, μ F_n) along the slip  (Mindlin 1949, no slip in the contact).
//!
//! **Restitution.** With q = 4/5 δ^{5/4} and v = δ̇ the normal motion is v dv/dq + α√(k/m*) v +
//! 5/4 (k/m*) q = 0: a damped linear oscillator, whose restitution does not depend on the speed
//! (Antypov & Elliott 2011): α = √5 β, β = −ln e/√(ln² e + π²). The clip at F_n = 0 acts in it as in
//! the linear law, so both forms of [`RestitutionForm`] carry over with r = b/ω: `seed` takes
//! r = −ln e/π, `exact-restitution` the r whose clipped law gives back e.
//!
//! **Spring while the contact grows.** The area that comes into contact is born without shear: the
//! force stays while δ_t grows no further, so δ_t shrinks by √(δ_old/δ_new) in loading (Thornton,
//! Cummins & Cleary 2013). Without it a cycle of loading at one shear and unloading at another
//! creates energy (Elata & Berryman 1996). While the contact shrinks δ_t is kept: the force goes down
//! with the area.
//!
//! **Contact time.** A collision at speed v lasts 2.9433 δ_max/v, δ_max = (5 m* v²/(4 k))^{2/5}: longer
//! the slower it is. The scene names the largest speed to resolve, `impact_speed`.

use crate::error::SpecError;
use crate::laws::coefficients::LinearPair;
use crate::laws::linear::{LeverArm, RestitutionForm, default_damping_ratio};
use crate::laws::rolling::Rolling;
use crate::laws::tangential::Sliding;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// ∫₀¹ 2 dx/√(1 − x^{5/2}) = (4√π/5) Γ(2/5)/Γ(9/10): duration of a collision over δ_max/v.
pub const DURATION: f64 = 2.943_275_184_324_705;

/// Parameters of the Hertz–Mindlin contact.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct HertzMindlin {
    /// Young's modulus E of grains and walls, Pa.
    pub young_modulus: f64,
    /// Poisson's ratio ν, −1 < ν ≤ 0.5.
    pub poisson_ratio: f64,
    /// Coefficient of normal restitution e_n, in (0, 1], at any speed.
    pub restitution: f64,
    /// Largest normal speed of a collision, m/s: it sets the contact time, and so the sub-step.
    pub impact_speed: f64,
    /// Coefficient of friction μ_c, ≥ 0.
    #[serde(default)]
    pub friction: f64,
    /// Which damping realises e_n.
    #[serde(default)]
    pub form: RestitutionForm,
    /// γ_t/γ_n.
    #[serde(default = "default_damping_ratio")]
    pub damping_ratio: f64,
    /// What happens to the tangential spring while the contact slides.
    #[serde(default)]
    pub sliding: Sliding,
    /// Where the tangential force attacks.
    #[serde(default)]
    pub lever_arm: LeverArm,
    /// Resistance to rolling; none by default.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rolling: Option<Rolling>,
}

/// The law as the loops use it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HertzPair {
    /// 4/3 E*, Pa.
    normal: f64,
    /// 8 G*, Pa.
    tangential: f64,
    /// α.
    damping: f64,
    /// γ_t/γ_n.
    damping_ratio: f64,
    friction: f64,
    capped: bool,
    at_contact_point: bool,
}

impl HertzMindlin {
    /// E*, Pa.
    fn effective_modulus(&self) -> f64 {
        self.young_modulus / (2.0 * (1.0 - self.poisson_ratio * self.poisson_ratio))
    }

    /// Duration of an undamped collision at `impact_speed`, s, of effective mass, kg, and radius, m.
    ///
    /// ```
    /// # use dem_solver::HertzMindlin;
    /// let text = "young_modulus = 7e10\npoisson_ratio = 0.22\nrestitution = 0.9\nimpact_speed = 1.0";
    /// let glass: HertzMindlin = toml::from_str(text)?;
    /// let slower = HertzMindlin { impact_speed: 0.1, ..glass };
    /// let (mass, radius) = (5e-6, 5e-4); // two grains of 10 mg and 1 mm
    /// let ratio = slower.contact_time_of(mass, radius) / glass.contact_time_of(mass, radius);
    /// assert!((ratio - 10.0_f64.powf(0.2)).abs() < 1e-12); // a contact lasts longer, as v^(−1/5)
    /// # Ok::<(), toml::de::Error>(())
    /// ```
    #[must_use]
    pub fn contact_time_of(&self, mass: f64, radius: f64) -> f64 {
        let k = 4.0 / 3.0 * self.effective_modulus() * radius.sqrt();
        let v = self.impact_speed;
        DURATION * (1.25 * mass * v * v / k).powf(0.4) / v
    }

    /// The law as the loops use it.
    #[must_use]
    pub fn pair(&self) -> HertzPair {
        let r = self.form.decay(self.restitution);
        let nu = self.poisson_ratio;
        let shear = self.young_modulus / (2.0 * (1.0 + nu)) / (2.0 * (2.0 - nu));
        HertzPair {
            normal: 4.0 / 3.0 * self.effective_modulus(),
            tangential: 8.0 * shear,
            damping: 5.0_f64.sqrt() * r / (1.0 + r * r).sqrt(),
            damping_ratio: self.damping_ratio,
            friction: self.friction,
            capped: self.sliding == Sliding::Capped,
            at_contact_point: self.lever_arm == LeverArm::ContactPoint,
        }
    }

    /// Checks ranges.
    pub fn validate(&self) -> Result<(), SpecError> {
        let model = "hertz-mindlin";
        let bad = |quantity, value, allowed| Err(SpecError::Model { model, quantity, value, allowed });
        let sizes = [("young_modulus", self.young_modulus), ("impact_speed", self.impact_speed)];
        SpecError::unless_positive(model, &sizes)?;
        if !(self.poisson_ratio > -1.0 && self.poisson_ratio <= 0.5) {
            return bad("poisson_ratio", self.poisson_ratio, "above -1 and at most 0.5");
        }
        if let Some(allowed) = self.form.refuses(self.restitution) {
            return bad("restitution", self.restitution, allowed);
        }
        let ratios = [("friction", self.friction), ("damping_ratio", self.damping_ratio)];
        SpecError::if_negative(model, &ratios)?;
        self.rolling.as_ref().map_or(Ok(()), Rolling::validate)
    }
}

impl HertzPair {
    /// Secant coefficients per unit effective mass at this overlap: with them the linear formulas give
    /// the forces above. `mass` m*, `radius` R*, `gap` < 0.
    #[inline(always)]
    #[must_use]
    pub fn at(&self, mass: f64, radius: f64, gap: f64) -> LinearPair {
        let contact_radius = (radius * -gap.min(0.0)).sqrt();
        let stiffness = self.normal * contact_radius / mass;
        // α √(m* k) δ^{1/4}/m* with k √δ = stiffness m*
        let damping = self.damping * stiffness.sqrt();
        LinearPair {
            stiffness,
            damping,
            tangential_stiffness: self.tangential * contact_radius / mass,
            tangential_damping: self.damping_ratio * damping,
            friction: self.friction,
            capped: self.capped,
            at_contact_point: self.at_contact_point,
        }
    }

    /// Factor on the spring of a contact whose gap has changed by `change` to `gap`: √(δ_old/δ_new) in
    /// loading, 1 in unloading.
    #[inline(always)]
    #[must_use]
    pub fn growth(gap: f64, change: f64) -> f64 {
        if change >= 0.0 || gap >= 0.0 { 1.0 } else { ((gap - change) / gap).max(0.0).sqrt() }
    }

    /// Energy of the normal spring, 2/5 k δ^{5/2}, J.
    #[must_use]
    pub fn normal_energy(&self, radius: f64, gap: f64) -> f64 {
        0.4 * self.normal * radius.sqrt() * (-gap).max(0.0).powf(2.5)
    }
}
