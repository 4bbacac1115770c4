//! What the fluid keeps of the grains from window to window.

use crate::immersed::Wrench;
use crate::immersed::body::{Motion, laboratory};
use crate::step::Stepper;
use protocol::message::Loads;
use serde::{Deserialize, Serialize};

/// What decides the next window besides velocity, pressure and the carried force.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Memory {
    /// Motion of the grains now.
    pub motions: Vec<Motion>,
    /// Where the force was imposed last: its support.
    pub imposed: Vec<Motion>,
    /// dt with which it was imposed, s; zero: never.
    pub imposed_dt: f64,
    /// Motion one window ago.
    pub before: Vec<Motion>,
    /// Length of that window, s; zero: there was none.
    pub before_dt: f64,
    /// ∫ α u dV one window ago (kempe-froehlich-2012).
    pub contents: Vec<Wrench>,
    /// Loads to be sent in the next window, where both solvers work at once; else empty.
    pub kept: Vec<Loads>,
}

impl Memory {
    /// Number of grains, if all parts agree on it.
    pub fn grains(&self) -> Option<usize> {
        let n = self.motions.len();
        let same = self.imposed.len() == n && self.before.len() == n && self.contents.len() == n;
        (same && (self.kept.is_empty() || self.kept.len() == n)).then_some(n)
    }

    /// What drives the whole fluid along periodic axes, m/s²: told in the first window, then zero.
    pub(crate) fn first_drive<const D: usize>(&self, stepper: &Stepper<D>) -> [f64; 3] {
        let mut drive = [0.0; 3];
        if self.before_dt == 0.0 {
            let grid = stepper.grid();
            for a in (0..D).filter(|a| grid.periodic(*a)) {
                drive[laboratory(grid.geometry, a)] = stepper.options().body_force[a];
            }
            if let Some(flow) = stepper.flow_rate() {
                drive[laboratory(grid.geometry, flow.axis())] += flow.acceleration();
            }
        }
        drive
    }

    /// Mean acceleration of a grain over the last window: zero in the first.
    pub(crate) fn acceleration(&self, grain: usize) -> Wrench {
        if self.before_dt == 0.0 {
            return Wrench::default();
        }
        let (now, before) = (&self.motions[grain], &self.before[grain]);
        let rate = |a: &[f64; 3], b: &[f64; 3]| std::array::from_fn(|c| (a[c] - b[c]) / self.before_dt);
        Wrench { force: rate(&now.velocity, &before.velocity), torque: rate(&now.spin, &before.spin) }
    }
}
