//! The calibrated method: a force λ in the cells of a mask, carried from step to step, as a true fixed point
//! (docs/equations-immersed.md, section 3; after Yu & Shao 2007).
//!
//! ```text
//! u* : one step of the fluid with the force λ
//! G  = Σ β (u* − U) dV − dt β λ dV            the impulse that the grain is sent, at its predicted place
//! λ' = β (λ + (U' − u*)/dt)                   U': the motion that comes back
//! u  = u* + dt (λ' − λ)
//! ```
//! The mask is a Brinkman medium whose surface is where the flow feels it ([`crate::immersed::mask_model`]).
//! Near grains convection is refined ([`crate::near_convection`]). In space and in the plane the radius of
//! the mask follows the pores ([`crate::immersed::pores`]), and in dense beds the force goes with the grains
//! and viscosity feels its change in the same step ([`advection`]). Where windows are repeated,
//! [`iterations`] mixes the attempts; elsewhere the jump of a contact goes to the fluid at once
//! ([`contact`]).

pub mod advection;
pub mod calibration;
pub mod contact;
pub mod iterations;
mod touch;
mod wall_impulse;

use super::grains::Grains;
use super::immersed_boundary::{ImmersedBoundary, OnWalls};
use super::loads::GrainLoads;
use super::needs::Needs;
use crate::config::Choices;
use crate::field::clear_own;
use crate::grid::Grid;
use crate::immersed::Immersed;
use crate::immersed::body::Motion;
use crate::immersed::brinkman::FIELDS;
use crate::immersed::mask_model::MaskModel;
use crate::immersed::pores::Pores;
use crate::scene_grains;
use crate::step::Stepper;
use advection::Advection;
use bedload_scene::{CheckedScene, Geometry, Medium, Total};
use contact::Contact;
use iterations::Iterations;
use protocol::message::Loads;
use protocol::participant::Window;
use protocol::scheme::Scheme;

/// Part of the smallest cell width within which a grain counts as where it was expected. The mask falls by
/// about one over a cell, so this changes a cell's share by as much at most; and it never adds up, as every
/// window expects a grain from where it truly is.
const AS_EXPECTED: f64 = 1e-4;

/// The calibrated method.
pub struct Calibrated<const D: usize> {
    loads: GrainLoads,
    /// Radius of the masks, where it is corrected.
    pores: Option<Pores<D>>,
    /// Transport of the force with the grains, where the scene is one in which it may lag.
    advection: Option<Advection<D>>,
    /// Whether convection is refined near the grains.
    refines: bool,
    /// Attempts at the present window, where windows are repeated.
    iterations: Option<Box<Iterations<D>>>,
    /// What contacts do to the fluid in their own window, where there may be contacts.
    contact: Option<Contact<D>>,
    /// Whether touches shorten the step: where few grains move.
    few: bool,
    /// Fields for what is worked with in between, all zero: as many as the parts of a step need, one after
    /// the other.
    room: [Vec<f64>; FIELDS],
}

impl<const D: usize> Calibrated<D> {
    /// For the grains of a scene.
    pub(super) fn new(
        scene: &CheckedScene,
        medium: &Medium,
        choices: &Choices,
        scheme: Scheme,
        needs: &Needs,
        grid: &Grid<D>,
        grains: &mut Grains<D>,
        loads: GrainLoads,
    ) -> Self {
        let shapes = grains.immersed.shapes();
        // The radius that the flow feels, where the correction was measured: off an axis of symmetry.
        let corrects = !shapes.is_empty()
            && !choices.calibration.nominal_radius
            && scene.scene.domain.geometry != Geometry::Axisymmetric;
        let gyration = shapes.iter().map(|shape| shape.gyration).collect();
        let mut method = Self {
            loads,
            pores: corrects.then(|| Pores::new(grid, shapes)),
            advection: needs
                .transport
                .map(|transport| Advection::new(scene, medium, transport, needs.local_solve, grid)),
            refines: needs.near_convection,
            iterations: (scheme == Scheme::Iterated).then(|| Box::new(Iterations::new(gyration))),
            contact: needs.jumps.then(|| {
                let totals = scene.scene.observe.totals.as_ref();
                let walls = totals.is_some_and(|asked| asked.has(&Total::ON_WALLS));
                Contact::new(grid, shapes, scene_grains::free(scene), walls)
            }),
            few: advection::moving(scene) <= touch::FEW,
            room: std::array::from_fn(|n| if n < room(needs, D) { grid.new_field() } else { Vec::new() }),
        };
        let Grains { immersed, model, memory, .. } = grains;
        method.set_masks(grid, immersed, model, &memory.motions, (&mut memory.rests, false));
        method
    }

    /// Masks in a window that begins with `motions`: their radii, and where grains have come to rest; `rests`
    /// as in [`GrainLoads::open_masks`].
    fn set_masks(
        &mut self,
        grid: &Grid<D>,
        immersed: &mut Immersed<D>,
        model: &MaskModel,
        motions: &[Motion],
        rests: (&mut [u8], bool),
    ) {
        if let Some(pores) = &mut self.pores {
            pores.set_radii(grid.geometry, model, immersed.shapes_mut(), motions);
        }
        self.loads.open_masks(immersed, model, grid.smallest_width(), motions, rests);
    }
}

/// Fields of room that the parts of a step need on `axes` axes.
pub(crate) fn room(needs: &Needs, axes: usize) -> usize {
    let transport = usize::from(needs.transport.is_some());
    let solve = if needs.local_solve { FIELDS } else { 0 };
    transport.max(solve).max(if needs.jumps { axes } else { 0 })
}

impl<const D: usize> ImmersedBoundary<D> for Calibrated<D> {
    fn place(&mut self, fluid: &Stepper<D>, grains: &mut Grains<D>, window: &Window) {
        let Grains { immersed, model, memory, .. } = &mut *grains;
        self.set_masks(fluid.grid(), immersed, model, &memory.motions, (&mut memory.rests, true));
        if let Some(iterations) = &mut self.iterations {
            iterations.guess(fluid, grains, window);
        }
        grains.predict(window.dt);
        if let Some(iterations) = &self.iterations {
            iterations.place(&mut grains.predicted);
        }
        if let Some(advection) = &mut self.advection {
            advection.move_force(fluid.grid(), grains, &mut self.room[0]);
        }
    }

    fn step(&mut self, fluid: &mut Stepper<D>, grains: &mut Grains<D>, dt: f64) {
        if self.refines {
            let spheres = grains.immersed.shapes().iter().zip(&grains.predicted);
            fluid.refine_near(spheres.map(|(shape, motion)| (motion.centre, shape.radius)));
        }
        fluid.step(dt, grains.force());
    }

    fn measure(&mut self, fluid: &mut Stepper<D>, grains: &mut Grains<D>, dt: f64) {
        if let Some(advection) = &mut self.advection {
            advection.respond(fluid, grains, dt, &mut self.room);
        }
        let Grains { immersed, model, predicted, force, .. } = &mut *grains;
        if predicted.is_empty() {
            return;
        }
        let velocity = &fluid.state().velocity;
        self.loads.set_forces(immersed.forces((fluid.grid(), model, predicted), velocity, Some(&*force)));
        self.loads.measure(fluid, grains);
        if let Some(iterations) = &self.iterations {
            iterations.virtual_mass_ahead(grains, dt, &mut self.loads.measured);
        }
        self.loads.measure_virtual_mass(grains, self.iterations.is_some());
    }

    fn loads(&self, grains: &Grains<D>, out: &mut [Loads]) {
        self.loads.write(grains.immersed.shapes(), out);
    }

    fn leak(&self, grains: &Grains<D>) -> Option<(f64, usize)> {
        self.loads.leak(grains)
    }

    /// Masks and carried force at the motion known now. A grain that came back where it was expected is held
    /// there, where its mask is known.
    fn impose(&mut self, fluid: &mut Stepper<D>, grains: &mut Grains<D>, dt: f64) {
        if self.contact.is_some() {
            self.loads.find_jumps(fluid.grid(), grains, dt);
        }
        let (grid, state) = fluid.parts_mut();
        let Grains { immersed, model, memory, predicted, force, .. } = &mut *grains;
        if !memory.motions.is_empty() {
            memory.imposed_dt = model.dt;
            let near = AS_EXPECTED * grid.smallest_width();
            let known = memory.motions.iter().zip(&memory.jumps).zip(predicted);
            for (to, ((motion, jump), predicted)) in memory.imposed.iter_mut().zip(known) {
                let expected = (0..3).all(|c| (motion.centre[c] - predicted.centre[c]).abs() <= near);
                let place = if expected { predicted } else { motion };
                // The force knows nothing of the jump.
                let velocity = std::array::from_fn(|c| motion.velocity[c] - jump[c]);
                *to = Motion { velocity, spin: motion.spin, ..*place };
            }
            let velocity = &mut state.velocity;
            let masks = self.advection.as_mut().map(|advection| &mut advection.masks);
            immersed.impose_carried((grid, model, &memory.imposed), [velocity, force], masks);
        }
        if let Some(iterations) = &mut self.iterations {
            iterations.note(dt, grid, grains);
        }
        if let Some(contact) = &mut self.contact {
            let field = self.room.first_chunk_mut().expect("as many as axes");
            contact.give(fluid, grains, self.loads.touches(), dt, field);
        }
    }

    fn part_of_step(&mut self, grains: &Grains<D>, allowed: f64, spacing: f64) -> f64 {
        let at_rest = touch::part_at_rest(&self.loads, grains, allowed, spacing);
        if !self.few || self.contact.is_none() {
            return at_rest;
        }
        touch::part_at_touches(&mut self.loads, grains, allowed, spacing).min(at_rest)
    }

    fn force_on_walls(&self, _: &Grid<D>, dt: f64) -> Option<OnWalls<D>> {
        let impulse = self.contact.as_ref()?.walls.as_ref()?.on_walls;
        let along = |a: usize, push: f64| std::array::from_fn(|d| if d == a { push / dt } else { 0.0 });
        Some(std::array::from_fn(|a| impulse[a].map(|push| along(a, push))))
    }

    /// Finds the cells that hold force, and the virtual masses of the window before.
    fn resume(&mut self, fluid: &Stepper<D>, grains: &mut Grains<D>) {
        self.loads.resume(grains);
        let grid = fluid.grid();
        let Grains { immersed, model, memory, .. } = grains;
        if memory.imposed_dt > 0.0 {
            let model = MaskModel { dt: memory.imposed_dt, ..*model };
            self.set_masks(grid, immersed, &model, &memory.before, (&mut memory.rests, false));
            immersed.mark_forced((grid, &model, &memory.imposed));
            if let Some(advection) = &mut self.advection {
                advection.clear(grid);
                clear_own(grid, &mut self.room);
                immersed.store_mask((grid, &model, &memory.imposed), &mut advection.masks);
            }
        }
    }
}
