//! Soft-sphere discrete element method (DEM) with lubrication and virtual mass.
//!
//! The equations are those of Izard, Bonometti & Lacaze (2014), "the seed": eqs 11–18 for contacts,
//! eq. 19 for lubrication; the virtual mass is that of Schwarz, Kempe & Fröhlich (2015).
//!
//! Start from [`DemSpec`] and [`Dem`]: the one is the data of a run, the other moves the grains window by window.
//! One room is one subject, and a file imports only from files below it:
//!
//! | room | what it holds |
//! |---|---|
//! | [`motion`], [`grain`], [`periods`], [`error`], [`report`], [`grains`] | vectors, grains, periodic directions, errors, loads and reports |
//! | [`laws`] | contact: linear, Hertz–Mindlin, tangential, rolling, Wan–Turek, walls; the table of all pairs of materials |
//! | [`search`] | cells, near pairs, half lists with contact history |
//! | [`lubrication`] | the law of one gap (eq. 19), and the simultaneous solution of many |
//! | [`spec`], [`state`], [`surroundings`] | data of a run, of a checkpoint, and what does not change |
//! | [`general`] | the engine for all laws, lubrication and integrators: one sub-step from top to bottom |
//! | [`bulk`] | the engine for many grains in linear contact |
//! | [`solver`] | [`Dem`]: the grains with the engine that moves them; `advance`, `save`, `validate` beside it |
//! | [`output`] | contacts, sums, averages (Goldhirsch 2010), profiles, Janssen's curve, files |
//! | [`config`], [`participant`], [`command`] | the scene's `[dem]`, the participant of a run, `bedload-dem coarse-grain` |
//!
//! SI units or any consistent set. Vectors have three components in the laboratory frame; plane and
//! axisymmetric scenes are masks on free motions ([`Freedom`]). With [`Shape::Disc`]
//! masses, forces and energies are per unit length.
//!
//! Sums run in a fixed order, grain by grain and partner by partner, so a result never depends on
//! when the neighbour list was built, and save/restore/repeat gives identical bits.

mod advance;
mod bounds;
pub mod bulk;
pub mod command;
pub mod config;
pub mod error;
mod facts;
pub mod general;
pub mod grain;
pub mod grains;
mod initial;
pub mod insertion;
pub mod laws;
pub mod lubrication;
pub mod motion;
pub mod output;
mod outside;
pub mod participant;
pub mod periods;
pub mod report;
mod save;
pub mod search;
pub mod solver;
pub mod spec;
pub mod state;
pub mod surroundings;
mod validate;

pub use error::{AdvanceError, RestoreError, SpecError};
pub use grain::{Grain, Shape};
pub use laws::linear::LinearSpringDashpot;
pub use laws::table::ContactLaw;
pub use laws::walls::Wall;
pub use lubrication::settings::Lubrication;
pub use motion::{Freedom, Motion, Vec3};
pub use report::{Dissipated, GrainLoad, WindowReport};
pub use solver::Dem;
pub use spec::{BulkSettings, DemSpec, Engine, Integrator};
pub use state::State;
