//! `bedload-dem`: the soft-sphere DEM solver.

fn main() -> std::process::ExitCode {
    dem_solver::command::main()
}
