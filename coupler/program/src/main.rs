//! `bedload`: plans, starts, drives and records coupled runs; studies over many, packings, new scenes.

mod cli;
mod new;
mod pack;
mod schema;

fn main() -> std::process::ExitCode {
    cli::main()
}
