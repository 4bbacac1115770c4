//! The film between spheres that slide or roll past each other: what the flow does not resolve of it.
//!
//! Leading terms of lubrication theory, of order ln(R/δ) (Goldman, Cox & Brenner 1967 for a wall; Jeffrey & Onishi 1984 for
//! two spheres). With n from sphere j (radius b) to i (radius a), β = b/a, w = ω × n, V the tangential velocity of i against
//! j, u = V − a w_i − b w_j the slip of the two surfaces and p = w_i − w_j, both zero where the pair turns as one, half the
//! dissipation is ½ πμaℓ (A u² + 2 B u·p + C p²),
//!
//! ```text
//! A = 8β(2 + β + 2β²)/(5(1 + β)³),   B/a = A − 4β(4 + β)/(5(1 + β)²),   C/a² = 16β/(5(1 + β)) − A + 2B/a
//! ```
//!
//! equal spheres: 1, 0, 3/5; a wall: 16/5, 12/5, 24/5. Force and torques follow as its derivatives. It is a sum of two
//! squares, (u + (B/A) p)² with A and p² with C − B²/A, each of which brakes one velocity.
//!
//! Of ℓ = ln(R/δ) the flow resolves all but
//!
//! ```text
//! ℓ = ½ ln(1 + (L_t/(δ + η))²),   L_t = ¼ L at a wall and ⅜ L between two spheres, L one cell
//! ```
//!
//! as was measured with the default mask (docs/decisions/tangential-film.md).
//!
//! **Sub-step.** Gaps are visited once, in the order of the list, with the resistance at the gap in which the sub-step
//! began: J = −K dt s/(1 + K dt W) for the velocity s that is braked and its inverse mass W. No visit turns s round, so the
//! energy falls whatever K dt W is; opposite impulses at the middle of the gap keep momentum and angular momentum.

use crate::grains::{Grains, Response};
use crate::lubrication::law::LubricationModel;
use crate::motion::Vec3;
use crate::surroundings::Surroundings;
use std::f64::consts::PI;

/// L_t over the length L that the normal film has, at a wall …
const TO_WALL: f64 = 0.25;
/// … and between two spheres, both of which have a mask.
const TO_SPHERE: f64 = 0.375;

/// Gap over L_t beyond which nothing is left of it: ℓ = 0.03.
const REACH: f64 = 4.0;

/// The film between two radii.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Film {
    /// πμaA, N s/m.
    slip: f64,
    /// B/A, m.
    shift: f64,
    /// πμa(C − B²/A), N m s.
    roll: f64,
}

impl Film {
    /// Of a sphere of radius `a` and one of radius `b`, infinite for a wall.
    fn new(viscosity: f64, a: f64, b: f64) -> Self {
        // In powers of s = 1/β, which is zero at a wall.
        let s = a / b;
        let sum = 1.0 + s;
        let slip = 1.6 * (2.0 * s * s + s + 2.0) / sum.powi(3);
        let cross = slip - 0.8 * (4.0 * s + 1.0) / (sum * sum);
        let turn = 3.2 / sum - slip + 2.0 * cross;
        let scale = PI * viscosity * a;
        Self {
            slip: scale * slip,
            shift: a * cross / slip,
            roll: scale * a * a * (turn - cross * cross / slip),
        }
    }
}

/// Part of the logarithm that the flow does not resolve at a gap, `length` being L_t; none in overlap.
fn unresolved(gap: f64, roughness: f64, length: f64) -> f64 {
    if !(0.0..=REACH * length).contains(&gap) {
        return 0.0;
    }
    let ratio = length / (gap + roughness);
    0.5 * (ratio * ratio).ln_1p()
}

/// A gap in which something can slide: the partners and what is between them.
#[derive(Clone, Copy, Debug)]
pub(super) struct SlidingGap {
    pub(super) first: u32,
    /// Second grain, or the wall's index if `wall`.
    pub(super) second: u32,
    pub(super) wall: bool,
    /// From the second to the first.
    pub(super) normal: Vec3,
    /// Its width, m.
    pub(super) gap: f64,
}

/// Gap beyond which nothing is left to this film.
pub(super) fn reach(model: &LubricationModel) -> f64 {
    if model.tangential { REACH * TO_SPHERE * model.resolved_length } else { f64::NEG_INFINITY }
}

/// Brakes the tangential motion in the gaps over `dt`, in place, and adds the mean force on each grain to `force`.
pub(super) fn brake(
    gaps: &[SlidingGap],
    around: &Surroundings,
    model: &LubricationModel,
    grains: &mut Grains,
    response: &Response,
    dt: f64,
    force: &mut [Vec3],
) {
    for gap in gaps {
        let (i, j) = (gap.first as usize, gap.second as usize);
        let (a, b) = (grains.radius[i], if gap.wall { f64::INFINITY } else { grains.radius[j] });
        let part = if gap.wall { TO_WALL } else { TO_SPHERE };
        let left = unresolved(gap.gap, model.law(a, b).roughness, part * model.resolved_length);
        if left > 0.0 {
            let film = Film::new(left * model.viscosity, a, b);
            let push = if gap.wall {
                gap.brake_at_wall(&film, &around.walls[j].velocity, grains, response, dt)
            } else {
                gap.brake_between(&film, grains, response, dt)
            };
            force[i] += push;
            if !gap.wall {
                force[j] -= push;
            }
        }
    }
}

impl SlidingGap {
    /// Both squares of a film between spheres, one after the other; the mean force on the first.
    fn brake_between(&self, film: &Film, grains: &mut Grains, response: &Response, dt: f64) -> Vec3 {
        let (i, j, normal) = (self.first as usize, self.second as usize, &self.normal);
        // Arms to the middle of the gap: with them the angular momentum is kept.
        let half = 0.5 * self.gap;
        let arms = [grains.radius[i] + half - film.shift, grains.radius[j] + half + film.shift];
        let (spin_i, spin_j) = (response.inverse_inertia[i].max(), response.inverse_inertia[j].max());
        let apart = grains.velocity[i] - grains.velocity[j];
        let turn = grains.spin[i] * arms[0] + grains.spin[j] * arms[1];
        let slip = apart - normal * apart.dot(normal) - turn.cross(normal);
        // The largest over directions: with locked ones it brakes a little less.
        let inverse = response.inverse_mass[i].max()
            + response.inverse_mass[j].max()
            + arms[0] * arms[0] * spin_i
            + arms[1] * arms[1] * spin_j;
        let impulse = slip * braking(film.slip * dt, inverse);
        let moment = normal.cross(&impulse);
        grains.velocity[i] += response.inverse_mass[i].component_mul(&impulse);
        grains.velocity[j] -= response.inverse_mass[j].component_mul(&impulse);
        grains.spin[i] -= response.inverse_inertia[i].component_mul(&moment) * arms[0];
        grains.spin[j] -= response.inverse_inertia[j].component_mul(&moment) * arms[1];
        // What rolls: the spins against each other, across the normal.
        let turn = grains.spin[i] - grains.spin[j];
        let torque = (turn - normal * turn.dot(normal)) * braking(film.roll * dt, spin_i + spin_j);
        grains.spin[i] += response.inverse_inertia[i].component_mul(&torque);
        grains.spin[j] -= response.inverse_inertia[j].component_mul(&torque);
        impulse * (1.0 / dt)
    }

    /// The same at a wall that moves with `velocity`.
    fn brake_at_wall(
        &self,
        film: &Film,
        velocity: &Vec3,
        grains: &mut Grains,
        response: &Response,
        dt: f64,
    ) -> Vec3 {
        let (i, normal) = (self.first as usize, &self.normal);
        let arm = grains.radius[i] - film.shift;
        let inverse_spin = response.inverse_inertia[i].max();
        let apart = grains.velocity[i] - velocity;
        let slip = apart - normal * apart.dot(normal) - grains.spin[i].cross(normal) * arm;
        let inverse = response.inverse_mass[i].max() + arm * arm * inverse_spin;
        let impulse = slip * braking(film.slip * dt, inverse);
        grains.velocity[i] += response.inverse_mass[i].component_mul(&impulse);
        let moment = normal.cross(&impulse) * arm;
        grains.spin[i] -= response.inverse_inertia[i].component_mul(&moment);
        let turn = grains.spin[i] - normal * grains.spin[i].dot(normal);
        let torque = turn * braking(film.roll * dt, inverse_spin);
        grains.spin[i] += response.inverse_inertia[i].component_mul(&torque);
        impulse * (1.0 / dt)
    }
}

/// Impulse over velocity where a resistance brakes for `strength`/resistance seconds: −K dt/(1 + K dt W).
fn braking(strength: f64, inverse: f64) -> f64 {
    -strength / (1.0 + strength * inverse)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Forces and torques of the film are the published ones: of a wall (Goldman, Cox & Brenner 1967) and of equal spheres
    /// (Jeffrey & Onishi 1984), factors of πμa ln(R/δ), radii 1.
    #[test]
    fn the_leading_terms_are_the_published_ones() {
        // (A, B, C) from the two squares.
        let of = |s: f64| {
            let film = Film::new(1.0 / PI, 1.0, 1.0 / s);
            let (a, b) = (film.slip, film.shift * film.slip);
            [a, b, film.roll + b * b / a]
        };
        let near = |ours: f64, theirs: f64| assert!((ours - theirs).abs() < 1e-14, "{ours}, {theirs}");
        let [a, b, c] = of(0.0);
        near(a, 6.0 * 8.0 / 15.0);
        // Force of a sphere that turns, torque of one that turns: 6 · 2/15 and 8 · 2/5.
        near(a - b, 6.0 * 2.0 / 15.0);
        near(a - 2.0 * b + c, 8.0 * 2.0 / 5.0);
        let [a, b, c] = of(1.0);
        near(a, 1.0);
        near(a - b, 1.0);
        near(a - 2.0 * b + c, 8.0 / 5.0);
        // Torque on one from the spin of the other, 8 · 1/20.
        near(a + b - b - c, 2.0 / 5.0);
    }

    /// Seen from the other sphere the film is the same.
    #[test]
    fn a_film_has_no_first_and_second() {
        let (a, b) = (0.3, 1.1);
        let (one, two) = (Film::new(1.0, a, b), Film::new(1.0, b, a));
        // u is the same vector turned round, p too: A and C agree, B changes sign.
        assert!((one.slip / two.slip - 1.0).abs() < 1e-14);
        assert!((one.shift + two.shift).abs() < 1e-14);
        assert!((one.roll / two.roll - 1.0).abs() < 1e-13);
    }

    #[test]
    fn what_is_left_grows_as_the_logarithm() {
        let left = |gap: f64| unresolved(gap, 1e-6, 0.05);
        assert_eq!(left(-1e-9), 0.0);
        assert_eq!(left(0.2001), 0.0);
        assert!((left(1e-4) - left(1e-3) - 10.0_f64.ln()).abs() < 0.02);
        assert!(left(0.19) < 0.04);
    }
}
