//! Immersed grains: where they are on the grid, how they hold the fluid, what it does to them.
//!
//! Nothing here sweeps the whole field: work is done in the rows of cells that grains cover, layer by layer
//! ([`layers`]), and nothing is kept of it but which cells hold force.

pub mod body;
pub mod brinkman;
pub mod by_layer;
pub mod component;
pub mod layer;
pub mod layer_sums;
pub mod layers;
mod mask;
pub mod mask_model;
pub mod nodes;
mod piece;
pub mod places;
mod point_mask;
pub mod pores;
mod rules;
mod transport;

use crate::grid::{Geometry, Grid};
use body::{Motion, Shape, laboratory};
use by_layer::Placed;
use component::{Component, Workspace};
use mask_model::MaskModel;
use rules::{CarriedForce, Content, DirectForce, Impose, ImposeDirectly, MarkForced, StoreMask};
use serde::{Deserialize, Serialize};
use transport::Interpolation;

/// Force and torque, or anything with a vector and its moment about the centre of a grain.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Wrench {
    /// The vector (laboratory axes).
    pub force: [f64; 3],
    /// Its moment about the centre.
    pub torque: [f64; 3],
}

/// A grid, the mask on it, and where the grains are.
pub type Where<'a, const D: usize> = (&'a Grid<D>, &'a MaskModel, &'a [Motion]);

/// All grains on all components of a grid.
#[derive(Clone, Debug)]
pub struct Immersed<const D: usize> {
    shapes: Vec<Shape>,
    components: [Component<D>; D],
    workspaces: Vec<Workspace>,
    wrenches: Vec<Wrench>,
    points: Vec<[Interpolation; D]>,
}

impl<const D: usize> Immersed<D> {
    /// Grains of the given shapes. `caches`: whether what they hold of the grid is kept until they move; for
    /// where it is asked for more than once.
    pub fn new(grid: &Grid<D>, shapes: Vec<Shape>, caches: bool) -> Self {
        Self {
            components: std::array::from_fn(|d| Component::new(grid, d, shapes.len(), caches)),
            workspaces: Vec::new(),
            points: Vec::new(),
            wrenches: vec![Wrench::default(); shapes.len()],
            shapes,
        }
    }

    /// What never changes about the grains.
    pub fn shapes(&self) -> &[Shape] {
        &self.shapes
    }

    /// The same, to set their masks.
    pub fn shapes_mut(&mut self) -> &mut [Shape] {
        &mut self.shapes
    }

    /// Declares the cells of the grains to be those that hold force (after a restore).
    pub fn mark_forced(&mut self, (grid, model, motions): Where<'_, D>) {
        let placed = Placed { grid, model, shapes: &self.shapes, motions };
        for component in &mut self.components {
            component.change(placed, &mut self.workspaces, [], &MarkForced);
        }
    }

    /// Imposes the motion and updates the carried force, `dt` of the mask after the last time; leaves the
    /// mask b of the grains in `masks`, if it is asked for.
    pub fn impose_carried(
        &mut self,
        (grid, model, motions): Where<'_, D>,
        [velocity, lambda]: [&mut [Vec<f64>; D]; 2],
        mut masks: Option<&mut [Vec<f64>; D]>,
    ) {
        let placed = Placed { grid, model, shapes: &self.shapes, motions };
        let rule = Impose { dt: model.dt };
        for (d, component) in self.components.iter_mut().enumerate() {
            let (u, lambda) = (&mut velocity[d][..], &mut lambda[d][..]);
            match &mut masks {
                Some(masks) => {
                    component.change(placed, &mut self.workspaces, [u, lambda, &mut masks[d]], &rule);
                }
                None => component.change(placed, &mut self.workspaces, [u, lambda], &rule),
            }
        }
    }

    /// The mask b of the grains (after a restore).
    pub fn store_mask(&mut self, (grid, model, motions): Where<'_, D>, masks: &mut [Vec<f64>; D]) {
        let placed = Placed { grid, model, shapes: &self.shapes, motions };
        for (component, mask) in self.components.iter_mut().zip(masks) {
            component.change(placed, &mut self.workspaces, [mask], &StoreMask);
        }
    }

    /// Takes the force λ along with the grains to where they lead in `dt` of the mask; `room`, all zero
    /// before and after, is room for it.
    pub fn advect_force(
        &mut self,
        (grid, model, motions): Where<'_, D>,
        predicted: &[Motion],
        [lambda, masks]: [&mut [Vec<f64>; D]; 2],
        room: &mut Vec<f64>,
    ) {
        self.points.clear();
        self.points.extend(motions.iter().map(|motion| Interpolation::of(grid, motion, model.dt)));
        let placed = Placed { grid, model, shapes: &self.shapes, motions: predicted };
        for (component, (lambda, mask)) in self.components.iter_mut().zip(lambda.iter_mut().zip(masks)) {
            component.advect_force(placed, &mut self.workspaces, &self.points, [lambda, mask, room]);
            std::mem::swap(lambda, room);
        }
    }

    /// Imposes the motion by eq. 7.
    pub fn impose_direct(&mut self, (grid, model, motions): Where<'_, D>, velocity: &mut [Vec<f64>; D]) {
        let placed = Placed { grid, model, shapes: &self.shapes, motions };
        for (component, u) in self.components.iter_mut().zip(velocity) {
            component.change(placed, &mut self.workspaces, [u], &ImposeDirectly);
        }
    }

    /// ∫ b (λ + (U − u)/dt) dV of every grain: the force per unit density that the grain would
    /// exert on the fluid, and its moment. Without `lambda`: eq. 7.
    pub fn forces(
        &mut self,
        (grid, model, motions): Where<'_, D>,
        velocity: &[Vec<f64>; D],
        lambda: Option<&[Vec<f64>; D]>,
    ) -> &[Wrench] {
        let rate = 1.0 / model.dt;
        let placed = Placed { grid, model, shapes: &self.shapes, motions };
        for (d, component) in self.components.iter_mut().enumerate() {
            let u = velocity[d].as_slice();
            if let Some(lambda) = lambda {
                let fields = [u, lambda[d].as_slice()];
                component.integrate(placed, &mut self.workspaces, fields, &CarriedForce(rate));
            } else {
                component.integrate(placed, &mut self.workspaces, [u], &DirectForce(rate));
            }
        }
        self.assemble(grid.geometry)
    }

    /// ∫ b u dV of every grain: the momentum per unit density of the fluid in its place.
    pub fn contents(&mut self, (grid, model, motions): Where<'_, D>, velocity: &[Vec<f64>; D]) -> &[Wrench] {
        let placed = Placed { grid, model, shapes: &self.shapes, motions };
        for (component, u) in self.components.iter_mut().zip(velocity) {
            component.integrate(placed, &mut self.workspaces, [u.as_slice()], &Content);
        }
        self.assemble(grid.geometry)
    }

    /// ∫ b dV of every grain on the nodes of each component (laboratory axes), m³, where the last integral
    /// found it. Zero where the grid has no such component, and for the radial one, along which no grain
    /// moves.
    pub fn volumes(&self, geometry: Geometry, out: &mut [[f64; 3]]) {
        out.fill([0.0; 3]);
        let first = usize::from(geometry == Geometry::Axisymmetric);
        for (d, component) in self.components.iter().enumerate().skip(first) {
            for (volume, moments) in out.iter_mut().zip(&component.moments) {
                volume[laboratory(geometry, d)] = moments.mask;
            }
        }
    }

    /// Vectors and moments from the components' integrals. On the axis of symmetry only what lies
    /// along the axis is left.
    fn assemble(&mut self, geometry: Geometry) -> &[Wrench] {
        for (grain, wrench) in self.wrenches.iter_mut().enumerate() {
            *wrench = Wrench::default();
            for (d, component) in self.components.iter().enumerate() {
                let c = laboratory(geometry, d);
                let moments = &component.moments[grain];
                if geometry == Geometry::Axisymmetric {
                    if c == 2 {
                        wrench.force[2] = moments.sum;
                    }
                    continue;
                }
                let (a, b) = ((c + 1) % 3, (c + 2) % 3);
                wrench.force[c] += moments.sum;
                // r × e_c
                wrench.torque[a] += moments.arm[b];
                wrench.torque[b] -= moments.arm[a];
            }
        }
        &self.wrenches
    }
}
