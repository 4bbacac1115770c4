//! The time step: what is asked for, what the method bears, what is proposed.

use crate::config::{Choices, ViscosityKey};
use crate::grid::Grid;
use crate::immersed::body::Motion;
use crate::initial::Start;
use crate::scheme::Viscous;
use crate::speed;
use bedload_scene::{CheckedScene, Medium, SceneError};

/// ν dt/Δx² up to which the carried force converges in few steps in dense beds.
/// docs/numerics.md, Forcing and viscosity
const FORCE_NUMBER: f64 = 2.0;

/// Bounds on the time step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plan {
    /// dt of the scene, s, if it is fixed.
    pub fixed: Option<f64>,
    /// CFL number kept when it is not.
    pub cfl: f64,
    /// Lengths that it may have in an octave, a power of two.
    pub dt_levels_per_octave: u32,
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
        let explicit = time.scheme.viscous_limit() / (nu * inverse);
        let spacing = grid.smallest_width();
        let force =
            if scene.grains.is_empty() { f64::INFINITY } else { FORCE_NUMBER * spacing * spacing / nu };
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
        let mut plan = Self {
            fixed: time.dt,
            cfl: time.cfl,
            dt_levels_per_octave: time.dt_levels_per_octave,
            ceiling,
            viscous,
            spacing,
            start: fastest,
            goes_on: None,
        };
        plan.goes_on = start.and_then(Start::last).map(|(dt, rate, motions)| plan.next(dt, rate, motions));
        Ok(plan)
    }

    /// Step proposed before anything moves, s.
    pub fn first(&self) -> f64 {
        self.fixed.or(self.goes_on).unwrap_or_else(|| self.level(self.ceiling))
    }

    /// Step proposed after one of length `previous`, with `rate` the largest Σ|u|/Δx.
    ///
    /// It stands on a level, and stays there while it is allowed and, in octaves of even levels, some two
    /// levels more are not: a new length costs the carried force a few steps.
    pub fn next(&self, previous: f64, rate: f64, motions: &[Motion]) -> f64 {
        if let Some(dt) = self.fixed {
            return dt;
        }
        let fastest = motions.iter().map(|m| m.velocity.iter().map(|v| v.abs()).sum()).fold(0.0, f64::max);
        let allowed = (self.cfl / rate.max(fastest / self.spacing)).min(self.ceiling);
        if previous <= allowed && previous >= self.patience() * allowed {
            previous
        } else {
            self.level(allowed)
        }
    }

    /// Part of what is allowed at which a step still stays: half with four levels an octave or fewer.
    fn patience(&self) -> f64 {
        (1.0 - 2.0 / f64::from(self.dt_levels_per_octave)).max(0.5)
    }

    /// The largest 2^k (1 + j/levels), 0 ≤ j < levels, that is not above `dt`: with few digits, so that sums
    /// of steps are exact.
    fn level(&self, dt: f64) -> f64 {
        f64::from_bits(
            dt.to_bits() & !((1_u64 << (f64::MANTISSA_DIGITS - 1 - self.dt_levels_per_octave.ilog2())) - 1),
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PLAN: Plan = Plan {
        fixed: None,
        cfl: 0.5,
        dt_levels_per_octave: 4,
        ceiling: 1.0,
        viscous: Viscous::Implicit,
        spacing: 0.1,
        start: 0.0,
        goes_on: None,
    };

    #[test]
    fn levels_lie_close_below() {
        for (levels, least) in [(1, 0.5), (4, 0.8), (16, 16.0 / 17.0), (64, 64.0 / 65.0)] {
            let plan = Plan { dt_levels_per_octave: levels, ..PLAN };
            for dt in [0.04, 1e-7, 3.0, 0.999, 123.4, 1.999] {
                let level = plan.level(dt);
                assert!(level <= dt && level > least * dt, "{level} under {dt}, {levels} in an octave");
            }
        }
        assert_eq!([1.75, 1.9375].map(|dt| PLAN.level(dt)), [1.75, 1.75]);
        assert_eq!(Plan { dt_levels_per_octave: 16, ..PLAN }.level(1.94), 1.9375);
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
        // Rising fivefold, 2.3 octaves: a level at a time. Falling, it waits until twice the step is allowed,
        // or with more levels until 1/(1 - 2/levels) of it is.
        for (levels, most_rising, most_falling) in [(4, 10, 3), (16, 40, 18)] {
            let plan = Plan { dt_levels_per_octave: levels, ..PLAN };
            let rising = changes(&plan, (0..1000).map(rate));
            assert!(rising <= 1 + most_rising, "{rising}");
            let falling = changes(&plan, (0..1000).rev().map(rate));
            assert!(falling <= 1 + most_falling, "{falling}");
        }
    }
}
