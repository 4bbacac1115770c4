//! The smooth surface of a grain: Izard et al. (2014), eqs 8–10 ("the seed").
//!
//! ```text
//! α = ½ − ½ tanh(s / w)                  (8)   s: distance to the surface, outward positive
//! λ = |n_x| + |n_y| + |n_z|              (9)   n: outward normal
//! σ = 0.065 (1 − λ²) + 0.39              (10)
//! w = f λ σ Δ,  Δ = √2 Δx                      f: width factor, 1 in the seed
//! ```
//!
//! Everything here works with the odds `q = α / (1 − α) = e^{−2s/w}` instead of α: odds of several
//! grains add up smoothly (docs/numerics.md, Mask), and `α = q / (1 + q)` gives eq. 8 back.

/// σ = `SIGMA` − `SIGMA_SLOPE` λ² (eq. 10).
pub const SIGMA: f64 = 0.39 + SIGMA_SLOPE;
/// See [`SIGMA`].
pub const SIGMA_SLOPE: f64 = 0.065;

/// Thickness w of the transition, m, for the outward unit normal `n` (eqs 9–10).
///
/// `spacing` is the cell width along each axis; Δx is its mean along the normal,
/// `(Σ n_a² Δx_a²)^½`, which is Δx itself on a uniform grid.
#[inline]
pub fn thickness<const D: usize>(factor: f64, n: &[f64; D], spacing: &[f64; D]) -> f64 {
    let mut lambda = 0.0;
    let mut across = 0.0;
    for a in 0..D {
        lambda += n[a].abs();
        across += (n[a] * spacing[a]).powi(2);
    }
    let sigma = SIGMA - SIGMA_SLOPE * lambda * lambda;
    factor * lambda * sigma * (2.0 * across).sqrt()
}

/// Bounds of λσ over all normals: 0.39 along an axis, 0.4633 at λ = 1.5275 (reached in space only).
pub const LAMBDA_SIGMA: [f64; 2] = [0.39, 0.4634];

/// Logarithm of the odds of eq. 8: `−2 s / w`.
#[inline]
pub fn log_odds(s: f64, w: f64) -> f64 {
    -2.0 * s / w
}

/// Solid volume fraction α from the odds.
#[inline]
pub fn fraction(odds: f64) -> f64 {
    odds / (1.0 + odds)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// α of eq. 8 by the printed formula.
    fn printed(s: f64, w: f64) -> f64 {
        0.5 - 0.5 * (s / w).tanh()
    }

    #[test]
    fn odds_give_equation_8() {
        for s in [-3.0, -0.4, 0.0, 0.1, 2.5] {
            let alpha = fraction(log_odds(s, 0.7).exp());
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
