//! `bedload`: plans, starts, drives and records coupled runs, and studies over many.

mod cli;
mod schema;

fn main() -> std::process::ExitCode {
    cli::main()
}
