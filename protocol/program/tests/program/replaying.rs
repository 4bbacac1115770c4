//! A solver driven by its log.

use std::path::Path;

use bedload_program::replay::{ReplayOptions, ReplayReport, replay};
use bedload_program::{Failure, Interrupts};
use protocol::log::{LogReader, Logged, Topic, flip_bit};
use protocol::participant::Participant;

use crate::support::{ToyDem, ToyFluid, coupled_log, coupled_log_with, manifest, path, window};

const VERIFY: ReplayOptions = ReplayOptions { verify: true, checkpoint: None, fields: false };

fn replayed<P>(solver: P, file: &Path, options: &ReplayOptions) -> Result<ReplayReport, Failure>
where
    P: Participant<Incoming: Logged, Outgoing: Logged>,
{
    let log = LogReader::open(file).unwrap();
    replay(solver, log, options, None, &Interrupts::never())
}

fn replay_dem(file: &Path, options: &ReplayOptions) -> ReplayReport {
    replayed(ToyDem::new(), file, options).unwrap()
}

#[test]
fn both_roles_repeat_their_log_bit_for_bit() {
    let file = path("replay.mcap");
    coupled_log(&file, 30, &[0, 4, 29]);
    let report = replayed(ToyFluid::new(), &file, &VERIFY).unwrap();
    assert_eq!(report.first_difference, None);
    assert_eq!((report.windows, report.repeats, report.compared), (33, 3, 33));
    let report = replay_dem(&file, &VERIFY);
    assert_eq!(report.first_difference, None);
    assert_eq!((report.windows, report.compared), (33, 33));
    assert!((report.time - 0.03).abs() < 1e-12);
    assert!(report.truncated.is_none() && report.unfinished.is_none());
}

#[test]
fn one_flipped_bit_is_named_by_step_grain_and_field() {
    let (file, bad) = (path("true.mcap"), path("flipped.mcap"));
    coupled_log(&file, 12, &[]);
    // Header 56 bytes, count 8, then 176 bytes per grain; velocity begins at word 7.
    let bit = 8 * (56 + 8 + 176 * 2 + 8 * (7 + 2)) + 3;
    flip_bit(&file, &bad, Topic::Kinematics, 8, 0, bit).unwrap();
    let report = replay_dem(&bad, &VERIFY);
    let found = report.first_difference.expect("noticed");
    assert_eq!((found.step, found.grain, found.field.as_str()), (8, Some(2), "velocity[2]"));
    assert_eq!(found.logged ^ found.sent, 8);
    assert_eq!(report.windows, 8);
    let text = found.to_string();
    assert!(text.starts_with("step 8, grain 2, field velocity[2]: logged "), "{text}");
}

#[test]
fn a_flipped_bit_of_the_header_or_of_the_input_is_found_too() {
    let (file, bad) = (path("true-2.mcap"), path("flipped-2.mcap"));
    coupled_log(&file, 12, &[]);
    // Word 4 of the header: sub-steps.
    flip_bit(&file, &bad, Topic::Kinematics, 5, 0, 64 * 4 + 1).unwrap();
    let found = replay_dem(&bad, &VERIFY).first_difference.expect("noticed");
    assert_eq!((found.step, found.grain), (5, None));
    assert_eq!(found.field, "header.substeps");
    // Lowest exponent bit of the vertical force on grain 1, once it is not zero: the DEM then
    // moves otherwise than logged, from that step on.
    let bit = 8 * (56 + 8 + 64 + 8 * 2) + 52;
    flip_bit(&file, &bad, Topic::Loads, 5, 0, bit).unwrap();
    let found = replay_dem(&bad, &VERIFY).first_difference.expect("noticed");
    assert_eq!((found.step, found.grain, found.field.as_str()), (5, Some(1), "position[2]"));
}

#[test]
fn without_verify_differences_are_measured() {
    let (file, bad) = (path("true-3.mcap"), path("flipped-3.mcap"));
    coupled_log(&file, 10, &[]);
    let bit = 8 * (56 + 8 + 8 * 2) + 51;
    flip_bit(&file, &bad, Topic::Kinematics, 4, 0, bit).unwrap();
    let report = replay_dem(&bad, &ReplayOptions::default());
    assert_eq!(report.windows, 10);
    assert_eq!(report.first_difference.map(|found| found.step), Some(4));
    let position = report.fields["position"];
    assert_eq!((position.words, position.differing), (10 * 3 * 3, 1));
    assert!(position.largest > 0.1 && position.rms > 0.0 && position.rms < position.largest);
    assert!(position.to_string().starts_with("1 of 90 numbers differ, by "), "{position}");
    assert_eq!(report.fields["spin"].to_string(), "all 90 numbers the same");
    assert_eq!(report.fields["header.dt"].words, 10);
}

#[test]
fn a_log_that_breaks_off_is_replayed_up_to_there() {
    let (file, cut) = (path("long.mcap"), path("short.mcap"));
    let options = protocol::log::RecorderOptions { chunk_bytes: 3000, ..Default::default() };
    coupled_log_with(&file, 20, &[], &manifest(), options);
    let bytes = std::fs::read(&file).unwrap();
    // Wherever it is cut, in a window as well: that one is not done.
    for part in 20..40 {
        std::fs::write(&cut, &bytes[..bytes.len() * part / 41]).unwrap();
        let report = replay_dem(&cut, &VERIFY);
        assert!(report.truncated.is_some(), "{part}");
        assert!(report.windows > 0 && report.windows <= 20, "{part}: {}", report.windows);
        assert_eq!(report.first_difference, None);
    }
}

#[test]
fn a_resumed_log_needs_its_checkpoint() {
    let file = path("resumed.mcap");
    let mut resumed = manifest();
    resumed.first_step = 3;
    resumed.first_time = 3e-3;
    let recorder = protocol::log::Recorder::create(&file, &resumed, Default::default()).unwrap();
    let (mut fluid, mut dem) = (ToyFluid::new(), ToyDem::new());
    let order = |step| window(step, 0).command(protocol::message::Order::Advance);
    // Step 0 is not what the manifest promises.
    for step in 3..6 {
        recorder.record_command(&order(step)).unwrap();
        crate::support::run_window(&mut fluid, &mut dem, &window(step, 0), &recorder);
    }
    recorder.finish().unwrap();
    let error = replayed(ToyDem::new(), &file, &VERIFY).unwrap_err();
    assert!(error.to_string().contains("begins at step 3"), "{error}");
    let options = ReplayOptions { checkpoint: Some(std::env::temp_dir()), ..VERIFY };
    let report = replayed(ToyDem::new(), &file, &options).unwrap();
    assert_eq!((report.windows, report.first_difference), (3, None));
    let fresh = protocol::log::Recorder::create(&file, &resumed, Default::default()).unwrap();
    assert!(fresh.record_command(&order(0)).is_err());
}
