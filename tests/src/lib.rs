//! What tests that cross crates share.

pub mod drawn;
pub mod harness;
pub mod random;
pub mod storm;
