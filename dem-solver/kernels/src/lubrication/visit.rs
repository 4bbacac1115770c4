//! Films of a sub-step, eight at a time: their laws at the present gaps, sweeps over them, and their forces.

use crate::grain::Shape;
use crate::lubrication::brake::{Spins, left};
use crate::lubrication::film_list::FilmList;
use crate::lubrication::law::{Expansion, LINE_SERIES, LubricationLaw, LubricationModel};
use crate::lubrication::packs::FilmPack;
use crate::lubrication::rows::Rows;
use crate::motion::Vec3;
use crate::vector::kernel::Kernel;
use crate::vector::lanes::{Lanes, Lanes8, Mask};
use crate::vector::rows::{Row, columns, write};
use crate::vector::vec3::Vec3Lanes;

/// A sweep that changes no gap rate by more than this part of the largest is the last. After a window of 87
/// sub-steps the velocities of a dense bed are 0.1 to 0.2 of this part off.
const CONVERGED: f64 = 1e-6;

/// All that a pass over the films reads and changes.
pub(super) struct Pass<'a> {
    pub(super) model: &'a LubricationModel,
    pub(super) list: &'a FilmList,
    pub(super) packs: &'a mut [FilmPack],
    pub(super) rows: &'a mut Rows,
    pub(super) sweeps: u32,
    pub(super) dt: f64,
    /// Mean force on each grain, N: added to.
    pub(super) force: &'a mut [Vec3],
    /// Mean force on each wall, N: added to.
    pub(super) on_walls: &'a mut [Vec3],
}

impl Kernel for Pass<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes8>(self, token: L::Token) {
        if self.rows.free.is_empty() {
            self.all::<L, false>(token);
        } else {
            self.all::<L, true>(token);
        }
    }
}

impl Pass<'_> {
    #[inline(always)]
    fn all<L: Lanes8, const LOCKED: bool>(self, token: L::Token) {
        let Self { model, list, packs, rows, sweeps, dt, force, on_walls } = self;
        let (motion, free) = (&mut rows.motion[..], &rows.free[..]);
        for pack in &mut *packs {
            begin::<L, LOCKED>(token, model, list, pack, (motion, free), dt);
        }
        for _ in 0..sweeps {
            if sweep::<L, LOCKED>(token, model, list, packs, (motion, free), dt) {
                break;
            }
        }
        let rate = 1.0 / dt;
        for pack in packs {
            let normal = Vec3Lanes::<L>::load(token, &pack.normal);
            let mut push = normal.scale(L::load(token, &pack.impulse) * L::splat(token, rate));
            if model.tangential {
                let left = left(model, list, pack);
                if left != [[0.0; 8]; 2] {
                    let spins = Spins { turning: &mut rows.turning, free: &rows.free, turns: &rows.turns };
                    let slid = spins.brake::<L, LOCKED>(token, list, pack, &left, &mut rows.motion, dt);
                    push = slid.scale_plus(L::splat(token, rate), push);
                }
            }
            add(token, pack, push, (force, on_walls));
        }
    }
}

/// Adds the forces `push` on first partners to the sums; second ones get as much less.
#[inline(always)]
fn add<L: Lanes8>(
    _: L::Token,
    pack: &FilmPack,
    push: Vec3Lanes<L>,
    (force, on_walls): (&mut [Vec3], &mut [Vec3]),
) {
    let mut lanes = [[0.0; 8]; 3];
    push.store(&mut lanes);
    let [x, y, z] = &lanes;
    for (k, (i, j)) in pack.i.iter().zip(&pack.j).enumerate() {
        let push = Vec3::new(x[k], y[k], z[k]);
        // the last row, of lanes without a film, is of no grain and no wall
        if let Some(first) = force.get_mut(*i as usize) {
            *first += push;
        }
        let (n, second) = (force.len(), *j as usize);
        let second = if second < n { force.get_mut(second) } else { on_walls.get_mut(second - n) };
        if let Some(second) = second {
            *second -= push;
        }
    }
}

/// Both partners of eight films, as they move along the normals.
struct Partners<L: Lanes> {
    /// Velocities.
    v: [Vec3Lanes<L>; 2],
    /// Inverse masses.
    weight: [L; 2],
    /// Velocity per impulse.
    yields: [Vec3Lanes<L>; 2],
}

impl<L: Lanes8> Partners<L> {
    #[inline(always)]
    fn load<const LOCKED: bool>(
        token: L::Token,
        pack: &FilmPack,
        motion: &[Row],
        free: &[Row],
        n: Vec3Lanes<L>,
    ) -> Self {
        let [ax, ay, az, wa, bx, by, bz, wb] = columns::<L>(token, motion, &pack.i, &pack.j);
        let (mut na, mut nb) = (n, n);
        if LOCKED {
            let [ax, ay, az, _, bx, by, bz, _] = columns::<L>(token, free, &pack.i, &pack.j);
            na = Vec3Lanes(n.0 * ax, n.1 * ay, n.2 * az);
            nb = Vec3Lanes(n.0 * bx, n.1 * by, n.2 * bz);
        }
        let v = [Vec3Lanes(ax, ay, az), Vec3Lanes(bx, by, bz)];
        Self { v, weight: [wa, wb], yields: [na.scale(wa), nb.scale(wb)] }
    }

    /// Gives the impulse `kick` to the first, and takes it from the second.
    #[inline(always)]
    fn push(self, pack: &FilmPack, motion: &mut [Row], kick: L) {
        let a = self.yields[0].scale_plus(kick, self.v[0]);
        let b = self.yields[1].scale_from(kick, self.v[1]);
        let columns = [a.0, a.1, a.2, self.weight[0], b.0, b.1, b.2, self.weight[1]];
        write(columns, motion, &pack.i, &pack.j);
    }
}

/// Geometry and law of a pack in this sub-step, and the impulses to begin with: those of the sub-step before,
/// grown as they grew to that.
#[inline(always)]
fn begin<L: Lanes8, const LOCKED: bool>(
    token: L::Token,
    model: &LubricationModel,
    list: &FilmList,
    pack: &mut FilmPack,
    (motion, free): (&mut [Row], &[Row]),
    dt: f64,
) {
    let [x, y, z, gap, c, roughness, cut_off, shift] = list.columns::<L>(token, &pack.entry);
    let n = Vec3Lanes(x, y, z);
    let partners = Partners::load::<LOCKED>(token, pack, motion, free, n);
    let inverse_mass = partners.yields[0].plus(partners.yields[1]).dot(n);
    n.store(&mut pack.normal);
    gap.store(&mut pack.gap);
    inverse_mass.store(&mut pack.inverse_mass);
    expand(token, model, pack, [gap, c, roughness, cut_off, shift, inverse_mass], dt);
    // no film without anything that it can move
    let zero = L::splat(token, 0.0);
    let some = zero.lt(inverse_mass);
    let (impulse, former) = (L::load(token, &pack.impulse), L::load(token, &pack.former));
    let growth = (impulse - former).select(pack.twice & some, zero);
    let impulse = impulse.select(pack.seen & some, zero);
    impulse.store(&mut pack.former);
    (pack.twice, pack.seen) = (pack.seen, pack.filled);
    let impulse = impulse + growth;
    impulse.store(&mut pack.impulse);
    partners.push(pack, motion, impulse);
}

/// [`LubricationLaw::expansion`] of eight films: the same expressions.
#[inline(always)]
fn expand<L: Lanes8>(
    token: L::Token,
    model: &LubricationModel,
    pack: &mut FilmPack,
    [gap, coefficient, roughness, cut_off, shift, inverse_mass]: [L; 6],
    dt: f64,
) {
    let k = |value: f64| L::splat(token, value);
    let (zero, one, two) = (k(0.0), k(1.0), k(2.0));
    // In overlap there is no film, and no root of what would be left of a.
    let a = gap.max(zero) + roughness;
    let [k1, k2, k3, k4] = match model.shape {
        Shape::Sphere => {
            let x = a * k(1.0 / model.resolved_length);
            let x2 = x * x;
            let (x4, x12) = (k(4.0) * x, k(12.0) * x2);
            let p = one / (one + two * x + two * x2);
            let (c, r) = (coefficient * p, (one + x4 + k(6.0) * x2) * p);
            let (second, third) = ((x4 + x12) * p, x12 * p);
            let k3 = c * k(1.0 / 6.0) * (two * r * r - second);
            [c, k(-0.5) * c * r, k3, c * k(1.0 / 24.0) * (k(6.0) * r * (second - r * r) - third)]
        }
        Shape::Disc => {
            let b = a + k(model.length());
            let (c, d, t) = (coefficient / a.sqrt(), coefficient / b.sqrt(), a / b);
            let t2 = t * t;
            let [p1, p2, p3, p4] = LINE_SERIES.map(k);
            [(c - d * t) * p1, (c - d * t2) * p2, (c - d * (t2 * t)) * p3, (c - d * (t2 * t2)) * p4]
        }
    };
    let k1 = k1 - shift * a;
    let inertia = a * k(1.0 / dt);
    let inverse = one / inverse_mass.times_plus(k1, inertia);
    let (free, braked) = (inertia * inverse, inverse_mass * inverse * k2);
    let third = free * (k3 - two * braked * k2);
    let fourth = free * (k4 + k(5.0) * braked * (braked * k2 - k3));
    let within = k(1.0 - Expansion::BEND) / a;
    let far = k(Expansion::FAR);
    // the larger of the lower ends: least of both upper ones, turned round
    let low = ((zero - gap) * within).max(zero - far);
    let high = zero - ((gap - cut_off) * within).max(zero - far);
    let outside: u8 = gap.lt(zero) | cut_off.lt(gap);
    k1.store(&mut pack.c[0]);
    (free * k2).store(&mut pack.c[1]);
    third.store(&mut pack.c[2]);
    fourth.store(&mut pack.c[3]);
    inverse.store(&mut pack.inverse);
    k(f64::INFINITY).select(outside, low).store(&mut pack.low);
    k(f64::NEG_INFINITY).select(outside, high).store(&mut pack.high);
}

/// One pass over all films, each solved against the present velocities; true when nothing worth another pass
/// changed.
#[inline(always)]
fn sweep<L: Lanes8, const LOCKED: bool>(
    token: L::Token,
    model: &LubricationModel,
    list: &FilmList,
    packs: &mut [FilmPack],
    (motion, free): (&mut [Row], &[Row]),
    dt: f64,
) -> bool {
    let zero = L::splat(token, 0.0);
    let step = L::splat(token, dt);
    let (mut change, mut largest) = (zero, zero);
    for pack in packs {
        let n = Vec3Lanes::<L>::load(token, &pack.normal);
        let partners = Partners::load::<LOCKED>(token, pack, motion, free, n);
        let inverse_mass = L::load(token, &pack.inverse_mass);
        let before = L::load(token, &pack.impulse);
        let rate = partners.v[0].minus(partners.v[1]).dot(n);
        let without = inverse_mass.times_from(before, rate);
        let y = without * L::load(token, &pack.inverse);
        let [c1, c2, c3, c4] = &pack.c;
        let series = y.times_plus(L::load(token, c4), L::load(token, c3));
        let series = y.times_plus(y.times_plus(series, L::load(token, c2)), L::load(token, c1));
        let short: u8 = !(y.lt(L::load(token, &pack.low)) | L::load(token, &pack.high).lt(y));
        let mut impulse = (zero - y * series).select(short & pack.filled, zero);
        // overlaps that last have no film; logarithms are rare
        let gap = L::load(token, &pack.gap);
        let flat: u8 = !(zero.lt(gap) | zero.lt(without.times_plus(step, gap)));
        let long = pack.filled & !short & !flat & zero.lt(inverse_mass);
        if Mask::any(long) {
            let mut rates = [0.0; 8];
            without.store(&mut rates);
            impulse = L::load(token, &long_paths(model, list, pack, long, &rates, dt)).select(long, impulse);
        }
        impulse = impulse.select(zero.lt(inverse_mass), zero);
        impulse.store(&mut pack.impulse);
        let kick = impulse - before;
        let changed = inverse_mass * kick;
        change = changed.max((zero - changed).max(change));
        largest = without.max((zero - without).max(largest));
        partners.push(pack, motion, kick);
    }
    let (mut changes, mut rates) = ([0.0; 8], [0.0; 8]);
    change.store(&mut changes);
    largest.store(&mut rates);
    let most = |lanes: &[f64; 8]| lanes.iter().copied().fold(0.0, f64::max);
    most(&changes) <= CONVERGED * most(&rates)
}

/// [`LubricationLaw::impulse`] in some lanes.
#[inline(never)]
fn long_paths(
    model: &LubricationModel,
    list: &FilmList,
    pack: &FilmPack,
    lanes: u8,
    rates: &[f64; 8],
    dt: f64,
) -> [f64; 8] {
    let mut impulse = [0.0; 8];
    for k in (0..8).filter(|k| lanes >> k & 1 == 1) {
        let law: LubricationLaw = list.law(model, pack.entry[k] as usize);
        impulse[k] = law.impulse(pack.gap[k], rates[k], dt, pack.inverse_mass[k]);
    }
    impulse
}
