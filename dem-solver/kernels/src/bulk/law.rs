//! The linear spring–dashpot law on many contacts at once (Izard et al. 2014, eqs 11–16; the scalar form is
//! in [`crate::general::forces`] and [`crate::laws::tangential`]).
//!
//! What a lane gives never depends on the other lanes: where some lanes take another branch, both are
//! computed and each lane selects its own.

use crate::laws::coefficients::LinearPair;
use crate::vector::lanes::{Lanes, Mask};
use crate::vector::vec3::Vec3Lanes;

/// Change of δ² in one turn of the spring above which its length is restored with a root: below, what
/// the series leaves out is 0.32 ε³, less than a rounding.
const SERIES: f64 = 5e-6;
/// Square of a spring below which its length is not restored, m²: 1e-75 m is no length.
const NOTHING: f64 = 1e-150;

/// Coefficients in all lanes, per unit m*.
#[derive(Clone, Copy)]
pub(super) struct LawLanes<L> {
    stiffness: L,
    damping: L,
    tangential_stiffness: L,
    tangential_damping: L,
    friction: L,
    /// 1/(k_t/m*), 0 without a spring.
    compliance: L,
    dt: L,
    has_spring: bool,
    pub(super) zero: L,
    pub(super) half: L,
    pub(super) one: L,
}

/// Contacts in their frames.
#[derive(Clone, Copy)]
pub(super) struct Contact<L: Lanes> {
    /// Lanes that overlap.
    pub(super) overlapping: L::Mask,
    /// Lanes that touched at the evaluation before.
    pub(super) before: L::Mask,
    /// Normal from the second to the first partner.
    pub(super) n: Vec3Lanes<L>,
    /// Overlap, m.
    pub(super) overlap: L,
    /// Velocity of the first against the second centre, m/s.
    pub(super) v: Vec3Lanes<L>,
    /// l_i ω_i + l_j ω_j, m/s.
    pub(super) rolling: Vec3Lanes<L>,
    /// ω_i + ω_j, rad/s.
    pub(super) spin: Vec3Lanes<L>,
    /// One over the distance of the centres, 1/m; nothing at a wall, which does not turn.
    pub(super) inverse_distance: Option<L>,
    /// m*, kg.
    pub(super) mass: L,
    /// 1/m*, 1/kg.
    pub(super) inverse_mass: L,
    /// 1/|δ_t|², or anything finite where the spring is nothing.
    pub(super) inverse_length2: L,
    /// |δ_t|², m².
    pub(super) length2: L,
}

/// What contacts do.
#[derive(Clone, Copy)]
pub(super) struct Answer<L: Lanes> {
    /// Lanes that bear a force.
    pub(super) touching: L::Mask,
    /// Force on the first partner, N.
    pub(super) force: Vec3Lanes<L>,
    /// F_t × n, N: times a lever arm, the torque on either partner.
    pub(super) moment: Vec3Lanes<L>,
    /// dδ/dt, m/s.
    pub(super) rate: L,
}

impl<L: Lanes> LawLanes<L> {
    /// The law for a sub-step of `dt`.
    #[inline(always)]
    pub(super) fn new(token: L::Token, law: &LinearPair, dt: f64) -> Self {
        let splat = L::splat;
        let k_t = law.tangential_stiffness;
        Self {
            stiffness: splat(token, law.stiffness),
            damping: splat(token, law.damping),
            tangential_stiffness: splat(token, k_t),
            tangential_damping: splat(token, law.tangential_damping),
            friction: splat(token, law.friction),
            compliance: splat(token, if k_t > 0.0 { 1.0 / k_t } else { 0.0 }),
            dt: splat(token, dt),
            has_spring: k_t > 0.0,
            zero: splat(token, 0.0),
            half: splat(token, 0.5),
            one: splat(token, 1.0),
        }
    }

    /// |δ_t|², and a value that may be divided by.
    #[inline(always)]
    pub(super) fn length2(&self, token: L::Token, spring: Vec3Lanes<L>) -> (L, L) {
        let length2 = spring.dot(spring);
        (length2, length2.select(L::splat(token, NOTHING).lt(length2), self.one))
    }

    /// Force, moment and the spring's step.
    #[inline(always)]
    pub(super) fn resolve(&self, token: L::Token, c: &Contact<L>, spring: &mut Vec3Lanes<L>) -> Answer<L> {
        let n = c.n;
        let rate = c.v.dot(n);
        // what begins within the step: general::contact::Onset
        let (mut slipped, mut dashpot) = (self.dt, self.one);
        let begins = c.overlapping & !c.before;
        if begins.any() {
            let gap = self.zero - c.overlap;
            let within = begins & (rate * self.dt * L::splat(token, 1.001)).lt(gap);
            let since = gap / rate;
            slipped = since.select(within, slipped);
            dashpot = (self.half + since / self.dt).select(within, dashpot);
        }
        // F_n = max(0, m* (k overlap − γ dδ/dt)), eq. 15
        let push = c.mass * (rate * dashpot).times_from(self.damping, self.stiffness * c.overlap);
        let normal = push.max(self.zero);
        let touching = c.overlapping & self.zero.lt(normal);
        let slip = n.scale_from(rate, c.v).minus(c.rolling.cross(n));
        let twist = self.half * n.dot(c.spin);
        let turn = match c.inverse_distance {
            Some(inverse) => n.cross(c.v).scale_plus(inverse, n.scale(twist)),
            None => n.scale(twist),
        };
        let carried = self.carry(token, c, *spring, turn.scale(self.dt));
        let mut s = slip.scale_plus(slipped, carried);
        // F_t = −min(|k_t δ_t + γ_t v_t|, μ F_n) along itself, eq. 16
        let gamma = self.tangential_damping * c.mass;
        let drag = slip.scale(dashpot * gamma);
        let mut tangential = s.scale_plus(self.tangential_stiffness * c.mass, drag);
        let size2 = tangential.dot(tangential);
        let limit = self.friction * normal;
        let sliding = (limit * limit).lt(size2);
        if (sliding & touching).any() {
            let cut = tangential.scale(limit / size2.sqrt());
            tangential = cut.select(sliding, tangential);
            if self.has_spring {
                // no more of the dashpot than acts in the next step
                let drag = slip.scale(dashpot.select(dashpot.lt(self.one), self.one) * gamma);
                let cut_back = cut.minus(drag).scale(c.inverse_mass * self.compliance);
                s = cut_back.select(sliding, s);
            }
        }
        let zero = Vec3Lanes(self.zero, self.zero, self.zero);
        *spring = s.select(touching, zero);
        let tangential = tangential.select(touching, zero);
        let force = n.scale(normal).minus(tangential).select(touching, zero);
        let moment = n.cross(tangential).select(touching, zero);
        Answer { touching, force, moment, rate }
    }

    /// Turns the spring, lays it into the contact plane and restores its length
    /// ([`crate::laws::tangential::carry`]). The length changes by a part ε of 1e-6 and less in a sub-step,
    /// so 1/√(1 − ε) is a short series; lanes with a larger one take the root.
    #[inline(always)]
    fn carry(&self, token: L::Token, c: &Contact<L>, s: Vec3Lanes<L>, turn: Vec3Lanes<L>) -> Vec3Lanes<L> {
        let first = turn.cross(s);
        let turned = turn.cross(first).scale_plus(self.half, s.plus(first));
        let flat = c.n.scale_from(c.n.dot(turned), turned);
        let flat2 = flat.dot(flat);
        let lost = (c.length2 - flat2) * c.inverse_length2;
        let k = |value| L::splat(token, value);
        let mut grow = lost.times_plus(lost.times_plus(k(0.375), self.half), self.one);
        let limit = k(SERIES);
        let far = limit.lt(lost) | lost.lt(self.zero - limit);
        if (far & c.overlapping).any() {
            let some = self.zero.lt(flat2);
            let root = (c.length2 / flat2).sqrt().select(some, self.zero);
            grow = root.select(far, grow);
        }
        flat.scale(grow)
    }
}
