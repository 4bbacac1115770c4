//! The solvers as commands: where they are, and what they say of themselves.

use std::ffi::OsString;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::process::Stdio;
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use bedload_output::{in_full, resolved_scene};
use bedload_scene::{CheckedScene, SceneError, changing};
use protocol::facts::{DemFacts, FluidFacts};
use protocol::participant::Role;
use serde::de::DeserializeOwned;

use crate::failure::Failure;
use crate::scratch::scratch;
use crate::supervise::{command_of, program};

/// A solver as a command.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Solver {
    pub(crate) role: Role,
    /// Executable and leading arguments.
    pub(crate) command: Vec<String>,
    /// What starts it as several ranks in a run; empty: nothing, it is one process.
    pub(crate) launcher: Vec<String>,
    /// Named by the scene, so perhaps not ours.
    pub(crate) foreign: bool,
}

impl Solver {
    /// The solver of `role`: `command` of its section, or ours beside this program, or on PATH.
    pub(crate) fn of(role: Role, scene: &CheckedScene) -> Result<Self, SceneError> {
        let section = match role {
            Role::Fluid => &scene.scene.fluid,
            Role::Dem => &scene.scene.dem,
        };
        let list = |key: &str, remedy: &str| {
            let read = |value| {
                words(value).ok_or_else(|| {
                    let what = format!("is {value}; allowed: a list of strings, the executable first");
                    scene.source.error(&format!("{role}.{key}"), what, remedy)
                })
            };
            section.get(key).map(read).transpose()
        };
        let mut solver = Self::ours(role);
        if let Some(command) = list("command", "write command = [\"path/to/solver\", \"first argument\"]")? {
            solver = Self { command, foreign: true, ..solver };
        }
        if role == Role::Fluid
            && let Some(launcher) = list("launcher", "write launcher = [\"mpirun\", \"-np\", \"4\"]")?
        {
            solver.launcher = launcher;
        }
        Ok(solver)
    }

    /// What starts it in a run: by its launcher, if it has one.
    pub(crate) fn run_command(&self) -> Vec<String> {
        [&self.launcher[..], &self.command[..]].concat()
    }

    /// Our solver of a role: beside this program, or on PATH.
    pub(crate) fn ours(role: Role) -> Self {
        Self { role, command: vec![sibling(program(role))], launcher: Vec::new(), foreign: false }
    }

    /// Is it the solver of this build, by whatever path the scene names it?
    pub(crate) fn is_ours(&self) -> bool {
        let real = |command: &String| std::fs::canonicalize(command).ok();
        let ours = Self::ours(self.role);
        !self.foreign
            || matches!((&self.command[..], &ours.command[..]), ([command], [own]) if real(command).is_some()
                && real(command) == real(own))
    }

    pub(crate) fn line(&self) -> String {
        self.command.join(" ")
    }

    /// Runs `command arguments…` to its end, at most `limit`, and returns exit code and output.
    fn ask(&self, arguments: &[OsString], limit: Duration) -> Result<Answer, Failure> {
        let (role, command) = (self.role, self.line());
        ask(&self.command, arguments, limit).map_err(|error| {
            Failure::Peer(format!(
                "cannot start the {role} solver `{command}`: {error}; build it beside bedload (cargo build \
                 --release), put it on PATH, or name it in [{role}] command (a path there counts from the \
                 scene's folder)"
            ))
        })
    }

    /// Commands that the scene names are started only where that is allowed.
    fn may_be_asked(&self, ask: Ask) -> bool {
        ask.commands || self.is_ours()
    }

    /// What the solver says of a scene; `None` from a foreign solver that does not know `check`, or that is
    /// not to be asked.
    fn facts<F: DeserializeOwned>(
        &self,
        scene: &CheckedScene,
        path: &Path,
        overrides: &[String],
        ask: Ask,
    ) -> Result<Option<F>, Failure> {
        if !self.may_be_asked(ask) {
            return Ok(None);
        }
        let limit = patience(ask.limit, scene.grains.len());
        if self.is_ours() {
            return self.facts_of(scene, path, overrides, limit);
        }
        let no_room = |what: String| {
            Failure::Run(format!("{what}; free some room there, or name another folder in TMPDIR"))
        };
        let folder = scratch().map_err(no_room)?;
        let path = folder.path().join("scene.toml");
        resolved_scene(&in_full(scene), [None; 3])
            .map_err(|error| error.to_string())
            .and_then(|text| std::fs::write(&path, text).map_err(|error| error.to_string()))
            .map_err(|error| no_room(format!("cannot write {}: {error}", path.display())))?;
        self.facts_of(scene, &path, &[], limit)
    }

    fn facts_of<F: DeserializeOwned>(
        &self,
        scene: &CheckedScene,
        path: &Path,
        overrides: &[String],
        limit: Duration,
    ) -> Result<Option<F>, Failure> {
        let (role, command) = (self.role, self.line());
        let mut arguments: Vec<OsString> = vec!["check".into(), path.into(), "--json".into()];
        for text in overrides {
            arguments.extend(["--set".into(), text.into()]);
        }
        let answer = self.ask(&arguments, limit)?;
        if answer.code == Some(0) {
            return match parse_facts(&answer.stdout, self.foreign.then_some(scene)) {
                Ok(facts) => Ok(Some(facts)),
                // One that prints something else does not know the word.
                Err(_) if self.foreign && !answer.stdout.trim_start().starts_with(['{', '[']) => Ok(None),
                Err(what) => Err(Failure::Run(format!(
                    "`{command} check SCENE --json` of the {role} solver printed no facts: {what}; mend the \
                     solver, or rebuild it with this version of bedload"
                ))),
            };
        }
        // A foreign solver may not know the word; ours, named by `command`, refuses with 2 and says
        // where.
        let refused = answer.code == Some(2) && answer.stderr.contains("remedy:");
        if self.foreign && !refused {
            return Ok(None);
        }
        let (code, words) = (answer.code.unwrap_or(-1), answer.stderr.trim_end());
        let what = format!("the {role} solver refuses the scene (exit code {code}):\n{words}");
        Err(if code == 2 { Failure::Input(what) } else { Failure::Run(what) })
    }

    /// JSON Schema of the solver's section; `None` if it is not there or does not print one.
    pub(crate) fn schema(&self, limit: Duration) -> Option<serde_json::Value> {
        let answer = self.ask(&["schema".into()], limit).ok()?;
        serde_json::from_str(&answer.stdout).ok()
    }
}

/// The time that a solver gets to read a scene: placing grains takes it some 0.1 ms each on a free core.
pub(crate) fn patience(limit: Duration, grains: usize) -> Duration {
    limit + Duration::from_millis(grains as u64)
}

#[derive(Clone, Copy, Debug)]
pub(crate) struct Ask {
    /// Longest time for an answer, that for reading a large scene apart.
    pub(crate) limit: Duration,
    /// May commands that the scene names be started?
    pub(crate) commands: bool,
}

/// What the fluid solver says of the scene; a foreign one that does not know `check`, or that is not to be
/// asked, is described from the scene, with a notice.
pub(crate) fn fluid_facts(
    solver: &Solver,
    scene: &CheckedScene,
    path: &Path,
    overrides: &[String],
    ask: Ask,
) -> Result<FluidFacts, Failure> {
    let (foreign, asked) = (!solver.is_ours(), solver.may_be_asked(ask));
    let mut facts: FluidFacts = match solver.facts(scene, path, overrides, ask)? {
        Some(facts) => facts,
        None => {
            let domain = &scene.scene.domain;
            FluidFacts {
                cells: domain.cell_count() as u64,
                dt: match section_number(scene, "fluid", &scene.scene.fluid, "dt")? {
                    Some(dt) => dt,
                    None if asked => {
                        let what = "its solver does not say what step it needs, and the section has no dt";
                        let remedy = "add dt = …, a positive number of seconds";
                        return Err(scene.source.error("fluid", what, remedy).into());
                    }
                    None => scene.scene.until,
                },
                spacing: domain.smallest_spacing(),
                notices: vec![unknown(solver, asked)],
                ..FluidFacts::default()
            }
        }
    };
    facts.foreign = foreign;
    if asked && !facts.values_over_time {
        refuse_changes(solver, scene, |key| !key.starts_with("walls") && !key.starts_with("grains"))?;
    }
    if foreign {
        facts.notices.push(format!(
            "the fluid solver `{}` is not ours: density-ratio, density-range and resolution were measured \
             with ours and are not judged; with which grains it is stable is not known",
            solver.line()
        ));
    }
    Ok(facts)
}

/// As [`fluid_facts`], of the DEM. Where it gives no contact time, that of the scene counts.
pub(crate) fn dem_facts(
    solver: &Solver,
    scene: &CheckedScene,
    path: &Path,
    overrides: &[String],
    ask: Ask,
) -> Result<DemFacts, Failure> {
    let (asked, known) = (solver.may_be_asked(ask), solver.facts(scene, path, overrides, ask)?);
    if solver.is_ours()
        && let Some(facts) = known
    {
        return Ok(facts);
    }
    let section = &scene.scene.dem;
    let number = |key: &str| section_number(scene, "dem", section, key);
    let mut facts = known.unwrap_or(DemFacts {
        grains: scene.grains.len() as u64,
        dt: number("dt")?.unwrap_or(f64::INFINITY),
        contact_time: f64::INFINITY,
        // It does not say from what gap it acts: nothing is far enough for a single sub-step.
        interaction_range: number("interaction_range")?.unwrap_or(f64::INFINITY),
        notices: vec![unknown(solver, asked)],
        ..DemFacts::default()
    });
    if asked && !facts.values_over_time {
        refuse_changes(solver, scene, |key| !key.starts_with("medium"))?;
    }
    if scene.scene.observe.substeps.is_some() {
        let (line, what) = (solver.line(), "observe.substeps: bedload-dem writes it");
        facts.notices.push(format!("{what}, the dem solver `{line}` need not"));
    }
    // The scene's own word binds whoever reads it.
    let of_scene = match section.get("contact") {
        Some(toml::Value::Table(contact)) => section_number(scene, "dem.contact", contact, "contact_time")?,
        _ => None,
    };
    let own = Some(facts.contact_time).filter(|own| *own > 0.0).unwrap_or(f64::INFINITY);
    facts.contact_time = own.min(of_scene.unwrap_or(f64::INFINITY));
    let can_touch = scene.grains.len() > 1 || !scene.contact_walls().is_empty();
    if facts.contact_time.is_finite() || !can_touch {
        return Ok(facts);
    }
    let key = "dem.contact.contact_time";
    if asked {
        let what = format!(
            "is missing, and the dem solver `{}` does not say how long a contact lasts: without it nothing \
             holds its sub-steps far below it",
            solver.line()
        );
        let remedy = "add [dem.contact] contact_time = …, the shortest duration of a contact in seconds, or \
            let the solver answer `check SCENE --json`";
        return Err(Box::new(scene.source.error(key, what, remedy)).into());
    }
    if !facts.dt.is_finite() {
        facts.dt = scene.scene.until;
    }
    facts.notices.push(format!("t_c, and every bound with it, is not known: {key} is not in the scene"));
    Ok(facts)
}

/// A solver that does not say that it follows values over time would go on with the first of them.
fn refuse_changes(
    solver: &Solver,
    scene: &CheckedScene,
    concerns: impl Fn(&str) -> bool,
) -> Result<(), Failure> {
    let Some(value) = changing(scene).into_iter().find(|value| concerns(&value.key)) else { return Ok(()) };
    let what = format!(
        "changes over time, and the {} solver `{}` does not say that it follows such values",
        solver.role,
        solver.line()
    );
    let remedy = "give a constant, or let the solver read the value (docs/coupling.md) and answer `check SCENE \
        --json` with values_over_time = true";
    Err(Box::new(scene.source.error(&value.key, what, remedy)).into())
}

fn unknown(solver: &Solver, asked: bool) -> String {
    let (role, line) = (solver.role, solver.line());
    let why = if asked {
        "does not answer `check SCENE --json`"
    } else {
        "was not started (`check --allow-commands` asks it)"
    };
    format!(
        "the {role} solver `{line}` {why}: it is planned from the scene alone, and bounds that need its \
         facts are not checked"
    )
}

/// A positive number that a section holds for a solver that says nothing of itself.
fn section_number(
    scene: &CheckedScene,
    section: &str,
    table: &toml::Table,
    key: &str,
) -> Result<Option<f64>, Box<SceneError>> {
    let Some(value) = table.get(key) else { return Ok(None) };
    let number = value.as_float().or(value.as_integer().map(|whole| whole as f64));
    number.filter(|number| *number > 0.0 && number.is_finite()).map(Some).ok_or_else(|| {
        let what = format!("is {value}; allowed: a finite number > 0");
        Box::new(scene.source.error(&format!("{section}.{key}"), what, "give a positive number"))
    })
}

/// A program beside this one, or its bare name, which the system looks for on PATH.
fn sibling(name: &str) -> String {
    let beside = std::env::current_exe().ok().and_then(|own| own.parent().map(|folder| folder.join(name)));
    match beside.filter(|path: &PathBuf| path.is_file()) {
        Some(path) => path.display().to_string(),
        None => name.to_owned(),
    }
}

fn words(value: &toml::Value) -> Option<Vec<String>> {
    let list = value.as_array()?;
    let words: Option<Vec<String>> = list.iter().map(|word| word.as_str().map(str::to_owned)).collect();
    words.filter(|words| !words.is_empty())
}

/// Facts as printed. JSON writes an infinite number as `null`; TOML, through which they are read,
/// has both. Those of a solver of another are judged by the scene that it was asked about.
fn parse_facts<F: DeserializeOwned>(text: &str, judged: Option<&CheckedScene>) -> Result<F, String> {
    let json: serde_json::Value = serde_json::from_str(text).map_err(|error| error.to_string())?;
    let toml::Value::Table(table) = to_toml(json) else {
        return Err("they are no object, `{\"KEY\": VALUE, …}`".to_owned());
    };
    judged.map_or(Ok(()), |scene| judge(&table, scene))?;
    table.try_into().map_err(|error: toml::de::Error| error.to_string().trim_end().replace('\n', " "))
}

/// Refuses numbers that cannot be; a key that is not there says nothing.
fn judge(facts: &toml::Table, scene: &CheckedScene) -> Result<(), String> {
    let number = |key: &str| {
        let value = facts.get(key)?;
        value.as_float().or(value.as_integer().map(|whole| whole as f64))
    };
    let wrong = |key: &str, value: f64, allowed: &str| Err(format!("{key} is {value:?}; allowed: {allowed}"));
    for key in ["dt", "contact_time", "spacing"] {
        if let Some(value) = number(key).filter(|value| value.is_nan() || *value <= 0.0) {
            return wrong(key, value, "a positive number, null for an infinite one");
        }
    }
    for key in ["cfl", "cfl_limit", "step_cost", "substep_cost", "interaction_range"] {
        if let Some(value) = number(key).filter(|value| value.is_nan() || *value < 0.0) {
            return wrong(key, value, "a number from 0 on, null for an infinite one");
        }
    }
    let grains = scene.grains.len();
    if let Some(value) = number("grains").filter(|value| *value != grains as f64) {
        return wrong("grains", value, &format!("{grains}, as many as the scene has"));
    }
    let (far, range) = (FAR * diagonal(scene), "interaction_range");
    let beyond = number(range).filter(|value| *value > far && value.is_finite());
    beyond.map_or(Ok(()), |it| wrong(range, it, &format!("at most {far}, null where it is not known")))
}

/// Of the box, m.
pub(crate) fn diagonal(scene: &CheckedScene) -> f64 {
    let domain = &scene.scene.domain;
    (0..domain.dimensions()).map(|axis| domain.upper[axis] - domain.lower[axis]).fold(0.0, f64::hypot)
}

/// How many boxes away something may be that a solver speaks of.
pub(crate) const FAR: f64 = 1e6;

fn to_toml(json: serde_json::Value) -> toml::Value {
    use serde_json::Value;
    match json {
        Value::Null => toml::Value::Float(f64::INFINITY),
        Value::Bool(value) => value.into(),
        Value::String(text) => text.into(),
        Value::Number(number) => match number.as_i64() {
            Some(whole) => whole.into(),
            None => number.as_f64().unwrap_or(f64::NAN).into(),
        },
        Value::Array(items) => items.into_iter().map(to_toml).collect::<Vec<_>>().into(),
        Value::Object(map) => {
            toml::Value::Table(map.into_iter().map(|(key, value)| (key, to_toml(value))).collect())
        }
    }
}

struct Answer {
    /// None: killed, or out of time.
    code: Option<i32>,
    stdout: String,
    stderr: String,
}

fn ask(command: &[String], arguments: &[OsString], limit: Duration) -> std::io::Result<Answer> {
    let mut asked = command_of(command, arguments)?;
    protocol::detail!("bedload: asks {asked:?}");
    let mut child = asked.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn()?;
    let (stdout, stderr) = (read_all(child.stdout.take()), read_all(child.stderr.take()));
    if stdout.is_err() || stderr.is_err() {
        child.kill()?;
        child.wait()?;
    }
    let (stdout, stderr) = (stdout?, stderr?);
    let start = Instant::now();
    let status = loop {
        if let Some(status) = child.try_wait()? {
            break Some(status);
        }
        if start.elapsed() >= limit {
            child.kill()?;
            child.wait()?;
            break None;
        }
        std::thread::sleep(Duration::from_millis(1));
    };
    let text = |thread: JoinHandle<String>| thread.join().unwrap_or_default();
    let (stdout, mut stderr) = (text(stdout), text(stderr));
    if status.is_none() {
        stderr += &format!("no answer within {} s", limit.as_secs_f64());
    }
    Ok(Answer { code: status.and_then(|status| status.code()), stdout, stderr })
}

/// Bytes of an answer that are kept: facts are some thousands.
const LONGEST_ANSWER: u64 = 64 << 20;

/// Reads a pipe to its end in a thread of its own.
fn read_all(pipe: Option<impl Read + Send + 'static>) -> std::io::Result<JoinHandle<String>> {
    std::thread::Builder::new().spawn(move || {
        let mut bytes = Vec::new();
        if let Some(mut pipe) = pipe {
            // What was read before an error is still worth showing. The rest is read, too, so that its writer
            // ends.
            let _ = pipe.by_ref().take(LONGEST_ANSWER).read_to_end(&mut bytes);
            let _ = std::io::copy(&mut pipe, &mut std::io::sink());
        }
        String::from_utf8_lossy(&bytes).into_owned()
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_scenes::two_grains;
    use protocol::facts::{Measure, Side, SolverBound};

    #[test]
    fn an_infinite_fact_survives_json() {
        let facts = DemFacts {
            dt: 1e-4,
            contact_time: f64::INFINITY,
            bounds: vec![SolverBound {
                void_from: Some((Measure::WindowOverContact, 10.0)),
                ..SolverBound::new("lift", "dt_dem", (1.0, Measure::Substep), Side::AtMost, 1e-3)
            }],
            ..DemFacts::default()
        };
        let read: DemFacts = parse_facts(&serde_json::to_string(&facts).unwrap(), None).unwrap();
        assert_eq!(read, facts);
        let fluid: FluidFacts =
            parse_facts(r#"{"dt": 1, "cells": 12, "schemes": ["explicit"], "resolved": {"dt": 0.5}}"#, None)
                .unwrap();
        assert_eq!(
            (fluid.dt, fluid.cells, fluid.schemes()),
            (1.0, 12, &[protocol::scheme::Scheme::Explicit][..])
        );
        assert_eq!(fluid.resolved["dt"].as_float(), Some(0.5));
        assert!(parse_facts::<DemFacts>("not json", None).is_err());
    }

    #[test]
    fn facts_that_cannot_be_are_refused_by_their_key() {
        for (text, words) in [
            (r#"[2, 0, 0.1]"#, "no object"),
            (r#"{"contact_time": "0.1"}"#, "contact_time"),
            (r#"{"contact_time": -1}"#, "contact_time is -1.0; allowed: a positive"),
            (r#"{"contact_time": 0.0}"#, "contact_time is 0.0"),
            (r#"{"dt": -1e-3}"#, "dt is -0.001"),
            (r#"{"interaction_range": -1}"#, "interaction_range is -1.0"),
            (r#"{"interaction_range": 1e300}"#, "interaction_range is 1e300"),
            (r#"{"grains": 7}"#, "grains is 7.0; allowed: 2"),
            (r#"{"grains": 2.5}"#, "grains is 2.5"),
            (r#"{"substep_cost": -1}"#, "substep_cost is -1.0"),
        ] {
            let error = parse_facts::<DemFacts>(text, Some(&two_grains())).expect_err(text);
            assert!(error.contains(words), "{text}: {error}");
        }
        for text in [r#"{"contact_time": null, "interaction_range": null}"#, r#"{"grains": 2}"#, "{}"] {
            parse_facts::<DemFacts>(text, Some(&two_grains())).expect(text);
        }
    }

    #[test]
    fn a_foreign_solver_that_knows_no_values_over_time_is_refused() {
        let tilted = "gravity=[[0.0, [0.0, 0.0, -1.0]], [1.0, [1.0, 0.0, -1.0]]]".to_owned();
        let pushed = "medium={ density = 1.0, viscosity = 1.0, body_force = { amplitude = [1.0, 0.0, 0.0], \
            frequency = 1.0 } }";
        let cells = "domain.cells=[16, 16, 16]".to_owned();
        let source = two_grains().source;
        let with = |changes: &[String]| {
            CheckedScene::new(source.clone().with_overrides(changes).expect("fits")).expect("a scene")
        };
        let ask = Ask { limit: Duration::from_secs(20), commands: true };
        let says = |answer: &str| Solver {
            role: Role::Dem,
            command: ["sh", "-c", &format!("echo '{answer}'")].map(str::to_owned).into(),
            launcher: Vec::new(),
            foreign: true,
        };
        let facts = |answer: &str, scene: &CheckedScene| {
            dem_facts(&says(answer), scene, Path::new("s.toml"), &[], ask).map_err(|error| error.to_string())
        };
        let (knows, knows_not) =
            (r#"{"contact_time": 1, "values_over_time": true}"#, r#"{"contact_time": 1}"#);
        let tilted = with(&[tilted]);
        let error = facts(knows_not, &tilted).expect_err("it takes the first gravity");
        assert!(error.contains("gravity") && error.contains("does not say that it follows"), "{error}");
        assert!(facts(knows, &tilted).is_ok_and(|facts| facts.values_over_time));
        // The fluid's own is no matter of a DEM's.
        assert!(facts(knows_not, &with(&[pushed.to_owned(), cells])).is_ok());
    }

    #[test]
    fn a_solver_that_does_not_answer_is_given_up() {
        let command = ["sh".to_owned(), "-c".to_owned(), "exec sleep 20".to_owned()];
        let start = Instant::now();
        let answer = ask(&command, &[], Duration::from_millis(100)).unwrap();
        assert!(answer.code.is_none() && start.elapsed() < Duration::from_secs(2));
        assert!(answer.stderr.contains("no answer"));
    }
}
