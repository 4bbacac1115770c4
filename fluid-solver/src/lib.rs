//! Incompressible Navier–Stokes solver on a staggered grid, for immersed grains.

#![warn(missing_docs)]

pub mod advect;
pub mod axis;
pub mod boundary;
pub mod comm;
pub mod diffuse;
pub mod field;
pub mod grid;
pub mod helmholtz;
pub mod lanes;
pub mod measure;
pub mod project;
pub mod scheme;
pub mod stencil;
pub mod step;
pub mod threads;
pub mod timings;
pub mod transform;
pub mod tridiagonal;
