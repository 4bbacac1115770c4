//! Masks open where grains come to rest: what braked them would stay in the cells that they seal with what
//! they rest on, and bear them (docs/decisions/rest.md).

use super::ByGap;
use crate::immersed::body::{Motion, Patch, Shape};

/// Where a grain has come to rest on something its mask is open to this depth, and where the gap is below
/// this, in cells.
const PATCH: [f64; 2] = [2.0, 2.0];

/// Windows for which it is.
pub(super) const OPEN: u8 = 16;

impl ByGap {
    /// Opens the masks where grains slower than `slow`, m/s, have come to rest on something, on a grid of
    /// this `spacing`, m. `rests`: windows in which each has touched something since it became slow; where
    /// `counts`, the one that begins with the motion `now` is added.
    pub fn open_masks(
        &mut self,
        shapes: &mut [Shape],
        now: &[Motion],
        [slow, spacing]: [f64; 2],
        (rests, counts): (&mut [u8], bool),
    ) {
        let Self { walls, free, neighbours, resting, contacts, .. } = self;
        resting.clear();
        shapes.iter_mut().for_each(|shape| shape.patches.clear());
        if slow == 0.0 {
            return;
        }
        let norm = |v: &[f64; 3]| v.iter().map(|v| v * v).sum::<f64>().sqrt();
        let is_slow = |grain: usize| shapes[grain].outline.is_none() && norm(&now[grain].velocity) < slow;
        // `round`: radius of the sphere whose gap to a plane is the one between the two.
        let patch = |grain: usize, normal: [f64; 3], round: f64| {
            let from = shapes[grain].radius - PATCH[0] * spacing;
            Patch { normal, from, radius: (2.0 * round * PATCH[1] * spacing).sqrt() }
        };
        for grain in (0..shapes.len()).filter(|grain| free[*grain] && is_slow(*grain)) {
            for wall in walls.iter().filter(|wall| wall.gap(&shapes[grain], &now[grain]) <= 0.0) {
                let normal = std::array::from_fn(|c| if c == wall.axis { -wall.inward } else { 0.0 });
                resting.push(([grain; 2], patch(grain, normal, shapes[grain].radius)));
            }
        }
        neighbours.each_contact(shapes, now, |i, j, way| {
            if (free[i] || free[j]) && is_slow(i) && is_slow(j) {
                let length = norm(&way);
                let round = shapes[i].radius * shapes[j].radius / (shapes[i].radius + shapes[j].radius);
                resting.push(([i, j], patch(i, way.map(|way| way / length), round)));
                resting.push(([j, i], patch(j, way.map(|way| -way / length), round)));
            }
        });
        if counts {
            contacts.fill(0);
            resting.iter().for_each(|([grain, _], _)| contacts[*grain] = 1);
            for (grain, (rests, touches)) in rests.iter_mut().zip(&*contacts).enumerate() {
                *rests = if is_slow(grain) { rests.saturating_add(u8::from(*touches > 0)) } else { 0 };
            }
        }
        for ([grain, other], patch) in &*resting {
            if rests[*grain].min(rests[*other]) <= OPEN {
                shapes[*grain].patches.push(*patch);
            }
        }
    }
}
