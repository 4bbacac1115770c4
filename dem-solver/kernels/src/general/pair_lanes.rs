//! Contacts between grains, eight at a time: gaps of all listed pairs, then the law of those that touch.
//!
//! For linear contacts with a contact time, without rolling and without an account of energy. Every sum has
//! the order and every operation the rounding of the scalar loop (`general::forces`), so that the bits are
//! the same.

use crate::general::contact::Kinematics;
use crate::general::pair_law::{Contacts, Law, Relative, cross};
use crate::grains::{Grains, Response};
use crate::laws::coefficients::LinearPair;
use crate::motion::Vec3;
use crate::report::Observations;
use crate::search::contact_list::ContactList;
use crate::surroundings::Surroundings;
use crate::vector::images::Images;
use crate::vector::kernel::Kernel;
use crate::vector::lanes::Lanes8;
use crate::vector::rows::{Row, columns};
use crate::vector::vec3::Vec3Lanes;

/// Grains as rows, and the contacts found.
#[derive(Clone, Debug, Default)]
pub(crate) struct PairLanes {
    place: Vec<Row>,
    motion: [Vec<Row>; 2],
    spin: [Vec<Row>; 2],
    /// Entries whose force must be evaluated, with their gaps.
    acting: Vec<u32>,
    gap: Vec<f64>,
    /// Leave the widest vectors unused (tests).
    plain: bool,
}

impl PairLanes {
    /// `plain` leaves the widest vectors unused.
    pub(crate) fn new(plain: bool) -> Self {
        Self { plain, ..Self::default() }
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
        let now = (kinematics.velocity, kinematics.spin);
        for (k, (velocity, spin)) in [now, kinematics.path.unwrap_or(now)].into_iter().enumerate() {
            if k == 1 && kinematics.path.is_none() {
                break;
            }
            self.motion[k].clear();
            self.motion[k].extend(velocity.iter().zip(weights).map(|(v, weight)| row(v, *weight)));
            self.motion[k].push([0.0, 0.0, 0.0, 1.0]);
            self.spin[k].clear();
            self.spin[k].extend(spin.iter().map(|spin| row(spin, 0.0)));
            self.spin[k].push([0.0; 4]);
        }
        true
    }

    /// Makes room for `count` contacts.
    pub(crate) fn reserve(&mut self, count: usize) {
        self.acting.reserve(count.saturating_sub(self.acting.len()));
        self.gap.reserve(count.saturating_sub(self.gap.len()));
    }

    /// Whether the widest vectors are left unused.
    pub(crate) fn is_plain(&self) -> bool {
        self.plain
    }
}

/// The sums that contacts add to.
pub(crate) struct Sums<'a> {
    pub(crate) contact: &'a mut [Vec3],
    pub(crate) torque: &'a mut [Vec3],
    pub(crate) observed: &'a mut Observations,
    pub(crate) contacts: usize,
    pub(crate) overlap: f64,
}

/// One evaluation of all pairs.
pub(crate) struct PairPass<'a> {
    pub(crate) around: &'a Surroundings,
    pub(crate) law: &'a LinearPair,
    pub(crate) kinematics: &'a Kinematics<'a>,
    pub(crate) lanes: &'a mut PairLanes,
    pub(crate) list: &'a mut ContactList,
    pub(crate) sums: Sums<'a>,
}

impl Kernel for PairPass<'_> {
    /// Contacts that bear a force, and the largest overlap.
    type Output = (usize, f64);

    #[inline(always)]
    fn run<L: Lanes8>(mut self, token: L::Token) -> (usize, f64) {
        let length = std::array::from_fn(|axis| self.around.periods.of(axis).1);
        let images = Images::<L>::new(token, length);
        self.find(token, &images);
        self.resolve(token, &images);
        (self.sums.contacts, self.sums.overlap)
    }
}

impl PairPass<'_> {
    /// Gaps of all pairs, and which must be evaluated: overlaps, and once more contacts that end.
    #[inline(always)]
    fn find<L: Lanes8>(&mut self, token: L::Token, images: &Images<L>) {
        let Self { around, lanes, list, sums, .. } = self;
        let PairLanes { place, acting, gap: gaps, .. } = &mut **lanes;
        acting.clear();
        gaps.clear();
        let none = place.len() as u32 - 1;
        let reach = L::splat(token, around.range);
        for from in (0..list.len()).step_by(8) {
            let count = (list.len() - from).min(8);
            let (mut first, mut second, mut touching) = ([none; 8], [none; 8], 0u8);
            first[..count].copy_from_slice(&list.first[from..from + count]);
            second[..count].copy_from_slice(&list.other[from..from + count]);
            for (k, touches) in list.touching[from..from + count].iter().enumerate() {
                touching |= u8::from(*touches) << k;
            }
            let (_, _, gap) = apart(token, images, place, &first, &second);
            let listed = u8::MAX >> (8 - count);
            let near = listed & (touching | !reach.lt(gap));
            if near == 0 {
                continue;
            }
            let acts = listed & (touching | gap.lt(L::splat(token, 0.0)));
            let mut each = [0.0; 8];
            gap.store(&mut each);
            for k in (0..count).filter(|k| near >> k & 1 == 1) {
                for grain in [first[k], second[k]] {
                    let smallest = &mut sums.observed.smallest_gap[grain as usize];
                    *smallest = smallest.min(each[k]);
                }
                sums.overlap = sums.overlap.max(-each[k]);
                if acts >> k & 1 == 1 {
                    acting.push((from + k) as u32);
                    gaps.push(each[k]);
                }
            }
        }
    }

    /// Forces and springs of the contacts found.
    #[inline(always)]
    fn resolve<L: Lanes8>(&mut self, token: L::Token, images: &Images<L>) {
        let Self { law, kinematics, lanes, list, sums, .. } = self;
        let PairLanes { place, motion, spin, acting, gap: gaps, .. } = &**lanes;
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
            let (d, distance, _) = apart(token, images, place, &first, &second);
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
            let [.., ri, _, _, _, rj] = columns::<L>(token, place, &first, &second);
            let half = L::splat(token, 0.5);
            let arms = (ri + half * gap, rj + half * gap);
            let mass = L::splat(token, 1.0) / inverse;
            let dt = kinematics.dt;
            let contacts = Contacts { begins, normal, gap, distance, mass, arms, now, path, dt };
            let answer = contacts.resolve(token, &law, Vec3Lanes::load(token, &springs));
            let moment = cross(answer.tangential, normal);
            let mut out = [[[0.0; 8]; 3]; 4];
            answer.spring.store(&mut out[0]);
            answer.force.store(&mut out[1]);
            moment.scale(arms.0).store(&mut out[2]);
            moment.scale(arms.1).store(&mut out[3]);
            let mut rates = [0.0; 8];
            answer.rate.store(&mut rates);
            for (k, entry) in entries.iter().enumerate() {
                let of = |what: usize| Vec3::new(out[what][0][k], out[what][1][k], out[what][2][k]);
                let (entry, i, j) = (*entry as usize, first[k] as usize, second[k] as usize);
                let bears = answer.bears >> k & 1 == 1;
                list.spring[entry] = of(0);
                if bears != list.touching[entry] {
                    list.touching[entry] = bears;
                    sums.note_event(bears, rates[k], i, j);
                }
                sums.contacts += usize::from(bears);
                sums.contact[i] += of(1);
                sums.contact[j] -= of(1);
                sums.torque[i] += of(2);
                sums.torque[j] += of(3);
            }
        }
    }
}

impl Sums<'_> {
    /// A contact begins or ends, with this gap rate.
    fn note_event(&mut self, begins: bool, rate: f64, i: usize, j: usize) {
        let Observations { impact_speed, rebound_speed, .. } = &mut *self.observed;
        let (speeds, speed) = if begins { (impact_speed, -rate) } else { (rebound_speed, rate) };
        speeds[i] = speed.max(0.0);
        speeds[j] = speed.max(0.0);
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

/// Vector between the centres, its length, and the gap.
#[inline(always)]
fn apart<L: Lanes8>(
    token: L::Token,
    images: &Images<L>,
    place: &[Row],
    first: &[u32; 8],
    second: &[u32; 8],
) -> (Vec3Lanes<L>, L, L) {
    let [xi, yi, zi, ri, xj, yj, zj, rj] = columns::<L>(token, place, first, second);
    let d = Vec3Lanes(images.nearest(0, xi - xj), images.nearest(1, yi - yj), images.nearest(2, zi - zj));
    let distance = (d.0 * d.0 + d.1 * d.1 + d.2 * d.2).sqrt();
    (d, distance, distance - ri - rj)
}
