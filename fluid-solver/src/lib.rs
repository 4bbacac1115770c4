//! Incompressible Navier–Stokes solver on a staggered grid, for immersed grains.

#![warn(missing_docs)]

pub mod attempts;
pub mod axis;
pub mod boundary;
mod bounds;
pub mod build;
pub mod checkpoint;
pub mod config;
pub mod coupling;
pub mod culprit;
mod engine;
pub mod facts;
pub mod field;
mod flow;
pub mod flow_rate;
pub mod geometry;
pub mod grid;
pub mod grid_error;
pub mod halo;
pub mod health;
pub mod helmholtz;
pub mod immersed;
pub mod lanes;
pub mod lines;
pub mod loads;
pub mod measure;
pub mod memory;
pub mod open;
pub mod output;
pub mod participant;
pub mod plan;
mod plane;
pub mod planes;
pub mod program;
pub mod scheme;
pub mod solver;
mod space;
mod speed;
mod stages;
pub mod stencil;
pub mod step;
pub mod threads;
pub mod timings;
pub mod transform;
pub mod tridiagonal;
pub mod work;
