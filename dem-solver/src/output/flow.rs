//! Dense flow across the slabs of a profile: the ratio of stresses μ = τ/σ and the inertial number
//! I = γ̇ d/√(σ/ρ_p) of its rheology μ(I) (GDR MiDi 2004, Eur. Phys. J. E 14, 341; Jop, Forterre & Pouliquen
//! 2006), and how the velocity grows below the surface: v = a − b (h − z)^n, n = 3/2 where I is the same
//! everywhere (Bagnold 1954; Silbert et al. 2001, eq. 12).

use crate::motion::Vec3;
use crate::output::janssen::{Measured, Silo, least, mean};
use crate::output::profile::Profile;

/// Normal and shear stress across the slab, Pa.
fn stresses(profile: &Profile, slab: usize) -> [f64; 2] {
    let (axis, stress) = (profile.axis, profile.cells[slab].stress());
    let shear = (0..3).filter(|&c| c != axis).map(|c| stress[(c, axis)].powi(2)).sum::<f64>();
    [stress[(axis, axis)], shear.sqrt()]
}

/// Size of the part of a velocity that lies along the slabs, m/s.
fn along(profile: &Profile, velocity: &Vec3) -> f64 {
    (0..3).filter(|c| *c != profile.axis).map(|c| velocity[c].powi(2)).sum::<f64>().sqrt()
}

/// Slabs of `range` that bear a normal stress.
fn bearing(profile: &Profile, range: [f64; 2]) -> impl Iterator<Item = usize> + '_ {
    profile.slabs_in(range).filter(|&slab| stresses(profile, slab)[0] > 0.0)
}

/// Σ τ over Σ σ, with the standard deviation of τ/σ over the slabs.
pub fn stress_ratio(profile: &Profile, range: [f64; 2]) -> Option<Measured> {
    let sum = bearing(profile, range).map(|slab| stresses(profile, slab));
    let [normal, shear] = sum.fold([0.0; 2], |[a, b], [c, d]| [a + c, b + d]);
    let spread = mean(bearing(profile, range).map(|slab| {
        let [normal, shear] = stresses(profile, slab);
        shear / normal
    }))?;
    Some(Measured { value: shear / normal, ..spread })
}

/// I for grains of diameter `d`, m: γ̇ from the slabs to both sides.
pub fn inertial_number(profile: &Profile, range: [f64; 2], d: f64) -> Option<Measured> {
    mean(bearing(profile, range).filter_map(|slab| {
        let around = [slab.checked_sub(1)?, slab + 1];
        let [below, above] = around.map(|slab| profile.cells.get(slab).filter(|cell| cell.density > 0.0));
        let rate = along(profile, &(above?.velocity - below?.velocity)) / (2.0 * profile.width);
        let cell = &profile.cells[slab];
        let [normal, _] = stresses(profile, slab);
        Some(rate * d * (cell.density / cell.solid / normal).sqrt())
    }))
}

/// n of least squares over the slabs of `range`, from 0.1 to 5, none if it lies beyond; h is where a column
/// of the mean density of `range` ends.
pub fn exponent(profile: &Profile, range: [f64; 2], gravity: f64) -> Option<Measured> {
    let top = Silo::new(profile, range, gravity)?.top;
    let points: Vec<(f64, f64)> = bearing(profile, range)
        .map(|slab| (top - profile.middle(slab), along(profile, &profile.cells[slab].velocity)))
        .filter(|(depth, _)| *depth > 0.0)
        .collect();
    let count = points.len() as f64;
    if points.len() < 4 {
        return None;
    }
    // v of the line through (depth^n, v), at each point.
    let line = |n: f64| {
        let x = move |depth: f64| depth.powf(n);
        let [mx, mv] = [points.iter().map(|(d, _)| x(*d)).sum::<f64>(), points.iter().map(|(_, v)| v).sum()]
            .map(|sum: f64| sum / count);
        let slope = points.iter().map(|(d, v)| (x(*d) - mx) * (v - mv)).sum::<f64>()
            / points.iter().map(|(d, _)| (x(*d) - mx).powi(2)).sum::<f64>();
        move |depth: f64| mv + slope * (x(depth) - mx)
    };
    let miss = |n: f64| points.iter().map(|(d, v)| (v - line(n)(*d)).powi(2)).sum::<f64>();
    let value = least(miss, 0.1, 5.0)?;
    let (more, less) = (line(value + 1e-3), line(value - 1e-3));
    let steepness: f64 = points.iter().map(|(d, _)| ((more(*d) - less(*d)) / 2e-3).powi(2)).sum();
    let spread = (miss(value) / (count - 3.0) / steepness).sqrt();
    Some(Measured { value, spread, slabs: points.len() })
}
