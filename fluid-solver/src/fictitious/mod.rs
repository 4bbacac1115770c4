//! The fictitious-domain method of Yu & Shao (2007): rigid motion imposed at points of the bodies by distributed
//! Lagrange multipliers, in the form that knows no difference of densities (docs/equations-immersed.md, section 9).
//!
//! It shares loads, windows and messages with the method of [`crate::immersed`]; what it has of its own is where the
//! force lives: on points that move with the bodies, not on the grid.

mod points;
mod stencil;

use crate::field::own_planes;
use crate::grid::Grid;
use crate::immersed::Wrench;
use crate::immersed::body::{Motion, Shape, along_axes, laboratory};
use points::Points;
use protocol::scene::CheckedScene;
use std::ops::Range;
use stencil::Stencil;

/// How far below the surface the outermost points lie, in cells.
const INSET: f64 = 0.3;

/// Root of the permeability ν/χ that λ has where it does not move the body as a whole, in cells. With these two numbers
/// a plane wall in a shear flow stands at the surface (docs/equations-immersed.md, section 9).
const SLIP: f64 = 0.182;

/// The points of all bodies on a plane grid of equal cells.
#[derive(Clone, Debug)]
pub struct FictitiousDomain<const D: usize> {
    /// Points of each body.
    ranges: Vec<Range<usize>>,
    /// Places from the bodies' centres, m.
    arms: Vec<[f64; 2]>,
    /// Area of each point over that of a cell.
    shares: Vec<f64>,
    /// λ at the points, m/s², by component.
    multipliers: [Vec<f64>; D],
    /// What the points are tied to, where they were placed last.
    stencils: [Vec<Stencil>; D],
    /// Velocity of the fluid at the points, m/s, when it was asked for last.
    velocities: [Vec<f64>; D],
    wrenches: Vec<Wrench>,
    cell: f64,
}

/// Bytes that the points of a scene's bodies take on cells of `spacing`, m.
pub fn bytes<const D: usize>(scene: &CheckedScene, spacing: f64) -> u64 {
    let points: f64 = scene.grains.iter().map(|grain| grain.volume() / (spacing * spacing)).sum();
    // Rings hold somewhat more points than cells.
    (1.2 * points) as u64 * FictitiousDomain::<D>::BYTES_PER_POINT
}

impl<const D: usize> FictitiousDomain<D> {
    /// Points in bodies of the given shapes, λ = 0.
    pub fn new(grid: &Grid<D>, shapes: &[Shape]) -> Self {
        let spacing = grid.smallest_width();
        let cell = spacing * spacing;
        let (mut arms, mut shares, mut ranges) = (Vec::new(), Vec::new(), Vec::new());
        for shape in shapes {
            let points = Points::disc(shape.radius, spacing, INSET * spacing);
            ranges.push(arms.len()..arms.len() + points.arms.len());
            arms.extend(points.arms);
            shares.extend(points.areas.iter().map(|area| area / cell));
        }
        let count = arms.len();
        Self {
            ranges,
            arms,
            shares,
            multipliers: std::array::from_fn(|_| vec![0.0; count]),
            stencils: std::array::from_fn(|_| vec![Stencil::default(); count]),
            velocities: std::array::from_fn(|_| vec![0.0; count]),
            wrenches: vec![Wrench::default(); shapes.len()],
            cell,
        }
    }

    /// Bytes for each point.
    pub const BYTES_PER_POINT: u64 = (24 + D * (16 + size_of::<Stencil>())) as u64;

    /// Puts the points where the bodies are at `motions`.
    pub fn place(&mut self, grid: &Grid<D>, motions: &[Motion]) {
        let Self { ranges, arms, stencils, .. } = self;
        for (range, motion) in ranges.iter().zip(motions) {
            let centre: [f64; D] = along_axes(grid.geometry, motion.centre);
            for i in range.clone() {
                let at = [centre[0] + arms[i][0], centre[1] + arms[i][1]];
                for (d, stencils) in stencils.iter_mut().enumerate() {
                    stencils[i] = Stencil::new(grid, d, at);
                }
            }
        }
    }

    /// `force` ← λ of the points on the grid, m/s².
    pub fn spread(&self, grid: &Grid<D>, force: &mut [Vec<f64>; D]) {
        let fields = force.iter_mut().zip(&self.multipliers).zip(&self.stencils);
        for ((field, multipliers), stencils) in fields {
            field[own_planes(grid)].fill(0.0);
            for ((lambda, share), stencil) in multipliers.iter().zip(&self.shares).zip(stencils) {
                stencil.spread(lambda * share, field);
            }
        }
    }

    /// ∫ (λ + (U − u)/dt) dV of every body, as [`crate::immersed::Immersed::forces`], with the velocity `u` where
    /// the points are.
    pub fn forces(
        &mut self,
        grid: &Grid<D>,
        motions: &[Motion],
        dt: f64,
        velocity: &[Vec<f64>; D],
    ) -> &[Wrench] {
        let Self { stencils, velocities, .. } = self;
        for ((values, stencils), field) in velocities.iter_mut().zip(stencils).zip(velocity) {
            for (value, stencil) in values.iter_mut().zip(stencils) {
                *value = stencil.interpolate(field);
            }
        }
        for (grain, motion) in motions.iter().enumerate() {
            self.wrenches[grain] = self.wrench(grid, grain, motion, dt);
        }
        &self.wrenches
    }

    /// Imposes the motion that came back, `dt` after the last time: λ and the force on the grid, then the velocity.
    /// `viscosity`: kinematic, m²/s.
    pub fn impose(
        &mut self,
        grid: &Grid<D>,
        motions: &[Motion],
        [dt, viscosity]: [f64; 2],
        [velocity, force]: [&mut [Vec<f64>; D]; 2],
    ) {
        let q = viscosity * dt / (SLIP * SLIP * self.cell);
        let keeps = q / (1.0 + q);
        for (grain, motion) in motions.iter().enumerate() {
            // What the whole body asks for: it moves as a whole.
            let [mean, turn] = self.rigid_part(grid, grain, motion, dt);
            for i in self.ranges[grain].clone() {
                let arm = self.arm(grid, i);
                let rigid = Motion { centre: [0.0; 3], velocity: mean, spin: turn };
                for d in 0..D {
                    let c = laboratory(grid.geometry, d);
                    let held = (motion.velocity_at(c, arm) - self.velocities[d][i]) / dt;
                    let rigid = rigid.velocity_at(c, arm);
                    let before = self.multipliers[d][i];
                    let now = rigid + keeps * (before + held - rigid);
                    self.multipliers[d][i] = now;
                    let change = (now - before) * self.shares[i];
                    let stencil = &self.stencils[d][i];
                    stencil.spread(change * dt, &mut velocity[d]);
                    stencil.spread(change, &mut force[d]);
                }
            }
        }
    }

    /// Mean and rotation of λ + (U − u)/dt over a body's points: m/s², 1/s².
    fn rigid_part(&self, grid: &Grid<D>, grain: usize, motion: &Motion, dt: f64) -> [[f64; 3]; 2] {
        let wrench = self.wrench(grid, grain, motion, dt);
        let (mut area, mut moment) = (0.0, 0.0);
        for i in self.ranges[grain].clone() {
            let [x, z] = self.arms[i];
            area += self.shares[i] * self.cell;
            moment += self.shares[i] * self.cell * (x * x + z * z);
        }
        [wrench.force.map(|f| f / area), wrench.torque.map(|t| t / moment)]
    }

    /// ∫ (λ + (U − u)/dt) dV of one body.
    fn wrench(&self, grid: &Grid<D>, grain: usize, motion: &Motion, dt: f64) -> Wrench {
        let mut wrench = Wrench::default();
        for i in self.ranges[grain].clone() {
            let arm = self.arm(grid, i);
            let volume = self.shares[i] * self.cell;
            let mut force = [0.0; 3];
            for d in 0..D {
                let c = laboratory(grid.geometry, d);
                let held = motion.velocity_at(c, arm) - self.velocities[d][i];
                force[c] = volume * (self.multipliers[d][i] + held / dt);
            }
            for c in 0..3 {
                let (a, b) = ((c + 1) % 3, (c + 2) % 3);
                wrench.force[c] += force[c];
                wrench.torque[c] += arm[a] * force[b] - arm[b] * force[a];
            }
        }
        wrench
    }

    /// λ at the points, by component: with the grid's fields it decides the next window.
    pub fn multipliers(&self) -> &[Vec<f64>; D] {
        &self.multipliers
    }

    /// The same, to be set.
    pub fn multipliers_mut(&mut self) -> &mut [Vec<f64>; D] {
        &mut self.multipliers
    }

    /// Place of a point from its body's centre, laboratory axes, m.
    fn arm(&self, grid: &Grid<D>, i: usize) -> [f64; 3] {
        let mut arm = [0.0; 3];
        for (a, x) in self.arms[i].iter().enumerate() {
            arm[laboratory(grid.geometry, a)] = *x;
        }
        arm
    }
}
