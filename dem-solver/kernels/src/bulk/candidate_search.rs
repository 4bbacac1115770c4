//! When candidates have to be searched again, block by block.
//!
//! Lists are taken from pairs within a much wider skin. What a block has found is good as long as its grains
//! and those of all blocks about it have not moved too far *since it searched*; how far is measured, as
//! sums of largest speeds are far above what any one grain has really moved. Grains that fall above a bed
//! are so searched often, the bed below seldom.

use crate::bulk::block_search::Search;
use crate::bulk::candidates::{BlockBox, CandidateStatus};
use crate::bulk::engine::Bulk;
use crate::bulk::records::GrainRecord;
use crate::bulk::sync::{lock, mutex_mut, on_threads, read, rwlock_mut};
use crate::search::cells::{CELLS, extent};
use std::sync::Mutex;

/// Candidates reach so many times as far as the lists, so far over the mean diameter at least and at
/// most, and so many times as far as the lists whatever comes.
const CANDIDATE_SKIN: (f64, f64, f64, f64) = (5.0, 0.1, 0.5, 1.6);

/// Lists that are this much wider must still be found among the candidates: hardly enough now would not be
/// enough soon.
const RESERVE: f64 = 1.5;

/// Gap of two boxes, m; axes of a period count as none.
fn gap(a: &BlockBox, b: &BlockBox, length: [f64; 3]) -> f64 {
    let along = |axis: usize| match length[axis] > 0.0 {
        true => 0.0,
        false => (b.low[axis] - a.high[axis]).max(a.low[axis] - b.high[axis]).max(0.0),
    };
    (0..3).map(|axis| along(axis).powi(2)).sum::<f64>().sqrt()
}

impl Bulk {
    /// Searches candidates wherever the present lists could not be taken from it.
    pub(super) fn refresh_candidates(&mut self, t: f64) {
        let count = self.blocks.block.len();
        if !self.valid {
            self.candidates.place = vec![BlockBox::default(); count];
            self.candidates.good_to = Vec::new();
            self.candidates.extend(self.blocks.inactive, 0, count);
        }
        self.measure();
        self.note_stale();
        if self.candidates.stale.iter().any(|stale| *stale) {
            self.choose_candidate_skins();
            self.search(t);
            self.note_search();
        }
    }

    /// Boxes about the blocks, and how far grains have moved since the blocks searched.
    fn measure(&mut self) {
        let periods = self.periods;
        let from = if self.valid { self.blocks.inactive } else { 0 };
        for b in from..self.blocks.block.len() {
            let rows: &[GrainRecord] = rwlock_mut(&mut self.blocks.rows[b][self.now]);
            let block = mutex_mut(&mut self.blocks.block[b]);
            let rows = &rows[..block.len()];
            let place = &mut self.candidates.place[b];
            (place.low, place.high) = extent(rows.iter().map(GrainRecord::position));
            let mut most2 = 0.0f64;
            if self.valid {
                for (row, origin) in rows.iter().zip(&block.origin) {
                    let x = row.position();
                    let d = periods.nearest([x[0] - origin[0], x[1] - origin[1], x[2] - origin[2]].into());
                    most2 = most2.max(d.norm_squared());
                }
            }
            place.off = most2.sqrt() * (1.0 + 1e-12);
        }
    }

    /// Finds the blocks whose search is too old for the skins of the lists.
    fn note_stale(&mut self) {
        let (inactive, count, length) = (self.blocks.inactive, self.blocks.block.len(), self.common.length);
        let (place, skins) = (&self.candidates.place, &self.lists.skins);
        let far = |b: usize, c: usize| 0.5 * RESERVE * (skins[b].width + skins[c].width);
        // paths are sums of many numbers
        let round_off = 1e-9 * self.diameter;
        self.candidates.stale.clear();
        for b in 0..count {
            let own = &place[b];
            let stale = b >= inactive && {
                let good_to = &self.candidates.good_to[(b - inactive) * count..][..count];
                let walls = own.off + self.wall_path - own.wall_path + RESERVE * skins[b].width + round_off;
                walls > own.searched
                    || (0..count).any(|c| {
                        own.off + place[c].before + place[c].off + far(b, c) + round_off > good_to[c]
                            && gap(own, &place[c], length) <= 2.0 * self.largest + far(b, c)
                    })
            };
            self.candidates.stale.push(stale);
        }
    }

    /// How wide a search is, block by block.
    fn choose_candidate_skins(&mut self) {
        let d = self.diameter;
        for (place, skin) in self.candidates.place.iter_mut().zip(&self.lists.skins) {
            let most = (CANDIDATE_SKIN.0 * skin.width).clamp(CANDIDATE_SKIN.1 * d, CANDIDATE_SKIN.2 * d);
            place.skin = most.max(CANDIDATE_SKIN.3 * RESERVE * skin.width);
        }
        self.candidates.place[..self.blocks.inactive].iter_mut().for_each(|place| place.skin = 0.0);
    }

    /// Searches from now on count from here.
    fn note_search(&mut self) {
        let (inactive, count) = (self.blocks.inactive, self.blocks.block.len());
        let Self { blocks, candidates, now, wall_path, .. } = self;
        let CandidateStatus { place, good_to, stale } = candidates;
        for b in (inactive..count).filter(|&b| stale[b]) {
            let rows: &[GrainRecord] = rwlock_mut(&mut blocks.rows[b][*now]);
            let block = mutex_mut(&mut blocks.block[b]);
            block.origin.clear();
            block.origin.extend(rows[..block.inverse_inertia.len()].iter().map(GrainRecord::position));
            let own = &mut place[b];
            (own.before, own.off) = (own.before + own.off, 0.0);
            (own.searched, own.wall_path) = (own.skin, *wall_path);
        }
        for b in (inactive..count).filter(|&b| stale[b]) {
            for (c, good_to) in good_to[(b - inactive) * count..][..count].iter_mut().enumerate() {
                // a grain that is off now has come from where it was, and may go back through there
                *good_to = 0.5 * (place[b].skin + place[c].skin) + place[c].before - place[c].off;
            }
        }
    }

    /// Finds the candidates for the stale blocks.
    fn search(&mut self, t: f64) {
        let (now, inactive, count) = (self.now, self.blocks.inactive, self.blocks.block.len());
        let place = &self.candidates.place;
        // as far as a block looks: up to blocks that are so near that they could have a pair
        let reach: Vec<f64> = (0..count)
            .map(|b| {
                let to = |c: usize| 2.0 * self.largest + 0.5 * (place[b].skin + place[c].skin);
                let near = (0..count).filter(|&c| gap(&place[b], &place[c], self.common.length) <= to(c));
                if self.candidates.stale[b] { near.map(to).fold(0.0, f64::max) } else { 0.0 }
            })
            .collect();
        let mean = place[inactive..].iter().map(|place| place.skin).sum::<f64>() / (count - inactive) as f64;
        let most = reach.iter().copied().fold(0.0, f64::max);
        let cell = (2.0 * self.largest + mean).max(most / CELLS as f64);
        let guards: Vec<_> = self.blocks.rows.iter().map(|rows| read(&rows[now])).collect();
        let rows = guards.iter().map(|rows| rows.split_last().map_or(&[][..], |(_, rows)| rows));
        // radii with half the skins
        let grains = rows.zip(place).flat_map(|(rows, BlockBox { skin, .. })| {
            let radius = move |row: &GrainRecord| row.a[3] + 0.5 * skin;
            rows.iter()
                .map(move |row| ([row.a[0], row.a[1], row.a[2], radius(row)], row.inverse_mass() > 0.0))
        });
        self.cells.sort(grains, self.n, cell, &self.periods);
        drop(guards);
        let (blocks, threads, stale) = (&self.blocks, self.list_scratch.len(), &self.candidates.stale);
        let far = Mutex::new(0);
        on_threads(&mut self.list_scratch, |k, scratch| {
            for b in blocks.blocks_of_thread(k, threads) {
                let mut block = lock(&blocks.block[b]);
                if stale[b] {
                    let search = Search {
                        common: &self.common,
                        cells_of_grains: &self.cells,
                        skin: place[b].skin,
                        cells: if reach[b] <= cell { 1 } else { CELLS },
                        t,
                        grains: self.n,
                        inactive,
                    };
                    block.search(&search, &read(&blocks.rows[b][now]), &mut scratch.search);
                }
                let mut far = lock(&far);
                *far = block.reach.max(*far);
            }
        });
        self.reach = far.into_inner().unwrap_or_default();
    }
}
