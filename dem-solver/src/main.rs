//! `bedload-dem`: the soft-sphere DEM solver.

fn main() -> std::process::ExitCode {
    // The one command that is about grains alone; all others are those of every solver.
    if std::env::args().nth(1).as_deref() == Some("coarse-grain") {
        return dem_solver::command::main();
    }
    bedload_program::main::<dem_solver::participant::DemParticipant>()
}
