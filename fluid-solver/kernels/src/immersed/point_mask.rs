//! The mask of one point as its formulas are printed: of bodies that are not round, and for tests of the rows
//! of round ones.

use super::mask_model::{LOG_EDGE, Mask, MaskModel, SIGMA, SIGMA_SLOPE, SOLID, exact_shear, wave};

/// Thickness w of the transition, m, for the outward unit normal `n` (eqs 9–10).
///
/// `spacing` is the cell width along each axis; Δx is its mean along the normal,
/// `(Σ n_a² Δx_a²)^½`, which is Δx itself on a uniform grid.
pub(super) fn thickness<const D: usize>(factor: f64, n: &[f64; D], spacing: &[f64; D]) -> f64 {
    let mut lambda = 0.0;
    let mut across = 0.0;
    for a in 0..D {
        lambda += n[a].abs();
        across += (n[a] * spacing[a]).powi(2);
    }
    let sigma = SIGMA - SIGMA_SLOPE * lambda * lambda;
    factor * lambda * sigma * (2.0 * across).sqrt()
}

/// Logarithm of the mask ratios of eq. 8: `−2 s / w`.
pub(super) fn log_ratio(s: f64, w: f64) -> f64 {
    -2.0 * s / w
}

/// Solid volume fraction α from the mask ratios.
#[cfg(test)]
pub(super) fn fraction(ratio: f64) -> f64 {
    ratio / (1.0 + ratio)
}

/// Mask ratio at distance `s` outside the surface with outward normal `n`; of masks that are exponentials,
/// [`SOLID`] above [`EDGE`] and zero below 1/[`EDGE`].
pub(super) fn ratio<const D: usize>(model: &MaskModel, s: f64, n: &[f64; D], spacing: &[f64; D]) -> f64 {
    let w = thickness(model.width, n, spacing);
    let width = (0..D).map(|a| (n[a] * spacing[a]).powi(2)).sum::<f64>().sqrt();
    let exponent = match model.mask {
        Mask::ExactShear => {
            let axes =
                std::array::from_fn(|a| [n[a] * spacing[a] / width, (spacing[a] * spacing[a]).recip()]);
            return exact_shear::<D>(model.viscosity * model.dt, s / width, axes);
        }
        Mask::Izard2014 => log_ratio(s, w),
        Mask::ParameterFree => {
            let fourth: f64 = (0..D).map(|a| (n[a] * n[a] * spacing[a]).powi(2)).sum();
            let aligned = fourth / (width * width);
            let swung = s + model.swing() * width * (aligned * aligned) * wave(s / width);
            log_ratio(swung, w) + model.log_rate(w, fourth)
        }
    };
    match exponent {
        e if e < -LOG_EDGE => 0.0,
        e if e > LOG_EDGE => SOLID,
        e => e.exp(),
    }
}

#[cfg(test)]
mod tests {
    use super::super::mask_model::LAMBDA_SIGMA;
    use super::*;

    /// α of eq. 8 by the printed formula.
    fn printed(s: f64, w: f64) -> f64 {
        0.5 - 0.5 * (s / w).tanh()
    }

    #[test]
    fn mask_ratios_give_equation_8() {
        for s in [-3.0, -0.4, 0.0, 0.1, 2.5] {
            let alpha = fraction(log_ratio(s, 0.7).exp());
            assert!((alpha - printed(s, 0.7)).abs() < 1e-15, "s = {s}: {alpha}");
        }
    }

    #[test]
    fn thickness_is_equations_9_and_10_by_hand() {
        // Along an axis: λ = 1, σ = 0.39, Δ = √2 · 0.1.
        let along = thickness(1.0, &[1.0, 0.0, 0.0], &[0.1; 3]);
        assert!((along - 0.39 * 0.1 * 2f64.sqrt()).abs() < 1e-16);
        // Along the diagonal in space: λ = √3, σ = 0.39 − 0.13 = 0.26.
        let n = [1.0 / 3f64.sqrt(); 3];
        let diagonal = thickness(1.0, &n, &[0.1; 3]);
        assert!((diagonal - 3f64.sqrt() * 0.26 * 0.1 * 2f64.sqrt()).abs() < 1e-15);
    }

    /// A flow along a wall, solved exactly on nodes that lie `place` + a whole number of cells outside it:
    /// where a shear vanishes, in cells outside the wall, and how much further inside a parabola with u'' =
    /// −1 and slope 1 does. (2 + q) u = u₋ + u₊ + force, ν dt/Δx² being 1.
    fn wall(place: f64) -> [f64; 2] {
        const CELLS: i32 = 14;
        let model = MaskModel { mask: Mask::ParameterFree, width: 0.5, wave: 1.0, viscosity: 1.0, dt: 1.0 };
        // From within outwards, u is a part of the next value and an offset by the force.
        let (mut part, mut offset) = (0.0, 0.0);
        for cell in -CELLS..CELLS {
            part = 1.0 / (2.0 + ratio(&model, f64::from(cell) + place, &[1.0], &[1.0]) - part);
            offset = (1.0 + offset) * part;
        }
        // Outside, u = a + b s − force s²/2 through the last node and one beyond it, with u = 1 or 0 there.
        let end = f64::from(CELLS) + place;
        let shear = 1.0 - part;
        let at_wall = 1.0 - shear * end;
        let slope = 0.5 * (end * end - (end - 1.0) * (end - 1.0)) - offset;
        let forced = 0.5 * end * end - slope * end;
        [-at_wall / shear, forced - slope / shear * at_wall]
    }

    #[test]
    fn the_flow_sees_the_wall_where_it_is_at_every_place_on_the_grid() {
        let places = 64;
        let walls: Vec<_> = (0..places).map(|k| wall((f64::from(k) + 0.5) / f64::from(places))).collect();
        let mean = [0, 1].map(|k| walls.iter().map(|wall| wall[k]).sum::<f64>() / f64::from(places));
        let most = walls.iter().fold(0.0, |most: f64, wall| most.max(wall[0].abs()));
        // Without the wave and with the shift alone: 0.12, and 0.0729 for the parabola.
        assert!(mean[0].abs() < 5e-4 && most < 0.036, "{mean:?} {most}");
        assert!((mean[1] - 0.0729 - 0.0121).abs() < 1e-4, "{mean:?}");
    }

    #[test]
    fn bounds_of_lambda_sigma_hold_for_all_directions() {
        for i in 0..=90 {
            for j in 0..=90 {
                let (a, b) = (f64::from(i).to_radians(), f64::from(j).to_radians());
                let n = [a.sin() * b.cos(), a.sin() * b.sin(), a.cos()];
                let value = thickness(1.0, &n, &[1.0; 3]) / 2f64.sqrt();
                assert!(value > LAMBDA_SIGMA[0] - 1e-12 && value < LAMBDA_SIGMA[1], "{value}");
            }
        }
    }
}
