//! Short-range repulsion of Wan & Turek (2007), in the form that Verjus & Guillou print.
//!
//! With d the distance of the centres, s = R_i + R_j and h_s the range,
//!
//! F = (X_i − X_j)(s − d)/ε for d ≤ s,  (X_i − X_j)(s + h_s − d)²/ε for s < d ≤ s + h_s, else 0.
//!
//! **A misprint.** The overlap branch of Verjus & Guillou is printed with R_i − R_j − d, which would pull
//! equal grains together with −d however little they overlap; R_i + R_j − d is evidently meant, as in
//! Wan & Turek (2007) and in the printed wall force (2R_i − d′), and is what is used here.
//!
//! A wall acts like a grain mirrored in it: d′ = 2(R + δ) and 2R instead of s. The two branches do
//! not meet at d = s (the printed form jumps by h_s² d/ε there); it is kept as printed. There is no
//! friction and no damping.

use crate::error::SpecError;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Parameters of the repulsion.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct WanTurek {
    /// ε of grain pairs; units m²/N within contact (m³/N in the range).
    pub softness: f64,
    /// ε of walls.
    pub wall_softness: f64,
    /// Range h_s, m.
    pub range: f64,
}

impl WanTurek {
    /// Force between two grains, N, positive apart; `gap` = d − s, `distance` = d.
    #[inline(always)]
    #[must_use]
    pub fn pair_force(&self, gap: f64, distance: f64) -> f64 {
        distance * self.factor(gap) / self.softness
    }

    /// Force of a wall, N; `gap` from the surface to the wall.
    #[inline(always)]
    #[must_use]
    pub fn wall_force(&self, gap: f64, radius: f64) -> f64 {
        2.0 * (radius + gap) * self.factor(2.0 * gap) / self.wall_softness
    }

    #[inline(always)]
    fn factor(&self, gap: f64) -> f64 {
        if gap <= 0.0 {
            -gap
        } else if gap <= self.range {
            (self.range - gap) * (self.range - gap)
        } else {
            0.0
        }
    }

    /// Checks ranges.
    pub fn validate(&self) -> Result<(), SpecError> {
        let softness = [("softness", self.softness), ("wall_softness", self.wall_softness)];
        SpecError::unless_positive("wan-turek", &[softness[0], softness[1], ("range", self.range)])
    }
}
