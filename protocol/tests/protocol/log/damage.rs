//! Files that are cut, flipped, hostile or of another build.

use std::path::Path;

use protocol::log::{LogError, LogReader, Manifest, Message, RecorderOptions, Topic, flip_bit, repair, thin};

use crate::log::support::{coupled_log, coupled_log_with, manifest, path};

/// Steps and topics of all messages that can be read, and the error that ends them.
fn read(bytes: Vec<u8>) -> (Vec<(u64, String, Message)>, Option<LogError>) {
    let mut messages = Vec::new();
    let reader = match LogReader::from_bytes(bytes, "test.mcap") {
        Ok(reader) => reader,
        Err(error) => return (messages, Some(error)),
    };
    for entry in reader {
        match entry {
            Ok(entry) => messages.push((entry.step, entry.channel.topic.clone(), entry.message)),
            Err(error) => return (messages, Some(error)),
        }
    }
    (messages, None)
}

/// A small log of several chunks.
fn small_log(name: &str) -> Vec<u8> {
    let file = path(name);
    let options = RecorderOptions { chunk_bytes: 4000, ..RecorderOptions::default() };
    coupled_log_with(&file, 6, &[2], &manifest(), options);
    std::fs::read(&file).unwrap()
}

#[test]
fn every_cut_gives_a_prefix_and_says_so() {
    let bytes = small_log("cut.mcap");
    let (whole, error) = read(bytes.clone());
    assert!(error.is_none(), "{error:?}");
    let mut lengths = std::collections::BTreeSet::new();
    for end in 0..bytes.len() {
        let (messages, error) = read(bytes[..end].to_vec());
        let error = error.unwrap_or_else(|| panic!("cut at {end} is not noticed"));
        assert!(error.is_truncation(), "cut at {end}: {error}");
        assert!(messages[..] == whole[..messages.len()], "cut at {end}");
        lengths.insert(messages.len());
    }
    assert!(lengths.len() >= 4, "several chunks, so several prefixes: {lengths:?}");
    assert_eq!(lengths.last(), Some(&whole.len()), "a cut in the index loses no message");
}

#[test]
fn every_flipped_byte_is_an_error_or_harms_no_message() {
    let bytes = small_log("flips.mcap");
    let (whole, _) = read(bytes.clone());
    let mut unnoticed = 0;
    for place in 0..bytes.len() {
        let mut bad = bytes.clone();
        bad[place] ^= 1 << (place % 8);
        let (messages, error) = read(bad);
        match error {
            Some(error) => {
                assert!(messages.len() <= whole.len(), "byte {place}");
                assert!(messages[..] == whole[..messages.len()], "byte {place}: {error}");
            }
            None => {
                unnoticed += 1;
                assert!(messages == whole, "byte {place}");
            }
        }
    }
    assert!(unnoticed * 100 < bytes.len(), "{unnoticed} of {} flips unnoticed", bytes.len());
}

#[test]
fn damage_names_file_byte_and_step() {
    let mut bytes = small_log("named.mcap");
    let entries: Vec<_> =
        LogReader::from_bytes(bytes.clone(), "test.mcap").unwrap().map(|entry| entry.unwrap()).collect();
    let chunk = entries.iter().find(|entry| entry.step == 3).unwrap().offset;
    let before: Vec<_> = entries.iter().filter(|entry| entry.offset < chunk).collect();
    assert!(!before.is_empty());
    // Opcode and length (9), the chunk's header (44), then what zstd wrote.
    bytes[chunk as usize + 9 + 44 + 40] ^= 0x10;
    let (messages, error) = read(bytes);
    assert_eq!(messages.len(), before.len());
    match error {
        Some(LogError::Damaged { file, offset, after, .. }) => {
            assert_eq!((file.as_str(), offset), ("test.mcap", chunk));
            assert_eq!(after.0, before.last().map(|entry| entry.step));
        }
        other => panic!("{other:?}"),
    }
}

#[test]
fn a_bad_length_inside_a_complete_file_is_damage_and_no_truncation() {
    let mut bytes = small_log("length.mcap");
    let chunk = LogReader::from_bytes(bytes.clone(), "test.mcap")
        .unwrap()
        .map(|entry| entry.unwrap().offset)
        .max()
        .unwrap();
    // The highest byte but two of the record's length: far beyond the end.
    bytes[chunk as usize + 6] = 1;
    let (messages, error) = read(bytes);
    assert!(!messages.is_empty());
    assert!(matches!(error, Some(LogError::Damaged { offset, .. }) if offset == chunk));
}

#[test]
fn repair_makes_a_complete_file_of_a_cut_one() {
    let (cut, whole) = (path("broken.mcap"), path("repaired.mcap"));
    let bytes = small_log("to-repair.mcap");
    let (all, _) = read(bytes.clone());
    let mut kept_some = 0;
    for end in (bytes.len() / 4..bytes.len()).step_by(bytes.len() / 40) {
        std::fs::write(&cut, &bytes[..end]).unwrap();
        let (expected, _) = read(bytes[..end].to_vec());
        if LogReader::open(&cut).is_err() {
            continue;
        }
        let report = repair(&cut, &whole).unwrap();
        assert!(report.errors.iter().all(LogError::is_truncation) && report.errors.len() == 1);
        assert_eq!(report.kept.values().sum::<u64>(), expected.len() as u64);
        assert_eq!(report.last_step, expected.last().map(|message| message.0));
        assert_eq!(report.bytes, end as u64);
        let (messages, error) = read(std::fs::read(&whole).unwrap());
        assert!(error.is_none(), "{error:?}");
        assert_eq!(messages, expected);
        kept_some += usize::from(!messages.is_empty() && messages.len() < all.len());
    }
    assert!(kept_some > 3, "the cuts must fall among the messages");
    assert!(repair(Path::new("/nowhere.mcap"), &whole).is_err());
}

#[test]
fn damage_costs_the_chunk_that_it_stands_in_and_no_other() {
    let (bad, mended) = (path("flipped.mcap"), path("flipped-repaired.mcap"));
    let bytes = small_log("to-flip.mcap");
    let reader = LogReader::from_bytes(bytes.clone(), "test.mcap").unwrap();
    let mut chunks = std::collections::BTreeMap::<u64, usize>::new();
    let whole: Vec<_> = reader.map(|entry| entry.unwrap()).collect();
    whole.iter().for_each(|entry| *chunks.entry(entry.offset).or_default() += 1);
    let (first, most) = (*chunks.keys().next().unwrap(), *chunks.values().max().unwrap());
    assert!(chunks.len() > 3 && 2 * most < whole.len(), "{chunks:?}");
    let (mut before, mut scenes_lost) = (0, 0);
    for place in (0..bytes.len()).filter(|place| place % if (*place as u64) < first { 5 } else { 29 } == 0) {
        let mut flipped = bytes.clone();
        flipped[place] ^= 1 << (place % 8);
        std::fs::write(&bad, &flipped).unwrap();
        let _ = std::fs::remove_file(&mended);
        let report = repair(&bad, &mended).unwrap_or_else(|error| panic!("byte {place}: {error}"));
        let reader = LogReader::open_any(&mended).unwrap_or_else(|error| panic!("byte {place}: {error}"));
        // The facts of the run stand before the first chunk, and once more with the channels.
        let scene = reader.manifest().scene.clone();
        scenes_lost += usize::from(scene.is_empty());
        assert!(*reader.manifest() == Manifest { scene, ..manifest() }, "byte {place}");
        if (place as u64) < first {
            before += 1;
            assert!(!report.errors.is_empty(), "byte {place}");
            assert_eq!(report.kept.values().sum::<u64>(), whole.len() as u64, "byte {place}: {report:?}");
        }
        let mut all = whole.iter();
        let mut kept = 0;
        for entry in reader.filter_map(Result::ok) {
            let is_same = |other: &&protocol::log::Entry| {
                (other.step, &other.channel.topic, &other.message)
                    == (entry.step, &entry.channel.topic, &entry.message)
            };
            assert!(all.any(|other| is_same(&other)), "byte {place}: a message that was not there");
            kept += 1;
        }
        assert!(kept + most >= whole.len(), "byte {place}: {kept} of {}, {:?}", whole.len(), report.errors);
    }
    println!("{before} flips before the first chunk, {scenes_lost} without their scene");
    assert!(before > 300 && scenes_lost > 0);
}

#[test]
fn a_gap_is_named_and_the_log_goes_on_behind_it() {
    let (bad, mended) = (path("gap.mcap"), path("gap-repaired.mcap"));
    let bytes = small_log("to-gap.mcap");
    let entries: Vec<_> =
        LogReader::from_bytes(bytes.clone(), "test.mcap").unwrap().map(|entry| entry.unwrap()).collect();
    let offsets: std::collections::BTreeSet<u64> = entries.iter().map(|entry| entry.offset).collect();
    let (lost, after) = (*offsets.iter().nth(2).unwrap(), *offsets.iter().nth(3).unwrap());
    let mut flipped = bytes.clone();
    // Its length: what the framing then takes for the record swallows all that follows.
    flipped[lost as usize + 3] ^= 1;
    std::fs::write(&bad, &flipped).unwrap();
    let report = repair(&bad, &mended).unwrap();
    let [LogError::Damaged { offset, next, .. }] = report.errors[..] else { panic!("{:?}", report.errors) };
    assert_eq!((offset, next, report.bytes_lost), (lost, Some(after), after - lost));
    let kept = entries.iter().filter(|entry| entry.offset != lost).count() as u64;
    assert_eq!(report.kept.values().sum::<u64>(), kept);
    // Whole as a file, with one gap: who looks reads on, a replay stops there.
    let found: Vec<_> = LogReader::open_any(&mended).unwrap().collect();
    assert_eq!(found.iter().filter(|entry| entry.is_ok()).count() as u64, kept);
    assert!(matches!(
        found.iter().filter_map(|entry| entry.as_ref().err()).collect::<Vec<_>>()[..],
        [LogError::Sequence { .. }]
    ));
    let strict: Vec<_> = LogReader::open(&mended).unwrap().collect();
    assert!(strict.last().unwrap().is_err() && strict.len() < found.len());
}

#[test]
fn a_thinned_log_has_some_frames_and_no_messages() {
    let (full, small) = (path("to-thin.mcap"), path("thin.mcap"));
    // 600 frames in 0.3 s: each window of 1 ms is one.
    let manifest = Manifest { until: 0.3, ..manifest() };
    coupled_log_with(&full, 40, &[], &manifest, RecorderOptions::default());
    let report = thin(&full, &small, 10).unwrap();
    let topics: Vec<_> = report.kept.iter().map(|(topic, count)| (topic.as_str(), *count)).collect();
    let viewers = ["viewer/grains", "viewer/points", "viewer/scene", "viewer/window"];
    assert_eq!(topics, viewers.map(|topic| (topic, 4)));
    assert!(2 * report.bytes_kept < report.bytes, "{} of {}", report.bytes_kept, report.bytes);
    let steps: Vec<u64> = LogReader::open(&small).unwrap().map(|entry| entry.unwrap().step).collect();
    assert_eq!(steps.first().zip(steps.last()), Some((&0, &30)));
}

#[test]
fn a_log_can_be_repaired_in_place() {
    let file = path("in-place.mcap");
    coupled_log(&file, 3, &[]);
    let before = read(std::fs::read(&file).unwrap()).0;
    let report = repair(&file, &file).unwrap();
    assert!(report.errors.is_empty() && report.bytes_lost == 0);
    assert_eq!(read(std::fs::read(&file).unwrap()).0, before);
}

#[test]
fn hostile_lengths_do_not_abort() {
    // A record that claims more than any memory, a text that claims 4 GiB, a chunk of 2^62 bytes.
    let record = |opcode: u8, length: u64, body: &[u8]| {
        let mut bytes = b"\x89MCAP0\r\n".to_vec();
        bytes.push(opcode);
        bytes.extend_from_slice(&length.to_le_bytes());
        bytes.extend_from_slice(body);
        bytes
    };
    let schema = [1, 0, 0xff, 0xff, 0xff, 0xff, b'x'];
    let mut chunk = vec![0; 16];
    chunk.extend_from_slice(&(1u64 << 62).to_le_bytes());
    chunk.extend_from_slice(&[0; 4]);
    chunk.extend_from_slice(&4u32.to_le_bytes());
    chunk.extend_from_slice(b"zstd");
    chunk.extend_from_slice(&4u64.to_le_bytes());
    chunk.extend_from_slice(&[0x28, 0xb5, 0x2f, 0xfd]);
    for bytes in [
        record(0x05, u64::MAX, &[]),
        record(0x06, 1 << 40, &[0; 100]),
        record(0x03, 7, &schema),
        record(0x06, chunk.len() as u64, &chunk),
        record(0x09, 28, &[0xff; 28]),
        record(0x0c, 8, &[0xff; 8]),
    ] {
        let (messages, error) = read(bytes);
        assert!(messages.is_empty() && error.is_some());
    }
}

#[test]
fn a_payload_that_claims_more_than_it_holds_is_refused() {
    let (file, bad) = (path("honest.mcap"), path("hostile.mcap"));
    coupled_log(&file, 4, &[]);
    // The count stands after the header's 56 bytes.
    for bit in [0, 1, 31, 32, 60, 63] {
        flip_bit(&file, &bad, Topic::Loads, 2, 0, 56 * 8 + bit).unwrap();
        let (messages, error) = read(std::fs::read(&bad).unwrap());
        assert!(messages.iter().all(|message| message.0 <= 2));
        let error = error.expect("noticed").to_string();
        assert!(error.contains("claims"), "{error}");
    }
}

#[test]
fn a_label_that_lies_is_refused() {
    let (file, bad) = (path("labels.mcap"), path("lying.mcap"));
    coupled_log(&file, 4, &[]);
    // Lowest bit of the step in the payload: 2 becomes 3.
    flip_bit(&file, &bad, Topic::Kinematics, 2, 0, 0).unwrap();
    let error = read(std::fs::read(&bad).unwrap()).1.expect("noticed");
    assert!(matches!(error, LogError::Sequence { offset: Some(_), .. }), "{error}");
    assert!(flip_bit(&file, &bad, Topic::Kinematics, 9, 0, 0).is_err());
}

#[test]
fn another_layout_is_refused_by_name_and_still_counts() {
    let file = path("foreign.mcap");
    let mut foreign = manifest();
    foreign.layout ^= 1;
    foreign.version = "9.9.9".to_owned();
    coupled_log_with(&file, 3, &[], &foreign, RecorderOptions::default());
    let error = LogReader::open(&file).err().expect("refused");
    assert!(matches!(error, LogError::Layout { .. }));
    let text = error.to_string();
    assert!(text.contains("9.9.9") && text.contains(&format!("{:016x}", foreign.layout)), "{text}");
    let entries: Vec<_> = LogReader::open_any(&file).unwrap().map(|entry| entry.unwrap().message).collect();
    assert!(entries.len() > 18 && entries.iter().all(|m| matches!(m, Message::Opaque(_))));
}

#[test]
fn what_is_no_log_is_refused() {
    let (messages, error) = read(b"hello, this is text and no log".to_vec());
    assert!(messages.is_empty() && matches!(error, Some(LogError::NotALog { .. })), "{error:?}");
    let empty = read(Vec::new()).1.expect("no log");
    assert!(matches!(empty, LogError::Truncated { offset: 0, .. }));
    assert!(
        empty.to_string().contains("nothing to rewrite") && !empty.to_string().contains("repair"),
        "{empty}"
    );
}
