//! Windows of sub-steps under constant loads, with all laws, lubrication and integrators.
//!
//! One sub-step, symplectic Euler, from top to bottom:
//!
//! 1. contact forces at xⁿ, vⁿ, springs take dt vⁿ (eqs 11–16);
//! 2. kick: gravity, fluid, virtual mass, contact; in beds the drag that changes within the window;
//! 3. neighbour lists, if the grains may outrun them in this sub-step;
//! 4. lubrication: implicit impulses over the path of the sub-step (eq. 19);
//! 5. drift: positions and orientations with the new velocities.
//!
//! Verlet starts with half a kick, evaluates contacts after the drift (springs along the half-step
//! velocity, dashpots at the predicted full-step one) and ends with the other half.

use crate::general::bodies::gap_between;
use crate::general::contact::{Kinematics, SpringStep};
use crate::general::evaluation::{Evaluation, Window};
use crate::general::integrate::{Speed, drift};
use crate::general::rk3::Rk3;
use crate::general::sums::Forces;
use crate::general::window_drag::WindowDrag;
use crate::grains::Grains;
use crate::motion::Vec3;
use crate::report::Outcome;
use crate::search::lists::Neighbours;
use crate::spec::{DemSpec, Integrator};
use crate::surroundings::Surroundings;

/// Up to this number of grains the gaps at the end of a window are exact at any distance.
pub(crate) const EXACT_GAPS: usize = 64;

#[derive(Clone, Debug)]
pub(crate) struct General {
    pub(crate) evaluation: Evaluation,
    integrator: Integrator,
    contact_step: f64,
    rk3: Rk3,
    /// Velocities and spins at the start of the window.
    start: (Vec<Vec3>, Vec<Vec3>),
    /// Velocities and spins predicted for the end of a Verlet step.
    ahead: (Vec<Vec3>, Vec<Vec3>),
    window_drag: Option<WindowDrag>,
}

impl General {
    /// The engine for a checked spec.
    pub(crate) fn new(spec: &DemSpec, grains: &Grains, around: &Surroundings) -> Self {
        let zeros = |n| (vec![Vec3::zeros(); n], vec![Vec3::zeros(); n]);
        let verlet = spec.integrator == Integrator::VelocityVerlet;
        Self {
            evaluation: Evaluation::new(spec, grains, around),
            integrator: spec.integrator,
            contact_step: spec.contact_step,
            rk3: Rk3::default(),
            start: zeros(grains.len()),
            ahead: zeros(if verlet { grains.len() } else { 0 }),
            window_drag: WindowDrag::of(spec),
        }
    }

    /// `n_sub` sub-steps of `dt` from `time` on.
    pub(crate) fn advance(&mut self, window: &mut Window<'_>, time: f64, dt: f64, n_sub: u32) -> Outcome {
        self.start.0.copy_from_slice(&window.grains.velocity);
        self.start.1.copy_from_slice(&window.grains.spin);
        if let Some(drag) = &mut self.window_drag {
            drag.window = if window.loaded { dt * f64::from(n_sub) } else { 0.0 };
        }
        window.observed.begin(window.around.walls.len());
        window.observed.split.begin(&window.grains.velocity);
        self.evaluation.lubrication.forget();
        self.evaluation.forces.overlap = 0.0;
        let speed = Speed::of(window.grains);
        // the first evaluation comes before the first kick: the lists must be good here
        self.evaluation.refresh(&speed, window.grains, window.around, time, 0.0);
        let mut outcome = Outcome { done: 0, finite: true };
        if self.integrator == Integrator::VelocityVerlet {
            // the springs stay
            self.evaluation.evaluate(window, time, 0.0, SpringStep::Before);
        }
        while outcome.done < n_sub && outcome.finite {
            let speed = self.substep(window, time + f64::from(outcome.done) * dt, dt);
            let flight = n_sub == 1 && (window.loaded || dt > self.contact_step * (1.0 + 1e-9));
            if flight && self.integrator == Integrator::SymplecticEuler {
                self.centre_flights(window, time, dt);
            }
            let end = time + f64::from(outcome.done + 1) * dt;
            let now = (&window.grains.position[..], &window.grains.velocity[..]);
            window.observed.split.end_substep(now, outcome.done, end, dt);
            outcome.finite = speed.finite;
            outcome.done += 1;
        }
        outcome
    }

    /// A window of one sub-step where nothing was to touch: grains that touched nothing have moved with their
    /// mean velocity, as in a window of many, not with the last one; with a gravity that changes, along
    /// their exact path.
    fn centre_flights(&self, window: &mut Window<'_>, time: f64, dt: f64) {
        let Window { grains, response, gravity, .. } = window;
        let lead = gravity.map_or(Vec3::zeros(), |gravity| gravity.lead(time, time + dt).into());
        let Forces { contact, lubrication, .. } = &self.evaluation.forces;
        for i in 0..grains.len() {
            if grains.responds(i) && contact[i] == Vec3::zeros() && lubrication[i] == Vec3::zeros() {
                let falls = response.fall(grains, i, &lead);
                grains.position[i] += falls - (grains.velocity[i] - self.start.0[i]) * (0.5 * dt);
            }
        }
    }

    /// One sub-step from `t` to `t + dt`.
    fn substep(&mut self, window: &mut Window<'_>, t: f64, dt: f64) -> Speed {
        let Self { evaluation, integrator, rk3, .. } = self;
        match integrator {
            Integrator::SymplecticEuler => {
                evaluation.evaluate(window, t, dt, SpringStep::Before);
                evaluation.tally(window.observed, 1.0);
                evaluation.follow(window.around, t, dt);
                self.kick_and_drift(window, t, dt, dt)
            }
            Integrator::VelocityVerlet => {
                evaluation.tally(window.observed, 0.5);
                self.kick_and_drift(window, t, dt, 0.5 * dt);
                window.fall(t + 0.5 * dt, t + dt);
                self.evaluate_ahead(window, t + dt, dt);
                self.evaluation.tally(window.observed, 0.5);
                self.evaluation.follow(window.around, t + dt, dt);
                self.evaluation.kick(0.5 * dt, window.grains, window.response)
            }
            Integrator::Rk3 => {
                let speed = Speed::of(window.grains);
                evaluation.refresh(&speed, window.grains, window.around, t, 2.0 * dt);
                rk3.substep(evaluation, window, t, dt)
            }
        }
    }

    /// Kick of `h`, lists, lubrication and drift of `dt`.
    fn kick_and_drift(&mut self, window: &mut Window<'_>, t: f64, dt: f64, h: f64) -> Speed {
        let Self { evaluation, window_drag, start, .. } = self;
        window.fall(t, t + h);
        let speed = evaluation.kick(h, window.grains, window.response);
        if let Some(drag) = window_drag {
            drag.act(dt, window.grains, window.response, &evaluation.lists, (&start.0, &start.1));
        }
        evaluation.refresh(&speed, window.grains, window.around, t, dt);
        evaluation.lubricate(window, t, dt);
        drift(dt, t, window.grains, (&evaluation.prescribed, &window.around.walls));
        evaluation.set_prescribed(window.grains, &window.around.walls, t + dt);
        speed
    }

    /// Forces after a Verlet drift: springs take the half-step velocity, dashpots see the velocity
    /// predicted for the full step, without which they would be first order.
    fn evaluate_ahead(&mut self, window: &mut Window<'_>, t: f64, dt: f64) {
        let Window { grains, around, response, observed, .. } = window;
        self.ahead.0.copy_from_slice(&grains.velocity);
        self.ahead.1.copy_from_slice(&grains.spin);
        self.evaluation.push(0.5 * dt, (&mut self.ahead.0, &mut self.ahead.1), response);
        let path = Some((&grains.velocity[..], &grains.spin[..]));
        let (velocity, spin) = (&self.ahead.0[..], &self.ahead.1[..]);
        let kinematics = Kinematics { velocity, spin, path, dt, spring: SpringStep::Before, t };
        self.evaluation.evaluate_with(grains, around, response, observed, &kinematics);
    }

    /// A_prev and means of the window.
    pub(crate) fn finish(&mut self, window: &mut Window<'_>, dt_window: f64, n_sub: u32) {
        let Window { grains, observed, .. } = window;
        self.evaluation.lanes.finish(observed);
        let each = 1.0 / f64::from(n_sub);
        for i in 0..grains.len() {
            grains.acceleration[i] = (grains.velocity[i] - self.start.0[i]) / dt_window;
            grains.spin_acceleration[i] = (grains.spin[i] - self.start.1[i]) / dt_window;
            observed.mean_contact[i] *= each;
            observed.mean_lubrication[i] *= each;
        }
        for wall in observed.wall_contact.iter_mut().chain(&mut observed.wall_lubrication) {
            *wall *= each;
        }
    }

    /// Gaps between grains at the end of a window.
    pub(crate) fn observe_gaps(&mut self, window: &mut Window<'_>) {
        let Window { grains, around, observed, .. } = window;
        if let Some(bodies) = &mut self.evaluation.bodies {
            bodies.placed.place(grains);
        }
        let bodies = self.evaluation.bodies.as_deref();
        let range = if grains.len() <= EXACT_GAPS { f64::INFINITY } else { around.range };
        let mut observe = |i: usize, j: usize| {
            let least = observed.gap_end[i].max(observed.gap_end[j]);
            let gap = gap_between((grains, bodies), &around.periods, [i, j], least);
            if gap <= range {
                observed.gap_end[i] = observed.gap_end[i].min(gap);
                observed.gap_end[j] = observed.gap_end[j].min(gap);
            }
        };
        if range.is_infinite() {
            (0..grains.len()).for_each(|i| (i + 1..grains.len()).for_each(|j| observe(i, j)));
        } else {
            let Neighbours { pairs, body_pairs, .. } = &self.evaluation.lists;
            pairs.entries().for_each(|(i, k)| observe(i, pairs.other[k] as usize));
            body_pairs.iter().for_each(|[i, j]| observe(*i as usize, *j as usize));
        }
    }
}
