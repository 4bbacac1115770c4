//! Masks open in films and where grains come to rest: a force would grow in the cells that they seal, or what
//! braked them would stay there and bear them (docs/decisions/film-complement.md, docs/decisions/rest.md).

use super::ByGap;
use super::neighbours::Near;
use crate::immersed::body::{Motion, Patch, Shape};

/// Where a grain has come to rest on something its mask is open to this depth, and where the gap is wider by
/// less than this, in cells.
const PATCH: [f64; 2] = [2.0, 2.0];

/// Windows for which it is, and the largest mask ratio there.
pub(super) const OPEN: u8 = 16;
/// See [`OPEN`].
const RATIO: f64 = 0.5;

/// Largest mask ratio in films of grains in space, over ν dt/Δx²: that of a free surface.
const FILM: f64 = 17.0;
/// Depth, in cells, to which masks are open there.
const LAYER: f64 = 0.5;

/// Gap, in cells, above which a grain has left what it rested on.
const LEFT: f64 = 0.1;

impl ByGap {
    /// Opens the masks where grains slower than `slow`, m/s, have come to rest on something, on a grid of
    /// this `spacing`, m. `rests`: windows in which each has touched something since it came to what bears
    /// it, the most there are for one that began there; where `counts`, the one that begins with the motion
    /// `now` is added.
    pub fn open_masks(
        &mut self,
        shapes: &mut [Shape],
        now: &[Motion],
        [slow, spacing]: [f64; 2],
        (rests, counts): (&mut [u8], bool),
    ) {
        if slow == 0.0 {
            return;
        }
        self.find_near(shapes, now, [slow, spacing]);
        self.find_borne();
        let Self { near, borne, .. } = self;
        if counts {
            for (grain, rests) in rests.iter_mut().enumerate() {
                *rests = if borne[grain] { *rests } else { 0 };
            }
            // Each once, however many it touches.
            for grain in near.iter().filter(|near| near.gap <= 0.0).flat_map(|near| near.grains) {
                if std::mem::take(&mut borne[grain]) {
                    rests[grain] = rests[grain].saturating_add(1);
                }
            }
        }
        for pair in near.iter().filter(|near| near.gap <= 0.0) {
            let [i, j] = pair.grains.map(|grain| rests[grain]);
            if i.min(j) <= OPEN && i.max(j) > 0 {
                open_between(shapes, pair, [PATCH[0] * spacing, PATCH[1] * spacing, RATIO]);
            }
        }
    }

    /// Opens the masks in films of grains in space that move, at their motion `now`, as far as at a free
    /// surface: where the gap is below a cell the masks seal the cells, and the force of a slow approach
    /// would grow in them for thousands of windows (docs/decisions/film-complement.md). `viscous`: ν dt/Δx².
    pub fn open_films(&mut self, shapes: &mut [Shape], now: &[Motion], [viscous, spacing]: [f64; 2]) {
        let Self { walls, moves, neighbours, near, .. } = self;
        near.clear();
        for grain in (0..shapes.len()).filter(|grain| moves[*grain]) {
            for wall in &*walls {
                let mut pair = wall.near(grain, &shapes[grain], &now[grain]);
                if wall.slips {
                    // A plane of symmetry.
                    (pair.gap, pair.round) = (2.0 * pair.gap, 0.5 * pair.round);
                }
                if pair.gap <= spacing {
                    near.push(pair);
                }
            }
        }
        neighbours.each_near(shapes, now, spacing, |pair| {
            if pair.grains.iter().any(|grain| moves[*grain]) {
                near.push(pair);
            }
        });
        // What overlaps by more has no film.
        for pair in near.iter().filter(|near| near.gap >= -spacing) {
            let around = spacing - pair.gap.max(0.0);
            open_between(shapes, pair, [LAYER * spacing, around, FILM * viscous]);
        }
    }

    /// Whether all free grains are slower than `slow`, m/s.
    pub fn all_slow(&self, now: &[Motion], slow: f64) -> bool {
        self.free.iter().zip(now).all(|(free, now)| !free || now.speed() < slow)
    }

    /// Finds what slow grains are near.
    fn find_near(&mut self, shapes: &[Shape], now: &[Motion], [slow, spacing]: [f64; 2]) {
        let Self { walls, free, neighbours, near, borne, .. } = self;
        near.clear();
        let is_slow = |grain: usize| shapes[grain].outline.is_none() && now[grain].speed() < slow;
        for grain in 0..shapes.len() {
            borne[grain] = !free[grain] && is_slow(grain);
            if !free[grain] || !is_slow(grain) {
                continue;
            }
            for wall in &*walls {
                let pair = wall.near(grain, &shapes[grain], &now[grain]);
                if pair.gap <= LEFT * spacing {
                    borne[grain] = true;
                    near.push(pair);
                }
            }
        }
        neighbours.each_near(shapes, now, LEFT * spacing, |pair| {
            if pair.grains.iter().any(|grain| free[*grain]) && pair.grains.into_iter().all(is_slow) {
                near.push(pair);
            }
        });
    }

    /// Finds the grains that walls and held grains bear, through others: those that sink together rest on
    /// nothing.
    fn find_borne(&mut self) {
        let Self { near, borne, .. } = self;
        let mut more = true;
        while more {
            more = false;
            for [i, j] in near.iter().map(|near| near.grains) {
                if borne[i] != borne[j] {
                    (borne[i], borne[j], more) = (true, true, true);
                }
            }
        }
    }
}

/// Opens the masks of two grains towards each other, or of one, named twice, towards a wall: to a
/// `depth`, m, where the gap is wider by less than `around`, m, to a mask ratio of `most`.
fn open_between(shapes: &mut [Shape], pair: &Near, [depth, around, most]: [f64; 3]) {
    let Near { grains: [i, j], normal, round, .. } = *pair;
    let radius = (2.0 * round * around).sqrt();
    let mut open = |grain: usize, normal: [f64; 3]| {
        let from = shapes[grain].radius - depth;
        shapes[grain].patches.push(Patch { normal, from, radius, most });
    };
    open(i, normal);
    if i != j {
        open(j, normal.map(|n| -n));
    }
}
