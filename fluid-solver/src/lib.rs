//! Incompressible Navier–Stokes solver on a staggered grid, for immersed grains.
//!
//! Start from:
//! - [`step::Stepper`]: one time step of the fluid alone, on a [`grid::Grid`];
//! - [`solver::Solver`]: the fluid of a scene with its grains, one window at a time;
//! - [`participant::Fluid`]: the same as a participant of a coupled run, on any geometry;
//! - [`boundary::Boundary`] and [`axis::AxisSpec`]: what a grid is made of;
//! - [`scheme::Options`]: viscosity, time scheme, driving force;
//! - [`methods`]: the methods of the immersed boundary, `fluid.method`;
//! - [`immersed::Immersed`]: grains on the grid, their masks and the force that imposes their motion.
//!
//! The equations stand in `docs/equations.md` and `docs/equations-immersed.md`, the order of a step in
//! [`step`].
//!
//! A channel driven by a body force `f` ends in Poiseuille flow, `u = f h²/(8 ν)` in the middle:
//! ```
//! use fluid_solver::axis::AxisSpec;
//! use fluid_solver::boundary::Boundary;
//! use fluid_solver::grid::{Geometry, Grid, GridSpec};
//! use fluid_solver::scheme::{Options, Scheme, Viscous};
//! use fluid_solver::step::Stepper;
//!
//! let axis = |cells| AxisSpec::Uniform { start: 0.0, end: 1.0, cells };
//! let grid = Grid::new(&GridSpec {
//!     geometry: Geometry::Plane,
//!     axes: [axis(4), axis(17)],
//!     boundaries: [[Boundary::Periodic, Boundary::Periodic], [Boundary::WALL, Boundary::WALL]],
//! })?;
//! let mut stepper = Stepper::new(grid, Options {
//!     viscosity: 1.0,
//!     scheme: Scheme::AdamsBashforth2,
//!     viscous: Viscous::Implicit,
//!     convection: true,
//!     body_force: [8.0, 0.0],
//! });
//! for _ in 0..200 {
//!     stepper.step(0.01, None);
//! }
//! let middle = stepper.grid().index([2, 8]);
//! let u = stepper.state().velocity[0][middle];
//! assert!((u - 1.0).abs() < 4e-3, "{u}");
//! # Ok::<(), fluid_solver::grid::GridError>(())
//! ```

#![warn(missing_docs)]

pub use fluid_kernels::{
    axis, boundary, division, engine, field, first_non_finite, flow_rate, geometry, grid, grid_error, halo,
    health, helmholtz, immersed, interpolate, lanes, measure, open, ranks, scheme, stencil, step, threads,
    timings, transform, tridiagonal, work,
};

mod bounds;
pub mod build;
pub mod checkpoint;
pub mod config;
pub mod coupling;
pub mod facts;
pub mod follow;
pub mod initial;
pub mod launcher;
pub mod lines;
pub mod memory;
pub mod methods;
pub mod orders;
pub mod output;
pub mod participant;
pub mod plan;
pub mod planes;
pub mod program;
pub mod solver;
mod speed;
