//! A solver that dies, hangs or gives up is noticed in time and named.

use std::time::{Duration, Instant};

use protocol::channel::{Event, Rendezvous};
use protocol::message::{Order, State};
use protocol::participant::{ExchangeError, Role};

use super::participants::Fault;
use super::stage::{PATIENCE, Stage, assert_goes};

const AT_MOST: Duration = Duration::from_secs(1);

/// A stage on which `fault` happened in window 5, so that the other solver waits.
fn stuck(fluid: Option<Fault>, dem: Option<Fault>, loads_to_see: usize) -> Stage {
    let mut stage = Stage::open(Rendezvous::new(2).unwrap(), fluid, dem);
    stage.advance(5);
    stage.order(Order::Advance, 5, 0);
    let mut seen = 0;
    while seen < loads_to_see {
        if let Event::Loads(lent) = stage.link.next(PATIENCE, &mut || Ok(())).unwrap() {
            seen += usize::from(lent.header().step == 5);
        }
    }
    stage
}

fn died(error: &ExchangeError) -> Option<&str> {
    match error {
        ExchangeError::PeerDied { peer, step: 5 } => Some(peer),
        _ => None,
    }
}

#[test]
fn dem_killed_while_the_fluid_waits_in_receive() {
    let mut stage = stuck(None, Some(Fault::Hang(5)), 1);
    let start = Instant::now();
    stage.dem.kill();
    let error = stage.first_error(PATIENCE);
    let heard = start.elapsed();
    let (well, words) = stage.fluid.end();
    assert_eq!(died(&error), Some("dem"), "{error}");
    assert!(!well && words.contains("dem died during window 5"), "{words}");
    assert!(heard < AT_MOST && start.elapsed() < AT_MOST, "{heard:?} {:?}", start.elapsed());
    drop(stage.link);
    assert_goes(&stage.rendezvous);
}

#[test]
fn dem_killed_while_the_fluid_waits_in_send() {
    // The queue of a small run holds 16: seen 16 times, the fluid is held up by the DEM's.
    let mut stage = stuck(Some(Fault::Flood(5)), Some(Fault::Hang(5)), 16);
    let start = Instant::now();
    stage.dem.kill();
    let (well, words) = stage.fluid.end();
    assert!(!well && words.contains("dem died during window 5"), "{words}");
    assert!(start.elapsed() < AT_MOST, "{:?}", start.elapsed());
    drop(stage.link);
    assert_goes(&stage.rendezvous);
}

#[test]
fn fluid_killed_while_the_dem_waits() {
    let mut stage = stuck(Some(Fault::Hang(5)), None, 0);
    let start = Instant::now();
    stage.fluid.kill();
    let error = stage.first_error(PATIENCE);
    let (well, words) = stage.dem.end();
    assert_eq!(died(&error), Some("fluid"), "{error}");
    assert!(!well && words.contains("fluid died during window 5"), "{words}");
    assert!(start.elapsed() < AT_MOST, "{:?}", start.elapsed());
    drop(stage.link);
    assert_goes(&stage.rendezvous);
}

#[test]
fn hung_dem_is_named_when_the_deadline_passes() {
    let mut rendezvous = Rendezvous::new(2).unwrap();
    rendezvous.deadline_s = 0.2;
    let mut stage = Stage::open(rendezvous, None, Some(Fault::Hang(1)));
    stage.order(Order::Advance, 0, 0);
    stage.settle().unwrap();
    stage.order(Order::Advance, 1, 0);
    let (well, words) = stage.fluid.end();
    assert!(!well && words.contains("dem did not answer within 0.2 s in window 1"), "{words}");
    // The coupler hears the fluid's last words, and in its own patience names the DEM too.
    let mut told = false;
    let error = loop {
        match stage.link.next(Duration::from_millis(50), &mut || Ok(())) {
            Ok(Event::Status(Role::Fluid, status)) => {
                told = status.state == State::Failed as u64 && status.text().contains("dem did not answer");
            }
            Ok(_) => {}
            Err(error) => break error,
        }
    };
    assert!(told);
    assert!(
        matches!(&error, ExchangeError::Deadline { peer, step: 1, .. } if peer == "dem")
            || matches!(&error, ExchangeError::PeerDied { peer, .. } if peer == "fluid"),
        "{error}"
    );
    stage.dem.kill();
    drop(stage.link);
    assert_goes(&stage.rendezvous);
}

#[test]
fn coupler_names_the_hung_solver() {
    for (fluid, dem, name) in [(Some(Fault::Hang(0)), None, "fluid"), (None, Some(Fault::Hang(0)), "dem")] {
        let mut stage = Stage::open(Rendezvous::new(2).unwrap(), fluid, dem);
        stage.order(Order::Advance, 0, 0);
        let error = stage.first_error(Duration::from_millis(300));
        assert!(
            matches!(&error, ExchangeError::Deadline { peer, step: 0, .. } if peer == name),
            "{error}, expected {name}"
        );
        stage.fluid.kill();
        stage.dem.kill();
        drop(stage.link);
        assert_goes(&stage.rendezvous);
    }
}

#[test]
fn last_words_of_a_failed_solver_are_heard() {
    let mut stage = stuck(None, Some(Fault::GiveUp(5)), 0);
    let (well, words) = stage.dem.end();
    assert!(!well && words.contains("velocity of grain 3 is NaN"), "{words}");
    loop {
        match stage.link.next(PATIENCE, &mut || Ok(())).unwrap() {
            Event::Status(Role::Dem, status) if status.state == State::Failed as u64 => {
                assert_eq!(status.text(), "velocity of grain 3 is NaN");
                assert_eq!(status.step, 5);
                break;
            }
            _ => {}
        }
    }
    let (well, words) = stage.fluid.end();
    assert!(!well && words.contains("dem died"), "{words}");
    drop(stage.link);
    assert_goes(&stage.rendezvous);
}

#[test]
fn stop_reaches_a_solver_that_waits_for_its_peer() {
    let mut stage = stuck(None, Some(Fault::Hang(5)), 1);
    stage.order(Order::Stop, 5, 0);
    let (well, words) = stage.fluid.end();
    assert!(well, "{words}");
    stage.dem.kill();
    drop(stage.link);
    assert_goes(&stage.rendezvous);
}

#[test]
fn stop_reaches_a_solver_whose_messages_nobody_takes() {
    let mut stage = stuck(Some(Fault::Flood(5)), Some(Fault::Hang(5)), 16);
    stage.order(Order::Stop, 5, 0);
    stage.dem.kill();
    let (well, words) = stage.fluid.end();
    assert!(well, "{words}");
    drop(stage.link);
    assert_goes(&stage.rendezvous);
}
