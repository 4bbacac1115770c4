//! `bedload-fluid`: the immersed-boundary fluid solver.

fn main() -> std::process::ExitCode {
    protocol::program::main::<fluid_solver::participant::Fluid>()
}
