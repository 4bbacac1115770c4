//! The time step: what is asked for, what the method bears, what is proposed.

use crate::config::{Choices, LONG, ViscosityKey};
use crate::grid::Grid;
use crate::immersed::body::Motion;
use crate::initial::Start;
use crate::scheme::Viscous;
use crate::speed;
use bedload_scene::{Changing, CheckedScene, Geometry, Medium, OverTime, Scene, SceneError, changing};

/// Lengths that an adaptive step may have in an octave, evenly spaced: a power of two.
const LEVELS: u32 = 4;

/// Part of what is allowed at which an adaptive step still stays as it is.
const PATIENCE: f64 = 0.5;

/// First step of a run with grains over R²/ν, R the smallest radius: a layer of √(νt) grows on each grain.
/// docs/decisions/time-step.md
const LAYER: f64 = 0.008;

/// Cells that stand for that radius where there are no grains, but walls and drives alone.
const WALL: f64 = 8.0;

/// Largest step over the time since the start: what goes on as a power of that time is resolved alike.
/// docs/decisions/time-step.md
const OF_AGE: f64 = 0.1;

/// Largest ratio of a step to the one before it: to the next level.
const GROWTH: f64 = 1.25;

/// Part of the expected step to which a table may shorten it that moves a sphere, and any other that spheres
/// feel: what shorter steps leave in the carried force of a jump grows as they grow again.
/// docs/decisions/values-over-time.md
const OF_TABLES: [f64; 2] = [0.0625, 0.25];

/// Bounds on the time step, and what it follows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plan {
    /// dt of the scene, s, if it is fixed.
    pub fixed: Option<f64>,
    /// CFL number kept when it is not.
    pub cfl: f64,
    /// Largest step whatever the velocity, s, but for explicit viscosity.
    pub ceiling: f64,
    /// Largest step that explicit viscosity bears, s.
    pub explicit: f64,
    /// Step at the speed that is expected of the run, s: for its cost and the bounds on its windows.
    pub expected: f64,
    /// First step, s.
    pub first: f64,
    /// Time that the flow counts as having gone on before t = 0, s: ten times the first step, and the
    /// whole run that this one goes on with.
    pub age: f64,
    /// Treatment of viscosity.
    pub viscous: Viscous,
    /// Smallest cell, m.
    pub spacing: f64,
    /// Largest speed of the run that this one starts from, m/s; zero: there is none.
    pub start: f64,
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
        // Up to it the carried force converges in few steps in dense beds, and what a wall or a drive sets in
        // motion at once does not ring for long: docs/numerics.md, Forcing and viscosity.
        let force = LONG * spacing * spacing / nu;
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
        let changes = changes(scene);
        let swings =
            changes.iter().filter(|change| matches!(change, Change::Value { value: OverTime::Sine(_), .. }));
        let ceiling = shortest(swings, 0.0, 0.0).min(force).min(scene.scene.until);
        let bears = if viscous == Viscous::Explicit { explicit } else { f64::INFINITY };
        if let Some(dt) = time.dt.filter(|dt| *dt > bears) {
            return Err(scene.source.error(
                "fluid.time.dt",
                format!("is {dt}; with explicit viscosity this grid allows at most {explicit:.3e}"),
                "give a smaller dt, or set fluid.time.viscosity = \"implicit\"",
            ));
        }
        let expected = level(by_speed.min(ceiling).min(bears));
        let from_rest = from_rest(scene, nu).unwrap_or(LAYER * (WALL * spacing).powi(2) / nu);
        let first = level(expected.min(from_rest).min(shortest(&changes, 0.0, expected)));
        let mut plan = Self {
            fixed: time.dt,
            cfl: time.cfl,
            ceiling,
            explicit,
            expected: time.dt.unwrap_or(expected),
            first: time.dt.unwrap_or(first),
            age: first / OF_AGE,
            viscous,
            spacing,
            start: fastest,
        };
        if let Some((last, rate)) = start.and_then(Start::last) {
            plan.age += last.time;
            let allowed = plan.allowed(rate, &last.memory.motions, &last.memory.before);
            plan.first = plan.next(last.previous_dt, 0.0, allowed, 1.0);
            plan.expected = plan.first;
        }
        Ok(plan)
    }

    /// The same, with no step longer than resolves `changes` from `time` on.
    pub(crate) fn until_change(&self, changes: &[Change], time: f64) -> Self {
        Self { ceiling: self.ceiling.min(shortest(changes, time, self.expected)), ..*self }
    }

    /// The longest step, s, that velocities allow, with `rate` the largest Σ|u|/Δx, 1/s, and the grains as
    /// they are and as they were before the last step.
    pub fn allowed(&self, rate: f64, now: &[Motion], before: &[Motion]) -> f64 {
        let speed = |motion: &Motion| motion.velocity.iter().map(|v| v.abs()).sum::<f64>();
        // What speeds up goes on to do so.
        let next = |(now, before)| speed(now) + (speed(now) - speed(before)).max(0.0);
        let fastest = now.iter().zip(before).map(next).fold(0.0, f64::max);
        (self.cfl / rate.max(fastest / self.spacing)).min(self.longest())
    }

    /// Largest step whatever the velocity, s.
    fn longest(&self) -> f64 {
        if self.viscous == Viscous::Explicit { self.ceiling.min(self.explicit) } else { self.ceiling }
    }

    /// Step proposed at `time` after one of length `previous`, s, where velocities allow `allowed`, s, and a
    /// touch the part `part` of it.
    ///
    /// It is a level. While the time since the start bounds it, or nearly so, it follows that; later it stays
    /// the same while it is allowed and twice its length is not: a new length costs the carried force a few
    /// steps. One that was no level the end of a run had cut, by half at most: what goes on past that has a
    /// whole one.
    pub fn next(&self, previous: f64, time: f64, allowed: f64, part: f64) -> f64 {
        if let Some(dt) = self.fixed {
            return dt;
        }
        let by_age = OF_AGE * (time + self.age);
        let settled = part == 1.0 && PATIENCE * by_age >= allowed;
        if settled && previous <= allowed && previous >= PATIENCE * allowed {
            let whole = if previous == level(previous) { 0.0 } else { level(allowed.min(2.0 * previous)) };
            return previous.max(whole);
        }
        level((part * allowed).min(by_age).min(GROWTH * previous))
    }
}

/// What the scene changes over time.
pub(crate) enum Change {
    /// A value.
    Value {
        value: OverTime<[f64; 3]>,
        /// Part of the expected step to which it may shorten it.
        least: f64,
    },
    /// A wall that vanishes and lets grains go.
    Gate {
        /// When, s.
        at: f64,
        /// First step of a start from rest, s.
        first: f64,
    },
}

impl Change {
    /// The longest step from `time` on, s, that resolves it, where `expected`, s, is expected. After a gate
    /// it follows the time since then, as after the start of a run.
    fn longest_step(&self, time: f64, expected: f64) -> f64 {
        match self {
            Self::Value { value, least } => value.longest_step(time).max(least * expected),
            Self::Gate { at, first } if time < *at - 0.5 * first => (at - time).max(*first),
            Self::Gate { at, first } => first + OF_AGE * (time - at).max(0.0),
        }
    }
}

/// Longest first step of grains that are let go in a fluid of kinematic viscosity `nu`, m²/s, s; none without
/// a grain.
fn from_rest(scene: &CheckedScene, nu: f64) -> Option<f64> {
    let smallest = scene.grains.iter().map(|grain| grain.radius).reduce(f64::min)?;
    Some(LAYER * smallest * smallest / nu)
}

/// What the scene changes over time: walls, drives, grains, a flow rate.
pub(crate) fn changes(scene: &CheckedScene) -> Vec<Change> {
    let Scene { domain, grains, .. } = &scene.scene;
    let spheres = domain.geometry != Geometry::Plane && !grains.is_empty();
    let change = |Changing { key, value, .. }: Changing| {
        let moves = key.starts_with("grains[") && key.ends_with(".velocity");
        let is_felt = spheres && matches!(value, OverTime::Table(_));
        Change::Value { value, least: if is_felt { OF_TABLES[usize::from(!moves)] } else { 0.0 } }
    };
    let free = scene.grains.iter().any(|grain| grain.motion == bedload_scene::Motion::Free);
    let medium = scene.scene.medium.as_ref().filter(|_| free);
    let first = medium.and_then(|medium| from_rest(scene, medium.kinematic_viscosity()));
    let gates = first.into_iter().flat_map(|first| {
        let ends = scene.scene.walls.iter().map(|wall| wall.until).filter(|at| at.is_finite());
        ends.map(move |at| Change::Gate { at, first })
    });
    changing(scene).into_iter().map(change).chain(gates).collect()
}

/// The longest step from `time` on, s, that resolves all of them, where `expected`, s, is expected.
fn shortest<'a>(changes: impl IntoIterator<Item = &'a Change>, time: f64, expected: f64) -> f64 {
    changes.into_iter().map(|change| change.longest_step(time, expected)).fold(f64::INFINITY, f64::min)
}

/// The largest 2^k (1 + j/[`LEVELS`]), 0 ≤ j < `LEVELS`, that is not above `dt`: with few digits, so that
/// sums of steps are exact.
fn level(dt: f64) -> f64 {
    f64::from_bits(dt.to_bits() & !((1_u64 << (f64::MANTISSA_DIGITS - 1 - LEVELS.ilog2())) - 1))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Of a run that has gone on for long.
    const PLAN: Plan = Plan {
        fixed: None,
        cfl: 0.5,
        ceiling: 1.0,
        explicit: 0.25,
        expected: 1.0,
        first: 1.0 / 128.0,
        age: f64::INFINITY,
        viscous: Viscous::Implicit,
        spacing: 0.1,
        start: 0.0,
    };

    #[test]
    fn levels_lie_close_below() {
        for dt in [0.04, 1e-7, 3.0, 0.999, 123.4, 1.999] {
            let level = level(dt);
            assert!(level <= dt && level > 0.8 * dt, "{level} under {dt}");
        }
        assert_eq!([1.75, 1.9375].map(level), [1.75, 1.75]);
        // Growth reaches the next level and not the one after it.
        for j in 0..LEVELS {
            let [this, next, other] = [0, 1, 2].map(|more| 1.0 + f64::from(j + more) / f64::from(LEVELS));
            assert_eq!(level(GROWTH * this), if next < 2.0 { next } else { 2.0 });
            assert!(GROWTH * this < other);
        }
    }

    /// Number of changes while the rate runs through `rates`; every step keeps the CFL number.
    fn changes(plan: &Plan, rates: impl Iterator<Item = f64>) -> usize {
        let mut dt = 1.0;
        let mut changes = 0;
        for rate in rates {
            let next = plan.next(dt, 0.0, plan.allowed(rate, &[], &[]), 1.0);
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
        assert!(falling <= 11, "{falling}");
    }

    #[test]
    fn the_first_steps_follow_the_time_since_the_start() {
        let plan = Plan { age: PLAN.first / OF_AGE, ..PLAN };
        let (mut time, mut dt, mut steps) = (0.0, plan.first, 0);
        while dt < plan.ceiling {
            time += dt;
            steps += 1;
            let next = plan.next(dt, time, plan.allowed(0.1, &[], &[]), 1.0);
            let by_age = plan.first + OF_AGE * time;
            assert!(next >= dt && next <= GROWTH * dt && next <= by_age * (1.0 + 1e-12), "{next} at {time}");
            // It does not wait: the level below.
            assert!(next >= 0.8 * by_age.min(GROWTH * dt), "{next} at {time}");
            dt = next;
        }
        // ln(1 + 0.1 t/first) over ln 1.1 and the levels: from 1/128 to 1 in 51 steps at best.
        assert!((51..=66).contains(&steps), "{steps}");
        // A run that goes on with another is as old as that one.
        let later = Plan { age: plan.age + 1.0, ..plan };
        assert_eq!(later.next(0.1, 0.5, 1.0, 1.0), plan.next(0.1, 1.5, 1.0, 1.0));
    }

    #[test]
    fn a_grain_that_speeds_up_is_expected_to_go_on() {
        let at = |speed: f64| Motion { velocity: [0.0, 0.0, speed], ..Motion::default() };
        let step =
            |before: f64, now: f64| PLAN.next(1.0, 0.0, PLAN.allowed(0.0, &[at(now)], &[at(before)]), 1.0);
        assert_eq!(step(-0.1, -0.1), level(0.5));
        assert_eq!(step(-0.05, -0.1), level(0.05 / 0.15));
        // One that slows down, or bounces, is as fast as it is.
        assert_eq!(step(-0.2, 0.1), level(0.5));
    }

    /// The last two windows before an end share what is left.
    #[test]
    fn what_goes_on_past_an_end_has_a_whole_step() {
        for cut in [0.26, 0.3, 0.4] {
            assert_eq!(PLAN.next(cut, 0.0, 0.5, 1.0), 0.5, "{cut}");
            assert_eq!(PLAN.next(cut, 0.0, 0.47, 1.0), level(0.47), "{cut}");
        }
        // Shortened by another solver a little below a level: as it was.
        assert_eq!(PLAN.next(0.46, 0.0, 0.47, 1.0), 0.46);
    }

    #[test]
    fn about_a_touch_the_step_is_a_part_of_what_is_allowed() {
        assert_eq!(PLAN.next(0.5, 0.0, 0.5, 0.1), level(0.05));
        assert_eq!(PLAN.next(0.5, 0.0, 0.5, 1.0), 0.5);
        // After it a quarter longer each, up to half of what is allowed.
        let mut dt = level(0.05);
        let steps = (0..).take_while(|_| {
            let next = PLAN.next(dt, 0.0, 0.5, 1.0);
            let grows = next > dt && next <= GROWTH * dt;
            dt = next;
            grows
        });
        assert!((8..=12).contains(&steps.count()));
        assert!((0.25..=0.5).contains(&dt));
        assert_eq!(Plan { fixed: Some(0.3), ..PLAN }.next(0.3, 0.0, 0.5, 0.1), 0.3);
    }
}
