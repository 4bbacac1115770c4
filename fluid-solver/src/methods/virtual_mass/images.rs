//! Added mass of two spheres, or of two discs, that move along the line of their centres in an ideal fluid.
//!
//! A sphere that moves alone is a dipole at its centre. Its image in another sphere of radius b, at the
//! distance d from that centre, is again a dipole, b²/d from it and (b/d)³ times as strong; (b/d)² for discs.
//! The images of images fill both bodies (Hicks 1880; Lamb, Hydrodynamics, 1932, § 137 to 139). With S_a and
//! S_b the sums of their strengths in the moving body and in the other one, the kinetic energy of the fluid
//! is ½ L U_a² − M U_a U_b + …, L = m_f (C + (1 + C) S_a), M = m_f (1 + C) S_b, C = ½ (spheres) or 1 (discs),
//! m_f the mass of fluid that the moving body displaces, speeds counted along one direction.

use std::f64::consts::PI;

/// Images weaker than this, in parts of the first dipole, are left out.
const WEAK: f64 = 1e-4;

/// More are never summed, for discs and for spheres; what follows is estimated, to 0.01 and 5e-4 of C.
const IMAGES: [usize; 2] = [24, 8];

/// Coefficients of one body beside another, in parts of the mass of fluid that it displaces.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Coefficients {
    /// Own added mass L: that of a body that moves while the other one is held.
    pub own: f64,
    /// Mutual added mass M: what the motion of the other one, the same way, takes off.
    pub mutual: f64,
}

/// C of a body alone: ½ for a sphere (`dimensions` 3), 1 for a disc (2).
pub fn alone(dimensions: i32) -> f64 {
    1.0 / f64::from(dimensions - 1)
}

/// Coefficients of a body of radius `a` whose surface is `gap` away from one of radius `b`. A gap below zero
/// counts as zero.
///
/// ```
/// use fluid_solver::methods::virtual_mass::images::beside;
/// // Two equal spheres that touch: one held, both moving together, head-on.
/// let c = beside(3, 1.0, 1.0, 0.0);
/// assert!((c.own - 0.5777).abs() < 1e-3);
/// assert!((c.own - c.mutual - 0.3523).abs() < 1e-3);
/// assert!((c.own + c.mutual - 0.8031).abs() < 1e-3);
/// ```
pub fn beside(dimensions: i32, a: f64, b: f64, gap: f64) -> Coefficients {
    let distance = a + b + gap.max(0.0);
    let (mut at, mut strength) = (0.0, 1.0);
    let (mut in_a, mut in_b) = (0.0, 0.0);
    let mut last = 1.0;
    for _ in 0..IMAGES[usize::from(dimensions == 3)] {
        let d = distance - at;
        last = strength;
        strength *= (b / d).powi(dimensions);
        in_b += strength;
        let d = distance - b * b / d;
        strength *= (a / d).powi(dimensions);
        in_a += strength;
        at = a * a / d;
        if strength < WEAK {
            break;
        }
    }
    // Geometric far from contact, n^−dimensions in contact, whose sum is as much larger.
    let ratio = strength / last;
    let tail = ratio / (1.0 - ratio) * (1.0 + ratio * ratio / f64::from(dimensions - 1));
    in_a += strength * tail;
    in_b += (last * strength).sqrt() * tail;
    let alone = alone(dimensions);
    Coefficients { own: alone + (1.0 + alone) * in_a, mutual: (1.0 + alone) * in_b }
}

/// Coefficient of a body whose surface is `gap` away from a plane wall: that of two equal ones head-on.
///
/// ```
/// use fluid_solver::methods::virtual_mass::images::at_a_wall;
/// assert!((at_a_wall(3, 1.0, 0.0) - 0.80309).abs() < 1e-3);
/// ```
pub fn at_a_wall(dimensions: i32, radius: f64, gap: f64) -> f64 {
    let pair = beside(dimensions, radius, radius, 2.0 * gap.max(0.0));
    pair.own + pair.mutual
}

/// The same in contact: ½ (3 ζ(3) − 2) for a sphere, π²/3 − 1 for a cylinder.
pub fn touching_a_wall(dimensions: i32) -> f64 {
    match dimensions {
        2 => PI * PI / 3.0 - 1.0,
        _ => 0.803_085_354_739,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// C = ½ [1 + 3 Σ_{n≥2} (sinh α / sinh nα)³], cosh α = h/R, and the same with squares for a cylinder.
    #[test]
    fn walls_agree_with_the_closed_series() {
        for gap in [1e-3, 0.01, 0.1, 0.5, 1.0, 3.0] {
            let alpha = (1.0_f64 + gap).acosh();
            let series = |power: i32| -> f64 {
                (2..4000).map(|n| (alpha.sinh() / (f64::from(n) * alpha).sinh()).powi(power)).sum()
            };
            let (sphere, disc) = (0.5 * (1.0 + 3.0 * series(3)), 1.0 + 2.0 * series(2));
            assert!((at_a_wall(3, 2.0, 2.0 * gap) - sphere).abs() < 5e-4, "gap {gap}");
            assert!((at_a_wall(2, 2.0, 2.0 * gap) - disc).abs() < 0.02, "gap {gap}");
        }
    }

    #[test]
    fn touching_and_far_values() {
        // Σ 1/n³ = ζ(3), Σ 1/n² = π²/6.
        let zeta = 1.202_056_903_159_594;
        assert!((at_a_wall(3, 1.0, 0.0) - 0.5 * (1.0 + 3.0 * (zeta - 1.0))).abs() < 1e-3);
        assert!((at_a_wall(2, 1.0, 0.0) - (PI * PI / 3.0 - 1.0)).abs() < 0.02);
        // ½ (1 + ⅜ (R/h)³) far away (Lamb 1932, § 137).
        assert!((at_a_wall(3, 1.0, 9.0) - 0.5 * (1.0 + 0.375e-3)).abs() < 1e-6);
        assert!((beside(2, 1.0, 1.0, 1e3).own - 1.0).abs() < 1e-6);
        assert_eq!(beside(3, 1.0, 2.0, -0.1), beside(3, 1.0, 2.0, 0.0));
    }

    /// The energy has one mixed term: M m_f is the same seen from either body.
    #[test]
    fn mutual_mass_is_symmetric() {
        for (a, b, gap) in [(1.0, 0.5, 0.1), (0.2, 1.0, 0.3), (1.0, 0.9, 0.01)] {
            let (here, there) =
                (beside(3, a, b, gap).mutual * a.powi(3), beside(3, b, a, gap).mutual * b.powi(3));
            assert!((here / there - 1.0).abs() < 2e-3, "{here} {there}");
        }
    }

    /// A small sphere beside a large one is a sphere at a wall; one that accelerates with the wall feels the
    /// fluid's own acceleration: L − M = −1.
    #[test]
    fn a_large_neighbour_is_a_wall() {
        let c = beside(3, 1e-3, 1.0, 2e-4);
        assert!((c.own - at_a_wall(3, 1e-3, 2e-4)).abs() < 3e-3, "{c:?}");
        assert!((c.own - c.mutual + 1.0).abs() < 6e-3, "{c:?}");
    }
}
