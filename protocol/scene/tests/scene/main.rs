//! The scene from outside: its text, the grains laid out, what follows from it before a run.

mod files;
mod grain_table;
mod observe;
mod over_time;
mod retired;
mod source;
mod speeds;
mod whole;
