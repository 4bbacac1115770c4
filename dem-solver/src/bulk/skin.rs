//! How wide the lists are, and when they are built anew.
//!
//! A listed pair out of reach costs in every sub-step, a build once in as many as the grains need to cross
//! half a skin. The motion is watched, and the widths follow. Lists are taken from the pairs that are near
//! within a much wider skin, which are searched seldom. None of this changes a bit of the result.

use super::bins::IMMOBILE;
use super::list::{Listed, Reach};
use super::near::Search;
use super::row::Row;
use super::stretch::{lock, mine, on_threads, only, read};
use super::{Bulk, SIZE};
use std::sync::Mutex;

/// Skins: least and most, over the mean diameter.
const SKINS: (f64, f64) = (0.001, 0.5);

/// First skin over the mean diameter, before any motion was seen.
const FIRST: f64 = 0.02;

/// Cost of taking lists from what is near over that of a listed pair out of reach in one sub-step, both
/// per grain.
const BUILD_OVER_PAIR: f64 = 25.0;

/// Sub-steps that a skin is good for at least, at the present largest speed.
const LEAST: f64 = 16.0;

/// What is near reaches so many times as far as the lists, and so far over the mean diameter at least.
const WIDER: (f64, f64) = (5.0, 0.1);

/// Pairs within a skin, and how far grains have moved since.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Lists {
    /// Gap of the pairs, m.
    skin: f64,
    /// How far a grain or a wall may have moved since, m.
    travel: f64,
    /// Sub-steps since.
    since: u32,
}

impl Lists {
    fn new(skin: f64) -> Self {
        Self { skin, travel: 0.0, since: 0 }
    }

    /// Whether all pairs within `skin` are among them.
    fn hold(&self, skin: f64) -> bool {
        2.0 * self.travel + skin <= self.skin
    }

    /// One sub-step in which nothing has moved further than `distance`.
    pub(super) fn moved(&mut self, distance: f64) {
        self.travel += distance;
        self.since = self.since.saturating_add(1);
    }

    /// Distance per sub-step, m.
    fn rate(&self) -> f64 {
        self.travel / f64::from(self.since.max(1))
    }
}

impl Bulk {
    /// Whether the lists hold all pairs in contact now.
    pub(super) fn holds(&self) -> bool {
        self.valid && self.lists.hold(0.0)
    }

    /// Sub-steps that the present lists are good for; builds them if these are few.
    pub(super) fn prepare(&mut self, t: f64, dt: f64, wanted: u32) -> u32 {
        let step = self.step_length(dt);
        let fit = |lists: &Lists| {
            let rest = 0.5 * lists.skin - lists.travel;
            if step > 0.0 { (rest / step).min(1e9) as u32 } else { u32::MAX }
        };
        if self.holds() && !self.too_wide() && fit(&self.lists) >= wanted.min(8) {
            return wanted.min(fit(&self.lists));
        }
        self.build(t, dt);
        wanted.min(fit(&self.lists)).max(1)
    }

    /// Whether pairs out of reach have cost more than a build since the last one, where a narrower skin would
    /// have spared them.
    fn too_wide(&self) -> bool {
        let Lists { skin, since, .. } = self.lists;
        let waste = self.spare() * (1.0 - self.best_skin() / skin);
        self.settings.skin.is_none() && since > 0 && waste * f64::from(since) > BUILD_OVER_PAIR
    }

    /// Listed pairs out of reach per grain.
    fn spare(&self) -> f64 {
        self.found.pairs.saturating_sub(self.found.touching) as f64 / self.moving.max(1) as f64
    }

    /// Skin at which builds and pairs out of reach cost the same, for grains that move as they did, m.
    fn best_skin(&self) -> f64 {
        let (spare, Lists { skin, .. }) = (self.spare(), self.lists);
        if spare == 0.0 {
            return skin;
        }
        (2.0 * self.lists.rate() * BUILD_OVER_PAIR * skin / spare)
            .sqrt()
            .clamp(SKINS.0 * self.diameter, SKINS.1 * self.diameter)
    }

    /// Skin for the present motion.
    fn choose_skin(&self, dt: f64) -> f64 {
        let Lists { skin, since, .. } = self.lists;
        let width = self.settings.skin.unwrap_or_else(|| {
            if since == 0 { FIRST * self.diameter } else { self.best_skin().clamp(0.25 * skin, 2.0 * skin) }
        });
        // a stretch of some steps at least: fast grains must not force a build in every sub-step, nor a
        // lost one lists of everything
        width.max((LEAST * self.step_length(dt)).min(SKINS.1 * self.diameter))
    }

    /// How far any grain or wall has moved since what is near was searched, m.
    fn displacement(&mut self, dt: f64) -> f64 {
        let periods = self.wrapping();
        let rows: Vec<&[Row]> =
            self.blocks.rows.iter_mut().map(|rows| &only(&mut rows[self.now])[..]).collect();
        let [xs, ys, zs, _] = &self.bins.item;
        let mut most2 = 0.0f64;
        for (((who, x), y), z) in self.bins.who.iter().zip(xs).zip(ys).zip(zs) {
            let place = (who & !IMMOBILE) as usize;
            let now = rows[place / SIZE][place % SIZE].position();
            let apart = periods.nearest([now[0] - x, now[1] - y, now[2] - z].into());
            most2 = most2.max(apart.norm_squared());
        }
        most2.sqrt().max(self.wall_speed * dt * f64::from(self.near.since)) * (1.0 + 1e-12)
    }

    /// Builds the lists for the present state, and searches what is near where that has become too old.
    pub(super) fn build(&mut self, t: f64, dt: f64) {
        let skin = self.choose_skin(dt);
        self.near.travel += self.lists.travel;
        self.near.since = self.near.since.saturating_add(self.lists.since);
        if self.valid && !self.near.hold(1.5 * skin) {
            // the sum of the largest speeds is far above what any one grain has moved
            self.near.travel = self.displacement(dt);
        }
        // hardly enough now would not be enough soon
        if !self.valid || !self.near.hold(1.5 * skin) {
            self.search(
                t,
                (WIDER.0 * skin).clamp(WIDER.1 * self.diameter, SKINS.1 * self.diameter).max(1.6 * skin),
            );
        }
        self.lists = Lists::new(skin);
        self.valid = true;
        self.builds += 1;
        self.take_lists(t);
    }

    /// Finds what is near within `skin`.
    fn search(&mut self, t: f64, skin: f64) {
        self.near = Lists::new(skin);
        let now = self.now;
        let guards: Vec<_> = self.blocks.rows.iter().map(|rows| read(&rows[now])).collect();
        let rows = guards.iter().map(|rows| rows.split_last().map_or(&[][..], |(_, rows)| rows));
        self.bins.sort(rows, self.n, 2.0 * self.largest + skin, self.periods);
        drop(guards);
        // springs are known by places in lists that now change
        if self.seeds.is_empty() {
            let blocks = self.blocks.block.iter_mut().map(|block| {
                let mut history = Default::default();
                mine(block).history(SIZE as u32, false, &mut history);
                history
            });
            self.seeds = blocks.collect();
        }
        let search = Search {
            bins: &self.bins,
            skin,
            length: self.common.length,
            t,
            size: SIZE as u32,
            grains: self.n,
            asleep: self.blocks.asleep,
            walls: &self.common.walls,
            plain: self.settings.plain,
        };
        let (blocks, threads) = (&self.blocks, self.builders.len());
        let reach = Mutex::new(0);
        on_threads(&mut self.builders, |k, builder| {
            for b in blocks.share_of(k, threads) {
                let rows = read(&blocks.rows[b][now]);
                let far = lock(&blocks.block[b]).search(&search, &rows, &mut builder.search);
                let mut reach = lock(&reach);
                *reach = far.max(*reach);
            }
        });
        self.reach = reach.into_inner().unwrap_or_default();
    }

    /// Takes the lists from what is near.
    fn take_lists(&mut self, t: f64) {
        let reach = Reach {
            skin: self.lists.skin,
            length: self.common.length,
            t,
            size: SIZE as u32,
            walls: &self.common.walls,
        };
        let (blocks, seeds, now) = (&self.blocks, &self.seeds, self.now);
        let threads = self.builders.len();
        let found = Mutex::new(Listed::default());
        on_threads(&mut self.builders, |k, builder| {
            for b in blocks.share_of(k, threads) {
                let rows = read(&blocks.rows[b][now]);
                let mut block = lock(&blocks.block[b]);
                // nothing runs now: there is no sub-step to wait for
                blocks.gather(&block, now, 0, &mut builder.halo);
                let listed = block.build(&reach, &rows, builder, seeds.get(b));
                lock(&found).add(&listed);
            }
        });
        self.found = found.into_inner().unwrap_or_default();
        self.seeds.clear();
    }
}
