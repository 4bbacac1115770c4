//! `bedload`: plans, starts, conducts and records coupled runs.

fn main() -> std::process::ExitCode {
    coupler::cli::main()
}
