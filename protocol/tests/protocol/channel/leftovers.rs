//! Whoever is killed, the last survivor leaves nothing behind; where nobody survives, the next
//! coupler does.

use std::fs::File;
use std::time::Duration;

use protocol::channel::{CouplerLink, Event, Rendezvous, remove_stale_runs};
use protocol::message::Order;

use super::stage::{PATIENCE, Participant, Stage, assert_goes, assert_gone, command, segments};

/// A coupler as a process of its own: starts both toys and conducts windows for ever.
pub(crate) fn conduct_until_killed() {
    let rendezvous = Rendezvous::from_environment().unwrap().expect("a token");
    let mut link = CouplerLink::create(&rendezvous).unwrap();
    let _toys =
        [Participant::start(&rendezvous, "fluid", None), Participant::start(&rendezvous, "dem", None)];
    link.wait_ready(&mut || Ok(())).unwrap();
    std::fs::write(started(&rendezvous), "").unwrap();
    for step in 0.. {
        link.order(command(Order::Advance, step, 0)).unwrap();
        while link.unanswered() > 0 {
            let event = link.next(PATIENCE, &mut || Ok(())).unwrap();
            if let Event::Status(_, status) = event {
                assert_eq!(status.step, step);
            }
        }
        std::thread::sleep(Duration::from_millis(1));
    }
}

/// Stands in the run's folder as soon as the coupler's first window is ordered.
fn started(rendezvous: &Rendezvous) -> std::path::PathBuf {
    rendezvous.root.join("started")
}

fn start_coupler(rendezvous: &Rendezvous) -> Participant {
    let coupler = Participant::start(rendezvous, "coupler", None);
    let start = std::time::Instant::now();
    while !started(rendezvous).exists() {
        assert!(start.elapsed() < PATIENCE, "the coupler does not start");
        std::thread::sleep(Duration::from_millis(1));
    }
    coupler
}

/// Processes that have this run's token in their environment.
fn kill_everyone(rendezvous: &Rendezvous) {
    for entry in std::fs::read_dir("/proc").unwrap().flatten() {
        let environment = std::fs::read(entry.path().join("environ")).unwrap_or_default();
        let mark = rendezvous.prefix.as_bytes();
        let ours = environment.windows(mark.len()).any(|bytes| bytes == mark);
        let name = entry.file_name().into_string().unwrap_or_default();
        if ours && name.parse::<u32>().is_ok_and(|process| process != std::process::id()) {
            std::process::Command::new("kill").args(["-9", &name]).status().unwrap();
        }
    }
}

#[test]
fn solvers_clean_up_after_a_killed_coupler() {
    let rendezvous = Rendezvous::new(50).unwrap();
    let mut coupler = start_coupler(&rendezvous);
    assert!(!segments(&rendezvous).is_empty());
    coupler.kill();
    assert_goes(&rendezvous);
}

#[test]
fn coupler_cleans_up_after_both_solvers_were_killed() {
    let mut stage = Stage::open(Rendezvous::new(50).unwrap(), None, None);
    stage.advance(3);
    stage.fluid.kill();
    stage.dem.kill();
    assert!(!segments(&stage.rendezvous).is_empty());
    drop(stage.link);
    assert_gone(&stage.rendezvous);
}

#[test]
fn stale_run_is_removed_and_living_ones_are_not() {
    let dead = Rendezvous::new(50).unwrap();
    let mut coupler = start_coupler(&dead);
    // Held by us, the run counts as living, whatever other couplers on this machine clean up.
    let hold = File::open(dead.root.join("run.lock")).unwrap();
    hold.lock_shared().unwrap();
    // All at once, so that no survivor cleans up.
    kill_everyone(&dead);
    coupler.kill();
    let living = Stage::open(Rendezvous::new(5).unwrap(), None, None);
    remove_stale_runs().unwrap();
    assert!(dead.root.exists() && !segments(&dead).is_empty());

    drop(hold);
    remove_stale_runs().unwrap();
    assert_gone(&dead);

    let mut living = living;
    living.advance(3);
    remove_stale_runs().unwrap();
    assert!(living.rendezvous.root.exists() && !segments(&living.rendezvous).is_empty());
    living.advance(0);
    living.order(Order::Advance, 3, 0);
    living.settle().unwrap();
    living.close(4);
}
