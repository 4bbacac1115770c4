//! Soft-sphere discrete element method (DEM) with lubrication and virtual mass.
//!
//! The equations are those of Izard, Bonometti & Lacaze (2014), "the seed": eqs 11–18 for contacts,
//! eq. 19 for the film between grains; the virtual mass is that of Schwarz, Kempe & Fröhlich (2015).
//! One model is one file:
//!
//! | file | what it holds |
//! |---|---|
//! | [`contact`] | the laws by name, and the table of all pairs of materials |
//! | [`linear`] | linear normal law, eqs 15, 17, 18, and the form that gives the asked restitution back |
//! | [`hertz_mindlin`] | Hertz–Mindlin law with damping by restitution |
//! | [`rolling`] | resistance to rolling |
//! | [`tangential`] | eq. 16: spring history, sliding, dashpot |
//! | [`wan_turek`] | the short-range repulsion of Wan & Turek (2007) |
//! | [`lubrication`] | eq. 19 for one film, explicit and implicit |
//! | [`films`] | many films at once, momentum conserving |
//! | [`walls`] | planes |
//! | [`neighbours`], [`cells`] | half list with contact history, cell search |
//! | [`interact`] | loops over contacts: forces and torques on all grains |
//! | [`integrate`] | kick, drift, rotation |
//! | [`bulk`] | the engine for many grains in linear contact |
//! | [`step`](mod@step) | the sub-step, readable from top to bottom |
//! | [`state`] | everything that decides the next step: save, restore, repeat |
//! | [`energy`] | account of the energy that contacts take |
//! | [`pour`] | grains that are poured in while the run goes |
//! | [`contacts`] | every contact with its force, for the mathematics of averages |
//! | [`coarse_grain`], [`partition`] | solid fraction, velocity, stress on slabs or a grid (Goldhirsch 2010) |
//! | [`profile`], [`janssen`] | profile over slabs as a table; Janssen's curve in a silo |
//! | [`output`] | grains for ParaView and as a table |
//!
//! SI units or any consistent set. Vectors have three components in the laboratory frame; plane and
//! axisymmetric scenes are masks on free motions ([`spec::Freedom`]). With [`spec::Shape::Disc`]
//! masses, forces and energies are per unit length.
//!
//! Sums run in a fixed order, grain by grain and partner by partner, so a result never depends on
//! when the neighbour list was built, and save/restore/repeat gives identical bits.

pub mod bulk;
pub mod config;
pub mod error;
pub mod general;
pub mod grains;
mod initial;
pub mod laws;
pub mod lubrication;
pub mod output;
mod outside;
pub mod participant;
pub mod pour;
pub mod report;
pub mod search;
pub mod solver;
pub mod spec;
pub mod state;

pub use error::{AdvanceError, RestoreError, SpecError};
pub use general::energy::Dissipated;
pub use general::integrate::Integrator;
pub use laws::linear::LinearSpringDashpot;
pub use laws::table::ContactLaw;
pub use laws::walls::Wall;
pub use lubrication::gap::Lubrication;
pub use report::{GrainLoad, WindowReport};
pub use solver::Dem;
pub use spec::{DemSpec, Engine, Freedom, Grain, Motion, Shape};
pub use state::State;

/// Three components in the laboratory frame.
pub type Vec3 = nalgebra::Vector3<f64>;
