//! Laws of contact: one model is one file; [`table`] holds the law of each pair of materials.

pub mod coefficients;
pub mod hertz_mindlin;
pub mod linear;
pub mod rolling;
pub mod table;
pub mod tangential;
pub mod walls;
pub mod wan_turek;
