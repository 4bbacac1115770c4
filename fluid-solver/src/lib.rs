//! Incompressible Navier–Stokes solver on a staggered grid, for immersed grains.

#![warn(missing_docs)]

pub mod axis;
pub mod boundary;
pub mod field;
pub mod grid;
