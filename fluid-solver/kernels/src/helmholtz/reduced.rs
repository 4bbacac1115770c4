//! The edges of all blocks of a column: what stands below and above each of them.
//!
//! Between blocks b − 1 and b stand L_{b−1}, the last value of the one, and R_{b−1}, the first of the other.
//! With P the value below the first block (the last one of all where the axis is periodic, else of no
//! weight),
//! ```text
//! L_b = g_b + f_b L_{b−1} + s_b R_b,    R_{b−1} = y_b + F_b L_{b−1} + H_b R_b.
//! ```
//! One pass upward leaves L_b = α + β R_b + γ P and R_{b−1} = ρ + σ R_b + τ P; the last two are solved for P
//! and the value above the last block, and a pass downward gives the rest. The order never changes.

use super::block_sweep::{Beside, Edge, GROUP, Wide};
use crate::lanes::Kernel;
use pulp::Simd;

/// ρ, σ, τ and α, β, γ between two blocks.
pub(super) type Between = [Wide; 6];

/// The system of one group of modes.
pub(super) struct Reduce<'a> {
    pub(super) edges: &'a [Edge],
    /// Room for one less than there are blocks.
    pub(super) between: &'a mut [Between],
    pub(super) beside: &'a mut [Beside],
    pub(super) periodic: bool,
    /// Whether the first mode is known up to a constant only.
    pub(super) singular: bool,
}

impl Kernel for Reduce<'_> {
    #[inline(always)]
    fn run<S: Simd>(self, _: S) {
        let Self { edges, between, beside, periodic, singular } = self;
        let last = edges.len() - 1;
        let [g, f, s, ..] = &edges[0];
        let (mut alpha, mut beta, mut gamma) = (*g, *s, *f);
        for (b, (edge, between)) in edges[1..].iter().zip(&mut *between).enumerate() {
            let [g, f, s, y, below, above] = edge;
            // Between walls the last equation of the singular mode says nothing new: its value is zero.
            let drops = singular && !periodic && b + 1 == last;
            let [rho, sigma, tau, keep @ ..] = between;
            let [kept_alpha, kept_beta, kept_gamma] = keep;
            (*kept_alpha, *kept_beta, *kept_gamma) = (alpha, beta, gamma);
            for l in 0..GROUP {
                let mut inverse = 1.0 / (1.0 - below[l] * beta[l]);
                if drops && l == 0 {
                    inverse = 0.0;
                }
                rho[l] = inverse * (y[l] + below[l] * alpha[l]);
                sigma[l] = inverse * above[l];
                tau[l] = inverse * (below[l] * gamma[l]);
                alpha[l] = g[l] + f[l] * (alpha[l] + beta[l] * rho[l]);
                gamma[l] = f[l] * (gamma[l] + beta[l] * tau[l]);
                beta[l] = s[l] + f[l] * (beta[l] * sigma[l]);
            }
        }
        let (mut top, mut bottom) = ([0.0; GROUP], [0.0; GROUP]);
        if periodic {
            // R_0 = t₀ + t₁ R + t₂ P, R being the value above the last block.
            let [mut t0, mut t1, mut t2] = [[0.0; GROUP], [1.0; GROUP], [0.0; GROUP]];
            for [rho, sigma, tau, ..] in between.iter().rev() {
                for l in 0..GROUP {
                    t0[l] = rho[l] + sigma[l] * t0[l];
                    t1[l] *= sigma[l];
                    t2[l] = tau[l] + sigma[l] * t2[l];
                }
            }
            let [.., y, below, above] = &edges[0];
            for l in 0..GROUP {
                let inverse = 1.0 / (1.0 - above[l] * t1[l]);
                let constant = inverse * (y[l] + above[l] * t0[l]);
                let share = inverse * (below[l] + above[l] * t2[l]);
                let p = (alpha[l] + beta[l] * constant) / (1.0 - gamma[l] - beta[l] * share);
                bottom[l] = if singular && l == 0 { 0.0 } else { p };
                top[l] = constant + share * bottom[l];
            }
        }
        beside[last][1] = top;
        for (b, [rho, sigma, tau, alpha, beta, gamma]) in between.iter().enumerate().rev() {
            for l in 0..GROUP {
                top[l] = rho[l] + sigma[l] * top[l] + tau[l] * bottom[l];
                beside[b + 1][0][l] = alpha[l] + beta[l] * top[l] + gamma[l] * bottom[l];
            }
            beside[b][1] = top;
        }
        beside[0][0] = bottom;
    }
}
