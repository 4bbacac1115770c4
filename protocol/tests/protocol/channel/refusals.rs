//! What does not fit is refused with both values named, before anything is exchanged.

use std::time::{Duration, Instant};

use protocol::channel::{CouplerLink, Rendezvous, Wire};
use protocol::message::{Kinematics, Loads, State, Status};
use protocol::participant::{ExchangeError, Role};

use super::stage::{PATIENCE, assert_gone};

type Dem = Loads;

/// A run in which only the DEM takes part.
fn dem_alone() -> Rendezvous {
    let mut rendezvous = Rendezvous::new(4).unwrap();
    rendezvous.roles = vec![Role::Dem];
    rendezvous
}

fn mismatch(error: &ExchangeError) -> Option<(&str, &str, &str)> {
    match error {
        ExchangeError::Mismatch { what, theirs, ours, .. } => Some((what, theirs, ours)),
        _ => None,
    }
}

#[test]
fn other_layout_on_the_services_is_refused() {
    let there = dem_alone();
    let link = CouplerLink::create(&there).unwrap();
    let mut here = there.clone();
    here.layout = "00000000deadbeef".into();
    let error = Dem::join(&here, Role::Dem, 4).unwrap_err();
    assert_eq!(
        mismatch(&error),
        Some(("bedload.layout", there.layout.as_str(), "00000000deadbeef")),
        "{error}"
    );
    here.layout.clone_from(&there.layout);
    here.protocol = 99;
    let error = Dem::join(&here, Role::Dem, 4).unwrap_err();
    assert_eq!(mismatch(&error), Some(("bedload.protocol", "1", "99")), "{error}");
    drop(link);
    assert_gone(&there);
}

#[test]
fn other_number_of_grains_is_refused_by_the_solver() {
    let there = dem_alone();
    let link = CouplerLink::create(&there).unwrap();
    let error = Dem::join(&there, Role::Dem, 5).unwrap_err();
    assert_eq!(mismatch(&error), Some(("number of grains", "4", "5")), "{error}");
    let mut here = there.clone();
    here.grains = 5;
    let error = Dem::join(&here, Role::Dem, 5).unwrap_err();
    assert_eq!(mismatch(&error), Some(("bedload.grains", "4", "5")), "{error}");
    drop(link);
    assert_gone(&there);
}

#[test]
fn foreign_solver_of_another_build_or_scene_is_refused_by_the_coupler() {
    for (text, grains, expected) in
        [("bedload 1 00000000deadbeef".to_owned(), 4, "00000000deadbeef"), (Rendezvous::greeting(), 7, "7")]
    {
        let rendezvous = dem_alone();
        let mut link = CouplerLink::create(&rendezvous).unwrap();
        let mut dem = Dem::join(&rendezvous, Role::Dem, 4).unwrap();
        let mut ready = Status { state: State::Ready as u64, grains, ..Status::default() };
        ready.set_text(&text);
        dem.report(ready).unwrap();
        let error = link.wait_ready(&mut || Ok(())).unwrap_err();
        let (_, theirs, _) = mismatch(&error).unwrap();
        assert!(theirs.contains(expected), "{error}");
        drop((dem, link));
        assert_gone(&rendezvous);
    }
}

#[test]
fn role_is_played_once_and_only_if_it_takes_part() {
    let rendezvous = dem_alone();
    let link = CouplerLink::create(&rendezvous).unwrap();
    let dem = Dem::join(&rendezvous, Role::Dem, 4).unwrap();
    let second = Dem::join(&rendezvous, Role::Dem, 4).unwrap_err().to_string();
    assert!(second.contains("another process joined in this role"), "{second}");
    let fluid = Kinematics::join(&rendezvous, Role::Fluid, 4);
    let fluid = fluid.unwrap_err().to_string();
    assert!(fluid.contains("has no fluid"), "{fluid}");
    drop((dem, link));
    assert_gone(&rendezvous);
    let late = Dem::join(&rendezvous, Role::Dem, 4).unwrap_err().to_string();
    assert!(late.contains("is over"), "{late}");
}

#[test]
fn solver_that_never_joins_is_named() {
    let mut rendezvous = Rendezvous::new(4).unwrap();
    rendezvous.join_s = 0.1;
    let mut link = CouplerLink::create(&rendezvous).unwrap();
    // The DEM joins and waits for a fluid that nobody started.
    let error = Dem::join(&rendezvous, Role::Dem, 4).unwrap_err();
    assert!(matches!(&error, ExchangeError::Deadline { peer, .. } if peer == "fluid"), "{error}");
    let error = link.wait_ready(&mut || Ok(())).unwrap_err();
    assert!(matches!(&error, ExchangeError::NotJoined { peer, .. } if peer == "fluid"), "{error}");
}

#[test]
fn supervisor_ends_the_wait_for_a_child_that_broke_down() {
    let mut link = CouplerLink::create(&Rendezvous::new(4).unwrap()).unwrap();
    let start = Instant::now();
    let error = link
        .wait_ready(&mut || Err(ExchangeError::PeerDied { peer: "fluid (exit code 2)".into(), step: 0 }))
        .unwrap_err();
    assert!(error.to_string().contains("exit code 2"), "{error}");
    assert!(start.elapsed() < Duration::from_secs(1) && start.elapsed() < PATIENCE);
}
