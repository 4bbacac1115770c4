//! One sub-step of Runge–Kutta, third order (Shu & Osher 1988): y₁ = y + dt f(y),
//! y₂ = ¾ y + ¼ (y₁ + dt f(y₁)), y′ = ⅓ y + ⅔ (y₂ + dt f(y₂)), over positions, velocities, spins and
//! tangential springs. Orientations turn by the weighted spin (1, 1, 4)/6, third order about a fixed
//! axis; spheres do not feel theirs.

use crate::general::contact::SpringStep;
use crate::general::evaluation::{Evaluation, Window};
use crate::general::integrate::Speed;
use crate::grains::Grains;
use crate::motion::{Vec3, rotate};
use crate::search::contact_list::ContactList;
use crate::search::lists::Neighbours;

/// The state at the start of the sub-step, and the spin for the orientations.
#[derive(Clone, Debug, Default)]
pub(super) struct Rk3 {
    start: [Vec<Vec3>; 7],
    mean_spin: Vec<Vec3>,
}

/// What the method integrates.
fn integrated<'a>(grains: &'a mut Grains, lists: &'a mut Neighbours) -> [&'a mut Vec<Vec3>; 7] {
    let (Grains { position, velocity, spin, .. }, Neighbours { pairs, walls, .. }) = (grains, lists);
    [position, velocity, spin, &mut pairs.spring, &mut walls.spring, &mut pairs.rolling, &mut walls.rolling]
}

/// Time of each stage, weight of the old state, weight of the stage's slope in the whole step.
const STAGES: [(f64, f64, f64); 3] =
    [(0.0, 0.0, 1.0 / 6.0), (1.0, 0.75, 1.0 / 6.0), (0.5, 1.0 / 3.0, 2.0 / 3.0)];

impl Rk3 {
    /// Advances all grains by `dt` from time `t`; returns the speed at the end.
    pub(super) fn substep(
        &mut self,
        evaluation: &mut Evaluation,
        window: &mut Window<'_>,
        t: f64,
        dt: f64,
    ) -> Speed {
        let now = integrated(window.grains, &mut evaluation.lists);
        self.start.iter_mut().zip(now).for_each(|(start, now)| start.clone_from(now));
        self.mean_spin.clear();
        self.mean_spin.resize(window.grains.len(), Vec3::zeros());
        let mut speed = Speed { largest2: 0.0, finite: true };
        for (at, old, weight) in STAGES {
            let time = t + at * dt;
            evaluation.set_prescribed(window.grains, &window.around.walls, time);
            window.fall(time, time);
            evaluation.evaluate(window, time, dt, SpringStep::After);
            evaluation.tally(window.observed, weight);
            let grains = &mut *window.grains;
            for i in 0..grains.len() {
                self.mean_spin[i] += grains.spin[i] * weight;
                grains.position[i] += grains.velocity[i] * dt;
            }
            speed = evaluation.kick(dt, grains, window.response);
            let now = integrated(grains, &mut evaluation.lists);
            now.into_iter().zip(&self.start).for_each(|(now, start)| blend(now, start, old));
        }
        forget(&mut evaluation.lists.pairs);
        forget(&mut evaluation.lists.walls);
        evaluation.set_prescribed(window.grains, &window.around.walls, t + dt);
        for (orientation, spin) in window.grains.orientation.iter_mut().zip(&self.mean_spin) {
            rotate(orientation, spin, dt);
        }
        speed
    }
}

/// A contact that ended within the sub-step keeps nothing of its old spring.
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
