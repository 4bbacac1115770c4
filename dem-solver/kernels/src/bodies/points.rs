//! Points of contact with their history, through the evaluations.

use crate::state::SavedPoint;

/// How near, over the smaller radius, the vertex of a point must be to one that lost its own, to go on with
/// its history.
const NEAR: f64 = 0.01;

/// Points that bear a force, ascending by the partners.
#[derive(Clone, Debug, Default)]
pub(crate) struct Points {
    pub(crate) now: Vec<SavedPoint>,
    /// Those of the evaluation under way.
    pub(crate) next: Vec<SavedPoint>,
    /// Where the pair under way has its points.
    from: usize,
    to: usize,
}

impl Points {
    /// Begins an evaluation.
    pub(crate) fn begin(&mut self) {
        self.next.clear();
        (self.from, self.to) = (0, 0);
    }

    /// Goes to the next pair; returns its points of before.
    #[inline(always)]
    pub(crate) fn go_to(&mut self, first: u32, second: u32) -> &[SavedPoint] {
        let key = |point: &SavedPoint| (point.first, point.second);
        self.from = self.to;
        while self.from < self.now.len() && key(&self.now[self.from]) < (first, second) {
            self.from += 1;
        }
        self.to = self.from;
        while self.to < self.now.len() && key(&self.now[self.to]) == (first, second) {
            self.to += 1;
        }
        &self.now[self.from..self.to]
    }

    /// The points of before of the present pair.
    #[inline(always)]
    pub(crate) fn old(&self) -> &[SavedPoint] {
        &self.now[self.from..self.to]
    }

    /// The point of before that is this one: of the same feature, or else one whose own feature is gone and
    /// which was next to it. `features` are those there now; `apart2` tells the square of the distance of two
    /// features over that of the smaller radius.
    pub(crate) fn find(
        &self,
        feature: u32,
        features: impl Fn(u32) -> bool,
        apart2: impl Fn(u32, u32) -> f64,
    ) -> Option<SavedPoint> {
        let old = self.old();
        old.iter().find(|point| point.feature == feature).copied().or_else(|| {
            old.iter()
                .filter(|point| !features(point.feature))
                .find(|point| apart2(point.feature, feature) < NEAR * NEAR)
                .copied()
        })
    }

    /// The evaluation is over.
    pub(crate) fn finish(&mut self) {
        std::mem::swap(&mut self.now, &mut self.next);
    }
}
