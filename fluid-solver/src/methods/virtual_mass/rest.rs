//! Masks open where grains come to rest: what braked them would stay in the cells that they seal with what
//! they rest on, and bear them (docs/decisions/rest.md).

use super::ByGap;
use super::neighbours::Near;
use crate::immersed::body::{Motion, Patch, Shape};

/// Where a grain has come to rest on something its mask is open to this depth, and where the gap is below
/// this, in cells.
const PATCH: [f64; 2] = [2.0, 2.0];

/// Windows for which it is.
pub(super) const OPEN: u8 = 16;

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
        shapes.iter_mut().for_each(|shape| shape.patches.clear());
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
        for Near { grains: [i, j], normal, .. } in near.iter().filter(|near| near.gap <= 0.0) {
            if rests[*i].min(rests[*j]) > OPEN || rests[*i].max(rests[*j]) == 0 {
                continue;
            }
            // Radius of the sphere whose gap to a plane is the one between the two.
            let [a, b] = [i, j].map(|grain| shapes[*grain].radius);
            let round = if i == j { a } else { a * b / (a + b) };
            let radius = (2.0 * round * PATCH[1] * spacing).sqrt();
            let mut open = |grain: usize, normal: [f64; 3]| {
                let from = shapes[grain].radius - PATCH[0] * spacing;
                shapes[grain].patches.push(Patch { normal, from, radius });
            };
            open(*i, *normal);
            if i != j {
                open(*j, normal.map(|n| -n));
            }
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
                let gap = wall.gap(&shapes[grain], &now[grain]);
                if gap <= LEFT * spacing {
                    borne[grain] = true;
                    let normal = std::array::from_fn(|c| if c == wall.axis { -wall.inward } else { 0.0 });
                    near.push(Near { grains: [grain; 2], normal, gap });
                }
            }
        }
        neighbours.each_near(shapes, now, LEFT * spacing, |i, j, way, gap| {
            if (free[i] || free[j]) && is_slow(i) && is_slow(j) {
                let length = way.iter().map(|x| x * x).sum::<f64>().sqrt();
                near.push(Near { grains: [i, j], normal: way.map(|way| way / length), gap });
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
