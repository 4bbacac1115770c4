//! `bedload-fluid`: the immersed-boundary fluid solver, one process or, over MPI, one of several.

#[cfg(feature = "mpi")]
mod mpi;

use fluid_solver::program;
use std::process::ExitCode;

#[cfg(feature = "mpi")]
fn main() -> ExitCode {
    match mpi::start() {
        Ok(None) => program::main(None),
        Ok(Some((_universe, ranks))) => program::main(Some(ranks)),
        Err(what) => program::failed(&what),
    }
}

/// Without MPI a process is alone; several of them would write into the same folder.
#[cfg(not(feature = "mpi"))]
fn main() -> ExitCode {
    match fluid_solver::ranks::launched() {
        Some(size @ 2..) => program::failed(&format!(
            "was started as one of {size} ranks, but built without MPI: build it with `cargo build --release -p \
             bedload-fluid --features mpi`"
        )),
        _ => program::main(None),
    }
}
