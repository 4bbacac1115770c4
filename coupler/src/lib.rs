//! The coupler behind `bedload`: it plans, starts the solvers, is their master of time, watches,
//! records. It never stands in the path of the data.

pub mod bounds;
pub mod config;
pub mod plan;
pub mod scheme;
pub mod solvers;
pub mod supervise;
