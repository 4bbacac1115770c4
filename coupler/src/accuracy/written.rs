//! Settings of the solvers that a scene writes out: those that hold without it, too, are none of its own.

use bedload_program::RunOptions;
use bedload_scene::CheckedScene;
use toml::{Table, Value};

use crate::failure::Failure;
use crate::keys::LUBRICATION;
use crate::prepare::Prepared;
use crate::proposals::Change;

/// A dotted key and its value.
pub(super) type Setting = (String, Value);

/// The settings in a table, whose key is `before`.
pub(super) fn settings(table: &Table, before: &str) -> Vec<Setting> {
    let of = |(key, value): (&String, &Value)| {
        let key = format!("{before}.{key}");
        match value {
            Value::Table(table) => settings(table, &key),
            value => vec![(key, value.clone())],
        }
    };
    table.iter().flat_map(of).collect()
}

/// The first of some settings of a scene without which it would have another one, where `set` holds besides;
/// the first of all where the solvers cannot be asked.
pub(super) fn own<'a>(scene: &CheckedScene, settings: &'a [Setting], set: &[String]) -> Option<&'a Setting> {
    let first = settings.first()?;
    let text = scene.source.text_for_any_folder();
    let options = RunOptions { no_commands: true, ..RunOptions::of_scene(scene.source.file.as_ref()) };
    let with = Change::default().overrides(set.to_vec());
    let without = settings.iter().fold(with.clone(), |change, (key, _)| change.remove(key.as_str()));
    // What holds of films hangs on whether the scene has that section.
    let without_films = without.clone().remove(LUBRICATION);
    let made = |change: &Change| choices(&change.prepared(&text, &options)?.1).ok();
    let (Some(with), Some(without)) = (made(&with), made(&without)) else { return Some(first) };
    let defaults = [Some(without), made(&without_films)];
    let value =
        |of: &[Setting], key: &str| of.iter().find(|(known, _)| known == key).map(|(_, value)| value.clone());
    let is_default = |key: &str| defaults.iter().flatten().any(|of| value(of, key) == value(&with, key));
    settings.iter().find(|(key, _)| !is_default(key))
}

/// Every setting with which a scene is run. What a solver does not resolve is as it is written.
fn choices(prepared: &Prepared) -> Result<Vec<Setting>, Failure> {
    let Prepared { scene, fluid, dem, .. } = prepared;
    let fluid = fluid.as_ref().map(|fluid| &fluid.facts.resolved).filter(|table| !table.is_empty());
    let dem = dem.as_ref().map(|dem| &dem.facts.resolved).filter(|table| !table.is_empty());
    let mut all = settings(fluid.unwrap_or(&scene.scene.fluid), "fluid");
    all.extend(settings(dem.unwrap_or(&scene.scene.dem), "dem"));
    all.extend(settings(&prepared.resolved_coupling()?, "coupling"));
    Ok(all)
}
