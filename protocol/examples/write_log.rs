//! Writes a log of grains that settle with Stokes drag, and prints what recording cost.
//!
//! `cargo run --release -p bedload-protocol --example write_log -- LOG [WINDOWS] [GRAINS] [WINDOW_US]`:
//! with WINDOW_US each window also takes that long, as a solver would.

use std::time::{Duration, Instant};

use protocol::log::{Manifest, Recorder, RecorderOptions};
use protocol::message::{Header, Kinematics, Loads, Order, State, Status};
use protocol::participant::{Role, Window};

const DT: f64 = 1e-3;
const RADIUS: f64 = 1e-3;
const SUBSTEPS: u64 = 20;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut arguments = std::env::args().skip(1);
    let path = arguments.next().ok_or("usage: write_log LOG [WINDOWS] [GRAINS] [WINDOW_US]")?;
    let mut number = |default: u64| arguments.next().map_or(Ok(default), |word| word.parse());
    let (windows, grains, pause) = (number(200)?, number(5)?, number(0)?);
    let manifest = Manifest::new(
        "grains settling with Stokes drag",
        "title = \"grains settling with Stokes drag\"\n",
        vec![RADIUS; usize::try_from(grains)?],
        DT,
        windows as f64 * DT,
    );
    let recorder = Recorder::create(path.as_ref(), &manifest, RecorderOptions::default())?;
    let begin = Instant::now();
    run(&recorder, &manifest, windows, Duration::from_micros(pause))?;
    let wall = begin.elapsed().as_secs_f64();
    let cost = recorder.finish()?;
    let per_window = 1e6 / windows as f64;
    println!(
        "{windows} windows, {grains} grains, {} messages, {} bytes; per window: wall {:.1} us, \
         calls {:.2} us, recorder's thread {:.2} us",
        cost.messages,
        cost.bytes,
        wall * per_window,
        cost.call_s * per_window,
        cost.write_s * per_window
    );
    Ok(())
}

fn run(
    recorder: &Recorder,
    manifest: &Manifest,
    windows: u64,
    pause: Duration,
) -> Result<(), Box<dyn std::error::Error>> {
    let mut grains = vec![Kinematics::default(); manifest.grains()];
    for (index, grain) in grains.iter_mut().enumerate() {
        grain.position = [4.0 * RADIUS * index as f64, 0.0, 0.1];
        grain.orientation = [1.0, 0.0, 0.0, 0.0];
    }
    let mut loads = vec![Loads::default(); grains.len()];
    for step in 0..windows {
        let time = step as f64 * DT;
        let window = Window { step, attempt: 0, time, dt: DT, substeps: SUBSTEPS, output: false };
        recorder.record_command(&window.command(Order::Advance))?;
        let header = settle(&window, &mut grains, &mut loads);
        std::thread::sleep(pause);
        recorder.record_loads(&window.header(), &loads)?;
        recorder.record_kinematics(&header, &grains)?;
        recorder.record_status(Role::Fluid, &status(&window, 2.0 * DT))?;
        recorder.record_status(Role::Dem, &status(&window, f64::INFINITY))?;
        recorder.record_command(&window.command(Order::Accept))?;
    }
    Ok(())
}

/// Unit mass over unit drag: v' = −g − v/τ, exact over a window.
fn settle(window: &Window, grains: &mut [Kinematics], loads: &mut [Loads]) -> Header {
    let (g, tau) = (9.81, 0.05);
    let decay = (-window.dt / tau).exp();
    for (grain, load) in grains.iter_mut().zip(loads) {
        load.force = [0.0, 0.0, -grain.velocity[2] / tau];
        grain.velocity[2] = -g * tau + (grain.velocity[2] + g * tau) * decay;
        grain.position[2] += window.dt * grain.velocity[2];
        grain.gap = grain.position[2] - RADIUS;
    }
    Header { substeps: window.substeps, smallest_gap: 2.0 * RADIUS, ..window.header() }
}

fn status(window: &Window, dt_limit: f64) -> Status {
    let (step, attempt) = (window.step, window.attempt);
    Status { state: State::Done as u64, step, attempt, dt_limit, ..Status::default() }
}
