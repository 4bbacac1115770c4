//! The linear law of eight contacts: operation by operation that of [`crate::general::contact::resolve`] and
//! [`crate::laws::tangential`], in their order and with their roundings, so that both give the same bits.

use crate::laws::coefficients::LinearPair;
use crate::vector::lanes::Lanes8;
use crate::vector::vec3::Vec3Lanes;

/// a·b, each product and sum rounded.
#[inline(always)]
pub(super) fn dot<L: Lanes8>(a: Vec3Lanes<L>, b: Vec3Lanes<L>) -> L {
    a.0 * b.0 + a.1 * b.1 + a.2 * b.2
}

/// a × b, each product and difference rounded.
#[inline(always)]
pub(super) fn cross<L: Lanes8>(a: Vec3Lanes<L>, b: Vec3Lanes<L>) -> Vec3Lanes<L> {
    Vec3Lanes(a.1 * b.2 - a.2 * b.1, a.2 * b.0 - a.0 * b.2, a.0 * b.1 - a.1 * b.0)
}

/// Coefficients by lanes ([`LinearPair`]).
#[derive(Clone, Copy)]
pub(super) struct Law<L> {
    stiffness: L,
    damping: L,
    tangential_stiffness: L,
    tangential_damping: L,
    friction: L,
}

impl<L: Lanes8> Law<L> {
    #[inline(always)]
    pub(super) fn splat(token: L::Token, law: &LinearPair) -> Self {
        let k = |value| L::splat(token, value);
        Self {
            stiffness: k(law.stiffness),
            damping: k(law.damping),
            tangential_stiffness: k(law.tangential_stiffness),
            tangential_damping: k(law.tangential_damping),
            friction: k(law.friction),
        }
    }
}

/// Relative motion: velocity of the first against the second centre, and both spins.
#[derive(Clone, Copy)]
pub(super) struct Relative<L> {
    pub(super) velocity: Vec3Lanes<L>,
    pub(super) spin: (Vec3Lanes<L>, Vec3Lanes<L>),
}

impl<L: Lanes8> Relative<L> {
    /// Slip of the surfaces in the contact plane.
    #[inline(always)]
    fn slip(&self, n: Vec3Lanes<L>, arms: (L, L)) -> Vec3Lanes<L> {
        let along = self.velocity.minus(n.scale(dot(n, self.velocity)));
        along.minus(cross(self.spin.0.scale(arms.0).plus(self.spin.1.scale(arms.1)), n))
    }

    /// Rotation rate of the contact frame.
    #[inline(always)]
    fn turning(&self, token: L::Token, n: Vec3Lanes<L>, distance: L) -> Vec3Lanes<L> {
        let turn = cross(n, self.velocity);
        let turn = Vec3Lanes(turn.0 / distance, turn.1 / distance, turn.2 / distance);
        turn.plus(n.scale(L::splat(token, 0.5) * dot(n, self.spin.0.plus(self.spin.1))))
    }
}

/// Eight contacts in their frames.
pub(super) struct Contacts<L> {
    /// Lanes that did not touch at the evaluation before.
    pub(super) begins: u8,
    pub(super) normal: Vec3Lanes<L>,
    pub(super) gap: L,
    pub(super) distance: L,
    /// m*, kg.
    pub(super) mass: L,
    pub(super) arms: (L, L),
    /// What dashpots see, and what springs go along.
    pub(super) now: Relative<L>,
    pub(super) path: Relative<L>,
    /// Step of the springs, s.
    pub(super) dt: f64,
}

/// What eight contacts do.
pub(super) struct Answer<L> {
    /// Lanes that bear a force.
    pub(super) bears: u8,
    pub(super) force: Vec3Lanes<L>,
    pub(super) tangential: Vec3Lanes<L>,
    /// Gap rate, m/s.
    pub(super) rate: L,
    pub(super) spring: Vec3Lanes<L>,
}

impl<L: Lanes8> Contacts<L> {
    /// Forces on the first partners; `spring` takes its step.
    #[inline(always)]
    pub(super) fn resolve(&self, token: L::Token, law: &Law<L>, spring: Vec3Lanes<L>) -> Answer<L> {
        let k = |value| L::splat(token, value);
        let (zero, dt, n) = (k(0.0), k(self.dt), self.normal);
        let rate = dot(self.now.velocity, n);
        let path_rate = dot(self.path.velocity, n);
        // what begins within the step
        let within = self.begins & (path_rate * dt * k(1.001)).lt(self.gap);
        let (mut slipped, mut dashpot) = (dt, k(1.0));
        if within != 0 {
            let since = self.gap / path_rate;
            dashpot = (k(0.5) + since / dt).select(within, dashpot);
            slipped = since.select(within, slipped);
        }
        let push = (zero - self.mass) * (law.stiffness * self.gap + law.damping * (rate * dashpot));
        let normal = push.max(zero);
        let bears: u8 = self.gap.lt(zero) & zero.lt(normal);
        let slip = self.now.slip(n, self.arms);
        let turn = self.path.turning(token, n, self.distance).scale(dt);
        let mut spring = carry(token, spring, n, turn).plus(self.path.slip(n, self.arms).scale(slipped));
        let (k_t, gamma) = (law.tangential_stiffness * self.mass, law.tangential_damping * self.mass);
        let drag = slip.scale(dashpot).scale(gamma);
        let none = Vec3Lanes(zero, zero, zero);
        let mut tangential = none.minus(spring.scale(k_t).plus(drag));
        let limit = law.friction * normal;
        let size2 = dot(tangential, tangential);
        let sliding = bears & (limit * limit).lt(size2);
        if sliding != 0 {
            let cut = tangential.scale(limit / size2.sqrt());
            tangential = cut.select(sliding, tangential);
            // no more of the dashpot than acts in the next step
            let drag = slip.scale(dashpot.select(dashpot.lt(k(1.0)), k(1.0))).scale(gamma);
            let back = none.minus(cut.plus(drag));
            let back = Vec3Lanes(back.0 / k_t, back.1 / k_t, back.2 / k_t);
            spring = back.select(sliding & zero.lt(k_t), spring);
        }
        let tangential = tangential.select(bears, none);
        let force = n.scale(normal).plus(tangential).select(bears, none);
        Answer { bears, force, tangential, rate, spring: spring.select(bears, none) }
    }
}

/// [`crate::laws::tangential::carry`].
#[inline(always)]
fn carry<L: Lanes8>(
    token: L::Token,
    spring: Vec3Lanes<L>,
    n: Vec3Lanes<L>,
    turn: Vec3Lanes<L>,
) -> Vec3Lanes<L> {
    let zero = L::splat(token, 0.0);
    let length2 = dot(spring, spring);
    let first = cross(turn, spring);
    let turned = spring.plus(first).plus(cross(turn, first).scale(L::splat(token, 0.5)));
    let flat = turned.minus(n.scale(dot(n, turned)));
    let flat2 = dot(flat, flat);
    flat.scale((length2 / flat2).sqrt()).select(zero.lt(flat2), Vec3Lanes(zero, zero, zero))
}
