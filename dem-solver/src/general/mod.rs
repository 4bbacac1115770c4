//! The general engine: all laws, lubrication and integrators.

pub mod energy;
pub mod forces;
pub mod integrate;
pub mod lists;
pub mod rk3;
