//! Contacts between grains, sixteen at a time.

use crate::bulk::law::{Contact, LawLanes};
use crate::bulk::observed::Observed;
use crate::bulk::records::{ContactPack, ForceTorque, GrainRecord};
use crate::vector::images::Images;
use crate::vector::lane_pair::LanePair;
use crate::vector::lanes::{Lanes, Lanes8, Mask};
use crate::vector::vec3::Vec3Lanes;

/// Records of first partners, or with `SPINS` their spins and radii twice, plus those of second ones with
/// `signs`, as columns. The signs are 1 or −1: one rounding, that of the sum.
#[inline(always)]
fn columns<L: Lanes8, const SPINS: bool>(
    token: L::Token,
    pack: &ContactPack,
    own: &[GrainRecord],
    second: &[GrainRecord],
    signs: L,
) -> [L; 8] {
    let mut rows = [signs; 8];
    for (k, row) in rows.iter_mut().enumerate() {
        let (i, j) = (pack.i[k] as usize, pack.j[k] as usize);
        *row = if SPINS {
            L::load_twice(token, &second[j].b).times_plus(signs, L::load_twice(token, &own[i].b))
        } else {
            L::load(token, &second[j].a).times_plus(signs, L::load(token, &own[i].a))
        };
    }
    L::transpose(rows)
}

#[inline(always)]
fn side_by_side<L: Copy>(a: [L; 8], b: [L; 8]) -> [LanePair<L>; 8] {
    std::array::from_fn(|k| LanePair(a[k], b[k]))
}

/// Adds the forces of all packs, whose number is even, to `push`. With `CROSS`, second partners are rows
/// of `others` and get nothing; else they are rows of `own`.
#[inline(always)]
pub(super) fn pair_forces<L: Lanes8, const PERIODIC: bool, const CROSS: bool>(
    token: L::Token,
    law: &LawLanes<LanePair<L>>,
    images: &Images<LanePair<L>>,
    packs: &mut [ContactPack],
    own: &[GrainRecord],
    others: &[GrainRecord],
    push: &mut [ForceTorque],
    observed: &mut Observed,
) {
    let second = if CROSS { others } else { own };
    let nearly = LanePair::splat(token, 1.0 + 1e-12);
    let apart = L::load(token, &[-1.0, -1.0, -1.0, 1.0, -1.0, -1.0, -1.0, 1.0]);
    let around = L::load(token, &[1.0, 1.0, 1.0, 1.0, -1.0, -1.0, -1.0, -1.0]);
    let mut deepest = law.zero;
    let (twos, _) = packs.as_chunks_mut::<2>();
    for [p, q] in twos {
        // differences of centres and velocities, sums of radii and inverse masses
        let [mut dx, mut dy, mut dz, reach, vx, vy, vz, inverse_mass] = side_by_side(
            columns::<L, false>(token, p, own, second, apart),
            columns::<L, false>(token, q, own, second, apart),
        );
        if PERIODIC {
            dx = images.nearest(0, dx);
            dy = images.nearest(1, dy);
            dz = images.nearest(2, dz);
        }
        let d = Vec3Lanes(dx, dy, dz);
        let distance2 = d.dot(d);
        if !distance2.lt(reach * reach * nearly).any() && p.touching | q.touching == 0 {
            continue;
        }
        let distance = distance2.sqrt();
        let overlap = reach - distance;
        let overlapping = law.zero.lt(overlap);
        deepest = overlap.max(deepest);
        // sums of spins and radii, then their differences
        let [sx, sy, sz, _, ex, ey, ez, differ] = side_by_side(
            columns::<L, true>(token, p, own, second, around),
            columns::<L, true>(token, q, own, second, around),
        );
        // lever arms (|d| ± (r_i − r_j))/2: to the middle of the overlap
        let base = law.half * distance;
        let differ = law.half * differ;
        let (sum, difference) = (Vec3Lanes(sx, sy, sz), Vec3Lanes(ex, ey, ez));
        let (ps, qs) = (Vec3Lanes::load(token, &p.spring), Vec3Lanes::load(token, &q.spring));
        let mut spring = Vec3Lanes(LanePair(ps.0, qs.0), LanePair(ps.1, qs.1), LanePair(ps.2, qs.2));
        let (length2, divisor) = law.length2(token, spring);
        // one division for three: 1/(|d| · 1/m* · |δ_t|²)
        let (mass_divisor, distance_divisor) = (inverse_mass * divisor, distance * divisor);
        let one = law.one / (distance * mass_divisor);
        let inverse_distance = one * mass_divisor;
        let contact = Contact {
            overlapping,
            before: LanePair(p.touching, q.touching),
            n: d.scale(inverse_distance),
            overlap,
            v: Vec3Lanes(vx, vy, vz),
            rolling: sum.scale_plus(base, difference.scale(differ)),
            spin: sum,
            inverse_distance: Some(inverse_distance),
            mass: one * distance_divisor,
            inverse_mass,
            inverse_length2: one * (distance * inverse_mass),
            length2,
        };
        let answer = law.resolve(token, &contact, &mut spring);
        Vec3Lanes(spring.0.0, spring.1.0, spring.2.0).store(&mut p.spring);
        Vec3Lanes(spring.0.1, spring.1.1, spring.2.1).store(&mut q.spring);
        let touching = answer.touching;
        if touching != LanePair(p.touching, q.touching) {
            for (pack, touching, lanes) in
                [(&mut *p, touching.0, answer.rate.0), (&mut *q, touching.1, answer.rate.1)]
            {
                let mut rate = [0.0; 8];
                lanes.store(&mut rate);
                observed.pair_event(pack, touching, &rate, CROSS);
                pack.touching = touching;
            }
        }
        let (f, m) = (answer.force, answer.moment);
        let (arm_i, arm_j) = (base + differ, base - differ);
        if touching.0 != 0 {
            let (f, m) = (Vec3Lanes(f.0.0, f.1.0, f.2.0), Vec3Lanes(m.0.0, m.1.0, m.2.0));
            scatter::<L, CROSS>(token, law.zero.0, p, push, f, m, arm_i.0, arm_j.0);
        }
        if touching.1 != 0 {
            let (f, m) = (Vec3Lanes(f.0.1, f.1.1, f.2.1), Vec3Lanes(m.0.1, m.1.1, m.2.1));
            scatter::<L, CROSS>(token, law.zero.0, q, push, f, m, arm_i.1, arm_j.1);
        }
    }
    for lanes in [deepest.0, deepest.1] {
        let mut depth = [0.0; 8];
        lanes.store(&mut depth);
        observed.overlap = depth.iter().copied().fold(observed.overlap, f64::max);
    }
}

/// Adds forces `f` and torques arm × `m` of a pack to its grains, lane by lane: the order of a sum must not
/// depend on where a pack begins.
#[inline(always)]
fn scatter<L: Lanes8, const CROSS: bool>(
    token: L::Token,
    z: L,
    pack: &ContactPack,
    push: &mut [ForceTorque],
    f: Vec3Lanes<L>,
    m: Vec3Lanes<L>,
    arm_i: L,
    arm_j: L,
) {
    let t = m.scale(arm_i);
    let first = L::transpose([f.0, f.1, f.2, z, t.0, t.1, t.2, z]);
    if CROSS {
        for (i, what) in pack.i.iter().zip(first) {
            add(token, push, *i as usize, what);
        }
    } else {
        let t = m.scale(arm_j);
        let second = L::transpose([z - f.0, z - f.1, z - f.2, z, t.0, t.1, t.2, z]);
        for k in 0..8 {
            add(token, push, pack.i[k] as usize, first[k]);
            add(token, push, pack.j[k] as usize, second[k]);
        }
    }
}

/// Adds eight numbers to one grain's.
#[inline(always)]
pub(super) fn add<L: Lanes8>(token: L::Token, push: &mut [ForceTorque], i: usize, what: L) {
    let to = &mut push[i].0;
    (L::load(token, to) + what).store(to);
}
