//! What of the edges of blocks is sent: of an operator that was solved for before only what hangs on the
//! right side.

use super::block_sweep::GROUP;

/// Wides of an edge, and those among them that hang on the right side.
const WIDES: usize = 6;
const CONSTANTS: [usize; 2] = [0, 3];

/// What is sent of an edge.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Sent {
    /// Everything.
    All,
    /// The constants of the last and the first value: their owner has kept the rest.
    Constants,
}

impl Sent {
    fn has(self, wide: usize) -> bool {
        self == Self::All || CONSTANTS.contains(&(wide % WIDES))
    }

    /// Numbers that are sent of edges of so many.
    pub(super) fn length(self, numbers: usize) -> usize {
        if self == Self::All { numbers } else { numbers / WIDES * CONSTANTS.len() }
    }

    /// What is sent of some edges.
    pub(super) fn pack(self, edges: &[f64]) -> Vec<f64> {
        let wides = edges.chunks_exact(GROUP).enumerate().filter(|(wide, _)| self.has(*wide));
        wides.flat_map(|(_, wide)| wide).copied().collect()
    }

    /// The edges with what was sent of them.
    pub(super) fn unpack(self, sent: &[f64], edges: &mut [f64]) {
        let wides = edges.chunks_exact_mut(GROUP).enumerate().filter(|(wide, _)| self.has(*wide));
        for ((_, wide), sent) in wides.zip(sent.chunks_exact(GROUP)) {
            wide.copy_from_slice(sent);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_sent_arrives_in_its_place() {
        let edges: Vec<f64> = (0..2 * WIDES * GROUP).map(|k| k as f64).collect();
        for sent in [Sent::All, Sent::Constants] {
            let packed = sent.pack(&edges);
            assert_eq!(packed.len(), sent.length(edges.len()));
            let mut back = edges.clone();
            for wide in back.chunks_exact_mut(GROUP).step_by(3) {
                wide.fill(-1.0);
            }
            sent.unpack(&packed, &mut back);
            assert_eq!(back, edges);
        }
    }
}
