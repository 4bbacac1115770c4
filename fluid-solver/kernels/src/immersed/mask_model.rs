//! How strongly a grain holds the fluid at a point: the mask ratios `q`, with `β = q / (1 + q)`.
//!
//! **Parameter-free** (r–z and space). With the force λ carried from step to step, the steady state is
//! a Brinkman medium of inverse permeability `e^{−2s/w} / τ`, and the no-slip surface that the
//! flow sees is where the grain ends if
//!
//! ```text
//! τ = (w² / 4ν) exp(2 γ_E − 0.0617 N Δx² / w²),   N = n_x⁴ + n_y⁴ + n_z⁴
//! q = (dt / τ) e^{−2s'/w},   s' = s + 0.092 N² Δx W(s/Δx)
//! ```
//!
//! W is a wave of period 1, `8 x (1 − 2|x|)` for |x| ≤ ½. A mask without it shifts the surface by up to 0.12
//! Δx to and fro as it moves over the nodes, where it is parallel to them; with it by 0.035 Δx at most.
//!
//! **Exact shear** (the plane). χ is made of the profile u(s) that the grid shall have, so that the discrete
//! equation ν∇²u = χu holds for it at every node, wherever a wall lies between the nodes:
//!
//! ```text
//! u = Δ g(s/Δ),   g(x) = ∫ max(0, x − y) dy over |y| < ½,   Δ = (Σ n_a² Δx_a²)^½,   m_a = n_a Δx_a/Δ
//! q = ν dt Σ_a [g(x + m_a) + g(x − m_a) − 2 g(x)] / (Δx_a² g(x)),   x = s/Δ
//! ```
//!
//! Derivations: `docs/equations-immersed.md`. **Izard et al.**: `q = e^{−2s/w}` (Izard et al. 2014, eq. 8).
//! q is called the mask ratio here.
//!
//! Thickness w (Izard et al. 2014, eqs 8–10):
//! ```text
//! α = ½ − ½ tanh(s / w)                  (8)   s: distance to the surface, outward positive
//! λ = |n_x| + |n_y| + |n_z|              (9)   n: outward normal
//! σ = 0.065 (1 − λ²) + 0.39              (10)
//! w = f λ σ Δ,  Δ = √2 Δx                      f: width factor, 1 in print
//! ```
//! Ratios of several grains add up smoothly (`docs/numerics.md`, "sum χ"); `α = q / (1 + q)` gives eq. 8
//! back.

/// σ = `SIGMA` − `SIGMA_SLOPE` λ² (eq. 10).
pub const SIGMA: f64 = 0.39 + SIGMA_SLOPE;
/// See [`SIGMA`].
pub const SIGMA_SLOPE: f64 = 0.065;

/// Bounds of λσ over all normals: 0.39 along an axis, 0.4633 at λ = 1.5275 (reached in space only).
pub const LAMBDA_SIGMA: [f64; 2] = [0.39, 0.4634];

/// Euler's constant γ_E.
const EULER: f64 = 0.577_215_664_901_532_9;

/// Shift of the surface by the grid, in the mean over places, of a mask without and with the wave; with
/// [`SWING`] fitted on exact one-dimensional discrete solutions (docs/equations-immersed.md, eq. 5).
const GRID_SHIFT: [f64; 2] = [0.0566, 0.0617];

/// Cells by which the distance from the surface is corrected for the place on the grid.
pub(super) const SWING: f64 = 0.092;

/// Mask ratio of a point that is solid, 1 − β = 1e-8.
pub const SOLID: f64 = 1e8;

/// Where the band around a surface ends: mask ratios above count as solid, mask ratios below 1/`EDGE` as
/// nothing, and no function is evaluated there. The drag of an array does not feel it
/// (`docs/equations-immersed.md`).
pub const EDGE: f64 = 1e4;

/// Where the mask of exact shear ends, in cells: solid further inside, not felt further outside.
pub(super) const BAND: [f64; 2] = [0.5, 1.5];

/// Logarithm of [`EDGE`].
pub(super) const LOG_EDGE: f64 = 9.210_340_371_976_184;

/// The wave W of period 1 in the number of cells `x`: a sine by two parabolas.
#[inline(always)]
pub(super) fn wave(x: f64) -> f64 {
    let x = x - round(x);
    8.0 * x * (1.0 - 2.0 * x.abs())
}

/// The nearest whole number, of numbers below 2⁵¹.
#[inline(always)]
pub(super) fn round(x: f64) -> f64 {
    (x + ROUND) - ROUND
}

/// Adding it leaves the nearest whole number in the last bits.
pub(crate) const ROUND: f64 = 6_755_399_441_055_744.0;

/// Form of the mask.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mask {
    /// The surface is where the flow feels it, at any dt and resolution.
    ParameterFree,
    /// A shear along a wall is exact at every node, and vanishes at the wall.
    ExactShear,
    /// Izard et al. (2014), eq. 8.
    Izard2014,
}

/// A mask with everything it depends on but the place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MaskModel {
    /// Form.
    pub mask: Mask,
    /// Factor on the thickness of Izard et al. (2014), eqs 8–10.
    pub width: f64,
    /// Part of the wave that it has, 0 to 1: that of the grain ([`super::body::Shape::wave`]).
    pub wave: f64,
    /// Kinematic viscosity, m²/s.
    pub viscosity: f64,
    /// Time step, s.
    pub dt: f64,
}

impl MaskModel {
    /// `a` and `b` in dt/τ = (a/w²) exp(b Σ n_a⁴ Δx_a²/w²), m² and 1.
    pub fn rate_and_shift(&self) -> [f64; 2] {
        [4.0 * self.viscosity * self.dt * (-2.0 * EULER).exp(), self.shift()]
    }

    fn shift(&self) -> f64 {
        GRID_SHIFT[0] + (GRID_SHIFT[1] - GRID_SHIFT[0]) * self.wave
    }

    /// Amplitude of the wave in the distance, cells.
    pub(super) fn swing(&self) -> f64 {
        match self.mask {
            Mask::ParameterFree => SWING * self.wave,
            Mask::Izard2014 | Mask::ExactShear => 0.0,
        }
    }

    /// ln(dt/τ), with `fourth` = Σ n_a⁴ Δx_a².
    #[inline]
    pub(super) fn log_rate(&self, w: f64, fourth: f64) -> f64 {
        let w2 = w * w;
        (4.0 * self.viscosity * self.dt / w2).ln() - 2.0 * EULER + self.shift() * fourth / w2
    }

    /// Radii within which a grain is solid and beyond which it is not felt, for spacings between
    /// `least` and `most`: bounds over all normals.
    pub fn reach(&self, radius: f64, least: f64, most: f64) -> [f64; 2] {
        let [low, high] = LAMBDA_SIGMA;
        let thin = self.width * low * 2f64.sqrt() * least;
        let thick = self.width * high * 2f64.sqrt() * most;
        let rates = match self.mask {
            Mask::Izard2014 => [0.0, 0.0],
            Mask::ParameterFree => [self.log_rate(thick, 0.0), self.log_rate(thin, most * most)],
            Mask::ExactShear => return [radius - BAND[0] * most, radius + BAND[1] * most],
        };
        let swing = self.swing() * most;
        let inner = radius - swing - 0.5 * thick * (LOG_EDGE - rates[0]).max(0.0);
        let outer = radius + swing + 0.5 * thick * (LOG_EDGE + rates[1]).max(0.0);
        [inner.min(radius), outer]
    }
}

/// g of the mask of exact shear.
#[inline(always)]
pub(super) fn rounded(x: f64) -> f64 {
    let part = (x + BAND[0]).clamp(0.0, 1.0);
    0.5 * part * part + (x - BAND[0]).max(0.0)
}

/// q of the mask of exact shear at `x` from the surface, in Δ. `spread`: ν dt, m²; `axes`: m_a and 1/Δx_a² of
/// each axis, 1 and 1/m².
#[inline(always)]
pub(super) fn exact_shear<const D: usize>(spread: f64, x: f64, axes: [[f64; 2]; D]) -> f64 {
    let here = rounded(x);
    let mut bend = 0.0;
    for [step, inverse] in axes {
        bend += (rounded(x + step) + rounded(x - step) - 2.0 * here) * inverse;
    }
    // At its end there is round-off only.
    let ratio = if x < BAND[1] - 1e-6 { spread * bend / here.max(1.0 / SOLID) } else { 0.0 };
    if here < 1.0 / SOLID { SOLID } else { ratio.min(SOLID) }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The discrete shear along a plane wall vanishes at the wall, wherever that lies between the nodes, and
    /// is one over all nodes but its tail: the mask is exact, not in the mean of places only.
    #[test]
    fn a_shear_along_a_wall_is_seen_at_the_wall_at_every_place() {
        for place in (0..40).map(|k| f64::from(k) / 40.0) {
            let ratio = |node: i32| exact_shear(1.0, f64::from(node) + place, [[1.0, 1.0]]);
            // u(+) = (2 + q) u − u(−), from inside
            let (mut before, mut u) = (0.0, 1.0);
            for node in -1..9 {
                (before, u) = (u, (2.0 + ratio(node)) * u - before);
            }
            let wall = 9.0 + place - u / (u - before);
            assert!(wall.abs() < 1e-7, "{place}: the wall is seen at {wall}");
        }
    }
}
