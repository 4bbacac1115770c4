//! Contacts between grains, eight at a time: gaps of all listed pairs, then the law of those that touch.
//!
//! For linear contacts with a contact time, without rolling and without an account of energy. Every sum has
//! the order and every operation the rounding of the scalar loop (`general::forces`), so that the bits are
//! the same.

use crate::general::contact::Kinematics;
use crate::general::pair_law::{Contacts, Law, Relative, cross, dot};
use crate::general::sums::Forces;
use crate::grains::{Grains, Response};
use crate::laws::coefficients::LinearPair;
use crate::motion::Vec3;
use crate::report::Observations;
use crate::search::contact_list::ContactList;
use crate::surroundings::Surroundings;
use crate::vector::images::Images;
use crate::vector::kernel::Kernel;
use crate::vector::lanes::Lanes8;
use crate::vector::rows::{EACH, Row, columns, load_all, pairs, rows_minus, write_pairs};
use crate::vector::vec3::Vec3Lanes;

/// Grains as rows, pairs in eights, and the contacts found.
#[derive(Clone, Debug, Default)]
pub(crate) struct PairLanes {
    place: Vec<Row>,
    motion: [Vec<Row>; 2],
    spin: [Vec<Row>; 2],
    /// Force and torque of each grain.
    sums: [Vec<Row>; 2],
    /// All pairs, and lanes without a pair up to the next eight.
    eights: Vec<Eight>,
    /// Smallest gap of each grain over the window, but for the pairs of `eights`.
    smallest: Vec<f64>,
    /// Entries whose force must be evaluated, with their gaps.
    acting: Vec<u32>,
    gap: Vec<f64>,
    /// Leave the widest vectors unused (tests).
    pub(crate) plain: bool,
}

/// Eight pairs of the list.
#[derive(Clone, Debug)]
struct Eight {
    first: [u32; 8],
    second: [u32; 8],
    /// Radii of both.
    radius: [[f64; 8]; 2],
    /// Smallest gaps since the list was built or the window began.
    smallest: [f64; 8],
}

impl PairLanes {
    /// `plain` leaves the widest vectors unused.
    pub(crate) fn new(plain: bool) -> Self {
        Self { plain, ..Self::default() }
    }

    /// Takes a new list of pairs.
    pub(crate) fn take(&mut self, list: &ContactList, grains: &Grains) {
        self.smallest.resize(grains.len(), f64::INFINITY);
        self.gather();
        self.eights.clear();
        let none = grains.len() as u32;
        for (first, second) in list.first.chunks(8).zip(list.other.chunks(8)) {
            let mut eight = Eight {
                first: [none; 8],
                second: [none; 8],
                radius: [[0.0; 8]; 2],
                smallest: [f64::INFINITY; 8],
            };
            eight.first[..first.len()].copy_from_slice(first);
            eight.second[..second.len()].copy_from_slice(second);
            for (k, (i, j)) in first.iter().zip(second).enumerate() {
                eight.radius[0][k] = grains.radius[*i as usize];
                eight.radius[1][k] = grains.radius[*j as usize];
            }
            self.eights.push(eight);
        }
        let count = list.len();
        self.acting.reserve(count.saturating_sub(self.acting.len()));
        self.gap.reserve(count.saturating_sub(self.gap.len()));
    }

    /// Hands the smallest gaps of pairs to their grains.
    fn gather(&mut self) {
        for Eight { first, second, smallest, .. } in &mut self.eights {
            for (gap, grain) in smallest.iter().chain(&*smallest).zip(first.iter().chain(&*second)) {
                if let Some(of) = self.smallest.get_mut(*grain as usize) {
                    *of = gap.min(*of);
                }
            }
            smallest.fill(f64::INFINITY);
        }
    }

    /// Ends a window: its smallest gaps go to the observations.
    pub(crate) fn finish(&mut self, observed: &mut Observations) {
        self.gather();
        for (gap, of) in self.smallest.iter_mut().zip(&mut observed.smallest_gap) {
            *of = of.min(std::mem::replace(gap, f64::INFINITY));
        }
    }

    /// Takes the present state. False if some grain can turn but not move: then m* is no sum of inverse
    /// masses.
    pub(crate) fn load(&mut self, grains: &Grains, response: &Response, kinematics: &Kinematics<'_>) -> bool {
        let row = |v: &Vec3, last: f64| [v.x, v.y, v.z, last];
        let weights = &response.contact_inverse_mass;
        if (0..grains.len()).any(|i| weights[i] == 0.0 && grains.responds(i)) {
            return false;
        }
        self.place.clear();
        self.place.extend(grains.position.iter().zip(&grains.radius).map(|(x, r)| row(x, *r)));
        // one more for lanes without a pair
        self.place.push([0.0; 4]);
        let now = Some((kinematics.velocity, kinematics.spin));
        for (k, (velocity, spin)) in [now, kinematics.path].into_iter().flatten().enumerate() {
            self.motion[k].clear();
            self.motion[k].extend(velocity.iter().zip(weights).map(|(v, weight)| row(v, *weight)));
            self.motion[k].push([0.0, 0.0, 0.0, 1.0]);
            self.spin[k].clear();
            self.spin[k].extend(spin.iter().map(|spin| row(spin, 0.0)));
            self.spin[k].push([0.0; 4]);
        }
        for sums in &mut self.sums {
            sums.clear();
            sums.resize(grains.len() + 1, [0.0; 4]);
        }
        true
    }
}

/// One evaluation of all pairs.
pub(crate) struct PairPass<'a> {
    pub(crate) around: &'a Surroundings,
    pub(crate) law: &'a LinearPair,
    pub(crate) kinematics: &'a Kinematics<'a>,
    pub(crate) lanes: &'a mut PairLanes,
    pub(crate) list: &'a mut ContactList,
    /// Forces on the grains, replaced; the largest overlap.
    pub(crate) forces: &'a mut Forces,
    pub(crate) observed: &'a mut Observations,
}

impl Kernel for PairPass<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes8>(mut self, token: L::Token) {
        let images = Images::<L>::new(token, self.around.periods.length);
        self.find(token, &images);
        self.resolve(token, &images);
        let Forces { contact, torque, .. } = self.forces;
        for (total, rows) in [contact, torque].into_iter().zip(&self.lanes.sums) {
            for (total, [x, y, z, _]) in total.iter_mut().zip(rows) {
                *total = Vec3::new(*x, *y, *z);
            }
        }
    }
}

impl PairPass<'_> {
    /// Gaps of all pairs, and which must be evaluated: overlaps, and once more contacts that end.
    #[inline(always)]
    fn find<L: Lanes8>(&mut self, token: L::Token, images: &Images<L>) {
        let Self { around, lanes, list, forces, .. } = self;
        let PairLanes { place, eights, acting, gap: gaps, .. } = &mut **lanes;
        acting.clear();
        gaps.clear();
        let (zero, reach) = (L::splat(token, 0.0), L::splat(token, around.range));
        let mut overlap = L::splat(token, forces.overlap);
        for (at, (eight, touching)) in eights.iter_mut().zip(list.touching.chunks(8)).enumerate() {
            let apart =
                rows_minus(pairs::<L>(token, place, &eight.first), pairs(token, place, &eight.second));
            let [x, y, z, _] = L::columns_of(apart);
            let d = Vec3Lanes(images.nearest(0, x), images.nearest(1, y), images.nearest(2, z));
            let [ri, rj] = load_all::<L, 2>(token, &eight.radius);
            let gap = dot(d, d).sqrt() - ri - rj;
            let mut touches = 0u8;
            for (k, touching) in touching.iter().enumerate() {
                touches |= u8::from(*touching) << k;
            }
            let listed = u8::MAX >> (8 - touching.len());
            let near = listed & (touches | !reach.lt(gap));
            let smallest = L::load(token, &eight.smallest);
            let less = near & gap.lt(smallest);
            gap.select(less, smallest).store(&mut eight.smallest);
            overlap = (zero - gap).max(overlap).select(near, overlap);
            let mut acts = listed & (touches | gap.lt(zero));
            if acts != 0 {
                let mut each = [0.0; 8];
                gap.store(&mut each);
                while acts != 0 {
                    let k = acts.trailing_zeros() as usize;
                    acts &= acts - 1;
                    acting.push((8 * at + k) as u32);
                    gaps.push(each[k]);
                }
            }
        }
        let mut overlaps = [0.0; 8];
        overlap.store(&mut overlaps);
        forces.overlap = overlaps.into_iter().fold(0.0, f64::max);
    }

    /// Forces and springs of the contacts found.
    #[inline(always)]
    fn resolve<L: Lanes8>(&mut self, token: L::Token, images: &Images<L>) {
        let Self { law, kinematics, lanes, list, observed, .. } = self;
        let PairLanes { place, motion, spin, sums, acting, gap: gaps, .. } = &mut **lanes;
        let [contact, torque] = sums;
        let none = place.len() as u32 - 1;
        let law = Law::splat(token, law);
        let zero = L::splat(token, 0.0);
        for (entries, gap) in acting.chunks(8).zip(gaps.chunks(8)) {
            let (mut first, mut second) = ([none; 8], [none; 8]);
            let (mut each, mut springs, mut begins) = ([1.0; 8], [[0.0; 8]; 3], u8::MAX);
            each[..gap.len()].copy_from_slice(gap);
            for (k, entry) in entries.iter().enumerate() {
                let entry = *entry as usize;
                (first[k], second[k]) = (list.first[entry], list.other[entry]);
                let spring = &list.spring[entry];
                (springs[0][k], springs[1][k], springs[2][k]) = (spring.x, spring.y, spring.z);
                begins &= !(u8::from(list.touching[entry]) << k);
            }
            let [xi, yi, zi, ri, xj, yj, zj, rj] = columns::<L>(token, place, &first, &second);
            let d =
                Vec3Lanes(images.nearest(0, xi - xj), images.nearest(1, yi - yj), images.nearest(2, zi - zj));
            let distance = dot(d, d).sqrt();
            let some: u8 = zero.lt(distance);
            let up = Vec3Lanes(zero, zero, L::splat(token, 1.0));
            let normal = Vec3Lanes(d.0 / distance, d.1 / distance, d.2 / distance).select(some, up);
            let gap = L::load(token, &each);
            let (now, inverse) = relative(token, (&motion[0], &spin[0]), &first, &second);
            let path = if kinematics.path.is_some() {
                relative(token, (&motion[1], &spin[1]), &first, &second).0
            } else {
                now
            };
            let half = L::splat(token, 0.5);
            let arms = (ri + half * gap, rj + half * gap);
            let mass = L::splat(token, 1.0) / inverse;
            let dt = kinematics.dt;
            let contacts = Contacts { begins, normal, gap, distance, mass, arms, now, path, dt };
            let answer = contacts.resolve(token, &law, Vec3Lanes::load(token, &springs));
            let moment = cross(answer.tangential, normal);
            let mut out = [[[0.0; 4]; 8]; 4];
            let (on_i, on_j) = (moment.scale(arms.0), moment.scale(arms.1));
            for (out, what) in out.iter_mut().zip([answer.spring, answer.force, on_i, on_j]) {
                write_pairs(L::rows_of([what.0, what.1, what.2, zero]), out, &EACH);
            }
            let mut rates = [0.0; 8];
            answer.rate.store(&mut rates);
            for (k, entry) in entries.iter().enumerate() {
                let (entry, i, j) = (*entry as usize, first[k] as usize, second[k] as usize);
                let bears = answer.bears >> k & 1 == 1;
                let [x, y, z, _] = out[0][k];
                list.spring[entry] = Vec3::new(x, y, z);
                observed.note_event((list.touching[entry], bears), rates[k], i, Some(j));
                list.touching[entry] = bears;
                for c in 0..4 {
                    contact[i][c] += out[1][k][c];
                    torque[i][c] += out[2][k][c];
                }
                for c in 0..4 {
                    contact[j][c] -= out[1][k][c];
                    torque[j][c] += out[3][k][c];
                }
            }
        }
    }
}

/// Relative motion, and the sum of the inverse masses.
#[inline(always)]
fn relative<L: Lanes8>(
    token: L::Token,
    (motion, spin): (&[Row], &[Row]),
    first: &[u32; 8],
    second: &[u32; 8],
) -> (Relative<L>, L) {
    let [ax, ay, az, wa, bx, by, bz, wb] = columns::<L>(token, motion, first, second);
    let velocity = Vec3Lanes(ax - bx, ay - by, az - bz);
    let [ax, ay, az, _, bx, by, bz, _] = columns::<L>(token, spin, first, second);
    let spin = (Vec3Lanes(ax, ay, az), Vec3Lanes(bx, by, bz));
    (Relative { velocity, spin }, wa + wb)
}
