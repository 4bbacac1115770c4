//! One point of contact of a body that is not round: its effective mass, the motion there, its force.

use crate::bodies::plane::{Vec2, across, dot, turning};
use crate::general::contact::Kinematics;
use crate::grains::{Grains, Response};
use crate::laws::coefficients::LinearPair;
use crate::motion::Vec3;

/// Components x and z.
#[inline(always)]
pub(super) fn flat(v: &Vec3) -> Vec2 {
    [v.x, v.z]
}

/// A point of contact between two grains, or a grain and a wall, in the plane.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Place {
    pub(crate) first: usize,
    /// The other grain; none at a wall.
    pub(crate) second: Option<usize>,
    /// Number of the wall, and its velocity at the point, m/s.
    pub(crate) wall: Option<(usize, Vec2)>,
    /// From the second to the first.
    pub(crate) normal: Vec2,
    pub(crate) gap: f64,
    /// From the centres of both to the point, m.
    pub(crate) arms: (Vec2, Vec2),
}

/// Rates at a point: of the gap, and of the first's surface against the second's along the tangent, m/s.
#[derive(Clone, Copy, Debug)]
struct Rates {
    gap: f64,
    slip: f64,
}

impl Place {
    fn rates(&self, velocity: &[Vec3], spin: &[Vec3]) -> Rates {
        let at = |i: usize, arm: Vec2| {
            let (v, w) = (&velocity[i], spin[i].y);
            [v.x + w * arm[1], v.z - w * arm[0]]
        };
        let one = at(self.first, self.arms.0);
        let of_wall = || self.wall.map_or([0.0; 2], |(_, velocity)| velocity);
        let other = self.second.map_or_else(of_wall, |j| at(j, self.arms.1));
        let relative = [one[0] - other[0], one[1] - other[1]];
        Rates { gap: dot(relative, self.normal), slip: dot(relative, across(self.normal)) }
    }

    /// 1/m* = Σ (n·W n + (r × n)² J) over both grains, W and J their inverse masses and inertias along free
    /// axes.
    pub(super) fn mass(&self, grains: &Grains, response: &Response) -> f64 {
        let inverse = |i: usize, arm: Vec2| {
            let (weight, turn) = (&response.inverse_mass[i], response.inverse_inertia[i].y);
            let [x, z] = self.normal;
            let lever = turning(arm, self.normal);
            x * x * weight.x + z * z * weight.z + lever * lever * turn
        };
        let sum = inverse(self.first, self.arms.0) + self.second.map_or(0.0, |j| inverse(j, self.arms.1));
        // What turns alone about an arm of round-off weighs no more than itself.
        let most = self.second.map_or(0.0, |j| grains.mass[j]).max(grains.mass[self.first]);
        if sum > 0.0 { (1.0 / sum).min(most) } else { grains.mass[self.first] }
    }

    /// Force on the first, and the gap rate; the spring takes its step. The rules are those of discs
    /// ([`crate::general::contact`]): within the step in which a point first touches, spring and dashpot act
    /// for the part in which it does.
    pub(super) fn force(
        &self,
        law: &LinearPair,
        (mass, begins): (f64, bool),
        kinematics: &Kinematics<'_>,
        spring: &mut f64,
    ) -> (Vec2, f64) {
        let dt = kinematics.dt;
        let now = self.rates(kinematics.velocity, kinematics.spin);
        let path = kinematics.path.map_or(now, |(velocity, spin)| self.rates(velocity, spin));
        let (mut slipped, mut dashpot) = (dt, 1.0);
        if begins && self.gap > path.gap * dt * 1.001 {
            slipped = self.gap / path.gap;
            dashpot = 0.5 + slipped / dt;
        }
        let push = if self.gap < 0.0 { law.normal_force(mass, self.gap, now.gap * dashpot) } else { 0.0 };
        if push == 0.0 {
            *spring = 0.0;
            return ([0.0; 2], now.gap);
        }
        *spring += path.slip * slipped;
        let (k_t, drag) = (law.tangential_stiffness * mass, law.tangential_damping * mass * now.slip);
        let limit = law.friction * push;
        let mut across_force = -(*spring * k_t + drag * dashpot);
        if across_force.abs() > limit {
            across_force = limit.copysign(across_force);
            if k_t > 0.0 {
                // no more of the dashpot than acts in the next step
                *spring = -(across_force + drag * dashpot.min(1.0)) / k_t;
            }
        }
        let tangent = across(self.normal);
        let force = [
            self.normal[0] * push + tangent[0] * across_force,
            self.normal[1] * push + tangent[1] * across_force,
        ];
        (force, now.gap)
    }
}
