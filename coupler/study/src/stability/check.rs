//! The `[stability]` section against its scene.

use bedload_output::Columns;
use bedload_scene::{CheckedScene, SceneError, SceneSource};

use crate::section::{ANY, Section};
use crate::sweep::Column;
use coupler::bounds;
use coupler::plan::Participants;

pub(crate) fn check(section: &Section, scene: &CheckedScene) -> Result<(), SceneError> {
    let wrong = |key: &str, message: &str, remedy: &str| Err(scene.source.error(key, message, remedy));
    if section.vary.is_empty() && section.runs.is_empty() {
        let remedy = "add [[stability.vary]] with key and values, or [[stability.runs]]";
        return wrong("stability", "names no runs", remedy);
    }
    let (bound, names) = (&section.bound, bounds::NAMES);
    if bound != ANY && !names.contains(&bound.as_str()) {
        let message = format!("is {bound:?}, which is no bound; allowed: any, {}", names.join(", "));
        return wrong("stability.bound", &message, "name a bound that `bedload check` prints, or \"any\"");
    }
    for (key, value) in
        [("stability.signal", &section.signal), ("stability.x", &section.x), ("stability.y", &section.y)]
    {
        if value.is_empty() {
            let remedy = "name a column of series.csv as signal, and two varied keys as x and y";
            return wrong(key, "is missing", remedy);
        }
    }
    if let Some(scale) = section.scale.filter(|scale| !(*scale > 0.0 && scale.is_finite())) {
        let message = format!("is {scale}; allowed: a finite number > 0");
        let remedy = "give the size of the signal that counts as whole, or leave it out";
        return wrong("stability.scale", &message, remedy);
    }
    columns(section, scene)
}

/// The columns of `series.csv` that the section names.
fn columns(section: &Section, scene: &CheckedScene) -> Result<(), SceneError> {
    let source = &scene.source;
    let columns = Columns::new(scene, Participants::of(scene).sides());
    let known = |name: &str| columns.names().iter().any(|column| column == name);
    let unknown = |key: &str, name: &str| {
        let there = columns.names().join(", ");
        let message =
            format!("is {name:?}, which is no column of this scene's series.csv; there are {there}");
        source.error(key, message, "name one of these; observe.grains chooses the grains")
    };
    if !known(&section.signal) {
        return Err(unknown("stability.signal", &section.signal));
    }
    for (number, limit) in section.limits.iter().enumerate() {
        let key = format!("stability.limits[{number}]");
        if !known(&limit.column) {
            return Err(unknown(&format!("{key}.column"), &limit.column));
        }
        let until = scene.scene.until;
        let is_longer = section.set.contains_key("until")
            || section.vary.iter().any(|vary| vary.key.is_none() || vary.key.as_deref() == Some("until"))
            || !section.runs.is_empty();
        if limit.from > until && !is_longer {
            let message = format!("is {}, after the end of the runs, until = {until} s", limit.from);
            return Err(source.error(&format!("{key}.from"), message, "give an earlier time"));
        }
        let range = (limit.least.unwrap_or(f64::NEG_INFINITY), limit.most.unwrap_or(f64::INFINITY));
        let bounded = range.0.is_finite() || range.1.is_finite();
        if !(bounded && range.0 < range.1 && limit.from >= 0.0) {
            let message = format!("allows {} to {} from t = {}", range.0, range.1, limit.from);
            let remedy = "give `least`, `most` or both, least < most, and a time `from` ≥ 0";
            return Err(source.error(&key, message, remedy));
        }
    }
    Ok(())
}

/// Numbers of the varied keys along x and y.
pub(crate) fn axes(
    section: &Section,
    columns: &[Column],
    source: &SceneSource,
) -> Result<(usize, usize), SceneError> {
    let x = axis(columns, &section.x, "stability.x", source)?;
    let y = axis(columns, &section.y, "stability.y", source)?;
    if x == y {
        let message = format!("is {:?} as `x` is", section.y);
        let remedy = "name another varied key; one that has a single value will do";
        return Err(source.error("stability.y", message, remedy));
    }
    Ok((x, y))
}

/// Number of the varied key that an axis names, by its name or its key.
fn axis(columns: &[Column], wanted: &str, key: &str, source: &SceneSource) -> Result<usize, SceneError> {
    columns.iter().position(|column| column.name == wanted || column.key == wanted).ok_or_else(|| {
        let names: Vec<&str> = columns.iter().map(|column| column.name.as_str()).collect();
        let message = format!("is {wanted:?}, which does not vary; varied are {}", names.join(", "));
        source.error(key, message, "name one of them")
    })
}
