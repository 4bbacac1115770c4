//! Films of a sub-step, eight at a time: their laws at the present gaps, sweeps over them, and their forces.

use crate::grain::Shape;
use crate::lubrication::brake::brake;
use crate::lubrication::film_list::FilmList;
use crate::lubrication::law::{LubricationLaw, LubricationModel};
use crate::lubrication::packs::FilmPack;
use crate::lubrication::rows::Rows;
use crate::lubrication::sliding::unresolved;
use crate::vector::kernel::Kernel;
use crate::vector::lanes::{Lanes8, Mask, PAIR};
use crate::vector::rows::{Row, load_all, pairs, store_all, write_pairs};
use crate::vector::rows::{rows_from, rows_minus, rows_plus, rows_times};

/// A sweep that changes no gap rate by more than this part of the largest is the last. After a window of 87
/// sub-steps the velocities of a dense bed are 0.1 to 0.2 of this part off.
const CONVERGED: f64 = 1e-6;

/// Largest |y| of [`expand`]. The terms left out are 1e-12 of the path for two spheres, and 1e-10 where the
/// flow resolves most of it.
const FAR: f64 = 1.0 / 512.0;

/// s differs from y by less than this part at [`FAR`].
const BEND: f64 = 0.01;

/// 2 (1 − (1 + s)^{−1/2}) in powers of s.
const LINE_SERIES: [f64; 4] = [1.0, -0.75, 0.625, -0.546_875];

/// All that a pass over the films reads and changes.
pub(super) struct Pass<'a> {
    pub(super) model: &'a LubricationModel,
    pub(super) list: &'a FilmList,
    pub(super) packs: &'a mut [FilmPack],
    pub(super) rows: &'a mut Rows,
    pub(super) sweeps: u32,
    pub(super) dt: f64,
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
        let Self { model, list, packs, rows, sweeps, dt } = self;
        let (motion, free) = (&mut rows.motion[..], &rows.free[..]);
        for pack in &mut *packs {
            begin::<L, LOCKED>(token, model, list, pack, (motion, free), dt);
        }
        for _ in 0..sweeps {
            if sweep::<L, LOCKED>(token, model, packs, (motion, free), dt) {
                break;
            }
        }
        let (rate, step) = (L::splat(token, 1.0 / dt), L::splat(token, dt));
        for pack in packs {
            let force = (L::load(token, &pack.impulse) * rate).spread();
            let mut push = rows_times(load_all::<L, 4>(token, &pack.normal), force);
            if model.tangential {
                let [_, roughness, _, _] = load_all::<L, 4>(token, &pack.law.normal);
                let [_, _, _, length] = load_all::<L, 4>(token, &pack.law.film);
                let of = [L::load(token, &pack.gap), roughness, length];
                if let Some([slip, roll]) = unresolved(token, model, of) {
                    let slid = brake::<L, LOCKED>(token, pack, [slip * step, roll * step], rows);
                    push = rows_plus(slid, [rate; 4], push);
                }
            }
            // Lane after lane: films of a pack may share what does not move.
            let mut forces = [[0.0; 8]; 4];
            store_all(push, &mut forces);
            for (lane, (pair, from)) in PAIR.into_iter().enumerate() {
                let (i, j) = (pack.i[lane] as usize, pack.j[lane] as usize);
                for c in 0..4 {
                    rows.push[i][c] += forces[pair][from + c];
                }
                for c in 0..4 {
                    rows.push[j][c] -= forces[pair][from + c];
                }
            }
        }
    }
}

/// Gives the impulses `kick` to the first partners, which move as `first`, and takes them from the second.
#[inline(always)]
fn push<L: Lanes8, const LOCKED: bool>(
    token: L::Token,
    pack: &FilmPack,
    (normal, kick): ([L; 4], L),
    [first, second]: [[L; 4]; 2],
    (motion, free): (&mut [Row], &[Row]),
) {
    let [weight_i, weight_j] = load_all::<L, 2>(token, &pack.weight);
    let (mut along_i, mut along_j) = (normal, normal);
    if LOCKED {
        along_i = rows_times(normal, pairs(token, free, &pack.i));
        along_j = rows_times(normal, pairs(token, free, &pack.j));
    }
    write_pairs(rows_plus(along_i, (kick * weight_i).spread(), first), motion, &pack.i);
    write_pairs(rows_from(along_j, (kick * weight_j).spread(), second), motion, &pack.j);
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
    let near = pairs::<L>(token, &list.near, &pack.law.entry);
    let [_, _, _, gap] = L::columns_of(near);
    let normal = rows_times(near, [L::load_halves(token, &[1.0, 1.0, 1.0, 0.0], &[1.0, 1.0, 1.0, 0.0]); 4]);
    let partners = [pairs::<L>(token, motion, &pack.i), pairs::<L>(token, motion, &pack.j)];
    let ([.., weight_i], [.., weight_j]) = (L::columns_of(partners[0]), L::columns_of(partners[1]));
    let mut inverse_mass = weight_i + weight_j;
    if LOCKED {
        let squares = rows_times(normal, normal);
        let of_i = L::row_sums(rows_times(squares, pairs(token, free, &pack.i)));
        let of_j = L::row_sums(rows_times(squares, pairs(token, free, &pack.j)));
        inverse_mass = weight_i * of_i + weight_j * of_j;
    }
    store_all(normal, &mut pack.normal);
    store_all([weight_i, weight_j], &mut pack.weight);
    gap.store(&mut pack.gap);
    inverse_mass.store(&mut pack.inverse_mass);
    expand(token, model, pack, [gap, inverse_mass], dt);
    // no film without anything that it can move
    let zero = L::splat(token, 0.0);
    let some = zero.lt(inverse_mass);
    let (impulse, former) = (L::load(token, &pack.impulse), L::load(token, &pack.former));
    let growth = (impulse - former).select(pack.twice & some, zero);
    let impulse = impulse.select(pack.seen & some, zero);
    impulse.store(&mut pack.former);
    (pack.twice, pack.seen) = (pack.seen, u8::MAX);
    let impulse = impulse + growth;
    impulse.store(&mut pack.impulse);
    push::<L, LOCKED>(token, pack, (normal, impulse), partners, (motion, free));
}

/// Eight gaps over so short paths that each impulse is a polynomial in the gap rate: most gaps of a dense bed
/// in most sub-steps, at a tenth of the cost of the logarithms.
///
/// With s the relative change of δ + η and path = k₁ s + k₂ s² + k₃ s³ + k₄ s⁴ the rate after lubrication
/// solves (a/dt) s + path/m = U, that is s + Σ b_j s^j = y with b_j = k_j/(m N), y = U/N and N = a/dt + k₁/m.
/// This series turned around, s = y − b₂ y² + (2b₂² − b₃) y³ + (−5b₂³ + 5b₂b₃ − b₄) y⁴, is put into path = m
/// (U − (a/dt) s).
#[inline(always)]
fn expand<L: Lanes8>(
    token: L::Token,
    model: &LubricationModel,
    pack: &mut FilmPack,
    [gap, inverse_mass]: [L; 2],
    dt: f64,
) {
    let [coefficient, roughness, cut_off, shift] = load_all::<L, 4>(token, &pack.law.normal);
    let k = |value: f64| L::splat(token, value);
    let (zero, one, two) = (k(0.0), k(1.0), k(2.0));
    // In overlap there is no film, and no root of what would be left of a.
    let a = gap.max(zero) + roughness;
    let [k1, k2, k3, k4] = match model.shape {
        Shape::Sphere => {
            // path = c ∫ dσ/Q(σ) with Q = (1 + σ)(1 + 2x(1 + σ) + 2x²(1 + σ)²)
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
            // 2c (1 − (1 + s)^{−1/2})/a^½, and as much less of a + λL
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
    // Of both bends the nearer one bounds |y|; outside the film the free path to where it begins does.
    let beyond = (zero - gap).max(gap - cut_off);
    let outside: u8 = zero.lt(beyond);
    let within = zero - (beyond * (k(1.0 - BEND) / a)).max(k(-FAR));
    let limit = (beyond * k(1.0 / dt) * inverse).select(outside, within);
    let none = outside | !zero.lt(inverse_mass);
    let c = [k1, free * k2, third, fourth];
    for (c, kept) in c.into_iter().zip(&mut pack.c) {
        zero.select(none, c).store(kept);
    }
    inverse.store(&mut pack.inverse);
    limit.select(zero.lt(inverse_mass), k(f64::INFINITY)).store(&mut pack.limit);
}

/// One pass over all films, each solved against the present velocities; true when nothing worth another pass
/// changed.
#[inline(always)]
fn sweep<L: Lanes8, const LOCKED: bool>(
    token: L::Token,
    model: &LubricationModel,
    packs: &mut [FilmPack],
    (motion, free): (&mut [Row], &[Row]),
    dt: f64,
) -> bool {
    let zero = L::splat(token, 0.0);
    let (mut change, mut largest) = (zero, zero);
    for pack in packs {
        let normal = load_all::<L, 4>(token, &pack.normal);
        let partners = [pairs::<L>(token, motion, &pack.i), pairs::<L>(token, motion, &pack.j)];
        let inverse_mass = L::load(token, &pack.inverse_mass);
        let before = L::load(token, &pack.impulse);
        let rate = L::row_sums(rows_times(rows_minus(partners[0], partners[1]), normal));
        let without = inverse_mass.times_from(before, rate);
        let y = without * L::load(token, &pack.inverse);
        let [c1, c2, c3, c4] = load_all::<L, 4>(token, &pack.c);
        let series = y.times_plus(y.times_plus(y.times_plus(c4, c3), c2), c1);
        let impulse = zero - y * series;
        largest = without.max((zero - without).max(largest));
        let long = L::load(token, &pack.limit).lt(y.max(zero - y));
        if Mask::any(long) {
            // One by one to the end: what lives on through a call has no register.
            let (mut rates, mut impulses) = ([0.0; 8], [0.0; 8]);
            without.store(&mut rates);
            impulse.store(&mut impulses);
            let changed = long_paths(model, pack, (long, &rates, impulses), (motion, free), dt);
            change = L::load(token, &changed).max(change);
            continue;
        }
        impulse.store(&mut pack.impulse);
        let kick = impulse - before;
        let changed = inverse_mass * kick;
        change = changed.max((zero - changed).max(change));
        push::<L, LOCKED>(token, pack, (normal, kick), partners, (motion, free));
    }
    let (mut changes, mut rates) = ([0.0; 8], [0.0; 8]);
    change.store(&mut changes);
    largest.store(&mut rates);
    let most = |lanes: &[f64; 8]| lanes.iter().copied().fold(0.0, f64::max);
    most(&changes) <= CONVERGED * most(&rates)
}

/// The rest of a visit where paths are long in some `lanes`: [`LubricationLaw::impulse`] there. Returns how
/// much gap rates changed.
#[inline(never)]
fn long_paths(
    model: &LubricationModel,
    pack: &mut FilmPack,
    (lanes, rates, mut impulse): (u8, &[f64; 8], [f64; 8]),
    (motion, free): (&mut [Row], &[Row]),
    dt: f64,
) -> [f64; 8] {
    let mut changed = [0.0; 8];
    for k in 0..8 {
        if lanes >> k & 1 == 1 {
            let [coefficient, roughness, cut_off, shift] = pack.law.normal.each_ref().map(|column| column[k]);
            let (shape, resolved_length) = (model.shape, model.length());
            let law = LubricationLaw { shape, coefficient, roughness, cut_off, resolved_length, shift };
            impulse[k] = law.impulse(pack.gap[k], rates[k], dt, pack.inverse_mass[k]);
        }
        let kick = impulse[k] - pack.impulse[k];
        changed[k] = (pack.inverse_mass[k] * kick).abs();
        let (pair, from) = PAIR[k];
        for (row, share) in [(pack.i[k], pack.weight[0][k]), (pack.j[k], -pack.weight[1][k])] {
            let along = free.get(row as usize).unwrap_or(&[1.0; 4]);
            for (axis, v) in motion[row as usize][..3].iter_mut().enumerate() {
                *v += pack.normal[pair][from + axis] * along[axis] * (kick * share);
            }
        }
    }
    pack.impulse = impulse;
    changed
}
