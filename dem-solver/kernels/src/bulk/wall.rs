//! Contacts with walls: the law of pairs with the plane's normal, eight grains at one wall at a time.

use crate::bulk::law::{Contact, LawLanes};
use crate::bulk::observed::Observed;
use crate::bulk::pair::add;
use crate::bulk::records::{ContactPack, ForceTorque, GrainRecord};
use crate::laws::coefficients::LinearPair;
use crate::laws::walls::Plane;
use crate::vector::lanes::Lanes8;
use crate::vector::vec3::Vec3Lanes;

/// Adds the forces of all wall contacts to `push` at time `t`.
#[inline(always)]
pub(super) fn wall_forces<L: Lanes8>(
    token: L::Token,
    (law, walls): (&LinearPair, &[Plane]),
    (t, dt): (f64, f64),
    packs: &mut [ContactPack],
    own: &[GrainRecord],
    push: &mut [ForceTorque],
    observed: &mut Observed,
) {
    let law = LawLanes::<L>::new(token, law, dt);
    for pack in packs {
        let plane = &walls[pack.wall as usize];
        if !plane.acts(t) {
            pack.touching = 0;
            pack.spring = [[0.0; 8]; 3];
            continue;
        }
        let n = Vec3Lanes::splat(token, plane.normal.into());
        let mut rows = [law.zero; 8];
        for (row, i) in rows.iter_mut().zip(pack.i) {
            *row = L::load(token, &own[i as usize].a);
        }
        let [x, y, z, r, vx, vy, vz, inverse_mass] = L::transpose(rows);
        let apart = Vec3Lanes(x, y, z).minus(Vec3Lanes::splat(token, plane.point.into()));
        let moved = L::splat(token, plane.moved(t));
        let distance = apart.dot(n) - moved;
        let overlap = r - distance;
        // a lane without a grain has no radius and no mass
        let overlapping = law.zero.lt(overlap) & law.zero.lt(r);
        if overlapping == 0 && pack.touching == 0 {
            continue;
        }
        let mut deep = [0.0; 8];
        overlap.select(overlapping, law.zero).store(&mut deep);
        observed.overlap = deep.iter().copied().fold(observed.overlap, f64::max);
        let none = [0.0; 4];
        let mut spins = [law.zero; 8];
        for (spin, i) in spins.iter_mut().zip(pack.i) {
            *spin = L::load_halves(token, &own[i as usize].b, &none);
        }
        let [ax, ay, az, ..] = L::transpose(spins);
        let w = Vec3Lanes(ax, ay, az);
        let arm = distance;
        let mut spring = Vec3Lanes::load(token, &pack.spring);
        let (length2, divisor) = law.length2(token, spring);
        let one = L::splat(token, 1.0) / (inverse_mass * divisor);
        let contact = Contact {
            overlapping,
            before: pack.touching,
            n,
            overlap,
            v: Vec3Lanes(vx, vy, vz).minus(Vec3Lanes::splat(token, plane.velocity_at(t).into())),
            rolling: w.scale(arm),
            spin: w,
            inverse_distance: None,
            mass: one * divisor,
            inverse_mass,
            inverse_length2: one * inverse_mass,
            length2,
        };
        let answer = law.resolve(token, &contact, &mut spring);
        spring.store(&mut pack.spring);
        if answer.touching != pack.touching {
            let mut rate = [0.0; 8];
            answer.rate.store(&mut rate);
            observed.pair_event(pack, answer.touching, &rate, true);
            pack.touching = answer.touching;
        }
        if answer.touching == 0 {
            continue;
        }
        let (f, t, zero) = (answer.force, answer.moment.scale(arm), law.zero);
        let first = L::transpose([f.0, f.1, f.2, zero, t.0, t.1, t.2, zero]);
        for (i, what) in pack.i.iter().zip(first) {
            add(token, push, *i as usize, what);
            // One after the other: grains share a pack by the list's age.
            add(token, &mut observed.walls, pack.wall as usize, what);
        }
    }
}
