//! The time step: what is asked for, what the method bears, what is proposed.

use crate::config::{Choices, LONG, ViscosityKey};
use crate::grid::Grid;
use crate::immersed::body::Motion;
use crate::initial::Start;
use crate::scheme::Viscous;
use crate::speed;
use bedload_scene::{CheckedScene, Medium, SceneError};

/// Lengths that an adaptive step may have in an octave, evenly spaced: a power of two.
const LEVELS: u32 = 4;

/// Part of what is allowed at which an adaptive step still stays as it is.
const PATIENCE: f64 = 0.5;

/// Bounds on the time step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plan {
    /// dt of the scene, s, if it is fixed.
    pub fixed: Option<f64>,
    /// CFL number kept when it is not.
    pub cfl: f64,
    /// Largest step whatever the velocity, s.
    pub ceiling: f64,
    /// Treatment of viscosity.
    pub viscous: Viscous,
    /// Smallest cell, m.
    pub spacing: f64,
    /// Largest speed of the run that this one starts from, m/s; zero: there is none.
    pub start: f64,
    /// First step of a run that goes on with another, s, where it is not fixed.
    pub goes_on: Option<f64>,
}

impl Plan {
    /// Decides the treatment of viscosity and the bounds, `start` being the run that this one starts from.
    ///
    /// # Errors
    /// If explicit viscosity is asked for with a dt that it does not bear.
    pub fn new<const D: usize>(
        scene: &CheckedScene,
        medium: &Medium,
        choices: &Choices,
        grid: &Grid<D>,
        start: Option<&Start<D>>,
    ) -> Result<Self, SceneError> {
        let nu = medium.kinematic_viscosity();
        let time = &choices.time;
        let width = |a: usize| grid.axes[a].widths.iter().copied().fold(f64::INFINITY, f64::min);
        let inverse: f64 = (0..D).map(|a| width(a).powi(-2)).sum();
        let explicit = choices.scheme.viscous_limit() / (nu * inverse);
        let spacing = grid.smallest_width();
        // Up to it the carried force converges in few steps in dense beds: docs/numerics.md, Forcing and
        // viscosity.
        let force = if scene.grains.is_empty() { f64::INFINITY } else { LONG * spacing * spacing / nu };
        let fastest = start.map_or(0.0, Start::fastest);
        let speed = speed::expected(scene, medium).max(fastest);
        let by_speed = time.cfl * spacing / speed;
        let wanted = time.dt.unwrap_or(by_speed.min(force));
        let viscous = match time.viscosity {
            ViscosityKey::Implicit => Viscous::Implicit,
            ViscosityKey::Explicit => Viscous::Explicit,
            ViscosityKey::Auto if wanted <= explicit => Viscous::Explicit,
            ViscosityKey::Auto => Viscous::Implicit,
        };
        let mut ceiling = by_speed.min(force).min(scene.scene.until);
        if viscous == Viscous::Explicit {
            if let Some(dt) = time.dt.filter(|dt| *dt > explicit) {
                return Err(scene.source.error(
                    "fluid.time.dt",
                    format!("is {dt}; with explicit viscosity this grid allows at most {explicit:.3e}"),
                    "give a smaller dt, or set fluid.time.viscosity = \"implicit\"",
                ));
            }
            ceiling = ceiling.min(explicit);
        }
        let mut plan =
            Self { fixed: time.dt, cfl: time.cfl, ceiling, viscous, spacing, start: fastest, goes_on: None };
        plan.goes_on = start.and_then(Start::last).map(|(dt, rate, motions)| plan.next(dt, rate, motions));
        Ok(plan)
    }

    /// Step proposed before anything moves, s.
    pub fn first(&self) -> f64 {
        self.fixed.or(self.goes_on).unwrap_or_else(|| level(self.ceiling))
    }

    /// Step proposed after one of length `previous`, with `rate` the largest Σ|u|/Δx.
    ///
    /// It is a level, and stays the same while it is allowed and twice its length is not: a new length costs
    /// the carried force a few steps.
    pub fn next(&self, previous: f64, rate: f64, motions: &[Motion]) -> f64 {
        if let Some(dt) = self.fixed {
            return dt;
        }
        let fastest = motions.iter().map(|m| m.velocity.iter().map(|v| v.abs()).sum()).fold(0.0, f64::max);
        let allowed = (self.cfl / rate.max(fastest / self.spacing)).min(self.ceiling);
        if previous <= allowed && previous >= PATIENCE * allowed { previous } else { level(allowed) }
    }
}

/// The largest 2^k (1 + j/[`LEVELS`]), 0 ≤ j < `LEVELS`, that is not above `dt`: with few digits, so that
/// sums of steps are exact.
fn level(dt: f64) -> f64 {
    f64::from_bits(dt.to_bits() & !((1_u64 << (f64::MANTISSA_DIGITS - 1 - LEVELS.ilog2())) - 1))
}

#[cfg(test)]
mod tests {
    use super::*;

    const PLAN: Plan = Plan {
        fixed: None,
        cfl: 0.5,
        ceiling: 1.0,
        viscous: Viscous::Implicit,
        spacing: 0.1,
        start: 0.0,
        goes_on: None,
    };

    #[test]
    fn levels_lie_close_below() {
        for dt in [0.04, 1e-7, 3.0, 0.999, 123.4, 1.999] {
            let level = level(dt);
            assert!(level <= dt && level > 0.8 * dt, "{level} under {dt}");
        }
        assert_eq!([1.75, 1.9375].map(level), [1.75, 1.75]);
    }

    /// Number of changes while the rate runs through `rates`; every step keeps the CFL number.
    fn changes(plan: &Plan, rates: impl Iterator<Item = f64>) -> usize {
        let mut dt = 0.0;
        let mut changes = 0;
        for rate in rates {
            let next = plan.next(dt, rate, &[]);
            assert!(next * rate <= plan.cfl * (1.0 + 1e-12) && next <= plan.ceiling, "{next} at {rate}");
            changes += usize::from(next != dt);
            dt = next;
        }
        changes
    }

    #[test]
    fn the_step_changes_seldom() {
        let rate = |k: i32| 0.5 + f64::from(k) * 0.002;
        // Rising fivefold, 2.3 octaves: a level at a time. Falling, it waits until twice the step is allowed.
        let rising = changes(&PLAN, (0..1000).map(rate));
        assert!(rising <= 11, "{rising}");
        let falling = changes(&PLAN, (0..1000).rev().map(rate));
        assert!(falling <= 4, "{falling}");
    }
}
