//! Lubrication in all gaps of a sub-step at once.
//!
//! The implicit equations of all gaps together are the condition of least
//! ½ Σ_i M_i |v_i − v*_i|² + (1/dt) Σ_gaps ∫Φ: a convex function, so visiting one gap after the
//! other, each with its impulse re-solved against the present velocities, converges to the one
//! solution (Gauss–Seidel; "sequential impulses" in rigid-body dynamics). One gap, or gaps that
//! share no grain that can move, are exact after one sweep. Each visit changes both partners by
//! opposite impulses, so momentum is kept to round-off whatever the number of sweeps.
//!
//! Within a window a sub-step begins with the impulses extrapolated from the two before: they change
//! little, so that few sweeps do what many would from zero. A window begins from zero, so nothing of this
//! is state.
//!
//! The order is fixed: grain pairs (i, j) ascending, then walls by grain, eight parts of that list by
//! turns. M_i holds the virtual mass, locked directions have zero inverse mass.

use crate::grains::{Grains, Response};
use crate::lubrication::law::{Expansion, LubricationLaw, LubricationModel};
use crate::lubrication::sliding::{self, SlidingGap};
use crate::motion::Vec3;
use crate::search::contact_list::ContactList;
use crate::surroundings::Surroundings;

/// A sweep that changes no gap rate by more than this part of the largest is the last. After a window of 87 sub-steps
/// the velocities of a dense bed are 0.1 to 0.2 of this part off (example `lubrication_sweeps`).
const CONVERGED: f64 = 1e-6;

/// Parts of the list that take turns.
const PARTS: usize = 8;

/// One gap in reach: what every visit needs.
#[derive(Clone, Copy, Debug)]
struct ActiveGap {
    first: u32,
    /// Second grain, or the wall's index if `wall`.
    second: u32,
    wall: bool,
    normal: Vec3,
    /// Normal velocity of the wall, m/s.
    wall_rate: f64,
    inverse_mass: f64,
    expansion: Expansion,
    impulse: f64,
    /// Impulse in the sub-step before, if it was there.
    former: Option<f64>,
}

/// What a visit needs of a gap whose path is long.
#[derive(Clone, Copy, Debug)]
struct WholeLaw {
    law: LubricationLaw,
    gap: f64,
}

/// Scratch of the implicit pass; its memory is kept between sub-steps.
#[derive(Clone, Debug, Default)]
pub(crate) struct LubricationSolver {
    active: Vec<ActiveGap>,
    /// Of each of them.
    laws: Vec<WholeLaw>,
    /// Those of the sub-step before, in this window.
    last: Vec<ActiveGap>,
    /// Gaps so narrow that sliding surfaces feel each other.
    sliding: Vec<SlidingGap>,
}

impl LubricationSolver {
    /// Room for `count` gaps.
    pub(crate) fn reserve(&mut self, count: usize) {
        for gaps in [&mut self.active, &mut self.last] {
            gaps.reserve(count.saturating_sub(gaps.len()));
        }
        self.laws.reserve(count.saturating_sub(self.laws.len()));
        self.sliding.reserve(count.saturating_sub(self.sliding.len()));
    }

    /// A window begins: the next sub-step starts from nothing.
    pub(crate) fn forget(&mut self) {
        self.active.clear();
        self.last.clear();
    }

    /// Applies the impulses of all gaps over `dt` to the velocities, in place, and writes the mean
    /// force of the gaps on each grain into `force`. Positions stay at the start of the sub-step.
    #[allow(clippy::too_many_arguments)] // the pass touches all parts of the step, each once
    pub(crate) fn apply(
        &mut self,
        around: &Surroundings,
        model: &LubricationModel,
        sweeps: u32,
        grains: &mut Grains,
        response: &Response,
        (pairs, walls): (&ContactList, &ContactList),
        (t, dt): (f64, f64),
        force: &mut [Vec3],
    ) {
        force.fill(Vec3::zeros());
        std::mem::swap(&mut self.active, &mut self.last);
        self.active.clear();
        self.laws.clear();
        self.sliding.clear();
        let sliding = 0.0..=sliding::reach(model);
        for i in 0..grains.len() {
            let (x, v, r) = (grains.position[i], grains.velocity[i], grains.radius[i]);
            for k in pairs.row(i) {
                let j = pairs.other[k] as usize;
                let law = model.law(r, grains.radius[j]);
                let apart = around.periods.nearest(x - grains.position[j]);
                let distance = apart.norm();
                let gap = distance - r - grains.radius[j];
                let normal = apart * (1.0 / distance);
                let rates = ((v - grains.velocity[j]).dot(&normal), 0.0);
                let weight = response.inverse_mass[i] + response.inverse_mass[j];
                if sliding.contains(&gap) {
                    let (first, second) = (i as u32, pairs.other[k]);
                    self.sliding.push(SlidingGap { first, second, wall: false, normal, gap });
                }
                self.collect((i, pairs.other[k], false), WholeLaw { law, gap }, rates, &normal, &weight, dt);
            }
        }
        for i in 0..grains.len() {
            for k in walls.row(i) {
                let wall = &around.walls[walls.other[k] as usize];
                if wall.acts(t) {
                    let law = model.law(grains.radius[i], f64::INFINITY);
                    let gap = wall.gap(&grains.position[i], grains.radius[i], t);
                    let wall_rate = wall.velocity.dot(&wall.normal);
                    if sliding.contains(&gap) {
                        let (first, second, normal) = (i as u32, walls.other[k], wall.normal);
                        self.sliding.push(SlidingGap { first, second, wall: true, normal, gap });
                    }
                    let rates = (grains.velocity[i].dot(&wall.normal) - wall_rate, wall_rate);
                    let (who, weight) = ((i, walls.other[k], true), &response.inverse_mass[i]);
                    self.collect(who, WholeLaw { law, gap }, rates, &wall.normal, weight, dt);
                }
            }
        }
        self.begin_with_last(&mut grains.velocity, &response.inverse_mass);
        let sweeps = if self.active.len() <= 1 { 1 } else { sweeps };
        for _ in 0..sweeps {
            if self.sweep(&mut grains.velocity, &response.inverse_mass, dt) {
                break;
            }
        }
        for gap in &self.active {
            let push = gap.normal * (gap.impulse / dt);
            force[gap.first as usize] += push;
            if !gap.wall {
                force[gap.second as usize] -= push;
            }
        }
        sliding::brake(&self.sliding, around, model, grains, response, dt, force);
    }

    /// Takes a gap up if it can act within the sub-step and something can move: if the grain could reach it
    /// even at twice its present rate, as another gap may speed it up.
    #[inline(always)]
    fn collect(
        &mut self,
        (first, second, wall): (usize, u32, bool),
        law: WholeLaw,
        (rate, wall_rate): (f64, f64),
        normal: &Vec3,
        weight: &Vec3,
        dt: f64,
    ) {
        let inverse_mass = weight.component_mul(normal).dot(normal);
        if inverse_mass > 0.0 && law.gap - 2.0 * dt * rate.abs() <= law.law.cut_off {
            let (first, normal, impulse, former) = (first as u32, *normal, 0.0, None);
            let expansion = law.law.expansion(law.gap, dt, inverse_mass);
            self.active.push(ActiveGap {
                first,
                second,
                wall,
                normal,
                wall_rate,
                inverse_mass,
                expansion,
                impulse,
                former,
            });
            self.laws.push(law);
        }
    }

    /// Gives every gap the impulse that it had in the sub-step before, grown as it grew to that.
    fn begin_with_last(&mut self, velocity: &mut [Vec3], inverse_mass: &[Vec3]) {
        let mut last = self.last.iter().peekable();
        for gap in &mut self.active {
            while last.next_if(|before| before.key() < gap.key()).is_some() {}
            if let Some(before) = last.next_if(|before| before.key() == gap.key()) {
                gap.former = Some(before.impulse);
                let growth = before.former.map_or(0.0, |former| before.impulse - former);
                gap.push(velocity, inverse_mass, before.impulse + growth);
            }
        }
    }

    /// One pass over all gaps; true when nothing worth another pass changed.
    ///
    /// Neighbours in the list share a grain, so each would wait for the one before: eight parts of
    /// the list take turns.
    fn sweep(&mut self, velocity: &mut [Vec3], inverse_mass: &[Vec3], dt: f64) -> bool {
        let (mut change, mut largest) = (0.0f64, 0.0f64);
        let part = self.active.len().div_ceil(PARTS).max(1);
        for k in 0..part {
            for at in (k..self.active.len()).step_by(part) {
                let gap = &mut self.active[at];
                let (kick, without) = gap.visit(&self.laws[at], velocity, inverse_mass, dt);
                change = change.max((gap.inverse_mass * kick).abs());
                largest = largest.max(without.abs());
            }
        }
        change <= CONVERGED * largest
    }
}

impl WholeLaw {
    /// See [`LubricationLaw::impulse`]. Overlaps that last have none; logarithms are rare.
    #[inline(always)]
    fn impulse(&self, rate: f64, dt: f64, inverse_mass: f64) -> f64 {
        if self.gap <= 0.0 && self.gap + dt * rate <= 0.0 { 0.0 } else { self.long(rate, dt, inverse_mass) }
    }

    #[inline(never)]
    fn long(&self, rate: f64, dt: f64, inverse_mass: f64) -> f64 {
        self.law.impulse(self.gap, rate, dt, inverse_mass)
    }
}

impl ActiveGap {
    /// Place in the order of the list.
    fn key(&self) -> (bool, u32, u32) {
        (self.wall, self.first, self.second)
    }

    /// Adds to the impulse that both partners are given.
    #[inline(always)]
    fn push(&mut self, velocity: &mut [Vec3], inverse_mass: &[Vec3], kick: f64) {
        self.impulse += kick;
        let i = self.first as usize;
        velocity[i] += inverse_mass[i].component_mul(&self.normal) * kick;
        if !self.wall {
            let j = self.second as usize;
            velocity[j] -= inverse_mass[j].component_mul(&self.normal) * kick;
        }
    }

    /// Solves this gap against the present velocities: by how much its impulse changed, and the gap
    /// rate without it.
    #[inline(always)]
    fn visit(&mut self, law: &WholeLaw, velocity: &mut [Vec3], inverse_mass: &[Vec3], dt: f64) -> (f64, f64) {
        let mut rate = velocity[self.first as usize].dot(&self.normal) - self.wall_rate;
        if !self.wall {
            rate -= velocity[self.second as usize].dot(&self.normal);
        }
        let without = rate - self.inverse_mass * self.impulse;
        let short = self.expansion.impulse(without);
        let impulse = short.unwrap_or_else(|| law.impulse(without, dt, self.inverse_mass));
        let kick = impulse - self.impulse;
        self.push(velocity, inverse_mass, kick);
        (kick, without)
    }
}

/// Adds the explicit gap forces −κ(δ) δ̇ at the present positions and velocities to `force`.
pub(crate) fn explicit_forces(
    around: &Surroundings,
    model: &LubricationModel,
    grains: &Grains,
    velocity: &[Vec3],
    (pairs, walls): (&ContactList, &ContactList),
    t: f64,
    force: &mut [Vec3],
) {
    force.fill(Vec3::zeros());
    for i in 0..grains.len() {
        let (x, r) = (grains.position[i], grains.radius[i]);
        for k in pairs.row(i) {
            let j = pairs.other[k] as usize;
            let law = model.law(r, grains.radius[j]);
            let apart = around.periods.nearest(x - grains.position[j]);
            let distance = apart.norm();
            let gap = distance - r - grains.radius[j];
            if (0.0..=law.cut_off).contains(&gap) {
                let normal = apart / distance;
                let push = normal * (-law.resistance(gap) * (velocity[i] - velocity[j]).dot(&normal));
                force[i] += push;
                force[j] -= push;
            }
        }
        for k in walls.row(i) {
            let wall = &around.walls[walls.other[k] as usize];
            let law = model.law(r, f64::INFINITY);
            let gap = wall.gap(&x, r, t);
            if wall.acts(t) && (0.0..=law.cut_off).contains(&gap) {
                let rate = (velocity[i] - wall.velocity).dot(&wall.normal);
                force[i] += wall.normal * (-law.resistance(gap) * rate);
            }
        }
    }
}
