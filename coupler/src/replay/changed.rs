//! The scene of a log with other values in it, and the solver that is to read it.

use bedload_output::refuse_changed_files;
use bedload_scene::{CheckedScene, SceneSource};
use protocol::log::Manifest;
use protocol::participant::Role;

use super::request::Replay;
use crate::failure::Failure;
use crate::solvers::Solver;

/// Keys of a solver's section that start a program.
const STARTS: [&str; 2] = ["command", "launcher"];

/// The scene that the solver reads, that of a log with `--set`, whose paths count from the current folder;
/// and the solver: ours, or what `--set` names. Fails with [`Failure::Scene`] where a value does not fit,
/// [`Failure::Input`] where a program is named that may not be started, or the number of grains is another
/// one.
pub(super) fn changed(request: &Replay, manifest: &Manifest) -> Result<(CheckedScene, Solver), Failure> {
    let before = SceneSource { file: "the scene in the log".into(), text: manifest.scene.clone() }.files();
    let same_files = |scene: &CheckedScene| match before == scene.source.files() {
        true => refuse_changed_files(scene, &manifest.scene),
        false => Ok(()),
    };
    if request.overrides.is_empty() {
        let scene = logged(request, manifest)?;
        same_files(&scene)?;
        return Ok((scene, Solver::ours(request.drive)));
    }
    let named = SceneSource { file: "the scene in the log".into(), text: without_commands(&manifest.scene) }
        .with_overrides(&request.overrides)?;
    let file = format!("{} (its scene, with --set)", request.log.display());
    let scene = CheckedScene::new(SceneSource { file, text: named.text_for_any_folder().into_owned() })?;
    same_files(&scene)?;
    let solver = solver(request, &scene)?;
    let (found, wanted) = (scene.grains.len(), manifest.grains());
    if found != wanted {
        return Err(Failure::Input(format!(
            "--set gives the scene {found} grains, but every message of {} has {wanted}: leave their number as it is",
            request.log.display()
        )));
    }
    Ok((scene, solver))
}

/// The scene as it was run.
pub(super) fn logged(request: &Replay, manifest: &Manifest) -> Result<CheckedScene, Failure> {
    let file = format!("{} (its scene)", request.log.display());
    Ok(CheckedScene::new(SceneSource { file, text: manifest.scene.clone() })?)
}

/// A scene without the commands in it: a log is data, and may come from anyone.
fn without_commands(text: &str) -> String {
    let Ok(mut scene) = text.parse::<toml::Table>() else { return text.to_owned() };
    for section in [Role::Fluid, Role::Dem] {
        if let Some(section) = scene.get_mut(&section.to_string()).and_then(toml::Value::as_table_mut) {
            section.retain(|key, _| !STARTS.contains(&key));
        }
    }
    scene.to_string()
}

/// Our solver, or the one that `--set` names and that may be started.
fn solver(request: &Replay, scene: &CheckedScene) -> Result<Solver, Failure> {
    let started = |role| {
        let section = if role == Role::Fluid { &scene.scene.fluid } else { &scene.scene.dem };
        STARTS.into_iter().find(|key| section.contains_key(*key)).map(|key| format!("{role}.{key}"))
    };
    let (driven, other) = match request.drive {
        Role::Fluid => (Role::Fluid, Role::Dem),
        Role::Dem => (Role::Dem, Role::Fluid),
    };
    if let Some(key) = started(other) {
        return Err(Failure::Input(format!(
            "--set {key}: the {other} of this replay is the log, and only the {driven} is started; leave the \
             key out, or drive the {other}"
        )));
    }
    let Some(key) = started(driven) else { return Ok(Solver::ours(driven)) };
    let solver = Solver::of(driven, scene)?;
    if !request.allow_commands {
        return Err(Failure::Input(format!(
            "--set {key} would start `{}`: say --allow-commands as well if you trust it",
            solver.run_command().join(" ")
        )));
    }
    Ok(solver)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn commands_of_a_log_are_gone_and_all_else_stays() {
        let text =
            "until = 1.0\n[fluid]\nlauncher = [\"a\"]\ndt = 0.1\n[dem]\ncommand = [\"b\"]\nradius = 2.0\n";
        let table: toml::Table = without_commands(text).parse().unwrap();
        assert_eq!(table["fluid"].as_table().unwrap().len(), 1);
        assert_eq!(table["dem"]["radius"].as_float(), Some(2.0));
        assert!(!table["dem"].as_table().unwrap().contains_key("command"));
    }
}
