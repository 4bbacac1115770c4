//! `bedload-dem`: the soft-sphere DEM solver.

fn main() -> std::process::ExitCode {
    protocol::program::main::<dem_solver::participant::DemParticipant>()
}
