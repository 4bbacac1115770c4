//! The order of messages in a log.

use protocol::log::{Manifest, Sequence, SequenceError};
use protocol::message::{Command, Header, Order};

fn sequence(first_step: u64) -> Sequence {
    let mut manifest = Manifest::new("", "", vec![1.0], 0.1, 1.0);
    manifest.first_step = first_step;
    Sequence::new(&manifest)
}

fn order(order: Order, step: u64, attempt: u64) -> Command {
    Command { order: order as u64, step, attempt, time: step as f64, ..Command::default() }
}

fn window(sequence: &mut Sequence, step: u64, attempt: u64) {
    let kind = if attempt == 0 { Order::Advance } else { Order::Repeat };
    sequence.command(&order(kind, step, attempt)).unwrap();
    let header = Header { step, attempt, ..Header::default() };
    sequence.loads(&header, 1).unwrap();
    sequence.kinematics(&header, 1).unwrap();
}

#[test]
fn windows_and_repeats_in_order_pass() {
    let mut sequence = sequence(5);
    window(&mut sequence, 5, 0);
    window(&mut sequence, 5, 1);
    sequence.command(&order(Order::Accept, 5, 1)).unwrap();
    window(&mut sequence, 6, 0);
    sequence.command(&order(Order::Stop, 7, 0)).unwrap();
    assert_eq!(sequence.clock(), 6_000_000_000);
}

/// The clock counts 2^64 ns; windows go on beyond it.
#[test]
fn windows_beyond_the_end_of_the_clock_pass() {
    let mut sequence = sequence(0);
    for step in 0..4 {
        let command = order(Order::Advance, step, 0);
        sequence.command(&Command { time: 1e10 * step as f64, ..command }).unwrap();
        let header = Header { step, ..Header::default() };
        sequence.loads(&header, 1).unwrap();
        sequence.kinematics(&header, 1).unwrap();
    }
    assert_eq!(sequence.clock(), u64::MAX);
}

#[test]
fn every_kind_of_gap_is_named() {
    let mut s = sequence(0);
    assert!(matches!(s.command(&order(Order::Advance, 1, 0)), Err(SequenceError::Gap { step: 1, .. })));
    assert!(matches!(s.command(&order(Order::Repeat, 0, 0)), Err(SequenceError::Gap { .. })));
    window(&mut s, 0, 0);
    assert!(matches!(s.command(&order(Order::Advance, 2, 0)), Err(SequenceError::Gap { step: 2, .. })));
    assert!(matches!(s.command(&order(Order::Repeat, 0, 2)), Err(SequenceError::Gap { attempt: 2, .. })));
    s.command(&order(Order::Advance, 1, 0)).unwrap();
    let header = Header { step: 1, ..Header::default() };
    assert!(matches!(s.loads(&header, 2), Err(SequenceError::Grains { found: 2, .. })));
    s.loads(&header, 1).unwrap();
    assert!(matches!(s.loads(&header, 1), Err(SequenceError::Stray { .. })));
    assert!(matches!(
        s.command(&order(Order::Advance, 2, 0)),
        Err(SequenceError::Missing { step: 1, what: "kinematics", .. })
    ));
}

#[test]
fn a_solver_alone_is_not_observed_in_every_window() {
    let mut manifest = Manifest::new("", "", vec![1.0], 0.1, 1.0);
    manifest.fluid_command.clear();
    let mut s = Sequence::new(&manifest);
    s.command(&order(Order::Advance, 0, 0)).unwrap();
    assert!(s.is_complete());
    s.command(&order(Order::Advance, 1, 0)).unwrap();
    let header = Header { step: 1, ..Header::default() };
    s.kinematics(&header, 1).unwrap();
    assert!(matches!(s.kinematics(&header, 1), Err(SequenceError::Stray { .. })));
}

#[test]
fn time_must_not_run_backwards() {
    let mut s = sequence(0);
    window(&mut s, 0, 0);
    let mut back = order(Order::Advance, 1, 0);
    back.time = f64::NAN;
    assert!(matches!(s.command(&back), Err(SequenceError::Time { .. })));
    window(&mut s, 1, 0);
    back = order(Order::Advance, 2, 0);
    back.time = 0.5;
    assert!(matches!(s.command(&back), Err(SequenceError::Time { step: 2, .. })));
}
