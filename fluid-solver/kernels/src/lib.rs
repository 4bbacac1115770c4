//! Incompressible Navier–Stokes solver on a staggered grid, for immersed grains.
//!
//! Start from:
//! - [`step::Stepper`]: one time step of the fluid alone, on a [`grid::Grid`];
//! - [`boundary::Boundary`] and [`axis::AxisSpec`]: what a grid is made of;
//! - [`scheme::Options`]: viscosity, time scheme, driving force;
//! - [`immersed::Immersed`]: grains on the grid, their masks and the force that imposes their motion.
//!
//! The equations stand in `docs/equations.md` and `docs/equations-immersed.md`, the order of a step in
//! [`step`].
//!
//! A channel driven by a body force `f` ends in Poiseuille flow, `u = f h²/(8 ν)` in the middle:
//! ```
//! use fluid_kernels::axis::AxisSpec;
//! use fluid_kernels::boundary::Boundary;
//! use fluid_kernels::grid::{Geometry, Grid, GridSpec};
//! use fluid_kernels::scheme::{Options, Scheme, Viscous};
//! use fluid_kernels::step::Stepper;
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
//! # Ok::<(), fluid_kernels::grid::GridError>(())
//! ```

#![warn(missing_docs)]

pub mod axis;
pub mod boundary;
pub mod division;
pub mod drive;
mod engine;
pub mod engines;
mod factors;
pub mod field;
pub mod first_non_finite;
mod flow;
pub mod flow_rate;
mod ghosts;
pub mod grid;
pub mod halo;
pub mod health;
pub mod helmholtz;
pub mod immersed;
pub mod interpolate;
pub mod lanes;
pub mod measure;
pub mod near_convection;
pub mod open;
mod plane;
pub mod ranks;
pub mod scheme;
mod space;
mod stages;
pub mod stencil;
pub mod step;
pub mod threads;
pub mod transform;
mod tridiagonal;
mod vector;
pub mod work;
