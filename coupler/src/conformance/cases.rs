//! What a solver of a coupled run has to do, case by case (docs/coupling.md). Each is a run of its own.

use std::time::{Duration, Instant};

use bedload_scene::Motion;
use protocol::channel::{CouplerLink, Rendezvous};
use protocol::log::Records;
use protocol::message::{Command, Kinematics, Loads, Order, State};
use protocol::participant::Role;
use protocol::serve::checkpoint_folder;

use super::bench::Bench;
use crate::number::norm;
use crate::solo_run::{Fault, FaultFrom, LEAVE, Setting, SoloRun, Turn, how, text};

/// A case: what to do, and what it is for.
pub(super) struct Case {
    pub(super) name: &'static str,
    /// Whether a solver must pass; else what it lacks is reported.
    pub(super) needed: bool,
    pub(super) about: &'static str,
    /// What was seen, or what was wrong.
    pub(super) play: fn(&Bench) -> Result<String, String>,
}

/// A case that a solver must pass.
const fn must(name: &'static str, play: fn(&Bench) -> Result<String, String>, about: &'static str) -> Case {
    Case { name, needed: true, about, play }
}

/// A case that a solver may do without.
const fn may(name: &'static str, play: fn(&Bench) -> Result<String, String>, about: &'static str) -> Case {
    Case { needed: false, ..must(name, play, about) }
}

/// All cases; the first one tells whether the solver takes the role at all.
#[rustfmt::skip]
pub(super) const CASES: [Case; 14] = [
    must("ready", ready, "joins, says Ready, leaves on Stop with exit code 0"),
    must("windows", windows, "one message a window with the command's step, attempt, time, dt and sub-steps, all \
        numbers finite, then Done"),
    must("ahead", ahead, "takes four windows ordered at once, in order"),
    must("units", units, "DEM: half the weight as load halves the fall; fluid: at rest it sends buoyancy"),
    must("checkpoint", checkpoint, "goes on from a checkpoint with the same bits as if it had not stopped"),
    must("stop-waiting", stop_waiting, "obeys Stop while it waits for a peer that is silent"),
    must("peer-silent", peer_silent, "gives up by the deadline, not with 0"),
    must("peer-leaves", peer_leaves, "leaves when its peer has gone, not with 0"),
    must("coupler-leaves", coupler_leaves, "leaves when the coupler has gone, not with 0"),
    must("unknown-order", unknown_order, "answers an order that it does not know with Failed, or leaves, not with 0"),
    must("other-layout", other_layout, "refuses a token of another layout"),
    must("other-grains", other_grains, "refuses a run with another number of grains than its scene"),
    may("not-finite", not_finite, "answers a value that is not a number with Failed, or leaves, not with 0"),
    may("repeat", repeat, "does a window again from its start with the same bits (coupling.scheme = \"iterated\")"),
];

/// Windows before something happens.
const BEFORE: usize = 3;

fn ready(bench: &Bench) -> Result<String, String> {
    let mut run = bench.open(Setting::default())?;
    let (joined, ready) = (run.joined, run.ready);
    run.stop()?;
    Ok(format!("ready after {:.2} s, knows {} grains", joined.as_secs_f64(), ready.grains))
}

fn windows(bench: &Bench) -> Result<String, String> {
    let mut run = bench.open(Setting::default())?;
    let commands = bench.windows(6);
    let mut substeps = 0;
    for command in &commands {
        let turn = run.play(*command)?;
        check_turn(command, &turn)?;
        if bench.setup.role == Role::Dem {
            substeps += command.substeps;
            if turn.done.substeps != substeps {
                return Err(format!(
                    "Done of window {} counts {} sub-steps since the start, {substeps} were ordered",
                    command.step, turn.done.substeps
                ));
            }
        }
    }
    run.stop()?;
    Ok(format!("{} windows", commands.len()))
}

fn ahead(bench: &Bench) -> Result<String, String> {
    let mut run = bench.open(Setting::default())?;
    let commands = bench.windows(4);
    for command in &commands {
        run.order(*command)?;
    }
    for command in &commands {
        let turn = run.turn(command)?;
        check_turn(command, &turn)?;
    }
    run.stop()?;
    Ok(format!("{} windows at once", commands.len()))
}

/// Header, records and report of a window.
pub(super) fn check_turn(command: &Command, turn: &Turn) -> Result<(), String> {
    let Turn { header, records, done } = turn;
    let step = command.step;
    let (ordered, sent) = match records {
        Records::Loads(_) => (0, 0),
        Records::Kinematics(_) => (command.substeps, header.substeps),
    };
    for (what, ours, theirs) in [
        ("step", step, header.step),
        ("attempt", command.attempt, header.attempt),
        ("time", command.time.to_bits(), header.time.to_bits()),
        ("dt", command.dt.to_bits(), header.dt.to_bits()),
        ("substeps", ordered, sent),
    ] {
        if ours != theirs {
            let shown = |bits: u64| match what {
                "time" | "dt" => f64::from_bits(bits).to_string(),
                _ => bits.to_string(),
            };
            return Err(format!(
                "the header of window {step} has {what} = {}, the command {}",
                shown(theirs),
                shown(ours)
            ));
        }
    }
    let bad = |grain: usize, word: usize, value: f64| {
        Err(format!("window {step}: {} of grain {grain} is {value}", turn.field(word)))
    };
    // Position, orientation, velocity and spin are the coupling; observations may be infinite (a gap to
    // nothing).
    let coupling = if matches!(records, Records::Kinematics(_)) { 13 } else { usize::MAX };
    for (grain, words) in turn.words().iter().enumerate() {
        for (word, value) in words.iter().map(|word| f64::from_bits(*word)).enumerate() {
            if value.is_nan() || (word < coupling && value.is_infinite()) {
                return bad(grain, word, value);
            }
        }
    }
    match records {
        Records::Loads(records) => {
            for (grain, loads) in records.iter().enumerate() {
                if loads.added_mass < 0.0 {
                    return bad(grain, 6, loads.added_mass);
                }
            }
        }
        Records::Kinematics(records) => {
            for (grain, kinematics) in records.iter().enumerate() {
                let norm = kinematics.orientation.iter().map(|q| q * q).sum::<f64>();
                if (norm - 1.0).abs() > 1e-6 {
                    return Err(format!(
                        "window {step}: the orientation of grain {grain} is no unit quaternion, its square is {norm}"
                    ));
                }
            }
        }
    }
    let state = (done.state, done.step, done.attempt);
    if state != (State::Done as u64, step, command.attempt) {
        return Err(format!(
            "after window {step} it said state {} of window {}, attempt {} (Done is 2)",
            state.0, state.1, state.2
        ));
    }
    if done.dt_limit.is_nan() || done.dt_limit <= 0.0 {
        return Err(format!(
            "dt_limit after window {step} is {}; allowed: positive, or infinite",
            done.dt_limit
        ));
    }
    Ok(())
}

fn units(bench: &Bench) -> Result<String, String> {
    let mut run = bench.open(Setting::default())?;
    let command = bench.window(0, 0.0, 1.0, 20);
    let turn = run.play(command)?;
    run.stop()?;
    match &turn.records {
        Records::Kinematics(records) => falls(bench, &command, records),
        Records::Loads(records) => floats(bench, records),
    }
}

/// Free grains at rest that nothing touches gain g dt/2.
fn falls(bench: &Bench, command: &Command, records: &[Kinematics]) -> Result<String, String> {
    let scene = &bench.setup.scene;
    let gravity = scene.scene.gravity.mean(command.time, command.time + command.dt);
    let mut seen = 0;
    for (number, (grain, now)) in scene.grains.iter().zip(records).enumerate() {
        let alone = now.contact_force == [0.0; 3] && now.lubrication_force == [0.0; 3];
        let free = grain.motion == Motion::Free && grain.locked.is_empty() && grain.velocity.is_zero();
        if !(alone && free) {
            continue;
        }
        seen += 1;
        for c in 0..3 {
            let gained = 0.5 * gravity[c] * command.dt;
            if (now.velocity[c] - gained).abs() > 1e-6 * norm(&gravity) * command.dt {
                return Err(format!(
                    "grain {number} has velocity[{c}] = {:e} m/s after {} s under half its weight; ½ g dt is \
                     {gained:e}",
                    now.velocity[c], command.dt
                ));
            }
            // ½ g/2 dt², and a sub-step more or less
            let moved = now.position[c] - grain.position[c];
            if (moved - 0.5 * gained * command.dt).abs() > 0.1 * (gained * command.dt).abs() + 1e-14 {
                return Err(format!(
                    "grain {number} has moved by {moved:e} m along axis {c}; {:e} were expected",
                    0.5 * gained * command.dt
                ));
            }
        }
    }
    Ok(format!("{seen} of {} grains at rest and untouched fall as they should", records.len()))
}

/// Grains at rest in a fluid at rest between walls feel −m_f g.
fn floats(bench: &Bench, records: &[Loads]) -> Result<String, String> {
    let scene = &bench.setup.scene;
    let density = scene.scene.medium.as_ref().map_or(0.0, |medium| medium.density);
    if !bench.plain {
        return Ok("not looked at: it needs a fluid at rest between walls, as in the built-in scene".into());
    }
    let mut worst = 0.0f64;
    for (number, (grain, loads)) in scene.grains.iter().zip(records).enumerate() {
        let buoyancy = scene.scene.gravity.start().map(|g| -density * g * grain.volume());
        let wrong = norm(&std::array::from_fn(|c| loads.force[c] - buoyancy[c])) / norm(&buoyancy);
        if wrong.is_nan() || wrong > 0.05 {
            return Err(format!(
                "grain {number} at rest in a fluid at rest feels {:?} N; buoyancy, −ρ V g, is {buoyancy:?} N",
                loads.force
            ));
        }
        worst = worst.max(wrong);
    }
    Ok(format!("buoyancy within {:.1e}", worst))
}

fn checkpoint(bench: &Bench) -> Result<String, String> {
    let commands = bench.windows(BEFORE + 3);
    let (first, rest) = commands.split_at(BEFORE);
    let mut run = bench.open(Setting::default())?;
    for command in first {
        run.play(*command)?;
    }
    let step = BEFORE as u64;
    let said = run.save(step)?;
    if said.state != State::Saved as u64 {
        return Err(format!("answered Checkpoint with state {} (Saved is 3): {}", said.state, said.text()));
    }
    let whole = rest.iter().map(|command| run.play(*command)).collect::<Result<Vec<_>, _>>()?;
    run.stop()?;
    drop(run);
    let folder = checkpoint_folder(bench.setup.folder.root(), step);
    let mut run = bench.open(Setting { checkpoint: Some(&folder), ..Setting::default() })?;
    for (command, whole) in rest.iter().zip(&whole) {
        let turn = run.play(*command)?;
        same(command.step, whole, &turn)?;
    }
    run.stop()?;
    Ok(format!("{} windows after it are the same, bit for bit", rest.len()))
}

fn repeat(bench: &Bench) -> Result<String, String> {
    let mut run = bench.open(Setting { repeatable: true, ..Setting::default() })?;
    for command in bench.windows(BEFORE) {
        let first = run.play(command)?;
        let shorter = Command { order: Order::Repeat as u64, attempt: 1, dt: 0.5 * command.dt, ..command };
        check_turn(&shorter, &run.play(shorter)?)?;
        let again = Command { order: Order::Repeat as u64, attempt: 2, ..command };
        let turn = run.play(again)?;
        check_turn(&again, &turn)?;
        same(command.step, &first, &turn)?;
        run.order(Command { order: Order::Accept as u64, attempt: 2, ..command })?;
    }
    run.stop()?;
    Ok(format!("{BEFORE} windows, each a second and a third time"))
}

/// Two messages of one window.
fn same(step: u64, first: &Turn, second: &Turn) -> Result<(), String> {
    for (grain, (a, b)) in first.words().iter().zip(second.words()).enumerate() {
        if let Some(word) = (0..a.len()).find(|k| a[*k] != b[*k]) {
            return Err(format!(
                "{} of grain {grain} in window {step} is {:e}, and was {:e}",
                second.field(word),
                f64::from_bits(b[word]),
                f64::from_bits(a[word])
            ));
        }
    }
    Ok(())
}

/// Does some windows; the peer fails from the last on, which is ordered and not waited for.
fn until<'a>(bench: &'a Bench, fault: Fault, setting: Setting<'_>) -> Result<SoloRun<'a>, String> {
    let fault = FaultFrom { fault, from: BEFORE as u64 };
    let mut run = bench.open(Setting { fault, ..setting })?;
    let commands = bench.windows(BEFORE + 1);
    for command in &commands[..BEFORE] {
        run.play(*command)?;
    }
    run.order(commands[BEFORE])?;
    Ok(run)
}

/// Waits at most `limit` until the solver has left, not with 0.
fn gives_up(run: &SoloRun<'_>, limit: Duration) -> Result<String, String> {
    let begin = Instant::now();
    let exit = run.supervisor.leaves(limit)?;
    match exit.code() {
        Some(0) => Err("left with 0, as if all were well".into()),
        Some(code) => Ok(format!("left with {code} after {:.2} s", begin.elapsed().as_secs_f64())),
        None => Err(how(&exit)),
    }
}

fn stop_waiting(bench: &Bench) -> Result<String, String> {
    let mut run = until(bench, Fault::Silent, Setting::default())?;
    std::thread::sleep(Duration::from_millis(100));
    let begin = Instant::now();
    // What it had sent before it waited is part of no finished window.
    run.stop_unfinished()?;
    Ok(format!("left with 0 after {:.2} s", begin.elapsed().as_secs_f64()))
}

fn peer_silent(bench: &Bench) -> Result<String, String> {
    let deadline = 1.5;
    let run = until(bench, Fault::Silent, Setting { deadline: Some(deadline), ..Setting::default() })?;
    gives_up(&run, Duration::from_secs_f64(deadline) + LEAVE)
}

fn peer_leaves(bench: &Bench) -> Result<String, String> {
    let run = until(bench, Fault::Leave, Setting::default())?;
    gives_up(&run, LEAVE)
}

fn coupler_leaves(bench: &Bench) -> Result<String, String> {
    let mut run = bench.open(Setting::default())?;
    for command in bench.windows(BEFORE) {
        run.play(command)?;
    }
    run.abandon();
    gives_up(&run, LEAVE)
}

/// The solver says Failed, or leaves, and in the end has left, not with 0.
fn fails(run: &mut SoloRun<'_>, step: u64) -> Result<String, String> {
    let said = loop {
        match run.report(step) {
            Ok(status) if status.state == State::Done as u64 && status.step < step => {}
            Ok(status) if status.state == State::Failed as u64 => break Some(status.text()),
            Ok(status) => return Err(format!("answered with state {}, as if all were well", status.state)),
            Err(_) => break None,
        }
    };
    let left = gives_up(run, LEAVE)?;
    Ok(said.map_or_else(|| left.clone(), |said| format!("{left}, saying: {said}")))
}

fn unknown_order(bench: &Bench) -> Result<String, String> {
    let mut run = bench.open(Setting::default())?;
    run.order(Command { order: 99, ..Command::default() })?;
    fails(&mut run, 0)
}

fn not_finite(bench: &Bench) -> Result<String, String> {
    let mut run = until(bench, Fault::NotFinite, Setting::default())?;
    // it may be the window after in which it sees what it was sent
    let next = bench.windows(BEFORE + 2)[BEFORE + 1];
    match fails(&mut run, BEFORE as u64) {
        Err(_) if run.order(next).is_ok() => fails(&mut run, next.step),
        seen => seen,
    }
}

fn other_layout(bench: &Bench) -> Result<String, String> {
    let rendezvous = bench.setup.rendezvous(Setting::default())?;
    let other = Rendezvous { layout: "0123456789abcdef".into(), ..rendezvous };
    refuses(bench, &other)
}

fn other_grains(bench: &Bench) -> Result<String, String> {
    let rendezvous = bench.setup.rendezvous(Setting::default())?;
    refuses(bench, &Rendezvous { grains: rendezvous.grains + 1, ..rendezvous })
}

/// The solver leaves a run of this token, not with 0, without having waited for anybody.
fn refuses(bench: &Bench, rendezvous: &Rendezvous) -> Result<String, String> {
    let link = CouplerLink::create(rendezvous).map_err(text)?;
    let supervisor = bench.setup.start(rendezvous, None)?;
    let exit = supervisor.leaves(LEAVE);
    supervisor.end(Duration::from_millis(300));
    drop(link);
    match exit?.code() {
        Some(0) | None => Err("did not refuse it".into()),
        Some(code) => Ok(format!("left with {code}")),
    }
}
