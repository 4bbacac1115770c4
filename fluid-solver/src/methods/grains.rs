//! The grains as every method has them: shapes, masks, motion, and the force on the fluid.

use crate::field::clear_own;
use crate::grid::Grid;
use crate::immersed::body::{Motion, laboratory};
use crate::immersed::mask_model::MaskModel;
use crate::immersed::places::Places;
use crate::immersed::{Immersed, Wrench};
use crate::step::Stepper;
use serde::{Deserialize, Serialize};

/// What decides the next window besides velocity, pressure and the carried force.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Memory {
    /// Motion of the grains now.
    pub motions: Vec<Motion>,
    /// Where the force was imposed last: its support.
    pub imposed: Vec<Motion>,
    /// dt with which the force was imposed, s; zero: never.
    pub imposed_dt: f64,
    /// Motion one window ago.
    pub before: Vec<Motion>,
    /// Length of that window, s; zero: there was none.
    pub before_dt: f64,
    /// What drove the whole fluid along periodic axes in that window, m/s².
    pub drive: [f64; 3],
    /// What contacts changed of each grain's velocity in that window, m/s, see [`super::loads`].
    pub jumps: Vec<[f64; 3]>,
    /// Momentum that the fluid took of them in that window, over the mass of the fluid that the grain
    /// displaces, m/s. Of several ranks the first alone knows it.
    pub taken: Vec<[f64; 3]>,
    /// Windows in which each grain has touched something since it came near it or became slow; the most there
    /// are for one that began so.
    pub rests: Vec<u8>,
}

impl Memory {
    /// Number of grains, if all parts agree on it.
    pub fn grains(&self) -> Option<usize> {
        let n = self.motions.len();
        let [imposed, before] = [&self.imposed, &self.before].map(Vec::len);
        let others = [imposed, before, self.jumps.len(), self.taken.len(), self.rests.len()];
        others.iter().all(|m| *m == n).then_some(n)
    }

    /// Change of what drives the whole fluid along periodic axes since the last window, m/s².
    pub(crate) fn change_of_drive<const D: usize>(&self, stepper: &Stepper<D>) -> [f64; 3] {
        let now = drive(stepper);
        std::array::from_fn(|c| now[c] - self.drive[c])
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

/// What drives the whole fluid along periodic axes in the last step, m/s²: body force and pressure gradient.
pub(crate) fn drive<const D: usize>(stepper: &Stepper<D>) -> [f64; 3] {
    let (grid, mut drive) = (stepper.grid(), [0.0; 3]);
    for a in (0..D).filter(|a| grid.periodic(*a)) {
        drive[laboratory(grid.geometry, a)] = stepper.options().body_force[a];
    }
    if let Some(flow) = stepper.flow_rate() {
        drive[laboratory(grid.geometry, flow.axis())] += flow.acceleration();
    }
    drive
}

/// The grains of a fluid.
pub struct Grains<const D: usize> {
    /// Shapes, and where the grains are on the grid.
    pub immersed: Immersed<D>,
    /// Mask with the dt of the present window.
    pub model: MaskModel,
    /// Mean gravity of the present window (x, y, z), m/s².
    pub gravity: [f64; 3],
    /// What decides the next window.
    pub memory: Memory,
    /// Motion expected at the end of the window.
    pub predicted: Vec<Motion>,
    /// Force per unit mass that is carried from step to step, m/s²; empty fields where a method has none.
    pub force: [Vec<f64>; D],
}

impl<const D: usize> Grains<D> {
    /// Grains that move as `motions` say, and a force of zero on `grid` where there is one.
    pub fn new(
        immersed: Immersed<D>,
        model: MaskModel,
        motions: Vec<Motion>,
        grid: Option<&Grid<D>>,
    ) -> Self {
        Self {
            immersed,
            model,
            gravity: [0.0; 3],
            predicted: vec![Motion::default(); motions.len()],
            memory: Memory {
                imposed: motions.clone(),
                before: motions.clone(),
                jumps: vec![[0.0; 3]; motions.len()],
                taken: vec![[0.0; 3]; motions.len()],
                rests: vec![u8::MAX; motions.len()],
                motions,
                ..Memory::default()
            },
            force: std::array::from_fn(|_| grid.map_or(Vec::new(), Grid::new_field)),
        }
    }

    /// The force that a step is given; none where there is no grain.
    pub fn force(&self) -> Option<&[Vec<f64>; D]> {
        (!self.memory.motions.is_empty() && !self.force[0].is_empty()).then_some(&self.force)
    }

    /// Predicts the motion after `dt`, s.
    pub fn predict(&mut self, dt: f64) {
        for (predicted, motion) in self.predicted.iter_mut().zip(&self.memory.motions) {
            *predicted = motion.predicted(dt);
        }
    }

    /// Clears the force outside of the cells that grains hold: no later step would take it back there.
    pub(crate) fn clear_free_force(&mut self, grid: &Grid<D>) {
        let (mut places, mut values) = (Places::default(), std::array::from_fn(|_| Vec::new()));
        places.add(grid, &self.immersed);
        places.gather(&self.force, &mut values);
        clear_own(grid, &mut self.force);
        places.scatter(&values, &mut self.force);
    }
}
