//! Where blocks are, and how long what they have found near them is good.

/// Where the grains of a block are, and how they have moved.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct BlockBox {
    pub(super) low: [f64; 3],
    pub(super) high: [f64; 3],
    /// How far any grain may have moved until the block searched last, m.
    pub(super) before: f64,
    /// How far any grain is from where it was then, m.
    pub(super) off: f64,
    /// Path of the walls then, m.
    pub(super) wall_path: f64,
    /// Skin of the candidates: in its own search, and now, m.
    pub(super) searched: f64,
    pub(super) skin: f64,
}

/// Candidates of all blocks.
#[derive(Clone, Debug, Default)]
pub(super) struct CandidateStatus {
    pub(super) place: Vec<BlockBox>,
    /// Row by row for the blocks that are active: up to which sum of paths a block's pairs with another one
    /// are good, m.
    pub(super) good_to: Vec<f64>,
    /// Blocks that must search.
    pub(super) stale: Vec<bool>,
}

impl CandidateStatus {
    /// From block `from` on, blocks are new or have other grains; there are `count` now.
    pub(super) fn extend(&mut self, inactive: usize, from: usize, count: usize) {
        let before = self.place.len();
        self.place.resize(count, BlockBox::default());
        let row = |b: usize| match self.good_to.get(b * before..(b + 1) * before) {
            Some(row) if inactive + b < from => &row[..from],
            _ => &[],
        };
        let good_to = (0..count - inactive).flat_map(|b| {
            let known = row(b);
            known.iter().copied().chain(std::iter::repeat_n(f64::NEG_INFINITY, count - known.len()))
        });
        self.good_to = good_to.collect();
    }
}
