//! The tangential film of sliding surfaces ([`crate::lubrication::sliding`]) in a sub-step, eight gaps at a
//! time.

use crate::lubrication::packs::FilmPack;
use crate::lubrication::rows::Rows;
use crate::vector::lanes::Lanes8;
use crate::vector::rows::{load_all, pairs, rows_from, rows_minus, rows_plus, rows_times, write_pairs};
use crate::vector::vec3::Vec3Lanes;

/// Brakes the tangential motion in the films of a pack, both squares one after the other, `strength` being
/// what is left of either times the sub-step; rows of the impulses on the first partners.
#[inline(always)]
pub(super) fn brake<L: Lanes8, const LOCKED: bool>(
    token: L::Token,
    pack: &FilmPack,
    strength: [L; 2],
    rows: &mut Rows,
) -> [L; 4] {
    let zero = L::splat(token, 0.0);
    let Rows { motion, turning, free, turns, .. } = rows;
    let (i, j) = (&pack.i, &pack.j);
    let [slip, shift, roll, _] = load_all::<L, 4>(token, &pack.law.film);
    let [ri, rj, part, _] = load_all::<L, 4>(token, &pack.law.body);
    let [mass_i, mass_j] = load_all::<L, 2>(token, &pack.weight);
    let [x, y, z, _] = L::columns_of(load_all::<L, 4>(token, &pack.normal));
    let n = Vec3Lanes(x, y, z);
    let (vi, vj) = (pairs::<L>(token, motion, i), pairs::<L>(token, motion, j));
    let [x, y, z, _] = L::columns_of(rows_minus(vi, vj));
    let apart = Vec3Lanes(x, y, z);
    let [x, y, z, spin_i] = L::columns_of(pairs(token, turning, i));
    let wi = Vec3Lanes(x, y, z);
    let [x, y, z, spin_j] = L::columns_of(pairs(token, turning, j));
    let wj = Vec3Lanes(x, y, z);
    // arms to the middle of the gap: with them the angular momentum is kept
    let half = part * L::load(token, &pack.gap);
    let (arm_i, arm_j) = (ri + half - shift, rj + half + shift);
    let turn = wi.scale(arm_i).plus(wj.scale(arm_j));
    let slipped = n.scale_from(apart.dot(n), apart).minus(turn.cross(n));
    // the largest over directions: with locked ones it brakes a little less
    let inverse = mass_i + mass_j + arm_i * arm_i * spin_i + arm_j * arm_j * spin_j;
    let impulse = slipped.scale(braking(token, slip * strength[0], inverse));
    let moment = n.cross(impulse);
    let pushed = L::rows_of([impulse.0, impulse.1, impulse.2, zero]);
    let (mut first, mut second) = (pushed, pushed);
    let (mut turn_i, mut turn_j) = (None, None);
    if LOCKED {
        first = rows_times(first, pairs(token, free, i));
        second = rows_times(second, pairs(token, free, j));
        let [x, y, z, _] = L::columns_of(pairs(token, turns, i));
        turn_i = Some(Vec3Lanes(x, y, z));
        let [x, y, z, _] = L::columns_of(pairs(token, turns, j));
        turn_j = Some(Vec3Lanes(x, y, z));
    }
    write_pairs(rows_plus(first, mass_i.spread(), vi), motion, i);
    write_pairs(rows_from(second, mass_j.spread(), vj), motion, j);
    let wi = along(moment, turn_i).scale_from(arm_i * spin_i, wi);
    let wj = along(moment, turn_j).scale_from(arm_j * spin_j, wj);
    // what rolls: the spins against each other, across the normal
    let turn = wi.minus(wj);
    let across = n.scale_from(turn.dot(n), turn);
    let torque = across.scale(braking(token, roll * strength[1], spin_i + spin_j));
    let wi = along(torque, turn_i).scale_plus(spin_i, wi);
    let wj = along(torque, turn_j).scale_from(spin_j, wj);
    write_pairs(L::rows_of([wi.0, wi.1, wi.2, spin_i]), turning, i);
    write_pairs(L::rows_of([wj.0, wj.1, wj.2, spin_j]), turning, j);
    pushed
}

/// Impulse over velocity where a resistance brakes for `strength`/resistance seconds: −K dt/(1 + K dt W).
#[inline(always)]
fn braking<L: Lanes8>(token: L::Token, strength: L, inverse: L) -> L {
    (L::splat(token, 0.0) - strength) / strength.times_plus(inverse, L::splat(token, 1.0))
}

/// What of `what` a grain follows that is locked along some axes, `free` being 1 along the others.
#[inline(always)]
fn along<L: Lanes8>(what: Vec3Lanes<L>, free: Option<Vec3Lanes<L>>) -> Vec3Lanes<L> {
    match free {
        Some(free) => Vec3Lanes(what.0 * free.0, what.1 * free.1, what.2 * free.2),
        None => what,
    }
}
