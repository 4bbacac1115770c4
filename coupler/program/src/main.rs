//! `bedload`: plans, starts, drives and records coupled runs, studies over many, and packings.

mod cli;
mod pack;
mod schema;

fn main() -> std::process::ExitCode {
    cli::main()
}
