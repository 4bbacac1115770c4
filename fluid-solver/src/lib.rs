//! Incompressible Navier–Stokes solver on a staggered grid, for immersed grains.
//!
//! Start from:
//! - [`solver::Solver`]: the fluid of a scene with its grains, one window at a time;
//! - [`participant::Fluid`]: the same as a participant of a coupled run, on any geometry;
//! - [`methods`]: the methods of the immersed boundary, `fluid.method`;
//! - [`fluid_kernels`]: grid, step, solves and masks, which know no scene.
//!
//! The equations stand in `docs/equations.md` and `docs/equations-immersed.md`, the order of a step in
//! [`step`].

#![warn(missing_docs)]

pub use fluid_kernels::{
    axis, boundary, division, drive, engines, field, first_non_finite, flow_rate, grid, halo, health,
    helmholtz, immersed, interpolate, lanes, measure, near_convection, open, ranks, scheme, stencil, step,
    threads, transform, work,
};

mod bounds;
pub mod build;
pub mod checkpoint;
mod coarse_part;
pub mod config;
pub mod coupling;
pub mod facts;
pub mod follow;
mod grain_forces;
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
mod scene_grains;
pub mod solver;
mod speed;
mod stress;
mod totals;
