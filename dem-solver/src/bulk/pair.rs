//! Contacts between grains, eight at a time.

use super::lanes::Lanes;
use super::law::{Contact8, LawLanes, Vec8};
use super::row::{Pack, Push, Row};
use super::seen::Seen;

/// Nearest images along periodic axes: d − L round(d/L), the rounding by adding and taking away
/// 1.5 × 2⁵², so that d and −d give the same.
#[derive(Clone, Copy)]
pub(super) struct Images<L> {
    length: [L; 3],
    inverse: [L; 3],
    shift: L,
}

impl<L: Lanes> Images<L> {
    /// Lengths of the periods, 0 where there is none.
    #[inline(always)]
    pub(super) fn new(token: L::Token, length: [f64; 3]) -> Self {
        let inverse = |l: f64| if l > 0.0 { 1.0 / l } else { 0.0 };
        let splat = |v: f64| L::splat(token, v);
        Self {
            length: [splat(length[0]), splat(length[1]), splat(length[2])],
            inverse: [splat(inverse(length[0])), splat(inverse(length[1])), splat(inverse(length[2]))],
            shift: splat(6_755_399_441_055_744.0),
        }
    }

    #[inline(always)]
    fn nearest(&self, axis: usize, d: L) -> L {
        d - self.length[axis] * ((d * self.inverse[axis] + self.shift) - self.shift)
    }
}

/// Adds the forces of all packs to `push`. With `CROSS`, second partners are rows of `others` and get
/// nothing; else they are rows of `own`.
#[inline(always)]
pub(super) fn pair_forces<L: Lanes, const PERIODIC: bool, const CROSS: bool>(
    token: L::Token,
    law: &LawLanes<L>,
    images: &Images<L>,
    packs: &mut [Pack],
    own: &[Row],
    others: &[Row],
    push: &mut [Push],
    seen: &mut Seen,
) {
    let second = if CROSS { others } else { own };
    let nearly = L::splat(token, 1.0 + 1e-12);
    let mut deepest = law.zero;
    for pack in packs {
        let mut rows = [law.zero; 8];
        for (k, row) in rows.iter_mut().enumerate() {
            let (i, j) = (pack.i[k] as usize, pack.j[k] as usize);
            *row = L::load(token, &own[i].a).apart(L::load(token, &second[j].a));
        }
        let [mut dx, mut dy, mut dz, reach, vx, vy, vz, inverse_mass] = L::transpose(rows);
        if PERIODIC {
            dx = images.nearest(0, dx);
            dy = images.nearest(1, dy);
            dz = images.nearest(2, dz);
        }
        let d = Vec8(dx, dy, dz);
        let distance2 = d.dot(d);
        if distance2.lt(reach * reach * nearly) == 0 && pack.touching == 0 {
            continue;
        }
        let distance = distance2.sqrt();
        let gap = distance - reach;
        let near = gap.lt(law.zero);
        deepest = deepest.max((law.zero - gap).select(near, law.zero));
        let mut spins = [law.zero; 8];
        for (k, spin) in spins.iter_mut().enumerate() {
            let (i, j) = (pack.i[k] as usize, pack.j[k] as usize);
            *spin = L::load_halves(token, &own[i].b, &second[j].b);
        }
        let [ax, ay, az, r_i, bx, by, bz, r_j] = L::transpose(spins);
        let (w_i, w_j) = (Vec8(ax, ay, az), Vec8(bx, by, bz));
        let middle = gap * law.arm;
        let (l_i, l_j) = (r_i + middle, r_j + middle);
        let mut spring = Vec8::load(token, &pack.spring);
        let (length2, divisor) = law.length2(token, spring);
        // one division for three: 1/(|d| · 1/m* · |δ_t|²)
        let one = L::splat(token, 1.0) / (distance * inverse_mass * divisor);
        let inverse_distance = one * (inverse_mass * divisor);
        let contact = Contact8 {
            near,
            before: pack.touching,
            n: d.scale(inverse_distance),
            gap,
            v: Vec8(vx, vy, vz),
            rolling: w_i.scale(l_i).plus(w_j.scale(l_j)),
            spin: w_i.plus(w_j),
            inverse_distance: Some(inverse_distance),
            mass: one * (distance * divisor),
            inverse_mass,
            inverse_length2: one * (distance * inverse_mass),
            length2,
        };
        let answer = law.resolve(token, &contact, &mut spring);
        spring.store(&mut pack.spring);
        if answer.touching != pack.touching {
            let mut rate = [0.0; 8];
            answer.rate.store(&mut rate);
            seen.pair_event(pack, answer.touching, &rate, CROSS);
            pack.touching = answer.touching;
        }
        if answer.touching == 0 {
            continue;
        }
        seen.contacts += answer.touching.count_ones() * if CROSS { 1 } else { 2 };
        let (f, z) = (answer.force, law.zero);
        let t = answer.moment.scale(l_i);
        let first = L::transpose([f.0, f.1, f.2, z, t.0, t.1, t.2, z]);
        if CROSS {
            for (i, what) in pack.i.iter().zip(first) {
                add(token, push, *i as usize, what);
            }
        } else {
            let t = answer.moment.scale(l_j);
            let second = L::transpose([z - f.0, z - f.1, z - f.2, z, t.0, t.1, t.2, z]);
            // lane by lane: the order of a sum must not depend on where a pack begins
            for k in 0..8 {
                add(token, push, pack.i[k] as usize, first[k]);
                add(token, push, pack.j[k] as usize, second[k]);
            }
        }
    }
    let mut depth = [0.0; 8];
    deepest.store(&mut depth);
    seen.overlap = depth.iter().copied().fold(seen.overlap, f64::max);
}

/// Adds eight numbers to one grain's.
#[inline(always)]
pub(super) fn add<L: Lanes>(token: L::Token, push: &mut [Push], i: usize, what: L) {
    let to = &mut push[i].0;
    (L::load(token, to) + what).store(to);
}
