//! Options of a run, and solvers driven by their logs.

mod options;
mod replaying;
#[allow(dead_code)] // the tests of the log use the rest
#[path = "../../../tests/protocol/log/support.rs"]
mod support;
