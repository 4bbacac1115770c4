//! One contact: its frame, the relative motion of its partners, its force and its rolling torque.
//!
//! Frame of a pair: n from the second to the first partner, so that a normal force pushes the first
//! along +n. Slip of the surfaces: v_t = (1 − nn)(v_i − v_j) − (l_i ω_i + l_j ω_j) × n with the lever
//! arms l; torques −l_i n × F_t on the first and −l_j n × F_t on the second (eq. 14 with n reversed).

use crate::grains::Grains;
use crate::laws::coefficients::LinearPair;
use crate::laws::rolling::{Roll, Rolling, grow, rolling_rate};
use crate::laws::tangential::{carry, tangential_force};
use crate::laws::walls::Stand;
use crate::laws::wan_turek::WanTurek;
use crate::motion::Vec3;

/// When the springs take the step's slip.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum SpringStep {
    /// First the springs, then the force from them.
    Before,
    /// First the force, then the springs: a stage of a Runge–Kutta method.
    After,
}

/// Velocities that a force evaluation sees, and the step that the springs take.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Kinematics<'a> {
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

/// A grain, and another grain or a wall.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Partners {
    pub(crate) first: usize,
    /// The other grain; none at a wall.
    pub(crate) second: Option<usize>,
    /// Velocity of the wall at the contact, m/s.
    pub(crate) wall: Vec3,
    /// Angular velocity of the wall, rad/s.
    pub(crate) wall_spin: Vec3,
}

impl Partners {
    /// Relative motion for the velocities and spins of all grains.
    #[inline(always)]
    pub(crate) fn relative(&self, velocity: &[Vec3], spin: &[Vec3]) -> Relative {
        let (v, w) = self.second.map_or((self.wall, self.wall_spin), |j| (velocity[j], spin[j]));
        Relative { velocity: velocity[self.first] - v, spin: (spin[self.first], w) }
    }

    /// R*, m.
    #[inline(always)]
    pub(crate) fn radius(&self, grains: &Grains) -> f64 {
        let r = grains.radius[self.first];
        self.second.map_or(r, |j| r * grains.radius[j] / (r + grains.radius[j]))
    }
}

#[derive(Clone, Copy, Debug)]
pub(crate) struct Near {
    pub(crate) partners: Partners,
    /// From the second to the first.
    pub(crate) normal: Vec3,
    pub(crate) gap: f64,
    /// Distance of the centres, or infinite for a wall, whose normal turns by itself alone.
    pub(crate) distance: f64,
}

impl Near {
    /// Grains `i` and `j`; `apart` is the vector between their centres, of this length.
    #[inline(always)]
    pub(crate) fn grains(i: usize, j: usize, apart: &Vec3, distance: f64, gap: f64) -> Self {
        let normal = if distance > 0.0 { apart / distance } else { Vec3::z() };
        let zero = Vec3::zeros();
        let partners = Partners { first: i, second: Some(j), wall: zero, wall_spin: zero };
        Self { partners, normal, gap, distance }
    }

    /// Grain `i` at a wall; `foot` is the point of contact.
    #[inline(always)]
    pub(crate) fn wall(i: usize, wall: &Stand, gap: f64, foot: &Vec3) -> Self {
        let partners =
            Partners { first: i, second: None, wall: wall.velocity_at(foot), wall_spin: wall.spin };
        Self { partners, normal: wall.normal, gap, distance: f64::INFINITY }
    }

    /// Force on the first partner along the normal, N, for the law of Wan & Turek.
    #[inline(always)]
    pub(crate) fn repulsion(&self, law: &WanTurek, grains: &Grains) -> f64 {
        match self.partners.second {
            Some(_) => law.pair_force(self.gap, self.distance),
            None => law.wall_force(self.gap, grains.radius[self.partners.first]),
        }
    }

    /// Distances from the centres at which the tangential force attacks: in the middle of the overlap. Both
    /// arms add up to the distance of the centres, so angular momentum is kept to round-off and a rigid
    /// rotation gives no slip (eq. 14 as printed has the radii, and loses δ × F_t). A wall does not yield:
    /// there the point lies in its plane.
    #[inline(always)]
    pub(crate) fn arms(&self, grains: &Grains) -> (f64, f64) {
        let r = grains.radius[self.partners.first];
        match self.partners.second {
            Some(j) => (r + 0.5 * self.gap, grains.radius[j] + 0.5 * self.gap),
            None => (r + self.gap, 0.0),
        }
    }
}

pub(crate) struct Frame {
    pub(crate) near: Near,
    /// m*, kg.
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
        if frame.begins && frame.near.gap > rate * dt * 1.001 {
            let slipped = frame.near.gap / rate;
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
    /// Slip of the surfaces in the contact plane, m/s, by normal and lever arms.
    #[inline(always)]
    pub(crate) fn slip(&self, n: &Vec3, arms: (f64, f64)) -> Vec3 {
        let along = self.velocity - n * n.dot(&self.velocity);
        along - (self.spin.0 * arms.0 + self.spin.1 * arms.1).cross(n)
    }

    /// Rotation rate of the contact frame, rad/s (see [`crate::laws::tangential`]).
    #[inline(always)]
    fn turning(&self, frame: &Frame) -> Vec3 {
        let (n, wall) = (&frame.near.normal, &frame.near.partners.wall_spin);
        n.cross(&self.velocity) / frame.near.distance
            + n * (0.5 * n.dot(&(self.spin.0 + self.spin.1)))
            + (wall - n * n.dot(wall))
    }
}

/// Rolling torque on the first partner; the angle takes its step on the way.
#[inline(always)]
pub(crate) fn roll_torque(
    rolling: &Rolling,
    roll: &Roll,
    frame: &Frame,
    kinematics: &Kinematics<'_>,
    angle: &mut Vec3,
) -> Vec3 {
    if roll.force <= 0.0 {
        *angle = Vec3::zeros();
        return Vec3::zeros();
    }
    let rate_of = |relative: &Relative| rolling_rate(&roll.normal, &relative.spin.0, &relative.spin.1);
    let partners = &frame.near.partners;
    let now = partners.relative(kinematics.velocity, kinematics.spin);
    let rate = rate_of(&now);
    let path = kinematics.path.map_or(now, |(velocity, spin)| partners.relative(velocity, spin));
    let turn = path.turning(frame) * kinematics.dt;
    if kinematics.spring == SpringStep::Before {
        let onset = Onset::of(frame, path.velocity.dot(&roll.normal), kinematics.dt);
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
pub(crate) fn resolve(
    law: &LinearPair,
    frame: &Frame,
    kinematics: &Kinematics<'_>,
    spring: &mut Vec3,
) -> (Vec3, Vec3, f64) {
    let Near { partners, normal: n, gap, .. } = &frame.near;
    let now = partners.relative(kinematics.velocity, kinematics.spin);
    let rate = now.velocity.dot(n);
    let dt = kinematics.dt;
    let path = kinematics.path.map(|(velocity, spin)| partners.relative(velocity, spin));
    let path = path.as_ref().unwrap_or(&now);
    let path_rate = path.velocity.dot(n);
    let before = kinematics.spring == SpringStep::Before;
    let onset = if before { Onset::of(frame, path_rate, dt) } else { Onset { slipped: dt, dashpot: 1.0 } };
    let normal = if *gap < 0.0 { law.normal_force(frame.mass, *gap, rate * onset.dashpot) } else { 0.0 };
    if normal == 0.0 {
        *spring = Vec3::zeros();
        return (Vec3::zeros(), Vec3::zeros(), rate);
    }
    let slip = now.slip(n, frame.arms);
    let turn = path.turning(frame) * dt;
    let stepped = |spring: &Vec3| carry(*spring, n, &turn) + path.slip(n, frame.arms) * onset.slipped;
    if before {
        *spring = stepped(spring);
    }
    let tangential = tangential_force(law, frame.mass, normal, (&slip, onset.dashpot), spring);
    if !before {
        *spring = stepped(spring);
    }
    (n * normal + tangential, tangential, rate)
}

/// The old spring in the present contact plane, and slip and growth of the gap over the whole step.
pub(crate) fn path_of(frame: &Frame, kinematics: &Kinematics<'_>, spring: Vec3) -> (Vec3, Vec3, f64) {
    let (velocity, spin) = kinematics.path.unwrap_or((kinematics.velocity, kinematics.spin));
    let (n, path) = (&frame.near.normal, frame.near.partners.relative(velocity, spin));
    let dt = kinematics.dt;
    let carried = carry(spring, n, &(path.turning(frame) * dt));
    (carried, path.slip(n, frame.arms) * dt, path.velocity.dot(n) * dt)
}
