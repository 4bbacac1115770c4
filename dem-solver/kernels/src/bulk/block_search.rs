//! Which grains are near those of a block: found through cells, eight candidates at a time, and seldom, as
//! lists are taken from them with a narrower skin many times.

use crate::bulk::block::{Block, Candidates, Common, Segment};
use crate::bulk::records::{GrainRecord, SIZE};
use crate::search::cells::{Cells, IMMOBILE};
use crate::vector::images::Images;
use crate::vector::kernel::{Kernel, dispatch};
use crate::vector::lanes::Lanes8;

/// Memory for searching.
#[derive(Clone, Debug, Default)]
pub(super) struct Scratch {
    found: Vec<u32>,
    /// Row, and number of the partner in another block.
    cross: Vec<(u16, u32)>,
    halo: Vec<u32>,
    /// Place of a grain in the halo, where it has one.
    slot: Vec<u32>,
}

/// What a search goes by.
pub(super) struct Search<'a> {
    pub(super) common: &'a Common,
    pub(super) cells_of_grains: &'a Cells,
    /// Skin of the block: a pair is a candidate if its gap is below half the sum of the blocks' skins, m.
    pub(super) skin: f64,
    /// How many cells further grains may be.
    pub(super) cells: usize,
    /// Time, s.
    pub(super) t: f64,
    pub(super) grains: usize,
    /// Inactive blocks: nobody waits for them.
    pub(super) inactive: usize,
}

impl Block {
    /// Finds the candidates; the contacts of the present lists become the history of the next.
    pub(super) fn search(&mut self, search: &Search<'_>, rows: &[GrainRecord], scratch: &mut Scratch) {
        // contacts are known by places in a halo that now changes
        self.save_history();
        let rows = &rows[..self.len()];
        let (first, candidates) = (self.first, &mut self.candidates);
        dispatch(BlockSearch { search, first, rows, candidates, scratch }, search.common.plain);
        self.reach = self.build_halo(search, scratch);
        self.candidates.walls.clear();
        for (w, plane) in (0u16..).zip(&search.common.walls) {
            let at = |row: &GrainRecord| {
                plane.stands(search.t) && row.inverse_mass() > 0.0 && row.gap(plane, search.t) < search.skin
            };
            let found = (0u16..).zip(rows).filter(|(_, row)| at(row));
            self.candidates.walls.extend(found.map(|(i, _)| (w, i)));
        }
    }

    /// The rows of other blocks that are read; returns how many blocks away they are at most. Leaves `slot`
    /// empty.
    fn build_halo(&mut self, search: &Search<'_>, scratch: &mut Scratch) -> usize {
        let Scratch { cross, halo, slot, .. } = scratch;
        let size = SIZE as u32;
        slot.resize(search.grains, u32::MAX);
        halo.clear();
        for &(_, j) in &*cross {
            if slot[j as usize] == u32::MAX {
                slot[j as usize] = 0;
                halo.push(j);
            }
        }
        halo.sort_unstable();
        self.halo.clear();
        self.segments.clear();
        let (here, mut reach) = (self.first / size, 0);
        for (k, &j) in (0u32..).zip(&*halo) {
            slot[j as usize] = k;
            let block = j / size;
            self.halo.push((j - block * size) as u16);
            match self.segments.last_mut() {
                Some(segment) if segment.block == block => segment.end = k + 1,
                _ => {
                    self.segments.push(Segment { block, end: k + 1 });
                    if block as usize >= search.inactive {
                        reach = reach.max(block.abs_diff(here) as usize);
                    }
                }
            }
        }
        self.candidates.cross.clear();
        self.candidates.cross.extend(cross.iter().map(|&(i, j)| (i, slot[j as usize])));
        for &j in &*halo {
            slot[j as usize] = u32::MAX;
        }
        reach
    }
}

/// Pairs of one block: those within it once, those with other blocks.
struct BlockSearch<'a> {
    search: &'a Search<'a>,
    /// Number of the block's first grain in the order of the engine.
    first: u32,
    /// Its grains, without the row that follows them.
    rows: &'a [GrainRecord],
    candidates: &'a mut Candidates,
    scratch: &'a mut Scratch,
}

impl Kernel for BlockSearch<'_> {
    type Output = ();

    /// Fills the lists by (i, j) ascending.
    #[inline(always)]
    fn run<L: Lanes8>(self, token: L::Token) {
        let Self { search, first, rows, candidates, scratch } = self;
        let (n, images) = (rows.len() as u32, Images::<L>::new(token, search.common.length));
        let Scratch { found, cross, .. } = scratch;
        candidates.pairs.clear();
        cross.clear();
        for (i, row) in (0u32..).zip(rows) {
            // a pair of grains that nothing moves does nothing
            let barred = if row.inverse_mass() > 0.0 { 0 } else { IMMOBILE };
            let count = neighbours_of::<L>(token, search, &images, row, found);
            let (pairs_from, cross_from) = (candidates.pairs.len(), cross.len());
            for &who in found[..count].iter().filter(|&who| who & barred == 0) {
                let j = who & !IMMOBILE;
                let within = j.wrapping_sub(first);
                if within >= n {
                    cross.push((i as u16, j));
                } else if within > i {
                    candidates.pairs.push((i as u16, within as u16));
                }
            }
            candidates.pairs[pairs_from..].sort_unstable();
            cross[cross_from..].sort_unstable();
        }
    }
}

/// Puts all grains that are near `row` into `found`, itself included; their number.
#[inline(always)]
fn neighbours_of<L: Lanes8>(
    token: L::Token,
    search: &Search<'_>,
    images: &Images<L>,
    row: &GrainRecord,
    found: &mut Vec<u32>,
) -> usize {
    // radii with half the skins
    let Cells { item: [xs, ys, zs, radii], who, .. } = search.cells_of_grains;
    let place = row.position();
    let [x, y, z] = place.map(|x| L::splat(token, x));
    let reach = L::splat(token, row.radius() + 0.5 * search.skin);
    let periodic = search.common.length != [0.0; 3];
    let mut count = 0;
    for &(from, to) in search.cells_of_grains.around(&place, search.cells).runs() {
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
