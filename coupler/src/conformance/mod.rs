//! `bedload conformance -- COMMAND…`: any solver command against the protocol of a coupled run, role by role.
//!
//! This process is the coupler and the other solver; COMMAND is started as `bedload run` would start it, once
//! for each case. A role that it does not take is passed over.
//!
//! | file | what it holds |
//! |---|---|
//! | `cases` | what a solver has to do |
//! | `physics` | what a DEM does with grains, on scenes of their own |
//! | `bench` | the solver under test, and its windows |

mod bench;
mod cases;
mod physics;

use std::path::{Path, PathBuf};
use std::time::Instant;

use bedload_program::RunOptions;
use clap::Args;
use protocol::channel::remove_stale_runs;
use protocol::participant::Role;
use serde::Serialize;

use crate::coupled::write_scene;
use crate::failure::Failure;
use crate::prepare::Prepared;
use crate::scratch::scratch;
use crate::solo_run::Setup;
use crate::supervise::role;
use bench::Bench;
use cases::CASES;
use physics::TRIALS;

/// Longest time to join in a role that nobody said the command takes, s.
const PROBE: f64 = 5.0;

/// The scene that a solver is given where no other is named.
const SCENE: &str = include_str!("scene.toml");

/// What is asked for.
#[derive(Clone, Debug, Args)]
pub struct Options {
    /// Only this role; by default each role that the command takes
    #[arg(long, value_parser = role())]
    pub role: Option<Role>,
    /// Scene with a fluid and free grains; by default two spheres apart in a closed box
    #[arg(long)]
    pub scene: Option<PathBuf>,
    /// Override any key of the scene; may be repeated
    #[arg(long = "set", value_name = "KEY=VALUE")]
    pub overrides: Vec<String>,
    /// Hold a DEM also against what is exact: fall, bounce, rest, collision, spin
    #[arg(long)]
    pub physics: bool,
    /// Print the results as JSON
    #[arg(long)]
    pub json: bool,
    /// The solver: executable and leading arguments, after --
    #[arg(required = true, last = true)]
    pub command: Vec<String>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
enum Outcome {
    Pass,
    Fail,
    /// Not passed, and not needed.
    Lacks,
}

impl Outcome {
    fn word(self) -> &'static str {
        match self {
            Self::Pass => "pass",
            Self::Fail => "FAIL",
            Self::Lacks => "lacks",
        }
    }
}

#[derive(Clone, Debug, Serialize)]
struct Played {
    name: &'static str,
    about: &'static str,
    outcome: Outcome,
    /// What was seen, or what was wrong.
    seen: String,
    seconds: f64,
}

#[derive(Clone, Debug, Serialize)]
struct Report {
    role: Role,
    /// Why the role was passed over.
    #[serde(skip_serializing_if = "Option::is_none")]
    passed_over: Option<String>,
    cases: Vec<Played>,
}

/// Tests a solver and prints what it does.
///
/// # Errors
/// [`Failure::Run`] if it fails a case that is needed or takes no role, [`Failure::Scene`] for a bad scene.
pub fn conformance(options: &Options) -> Result<(), Failure> {
    if let Err(error) = remove_stale_runs() {
        protocol::say!("bedload: warning: cannot remove what dead runs left: {error}");
    }
    let folder = scratch().map_err(Failure::Run)?;
    if options.physics && options.role == Some(Role::Fluid) {
        let what = "--physics bounces spheres of a DEM: give --role dem with it, or leave --role out";
        return Err(Failure::Input(what.into()));
    }
    // a scene that is at fault by itself is no fault of the solver
    if let Some(scene) = &options.scene {
        RunOptions { overrides: options.overrides.clone(), ..RunOptions::of_scene(scene) }.read_scene()?;
    }
    let roles = options.role.map_or_else(|| vec![Role::Fluid, Role::Dem], |role| vec![role]);
    let mut reports = Vec::new();
    for role in roles {
        let mut report = try_role(options, role, folder.path())?;
        if options.physics && role == Role::Dem && report.passed_over.is_none() {
            try_physics(options, &mut report, folder.path());
        }
        reports.push(report);
    }
    if options.json {
        println!(
            "{}",
            serde_json::to_string_pretty(&reports).map_err(|error| Failure::Run(error.to_string()))?
        );
    }
    conclude(&reports)
}

fn try_role(options: &Options, role: Role, folder: &Path) -> Result<Report, Failure> {
    let mut report = Report { role, passed_over: None, cases: Vec::new() };
    let built_in = folder.join("scene.toml");
    put(&built_in, SCENE)?;
    let scene = options.scene.as_deref().unwrap_or(&built_in);
    let bench = match bench(options, role, scene, &folder.join(role.to_string())) {
        Ok(bench) => bench,
        Err(failure) if options.role.is_some() => return Err(failure),
        Err(failure) => {
            pass_over(options, &mut report, &failure.to_string());
            return Ok(report);
        }
    };
    for (number, case) in CASES.iter().enumerate() {
        let begin = Instant::now();
        let (outcome, seen) = match (case.play)(&bench) {
            Ok(seen) => (Outcome::Pass, seen),
            Err(wrong) if number == 0 && options.role.is_none() => {
                pass_over(options, &mut report, &wrong);
                return Ok(report);
            }
            Err(wrong) => (if case.needed { Outcome::Fail } else { Outcome::Lacks }, wrong),
        };
        let seconds = begin.elapsed().as_secs_f64();
        report.add(options, Played { name: case.name, about: case.about, outcome, seen, seconds });
        // One that cannot join fails all cases for the same reason.
        if number == 0 && outcome == Outcome::Fail {
            break;
        }
    }
    Ok(report)
}

/// Holds a DEM against what is exact. One that refuses a scene lacks what is in it.
fn try_physics(options: &Options, report: &mut Report, folder: &Path) {
    // What was said of the grains of another scene is not meant for these.
    let kept = |text: &&String| text.starts_with("dem.") || text.starts_with("coupling.");
    let overrides = options.overrides.iter().filter(kept).cloned().collect();
    let options = &Options { overrides, ..options.clone() };
    for trial in &TRIALS {
        let begin = Instant::now();
        let path = folder.join(format!("{}.toml", trial.name));
        let bench = put(&path, &trial.scene())
            .and_then(|()| bench(options, Role::Dem, &path, &folder.join(trial.name)));
        let (outcome, seen) = match bench {
            Err(failure) => (Outcome::Lacks, failure.to_string()),
            Ok(bench) => match trial.play(&bench) {
                Ok(seen) => (Outcome::Pass, seen),
                Err(wrong) => (Outcome::Fail, wrong),
            },
        };
        let seconds = begin.elapsed().as_secs_f64();
        report.add(options, Played { name: trial.name, about: trial.about, outcome, seen, seconds });
    }
}

impl Report {
    /// Takes a case, and prints it.
    fn add(&mut self, options: &Options, case: Played) {
        if !options.json {
            protocol::show!("{:5}  {:5}  {:14}  {}", self.role, case.outcome.word(), case.name, case.seen);
            if case.outcome != Outcome::Pass {
                println!("{:30}wanted: {}", "", case.about);
            }
        }
        self.cases.push(case);
    }
}

fn put(path: &Path, text: &str) -> Result<(), Failure> {
    std::fs::write(path, text)
        .map_err(|error| Failure::Run(format!("cannot write {}: {error}", path.display())))
}

fn pass_over(options: &Options, report: &mut Report, why: &str) {
    if !options.json {
        protocol::show!("{:5}  passed over: {why}", report.role);
    }
    report.passed_over = Some(why.to_owned());
}

/// Reads and resolves the scene with the command as the solver of `role`.
fn bench(options: &Options, role: Role, scene: &Path, out: &Path) -> Result<Bench, Failure> {
    let command: Vec<String> =
        options.command.iter().enumerate().map(|(place, word)| from_here(place, word)).collect();
    let command = serde_json::to_string(&command).map_err(|error| Failure::Run(error.to_string()))?;
    let mut overrides = options.overrides.clone();
    overrides.push(format!("{role}.command={command}"));
    let run = RunOptions { overrides, out: Some(out.to_owned()), ..RunOptions::of_scene(scene) };
    let prepared = Prepared::new(&run)?;
    if prepared.fluid.is_none() || prepared.dem.is_none() {
        return Err(Failure::Input(
            "the scene needs one solver only; give one with [medium] and at least one grain that is free"
                .into(),
        ));
    }
    let output = run.folder(&prepared.scene)?;
    write_scene(&prepared, &output)?;
    let file = if prepared.has_others() { output.scene_in_full() } else { output.scene() };
    let patience = prepared.coupling.startup_deadline;
    let join_s = if options.role.is_none() { patience.min(PROBE) } else { patience };
    Ok(Bench {
        dt: prepared.plan.steps.dt_fluid,
        plain: options.scene.is_none(),
        setup: Setup {
            role,
            command: options.command.clone(),
            scene: prepared.scene,
            coupling: prepared.coupling,
            file,
            join_s,
            folder: output,
        },
    })
}

/// A word of the command line that names a file counts from here, not from the folder of the scene that it
/// goes into.
fn from_here(place: usize, word: &str) -> String {
    let is_path = if place == 0 { word.contains('/') } else { Path::new(word).is_file() };
    let whole = if is_path { std::path::absolute(word).ok() } else { None };
    whole.map_or_else(|| word.to_owned(), |path| path.display().to_string())
}

/// Counts, and fails where something needed is missing.
fn conclude(reports: &[Report]) -> Result<(), Failure> {
    let count = |outcome| {
        reports.iter().flat_map(|report| &report.cases).filter(|case| case.outcome == outcome).count()
    };
    let (passed, failed, lacking) = (count(Outcome::Pass), count(Outcome::Fail), count(Outcome::Lacks));
    protocol::say!("bedload: {passed} passed, {failed} failed, {lacking} that are not needed lack");
    if reports.iter().all(|report| report.passed_over.is_some()) {
        return Err(Failure::Run(
            "the command takes neither role: name one with --role to see all that is wrong".into(),
        ));
    }
    match failed {
        0 => Ok(()),
        _ => Err(Failure::Run(format!("{failed} of the cases that a solver must pass failed"))),
    }
}
