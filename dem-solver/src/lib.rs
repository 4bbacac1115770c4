//! Soft-sphere discrete element method (DEM) with lubrication and virtual mass.
//!
//! The equations are those of Izard, Bonometti & Lacaze (2014): eqs 11–18 for contacts, eq. 19 for
//! lubrication; the virtual mass is that of Schwarz, Kempe & Fröhlich (2015).
//!
//! Start here:
//!
//! - [`DemSpec`], [`Grain`], [`Wall`]: what a run is made of;
//! - [`Dem`]: [`Dem::advance`] moves the grains, [`Dem::save`] and [`Dem::restore`] keep the state;
//! - [`ContactLaw`], [`LinearSpringDashpot`]: how grains touch;
//! - [`Lubrication`], [`LubricationModel`]: the force in a narrow gap;
//! - [`config::Config`], [`participant::DemParticipant`]: `[dem]` of a scene, and the DEM in a run.
//!
//! ```
//! use dem_solver::{ContactLaw, Dem, DemSpec, Grain, LinearSpringDashpot};
//!
//! // two spheres of 1 mm radius meet at 0.1 m/s; a contact lasts 0.1 ms
//! let law = LinearSpringDashpot::new(0.9, 1e-4, 0.3);
//! let mut left = Grain::new([-1.0e-3, 0.0, 0.0], 1e-3, 2500.0);
//! let right = Grain::new([1.0e-3, 0.0, 0.0], 1e-3, 2500.0);
//! left.velocity = [0.1, 0.0, 0.0];
//! let mut dem = Dem::new(&DemSpec::new(vec![left, right], ContactLaw::LinearSpringDashpot(law)))?;
//! let report = dem.advance(2e-4, 100, &[])?; // 100 sub-steps of 2 µs, without a fluid
//! let rebound = dem.grains.velocity[1].x - dem.grains.velocity[0].x;
//! assert_eq!(report.n_sub_done, 100);
//! assert!((rebound / 0.1 - law.restitution).abs() < 1e-3);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! The method stands in [`dem_kernels`], which knows no scene; here are the scene's `[dem]`, the participant
//! of a run, averages and files.
//!
//! SI units or any consistent set. Vectors have three components in the laboratory frame; plane and
//! axisymmetric scenes are masks on free motions ([`Freedom`]). With [`Shape::Disc`]
//! masses, forces and energies are per unit length.
//!
//! Sums run in a fixed order, grain by grain and partner by partner, so a result never depends on
//! when the neighbour list was built, and save/restore/repeat gives identical bits.

mod bounds;
pub mod command;
pub mod config;
mod facts;
mod initial;
pub mod insertion;
pub mod output;
mod outside;
pub mod participant;

pub use dem_kernels::*;
