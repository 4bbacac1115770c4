//! The tangential film of sliding surfaces ([`crate::lubrication::sliding`]) in a sub-step, eight gaps at a
//! time.

use crate::lubrication::film_list::FilmList;
use crate::lubrication::law::LubricationModel;
use crate::lubrication::packs::FilmPack;
use crate::lubrication::sliding::unresolved;
use crate::vector::lanes::Lanes8;
use crate::vector::rows::{Row, both, columns, write};
use crate::vector::vec3::Vec3Lanes;

/// What the flow does not resolve of the films of a pack; zero where there is none.
pub(super) fn left(model: &LubricationModel, list: &FilmList, pack: &FilmPack) -> [[f64; 8]; 2] {
    let mut left = [[0.0; 8]; 2];
    for k in (0..8).filter(|k| pack.filled >> k & 1 == 1) {
        let at = pack.entry[k] as usize;
        [left[0][k], left[1][k]] = unresolved(model, pack.gap[k], list.roughness(at), list.film[at][3]);
    }
    left
}

/// What a film of sliding surfaces reads and changes besides velocities.
pub(super) struct Spins<'a> {
    pub(super) turning: &'a mut [Row],
    /// Free axes, where some grain is locked along or about some only.
    pub(super) free: &'a [Row],
    pub(super) turns: &'a [Row],
}

impl Spins<'_> {
    /// Brakes the tangential motion in the films of a pack over `dt`, both squares one after the other; the
    /// impulse on the first partners.
    #[inline(always)]
    pub(super) fn brake<L: Lanes8, const LOCKED: bool>(
        self,
        token: L::Token,
        list: &FilmList,
        pack: &FilmPack,
        left: &[[f64; 8]; 2],
        motion: &mut [Row],
        dt: f64,
    ) -> Vec3Lanes<L> {
        let [slip, shift, roll, _, ri, rj, part, _] =
            both::<L>(token, (&list.film, &pack.entry), (&list.body, &pack.entry));
        let n = Vec3Lanes::load(token, &pack.normal);
        let [slid, rolled] = left.each_ref().map(|left| L::load(token, left) * L::splat(token, dt));
        let [ax, ay, az, mass_i, bx, by, bz, mass_j] = columns::<L>(token, motion, &pack.i, &pack.j);
        let (vi, vj) = (Vec3Lanes(ax, ay, az), Vec3Lanes(bx, by, bz));
        let [ax, ay, az, spin_i, bx, by, bz, spin_j] = columns::<L>(token, self.turning, &pack.i, &pack.j);
        let (wi, wj) = (Vec3Lanes(ax, ay, az), Vec3Lanes(bx, by, bz));
        // arms to the middle of the gap: with them the angular momentum is kept
        let half = part * L::load(token, &pack.gap);
        let (arm_i, arm_j) = (ri + half - shift, rj + half + shift);
        let apart = vi.minus(vj);
        let turn = wi.scale(arm_i).plus(wj.scale(arm_j));
        let slipped = n.scale_from(apart.dot(n), apart).minus(turn.cross(n));
        // the largest over directions: with locked ones it brakes a little less
        let inverse = mass_i + mass_j + arm_i * arm_i * spin_i + arm_j * arm_j * spin_j;
        let impulse = slipped.scale(braking(token, slip * slid, inverse));
        let moment = n.cross(impulse);
        let [pi, pj] = along::<L, LOCKED>(token, self.free, pack, impulse);
        let (vi, vj) = (pi.scale_plus(mass_i, vi), pj.scale_from(mass_j, vj));
        write([vi.0, vi.1, vi.2, mass_i, vj.0, vj.1, vj.2, mass_j], motion, &pack.i, &pack.j);
        let [mi, mj] = along::<L, LOCKED>(token, self.turns, pack, moment);
        let (wi, wj) = (mi.scale_from(arm_i * spin_i, wi), mj.scale_from(arm_j * spin_j, wj));
        // what rolls: the spins against each other, across the normal
        let turn = wi.minus(wj);
        let across = n.scale_from(turn.dot(n), turn);
        let torque = across.scale(braking(token, roll * rolled, spin_i + spin_j));
        let [ti, tj] = along::<L, LOCKED>(token, self.turns, pack, torque);
        let (wi, wj) = (ti.scale_plus(spin_i, wi), tj.scale_from(spin_j, wj));
        write([wi.0, wi.1, wi.2, spin_i, wj.0, wj.1, wj.2, spin_j], self.turning, &pack.i, &pack.j);
        impulse
    }
}

/// Impulse over velocity where a resistance brakes for `strength`/resistance seconds: −K dt/(1 + K dt W).
#[inline(always)]
fn braking<L: Lanes8>(token: L::Token, strength: L, inverse: L) -> L {
    (L::splat(token, 0.0) - strength) / strength.times_plus(inverse, L::splat(token, 1.0))
}

/// What of `what` both partners can follow, `rows` being 1 along or about their free axes.
#[inline(always)]
fn along<L: Lanes8, const LOCKED: bool>(
    token: L::Token,
    rows: &[Row],
    pack: &FilmPack,
    what: Vec3Lanes<L>,
) -> [Vec3Lanes<L>; 2] {
    if !LOCKED {
        return [what, what];
    }
    let [ax, ay, az, _, bx, by, bz, _] = columns::<L>(token, rows, &pack.i, &pack.j);
    [Vec3Lanes(what.0 * ax, what.1 * ay, what.2 * az), Vec3Lanes(what.0 * bx, what.1 * by, what.2 * bz)]
}
