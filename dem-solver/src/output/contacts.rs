//! Every contact of a state with its force: what averages over grains are made of.

use crate::general::contact::{Coefficients, Frame, Kinematics, Relative, SpringStep, resolve};
use crate::grains::{Grains, Response};
use crate::laws::table::PairLaw;
use crate::motion::{Motion, Vec3};
use crate::report::GrainLoad;
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
}

impl Dem {
    /// The contacts of the present state under `loads` (none at all for a dry run); nothing changes.
    #[must_use]
    pub fn contact_list(&self, loads: &[GrainLoad]) -> Vec<Contact> {
        let mut response = Response::new(self.grains.len());
        response.set(&self.grains, &self.gravity, loads);
        let lists = self.lists_now();
        let mut found = Vec::new();
        self.collect_pairs(&lists, &response, &mut found);
        self.collect_walls(&lists, &response, &mut found);
        found
    }

    /// Law, masses and history of one contact as a force; `history` is its spring.
    fn force_of(
        &self,
        law: &PairLaw,
        radius: f64,
        frame: &Frame,
        relative: impl Fn(&[Vec3], &[Vec3]) -> Relative,
        history: Vec3,
    ) -> Vec3 {
        let Some(law) = Coefficients::of(law, frame.mass, radius, frame.gap) else { return Vec3::zeros() };
        let kinematics = Kinematics {
            velocity: &self.grains.velocity,
            spin: &self.grains.spin,
            path: None,
            dt: 0.0,
            spring: SpringStep::Before,
            t: self.time,
        };
        let mut spring = history;
        resolve(&law, frame, &kinematics, relative, &mut spring).0
    }

    fn collect_pairs(&self, lists: &Neighbours, response: &Response, found: &mut Vec<Contact>) {
        let (g, around) = (&self.grains, &self.around);
        for i in 0..g.len() {
            for k in lists.pairs.row(i) {
                let j = lists.pairs.other[k] as usize;
                let apart = around.periods.nearest(g.position[i] - g.position[j]);
                let distance = apart.norm();
                let (r, s) = (g.radius[i], g.radius[j]);
                let gap = distance - r - s;
                if gap > around.range || distance == 0.0 {
                    continue;
                }
                let normal = apart / distance;
                let law = around.laws.between(g.material[i], g.material[j]);
                let force = if let PairLaw::WanTurek(law) = law {
                    normal * law.pair_force(gap, distance)
                } else {
                    let mass = response.effective_mass(g, i, j);
                    let arms = (r + 0.5 * gap, s + 0.5 * gap);
                    let frame = Frame { normal, gap, distance, mass, arms, begins: false };
                    let relative =
                        |v: &[Vec3], w: &[Vec3]| Relative { velocity: v[i] - v[j], spin: (w[i], w[j]) };
                    self.force_of(law, r * s / (r + s), &frame, relative, lists.pairs.spring[k])
                };
                if force == Vec3::zeros() {
                    continue;
                }
                let point = g.position[i] - normal * (r + 0.5 * gap);
                let start = g.position[i] - apart;
                let contact = Contact { grain: i, force, end: g.position[i], start, point, held: false };
                let contact = match (is_free(g, i), is_free(g, j)) {
                    (true, true) => contact,
                    (true, false) => Contact { start: point, held: true, ..contact },
                    (false, true) => {
                        // seen from the other grain, where that one is
                        let (end, point) = (g.position[j], point + (g.position[j] - start));
                        Contact { grain: j, force: -force, end, start: point, point, held: true }
                    }
                    (false, false) => continue,
                };
                found.push(contact);
            }
        }
    }

    fn collect_walls(&self, lists: &Neighbours, response: &Response, found: &mut Vec<Contact>) {
        let (g, around) = (&self.grains, &self.around);
        for i in (0..g.len()).filter(|&i| is_free(g, i)) {
            for k in lists.walls.row(i) {
                let wall = &around.walls[lists.walls.other[k] as usize];
                let (r, normal) = (g.radius[i], wall.normal);
                let gap = wall.gap(&g.position[i], r, self.time);
                if !wall.acts(self.time) || gap > around.range {
                    continue;
                }
                let law = around.laws.between(g.material[i], wall.material);
                let force = if let PairLaw::WanTurek(law) = law {
                    normal * law.wall_force(gap, r)
                } else {
                    let mass = response.wall_mass(g, i);
                    let (distance, arms) = (f64::INFINITY, (r + gap, 0.0));
                    let frame = Frame { normal, gap, distance, mass, arms, begins: false };
                    let relative = |v: &[Vec3], w: &[Vec3]| Relative {
                        velocity: v[i] - wall.velocity,
                        spin: (w[i], Vec3::zeros()),
                    };
                    self.force_of(law, r, &frame, relative, lists.walls.spring[k])
                };
                if force != Vec3::zeros() {
                    let point = g.position[i] - normal * (r + gap);
                    let (end, start) = (g.position[i], point);
                    found.push(Contact { grain: i, force, end, start, point, held: true });
                }
            }
        }
    }
}

/// Is grain `i` moved by forces?
#[must_use]
pub fn is_free(grains: &Grains, i: usize) -> bool {
    grains.motion[i] == Motion::Free
}
