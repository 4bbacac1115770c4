//! Every contact of a state with its force: what averages over grains are made of.

use crate::general::contact::{Frame, Kinematics, Near, SpringStep, resolve};
use crate::general::forces::Scene;
use crate::grains::{Grains, Response};
use crate::laws::table::PairLaw;
use crate::laws::walls::Stand;
use crate::motion::{Motion, Vec3};
use crate::report::GrainLoad;
use crate::search::contact_list::ContactList;
use crate::search::lists::Neighbours;
use crate::solver::Dem;

/// One contact that bears a force, seen from a free grain.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contact {
    /// The free grain.
    pub grain: usize,
    /// Force on it, N (per unit length for discs).
    pub force: Vec3,
    /// Its centre, m.
    pub end: Vec3,
    /// Centre of the other grain (its nearest image) if that is free too, else the point of contact:
    /// stress lives in the grains that flow (Weinhart et al. 2012).
    pub start: Vec3,
    /// Point of contact, m.
    pub point: Vec3,
    /// Is the other one a wall or a held grain?
    pub held: bool,
    /// Number of the wall, if it is one.
    pub wall: Option<usize>,
}

impl Dem {
    /// The contacts of the present state under `loads` (none at all for a dry run); nothing changes.
    #[must_use]
    pub fn contact_list(&self, loads: &[GrainLoad]) -> Vec<Contact> {
        let (g, lists) = (&self.grains, self.lists_now());
        let response = Response::new(g, &self.gravity.at(self.time).into(), loads);
        let pairs =
            lists.pairs.entries().filter_map(|(i, k)| self.between_grains(i, k, &lists.pairs, &response));
        let walls = lists.walls.entries().filter(|&(i, _)| is_free(g, i));
        let mut all: Vec<Contact> =
            pairs.chain(walls.filter_map(|(i, k)| self.at_wall(i, k, &lists.walls, &response))).collect();
        self.of_bodies(&lists, &response, &mut all);
        all
    }

    /// The points of contact of bodies that are not round.
    fn of_bodies(&self, lists: &Neighbours, response: &Response, all: &mut Vec<Contact>) {
        let Some(mut bodies) = self.bodies_now() else { return };
        let (g, around) = (&self.grains, &self.around);
        let (velocity, spin) = (&g.velocity, &g.spin);
        let (dt, t, step) = (0.0, self.time, SpringStep::Before);
        let kinematics = Kinematics { velocity, spin, path: None, dt, spring: step, t };
        let stands: Vec<Stand> = around.walls.iter().map(|wall| wall.at(t)).collect();
        let scene = Scene { around, grains: g, response, kinematics: &kinematics, stands: &stands };
        let space = |[x, z]: [f64; 2]| Vec3::new(x, 0.0, z);
        bodies.bearing(&scene, lists, |place, force| {
            let (i, force, end) = (place.first, space(force), g.position[place.first]);
            let (arm, far) = (space(place.arms.0), space(place.arms.1));
            let point = end + arm;
            let contact = Contact { grain: i, force, end, start: point, point, held: true, wall: None };
            match place.second.map(|j| (j, is_free(g, j))) {
                Some((_, true)) if is_free(g, i) => {
                    all.push(Contact { start: point - far, held: false, ..contact });
                }
                Some((j, true)) => {
                    let (end, point) = (g.position[j], g.position[j] + far);
                    all.push(Contact { grain: j, force: -force, end, point, start: point, ..contact });
                }
                _ if is_free(g, i) => all.push(Contact { wall: place.wall.map(|(wall, _)| wall), ..contact }),
                _ => {}
            }
        });
    }

    /// Force on the first partner, N, if there is one; `spring` is what the contact remembers.
    fn force(&self, near: &Near, response: &Response, mut spring: Vec3) -> Option<Vec3> {
        let (g, partners) = (&self.grains, &near.partners);
        let force = match &self.around.law {
            PairLaw::WanTurek(law) => near.normal * near.repulsion(law, g),
            law => {
                let mass = response.effective_mass(g, partners.first, partners.second);
                let frame = Frame { near: *near, mass, arms: near.arms(g), begins: false };
                let law = law.at(mass)?;
                let (velocity, spin) = (&g.velocity, &g.spin);
                let (dt, t, step) = (0.0, self.time, SpringStep::Before);
                let kinematics = Kinematics { velocity, spin, path: None, dt, spring: step, t };
                resolve(&law, &frame, &kinematics, &mut spring).0
            }
        };
        (force != Vec3::zeros()).then_some(force)
    }

    /// Entry `k` of the pairs, of grain `i`.
    fn between_grains(
        &self,
        i: usize,
        k: usize,
        pairs: &ContactList,
        response: &Response,
    ) -> Option<Contact> {
        let (g, j) = (&self.grains, pairs.other[k] as usize);
        let apart = self.around.periods.nearest(g.position[i] - g.position[j]);
        let distance = apart.norm();
        let gap = distance - g.radius[i] - g.radius[j];
        if gap > self.around.range || distance == 0.0 {
            return None;
        }
        let near = Near::grains(i, j, &apart, distance, gap);
        let force = self.force(&near, response, pairs.spring[k])?;
        let point = g.position[i] - near.normal * (g.radius[i] + 0.5 * gap);
        let start = g.position[i] - apart;
        let contact = Contact { grain: i, force, end: g.position[i], start, point, held: false, wall: None };
        match (is_free(g, i), is_free(g, j)) {
            (true, true) => Some(contact),
            (true, false) => Some(Contact { start: point, held: true, ..contact }),
            (false, true) => {
                // seen from the other grain, where that one is
                let (end, point) = (g.position[j], point + (g.position[j] - start));
                Some(Contact { grain: j, force: -force, end, start: point, point, held: true, wall: None })
            }
            (false, false) => None,
        }
    }

    /// Entry `k` of the grains at walls, of grain `i`.
    fn at_wall(&self, i: usize, k: usize, walls: &ContactList, response: &Response) -> Option<Contact> {
        let number = walls.other[k] as usize;
        let (g, wall) = (&self.grains, &self.around.walls[number]);
        let stand = wall.at(self.time);
        let gap = stand.gap(&g.position[i], g.radius[i]);
        if !wall.acts(self.time) || gap > self.around.range {
            return None;
        }
        let (end, point) = (g.position[i], g.position[i] - stand.normal * (g.radius[i] + gap));
        let force = self.force(&Near::wall(i, &stand, gap, &point), response, walls.spring[k])?;
        Some(Contact { grain: i, force, end, start: point, point, held: true, wall: Some(number) })
    }
}

/// Is grain `i` moved by forces?
#[must_use]
pub fn is_free(grains: &Grains, i: usize) -> bool {
    grains.motion[i] == Motion::Free
}
