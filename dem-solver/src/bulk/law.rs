//! The linear spring–dashpot law on eight contacts at once (the seed, eqs 11–16; the scalar form is
//! in [`crate::interact`] and [`crate::tangential`]).
//!
//! What a lane gives never depends on the other lanes of its pack: where some lanes take another
//! branch, both are computed and each lane selects its own.

use super::lanes::Lanes;
use crate::linear::LinearPair;

/// Change of δ² in one turn of the spring above which its length is restored with a root.
const SERIES: f64 = 1e-3;
/// Square of a spring below which its length is not restored, m²: 1e-75 m is no length.
const NOTHING: f64 = 1e-150;

/// Three components in eight lanes.
#[derive(Clone, Copy)]
pub(super) struct Vec8<L>(pub(super) L, pub(super) L, pub(super) L);

impl<L: Lanes> Vec8<L> {
    #[inline(always)]
    pub(super) fn dot(self, o: Self) -> L {
        self.0 * o.0 + self.1 * o.1 + self.2 * o.2
    }

    #[inline(always)]
    pub(super) fn cross(self, o: Self) -> Self {
        Self(self.1 * o.2 - self.2 * o.1, self.2 * o.0 - self.0 * o.2, self.0 * o.1 - self.1 * o.0)
    }

    #[inline(always)]
    pub(super) fn scale(self, s: L) -> Self {
        Self(self.0 * s, self.1 * s, self.2 * s)
    }

    #[inline(always)]
    pub(super) fn plus(self, o: Self) -> Self {
        Self(self.0 + o.0, self.1 + o.1, self.2 + o.2)
    }

    #[inline(always)]
    pub(super) fn minus(self, o: Self) -> Self {
        Self(self.0 - o.0, self.1 - o.1, self.2 - o.2)
    }

    #[inline(always)]
    pub(super) fn select(self, mask: u8, o: Self) -> Self {
        Self(self.0.select(mask, o.0), self.1.select(mask, o.1), self.2.select(mask, o.2))
    }

    #[inline(always)]
    pub(super) fn load(token: L::Token, from: &[[f64; 8]; 3]) -> Self {
        Self(L::load(token, &from[0]), L::load(token, &from[1]), L::load(token, &from[2]))
    }

    #[inline(always)]
    pub(super) fn store(self, to: &mut [[f64; 8]; 3]) {
        self.0.store(&mut to[0]);
        self.1.store(&mut to[1]);
        self.2.store(&mut to[2]);
    }

    #[inline(always)]
    pub(super) fn splat(token: L::Token, v: [f64; 3]) -> Self {
        Self(L::splat(token, v[0]), L::splat(token, v[1]), L::splat(token, v[2]))
    }
}

/// Coefficients of one pair of materials in all lanes, per unit m*.
#[derive(Clone, Copy)]
pub(super) struct LawLanes<L> {
    stiffness: L,
    damping: L,
    tangential_stiffness: L,
    tangential_damping: L,
    friction: L,
    /// 1/(k_t/m*), 0 without a spring.
    compliance: L,
    /// Share of the gap that the lever arm takes: 0 at the radius; ½ between grains, 1 at a wall.
    pub(super) arm: L,
    dt: L,
    capped: bool,
    pub(super) zero: L,
    half: L,
    one: L,
}

/// One pack of contacts in its frame.
#[derive(Clone, Copy)]
pub(super) struct Contact8<L> {
    /// Lanes that overlap.
    pub(super) near: u8,
    /// Lanes that touched at the evaluation before.
    pub(super) before: u8,
    /// Normal from the second to the first partner.
    pub(super) n: Vec8<L>,
    /// Gap, m.
    pub(super) gap: L,
    /// Velocity of the first against the second centre, m/s.
    pub(super) v: Vec8<L>,
    /// l_i ω_i + l_j ω_j, m/s.
    pub(super) rolling: Vec8<L>,
    /// ω_i + ω_j, rad/s.
    pub(super) spin: Vec8<L>,
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

/// What a pack of contacts does.
#[derive(Clone, Copy)]
pub(super) struct Answer8<L> {
    /// Lanes that bear a force.
    pub(super) touching: u8,
    /// Force on the first partner, N.
    pub(super) force: Vec8<L>,
    /// F_t × n, N: times a lever arm, the torque on either partner.
    pub(super) moment: Vec8<L>,
    /// dδ/dt, m/s.
    pub(super) rate: L,
}

impl<L: Lanes> LawLanes<L> {
    /// The law for a sub-step of `dt`; `arm` as the field.
    #[inline(always)]
    pub(super) fn new(token: L::Token, law: &LinearPair, dt: f64, arm: f64) -> Self {
        let splat = L::splat;
        let k_t = law.tangential_stiffness;
        Self {
            stiffness: splat(token, law.stiffness),
            damping: splat(token, law.damping),
            tangential_stiffness: splat(token, k_t),
            tangential_damping: splat(token, law.tangential_damping),
            friction: splat(token, law.friction),
            compliance: splat(token, if k_t > 0.0 { 1.0 / k_t } else { 0.0 }),
            arm: splat(token, if law.at_contact_point { arm } else { 0.0 }),
            dt: splat(token, dt),
            capped: law.capped && k_t > 0.0,
            zero: splat(token, 0.0),
            half: splat(token, 0.5),
            one: splat(token, 1.0),
        }
    }

    /// |δ_t|², and a value that may be divided by.
    #[inline(always)]
    pub(super) fn length2(&self, token: L::Token, spring: Vec8<L>) -> (L, L) {
        let length2 = spring.dot(spring);
        (length2, length2.select(L::splat(token, NOTHING).lt(length2), self.one))
    }

    /// Force, moment and the spring's step.
    #[inline(always)]
    pub(super) fn resolve(&self, token: L::Token, c: &Contact8<L>, spring: &mut Vec8<L>) -> Answer8<L> {
        let n = c.n;
        let rate = c.v.dot(n);
        // what begins within the step: interact::Onset
        let (mut slipped, mut dashpot) = (self.dt, self.one);
        let begins = c.near & !c.before;
        if begins != 0 {
            let within = begins & (rate * self.dt * L::splat(token, 1.001)).lt(c.gap);
            let since = c.gap / rate;
            slipped = since.select(within, slipped);
            dashpot = (self.half + since / self.dt).select(within, dashpot);
        }
        // F_n = max(0, −m* (k δ + γ dδ/dt)), eq. 15
        let pull = c.mass * (self.stiffness * c.gap + self.damping * (rate * dashpot));
        let normal = (self.zero - pull).max(self.zero);
        let touching = c.near & self.zero.lt(normal);
        let slip = c.v.minus(n.scale(rate)).minus(c.rolling.cross(n));
        let mut turn = n.scale(self.half * n.dot(c.spin));
        if let Some(inverse) = c.inverse_distance {
            turn = n.cross(c.v).scale(inverse).plus(turn);
        }
        let mut s = self.carry(token, c, *spring, turn.scale(self.dt)).plus(slip.scale(slipped));
        // F_t = −min(|k_t δ_t + γ_t v_t|, μ F_n) along itself, eq. 16
        let k_t = self.tangential_stiffness * c.mass;
        let drag = slip.scale(dashpot * (self.tangential_damping * c.mass));
        let mut pulled = s.scale(k_t).plus(drag);
        let size2 = pulled.dot(pulled);
        let limit = self.friction * normal;
        let sliding = (limit * limit).lt(size2);
        if sliding & touching != 0 {
            let cut = pulled.scale(limit / size2.sqrt());
            pulled = cut.select(sliding, pulled);
            if self.capped {
                let held = cut.minus(drag).scale(c.inverse_mass * self.compliance);
                s = held.select(sliding, s);
            }
        }
        let zero = Vec8(self.zero, self.zero, self.zero);
        *spring = s.select(touching, zero);
        let force = n.scale(normal).minus(pulled).select(touching, zero);
        let moment = n.cross(pulled).select(touching, zero);
        Answer8 { touching, force, moment, rate }
    }

    /// Turns the spring, lays it into the contact plane and restores its length
    /// ([`crate::tangential::carry`]). The length changes by a part ε of 1e-6 and less in a sub-step,
    /// so 1/√(1 − ε) is a short series; lanes with a larger one take the root.
    #[inline(always)]
    fn carry(&self, token: L::Token, c: &Contact8<L>, s: Vec8<L>, turn: Vec8<L>) -> Vec8<L> {
        let first = turn.cross(s);
        let turned = s.plus(first).plus(turn.cross(first).scale(self.half));
        let flat = turned.minus(c.n.scale(c.n.dot(turned)));
        let flat2 = flat.dot(flat);
        let lost = (c.length2 - flat2) * c.inverse_length2;
        let k = |value| L::splat(token, value);
        let mut grow =
            self.one + lost * (self.half + lost * (k(0.375) + lost * (k(0.3125) + lost * k(0.2734375))));
        let limit = k(SERIES);
        let far = limit.lt(lost) | lost.lt(self.zero - limit);
        if far & c.near != 0 {
            let some = self.zero.lt(flat2);
            let root = (c.length2 / flat2).sqrt().select(some, self.zero);
            grow = root.select(far, grow);
        }
        flat.scale(grow)
    }
}
