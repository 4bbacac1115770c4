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
//!
//! ```
//! use dem_kernels::{ContactLaw, Dem, DemSpec, Grain, LinearSpringDashpot};
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
//! A file imports only from files below it:
//!
//! | module | contents |
//! |---|---|
//! | [`motion`], [`grain`], [`grains`], [`periods`] | vectors, grains, periodic directions |
//! | [`error`], [`report`] | errors, loads and reports |
//! | [`laws`] | contact: linear, tangential, rolling, Wan–Turek, walls |
//! | `search` | cells, near pairs, half lists with contact history |
//! | `bodies` | bodies of the plane that are not round: how they stand, where they touch |
//! | `vector` | several numbers at once, in registers where there are any |
//! | [`lubrication`] | the law of one gap (eq. 19), and the simultaneous solution of many |
//! | [`spec`], [`state`], `surroundings` | data of a run, of a checkpoint, and what does not change |
//! | `general` | the engine for all laws, lubrication and integrators: one sub-step from top to bottom |
//! | `bulk` | the engine for many grains in linear contact |
//! | [`solver`] | [`Dem`]: the grains with the engine that moves them; `advance`, `save`, `validate` beside it |
//! | [`contacts`], [`sums`], [`split`] | every contact with its force; energy; forces by sub-step |
//!
//! SI units or any consistent set. Vectors have three components in the laboratory frame; plane and
//! axisymmetric scenes are masks on free motions ([`Freedom`]). With [`Shape::Disc`]
//! masses, forces and energies are per unit length.
//!
//! Sums run in a fixed order, grain by grain and partner by partner, so a result never depends on
//! when the neighbour list was built, and save/restore/repeat gives identical bits.

mod advance;
mod bodies;
mod bulk;
pub mod contacts;
pub mod error;
mod general;
pub mod grain;
pub mod grains;
pub mod laws;
pub mod lubrication;
pub mod motion;
pub mod periods;
pub mod report;
mod save;
mod search;
pub mod solver;
pub mod spec;
pub mod split;
pub mod state;
pub mod sums;
mod surroundings;
mod validate;
mod vector;

pub use bedload_over_time::{OverTime, Sine};
pub use bulk::requirements::takes as takes_bulk;
pub use error::{AdvanceError, RestoreError, SpecError};
pub use grain::{Grain, Shape};
pub use laws::linear::LinearSpringDashpot;
pub use laws::table::ContactLaw;
pub use laws::walls::{Servo, Wall};
pub use lubrication::law::{LineResolution, LubricationModel};
pub use lubrication::settings::Lubrication;
pub use motion::{Freedom, Motion, Vec3};
pub use report::{Dissipated, GrainLoad, WindowReport};
pub use solver::Dem;
pub use spec::{BulkSettings, DemSpec, Engine, Integrator};
pub use state::State;
