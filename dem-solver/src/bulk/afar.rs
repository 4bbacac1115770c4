//! When the pairs that are near have to be searched again, block by block.
//!
//! Lists are taken from pairs within a much wider skin. What a block has found holds as long as its grains
//! and those of all blocks about it have not moved too far *since it searched*; how far is measured, as
//! sums of largest speeds are far above what any one grain has really moved. Rain above a bed is so
//! searched often, the bed below seldom.

use super::near::Search;
use super::row::Row;
use super::stretch::{lock, mine, on_threads, only, read};
use super::{Bulk, SIZE};
use std::sync::Mutex;

/// What is near reaches so many times as far as the lists, so far over the mean diameter at least and at
/// most, and so many times as far as the lists whatever comes.
const WIDER: (f64, f64, f64, f64) = (5.0, 0.1, 0.5, 1.6);

/// Lists that are this much wider must still be found in what is near: hardly enough now would not be enough soon.
const RESERVE: f64 = 1.5;

/// Cells that a search looks around itself at most.
pub(super) const CELLS: usize = 2;

/// Where the grains of a block are, and how they have moved.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Place {
    low: [f64; 3],
    high: [f64; 3],
    /// How far any grain may have moved until the block searched last, m.
    before: f64,
    /// How far any grain is from where it was then, m.
    off: f64,
    /// Path of the walls then, m.
    wall_path: f64,
    /// Skin of what is near: in its own search, and now, m.
    searched: f64,
    wide: f64,
}

impl Afar {
    /// From block `from` on, blocks are new or have other grains; there are `count` now.
    pub(super) fn extend(&mut self, asleep: usize, from: usize, count: usize) {
        let before = self.place.len();
        self.place.resize(count, Place::default());
        let row = |b: usize| match self.holds.get(b * before..(b + 1) * before) {
            Some(row) if asleep + b < from => &row[..from],
            _ => &[],
        };
        let holds = (0..count - asleep).flat_map(|b| {
            let known = row(b);
            known.iter().copied().chain(std::iter::repeat_n(f64::NEG_INFINITY, count - known.len()))
        });
        self.holds = holds.collect();
    }
}

/// Gap of two boxes, m; axes of a period count as none.
fn gap(a: &Place, b: &Place, length: [f64; 3]) -> f64 {
    let along = |axis: usize| match length[axis] > 0.0 {
        true => 0.0,
        false => (b.low[axis] - a.high[axis]).max(a.low[axis] - b.high[axis]).max(0.0),
    };
    (0..3).map(|axis| along(axis).powi(2)).sum::<f64>().sqrt()
}

/// What is near, of all blocks.
#[derive(Clone, Debug, Default)]
pub(super) struct Afar {
    place: Vec<Place>,
    /// Row by row for the blocks that are awake: up to which sum of paths a block's pairs with another one hold, m.
    holds: Vec<f64>,
    /// Blocks that must search.
    stale: Vec<bool>,
}

impl Bulk {
    /// Searches what is near wherever the present lists could not be taken from it.
    pub(super) fn refresh_near(&mut self, t: f64) {
        let count = self.blocks.block.len();
        if !self.valid {
            self.afar.place = vec![Place::default(); count];
            self.afar.holds = Vec::new();
            self.afar.extend(self.blocks.asleep(), 0, count);
        }
        self.measure();
        self.note_stale();
        if self.afar.stale.iter().any(|stale| *stale) {
            self.choose_wide();
            self.search(t);
            self.note_search();
        }
    }

    /// Boxes about the blocks, and how far grains have moved since the blocks searched.
    fn measure(&mut self) {
        let periods = self.wrapping();
        let from = if self.valid { self.blocks.asleep() } else { 0 };
        for b in from..self.blocks.block.len() {
            let rows: &[Row] = only(&mut self.blocks.rows[b][self.now]);
            let block = mine(&mut self.blocks.block[b]);
            let rows = &rows[..block.len()];
            let place = &mut self.afar.place[b];
            (place.low, place.high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
            for row in rows {
                for axis in 0..3 {
                    place.low[axis] = place.low[axis].min(row.a[axis]);
                    place.high[axis] = place.high[axis].max(row.a[axis]);
                }
            }
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

    /// Marks the blocks whose search is too old for the skins of the lists.
    fn note_stale(&mut self) {
        let (asleep, count, length) = (self.blocks.asleep(), self.blocks.block.len(), self.common.length);
        let (place, skins) = (&self.afar.place, &self.lists.skins);
        let far = |b: usize, c: usize| 0.5 * RESERVE * (skins[b].width + skins[c].width);
        // paths are sums of many numbers
        let round_off = 1e-9 * self.diameter;
        self.afar.stale.clear();
        for b in 0..count {
            let own = &place[b];
            let stale = b >= asleep && {
                let holds = &self.afar.holds[(b - asleep) * count..][..count];
                let walls = own.off + self.wall_path - own.wall_path + RESERVE * skins[b].width + round_off;
                walls > own.searched
                    || (0..count).any(|c| {
                        own.off + place[c].before + place[c].off + far(b, c) + round_off > holds[c]
                            && gap(own, &place[c], length) <= 2.0 * self.largest + far(b, c)
                    })
            };
            self.afar.stale.push(stale);
        }
    }

    /// How wide a search is, block by block.
    fn choose_wide(&mut self) {
        let d = self.diameter;
        for (place, skin) in self.afar.place.iter_mut().zip(&self.lists.skins) {
            let most = (WIDER.0 * skin.width).clamp(WIDER.1 * d, WIDER.2 * d);
            place.wide = most.max(WIDER.3 * RESERVE * skin.width);
        }
        self.afar.place[..self.blocks.asleep()].iter_mut().for_each(|place| place.wide = 0.0);
    }

    /// Searches from now on count from here.
    fn note_search(&mut self) {
        let (asleep, count) = (self.blocks.asleep(), self.blocks.block.len());
        let Self { blocks, afar, now, wall_path, .. } = self;
        let Afar { place, holds, stale } = afar;
        for b in (asleep..count).filter(|&b| stale[b]) {
            let rows: &[Row] = only(&mut blocks.rows[b][*now]);
            let block = mine(&mut blocks.block[b]);
            block.origin.clear();
            block.origin.extend(rows[..block.inverse_inertia.len()].iter().map(Row::position));
            let own = &mut place[b];
            (own.before, own.off) = (own.before + own.off, 0.0);
            (own.searched, own.wall_path) = (own.wide, *wall_path);
        }
        for b in (asleep..count).filter(|&b| stale[b]) {
            for (c, holds) in holds[(b - asleep) * count..][..count].iter_mut().enumerate() {
                // a grain that is off now has come from where it was, and may go back through there
                *holds = 0.5 * (place[b].wide + place[c].wide) + place[c].before - place[c].off;
            }
        }
    }

    /// Finds what is near for the stale blocks.
    fn search(&mut self, t: f64) {
        let (now, asleep, count) = (self.now, self.blocks.asleep(), self.blocks.block.len());
        let place = &self.afar.place;
        // as far as a block looks: up to blocks that are so near that they could have a pair
        let reach: Vec<f64> = (0..count)
            .map(|b| {
                let to = |c: usize| 2.0 * self.largest + 0.5 * (place[b].wide + place[c].wide);
                let near = (0..count).filter(|&c| gap(&place[b], &place[c], self.common.length) <= to(c));
                if self.afar.stale[b] { near.map(to).fold(0.0, f64::max) } else { 0.0 }
            })
            .collect();
        let mean = place[asleep..].iter().map(|place| place.wide).sum::<f64>() / (count - asleep) as f64;
        let most = reach.iter().copied().fold(0.0, f64::max);
        let cell = (2.0 * self.largest + mean).max(most / CELLS as f64);
        let guards: Vec<_> = self.blocks.rows.iter().map(|rows| read(&rows[now])).collect();
        let rows = guards.iter().map(|rows| rows.split_last().map_or(&[][..], |(_, rows)| rows));
        let rows = rows.zip(place.iter().map(|place| 0.5 * place.wide));
        self.bins.sort(rows, self.n, cell, self.periods);
        drop(guards);
        let (blocks, threads, stale) = (&self.blocks, self.builders.len(), &self.afar.stale);
        let far = Mutex::new(0);
        on_threads(&mut self.builders, |k, builder| {
            for b in blocks.share_of(k, threads) {
                let mut block = lock(&blocks.block[b]);
                if stale[b] {
                    let search = Search {
                        bins: &self.bins,
                        skin: place[b].wide,
                        cells: if reach[b] <= cell { 1 } else { CELLS },
                        length: self.common.length,
                        t,
                        size: SIZE as u32,
                        grains: self.n,
                        asleep,
                        walls: &self.common.walls,
                        plain: self.settings.plain,
                    };
                    block.search(&search, &read(&blocks.rows[b][now]), &mut builder.search);
                }
                let mut far = lock(&far);
                *far = block.reach.max(*far);
            }
        });
        self.reach = far.into_inner().unwrap_or_default();
    }
}
