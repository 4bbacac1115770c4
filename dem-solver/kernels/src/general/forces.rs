//! Contact forces and torques on all grains (Izard et al. 2014, eqs 11–16): the loops over pairs and walls.

use crate::general::contact::{Frame, Kinematics, Near, Partners, SpringStep, path_of, resolve, roll_torque};
use crate::general::energy::Account;
use crate::general::pair_lanes::{PairLanes, PairPass};
use crate::general::sums::Forces;
use crate::grains::{Grains, Response};
use crate::laws::rolling::Roll;
use crate::laws::table::PairLaw;
use crate::laws::walls::Stand;
use crate::motion::Vec3;
use crate::report::Observations;
use crate::search::contact_list::ContactList;
use crate::surroundings::Surroundings;
use crate::vector::kernel::dispatch;

/// What an evaluation reads.
#[derive(Clone, Copy)]
pub(crate) struct Scene<'a> {
    pub(crate) around: &'a Surroundings,
    pub(crate) grains: &'a Grains,
    pub(crate) response: &'a Response,
    pub(crate) kinematics: &'a Kinematics<'a>,
    /// The walls at the time of `kinematics`.
    pub(crate) stands: &'a [Stand],
}

/// Contact forces of all pairs and walls; springs take their step on the way, and an account what it needs.
pub(crate) fn contact_forces(
    scene: &Scene<'_>,
    (pairs, walls): (&mut ContactList, &mut ContactList),
    lanes: &mut PairLanes,
    forces: &mut Forces,
    observed: &mut Observations,
    mut account: Option<&mut Account>,
) {
    if let Some(account) = &mut account {
        account.clear();
    }
    forces.walls.fill(Vec3::zeros());
    let Scene { around, grains, response, kinematics, .. } = *scene;
    let linear = match &around.law {
        PairLaw::Linear(law) if account.is_none() && around.rolling.is_none() => Some(law),
        _ => None,
    };
    if let Some(law) = linear
        && kinematics.spring == SpringStep::Before
        && lanes.load(grains, response, kinematics)
    {
        let plain = lanes.plain;
        dispatch(PairPass { around, law, kinematics, lanes, list: pairs, forces, observed }, plain);
    } else {
        pair_forces(scene, pairs, forces, observed, account.as_deref_mut());
    }
    wall_forces(scene, walls, forces, observed, account);
}

fn pair_forces(
    scene: &Scene<'_>,
    list: &mut ContactList,
    forces: &mut Forces,
    observed: &mut Observations,
    mut account: Option<&mut Account>,
) {
    let Scene { around, grains, .. } = *scene;
    forces.contact.fill(Vec3::zeros());
    forces.torque.fill(Vec3::zeros());
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
            if acts(&around.law, gap, list.touching[k]) {
                let near = Near::grains(i, j, &apart, distance, gap);
                touch(scene, &near, list, k, forces, observed, account.as_deref_mut());
            }
        }
    }
}

fn wall_forces(
    scene: &Scene<'_>,
    list: &mut ContactList,
    forces: &mut Forces,
    observed: &mut Observations,
    mut account: Option<&mut Account>,
) {
    let Scene { around, grains, kinematics, stands, .. } = *scene;
    for i in 0..grains.len() {
        let (x, r) = (&grains.position[i], grains.radius[i]);
        for k in list.row(i) {
            let w = list.other[k] as usize;
            let (wall, stand) = (&around.walls[w], &stands[w]);
            if !wall.acts(kinematics.t) {
                if list.touching[k]
                    && let Some(account) = account.as_deref_mut()
                {
                    let gap = stand.gap(x, r);
                    let near = Near::wall(i, stand, gap, &(x - stand.normal * (r + gap)));
                    let mass = scene.response.effective_mass(grains, i, None);
                    let frame = Frame { near, mass, arms: near.arms(grains), begins: false };
                    if let Some(law) = around.law.at(mass) {
                        let path = path_of(&frame, kinematics, list.spring[k]);
                        account.enter(&frame, &law, path, Vec3::zeros(), (Vec3::zeros(), Vec3::zeros()));
                    }
                }
                list.touching[k] = false;
                list.spring[k] = Vec3::zeros();
                list.rolling[k] = Vec3::zeros();
                continue;
            }
            let gap = stand.gap(x, r);
            if gap > around.range && !list.touching[k] {
                continue;
            }
            note_gap(observed, forces, i, gap);
            if acts(&around.law, gap, list.touching[k]) {
                let near = Near::wall(i, stand, gap, &(x - stand.normal * (r + gap)));
                let force = touch(scene, &near, list, k, forces, observed, account.as_deref_mut());
                forces.walls[w] -= force;
            }
        }
    }
}

/// Whether the force of partners near each other must be evaluated: a contact that ends is, once more.
#[inline(always)]
fn acts(law: &PairLaw, gap: f64, touching: bool) -> bool {
    gap < 0.0 || touching || matches!(law, PairLaw::WanTurek(_))
}

/// Adds force and torque of the contact that is entry `k` of `list`, and takes its step; returns the force on
/// the first partner, N.
#[inline(always)]
fn touch(
    scene: &Scene<'_>,
    near: &Near,
    list: &mut ContactList,
    k: usize,
    forces: &mut Forces,
    observed: &mut Observations,
    account: Option<&mut Account>,
) -> Vec3 {
    let Scene { around, grains, response, kinematics, .. } = *scene;
    let Near { partners, normal, .. } = *near;
    let (i, second) = (partners.first, partners.second);
    if let PairLaw::WanTurek(law) = &around.law {
        let size = near.repulsion(law, grains);
        let rate = partners.relative(kinematics.velocity, kinematics.spin).velocity.dot(&normal);
        let force = normal * size;
        push(&mut forces.contact, &partners, &force);
        let before = std::mem::replace(&mut list.touching[k], size > 0.0);
        observed.note_event((before, size > 0.0), rate, i, second);
        return force;
    }
    let mass = response.effective_mass(grains, i, second);
    let Some(law) = around.law.at(mass) else { return Vec3::zeros() };
    let arms = near.arms(grains);
    let frame = Frame { near: *near, mass, arms, begins: !list.touching[k] };
    let old = list.spring[k];
    let (force, tangential, rate) = resolve(&law, &frame, kinematics, &mut list.spring[k]);
    if let Some(account) = account {
        let path = path_of(&frame, kinematics, old);
        account.enter(&frame, &law, path, list.spring[k], (force, tangential));
    }
    let bears = force != Vec3::zeros();
    observed.note_event((list.touching[k], bears), rate, i, second);
    list.touching[k] = bears;
    push(&mut forces.contact, &partners, &force);
    let moment = tangential.cross(&normal);
    forces.torque[i] += moment * arms.0;
    if let Some(j) = second {
        forces.torque[j] += moment * arms.1;
    }
    if let Some(rolls) = &around.rolling {
        let radius = partners.radius(grains);
        let inertia = rolling_inertia(grains, response, i, second);
        let along = (force - tangential).dot(&normal);
        let roll = Roll { normal, force: along, stiffness: law.stiffness * mass, radius, inertia };
        let torque = roll_torque(rolls, &roll, &frame, kinematics, &mut list.rolling[k]);
        push(&mut forces.torque, &partners, &torque);
    }
    force
}

/// Adds to the first partner's sum, and takes as much from the second's.
#[inline(always)]
fn push(sums: &mut [Vec3], partners: &Partners, what: &Vec3) {
    sums[partners.first] += what;
    if let Some(j) = partners.second {
        sums[j] -= what;
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
