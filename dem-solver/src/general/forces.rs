//! Contact forces and torques on all grains (the seed, eqs 11–16): the loops over pairs and walls.

use crate::general::contact::{Coefficients, Frame, Kinematics, Relative, path_of, resolve, roll_torque};
use crate::general::energy::{Account, Entry};
use crate::grains::{Grains, Response};
use crate::laws::rolling::Roll;
use crate::laws::table::PairLaw;
use crate::motion::Vec3;
use crate::report::Observations;
use crate::search::contact_list::ContactList;
use crate::surroundings::Surroundings;

/// Forces and torques on the grains.
#[derive(Clone, Debug, Default)]
pub(crate) struct Forces {
    /// Contact forces, N.
    pub contact: Vec<Vec3>,
    /// Contact torques, N m.
    pub torque: Vec<Vec3>,
    /// Lubrication forces, N.
    pub lubrication: Vec<Vec3>,
    /// Contacts that bear a force.
    pub contacts: usize,
    /// Largest overlap met, m.
    pub overlap: f64,
}

impl Forces {
    /// Room for `n` grains.
    pub(crate) fn new(n: usize) -> Self {
        Self {
            contact: vec![Vec3::zeros(); n],
            torque: vec![Vec3::zeros(); n],
            lubrication: vec![Vec3::zeros(); n],
            contacts: 0,
            overlap: 0.0,
        }
    }
}

/// Contact forces of all pairs and walls; springs take their step on the way, and an account what it needs.
pub(crate) fn contact_forces(
    around: &Surroundings,
    grains: &Grains,
    response: &Response,
    kinematics: &Kinematics<'_>,
    (pairs, walls): (&mut ContactList, &mut ContactList),
    forces: &mut Forces,
    observed: &mut Observations,
    mut account: Option<&mut Account>,
) {
    if let Some(account) = &mut account {
        account.clear();
    }
    forces.contact.fill(Vec3::zeros());
    forces.torque.fill(Vec3::zeros());
    forces.contacts = 0;
    pair_forces(around, grains, response, kinematics, pairs, forces, observed, account.as_deref_mut());
    wall_forces(around, grains, response, kinematics, walls, forces, observed, account);
}

fn pair_forces(
    around: &Surroundings,
    grains: &Grains,
    response: &Response,
    kinematics: &Kinematics<'_>,
    list: &mut ContactList,
    forces: &mut Forces,
    observed: &mut Observations,
    mut account: Option<&mut Account>,
) {
    for i in 0..grains.len() {
        let (x, r) = (grains.position[i], grains.radius[i]);
        for k in list.row(i) {
            let j = list.other[k] as usize;
            let apart = around.periods.nearest(x - grains.position[j]);
            let reach = r + grains.radius[j] + around.range;
            let distance2 = apart.norm_squared();
            if distance2 > reach * reach && !list.touching[k] {
                continue;
            }
            let distance = distance2.sqrt();
            let gap = distance - r - grains.radius[j];
            note_gap(observed, forces, i, gap);
            observed.smallest_gap[j] = observed.smallest_gap[j].min(gap);
            let law = around.laws.between(grains.material[i], grains.material[j]);
            let wide = matches!(law, PairLaw::WanTurek(_));
            if gap >= 0.0 && !list.touching[k] && !wide {
                continue;
            }
            let relative = |velocity: &[Vec3], spin: &[Vec3]| Relative {
                velocity: velocity[i] - velocity[j],
                spin: (spin[i], spin[j]),
            };
            let normal = if distance > 0.0 { apart / distance } else { Vec3::z() };
            if let PairLaw::WanTurek(law) = law {
                let size = law.pair_force(gap, distance);
                forces.contact[i] += normal * size;
                forces.contact[j] -= normal * size;
                let rate = (kinematics.velocity[i] - kinematics.velocity[j]).dot(&normal);
                note_event(&mut list.touching[k], size > 0.0, rate, observed, i, Some(j));
                forces.contacts += usize::from(size > 0.0);
                continue;
            }
            let mass = response.effective_mass(grains, i, j);
            let radius = r * grains.radius[j] / (r + grains.radius[j]);
            let Some(law) = Coefficients::of(law, mass, radius, gap) else { continue };
            let half = if law.pair.at_contact_point { 0.5 * gap } else { 0.0 };
            let arms = (r + half, grains.radius[j] + half);
            let frame = Frame { normal, gap, distance, mass, arms, begins: !list.touching[k] };
            let old = list.spring[k];
            let (force, tangential, rate) = resolve(&law, &frame, kinematics, relative, &mut list.spring[k]);
            if let Some(account) = account.as_deref_mut() {
                let path = path_of(&frame, kinematics, relative, old);
                let (pair, wall, spring) = (&law.pair, Vec3::zeros(), list.spring[k]);
                let (first, second, force) = (i, Some(j), (force, tangential));
                account.enter(&Entry { first, second, wall, frame: &frame, law: pair, path, spring, force });
            }
            let bears = force != Vec3::zeros();
            note_event(&mut list.touching[k], bears, rate, observed, i, Some(j));
            forces.contacts += usize::from(bears);
            forces.contact[i] += force;
            forces.contact[j] -= force;
            let moment = tangential.cross(&normal);
            forces.torque[i] += moment * frame.arms.0;
            forces.torque[j] += moment * frame.arms.1;
            if let Some(rolls) = around.laws.rolling(grains.material[i], grains.material[j]) {
                let inertia = rolling_inertia(grains, response, i, Some(j));
                let force = (force - tangential).dot(&normal);
                let roll = Roll { normal, force, stiffness: law.pair.stiffness * mass, radius, inertia };
                let torque = roll_torque(rolls, &roll, &frame, kinematics, relative, &mut list.rolling[k]);
                forces.torque[i] += torque;
                forces.torque[j] -= torque;
            }
        }
    }
}

fn wall_forces(
    around: &Surroundings,
    grains: &Grains,
    response: &Response,
    kinematics: &Kinematics<'_>,
    list: &mut ContactList,
    forces: &mut Forces,
    observed: &mut Observations,
    mut account: Option<&mut Account>,
) {
    for i in 0..grains.len() {
        let r = grains.radius[i];
        for k in list.row(i) {
            let wall = &around.walls[list.other[k] as usize];
            if !wall.acts(kinematics.t) {
                list.touching[k] = false;
                list.spring[k] = Vec3::zeros();
                list.rolling[k] = Vec3::zeros();
                continue;
            }
            let gap = wall.gap(&grains.position[i], r, kinematics.t);
            if gap > around.range && !list.touching[k] {
                continue;
            }
            note_gap(observed, forces, i, gap);
            let relative = |velocity: &[Vec3], spin: &[Vec3]| Relative {
                velocity: velocity[i] - wall.velocity,
                spin: (spin[i], Vec3::zeros()),
            };
            let law = around.laws.between(grains.material[i], wall.material);
            if let PairLaw::WanTurek(law) = law {
                let size = law.wall_force(gap, r);
                forces.contact[i] += wall.normal * size;
                let rate = (kinematics.velocity[i] - wall.velocity).dot(&wall.normal);
                note_event(&mut list.touching[k], size > 0.0, rate, observed, i, None);
                forces.contacts += usize::from(size > 0.0);
                continue;
            }
            if gap >= 0.0 && !list.touching[k] {
                continue;
            }
            let mass = response.wall_mass(grains, i);
            let Some(law) = Coefficients::of(law, mass, r, gap) else { continue };
            // the wall does not yield: the force attacks in its plane, R + δ from the centre
            let arm = if law.pair.at_contact_point { r + gap } else { r };
            let begins = !list.touching[k];
            let (normal, distance, arms) = (wall.normal, f64::INFINITY, (arm, 0.0));
            let frame = Frame { normal, gap, distance, mass, arms, begins };
            let old = list.spring[k];
            let (force, tangential, rate) = resolve(&law, &frame, kinematics, relative, &mut list.spring[k]);
            if let Some(account) = account.as_deref_mut() {
                let path = path_of(&frame, kinematics, relative, old);
                let (pair, spring) = (&law.pair, list.spring[k]);
                let (first, second, wall, force) = (i, None, wall.velocity, (force, tangential));
                account.enter(&Entry { first, second, wall, frame: &frame, law: pair, path, spring, force });
            }
            let bears = force != Vec3::zeros();
            note_event(&mut list.touching[k], bears, rate, observed, i, None);
            forces.contacts += usize::from(bears);
            forces.contact[i] += force;
            forces.torque[i] += tangential.cross(&wall.normal) * arm;
            if let Some(rolls) = around.laws.rolling(grains.material[i], wall.material) {
                let inertia = rolling_inertia(grains, response, i, None);
                let force = (force - tangential).dot(&wall.normal);
                let stiffness = law.pair.stiffness * mass;
                let roll = Roll { normal: wall.normal, force, stiffness, radius: r, inertia };
                forces.torque[i] +=
                    roll_torque(rolls, &roll, &frame, kinematics, relative, &mut list.rolling[k]);
            }
        }
    }
}

/// I_r: 1/I_r = Σ 1/(I + m R²) over the partners that can move (Ai et al. 2011); walls and held grains
/// are infinitely heavy.
#[inline(always)]
fn rolling_inertia(grains: &Grains, response: &Response, i: usize, j: Option<usize>) -> f64 {
    let inverse = |g: usize| {
        let moves = response.contact_inverse_mass[g] > 0.0 || grains.responds(g);
        let inertia = grains.inertia[g] + grains.mass[g] * grains.radius[g] * grains.radius[g];
        if moves { 1.0 / inertia } else { 0.0 }
    };
    1.0 / (inverse(i) + j.map_or(0.0, inverse))
}

/// Records the gap of grain `i`.
#[inline(always)]
fn note_gap(observed: &mut Observations, forces: &mut Forces, i: usize, gap: f64) {
    observed.smallest_gap[i] = observed.smallest_gap[i].min(gap);
    forces.overlap = forces.overlap.max(-gap);
}

/// Records the beginning and the end of a contact, with the normal speed at that moment.
#[inline(always)]
fn note_event(
    touching: &mut bool,
    bears: bool,
    rate: f64,
    observed: &mut Observations,
    i: usize,
    j: Option<usize>,
) {
    if *touching == bears {
        return;
    }
    *touching = bears;
    let speeds = if bears { &mut observed.impact_speed } else { &mut observed.rebound_speed };
    let speed = if bears { -rate } else { rate };
    speeds[i] = speed.max(0.0);
    if let Some(j) = j {
        speeds[j] = speed.max(0.0);
    }
}
