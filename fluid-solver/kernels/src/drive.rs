//! What moves the fluid from outside and changes over time: walls along themselves, a uniform force, inflows.
//!
//! An inflow has its velocity at the end of the stage, when the projection makes it felt.
//! A force acts in a stage with its mean over the stage, so that its impulse is complete. With implicit
//! viscosity a wall has its mean velocity over the stage: Crank–Nicolson asks for ½ (V' + V), which is the
//! same to the order of the scheme. With explicit viscosity, which extrapolates, it has that of the start.

use crate::boundary::Boundary;
use crate::flow::Flow;
use crate::grid::Grid;
use crate::immersed::body::laboratory;
use crate::scheme::Viscous;
use bedload_over_time::OverTime;

/// Walls and forces that change, as vectors (x, y, z) of the laboratory.
#[derive(Clone, Debug, Default)]
pub struct Drive {
    /// Velocity of the no-slip walls that move so, and mean velocity of the inflows, m/s, by axis and side.
    pub faces: Vec<(usize, usize, OverTime<[f64; 3]>)>,
    /// Parts of the uniform force per unit mass, m/s²; none where all are constant.
    pub force: Vec<OverTime<[f64; 3]>>,
}

impl Drive {
    /// Whether nothing changes.
    pub fn is_empty(&self) -> bool {
        self.faces.is_empty() && self.force.is_empty()
    }

    /// Gives the walls their velocity at `time`, s.
    pub(crate) fn move_walls<const D: usize>(&self, grid: &mut Grid<D>, time: f64) {
        self.set_walls(grid, |wall| wall.at(time));
    }

    /// Gives the inflows their velocity at `time`, s.
    pub(crate) fn enter<const D: usize>(&self, flow: &mut Flow<D>, time: f64) {
        for (axis, side, velocity) in &self.faces {
            if let Boundary::Inflow { .. } = flow.grid.boundaries[*axis][*side] {
                let (now, geometry) = (velocity.at(time), flow.grid.geometry);
                flow.state.open.enter(*axis, *side, std::array::from_fn(|a| now[laboratory(geometry, a)]));
            }
        }
    }

    /// Walls and force for a stage from `from` to `to`, s.
    pub(crate) fn act<const D: usize>(&self, flow: &mut Flow<D>, from: f64, to: f64) {
        if flow.options.viscous == Viscous::Implicit {
            self.set_walls(&mut flow.grid, |wall| wall.mean(from, to));
        }
        if self.force.is_empty() {
            return;
        }
        let mut force = [0.0; 3];
        for part in &self.force {
            force.iter_mut().zip(part.mean(from, to)).for_each(|(sum, part)| *sum += part);
        }
        let geometry = flow.grid.geometry;
        flow.options.body_force = std::array::from_fn(|a| force[laboratory(geometry, a)]);
    }

    fn set_walls<const D: usize>(&self, grid: &mut Grid<D>, value: impl Fn(&OverTime<[f64; 3]>) -> [f64; 3]) {
        for (axis, side, wall) in &self.faces {
            let now = value(wall);
            if let Boundary::NoSlip { velocity } = &mut grid.boundaries[*axis][*side] {
                *velocity = std::array::from_fn(|a| now[laboratory(grid.geometry, a)]);
            }
        }
    }
}
