//! The program as a user has it, and the plans that it makes: one executable, which is also the solvers of
//! its runs (`fake_solvers`).

mod cli;
mod conformance;
mod fake_solvers;
mod faults;
mod limit;
mod log_command;
mod pack;
mod plan;
mod report;
mod speeds;
mod study;
mod substeps;

/// No test of its own: the part of a solver when this executable is started as one.
#[test]
fn fake_solver() {
    fake_solvers::play();
}
