//! The force of grains that move over the grid: it goes with them, and viscosity feels its change in the same
//! step (docs/equations-immersed.md, section 7).
//!
//! A force that stays in its cells lags behind its grain by a step: some per cent of a slow grain's velocity,
//! much beside the flow through a dense bed. The remedies act in the steps in which the error is felt
//! ([`crate::immersed::brinkman::lag`]).

use super::calibration::{Calibration, ForceTransport};
use crate::field::clear_own;
use crate::grid::Grid;
use crate::immersed::brinkman::{Brinkman, FIELDS, LAG, lag, largest_viscous_number};
use crate::methods::grains::Grains;
use crate::step::Stepper;
use bedload_scene::{CheckedScene, Geometry, Grain, Medium, Motion};
use protocol::scheme::Scheme;

/// Solid fraction from which on one moving sphere is a bed with its images.
const FULL: f64 = 0.05;

/// Lag from which on the force of a sphere alone is taken along: there it would gain 0.5 to 1 % of its
/// velocity. Below, where convection is strong, the force in place errs less.
const LAG_ALONE: f64 = 0.3;

/// How the carried force goes with the grains of a scene, where one of them moves and it does not stay in its
/// cells. A repeated window needs the force where the window began: there it stays.
pub(crate) fn transport(
    scene: &CheckedScene,
    calibration: &Calibration,
    scheme: Scheme,
) -> Option<ForceTransport> {
    let stays = moving(scene) == 0 || scheme == Scheme::Iterated;
    Some(calibration.force_transport).filter(|transport| !stays && *transport != ForceTransport::Eulerian)
}

/// Whether grains form pores, where viscosity must feel a change of the force in the same step: discs of the
/// plane, and spheres in space of which two or more move, or that fill more than a twentieth of their box.
pub(crate) fn has_pores(scene: &CheckedScene) -> bool {
    match scene.scene.domain.geometry {
        Geometry::Plane => true,
        Geometry::Space => moving(scene) > 1 || is_full(scene),
        Geometry::Axisymmetric => false,
    }
}

/// How many grains move over the grid.
pub(super) fn moving(scene: &CheckedScene) -> usize {
    let geometry = scene.scene.domain.geometry;
    scene.grains.iter().filter(|grain| !grain.stays(geometry)).count()
}

fn is_full(scene: &CheckedScene) -> bool {
    let domain = &scene.scene.domain;
    let size: f64 = domain.lower.iter().zip(&domain.upper).map(|(lower, upper)| upper - lower).product();
    scene.grains.iter().map(Grain::volume).sum::<f64>() > FULL * size
}

/// Longest step in which every free grain is stable with the local solve, s.
fn longest_local_step(scene: &CheckedScene, medium: &Medium) -> f64 {
    let free = scene.grains.iter().filter(|grain| grain.motion == Motion::Free);
    let disc = scene.scene.domain.geometry == Geometry::Plane;
    let longest = |grain: &Grain| {
        let diameter = 2.0 * grain.radius;
        // Of a body that is not round: it turns more easily than the disc about it, whose torque it has at
        // most.
        let about = 0.5 * std::f64::consts::PI * grain.radius.powi(4);
        let share = if grain.shape.is_round() { 1.0 } else { grain.volume() * grain.gyration() / about };
        largest_viscous_number(disc, grain.density / medium.density, share) * diameter * diameter
            / medium.kinematic_viscosity()
    };
    free.map(longest).fold(f64::INFINITY, f64::min)
}

/// Transport of the force, and the local solve.
pub(super) struct Advection<const D: usize> {
    /// Whether the force is taken along in every step.
    always: bool,
    /// Lag from which on the force is taken along.
    least: f64,
    /// Mask b of the grains where the force is.
    pub(super) masks: [Vec<f64>; D],
    local_solve: Option<Brinkman<D>>,
    /// Longest step of the local solve, s.
    longest: f64,
    /// Error of the present window if the force stayed in its cells.
    lag: f64,
}

impl<const D: usize> Advection<D> {
    /// `local_solve`: whether there is one.
    pub(super) fn new(
        scene: &CheckedScene,
        medium: &Medium,
        transport: ForceTransport,
        local_solve: bool,
        grid: &Grid<D>,
    ) -> Self {
        let always = transport == ForceTransport::Advected;
        Self {
            always,
            least: if has_pores(scene) { LAG[0] } else { LAG_ALONE },
            masks: grid.new_vector(),
            local_solve: local_solve.then(|| Brinkman::new(grid)),
            longest: if always { f64::INFINITY } else { longest_local_step(scene, medium) },
            lag: 0.0,
        }
    }

    /// Takes the force to where the grains will be, if it would lag.
    pub(super) fn move_force(&mut self, grid: &Grid<D>, grains: &mut Grains<D>, room: &mut Vec<f64>) {
        let Grains { immersed, model, memory, predicted, force, .. } = grains;
        self.lag =
            if self.always { f64::INFINITY } else { lag(grid, model, immersed.shapes(), &memory.motions) };
        if self.lag >= self.least {
            let fields = [force, &mut self.masks];
            immersed.advect_force((grid, model, &memory.motions), predicted, fields, room);
        }
    }

    /// Lets viscosity feel the change of the force, in steps that the grains allow.
    pub(super) fn respond(
        &mut self,
        fluid: &mut Stepper<D>,
        grains: &mut Grains<D>,
        dt: f64,
        room: &mut [Vec<f64>; FIELDS],
    ) {
        let wanted = self.lag >= LAG[1] && dt <= self.longest;
        let Some(local_solve) = self.local_solve.as_mut().filter(|_| wanted) else { return };
        let Grains { immersed, model, predicted, force, .. } = grains;
        let (grid, state) = fluid.parts_mut();
        local_solve.respond(immersed, (grid, model, predicted), [&mut state.velocity, force], room);
    }

    /// Forgets where the force is.
    pub(super) fn clear(&mut self, grid: &Grid<D>) {
        clear_own(grid, &mut self.masks);
    }
}
