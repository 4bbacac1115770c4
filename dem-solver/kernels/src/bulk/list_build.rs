//! When the lists are built anew, how wide, and from the candidates.

use crate::bulk::block_list::ListReach;
use crate::bulk::engine::Bulk;
use crate::bulk::skins::{Listed, Lists, Skin};
use crate::bulk::sync::{lock, mutex_mut, on_threads, read};
use std::sync::Mutex;

/// Skins: least and most, over the mean diameter.
const SKINS: (f64, f64) = (0.001, 0.5);

/// First skin over the mean diameter, before any motion was observed.
const FIRST: f64 = 0.02;

/// Cost of taking lists from the candidates over that of a listed pair out of reach in one sub-step, both
/// per grain.
const BUILD_OVER_PAIR: f64 = 25.0;

/// Sub-steps that lists are to last: least and most.
const LIVES: (f64, f64) = (8.0, 1e6);

/// Share of its speed that a grain is expected to hand on to those of neighbouring blocks.
const HANDED_ON: f64 = 0.5;

/// Room for grains that become faster, in distances per sub-step.
const ROOM: f64 = 1.25;

impl Bulk {
    /// Whether all pairs in contact now are in the lists.
    pub(super) fn lists_are_good(&self) -> bool {
        let wide_enough = |skin: &Skin| 2.0 * skin.travel <= skin.width;
        self.valid && self.listed && self.lists.skins[self.blocks.inactive..].iter().all(wide_enough)
    }

    /// One sub-step `s` of a batch was good.
    pub(super) fn moved(&mut self, s: u32, dt: f64) {
        let (keep, wall_speed, inactive) =
            (1.0 - 1.0 / self.lists.life.max(2.0), self.wall_speed, self.blocks.inactive);
        for (block, skin) in self.blocks.active_mut().iter_mut().zip(&mut self.lists.skins[inactive..]) {
            skin.speed = mutex_mut(block).speed2[s as usize].sqrt();
            skin.recent_speed = (keep * skin.recent_speed).max(skin.speed);
            skin.travel += dt * skin.speed.max(wall_speed);
        }
        self.wall_path += dt * wall_speed;
        self.lists.since = self.lists.since.saturating_add(1);
    }

    /// Sub-steps that the present lists are good for; builds them if these are few.
    pub(super) fn prepare(&mut self, t: f64, dt: f64, wanted: u32) -> u32 {
        if self.lists_are_good() && !self.too_wide(dt) && self.fit(dt) >= wanted.min(8) {
            return wanted.min(self.fit(dt));
        }
        self.build(t, dt);
        wanted.min(self.fit(dt)).max(1)
    }

    /// Sub-steps until the first block is likely to outrun the lists.
    fn fit(&self, dt: f64) -> u32 {
        let steps = self.lists.skins[self.blocks.inactive..].iter().map(|skin| {
            let step = ROOM * dt * skin.speed.max(self.wall_speed);
            if step > 0.0 { (0.5 * skin.width - skin.travel) / step } else { f64::INFINITY }
        });
        steps.fold(f64::INFINITY, f64::min).min(1e9) as u32
    }

    /// Whether pairs out of reach have cost more than a build since the last one, where narrower skins would
    /// have spared them.
    fn too_wide(&mut self, dt: f64) -> bool {
        let Lists { since, .. } = self.lists;
        if self.settings.skin.is_some() || self.spare() * f64::from(since) <= BUILD_OVER_PAIR {
            return false;
        }
        let life = self.best_life();
        let (mut sum, mut best) = (0.0, 0.0);
        for b in self.blocks.inactive..self.blocks.block.len() {
            let width = self.lists.skins[b].width;
            sum += width;
            best += self.best_width(b, life, dt).min(width);
        }
        self.spare() * (1.0 - best / sum) * f64::from(since) > BUILD_OVER_PAIR
    }

    /// Listed pairs out of reach per grain.
    fn spare(&self) -> f64 {
        let Listed { pairs, touching } = self.lists.found;
        pairs.saturating_sub(touching) as f64 / self.moving.max(1) as f64
    }

    /// Sub-steps between builds at which these and pairs out of reach cost the same, for grains that
    /// move as they did.
    fn best_life(&self) -> f64 {
        let Lists { since, life, .. } = self.lists;
        if life == 0.0 {
            return 2.0 * LIVES.0;
        }
        if since == 0 {
            return life;
        }
        // what share of its skin the fastest block has used up in a sub-step
        let skins = &self.lists.skins[self.blocks.inactive..];
        let used = skins.iter().map(|skin| 2.0 * skin.travel / skin.width).fold(0.0, f64::max);
        let used = used / f64::from(since);
        let best = (BUILD_OVER_PAIR / (self.spare() * used)).sqrt();
        // not a number where nothing moves and nothing is to spare
        best.max(LIVES.0).clamp(0.25 * life, 2.0 * life).clamp(LIVES.0, LIVES.1)
    }

    /// Skin with which block `b` does not outrun lists that last `life` sub-steps, m.
    fn best_width(&mut self, b: usize, life: f64, dt: f64) -> f64 {
        let skins = &self.lists.skins;
        let beside = mutex_mut(&mut self.blocks.block[b]).segments.iter();
        let beside = beside.map(|segment| skins[segment.block as usize].recent_speed).fold(0.0, f64::max);
        let speed = skins[b].recent_speed.max(HANDED_ON * beside).max(self.wall_speed);
        let (least, most) = (SKINS.0 * self.diameter, SKINS.1 * self.diameter);
        let of = |life: f64| (2.0 * ROOM * dt * speed * life).clamp(least, most);
        match self.settings.skin {
            Some(width) => width.max(of(LIVES.0)),
            None => of(life),
        }
    }

    /// Skins for the present motion.
    fn choose_skins(&mut self, dt: f64) {
        let life = self.best_life();
        let least =
            if self.lists.life == 0.0 && self.settings.skin.is_none() { FIRST * self.diameter } else { 0.0 };
        for b in self.blocks.inactive..self.blocks.block.len() {
            self.lists.skins[b].width = self.best_width(b, life, dt).max(least);
        }
        for skin in &mut self.lists.skins {
            skin.travel = 0.0;
        }
        self.lists.skins[..self.blocks.inactive].fill(Skin::default());
        (self.lists.life, self.lists.since) = (life, 0);
    }

    /// Builds the lists for the present state, and searches candidates where that has become too old.
    pub(super) fn build(&mut self, t: f64, dt: f64) {
        self.choose_skins(dt);
        self.refresh_candidates(t);
        (self.valid, self.listed) = (true, true);
        self.builds += 1;
        self.take_lists(t);
    }

    /// Takes the lists from the candidates.
    fn take_lists(&mut self, t: f64) {
        let reach =
            ListReach { skins: &self.lists.skins, periods: self.periods, t, walls: &self.common.walls };
        let (blocks, now) = (&self.blocks, self.now);
        let threads = self.list_scratch.len();
        let found = Mutex::new(Listed::default());
        on_threads(&mut self.list_scratch, |k, scratch| {
            for b in blocks.blocks_of_thread(k, threads) {
                let rows = read(&blocks.rows[b][now]);
                let mut block = lock(&blocks.block[b]);
                // nothing runs now: there is no sub-step to wait for
                blocks.gather(&block, now, 0, &mut scratch.halo);
                let listed = block.build(&reach, &rows, scratch);
                lock(&found).add(&listed);
            }
        });
        self.lists.found = found.into_inner().unwrap_or_default();
        self.blocks.balance(threads);
    }
}
