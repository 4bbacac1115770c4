//! Several numbers at once, in registers where the machine has them: what the vector kernels of contacts and
//! of films are written in.

#[cfg(target_arch = "x86_64")]
mod avx512;
pub(crate) mod images;
pub(crate) mod kernel;
pub(crate) mod lane_pair;
pub(crate) mod lanes;
pub(crate) mod logarithm;
pub(crate) mod rows;
pub(crate) mod vec3;
