//! Lubrication of one gap between two surfaces (Izard et al. 2014, eq. 19).
//!
//! Force against the approach, F = −κ(δ) δ̇ for 0 ≤ δ ≤ δ_c, nothing in overlap. With the roughness
//! η = (η/R) R and R_eff = R_i R_j/(R_i + R_j), R for a wall:
//!
//! - around a point (spheres, eq. 19): κ = 6πμ R_eff²/(δ + η);
//! - along a line (discs, per unit length): κ = 3√2 πμ (R_eff/(δ + η))^{3/2}; eq. 19 has the wrong
//!   exponent in the plane.
//!
//! `as-printed` applies κ up to the cut-off. `complement` applies what the flow was measured to leave
//! unresolved, with x = (δ + η)/L and L one cell:
//!
//!   κ(δ) = 6πμ R_eff²/(δ + η) · 1/(1 + 2x + 2x²),
//!   ∫κ dδ = 6πμ R_eff² [ln x − ½ ln(1 + 2x + 2x²) − arctan(1 + 2x)].
//!
//! and for discs, λL being a part of L that was measured,
//!
//!   κ(δ) = 3√2 πμ R_eff^{3/2} [(δ + η)^{−3/2} − (δ + η + λL)^{−3/2}], less its value at the cut-off.
//!
//! For spheres resolved and modelled force together are Brenner's (1961) within 1 % at every gap with the
//! default mask: `scenes/validation/wall-approach.toml`; for discs: `scenes/validation/disc-film.toml`.
//!
//! **Implicit sub-step.** Explicit integration would be stable only for dt < 2(η + δ)m/(6πμR²), and an
//! implicit velocity with a frozen gap tunnels through the gap. Instead the impulse of lubrication is taken
//! over the path of the step: with U the gap rate before lubrication acts, m the effective mass and
//! Φ′ = κ, the rate U′ after it solves
//!
//!   m(U′ − U) + Φ(δ + dt U′) − Φ(δ) = 0,
//!
//! for spheres U′ + (6πμR²/m) ln((δ + dt U′ + η)/(δ + η)) = U. Φ is constant in overlap and
//! beyond the cut-off, which stops it at δ = 0 and makes entering, leaving and rebounding exact
//! without further cases. The left side rises with U′, so there is one root.

use crate::grain::Shape;
use std::f64::consts::PI;

/// How much of the film of a line the flow resolves: as if its gap were longer by a part of L, as measured
/// with each way to impose the motion of discs (docs/decisions/line-film.md).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LineResolution {
    /// λ: that part in the approach.
    pub(super) normal: f64,
    /// That part for surfaces that slide: c and f of c/(1 + f x²), x = (δ + η)/L.
    pub(super) slip: [f64; 2],
    /// The same for surfaces that roll.
    pub(super) roll: [f64; 2],
}

impl LineResolution {
    /// With a mask of cells.
    pub const MASK: Self = Self { normal: 0.48, slip: [0.275, 4.2], roll: [0.31, 4.4] };

    /// With points of the bodies.
    pub const POINTS: Self = Self { normal: 0.47, slip: [0.145, 4.0], roll: [0.175, 1.0] };
}

/// The model with everything resolved that is common to all gaps of a run.
///
/// ```
/// use dem_kernels::{DemSpec, Lubrication, LubricationModel};
/// # use dem_kernels::{ContactLaw, LinearSpringDashpot, lubrication::settings::LubricationSettings};
/// # let law = ContactLaw::LinearSpringDashpot(LinearSpringDashpot::new(0.9, 1e-4, 0.0));
/// let mut spec = DemSpec::new(Vec::new(), law);
/// spec.lubrication = Lubrication::AsPrinted(LubricationSettings::new(1e-3));
/// spec.viscosity = 1e-3; // water, Pa s
/// let model: LubricationModel = spec.lubrication_model().ok_or("no lubrication")?;
/// // a sphere of 1 mm radius, 10 µm from a wall, comes nearer by 1 mm/s: F = 6πμR²/(δ + η) · 1 mm/s
/// let force = model.law(1e-3, f64::INFINITY).resistance(1e-5) * 1e-3;
/// let expected = 6.0 * std::f64::consts::PI * 1e-3 * 1e-6 / (1e-5 + 1e-6) * 1e-3;
/// assert!((force / expected - 1.0).abs() < 1e-12);
/// # Ok::<(), &str>(())
/// ```
#[derive(Clone, Copy, Debug)]
pub struct LubricationModel {
    /// Shape of the grains: spheres are near around a point, discs along a line.
    pub shape: Shape,
    /// η/R.
    pub roughness: f64,
    /// δ_c/R.
    pub cut_off: f64,
    /// Largest δ_c, m.
    pub longest: f64,
    /// L of `complement`, m; infinite otherwise.
    pub resolved_length: f64,
    /// What the flow resolves of the films of discs.
    pub line: LineResolution,
    /// Whether surfaces that slide or roll past each other have a film too.
    pub tangential: bool,
    /// Viscosity μ, Pa s.
    pub viscosity: f64,
}

impl LubricationModel {
    /// [`LubricationLaw::resolved_length`].
    pub(super) fn length(&self) -> f64 {
        match self.shape {
            Shape::Sphere => self.resolved_length,
            Shape::Disc => self.line.normal * self.resolved_length,
        }
    }

    /// δ_c between grains of mean radius `scale`, m.
    #[inline(always)]
    pub(crate) fn reach(&self, scale: f64) -> f64 {
        (self.cut_off * scale).min(self.longest)
    }

    /// Coefficients of the gap between radii `a` and `b` (infinite for a wall).
    #[inline(always)]
    #[must_use]
    pub fn law(&self, a: f64, b: f64) -> LubricationLaw {
        let (scale, reduced) = if b.is_infinite() { (a, a) } else { (0.5 * (a + b), a * b / (a + b)) };
        let roughness = self.roughness * scale;
        let cut_off = self.reach(scale);
        let coefficient = match self.shape {
            Shape::Sphere => 6.0 * PI * self.viscosity * reduced * reduced,
            Shape::Disc => 3.0 * std::f64::consts::SQRT_2 * PI * self.viscosity * reduced * reduced.sqrt(),
        };
        let (shape, resolved_length) = (self.shape, self.length());
        let mut law = LubricationLaw { shape, coefficient, roughness, cut_off, resolved_length, shift: 0.0 };
        // What the flow lacks at a line fades slowly: so that it ends at the cut-off.
        if shape == Shape::Disc && resolved_length.is_finite() {
            law.shift = law.resistance(cut_off);
        }
        law
    }
}

/// One gap for 0 ≤ δ ≤ δ_c: κ(δ) = c/(δ + η)/(1 + 2x + 2x²) − shift with x = (δ + η)/L, or
/// c/(δ + η)^{3/2} − c/(δ + η + λL)^{3/2} − shift.
#[derive(Clone, Copy, Debug)]
pub struct LubricationLaw {
    /// Shape of the grains: spheres are near around a point, discs along a line.
    pub shape: Shape,
    /// c, N s (point) or N s m^{1/2} per unit length (line).
    pub coefficient: f64,
    /// η, m.
    pub roughness: f64,
    /// δ_c, m.
    pub cut_off: f64,
    /// L (line: λL), m; infinite if the form is not `complement`.
    pub resolved_length: f64,
    /// κ(δ_c) if discs have what the flow does not resolve, else zero, N s/m.
    pub shift: f64,
}

impl LubricationLaw {
    /// κ at gap `gap` up to the cut-off, N s/m.
    #[inline(always)]
    #[must_use]
    pub fn resistance(&self, gap: f64) -> f64 {
        let a = gap + self.roughness;
        match self.shape {
            Shape::Sphere => {
                let x = a / self.resolved_length;
                self.coefficient / (a * (1.0 + 2.0 * x * (1.0 + x))) - self.shift
            }
            Shape::Disc => {
                let b = a + self.resolved_length;
                self.coefficient * (1.0 / (a * a.sqrt()) - 1.0 / (b * b.sqrt())) - self.shift
            }
        }
    }

    /// ∫κ dδ from the gap `a` − η to `a`(1 + `s`) − η, N s.
    #[inline(always)]
    fn path(&self, a: f64, s: f64) -> f64 {
        let spent = match self.shape {
            Shape::Sphere => self.coefficient * (s.ln_1p() - self.resolved(a, s)),
            Shape::Disc => {
                // 1 − (1+s)^{−1/2} without cancellation
                let of = |a: f64, s: f64| {
                    let root = (1.0 + s).sqrt();
                    2.0 * self.coefficient / a.sqrt() * (s / (root * (1.0 + root)))
                };
                let b = a + self.resolved_length;
                of(a, s) - of(b, s * (a / b))
            }
        };
        spent - self.shift * a * s
    }

    /// ∫ (2x + 2)/(1 + 2x + 2x²) dx over the same path, without cancellation: what the flow resolves.
    #[inline(always)]
    fn resolved(&self, a: f64, s: f64) -> f64 {
        if self.resolved_length.is_infinite() {
            return 0.0;
        }
        let x = a / self.resolved_length;
        let (step, y) = (x * s, x + x * s);
        let quotient = 2.0 * step * (1.0 + x + y) / (1.0 + 2.0 * x * (1.0 + x));
        let angle = 2.0 * step / (1.0 + (1.0 + 2.0 * x) * (1.0 + 2.0 * y));
        0.5 * quotient.ln_1p() + angle.atan()
    }

    /// Impulse of lubrication over `dt`, N s, positive apart.
    ///
    /// `gap` at the start, `rate` the gap rate before it acts, `inverse_mass` 1/m of the pair:
    /// the rate after it is `rate + inverse_mass * impulse`.
    #[inline]
    #[must_use]
    pub fn impulse(&self, gap: f64, rate: f64, dt: f64, inverse_mass: f64) -> f64 {
        let free = gap + dt * rate;
        if (gap <= 0.0 && free <= 0.0) || (gap >= self.cut_off && free >= self.cut_off) {
            return 0.0;
        }
        // Φ is flat outside [0, δ_c]: start where the path enters, with what is left of the step.
        let start = gap.clamp(0.0, self.cut_off);
        let a = start + self.roughness;
        let rate = rate + (gap - start) / dt;
        let inertia = a / dt;
        let balance = |s: f64| inertia * s - rate + inverse_mass * self.path(a, s);
        let low = -start / a;
        let high = (self.cut_off - start) / a;
        // lubrication only brakes: the path ends inside unless the free path leaves it
        if free <= 0.0 && balance(low) >= 0.0 {
            return -self.path(a, low);
        }
        if free >= self.cut_off && balance(high) <= 0.0 {
            return -self.path(a, high);
        }
        let (low, high) = if rate < 0.0 { (low, 0.0) } else { (0.0, high) };
        // at the root the impulse is m (U' - U), with no further logarithm
        (inertia * self.root(a, rate, inertia, inverse_mass, low, high) - rate) / inverse_mass
    }

    /// Root of inertia·s − rate + path(s)/m in [low, high]: Newton in s where inertia dominates and in
    /// ln(1 + s) where lubrication does (nearly linear either way), bisection if a step leaves the bracket.
    #[inline]
    fn root(&self, a: f64, rate: f64, inertia: f64, inverse_mass: f64, mut low: f64, mut high: f64) -> f64 {
        let slope = |s: f64| inverse_mass * a * self.resistance(a * (1.0 + s) - self.roughness);
        let mut s = 0.0;
        for _ in 0..60 {
            let value = inertia * s - rate + inverse_mass * self.path(a, s);
            if value > 0.0 {
                high = s;
            } else {
                low = s;
            }
            let lubrication = slope(s);
            let mut next = if lubrication > inertia {
                let step = value / ((lubrication + inertia) * (1.0 + s));
                s + (1.0 + s) * (-step).exp_m1()
            } else {
                s - value / (lubrication + inertia)
            };
            if !(next >= low && next <= high) {
                next = 0.5 * (low + high);
            }
            let change = (next - s).abs();
            s = next;
            // quadratic convergence: the error left is the square of this change
            if change <= 1e-8 * s.abs() {
                break;
            }
        }
        s
    }
}
