//! Immersed grains, loads, restart and output, against exact and published results.
//!
//! The DEM is replaced by [`newton::Newton`]: Newton's second law for each grain, with the virtual
//! mass of the message, and nothing else.

mod arrays;
mod balance;
mod bodies;
mod bounds;
mod config;
mod dense;
mod discs;
mod drift;
mod fictitious;
mod handover;
mod kept;
mod many;
mod newton;
mod output;
mod planes;
mod pores;
mod ranks;
mod restart;
mod schemes;
mod settling;
mod touch;
mod wall;
