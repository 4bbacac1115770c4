//! Studies: their runs, and how a run is classified.

mod classify;
mod sweep;
