//! Studies: cases, sweeps, tables, and how a run is classified.

mod case;
mod classify;
mod sweep;
mod table;
