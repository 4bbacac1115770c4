//! Forces at one state, and the kick that follows from them.

use crate::general::bodies::BodyContacts;
use crate::general::contact::{Kinematics, SpringStep};
use crate::general::energy::Account;
use crate::general::forces::{Scene, contact_forces};
use crate::general::integrate::{Led, Speed, kick};
use crate::general::pair_lanes::PairLanes;
use crate::general::sums::Forces;
use crate::grain::Grain;
use crate::grains::{Grains, Response};
use crate::laws::walls::{Plane, Stand};
use crate::lubrication::law::LubricationModel;
use crate::lubrication::simultaneous::LubricationSolver;
use crate::motion::Vec3;
use crate::report::Observations;
use crate::search::lists::Neighbours;
use crate::spec::DemSpec;
use crate::surroundings::Surroundings;
use bedload_over_time::OverTime;

/// What the engine works on over a window.
pub(crate) struct Window<'a> {
    pub(crate) grains: &'a mut Grains,
    pub(crate) around: &'a mut Surroundings,
    pub(crate) response: &'a mut Response,
    pub(crate) observed: &'a mut Observations,
    /// Where it changes over time.
    pub(crate) gravity: Option<&'a OverTime<[f64; 3]>>,
    /// Whether loads of a fluid act.
    pub(crate) loaded: bool,
}

impl Window<'_> {
    /// Takes the mean gravity between two times, s.
    pub(super) fn fall(&mut self, from: f64, to: f64) {
        if let Some(gravity) = self.gravity {
            self.response.set_gravity(self.grains, gravity.mean(from, to).into());
        }
    }
}

/// Lists, forces and models: what one evaluation needs.
#[derive(Clone, Debug)]
pub(crate) struct Evaluation {
    pub(crate) lists: Neighbours,
    pub(crate) forces: Forces,
    /// Contacts of bodies that are not round; none where all are.
    pub(crate) bodies: Option<Box<BodyContacts>>,
    pub(crate) account: Option<Box<Account>>,
    /// Films, and the most sweeps over them in a sub-step.
    model: Option<(LubricationModel, u32)>,
    pub(super) lubrication: LubricationSolver,
    pub(super) lanes: PairLanes,
    /// Grains whose velocity is a function of time or goes with a wall that has a servo.
    pub(super) prescribed: Vec<Led>,
    wall_speed: f64,
    /// The walls at the time of the evaluation.
    stands: Vec<Stand>,
}

impl Evaluation {
    pub(super) fn new(spec: &DemSpec, grains: &Grains, around: &Surroundings) -> Self {
        let sweeps = spec.lubrication.settings().map(|settings| settings.sweeps);
        let speed = around.walls.iter().map(Plane::approach);
        let led = |(grain, of): (u32, &Grain)| {
            let wall = of.wall.filter(|wall| around.walls[*wall as usize].servo.is_some());
            (of.motion.varies() || wall.is_some()).then_some(Led { grain, wall })
        };
        Self {
            lists: Neighbours::new(around.range, spec.skin(), grains.len()),
            forces: Forces::new(grains.len(), around.walls.len()),
            bodies: BodyContacts::new(grains, &spec.outlines),
            account: spec.energy.then(Box::default),
            model: spec.lubrication_model().zip(sweeps),
            lubrication: LubricationSolver::new(spec.bulk.plain),
            lanes: PairLanes::new(spec.bulk.plain),
            prescribed: (0u32..).zip(&spec.grains).filter_map(led).collect(),
            wall_speed: speed.fold(0.0, f64::max),
            stands: Vec::with_capacity(around.walls.len()),
        }
    }

    /// Forces at the present state; springs take `dt` of the present slip.
    pub(super) fn evaluate(&mut self, window: &mut Window<'_>, t: f64, dt: f64, spring: SpringStep) {
        let Window { grains, around, response, observed, .. } = window;
        let (velocity, spin) = (&grains.velocity, &grains.spin);
        let kinematics = Kinematics { velocity, spin, path: None, dt, spring, t };
        self.evaluate_with(grains, around, response, observed, &kinematics);
    }

    /// Forces for these velocities.
    pub(super) fn evaluate_with(
        &mut self,
        grains: &Grains,
        around: &Surroundings,
        response: &Response,
        observed: &mut Observations,
        kinematics: &Kinematics<'_>,
    ) {
        let lists = (&mut self.lists.pairs, &mut self.lists.walls);
        let account = self.account.as_deref_mut();
        self.stands.clear();
        self.stands.extend(around.walls.iter().map(|wall| wall.at(kinematics.t)));
        let scene = Scene { around, grains, response, kinematics, stands: &self.stands };
        contact_forces(&scene, lists, &mut self.lanes, &mut self.forces, observed, account);
        if let Some(bodies) = &mut self.bodies {
            bodies.add_forces(&scene, &self.lists, &mut self.forces, observed);
        }
    }

    /// Walls with a servo take the present forces, of time `t`, for the next `dt`.
    pub(super) fn follow(&mut self, around: &mut Surroundings, t: f64, dt: f64) {
        let Forces { walls: forces, contact, .. } = &mut self.forces;
        for led in &self.prescribed {
            if let Some(wall) = led.wall {
                forces[wall as usize] += contact[led.grain as usize];
            }
        }
        around.walls.iter_mut().zip(forces).for_each(|(wall, force)| wall.follow(*force, t, dt));
    }

    /// v ← v + h (a + W F) for the present forces.
    pub(super) fn kick(&mut self, h: f64, grains: &mut Grains, response: &Response) -> Speed {
        if let Some(account) = &mut self.account {
            account.before_kick(grains);
        }
        let speed = self.push(h, (&mut grains.velocity, &mut grains.spin), response);
        if let Some(account) = &mut self.account {
            account.after_kick(h, grains);
        }
        speed
    }

    /// The same for any velocities and spins.
    pub(super) fn push(&self, h: f64, motion: (&mut [Vec3], &mut [Vec3]), response: &Response) -> Speed {
        kick(h, motion, response, &self.forces.contact, &self.forces.torque)
    }

    /// Builds the lists again if a grain may leave them within `dt`. Lubrication only slows a pair down,
    /// but passes momentum on: a grain may gain up to √2 of the largest speed.
    pub(super) fn refresh(&mut self, speed: &Speed, grains: &Grains, around: &Surroundings, t: f64, dt: f64) {
        if speed.finite {
            let step = 1.5 * dt * speed.largest2.sqrt().max(self.wall_speed);
            let built = self.lists.refresh(step, grains, &around.walls, &around.periods, t);
            if built {
                self.lanes.take(&self.lists.pairs, grains);
            }
            if let (true, Some((model, _))) = (built, &self.model) {
                self.lubrication.take(around, model, grains, (&self.lists.pairs, &self.lists.walls));
            }
        }
    }

    /// Lubrication over `dt`.
    pub(super) fn lubricate(&mut self, window: &mut Window<'_>, t: f64, dt: f64) {
        if let Some((model, sweeps)) = self.model {
            let Window { grains, around, response, observed, .. } = window;
            let force = &mut self.forces.lubrication;
            self.lubrication.apply(around, (&model, sweeps), grains, response, (t, dt), force);
            for (mean, force) in observed.mean_lubrication.iter_mut().zip(&*force) {
                *mean += *force;
            }
            for (mean, force) in observed.wall_lubrication.iter_mut().zip(&self.lubrication.on_walls) {
                *mean += *force;
            }
            observed.split.add_lubrication(force);
        }
    }

    /// Adds the present contact forces to the window's means with a weight in sub-steps.
    pub(super) fn tally(&self, observed: &mut Observations, weight: f64) {
        for (mean, force) in observed.mean_contact.iter_mut().zip(&self.forces.contact) {
            *mean += force * weight;
        }
        for (mean, force) in observed.wall_contact.iter_mut().zip(&self.forces.walls) {
            *mean += force * weight;
        }
        observed.split.add_contact(&self.forces.contact, weight);
    }

    /// Sets the velocities that are functions of time.
    pub(super) fn set_prescribed(&self, grains: &mut Grains, walls: &[Plane], t: f64) {
        for led in &self.prescribed {
            led.set(grains, walls, |motion| motion.velocity_at(t));
        }
    }
}
