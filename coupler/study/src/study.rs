//! A study: its section, read and checked, and the runs that it asks for.

use std::path::{Component, Path, PathBuf};

use bedload_scene::{CheckedScene, Metric, SceneError, SceneSource};

use super::case::check as case_check;
use super::chart::check as chart_check;
use super::kind::Kind;
use super::section::Section;
use super::stability::check as stability_check;
use super::sweep::{Column, Point, Sweep};
use super::vary::SingleRun;

/// A study whose runs are laid out.
#[derive(Clone, Debug)]
pub struct Study {
    /// What is made of its runs.
    pub kind: Kind,
    /// The file: a scene, but for a case.
    pub source: SceneSource,
    /// As written.
    pub section: Section,
    /// Metrics of the scene of a chart or a map.
    pub metrics: Vec<Metric>,
    /// Varied keys.
    pub columns: Vec<Column>,
    /// The runs.
    pub points: Vec<Point>,
}

impl Study {
    /// Reads the section of this kind in a file. `quick`: of a case, only the runs of `--quick`.
    ///
    /// # Errors
    /// [`SceneError`] at the key that is missing, unknown or out of range.
    pub fn read(path: &Path, kind: Kind, quick: bool) -> Result<Self, SceneError> {
        let source = SceneSource::read(path, &[])?;
        match kind {
            Kind::Case => Self::of_case(source, path, quick),
            Kind::Chart | Kind::Stability => Self::of_scene(&CheckedScene::new(source)?, path, kind),
        }
    }

    /// The study that the scene at `path` asks for.
    pub fn of_scene(scene: &CheckedScene, path: &Path, kind: Kind) -> Result<Self, SceneError> {
        let source = &scene.source;
        let section = Section::of_text(source, kind)?;
        counts(&section, kind, source)?;
        for (index, run) in section.runs.iter().enumerate() {
            let own = [("scene", run.scene.is_some()), ("at", run.at.is_some()), ("quick", run.quick)];
            if let Some((key, _)) = own.into_iter().find(|(_, is_given)| *is_given) {
                let place = format!("{}.runs[{index}].{key}", kind.name());
                let what = "is for the runs of a case: all runs here are of this scene";
                return Err(source.error(&place, what, "leave it out"));
            }
        }
        match kind {
            Kind::Stability => stability_check::check(&section, scene)?,
            Kind::Chart | Kind::Case => chart_check::check(&section, scene)?,
        }
        let Section { set, vary, runs, .. } = &section;
        let Sweep { columns, points } = Sweep::new((scene, path), source, kind.name(), set, vary, runs)?;
        if kind == Kind::Stability {
            stability_check::axes(&section, &columns, source)?;
        }
        let labels: Vec<&str> = points.iter().map(|point| point.label.as_str()).collect();
        chart_check::baseline(&section, &labels, source)?;
        Ok(Self {
            kind,
            source: source.clone(),
            metrics: scene.scene.metrics.clone(),
            section,
            columns,
            points,
        })
    }

    /// A case: each of its runs may have a scene of its own.
    fn of_case(source: SceneSource, path: &Path, quick: bool) -> Result<Self, SceneError> {
        let section = Section::of_text(&source, Kind::Case)?;
        counts(&section, Kind::Case, &source)?;
        case_check::check(&section, &source)?;
        let mut points = Vec::new();
        for (index, run) in section.runs.iter().enumerate().filter(|(_, run)| run.quick || !quick) {
            let named = run.scene.as_ref().or(section.scene.as_ref()).ok_or_else(|| {
                let key = format!("case.runs[{index}].scene");
                source.error(&key, "is missing", "name a scene here, or one for all runs as case.scene")
            })?;
            let place = format!("case.runs[{index}]");
            points.push(point(&source, &from(path, named), (run, &place), &section.set)?);
        }
        Ok(Self { kind: Kind::Case, source, metrics: Vec::new(), section, columns: Vec::new(), points })
    }

    /// Name of the study: that of a case, else of the file.
    pub fn name(&self) -> String {
        match self.kind {
            Kind::Case => self.section.name.clone(),
            Kind::Chart | Kind::Stability => {
                let stem = Path::new(&self.source.file).file_stem().unwrap_or_default();
                stem.to_string_lossy().into_owned()
            }
        }
    }

    /// Folder of the file: paths in a case start there.
    pub(super) fn folder(&self) -> &Path {
        Path::new(&self.source.file).parent().unwrap_or(Path::new(""))
    }
}

/// The run of a case; `set` is what all its runs set.
fn point(
    source: &SceneSource,
    scene: &Path,
    (run, place): (&SingleRun, &str),
    set: &toml::Table,
) -> Result<Point, SceneError> {
    let checked = CheckedScene::new(SceneSource::read(scene, &[])?)?;
    let sweep = Sweep::new((&checked, scene), source, "case", set, &[], std::slice::from_ref(run));
    let first =
        sweep.map_err(|error| SceneError { key: error.key.replace("case.runs[0]", place), ..error })?;
    first.points.into_iter().next().ok_or_else(|| source.error(place, "is no run", "give it a label"))
}

/// A path that a file at `path` names, without `..` after a name.
fn from(path: &Path, named: &Path) -> PathBuf {
    let mut whole = PathBuf::new();
    for part in path.parent().unwrap_or(Path::new("")).join(named).components() {
        let follows_name = matches!(whole.components().next_back(), Some(Component::Normal(_)));
        if part == Component::ParentDir && follows_name {
            whole.pop();
        } else {
            whole.push(part);
        }
    }
    whole
}

/// Threads and repeats of every kind.
fn counts(section: &Section, kind: Kind, source: &SceneSource) -> Result<(), SceneError> {
    for (key, count) in [("repeat", section.repeat), ("threads", section.threads)] {
        if !(1..=1000).contains(&count) {
            let message = format!("is {count}; allowed: 1 to 1000");
            return Err(source.error(&format!("{}.{key}", kind.name()), message, "give a whole number"));
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_path_is_seen_from_the_file_that_names_it() {
        let scene = |file: &str| from(Path::new(file), Path::new("../falling-sphere.toml"));
        assert_eq!(scene("scenes/validation/fall.toml"), Path::new("scenes/falling-sphere.toml"));
        assert_eq!(scene("../fall.toml"), Path::new("../../falling-sphere.toml"));
    }
}
