//! Lubrication between near surfaces: the law of one gap, and the simultaneous solution of many.

pub mod law;
pub mod settings;
pub(crate) mod simultaneous;
mod sliding;
