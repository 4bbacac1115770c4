//! Immersed grains: where they are on the grid, how they hold the fluid, what it does to them.
//!
//! Nothing here sweeps the whole field: work is done in the rows of cells that grains cover.

pub mod body;
pub mod carried;
pub mod component;
pub mod cover;
pub mod direct;
pub mod mask;
mod odds;
pub mod volume_fraction;

use crate::grid::{Geometry, Grid};
use body::{Motion, Shape, laboratory};
use carried::Imposed;
use component::{Component, Point, WORTH_A_THREAD};
use mask::Kernel;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// Force and torque, or anything with a vector and its moment about the centre of a grain.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Wrench {
    /// The vector (laboratory axes).
    pub force: [f64; 3],
    /// Its moment about the centre.
    pub torque: [f64; 3],
}

/// All grains on all components of a grid.
#[derive(Clone, Debug)]
pub struct Immersed<const D: usize> {
    shapes: Vec<Shape>,
    components: [Component<D>; D],
    wrenches: Vec<Wrench>,
}

impl<const D: usize> Immersed<D> {
    /// Grains of the given shapes.
    pub fn new(grid: &Grid<D>, shapes: Vec<Shape>) -> Self {
        Self {
            components: std::array::from_fn(|d| Component::new(grid, d, shapes.len())),
            wrenches: vec![Wrench::default(); shapes.len()],
            shapes,
        }
    }

    /// What never changes about the grains.
    pub fn shapes(&self) -> &[Shape] {
        &self.shapes
    }

    /// Places the grains and sums their odds, ready for integrals and for imposing.
    pub fn place(&mut self, grid: &Grid<D>, kernel: &Kernel, motions: &[Motion]) {
        let busy = self.busy();
        let Self { shapes, components, .. } = self;
        each(busy, components, |_, component| {
            component.place(grid, kernel, shapes, motions);
            component.gather(grid, motions);
        });
    }

    /// Forgets the sums of [`Immersed::place`].
    pub fn clear(&mut self) {
        each(self.busy(), &mut self.components, |_, component| component.clear());
    }

    /// Declares the cells of `motions` to be those that hold force (after a restore).
    pub fn hold(&mut self, grid: &Grid<D>, kernel: &Kernel, motions: &[Motion]) {
        let busy = self.busy();
        let Self { shapes, components, .. } = self;
        each(busy, components, |_, component| {
            component.place(grid, kernel, shapes, motions);
            component.swap();
        });
    }

    /// Imposes the motion and updates the carried force. Uses up the sums.
    pub fn impose_carried(
        &mut self,
        imposed: Imposed,
        dt: f64,
        velocity: &mut [Vec<f64>; D],
        lambda: &mut [Vec<f64>; D],
    ) {
        let busy = self.busy();
        let fields = velocity.iter_mut().zip(lambda.iter_mut());
        let mut parts: [_; D] = collect(self.components.iter_mut().zip(fields));
        each(busy, &mut parts, |_, (component, (u, lambda))| {
            carried::impose(component, imposed, dt, u, lambda);
        });
    }

    /// Imposes the motion by eq. 7. Uses up the sums.
    pub fn impose_direct(&mut self, velocity: &mut [Vec<f64>; D]) {
        let busy = self.busy();
        let mut parts: [_; D] = collect(self.components.iter_mut().zip(velocity.iter_mut()));
        each(busy, &mut parts, |_, (component, u)| direct::impose(component, u));
    }

    /// ∫ b (λ + (U − u)/dt) dV of every grain: the force per unit density that the grain would
    /// exert on the fluid, and its moment. Without `lambda`: eq. 7.
    pub fn forces(
        &mut self,
        grid: &Grid<D>,
        motions: &[Motion],
        dt: f64,
        velocity: &[Vec<f64>; D],
        lambda: Option<&[Vec<f64>; D]>,
    ) -> &[Wrench] {
        let rate = 1.0 / dt;
        each(self.busy(), &mut self.components, |d, component| {
            let u = velocity[d].as_slice();
            if let Some(lambda) = lambda {
                component.integrate(grid, motions, [u, &lambda[d]], |p: Point<2>| {
                    let [u, lambda] = p.fields;
                    p.share() * (lambda + rate * (p.solid - u))
                });
            } else {
                component
                    .integrate(grid, motions, [u], |p: Point<1>| p.share() * rate * (p.solid - p.fields[0]));
            }
        });
        self.assemble(grid.geometry)
    }

    /// ∫ b u dV of every grain: the momentum per unit density of the fluid in its place.
    pub fn contents(&mut self, grid: &Grid<D>, motions: &[Motion], velocity: &[Vec<f64>; D]) -> &[Wrench] {
        each(self.busy(), &mut self.components, |d, component| {
            component.integrate(grid, motions, [&velocity[d]], |p: Point<1>| p.share() * p.fields[0]);
        });
        self.assemble(grid.geometry)
    }

    /// ∫ λ dV of every grain where it was held last, shared by odds (F5).
    pub fn carried(&mut self, grid: &Grid<D>, held: &[Motion], lambda: &[Vec<f64>; D]) -> &[Wrench] {
        each(self.busy(), &mut self.components, |d, component| {
            component.swap();
            component.gather(grid, held);
            component.integrate(grid, held, [&lambda[d]], |p: Point<1>| {
                if p.total > 0.0 { p.odds / p.total * p.fields[0] } else { 0.0 }
            });
            component.clear();
            component.swap();
        });
        self.assemble(grid.geometry)
    }

    /// ∫ b dV of every grain on the nodes of each component (laboratory axes), m³. Zero where the
    /// grid has no such component, and for the radial one, along which no grain moves.
    pub fn volumes(&mut self, grid: &Grid<D>, motions: &[Motion], out: &mut [[f64; 3]]) {
        each(self.busy(), &mut self.components, |_, component| {
            component.integrate(grid, motions, [], |p: Point<0>| p.share());
        });
        let first = usize::from(grid.geometry == Geometry::Axisymmetric);
        for (grain, volume) in out.iter_mut().enumerate() {
            *volume = [0.0; 3];
            for (d, component) in self.components.iter().enumerate().skip(first) {
                volume[laboratory(grid.geometry, d)] = component.moments[grain].sum;
            }
        }
    }

    /// Whether the grains hold enough cells for a second thread to bring something.
    fn busy(&self) -> bool {
        self.components.iter().map(Component::cells).sum::<usize>() > WORTH_A_THREAD
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

/// Does `work` for every component, at the same time where there are threads and it is worth it.
fn each<T: Send, const D: usize>(busy: bool, parts: &mut [T; D], work: impl Fn(usize, &mut T) + Sync) {
    if busy && rayon::current_num_threads() > 1 {
        parts.par_iter_mut().enumerate().for_each(|(d, part)| work(d, part));
    } else {
        parts.iter_mut().enumerate().for_each(|(d, part)| work(d, part));
    }
}

/// An iterator of `D` items as an array.
fn collect<T, const D: usize>(mut items: impl Iterator<Item = T>) -> [T; D] {
    std::array::from_fn(|_| items.next().expect("one item per component"))
}
