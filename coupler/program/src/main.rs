//! `bedload`: plans, starts, drives and records coupled runs, studies over many, packings, scenes to start from.

mod cli;
mod new;
mod pack;
mod schema;

fn main() -> std::process::ExitCode {
    cli::main()
}
