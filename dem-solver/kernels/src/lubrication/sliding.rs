//! The film between grains that slide or roll past each other: what the flow does not resolve of it.
//!
//! **Spheres.** Leading terms of lubrication theory, of order ln(R/δ) (Goldman, Cox & Brenner 1967 for a
//! wall; Jeffrey & Onishi 1984 for two spheres). With n from sphere j (radius b) to i (radius a), β = b/a,
//! w = ω × n, V the tangential velocity of i against j, u = V − a w_i − b w_j the slip of the two surfaces
//! and p = w_i − w_j, both zero where the pair turns as one, half the dissipation is ½ πμaℓ (A u² + 2 B u·p +
//! C p²),
//!
//! ```text
//! A = 8β(2 + β + 2β²)/(5(1 + β)³),   B/a = A − 4β(4 + β)/(5(1 + β)²),   C/a² = 16β/(5(1 + β)) − A + 2B/a
//! ```
//!
//! equal spheres: 1, 0, 3/5; a wall: 16/5, 12/5, 24/5. Force and torques follow as its derivatives. It is a
//! sum of two squares, (u + (B/A) p)² with A and p² with C − B²/A, each of which brakes one velocity.
//!
//! Of ℓ = ln(R/δ) the flow resolves all but
//!
//! ```text
//! ℓ = ½ ln(1 + (L_t/(δ + η))²),   L_t = ¼ L at a wall and ⅜ L between two spheres, L one cell
//! ```
//!
//! as was measured with the default mask (docs/decisions/tangential-film.md).
//!
//! **Discs.** Between two cylinders each surface is braked by its own speed in the frame of the line of
//! centres: half the dissipation is ½ k (u_i² + u_j²)/(δ + η)^½ with k = 2√2 πμ R*^½, R* = ab/(a + b)
//! (Reynolds' equation; a cylinder beside a wall: Jeffrey & Onishi 1981), which in the two squares above is
//!
//! ```text
//! A = k(a² + b²)/(a + b)²,   B/A = ab(b − a)/(a² + b²),   C − B²/A = k a²b²/(a² + b²)
//! ```
//!
//! at a wall: k, a, k a². Of 1/(δ + η)^½ the flow resolves all but 1/(δ + η)^½ − 1/(δ + η + λ_t L)^½, λ_t =
//! c/(1 + f x²), x = (δ + η)/L, with c and f of either square (docs/decisions/line-film.md). It acts on
//! touching discs, too, with δ = 0: a cylinder rolls on the fluid between the asperities, and without it the
//! speed would be the grid's.
//!
//! **Sub-step.** Gaps are visited once, pack by pack, with the resistance at the gap in which the sub-step
//! began: J = −K dt s/(1 + K dt W) for the velocity s that is braked and its inverse mass W. No visit turns s
//! round, so the energy falls whatever K dt W is; opposite impulses at the middle of the gap keep momentum
//! and angular momentum.

use crate::grain::Shape;
use crate::lubrication::law::LubricationModel;
use crate::vector::lanes::Lanes8;
use crate::vector::logarithm::ln;
use std::f64::consts::PI;

/// L_t over the length L that the normal film has, at a wall …
const TO_WALL: f64 = 0.25;
/// … and between two spheres, both of which have a mask.
const TO_SPHERE: f64 = 0.375;

/// Gap over L_t beyond which nothing is left of it: ℓ = 0.03.
const REACH: f64 = 4.0;

/// The film between two radii.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Film {
    /// Factor of u², N s/m (discs: N s/m^{1/2}).
    slip: f64,
    /// B/A, m.
    shift: f64,
    /// Factor of p², N m s.
    roll: f64,
}

impl Film {
    /// Of a grain of radius `a` and one of radius `b`, infinite for a wall.
    pub(super) fn new(shape: Shape, viscosity: f64, a: f64, b: f64) -> Self {
        match shape {
            Shape::Sphere => Self::of_spheres(viscosity, a, b),
            Shape::Disc => Self::of_discs(viscosity, a, b),
        }
    }

    fn of_discs(viscosity: f64, a: f64, b: f64) -> Self {
        let s = a / b;
        let (sum, squares) = (1.0 + s, 1.0 + s * s);
        let scale = 2.0 * std::f64::consts::SQRT_2 * PI * viscosity * (a / sum).sqrt();
        Self {
            slip: scale * squares / (sum * sum),
            shift: a * (1.0 - s) / squares,
            roll: scale * a * a / squares,
        }
    }

    fn of_spheres(viscosity: f64, a: f64, b: f64) -> Self {
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

    /// As a row with `length`, L_t.
    pub(super) fn row(&self, length: f64) -> [f64; 4] {
        [self.slip, self.shift, self.roll, length]
    }
}

/// What the flow does not resolve at gaps, of films that slide and of those that roll: part of the logarithm
/// with `length` L_t, none in overlap; for discs part of (δ + η)^{−1/2}. None where there is none of all.
#[inline(always)]
pub(super) fn unresolved<L: Lanes8>(
    token: L::Token,
    model: &LubricationModel,
    [gap, roughness, length]: [L; 3],
) -> Option<[L; 2]> {
    let k = |value: f64| L::splat(token, value);
    let (zero, one) = (k(0.0), k(1.0));
    let a = gap.max(zero) + roughness;
    match model.shape {
        Shape::Sphere => {
            let beyond: u8 = gap.lt(zero) | (k(REACH) * length).lt(gap);
            if beyond == u8::MAX {
                return None;
            }
            let ratio = length / a;
            let left = zero.select(beyond, k(0.5) * ln(token, ratio.times_plus(ratio, one)));
            Some([left; 2])
        }
        Shape::Disc => {
            let cells = a / length;
            let mut left = [one / a.sqrt(); 2];
            for (left, [part, fade]) in left.iter_mut().zip([model.line.slip, model.line.roll]) {
                let longer = k(part) * length / (k(fade) * cells).times_plus(cells, one);
                *left = *left - one / (a + longer).sqrt();
            }
            Some(left)
        }
    }
}

/// L_t of `model`, m; L itself for discs.
pub(super) fn reach_at(model: &LubricationModel, at_wall: bool) -> f64 {
    let part = match model.shape {
        Shape::Sphere if at_wall => TO_WALL,
        Shape::Sphere => TO_SPHERE,
        Shape::Disc => 1.0,
    };
    part * model.resolved_length
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lubrication::law::LineResolution;
    use crate::vector::lanes::{Lanes, Portable8};

    /// Forces and torques of the film are the published ones: of a wall (Goldman, Cox & Brenner 1967) and of
    /// equal spheres (Jeffrey & Onishi 1984), factors of πμa ln(R/δ), radii 1.
    #[test]
    fn the_leading_terms_are_the_published_ones() {
        // (A, B, C) from the two squares.
        let of = |s: f64| {
            let film = Film::of_spheres(1.0 / PI, 1.0, 1.0 / s);
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
        for shape in [Shape::Sphere, Shape::Disc] {
            let (one, two) = (Film::new(shape, 1.0, a, b), Film::new(shape, 1.0, b, a));
            // u is the same vector turned round, p too: A and C agree, B changes sign.
            assert!((one.slip / two.slip - 1.0).abs() < 1e-14);
            assert!((one.shift + two.shift).abs() < 1e-14);
            assert!((one.roll / two.roll - 1.0).abs() < 1e-13);
        }
    }

    /// Of a cylinder beside a wall: force 2√2 πμ U (R/δ)^½ and no torque, torque 2√2 πμ Ω R² (R/δ)^½ and no
    /// force (Jeffrey & Onishi 1981). Two equal ones that turn the same way are braked by twice that of one
    /// for half the reduced radius.
    #[test]
    fn the_film_of_a_cylinder_is_the_published_one() {
        let unit = 2.0 * std::f64::consts::SQRT_2 * PI;
        let near = |ours: f64, theirs: f64| assert!((ours - theirs).abs() < 1e-13, "{ours}, {theirs}");
        let wall = Film::of_discs(1.0, 2.0, f64::INFINITY);
        near(wall.slip, unit * 2f64.sqrt());
        // The lever arm of the slip is nothing: the force on one that turns, the torque on one that moves.
        near(2.0 - wall.shift, 0.0);
        near(wall.roll, unit * 2f64.sqrt() * 4.0);
        let pair = Film::of_discs(1.0, 1.0, 1.0);
        // Both turn with 1: u = −2, p = 0; ½ A u² = 2 · ½ k.
        near(2.0 * pair.slip, unit * 0.5f64.sqrt());
        // One turns with 1, the other against it: u = 0, p = 2; the same dissipation.
        near(2.0 * pair.roll, unit * 0.5f64.sqrt());
    }

    #[test]
    fn what_is_left_grows_as_the_logarithm() {
        let model = LubricationModel {
            shape: Shape::Sphere,
            roughness: 0.0,
            cut_off: 1.0,
            longest: f64::INFINITY,
            resolved_length: 0.2,
            line: LineResolution::MASK,
            tangential: true,
            viscosity: 1.0,
        };
        let left = |gap: f64| {
            let of = [gap, 1e-6, 0.05].map(|value| Portable8::splat((), value));
            let mut left = [0.0; 8];
            unresolved((), &model, of).map_or(0.0, |[slip, _]| {
                slip.store(&mut left);
                left[0]
            })
        };
        assert_eq!(left(-1e-9), 0.0);
        assert_eq!(left(0.2001), 0.0);
        assert!((left(1e-4) - left(1e-3) - 10.0_f64.ln()).abs() < 0.02);
        assert!(left(0.19) < 0.04);
    }
}
