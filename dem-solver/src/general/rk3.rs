//! One sub-step of Runge–Kutta, third order (Shu & Osher 1988): y₁ = y + dt f(y),
//! y₂ = ¾ y + ¼ (y₁ + dt f(y₁)), y′ = ⅓ y + ⅔ (y₂ + dt f(y₂)), over positions, velocities, spins and
//! tangential springs. Orientations turn by the weighted spin (1, 1, 4)/6, third order about a fixed
//! axis; spheres do not feel theirs.

use crate::Vec3;
use crate::general::forces::SpringStep;
use crate::general::integrate::{Speed, kick, rotate};
use crate::general::lists::ContactList;
use crate::solver::Dem;

/// The state at the start of the sub-step, and the spin for the orientations.
#[derive(Clone, Debug, Default)]
pub struct Start {
    position: Vec<Vec3>,
    velocity: Vec<Vec3>,
    spin: Vec<Vec3>,
    pair_spring: Vec<Vec3>,
    wall_spring: Vec<Vec3>,
    pair_rolling: Vec<Vec3>,
    wall_rolling: Vec<Vec3>,
    mean_spin: Vec<Vec3>,
}

impl Start {
    fn take(&mut self, dem: &Dem) {
        self.position.clone_from(&dem.grains.position);
        self.velocity.clone_from(&dem.grains.velocity);
        self.spin.clone_from(&dem.grains.spin);
        self.pair_spring.clone_from(&dem.lists.pairs.spring);
        self.wall_spring.clone_from(&dem.lists.walls.spring);
        self.pair_rolling.clone_from(&dem.lists.pairs.rolling);
        self.wall_rolling.clone_from(&dem.lists.walls.rolling);
        self.mean_spin.clear();
        self.mean_spin.resize(dem.grains.len(), Vec3::zeros());
    }
}

/// Time of each stage, weight of the old state, weight of the stage's slope in the whole step.
const STAGES: [(f64, f64, f64); 3] =
    [(0.0, 0.0, 1.0 / 6.0), (1.0, 0.75, 1.0 / 6.0), (0.5, 1.0 / 3.0, 2.0 / 3.0)];

/// Advances all grains by `dt` from time `t`; returns the speed at the end.
pub fn substep(dem: &mut Dem, t: f64, dt: f64) -> Speed {
    let mut start = std::mem::take(&mut dem.rk3);
    start.take(dem);
    let mut speed = Speed { largest2: 0.0, finite: true };
    for (at, old, share) in STAGES {
        let time = t + at * dt;
        dem.set_prescribed(time);
        dem.evaluate(time, dt, SpringStep::After);
        dem.tally(share);
        for i in 0..dem.grains.len() {
            start.mean_spin[i] += dem.grains.spin[i] * share;
            dem.grains.position[i] += dem.grains.velocity[i] * dt;
        }
        let film = dem.film_is_explicit().then_some(&dem.forces.film[..]);
        speed = kick(dt, &mut dem.grains, &dem.response, &dem.forces.contact, &dem.forces.torque, film);
        blend(&mut dem.grains.position, &start.position, old);
        blend(&mut dem.grains.velocity, &start.velocity, old);
        blend(&mut dem.grains.spin, &start.spin, old);
        blend(&mut dem.lists.pairs.spring, &start.pair_spring, old);
        blend(&mut dem.lists.walls.spring, &start.wall_spring, old);
        blend(&mut dem.lists.pairs.rolling, &start.pair_rolling, old);
        blend(&mut dem.lists.walls.rolling, &start.wall_rolling, old);
    }
    forget(&mut dem.lists.pairs);
    forget(&mut dem.lists.walls);
    dem.set_prescribed(t + dt);
    for i in 0..dem.grains.len() {
        rotate(&mut dem.grains.orientation[i], &start.mean_spin[i], dt);
    }
    dem.rk3 = start;
    speed
}

/// A contact that ended within the sub-step keeps no share of its old spring.
fn forget(list: &mut ContactList) {
    for ((spring, rolling), touching) in list.spring.iter_mut().zip(&mut list.rolling).zip(&list.touching) {
        if !touching {
            *spring = Vec3::zeros();
            *rolling = Vec3::zeros();
        }
    }
}

/// new ← old_weight · old + (1 − old_weight) · new.
fn blend(new: &mut [Vec3], old: &[Vec3], old_weight: f64) {
    if old_weight > 0.0 {
        for (new, old) in new.iter_mut().zip(old) {
            *new = old * old_weight + *new * (1.0 - old_weight);
        }
    }
}
