//! Observations of a block.

use crate::bulk::records::{ContactPack, ForceTorque};

/// Observations of one block over a window; per grain only where asked for.
#[derive(Clone, Debug, Default)]
pub(super) struct Observed {
    /// Largest overlap, m.
    pub(super) overlap: f64,
    /// Sum of the contact forces over the sub-steps, N, with an empty fourth number; empty if not
    /// asked for.
    pub(super) force: Vec<[f64; 4]>,
    /// Sums of the contact forces and torques on grains at each wall over the sub-steps, N and N m.
    pub(super) walls: Vec<ForceTorque>,
    /// Approach and separation speed at the last beginning and end of a contact, m/s; empty if not
    /// asked for.
    pub(super) speeds: Vec<[f64; 2]>,
}

impl Observed {
    /// Starts a window with `n` observed grains, or none, and some walls.
    pub(super) fn clear(&mut self, n: usize, walls: usize) {
        self.overlap = 0.0;
        self.force.clear();
        self.force.resize(n, [0.0; 4]);
        self.walls.clear();
        self.walls.resize(walls, ForceTorque::default());
        self.speeds.clear();
        self.speeds.resize(n, [0.0; 2]);
    }

    #[cold]
    fn note(&mut self, i: u32, begins: bool, rate: f64) {
        // lanes without a grain point behind the last one
        if let Some(speeds) = self.speeds.get_mut(i as usize) {
            let at = usize::from(!begins);
            speeds[at] = (if begins { -rate } else { rate }).max(0.0);
        }
    }

    /// Contacts of `pack` begin or end: `now` touch. With `cross`, second partners are of another block, or a
    /// wall.
    pub(super) fn pair_event(&mut self, pack: &ContactPack, now: u8, rate: &[f64; 8], cross: bool) {
        if self.speeds.is_empty() {
            return;
        }
        for k in (0..8).filter(|k| (pack.touching ^ now) >> k & 1 == 1) {
            let begins = now >> k & 1 == 1;
            self.note(u32::from(pack.i[k]), begins, rate[k]);
            if !cross {
                self.note(pack.j[k], begins, rate[k]);
            }
        }
    }
}
