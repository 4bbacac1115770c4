//! An output folder filled from formulas: a sphere that settles, bounces and rests, with a vortex
//! ring around it.

use std::path::{Path, PathBuf};

use bedload_output::{Observer, OutputFolder, Sample, Sides, Summary};
use bedload_scene::{CheckedScene, SceneSource};
use protocol::message::{Kinematics, Loads};
use protocol::participant::Window;

use super::fields;

/// Radius, gravity, densities, terminal speed: those of no experiment.
pub(crate) const R: f64 = 0.5;
const G: f64 = 1.0;
const VOLUME: f64 = 4.0 / 3.0 * std::f64::consts::PI * R * R * R;
const START: f64 = 11.0;
const V_T: f64 = 1.2;
const DT: f64 = 0.004;
const CONTACT: f64 = 0.02;
const E: f64 = 0.6;

pub(crate) const SCENE: &str = r#"
title = "Test data: a <bounce> & \"more\""
source = "a formula, not a run"
until = 14.0
gravity = [0.0, 0.0, -1.0]
[domain]
geometry = "axisymmetric"
lower = [0.0, 0.0]
upper = [4.0, 13.0]
cells = [40, 130]
[domain.boundary]
r_upper = "free-slip"
z_lower = "no-slip"
z_upper = "free-slip"
[medium]
density = 1.0
viscosity = 0.02
[[grains]]
position = [0.0, 0.0, 11.5]
radius = 0.5
density = 8.0
[[metrics]]
name = "rebound_velocity_ratio"
kind = "rebound-velocity-ratio"
reference = 0.55
source = "<none>"
[[metrics]]
name = "second_height"
kind = "second-rebound-height"
[[metrics]]
name = "stokes"
kind = "stokes"
"#;

/// A folder below the system's temporary one, filled with the sample.
pub(crate) fn folder(name: &str) -> PathBuf {
    let root = std::env::temp_dir().join(format!("bedload-report-{}-{name}", std::process::id()));
    let _ = std::fs::remove_dir_all(&root);
    fill(&root);
    root
}

pub(crate) fn fill(root: &Path) {
    let scene = SceneSource { file: "test.toml".into(), text: SCENE.into() };
    let scene = CheckedScene::new(scene).expect("the scene of this test");
    let folder = OutputFolder::create(root, &scene, false).expect("a folder");
    let mut observer = Observer::create(&folder, &scene, Sides::coupled()).expect("an observer");
    let way = way(scene.scene.until);
    for (step, motion) in way.iter().enumerate() {
        let substeps = if motion.contact_force[2] > 0.0 { 40 } else { 25 + (step % 3) as u64 };
        let window =
            Window { step: step as u64, attempt: 0, time: step as f64 * DT, dt: DT, substeps, output: false };
        let mut header = window.header();
        (header.substeps, header.smallest_gap) = (substeps, motion.gap);
        let loads = [Loads { force: [0.0, 0.0, drag(motion.velocity[2])], ..Loads::default() }];
        let kinematics = std::slice::from_ref(motion);
        let sample = Sample { window: &window, loads: &loads, header: &header, kinematics, extras: &[] };
        observer.record(&sample).expect("a window");
        if step % 250 == 249 {
            fields::write(&folder.fields(), step, (step + 1) as f64 * DT, motion);
        }
    }
    let mut summary = Summary::new(&scene, "0.0.0-test");
    observer.finish(&mut summary, CONTACT).expect("the end");
    let cost = &mut summary.cost;
    (cost.wall_s, cost.fluid_cpu_s, cost.dem_cpu_s) = (61.0, 48.0, 6.5);
    (cost.coupler_cpu_s, cost.exchange_s, cost.record_s) = (0.4, 1.1, 0.25);
    cost.peak_rss_bytes.fluid = Some(300 << 20);
    summary.set_unit_costs(1);
    summary.write(&folder.summary()).expect("a summary");
    std::fs::write(folder.plan(), PLAN).expect("a plan");
}

/// Drag and buoyancy on the sphere; at the terminal speed they carry its weight.
fn drag(velocity: f64) -> f64 {
    let ratio = velocity / V_T;
    VOLUME * G * (1.0 - 7.0 * ratio * ratio.abs())
}

/// Settles towards V_T under 0.8 g, bounces with restitution E in one window, rests at last.
fn way(until: f64) -> Vec<Kinematics> {
    let (mut z, mut v, mut resting) = (START, 0.0f64, false);
    (0..(until / DT) as usize)
        .map(|_| {
            let mut motion = Kinematics { orientation: [1.0, 0.0, 0.0, 0.0], ..Kinematics::default() };
            let ratio = v / V_T;
            v -= DT * 0.8 * G * (1.0 + ratio * ratio.abs());
            z += DT * v;
            if !resting && z < 0.0 && v < 0.0 {
                resting = v > -0.05;
                motion.impact_speed = -v;
                motion.rebound_speed = if resting { 0.0 } else { -v * E };
                motion.contact_force[2] = 8.0 * VOLUME * (motion.rebound_speed - v) / DT;
                (v, z) = (motion.rebound_speed, 0.0);
            }
            if resting {
                (v, z) = (0.0, -1e-4);
                motion.contact_force[2] = 7.0 * VOLUME * G;
            }
            if (0.0..0.5 * R).contains(&z) {
                motion.lubrication_force[2] = -0.4 * v / (z + 0.01);
            }
            (motion.position[2], motion.velocity[2], motion.gap) = (z + R, v, z);
            motion
        })
        .collect()
}

const PLAN: &str = r#"{
  "dt_fluid": 0.004, "dt_dem": 0.00016, "substeps": 25, "contact_time": 0.02, "windows": 3500, "until": 14.0,
  "bounds": [
    { "name": "cfl", "quantity": "|u| dt/dx", "value": 0.41, "side": "at-most", "limit": 0.5, "margin": 1.22,
      "holds": true, "level": "refuse", "why": "", "source": "Courant et al. 1928", "remedy": "" },
    { "name": "contact-steps", "quantity": "t_c/dt_dem", "value": 15.0, "side": "at-least", "limit": 20.0,
      "margin": 0.75, "holds": false, "level": "warn", "why": "", "source": "<b>", "remedy": "" }
  ]
}"#;
