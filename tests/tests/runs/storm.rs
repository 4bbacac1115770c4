//! A small storm of kills (`cargo run --release -p tests --example storm` does a large one).

use tests::harness::Folder;
use tests::storm::{KINDS, Plan, storm};

#[test]
fn twenty_kills_break_no_promise() {
    rustix::process::set_child_subreaper(Some(rustix::process::getpid())).expect("Linux 3.4");
    let folder = Folder::new("storm");
    // Other tests run beside this one: more time than the storm by itself grants.
    let (kinds, gone) = (KINDS.iter().collect(), 15.0);
    let plan = Plan { kills: 20, seed: 20, kinds, gone, folder: folder.join("runs") };
    let report = storm(&plan, &mut |_| {});
    assert_eq!(report.broken, Vec::<String>::new());
    assert_eq!(report.kills(), 20, "{}", report.table());
}
