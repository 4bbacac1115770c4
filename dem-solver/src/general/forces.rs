//! Contact forces and torques on all grains (the seed, eqs 11–16).
//!
//! Frame of a pair: n from the second to the first partner, so that a normal force pushes the first
//! along +n. Slip of the surfaces: v_t = (1 − nn)(v_i − v_j) − (l_i ω_i + l_j ω_j) × n with the lever
//! arms l; torques −l_i n × F_t on the first and −l_j n × F_t on the second (eq. 14 with n reversed).

use crate::Vec3;
use crate::general::energy::{Account, Entry};
use crate::general::lists::ContactList;
use crate::grains::{Grains, Response};
use crate::laws::hertz_mindlin::HertzPair;
use crate::laws::rolling::{Roll, Rolling, grow, rolling_rate};
use crate::laws::table::{LawTable, LinearPair, PairLaw};
use crate::laws::tangential::{carry, tangential_force};
use crate::laws::walls::Plane;
use crate::report::Observations;
use crate::search::cells::Periods;

/// What does not change over a run.
#[derive(Clone, Debug)]
pub struct Scene {
    /// Walls.
    pub walls: Vec<Plane>,
    /// Periodic directions.
    pub periods: Periods,
    /// Laws by materials.
    pub laws: LawTable,
    /// Gap below which gaps are watched, m.
    pub range: f64,
}

/// When the springs take the step's slip.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SpringStep {
    /// First the springs, then the force from them.
    Before,
    /// First the force, then the springs: a stage of a Runge–Kutta method.
    After,
}

/// Velocities that a force evaluation sees, and the step that the springs take.
#[derive(Clone, Copy, Debug)]
pub struct Kinematics<'a> {
    /// Velocities for dashpots, m/s.
    pub velocity: &'a [Vec3],
    /// Spins for dashpots, rad/s.
    pub spin: &'a [Vec3],
    /// Velocities for the springs, if others than for the dashpots (Verlet's half step).
    pub path: Option<(&'a [Vec3], &'a [Vec3])>,
    /// Step of the springs, s; zero leaves them.
    pub dt: f64,
    /// Order of spring and force.
    pub spring: SpringStep,
    /// Time, s.
    pub t: f64,
}

/// Forces and torques on the grains.
#[derive(Clone, Debug, Default)]
pub struct Forces {
    /// Contact forces, N.
    pub contact: Vec<Vec3>,
    /// Contact torques, N m.
    pub torque: Vec<Vec3>,
    /// Film forces, N.
    pub film: Vec<Vec3>,
    /// Contacts that bear a force.
    pub contacts: usize,
    /// Largest overlap met, m.
    pub overlap: f64,
}

impl Forces {
    /// Room for `n` grains.
    #[must_use]
    pub fn new(n: usize) -> Self {
        Self {
            contact: vec![Vec3::zeros(); n],
            torque: vec![Vec3::zeros(); n],
            film: vec![Vec3::zeros(); n],
            contacts: 0,
            overlap: 0.0,
        }
    }
}

/// One contact in its frame.
pub(crate) struct Frame {
    pub(crate) normal: Vec3,
    pub(crate) gap: f64,
    /// Distance of the centres, or infinite for a wall: its normal does not turn.
    pub(crate) distance: f64,
    pub(crate) mass: f64,
    pub(crate) arms: (f64, f64),
    /// Did the partners not touch at the evaluation before?
    pub(crate) begins: bool,
}

/// A contact that begins within a step: what the step owes to the part of it in which the partners touch.
///
/// The force jumps at the touch, and a rule that takes no notice of where in the step it came is of first
/// order in restitution and Ψ₂ whatever the integrator. With f the part of the step before this evaluation
/// in which they touched, the springs take the slip of f dt, not of dt; the dashpots have acted for f dt
/// before it and act for ½ dt after it, where a kick gives them dt.
struct Onset {
    /// f dt, s.
    slipped: f64,
    /// f + ½: factor on the dashpots.
    dashpot: f64,
}

impl Onset {
    /// At an evaluation after a step `dt` along which the gap changed at `rate`.
    #[inline(always)]
    fn of(frame: &Frame, rate: f64, dt: f64) -> Self {
        // a contact deeper than the path of the step was there before; the line of centres turns a little
        if frame.begins && frame.gap > rate * dt * 1.001 {
            let slipped = frame.gap / rate;
            Self { slipped, dashpot: 0.5 + slipped / dt }
        } else {
            Self { slipped: dt, dashpot: 1.0 }
        }
    }
}

/// Velocity of the first against the second centre, and the two spins.
pub(crate) struct Relative {
    pub(crate) velocity: Vec3,
    pub(crate) spin: (Vec3, Vec3),
}

impl Relative {
    /// Slip of the surfaces in the contact plane, m/s.
    #[inline(always)]
    fn slip(&self, frame: &Frame) -> Vec3 {
        self.slip_at(&frame.normal, frame.arms)
    }

    /// The same by normal and lever arms.
    #[inline(always)]
    pub(crate) fn slip_at(&self, n: &Vec3, arms: (f64, f64)) -> Vec3 {
        let along = self.velocity - n * n.dot(&self.velocity);
        along - (self.spin.0 * arms.0 + self.spin.1 * arms.1).cross(n)
    }

    /// Rotation rate of the contact frame, rad/s (see [`crate::laws::tangential`]).
    #[inline(always)]
    fn turning(&self, frame: &Frame) -> Vec3 {
        let n = &frame.normal;
        n.cross(&self.velocity) / frame.distance + n * (0.5 * n.dot(&(self.spin.0 + self.spin.1)))
    }
}

/// Contact forces of all pairs and walls; springs take their step on the way, and an account what it needs.
pub fn contact_forces(
    scene: &Scene,
    grains: &Grains,
    response: &Response,
    kinematics: &Kinematics<'_>,
    (pairs, walls): (&mut ContactList, &mut ContactList),
    forces: &mut Forces,
    seen: &mut Observations,
    mut account: Option<&mut Account>,
) {
    if let Some(account) = &mut account {
        account.clear();
    }
    forces.contact.fill(Vec3::zeros());
    forces.torque.fill(Vec3::zeros());
    forces.contacts = 0;
    pair_forces(scene, grains, response, kinematics, pairs, forces, seen, account.as_deref_mut());
    wall_forces(scene, grains, response, kinematics, walls, forces, seen, account);
}

fn pair_forces(
    scene: &Scene,
    grains: &Grains,
    response: &Response,
    kinematics: &Kinematics<'_>,
    list: &mut ContactList,
    forces: &mut Forces,
    seen: &mut Observations,
    mut account: Option<&mut Account>,
) {
    for i in 0..grains.len() {
        let (x, r) = (grains.position[i], grains.radius[i]);
        for k in list.row(i) {
            let j = list.other[k] as usize;
            let apart = scene.periods.nearest(x - grains.position[j]);
            let reach = r + grains.radius[j] + scene.range;
            let distance2 = apart.norm_squared();
            if distance2 > reach * reach && !list.touching[k] {
                continue;
            }
            let distance = distance2.sqrt();
            let gap = distance - r - grains.radius[j];
            note_gap(seen, forces, i, gap);
            seen.smallest_gap[j] = seen.smallest_gap[j].min(gap);
            let law = scene.laws.between(grains.material[i], grains.material[j]);
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
                note_event(&mut list.touching[k], size > 0.0, rate, seen, i, Some(j));
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
            note_event(&mut list.touching[k], bears, rate, seen, i, Some(j));
            forces.contacts += usize::from(bears);
            forces.contact[i] += force;
            forces.contact[j] -= force;
            let moment = tangential.cross(&normal);
            forces.torque[i] += moment * frame.arms.0;
            forces.torque[j] += moment * frame.arms.1;
            if let Some(rolls) = scene.laws.rolling(grains.material[i], grains.material[j]) {
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
    scene: &Scene,
    grains: &Grains,
    response: &Response,
    kinematics: &Kinematics<'_>,
    list: &mut ContactList,
    forces: &mut Forces,
    seen: &mut Observations,
    mut account: Option<&mut Account>,
) {
    for i in 0..grains.len() {
        let r = grains.radius[i];
        for k in list.row(i) {
            let wall = &scene.walls[list.other[k] as usize];
            if !wall.acts(kinematics.t) {
                list.touching[k] = false;
                list.spring[k] = Vec3::zeros();
                list.rolling[k] = Vec3::zeros();
                continue;
            }
            let gap = wall.gap(&grains.position[i], r, kinematics.t);
            if gap > scene.range && !list.touching[k] {
                continue;
            }
            note_gap(seen, forces, i, gap);
            let relative = |velocity: &[Vec3], spin: &[Vec3]| Relative {
                velocity: velocity[i] - wall.velocity,
                spin: (spin[i], Vec3::zeros()),
            };
            let law = scene.laws.between(grains.material[i], wall.material);
            if let PairLaw::WanTurek(law) = law {
                let size = law.wall_force(gap, r);
                forces.contact[i] += wall.normal * size;
                let rate = (kinematics.velocity[i] - wall.velocity).dot(&wall.normal);
                note_event(&mut list.touching[k], size > 0.0, rate, seen, i, None);
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
            note_event(&mut list.touching[k], bears, rate, seen, i, None);
            forces.contacts += usize::from(bears);
            forces.contact[i] += force;
            forces.torque[i] += tangential.cross(&wall.normal) * arm;
            if let Some(rolls) = scene.laws.rolling(grains.material[i], wall.material) {
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

/// A law at one overlap: its coefficients, and what becomes of the spring as the contact grows.
pub(crate) struct Coefficients {
    pub(crate) pair: LinearPair,
    /// Hertz–Mindlin: the spring shrinks in loading.
    grows: bool,
}

impl Coefficients {
    /// Of a law that has springs; `radius` is R*.
    #[inline(always)]
    pub(crate) fn of(law: &PairLaw, mass: f64, radius: f64, gap: f64) -> Option<Self> {
        match law {
            PairLaw::Linear(pair) => Some(Self { pair: *pair, grows: false }),
            PairLaw::Stiff(law) => Some(Self { pair: law.at(mass), grows: false }),
            PairLaw::Hertz(law) => Some(Self { pair: law.at(mass, radius, gap), grows: true }),
            PairLaw::WanTurek(_) => None,
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

/// Rolling torque on the first partner; the angle takes its step on the way.
#[inline(always)]
fn roll_torque<'a>(
    rolling: &Rolling,
    roll: &Roll,
    frame: &Frame,
    kinematics: &Kinematics<'a>,
    relative: impl Fn(&'a [Vec3], &'a [Vec3]) -> Relative,
    angle: &mut Vec3,
) -> Vec3 {
    if roll.force <= 0.0 {
        *angle = Vec3::zeros();
        return Vec3::zeros();
    }
    let rate_of = |relative: &Relative| rolling_rate(&roll.normal, &relative.spin.0, &relative.spin.1);
    let now = relative(kinematics.velocity, kinematics.spin);
    let rate = rate_of(&now);
    let path = kinematics.path.map_or(now, |(velocity, spin)| relative(velocity, spin));
    let turn = path.turning(frame) * kinematics.dt;
    if kinematics.spring == SpringStep::Before {
        let onset = Onset::of(frame, path.velocity.dot(&frame.normal), kinematics.dt);
        *angle = grow(*angle, &roll.normal, &turn, &rate_of(&path), onset.slipped);
        rolling.torque(roll, &rate, angle)
    } else {
        let torque = rolling.torque(roll, &rate, angle);
        *angle = grow(*angle, &roll.normal, &turn, &rate_of(&path), kinematics.dt);
        torque
    }
}

/// Force on the first partner, its tangential part, and the gap rate.
#[inline(always)]
pub(crate) fn resolve<'a>(
    law: &Coefficients,
    frame: &Frame,
    kinematics: &Kinematics<'a>,
    relative: impl Fn(&'a [Vec3], &'a [Vec3]) -> Relative,
    spring: &mut Vec3,
) -> (Vec3, Vec3, f64) {
    let now = relative(kinematics.velocity, kinematics.spin);
    let rate = now.velocity.dot(&frame.normal);
    let (pair, dt) = (&law.pair, kinematics.dt);
    let path = kinematics.path.map(|(velocity, spin)| relative(velocity, spin));
    let path = path.as_ref().unwrap_or(&now);
    let path_rate = path.velocity.dot(&frame.normal);
    let before = kinematics.spring == SpringStep::Before;
    let onset = if before { Onset::of(frame, path_rate, dt) } else { Onset { slipped: dt, dashpot: 1.0 } };
    let normal =
        if frame.gap < 0.0 { pair.normal_force(frame.mass, frame.gap, rate * onset.dashpot) } else { 0.0 };
    if normal == 0.0 {
        *spring = Vec3::zeros();
        return (Vec3::zeros(), Vec3::zeros(), rate);
    }
    let slip = now.slip(frame) * onset.dashpot;
    let turn = path.turning(frame) * dt;
    let growth = if law.grows { HertzPair::growth(frame.gap, path_rate * dt) } else { 1.0 };
    let stepped =
        |spring: &Vec3| carry(*spring, &frame.normal, &turn) * growth + path.slip(frame) * onset.slipped;
    if before {
        *spring = stepped(spring);
    }
    let tangential = tangential_force(pair, frame.mass, normal, &slip, spring);
    if !before {
        *spring = stepped(spring);
    }
    (frame.normal * normal + tangential, tangential, rate)
}

/// The old spring in the present contact plane, and slip and growth of the gap over the whole step.
fn path_of<'a>(
    frame: &Frame,
    kinematics: &Kinematics<'a>,
    relative: impl Fn(&'a [Vec3], &'a [Vec3]) -> Relative,
    spring: Vec3,
) -> (Vec3, Vec3, f64) {
    let (velocity, spin) = kinematics.path.unwrap_or((kinematics.velocity, kinematics.spin));
    let (path, dt) = (relative(velocity, spin), kinematics.dt);
    let carried = carry(spring, &frame.normal, &(path.turning(frame) * dt));
    (carried, path.slip(frame) * dt, path.velocity.dot(&frame.normal) * dt)
}

/// Records the gap of grain `i`.
#[inline(always)]
fn note_gap(seen: &mut Observations, forces: &mut Forces, i: usize, gap: f64) {
    seen.smallest_gap[i] = seen.smallest_gap[i].min(gap);
    forces.overlap = forces.overlap.max(-gap);
}

/// Records the beginning and the end of a contact, with the normal speed at that moment.
#[inline(always)]
fn note_event(
    touching: &mut bool,
    bears: bool,
    rate: f64,
    seen: &mut Observations,
    i: usize,
    j: Option<usize>,
) {
    if *touching == bears {
        return;
    }
    *touching = bears;
    let speeds = if bears { &mut seen.impact_speed } else { &mut seen.rebound_speed };
    let speed = if bears { -rate } else { rate };
    speeds[i] = speed.max(0.0);
    if let Some(j) = j {
        speeds[j] = speed.max(0.0);
    }
}
