//! What is sent arrives, in order, in all three processes.

use protocol::channel::{Event, Rendezvous};
use protocol::message::{Order, State};
use protocol::participant::Role;
use protocol::serve::checkpoint_folder;

use super::participants::force;
use super::stage::{PATIENCE, Stage, command, out_dir};

/// Conducts `windows` windows with up to `ahead` ordered at once and checks every event.
fn conduct(grains: usize, windows: u64, ahead: usize) {
    let mut rendezvous = Rendezvous::new(grains).unwrap();
    rendezvous.ahead = ahead;
    let mut stage = Stage::open(rendezvous, None, None);
    let (mut given, mut loads, mut kinematics, mut done) = (0, 0, 0, [0; 2]);
    while done[0].min(done[1]) < windows {
        while given < windows && stage.link.unanswered() < ahead as u64 {
            stage.order(Order::Advance, given, 0);
            given += 1;
        }
        match stage.link.next(PATIENCE, &mut || Ok(())).unwrap() {
            Event::Loads(lent) => {
                assert_eq!(lent.header().step, loads);
                assert_eq!(loads, kinematics, "loads before the last kinematics");
                assert_eq!(lent.records().len(), grains);
                for (index, load) in lent.records().iter().enumerate() {
                    assert_eq!(load.force, force(loads, 0, index));
                }
                loads += 1;
            }
            Event::Kinematics(lent) => {
                assert_eq!(lent.header().step, kinematics);
                assert_eq!(loads, kinematics + 1, "kinematics before their loads");
                assert_eq!(lent.header().substeps, 20);
                assert_eq!(lent.records().len(), grains);
                for (index, grain) in lent.records().iter().enumerate() {
                    assert_eq!(grain.velocity, force(kinematics, 0, index));
                    assert_eq!(grain.position, [0.5 * (kinematics + 1) as f64; 3]);
                }
                kinematics += 1;
            }
            Event::Status(role, status) => {
                let step = &mut done[usize::from(role == Role::Dem)];
                assert_eq!((status.state, status.step), (State::Done as u64, *step));
                assert!(*step < kinematics, "{role} reported before its data");
                *step += 1;
                let substeps = if role == Role::Dem { 20 * *step } else { 0 };
                assert_eq!(status.substeps, substeps);
                assert_eq!(status.dt_limit, 0.25);
                assert!(status.peak_rss > 0 && status.exchange_s > 0.0);
            }
        }
    }
    assert_eq!((loads, kinematics, done), (windows, windows, [windows; 2]));
    stage.close(windows);
}

#[test]
fn thousand_windows_one_by_one() {
    conduct(200, 1000, 1);
}

#[test]
fn thousand_windows_ordered_ahead() {
    conduct(200, 1000, 6);
}

#[test]
fn one_grain_none_and_many() {
    conduct(1, 20, 4);
    conduct(0, 20, 4);
    conduct(20_000, 20, 4);
}

#[test]
fn two_runs_at_once_do_not_disturb_each_other() {
    std::thread::scope(|scope| {
        scope.spawn(|| conduct(30, 300, 4));
        scope.spawn(|| conduct(40, 300, 4));
    });
}

#[test]
fn repeated_window_starts_from_the_saved_state() {
    let mut rendezvous = Rendezvous::new(3).unwrap();
    rendezvous.repeatable = true;
    let mut stage = Stage::open(rendezvous, None, None);
    for step in 0..3 {
        stage.order(Order::Advance, step, 0);
        stage.settle().unwrap();
        for attempt in 1..4 {
            stage.order(Order::Repeat, step, attempt);
            for (role, status) in stage.settle().unwrap() {
                let (answer, clock) = ((status.step, status.attempt), status.residual);
                assert_eq!(status.state, State::Done as u64, "{role}: {}", status.text());
                assert_eq!(answer, (step, attempt));
                assert_eq!(clock, 0.5 * (step + 1) as f64, "{role} went on instead of back");
            }
        }
        stage.order(Order::Accept, step, 3);
    }
    stage.order(Order::Checkpoint, 3, 0);
    let saved = stage.settle().unwrap();
    assert_eq!(saved.len(), 2);
    for (role, status) in saved {
        assert_eq!(status.state, State::Saved as u64);
        let folder = checkpoint_folder(&out_dir(&stage.rendezvous), 3);
        let text = std::fs::read_to_string(folder.join(role.to_string())).unwrap();
        assert_eq!(text, "1.5");
    }
    stage.close(3);
}

#[test]
fn repeat_is_refused_where_nothing_was_saved() {
    let mut stage = Stage::open(Rendezvous::new(1).unwrap(), None, None);
    stage.advance(1);
    stage.order(Order::Repeat, 0, 1);
    for (role, status) in stage.settle().unwrap() {
        assert_eq!(status.state, State::Failed as u64, "{role}");
        assert!(status.text().contains("Repeat of window 0"), "{}", status.text());
    }
}

#[test]
fn more_windows_than_allowed_ahead_are_refused() {
    let mut rendezvous = Rendezvous::new(1).unwrap();
    rendezvous.ahead = 2;
    let mut stage = Stage::open(rendezvous, None, None);
    stage.order(Order::Advance, 0, 0);
    stage.order(Order::Advance, 1, 0);
    let third = stage.link.order(command(Order::Advance, 2, 0));
    assert!(third.unwrap_err().to_string().contains("at most 2"));
    stage.settle().unwrap();
    stage.close(2);
}
