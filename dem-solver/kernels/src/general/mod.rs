//! The general engine: all laws, lubrication and integrators.

pub(crate) mod bodies;
mod body_point;
pub(crate) mod contact;
pub(crate) mod energy;
pub(crate) mod engine;
pub(crate) mod evaluation;
pub(crate) mod forces;
mod integrate;
pub(crate) mod pair_lanes;
mod pair_law;
mod rk3;
pub(crate) mod sums;
mod window_drag;
