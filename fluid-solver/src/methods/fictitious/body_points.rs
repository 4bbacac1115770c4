//! Points in bodies on a plane grid, and the Lagrange multipliers λ there (docs/equations-immersed.md,
//! section 9).

use super::points::Points;
use super::stencil::Stencil;
use crate::field::clear_own;
use crate::grid::{Geometry, Grid};
use crate::immersed::Wrench;
use crate::immersed::body::{Motion, Shape, along_axes, laboratory};
use crate::methods::immersed_boundary::OnWalls;
use bedload_scene::CheckedScene;
use std::ops::Range;

/// How far below the surface the outermost points lie, in cells.
const INSET: f64 = 0.3;

/// Root of the permeability ν/χ that λ has where it does not move the body as a whole, in cells. With these
/// two numbers a plane wall in a shear flow stands at the surface (docs/equations-immersed.md, section 9).
const SLIP: f64 = 0.182;

/// The points of all bodies on a plane grid of equal cells.
#[derive(Clone, Debug)]
pub struct BodyPoints<const D: usize> {
    /// Points of each body.
    ranges: Vec<Range<usize>>,
    /// Places from the bodies' centres, m.
    arms: Vec<[f64; 2]>,
    /// The same in the frame of the body, for bodies that are not round.
    own_arms: Vec<Vec<[f64; 2]>>,
    /// Area of each point over that of a cell.
    shares: Vec<f64>,
    /// λ at the points, m/s², by component: with the grid's fields it decides the next window.
    pub(super) multipliers: [Vec<f64>; D],
    /// Cells and weights that tie the points to the grid, where they were placed last.
    stencils: [Vec<Stencil>; D],
    /// Velocity of the fluid at the points, m/s, as interpolated last.
    velocities: [Vec<f64>; D],
    /// Area of each body, m², and its second moment about the centre, m⁴.
    moments: Vec<[f64; 2]>,
    wrenches: Vec<Wrench>,
    /// Area of a cell, m².
    cell: f64,
}

/// Bytes that the points of a scene's bodies take on cells of `spacing`, m.
pub fn bytes<const D: usize>(scene: &CheckedScene, spacing: f64) -> u64 {
    let points: f64 = scene.grains.iter().map(|grain| grain.volume() / (spacing * spacing)).sum();
    // Rings hold somewhat more points than cells.
    (1.2 * points) as u64 * BodyPoints::<D>::BYTES_PER_POINT
}

impl<const D: usize> BodyPoints<D> {
    /// Points in bodies of the given shapes, λ = 0.
    pub fn new(grid: &Grid<D>, shapes: &[Shape]) -> Self {
        let spacing = grid.smallest_width();
        let cell = spacing * spacing;
        let (mut arms, mut shares, mut ranges) = (Vec::new(), Vec::new(), Vec::new());
        let (mut moments, mut own_arms) = (Vec::new(), Vec::new());
        for shape in shapes {
            let inset = INSET * spacing;
            let points = match &shape.outline {
                None => Points::disc(shape.radius, spacing, inset),
                Some(outline) => Points::of(outline, spacing, inset),
            };
            own_arms.push(if shape.outline.is_some() { points.arms.clone() } else { Vec::new() });
            let moment =
                points.arms.iter().zip(&points.areas).map(|([x, z], area)| area * (x * x + z * z)).sum();
            moments.push([points.areas.iter().sum(), moment]);
            ranges.push(arms.len()..arms.len() + points.arms.len());
            arms.extend(points.arms);
            shares.extend(points.areas.iter().map(|area| area / cell));
        }
        let count = arms.len();
        Self {
            ranges,
            arms,
            own_arms,
            shares,
            multipliers: std::array::from_fn(|_| vec![0.0; count]),
            stencils: std::array::from_fn(|_| vec![Stencil::default(); count]),
            velocities: std::array::from_fn(|_| vec![0.0; count]),
            moments,
            wrenches: vec![Wrench::default(); shapes.len()],
            cell,
        }
    }

    /// Bytes for each point.
    pub const BYTES_PER_POINT: u64 = (24 + D * (16 + size_of::<Stencil>())) as u64;

    /// Puts the points where the bodies are at `motions`.
    pub fn place(&mut self, grid: &Grid<D>, motions: &[Motion]) {
        let Self { ranges, arms, own_arms, stencils, .. } = self;
        for ((range, own_arms), motion) in ranges.iter().zip(own_arms).zip(motions) {
            // Rings of a disc need not turn with it.
            let (sine, cosine) = motion.angle.sin_cos();
            for (arm, [x, z]) in arms[range.clone()].iter_mut().zip(own_arms) {
                *arm = [cosine * *x + sine * *z, cosine * *z - sine * *x];
            }
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
        clear_own(grid, force);
        let fields = force.iter_mut().zip(&self.multipliers).zip(&self.stencils);
        for ((field, multipliers), stencils) in fields {
            for ((lambda, share), stencil) in multipliers.iter().zip(&self.shares).zip(stencils) {
                stencil.spread(lambda * share, field);
            }
        }
    }

    /// ∫ λ dV that goes to the walls of the box, not to the fluid: points within a cell and a half of one
    /// spread to its mirror image, too. By axis, side and component, m³/s².
    pub fn held_by_walls(&self, grid: &Grid<D>) -> OnWalls<D> {
        let mut sums = [[[0.0; D]; 2]; D];
        for (d, (multipliers, stencils)) in self.multipliers.iter().zip(&self.stencils).enumerate() {
            for ((lambda, share), stencil) in multipliers.iter().zip(&self.shares).zip(stencils) {
                for (sides, (side, part)) in sums.iter_mut().zip(stencil.held_by_walls(grid)) {
                    sides[side][d] += lambda * share * self.cell * part;
                }
            }
        }
        sums
    }

    /// ∫ (λ + (U − u)/dt) dV of every body, as [`crate::immersed::Immersed::forces`], with the velocity `u`
    /// where the points are.
    pub fn forces(
        &mut self,
        grid: &Grid<D>,
        motions: &[Motion],
        dt: f64,
        velocity: &[Vec<f64>; D],
    ) -> &[Wrench] {
        let Self { ranges, arms, stencils, velocities, .. } = self;
        for (d, ((values, stencils), field)) in velocities.iter_mut().zip(stencils).zip(velocity).enumerate()
        {
            for (range, motion) in ranges.iter().zip(motions) {
                for i in range.clone() {
                    // Beyond an open face the fluid of the body goes along with it.
                    values[i] = if stencils[i].is_out() {
                        Plane::<D>::of(motion).at(d, arms[i])
                    } else {
                        stencils[i].interpolate(field)
                    };
                }
            }
        }
        for (grain, motion) in motions.iter().enumerate() {
            let (force, torque) = self.wrench(grain, Plane::of(motion), dt);
            let wrench = &mut self.wrenches[grain];
            *wrench = Wrench::default();
            for (d, force) in force.into_iter().enumerate() {
                wrench.force[laboratory(grid.geometry, d)] = force;
            }
            wrench.torque[1] = torque;
        }
        &self.wrenches
    }

    /// Imposes the motion that came back, `dt` after the last time: λ, then the velocity. `viscosity`:
    /// kinematic, m²/s.
    pub fn impose(&mut self, motions: &[Motion], [dt, viscosity]: [f64; 2], velocity: &mut [Vec<f64>; D]) {
        let q = viscosity * dt / (SLIP * SLIP * self.cell);
        let keeps = q / (1.0 + q);
        for (grain, motion) in motions.iter().enumerate() {
            // What the whole body asks for: it moves as a whole.
            let motion = Plane::of(motion);
            let (force, torque) = self.wrench(grain, motion, dt);
            let [area, moment] = self.moments[grain];
            let rigid = Plane { velocity: force.map(|f| f / area), spin: torque / moment };
            let range = self.ranges[grain].clone();
            let (arms, shares) = (&self.arms[range.clone()], &self.shares[range.clone()]);
            for (d, field) in velocity.iter_mut().enumerate() {
                let multipliers = &mut self.multipliers[d][range.clone()];
                let (stencils, found) =
                    (&self.stencils[d][range.clone()], &self.velocities[d][range.clone()]);
                for (((lambda, arm), share), (stencil, u)) in
                    multipliers.iter_mut().zip(arms).zip(shares).zip(stencils.iter().zip(found))
                {
                    let held = (motion.at(d, *arm) - u) / dt;
                    let rigid = rigid.at(d, *arm);
                    let now = rigid + keeps * (*lambda + held - rigid);
                    stencil.spread((now - *lambda) * share * dt, field);
                    *lambda = now;
                }
            }
        }
    }

    /// ∫ (λ + (U − u)/dt) dV of one body, and its moment about y.
    fn wrench(&self, grain: usize, motion: Plane<D>, dt: f64) -> ([f64; D], f64) {
        let range = self.ranges[grain].clone();
        let (arms, shares) = (&self.arms[range.clone()], &self.shares[range.clone()]);
        let (mut force, mut torque) = ([0.0; D], 0.0);
        for (d, sum) in force.iter_mut().enumerate() {
            let (lambdas, found) = (&self.multipliers[d][range.clone()], &self.velocities[d][range.clone()]);
            for (((lambda, u), arm), share) in lambdas.iter().zip(found).zip(arms).zip(shares) {
                let force = self.cell * share * (lambda + (motion.at(d, *arm) - u) / dt);
                *sum += force;
                torque += Plane { velocity: [0.0; D], spin: force }.at(d, *arm);
            }
        }
        (force, torque)
    }
}

/// A motion in the plane: along its axes, and about y.
#[derive(Clone, Copy)]
struct Plane<const D: usize> {
    velocity: [f64; D],
    spin: f64,
}

impl<const D: usize> Plane<D> {
    fn of(motion: &Motion) -> Self {
        Self { velocity: along_axes(Geometry::Plane, motion.velocity), spin: motion.spin[1] }
    }

    /// Component `d` at `arm` from the centre: (ω × r)_x = ω r_z, (ω × r)_z = −ω r_x.
    #[inline(always)]
    fn at(&self, d: usize, arm: [f64; 2]) -> f64 {
        self.velocity[d] + if d == 0 { self.spin * arm[1] } else { -self.spin * arm[0] }
    }
}
