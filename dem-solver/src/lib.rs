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
pub mod cells;
pub mod coarse_grain;
pub mod coarse_grain_command;
pub mod config;
pub mod contact;
pub mod contacts;
pub mod diagnostics;
pub mod energy;
pub mod error;
pub mod films;
mod finish;
pub mod grains;
pub mod hertz_mindlin;
mod initial;
pub mod integrate;
pub mod interact;
pub mod janssen;
pub mod linear;
pub mod lubrication;
pub mod neighbours;
pub mod output;
mod outside;
pub mod participant;
pub mod partition;
pub mod pour;
pub mod profile;
pub mod report;
pub mod rk3;
pub mod rolling;
pub mod spec;
pub mod state;
pub mod step;
pub mod tangential;
pub mod walls;
pub mod wan_turek;

pub use contact::{ContactLaw, LinearSpringDashpot};
pub use energy::Dissipated;
pub use error::{AdvanceError, RestoreError, SpecError};
pub use integrate::Integrator;
pub use lubrication::Lubrication;
pub use report::{GrainLoad, WindowReport};
pub use spec::{DemSpec, Engine, Freedom, Grain, Motion, Shape};
pub use state::State;
pub use step::Dem;
pub use walls::Wall;

/// Three components in the laboratory frame.
pub type Vec3 = nalgebra::Vector3<f64>;
