//! Search of near pairs.

pub mod cells;
