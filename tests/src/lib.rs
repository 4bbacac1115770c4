//! What tests that cross crates share.

pub mod harness;
pub mod random;
pub mod storm;
