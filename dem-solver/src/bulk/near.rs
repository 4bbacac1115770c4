//! Which grains are near those of a block: eight candidates at a time.

use super::bins::{Bins, IMMOBILE};
use super::lanes::{Eight, Plain};
use super::list::{Builder, Search};
use super::pair::Images;
use super::row::Row;
use pulp::{Simd, WithSimd};

/// Pairs of one block: those within it once, those with other blocks.
pub(super) struct Near<'a> {
    pub(super) search: &'a Search<'a>,
    /// Number of the block's first grain in the order of the engine.
    pub(super) first: u32,
    /// Its grains, without the row that follows them.
    pub(super) rows: &'a [Row],
    pub(super) builder: &'a mut Builder,
    /// Leave the widest vectors unused.
    pub(super) plain: bool,
}

impl Near<'_> {
    /// Fills the builder's lists by (i, j) ascending.
    pub(super) fn find(self) {
        #[cfg(target_arch = "x86_64")]
        if !self.plain
            && let Some(simd) = pulp::x86::V4::try_new()
        {
            return Simd::vectorize(simd, OnWide(self, simd));
        }
        self.run::<Plain>(());
    }

    #[inline(always)]
    fn run<L: Eight>(self, token: L::Token) {
        let Self { search, first, rows, builder, .. } = self;
        let (n, images) = (rows.len() as u32, Images::<L>::new(token, search.length));
        let Builder { found, inner, cross, .. } = builder;
        inner.clear();
        cross.clear();
        for (i, row) in (0u32..).zip(rows) {
            // a pair of grains that nothing moves does nothing
            let barred = if row.inverse_mass() > 0.0 { 0 } else { IMMOBILE };
            let count = candidates::<L>(token, search, &images, row, found);
            let (inner_from, cross_from) = (inner.len(), cross.len());
            for &who in &found[..count] {
                if who & barred != 0 {
                    continue;
                }
                let j = who & !IMMOBILE;
                let within = j.wrapping_sub(first);
                if within >= n {
                    cross.push((i as u16, j));
                } else if within > i {
                    inner.push((i as u16, j));
                }
            }
            inner[inner_from..].sort_unstable();
            cross[cross_from..].sort_unstable();
        }
    }
}

#[cfg(target_arch = "x86_64")]
struct OnWide<'a>(Near<'a>, pulp::x86::V4);

#[cfg(target_arch = "x86_64")]
impl WithSimd for OnWide<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        self.0.run::<super::wide::Wide>(self.1);
    }
}

/// Puts all grains whose gap to `row` is below the skin into `found`, itself included; their number.
#[inline(always)]
fn candidates<L: Eight>(
    token: L::Token,
    search: &Search<'_>,
    images: &Images<L>,
    row: &Row,
    found: &mut Vec<u32>,
) -> usize {
    let Bins { item: [xs, ys, zs, radii], who, .. } = search.bins;
    let place = row.position();
    let [x, y, z] = place.map(|x| L::splat(token, x));
    let reach = L::splat(token, row.radius() + search.skin);
    let periodic = search.length != [0.0; 3];
    let mut count = 0;
    for &(from, to) in search.bins.around(&place).runs() {
        let (mut k, to) = (from as usize, to as usize);
        if found.len() < count + (to - k) {
            found.resize(2 * (count + (to - k)), 0);
        }
        while k < to {
            // the lists go on for eight numbers behind the last grain
            let eight =
                |of: &[f64]| of[k..].first_chunk().map_or(L::splat(token, 0.0), |v| L::load(token, v));
            let (mut dx, mut dy, mut dz) = (x - eight(xs), y - eight(ys), z - eight(zs));
            if periodic {
                dx = images.nearest(0, dx);
                dy = images.nearest(1, dy);
                dz = images.nearest(2, dz);
            }
            let limit = reach + eight(radii);
            let distance2 = dz.times_plus(dz, dy.times_plus(dy, dx * dx));
            let mut hits = u32::from(distance2.lt(limit * limit)) & ((1u32 << (to - k).min(8)) - 1);
            while hits != 0 {
                found[count] = who[k + hits.trailing_zeros() as usize];
                count += 1;
                hits &= hits - 1;
            }
            k += 8;
        }
    }
    count
}
