//! Laws of contact between two surfaces; each model is a file of its own.
//!
//! | law | file |
//! |---|---|
//! | linear spring and dashpot (Cundall & Strack 1979; Izard et al. 2014) | [`crate::laws::linear`] |
//! | repulsion of Wan & Turek (2007) | [`crate::laws::wan_turek`] |
//! | resistance to rolling, part of the first (Ai et al. 2011) | [`crate::laws::rolling`] |

pub mod coefficients;
pub mod linear;
pub mod rolling;
pub mod table;
pub mod tangential;
pub mod walls;
pub mod wan_turek;
