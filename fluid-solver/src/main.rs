//! `bedload-fluid`: the immersed-boundary fluid solver.

fn main() -> std::process::ExitCode {
    bedload_program::main::<fluid_solver::participant::Fluid>()
}
