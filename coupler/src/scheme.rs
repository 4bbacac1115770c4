//! Which window comes next, and how many sub-steps it gets.
//!
//! The planner is deterministic: the window after the next `ahead` ones is planned from what was
//! known exactly `ahead` windows before, never from what happens to have arrived. So the order in
//! which messages come, and a resume in between, change no bit of a run.

use std::collections::VecDeque;

use bedload_scene::{CheckedScene, Grain, Motion, Observe};
use protocol::message::{Header, Kinematics, Loads};
use protocol::participant::Window;
use protocol::scheme::Scheme;
use serde::{Deserialize, Serialize};

use crate::config::{Coupling, Substeps};
use crate::number::norm;
use crate::plan::Plan;

/// Windows that may be on their way at once where dt is fixed: enough to take the coupler's own
/// latency off the critical path.
pub const AHEAD: usize = 4;
/// An adaptive step grows by at most this ratio from one window to the next.
const GROWTH: f64 = 1.25;

/// How long nothing can begin to touch.
///
/// Relative motion over T is at most V T + ½ A T², V and A the largest relative speed and
/// acceleration; of bodies that are not round those of their farthest points, which spin moves. Both are
/// doubled: V for what the fluid's memory may add, A because loads change.
#[derive(Clone, Debug)]
pub struct ContactFreeHorizon {
    /// Gap at which contact or lubrication begins, m.
    range: f64,
    gravity: f64,
    masses: Vec<f64>,
    /// How far from its centre each grain reaches, m, and the square of its radius of gyration, m², where it
    /// is not round; 0 and 1 of what is.
    reaches: Vec<(f64, f64)>,
    /// Acceleration that the scene prescribes, by grain, m/s².
    swings: Vec<f64>,
    wall_speed: f64,
    /// Largest acceleration of a wall, m/s².
    wall_acceleration: f64,
}

impl ContactFreeHorizon {
    /// For a scene whose contact and lubrication begin at the gap `range`.
    pub fn new(scene: &CheckedScene, range: f64) -> Self {
        let held = |motion: Motion| motion != Motion::Free;
        let arm = |grain: &Grain| {
            if grain.shape.is_round() { (0.0, 1.0) } else { (grain.radius, grain.gyration()) }
        };
        let (walls, until) = (scene.contact_walls(), scene.scene.until);
        Self {
            range,
            gravity: scene.scene.largest_gravity(),
            masses: scene
                .grains
                .iter()
                .map(|grain| if held(grain.motion) { f64::INFINITY } else { grain.mass() })
                .collect(),
            swings: scene
                .grains
                .iter()
                .map(|grain| grain.velocity.fastest(until) + arm(grain).0 * grain.spin.fastest(until))
                .collect(),
            reaches: scene.grains.iter().map(arm).collect(),
            wall_speed: scene.wall_speed(until),
            wall_acceleration: walls.iter().map(|wall| wall.velocity.fastest(until)).fold(0.0, f64::max),
        }
    }

    /// Largest acceleration of a point of grain `index` with `spin` under `load`: weight and twice the load
    /// on the dry mass, or what the scene prescribes.
    fn acceleration(&self, index: usize, load: &Loads, spin: f64) -> f64 {
        let (mass, (reach, gyration)) = (self.masses[index], self.reaches[index]);
        let turn = reach * spin * spin;
        if mass.is_infinite() {
            return self.swings[index] + turn;
        }
        let about = reach * 2.0 * norm(&load.torque) / (mass * gyration);
        self.gravity + 2.0 * norm(&load.force) / mass + turn + about
    }

    /// Time, counted from the end of the window of these messages, in which nothing can begin to
    /// touch; 0 where something touches already or a gap is not known.
    pub fn contact_free_for(&self, loads: &[Loads], kinematics: &[Kinematics]) -> f64 {
        // A DEM may not watch far pairs of many grains and leave their gap infinite: that is no
        // knowledge, except of a grain that has no other.
        let alone = kinematics.len() == 1;
        let known =
            |gap: f64| if gap.is_nan() || (gap == f64::INFINITY && !alone) { f64::NEG_INFINITY } else { gap };
        let gap = kinematics.iter().map(|grain| known(grain.gap)).fold(f64::INFINITY, f64::min);
        let room = gap - self.range;
        // Infinity less infinity is no room either.
        if room.is_nan() || room <= 0.0 {
            return 0.0;
        }
        let moving = || kinematics.iter().map(|grain| (norm(&grain.velocity), norm(&grain.spin)));
        let speeds = moving().zip(&self.reaches).map(|((speed, spin), (reach, _))| speed + reach * spin);
        let accelerations = loads.iter().zip(moving()).enumerate();
        let accelerations =
            accelerations.map(|(index, (load, (_, spin)))| self.acceleration(index, load, spin));
        let (v, a) =
            (largest_pair(speeds, self.wall_speed), largest_pair(accelerations, self.wall_acceleration));
        time_to_cover(room, 2.0 * v, 2.0 * a)
    }
}

/// Sum of the two largest values, `other` being one more that is always there.
fn largest_pair(values: impl Iterator<Item = f64>, other: f64) -> f64 {
    let (first, second) = values.fold((other, 0.0), |(first, second), value| {
        if value > first { (value, first) } else { (first, f64::max(second, value)) }
    });
    first + second
}

/// The T at which v T + ½ a T² = room; infinite at rest.
fn time_to_cover(room: f64, v: f64, a: f64) -> f64 {
    // The form without the difference of near numbers.
    2.0 * room / (v + (v * v + 2.0 * a * room).sqrt())
}

/// State of the planner: everything that decides the next window.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PlannerState {
    step: u64,
    /// Its start, s.
    time: f64,
    /// Length of the last window, s.
    dt: f64,
    /// Until when nothing can touch, as known after each window that no plan has used yet, oldest
    /// first: the first is used for the next window. −1: not at all.
    quiet: VecDeque<f64>,
    /// Largest step that the solvers would accept; infinite: not asked yet.
    limit: f64,
}

/// Plans window after window.
#[derive(Clone, Debug)]
pub struct Planner {
    plan: Plan,
    substeps: Substeps,
    observe: Observe,
    state: PlannerState,
}

impl Planner {
    /// From the start of a run.
    pub fn new(plan: &Plan, coupling: &Coupling, observe: &Observe) -> Self {
        // The plan of a window that may be repeated waits for its last attempt.
        let iterated = plan.scheme == Some(Scheme::Iterated);
        let ahead = if plan.adaptive || iterated { 1 } else { AHEAD };
        let state = PlannerState {
            step: 0,
            time: 0.0,
            dt: plan.dt_first,
            quiet: std::iter::repeat_n(-1.0, ahead).collect(),
            limit: f64::INFINITY,
        };
        Self { plan: plan.clone(), substeps: coupling.substeps, observe: observe.clone(), state }
    }

    /// Next window to plan.
    pub fn step(&self) -> u64 {
        self.state.step
    }

    /// Its start, s.
    pub fn time(&self) -> f64 {
        self.state.time
    }

    /// For a checkpoint: to be asked only while nothing is on its way.
    pub fn state(&self) -> &PlannerState {
        &self.state
    }

    /// Goes on from a checkpoint.
    pub fn resume(&mut self, state: PlannerState) {
        self.state = state;
    }

    /// Is the end reached?
    pub fn is_over(&self) -> bool {
        self.remaining() <= 0.0
    }

    fn remaining(&self) -> f64 {
        // A remainder of rounding is no window.
        let left = self.plan.until - self.state.time;
        if left <= 1e-9 * self.plan.until.min(self.state.dt.max(self.plan.steps.dt_fluid)) {
            0.0
        } else {
            left
        }
    }

    /// Plans the next window; none at the end, or while the window `ahead` before it is not known.
    pub fn next_window(&mut self) -> Option<Window> {
        if self.is_over() {
            return None;
        }
        let quiet = self.state.quiet.pop_front()?;
        let dt = self.window_length();
        let state = &self.state;
        let full = self.plan.full_substeps(dt);
        let end = state.time + dt;
        let single = self.substeps == Substeps::Auto && end <= quiet;
        let window = Window {
            step: state.step,
            attempt: 0,
            time: state.time,
            dt,
            substeps: if single { 1 } else { full },
            output: self.observe.fields_due(state.time, end),
        };
        self.advance(dt);
        Some(window)
    }

    fn window_length(&self) -> f64 {
        let left = self.remaining();
        let first = if self.state.step == 0 { self.state.dt } else { f64::INFINITY };
        let dt = match self.plan.adaptive {
            true => first.min(self.state.limit).min(self.plan.dt_max).min(GROWTH * self.state.dt),
            false => self.plan.steps.dt_fluid,
        };
        // The last two windows share what is left, so that none is a sliver, over which the mean of a force
        // means nothing.
        match left / dt {
            ratio if ratio <= 1.0 + 1e-6 => left,
            ratio if ratio < 2.0 - 1e-6 => 0.5 * left,
            _ => dt,
        }
    }

    fn advance(&mut self, dt: f64) {
        let fixed = self.plan.steps.dt_fluid;
        let begun = self.state.step as f64 * fixed;
        self.state.step += 1;
        // Multiplied, not summed: a million windows add no rounding. After the last two windows of a run that
        // now goes on, which share what was left, the time is no multiple.
        let regular = !self.plan.adaptive && dt == fixed && (self.state.time - begun).abs() < 1e-6 * fixed;
        self.state.time = if regular { self.state.step as f64 * fixed } else { self.state.time + dt };
        if self.plan.until - self.state.time <= 1e-9 * dt {
            self.state.time = self.plan.until;
        }
        self.state.dt = dt;
    }

    /// Takes what is known after a window: until when nothing can touch, and the solvers' limit.
    pub fn learn(&mut self, quiet_until: f64, dt_limit: f64) {
        self.state.quiet.push_back(quiet_until);
        self.state.limit = dt_limit;
    }
}

/// Did a window that got one sub-step see something begin to touch after all? Then the rule's
/// margin was too small for this flow.
pub fn was_late(window: &Window, full: u64, header: &Header, range: f64) -> bool {
    full > 1 && window.substeps == 1 && header.smallest_gap < range
}
