//! Haff's law: a gas of inelastic spheres cools as E₀/(1 + t/τ)² (Haff 1983), τ from kinetic theory.
//!
//! 1/τ = (1 − e²) ω (1 + 3 a₂/16)/6 with the collision rate of a sphere, ω = 4 n σ² g √(π T/m), the pair
//! distribution at contact g = (2 − φ)/(2 (1 − φ)³) (Carnahan & Starling 1969), and the second Sonine
//! coefficient a₂ = 16 (1 − e)(1 − 2e²)/(81 − 17 e + 30 e² (1 − e)) (van Noije & Ernst 1998; Brilliantov &
//! Pöschel 2004, Kinetic Theory of Granular Gases). It holds while the gas is homogeneous: vortices and
//! clusters grow in boxes longer than some ten mean free paths over √(1 − e²); here L/σ = 17, ten paths. Soft
//! spheres cannot collapse (no infinitely many collisions in finite time), but multiple contacts dissipate
//! less once the mean time between collisions comes down to t_c; here ω t_c = 0.007 at first. Each contact
//! also takes t_c in which a sphere meets no other: at ω t_c = 0.018 τ is 2.6 % longer.
use crate::common::{Random, dem, exact, law, spec};
use dem_solver::{Engine, Grain};
use std::f64::consts::PI;

const E_N: f64 = 0.8;
const T_C: f64 = 0.004;
const SIDE: f64 = 17.364; // φ = 0.1

/// 1,000 spheres of diameter 1, at rest in the mean; each component of the velocities has a variance near 1.
fn gas() -> Vec<Grain> {
    let mut random = Random(11);
    let mut grains: Vec<Grain> = (0..1000)
        .map(|k| {
            let site = [k % 10, k / 10 % 10, k / 100].map(|s| (f64::from(s) + 0.5) * SIDE / 10.0);
            let mut grain = Grain::new(site, 0.5, 1.0);
            let mut normal = || (0..12).map(|_| random.next()).sum::<f64>() - 6.0;
            grain.velocity = [normal(), normal(), normal()];
            grain
        })
        .collect();
    for axis in 0..3 {
        let mean = grains.iter().map(|grain| grain.velocity[axis]).sum::<f64>() / 1000.0;
        grains.iter_mut().for_each(|grain| grain.velocity[axis] -= mean);
    }
    grains
}

/// τ for unit variance of the velocities.
fn theory() -> f64 {
    let (n, solid, e) = (1000.0 / SIDE.powi(3), 0.1f64, E_N);
    let contact = (2.0 - solid) / (2.0 * (1.0 - solid).powi(3));
    let rate = 4.0 * n * contact * PI.sqrt();
    let sonine = 16.0 * (1.0 - e) * (1.0 - 2.0 * e * e) / (81.0 - 17.0 * e + 30.0 * e * e * (1.0 - e));
    6.0 / ((1.0 - e * e) * rate * (1.0 + 3.0 / 16.0 * sonine))
}

/// T(t)^(−1/2) of the gas is a straight line with slope 1/τ; looked at from two collisions a sphere on to
/// E/E₀ of about 1/13. Returns slope and root mean square about the line over the mean; energy by spins
/// counts.
fn cool(friction: f64) -> (f64, f64) {
    let mut law = exact(law(E_N, T_C));
    law.friction = friction;
    let mut set_up = spec(gas(), law);
    set_up.periods = [Some((0.0, SIDE)); 3];
    set_up.engine = Engine::Bulk;
    (set_up.observations, set_up.orientation) = (false, false);
    let mut solver = dem(&set_up);
    let degrees = 3.0 * solver.grains.mass.iter().sum::<f64>();
    let mut points = Vec::new();
    for _ in 0..100 {
        solver.advance(0.25, 1250, &[]).expect("advances");
        let temperature = 2.0 * solver.kinetic_energy() / degrees;
        if solver.time() > 1.0 {
            points.push((solver.time(), temperature.sqrt().recip()));
        }
    }
    let count = points.len() as f64;
    let (t, y) = points.iter().fold((0.0, 0.0), |m, p| (m.0 + p.0 / count, m.1 + p.1 / count));
    let sum = |f: &dyn Fn(f64, f64) -> f64| points.iter().map(|p| f(p.0 - t, p.1 - y)).sum::<f64>();
    let slope = sum(&|t, y| t * y) / sum(&|t, _| t * t);
    let rest = sum(&|t, y| (y - slope * t) * (y - slope * t));
    println!("friction {friction}: T falls to {:.4}", points.last().expect("points").1.powi(-2));
    (slope, (rest / count).sqrt() / y)
}

/// Friction takes more, and the law keeps its form once translation and rotation cool together.
#[test]
fn a_gas_cools_as_kinetic_theory_says_and_faster_with_friction() {
    let ((smooth, misfit), (rough, rough_misfit)) = (cool(0.0), cool(0.3));
    let tau = theory();
    println!("τ {:.3}, theory {tau:.3}, misfit {misfit:.4}", 1.0 / smooth);
    println!("with friction τ {:.3}, misfit {rough_misfit:.4}", 1.0 / rough);
    // 1,000 spheres: the rate of some 20,000 collisions is known to about 1 %
    assert!((smooth * tau - 1.0).abs() < 0.03, "τ = {} instead of {tau}", 1.0 / smooth);
    assert!(misfit < 0.02, "{misfit}");
    assert!(rough > 1.05 * smooth, "{rough} and {smooth}");
    assert!(rough_misfit < 0.04, "{rough_misfit}");
}
