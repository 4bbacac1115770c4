//! How wide the lists are, and when they are built anew.
//!
//! A listed pair out of reach costs in every sub-step, a build once in as many as the grains need to cross
//! half a skin. All lists are built at the same time, but every block has a skin of its own, in proportion to
//! its speeds, so that the lists of a bed at rest are not as wide as those of grains that fall above it. The
//! motion is watched, and the widths follow. None of this changes a bit of the result.

/// Skin of one block, and how its grains have moved since its lists were built.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Skin {
    /// Pairs are listed up to half the sum of their blocks' skins, grains at walls up to the skin, m.
    pub(super) width: f64,
    /// How far a grain or a wall may have moved since, m.
    pub(super) travel: f64,
    /// Largest speed now, m/s.
    pub(super) speed: f64,
    /// Largest speed of late, m/s.
    pub(super) recent_speed: f64,
}

/// What a build of the lists found.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Listed {
    /// Contacts listed.
    pub(super) pairs: usize,
    /// Of these, with a force.
    pub(super) touching: usize,
}

impl Listed {
    pub(super) fn add(&mut self, other: &Self) {
        self.pairs += other.pairs;
        self.touching += other.touching;
    }
}

/// State of all lists.
#[derive(Clone, Debug, Default)]
pub(super) struct Lists {
    /// One per block.
    pub(super) skins: Vec<Skin>,
    /// Sub-steps since they were built.
    pub(super) since: u32,
    /// Sub-steps that they were to last; 0 before the first.
    pub(super) life: f64,
    pub(super) found: Listed,
}
