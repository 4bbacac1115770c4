//! How wide the lists are, and when they are built anew.
//!
//! A listed pair out of reach costs in every sub-step, a build once in as many as the grains need to cross
//! half a skin. Both costs are known (`packing_cost` measures them), the motion is watched: the widths
//! follow. None of this changes a bit of the result.

use super::bins::IMMOBILE;
use super::row::Row;
use super::stretch::only;
use super::{Bulk, SIZE};

/// Skins: least and most, over the mean diameter.
const SKINS: (f64, f64) = (0.001, 0.5);

/// First skin over the mean diameter, before any motion was seen.
const FIRST: f64 = 0.05;

/// Cost of a build over that of a listed pair out of reach in one sub-step, both per grain.
const BUILD_OVER_PAIR: f64 = 60.0;

/// Sub-steps that a skin is good for at least, at the present largest speed.
const LEAST: f64 = 32.0;

impl Bulk {
    /// Whether the lists hold all pairs in contact now.
    pub(super) fn holds(&self) -> bool {
        self.valid && self.travel <= 0.5 * self.skin
    }

    /// Sub-steps that the present lists are good for; builds them if these are few.
    pub(super) fn prepare(&mut self, t: f64, dt: f64, wanted: u32) -> u32 {
        let step = self.step_length(dt);
        let fit = |rest: f64| if step > 0.0 { (rest / step).min(1e9) as u32 } else { u32::MAX };
        let enough = |rest: u32| rest >= wanted.min(8);
        if self.holds() && !self.too_wide() {
            let rest = fit(0.5 * self.skin - self.travel);
            if enough(rest) {
                return wanted.min(rest);
            }
            // the sum of the largest speeds is far above what any one grain has moved
            self.travel = self.moved(dt);
            let rest = 0.5 * self.skin - self.travel;
            if rest > 0.125 * self.skin && enough(fit(rest)) {
                return wanted.min(fit(rest));
            }
        }
        self.build(t, dt);
        wanted.min(fit(0.5 * self.skin)).max(1)
    }

    /// Whether pairs out of reach have cost more than a build since the last one, where a narrower skin would
    /// have spared them.
    fn too_wide(&mut self) -> bool {
        if self.settings.skin.is_some() || self.since == 0 {
            return false;
        }
        let best = self.best_skin(self.travel / f64::from(self.since));
        let waste = self.spare() * (1.0 - best / self.skin);
        waste * f64::from(self.since) > BUILD_OVER_PAIR
    }

    /// Listed pairs out of reach per grain.
    fn spare(&self) -> f64 {
        self.found.pairs.saturating_sub(self.found.touching) as f64 / self.n as f64
    }

    /// Skin at which builds and pairs out of reach cost the same, for grains that move by `rate` in a
    /// sub-step, m.
    fn best_skin(&self, rate: f64) -> f64 {
        let spare = self.spare();
        if spare == 0.0 {
            return self.skin;
        }
        (2.0 * rate * BUILD_OVER_PAIR * self.skin / spare)
            .sqrt()
            .clamp(SKINS.0 * self.diameter, SKINS.1 * self.diameter)
    }

    /// Skin for the present motion.
    pub(super) fn choose_skin(&mut self, dt: f64) -> f64 {
        let width = self.settings.skin.unwrap_or_else(|| {
            if self.skin == 0.0 || self.since == 0 {
                return FIRST * self.diameter;
            }
            let travel = if self.valid { self.moved(dt) } else { self.travel };
            self.best_skin(travel / f64::from(self.since)).clamp(0.25 * self.skin, 2.0 * self.skin)
        });
        // a stretch of some steps at least: fast grains must not force a build in every sub-step, nor a
        // lost one lists of everything
        width.max((LEAST * self.step_length(dt)).min(SKINS.1 * self.diameter))
    }

    /// How far any grain or wall has moved since the lists were built, m.
    fn moved(&mut self, dt: f64) -> f64 {
        let periods = self.wrapping();
        let rows: Vec<&[Row]> =
            self.blocks.rows.iter_mut().map(|rows| &only(&mut rows[self.now])[..]).collect();
        let mut most2 = 0.0f64;
        let [xs, ys, zs, _] = &self.bins.item;
        for (((who, x), y), z) in self.bins.who.iter().zip(xs).zip(ys).zip(zs) {
            let place = (who & !IMMOBILE) as usize;
            let now = rows[place / SIZE][place % SIZE].position();
            let apart = periods.nearest([now[0] - x, now[1] - y, now[2] - z].into());
            most2 = most2.max(apart.norm_squared());
        }
        most2.sqrt().max(self.wall_speed * dt * f64::from(self.since)) * (1.0 + 1e-12)
    }
}
