//! How strongly a grain holds the fluid at a point: the odds `q`, with `β = q / (1 + q)`.
//!
//! **Parameter-free** (the default). With the force λ carried from step to step, the steady state is
//! a Brinkman medium of inverse permeability `e^{−2s/w} / τ`, and the no-slip surface that the
//! flow sees is where the grain ends if
//!
//! ```text
//! τ = (w² / 4ν) exp(2 γ_E − 0.0566 (n_x⁴ + n_y⁴ + n_z⁴) Δx² / w²),   q = (dt / τ) e^{−2s/w}
//! ```
//!
//! Derivation: `docs/equations-immersed.md`. **Seed**: `q = e^{−2s/w}` (Izard et al. 2014, eq. 8).

use super::volume_fraction::{LAMBDA_SIGMA, log_odds, thickness};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Euler's constant γ_E.
const EULER: f64 = 0.577_215_664_901_532_9;

/// Shift of the surface by the grid, fitted on exact one-dimensional discrete solutions.
const GRID_SHIFT: f64 = 0.0566;

/// Odds of a point that is solid, 1 − β = 1e-8.
pub const SOLID: f64 = 1e8;

/// Where the band around a surface ends: odds above count as solid, odds below 1/`EDGE` as nothing, and no
/// function is evaluated there. The drag of an array does not feel it (`docs/equations-immersed.md`).
pub const EDGE: f64 = 1e4;

/// Logarithm of [`EDGE`].
const LOG_EDGE: f64 = 9.210_340_371_976_184;

/// Form of the mask.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Mask {
    /// The surface stands where the flow sees it, at any dt and resolution.
    #[default]
    ParameterFree,
    /// Izard et al. (2014), eq. 8.
    Seed,
}

/// A mask with everything it depends on but the place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Kernel {
    /// Form.
    pub mask: Mask,
    /// Factor on the seed's thickness.
    pub width: f64,
    /// Kinematic viscosity, m²/s.
    pub viscosity: f64,
    /// Time step, s.
    pub dt: f64,
}

impl Kernel {
    /// Logarithm of the odds at distance `s` outside the surface with outward normal `n`.
    #[inline]
    pub fn exponent<const D: usize>(&self, s: f64, n: &[f64; D], spacing: &[f64; D]) -> f64 {
        let w = thickness(self.width, n, spacing);
        let fourth: f64 = (0..D).map(|a| (n[a] * n[a] * spacing[a]).powi(2)).sum();
        match self.mask {
            Mask::Seed => log_odds(s, w),
            Mask::ParameterFree => log_odds(s, w) + self.log_rate(w, fourth),
        }
    }

    /// Odds at distance `s`: [`SOLID`] above [`EDGE`], zero below 1/[`EDGE`].
    #[inline]
    pub fn odds<const D: usize>(&self, s: f64, n: &[f64; D], spacing: &[f64; D]) -> f64 {
        match self.exponent(s, n, spacing) {
            e if e < -LOG_EDGE => 0.0,
            e if e > LOG_EDGE => SOLID,
            e => e.exp(),
        }
    }

    /// `a` and `b` in dt/τ = (a/w²) exp(b Σ n_a⁴ Δx_a²/w²), m² and 1.
    pub fn rate_and_shift(&self) -> [f64; 2] {
        [4.0 * self.viscosity * self.dt * (-2.0 * EULER).exp(), GRID_SHIFT]
    }

    /// ln(dt/τ), with `fourth` = Σ n_a⁴ Δx_a².
    #[inline]
    fn log_rate(&self, w: f64, fourth: f64) -> f64 {
        let w2 = w * w;
        (4.0 * self.viscosity * self.dt / w2).ln() - 2.0 * EULER + GRID_SHIFT * fourth / w2
    }

    /// Radii within which a grain is solid and beyond which it is not felt, for spacings between
    /// `least` and `most`: bounds over all normals.
    pub fn reach(&self, radius: f64, least: f64, most: f64) -> [f64; 2] {
        let [low, high] = LAMBDA_SIGMA;
        let thin = self.width * low * 2f64.sqrt() * least;
        let thick = self.width * high * 2f64.sqrt() * most;
        let rates = match self.mask {
            Mask::Seed => [0.0, 0.0],
            Mask::ParameterFree => [self.log_rate(thick, 0.0), self.log_rate(thin, most * most)],
        };
        let inner = radius - 0.5 * thick * (LOG_EDGE - rates[0]).max(0.0);
        let outer = radius + 0.5 * thick * (LOG_EDGE + rates[1]).max(0.0);
        [inner.min(radius), outer]
    }
}

#[cfg(test)]
mod tests {
    use super::super::volume_fraction::fraction;
    use super::*;

    const KERNEL: Kernel = Kernel { mask: Mask::ParameterFree, width: 0.5, viscosity: 1e-2, dt: 0.5 };

    #[test]
    fn parameter_free_odds_are_the_printed_formula() {
        let (n, spacing, s) = ([0.6, 0.8], [0.1; 2], 0.03);
        let w = thickness(0.5, &n, &spacing);
        let fourth = n[0].powi(4) + n[1].powi(4);
        let tau = w * w / (4.0 * 1e-2) * (2.0 * 0.5772156649_f64 - 0.0566 * fourth * 0.01 / (w * w)).exp();
        let beta = 1.0 / (1.0 + tau / 0.5 * (2.0 * s / w).exp());
        let ours = fraction(KERNEL.odds(s, &n, &spacing));
        assert!((ours - beta).abs() < 1e-9, "{ours} against {beta}");
    }

    #[test]
    fn inside_is_solid_outside_is_fluid_and_the_reach_knows_it() {
        for mask in [Mask::ParameterFree, Mask::Seed] {
            for dt in [1e-4, 0.5, 100.0] {
                let kernel = Kernel { mask, dt, ..KERNEL };
                let [inner, outer] = kernel.reach(1.0, 0.1, 0.1);
                for angle in 0..90 {
                    let angle = f64::from(angle).to_radians();
                    let n = [angle.cos(), angle.sin()];
                    assert_eq!(kernel.odds(outer - 1.0, &n, &[0.1; 2]), 0.0);
                    assert!(kernel.odds(inner - 1.0, &n, &[0.1; 2]) >= SOLID * (1.0 - 1e-9));
                }
            }
        }
    }

    #[test]
    fn permeability_does_not_depend_on_dt() {
        // χ = q / dt is what the steady state sees.
        let chi = |dt: f64| {
            let kernel = Kernel { dt, ..KERNEL };
            kernel.odds(0.02, &[0.0, 1.0], &[0.1; 2]) / dt
        };
        assert!((chi(0.5) / chi(0.01) - 1.0).abs() < 1e-12);
    }
}
