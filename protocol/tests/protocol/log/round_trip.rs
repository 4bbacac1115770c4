//! What goes in comes out, bit for bit.

use protocol::log::{LogReader, Manifest, Message, Recorder, RecorderOptions, Topic, nanoseconds};
use protocol::message::{Command, Header, Kinematics, Loads, Order, Record, Status};
use protocol::participant::Role;

use crate::log::support::{Random, coupled_log, path};

fn loads(random: &mut Random) -> Loads {
    Loads {
        force: random.vector(),
        torque: random.vector(),
        added_mass: random.f64(),
        added_inertia: random.f64(),
    }
}

fn kinematics(random: &mut Random) -> Kinematics {
    Kinematics {
        position: random.vector(),
        orientation: [random.f64(), random.f64(), random.f64(), random.f64()],
        velocity: random.vector(),
        spin: random.vector(),
        contact_force: random.vector(),
        lubrication_force: random.vector(),
        gap: random.f64(),
        impact_speed: random.f64(),
        rebound_speed: random.f64(),
    }
}

fn header(random: &mut Random, step: u64, attempt: u64) -> Header {
    Header {
        step,
        attempt,
        time: random.f64(),
        dt: random.f64(),
        substeps: random.next(),
        smallest_gap: random.f64(),
        largest_overlap: random.f64(),
    }
}

/// All words of a message, so that NaN equals itself.
fn words(message: &Message) -> Vec<u64> {
    fn slice<R: Record>(header: &Header, records: &[R]) -> Vec<u64> {
        let records = records.iter().flat_map(Record::words);
        header.words().into_iter().chain(records).collect()
    }
    match message {
        Message::Command(command) => command.words(),
        Message::Loads(header, records) => slice(header, records),
        Message::Kinematics(header, records) => slice(header, records),
        Message::Status(role, status) => std::iter::once(*role as u64).chain(status.words()).collect(),
        Message::Opaque(_) => Vec::new(),
    }
}

/// The messages of one window with arbitrary contents.
fn window(random: &mut Random, step: u64, attempt: u64, grains: usize) -> Vec<Message> {
    let order = if attempt == 0 { Order::Advance } else { Order::Repeat };
    let command = Command {
        order: order as u64,
        step,
        attempt,
        time: step as f64 * 0.25,
        dt: random.f64(),
        substeps: random.next(),
        output: random.next() % 2,
    };
    let mut status = Status { step, attempt, residual: random.f64(), ..Status::default() };
    status.set_text("worte mit ü");
    let mut messages = vec![
        Message::Loads(header(random, step, attempt), (0..grains).map(|_| loads(random)).collect()),
        Message::Kinematics(header(random, step, attempt), (0..grains).map(|_| kinematics(random)).collect()),
    ];
    if random.next().is_multiple_of(2) {
        messages.swap(0, 1);
    }
    messages.insert(0, Message::Command(command));
    messages.push(Message::Status(Role::Dem, Box::new(status)));
    messages
}

fn record(recorder: &Recorder, message: &Message) {
    match message {
        Message::Command(command) => recorder.record_command(command),
        Message::Loads(header, records) => recorder.record_loads(header, records),
        Message::Kinematics(header, records) => recorder.record_kinematics(header, records),
        Message::Status(role, status) => recorder.record_status(*role, status),
        Message::Opaque(_) => Ok(()),
    }
    .expect("in order");
}

#[test]
fn random_messages_come_back_to_the_bit() {
    for (seed, grains) in [(1, 0), (2, 1), (3, 7), (4, 300)] {
        let mut random = Random(seed);
        let mut manifest = Manifest::new("random", "", vec![0.5; grains], 0.25, 10.0);
        manifest.first_step = 1000;
        let mut messages = Vec::new();
        for step in 1000..1040 {
            for attempt in 0..1 + random.next() % 3 {
                messages.extend(window(&mut random, step, attempt, grains));
            }
        }
        let file = path(&format!("random-{grains}.mcap"));
        let options = RecorderOptions { chunk_bytes: 3000, ..RecorderOptions::default() };
        let recorder = Recorder::create(&file, &manifest, options).unwrap();
        messages.iter().for_each(|message| record(&recorder, message));
        recorder.finish().unwrap();

        let reader = LogReader::open(&file).unwrap();
        assert_eq!(reader.manifest(), &manifest);
        let read: Vec<Message> = reader
            .map(|entry| entry.expect("readable"))
            .filter(|entry| Topic::from_name(&entry.channel.topic).is_some_and(Topic::is_data))
            .map(|entry| entry.message)
            .collect();
        assert_eq!(read.len(), messages.len());
        for (read, written) in read.iter().zip(&messages) {
            assert_eq!(words(read), words(written));
        }
    }
}

#[test]
fn every_message_has_its_step_and_a_time_that_never_falls() {
    let file = path("times.mcap");
    coupled_log(&file, 20, &[3, 7]);
    let mut last = (0, 0);
    let mut frames = 0;
    for entry in LogReader::open(&file).unwrap() {
        let entry = entry.unwrap();
        assert!(entry.log_time >= last.0, "simulated time falls");
        last = (entry.log_time, entry.step.max(last.1));
        match entry.message {
            Message::Loads(header, _) | Message::Kinematics(header, _) => {
                assert_eq!(entry.step, header.step);
                assert_eq!(entry.log_time, nanoseconds(header.time));
            }
            Message::Command(command) => assert_eq!(entry.step, command.step),
            Message::Status(_, status) => assert_eq!(entry.step, status.step),
            Message::Opaque(_) => frames += 1,
        }
    }
    // 600 frames in 1 s: each window of 1 ms waits for the next 1/600 s; a repeated window once.
    assert_eq!(last.1, 20);
    assert_eq!(frames % 4, 0);
    assert!((4 * 10..=4 * 14).contains(&frames), "{frames}");
}

#[test]
fn windows_hold_their_messages() {
    let file = path("windows.mcap");
    coupled_log(&file, 6, &[2]);
    let windows: Vec<_> = LogReader::open(&file).unwrap().windows().map(|window| window.unwrap()).collect();
    let tries: Vec<_> = windows.iter().map(|window| (window.command.step, window.command.attempt)).collect();
    assert_eq!(tries, [(0, 0), (1, 0), (2, 0), (2, 1), (3, 0), (4, 0), (5, 0)]);
    for window in &windows {
        let (step, attempt) = (window.command.step, window.command.attempt);
        for header in [window.loads.as_ref().unwrap().0, window.kinematics.as_ref().unwrap().0] {
            assert_eq!((header.step, header.attempt), (step, attempt));
        }
        assert_eq!(window.accepted, (step, attempt) != (2, 0));
        assert_eq!(window.is_repeat(), attempt == 1);
    }
}
