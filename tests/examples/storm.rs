//! A storm of kills: see `tests::storm`.
//!
//! ```text
//! cargo build --release
//! cargo run --release -p tests --example storm -- --kills 1000 --seed 1 [--kind dry]
//! ```
//!
//! Exit code 1: a promise is broken. The seed decides what is drawn; when a process is hit within its work
//! depends on the machine, too.

use std::process::ExitCode;

use tests::storm::{KINDS, Kind, Plan, storm};

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let value = |name: &str, default: &str| {
        let place = arguments.iter().position(|argument| argument == name);
        place.and_then(|place| arguments.get(place + 1)).map_or(default, String::as_str).to_owned()
    };
    let number = |name: &str, default: &str| value(name, default).parse::<u64>();
    let (Ok(kills), Ok(seed)) = (number("--kills", "1000"), number("--seed", "1")) else {
        eprintln!("--kills N and --seed N take whole numbers");
        return ExitCode::from(2);
    };
    let kind = value("--kind", "");
    let kinds: Vec<&'static Kind> = KINDS.iter().filter(|known| known.name.contains(&kind)).collect();
    if kinds.is_empty() {
        eprintln!("--kind: one of {}", KINDS.map(|kind| kind.name).join(", "));
        return ExitCode::from(2);
    }
    let folder = std::env::temp_dir().join(format!("bedload-storm-{seed}-{}", std::process::id()));
    rustix::process::set_child_subreaper(Some(rustix::process::getpid())).expect("Linux 3.4");
    println!("{kills} kills, seed {seed}, in {}", folder.display());
    let plan = Plan { kills: kills as usize, seed, kinds, gone: 2.0, folder: folder.clone() };
    let mut told = 0;
    let report = storm(&plan, &mut |report| {
        for broken in &report.broken[told..] {
            println!("BROKEN: {broken}");
        }
        told = report.broken.len();
    });
    println!("{}", report.table());
    println!("{} kills came too late and were drawn again", report.late);
    if report.broken.is_empty() {
        let _ = std::fs::remove_dir_all(&folder);
        return ExitCode::SUCCESS;
    }
    println!("{} broken promises; the runs lie in {}", report.broken.len(), folder.display());
    ExitCode::from(1)
}
