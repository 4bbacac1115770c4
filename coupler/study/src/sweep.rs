//! All combinations of varied keys, and single runs, as runs with `--set`.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use bedload_scene::{CheckedScene, SceneError, SceneSource};

use super::resolution::scaled;
use super::runs::Task;
use super::vary::{Choice, RESOLUTION, Setting, SingleRun, THREADS, Vary, settings, text};
use coupler::number::rounded;
use coupler::resolution;

/// More runs than this are a mistake.
const MOST_RUNS: usize = 5000;

/// A label is the name of a folder.
const LONGEST_LABEL: usize = 100;

/// A varied key.
#[derive(Clone, Debug, PartialEq)]
pub struct Column {
    /// Header: dotted key, or name of the bundles.
    pub key: String,
    /// Name for people.
    pub name: String,
}

/// One run to make.
#[derive(Clone, Debug, PartialEq)]
pub struct Point {
    /// Name, also of its folder.
    pub label: String,
    /// Its value of each column; empty where the key is left to its default.
    pub values: Vec<String>,
    /// `KEY=VALUE` for `--set`.
    pub set: Vec<String>,
    /// Threads of each solver, where they vary.
    pub threads: Option<usize>,
    /// Its scene.
    pub scene: PathBuf,
    /// Its abscissa in a figure whose x is no metric.
    pub at: Option<f64>,
}

impl Point {
    /// The run, in a folder of its own below `folder`.
    pub(super) fn task(&self, folder: &Path, threads: usize) -> Task {
        Task {
            name: self.label.clone(),
            scene: self.scene.clone(),
            set: self.set.clone(),
            folder: folder.join(&self.label),
            threads: self.threads.unwrap_or(threads),
        }
    }
}

/// The runs of a sweep.
#[derive(Clone, Debug, PartialEq)]
pub struct Sweep {
    /// Varied keys.
    pub columns: Vec<Column>,
    /// Combinations, the last key fastest, then the single runs.
    pub points: Vec<Point>,
}

/// Builds the points of one scene.
struct Builder<'a> {
    scene: &'a CheckedScene,
    path: &'a Path,
    /// The file that asks for the runs.
    source: &'a SceneSource,
    section: &'a str,
    /// Set in every run.
    base: Vec<Setting>,
    vary: &'a [Vary],
    /// Values of each of `vary`.
    choices: Vec<Vec<Choice>>,
    columns: Vec<Column>,
    labels: BTreeSet<String>,
}

impl Sweep {
    /// The varied keys alone: the runs, whose files may be gone, are not looked at.
    pub fn columns(
        scene: (&CheckedScene, &Path),
        source: &SceneSource,
        section: &str,
        vary: &[Vary],
        runs: &[SingleRun],
    ) -> Result<Vec<Column>, SceneError> {
        Ok(Builder::new(scene, source, section, (Vec::new(), vary), runs)?.columns)
    }

    /// All combinations of `vary`, then `runs`; `section` is where they stand, `chart`. `base` is set in
    /// every run, before its own keys. Each scene that comes out is read and checked as far as the
    /// shared part goes. `path` and `source`: where the scene is, and the file that asks for the runs.
    pub fn new(
        (scene, path): (&CheckedScene, &Path),
        source: &SceneSource,
        section: &str,
        base: &toml::Table,
        vary: &[Vary],
        runs: &[SingleRun],
    ) -> Result<Self, SceneError> {
        let base = settings(base, &format!("{section}.set"));
        let mut builder = Builder::new((scene, path), source, section, (base, vary), runs)?;
        let mut points = Vec::new();
        let many = builder.choices.iter().map(Vec::len).try_fold(1, usize::checked_mul);
        let many = if vary.is_empty() { Some(0) } else { many };
        match many.and_then(|many| many.checked_add(runs.len())) {
            Some(1..=MOST_RUNS) => {}
            Some(0) => {
                let remedy =
                    format!("add [[{section}.vary]] with `key` and `values`; docs/scene.md shows one");
                let message = "names no run: it has neither `vary` nor `runs`";
                return Err(source.error(section, message, &remedy));
            }
            _ => {
                let (key, message) =
                    (format!("{section}.vary"), format!("combines to more than {MOST_RUNS} runs"));
                return Err(source.error(&key, message, "list fewer values, or single runs"));
            }
        }
        for number in 0..many.unwrap_or(0) {
            points.push(builder.combination(number)?);
        }
        for (index, run) in runs.iter().enumerate() {
            points.push(builder.single(run, index)?);
        }
        Ok(Self { columns: builder.columns, points })
    }
}

impl<'a> Builder<'a> {
    fn new(
        (scene, path): (&'a CheckedScene, &'a Path),
        source: &'a SceneSource,
        section: &'a str,
        (base, vary): (Vec<Setting>, &'a [Vary]),
        runs: &[SingleRun],
    ) -> Result<Self, SceneError> {
        let place = |index: usize| format!("{section}.vary[{index}]");
        let choices = |(index, vary): (usize, &Vary)| vary.choices(&place(index), source);
        let choices: Vec<Vec<Choice>> = vary.iter().enumerate().map(choices).collect::<Result<_, _>>()?;
        let bundled: BTreeSet<&str> = choices
            .iter()
            .flatten()
            .filter(|choice| choice.is_bundle)
            .flat_map(|choice| choice.settings.iter().map(|setting| setting.key.as_str()))
            .collect();
        let mut columns: Vec<Column> = Vec::new();
        for (index, vary) in vary.iter().enumerate() {
            if columns.iter().any(|column| column.key == vary.header()) {
                let message = format!("varies {} a second time", vary.header());
                return Err(source.error(&place(index), message, "put all its values into one list"));
            }
            let earlier = (0..index).filter(|other| choices[*other].iter().any(|choice| !choice.is_bundle));
            let set = choices[index].iter().flat_map(|choice| &choice.settings);
            for other in earlier.map(|other| columns[other].key.as_str()) {
                if let Some(setting) = set.clone().find(|setting| setting.key == other) {
                    let remedy = "leave it out here, or vary bundles that have a name";
                    let why = "whose values vary already: its column would not be what was run";
                    return Err(source.error(&setting.place, format!("sets {other}, {why}"), remedy));
                }
            }
            columns.push(Column { key: vary.header().to_owned(), name: super::table::cell(vary.title()) });
        }
        for key in runs.iter().flat_map(|run| run.set.settings("")).map(|setting| setting.key) {
            if !columns.iter().any(|column| column.key == key) && !bundled.contains(key.as_str()) {
                columns.push(Column { name: super::table::cell(&key), key });
            }
        }
        Ok(Self { scene, path, source, section, base, vary, choices, columns, labels: BTreeSet::new() })
    }

    fn combination(&mut self, number: usize) -> Result<Point, SceneError> {
        let mut rest = number;
        let mut chosen: Vec<Choice> = Vec::new();
        for choices in self.choices.iter().rev() {
            chosen.push(choices[rest % choices.len()].clone());
            rest /= choices.len();
        }
        chosen.reverse();
        let part = |(vary, choice): (&Vary, &Choice)| format!("{}{}", short(vary), plain(&choice.text));
        let parts: Vec<String> = self.vary.iter().zip(&chosen).map(part).collect();
        let label = self.unique(&parts.join("_"));
        let settings: Vec<Setting> = chosen.iter().flat_map(|choice| choice.settings.clone()).collect();
        let place = format!("{}.vary", self.section);
        self.point(label, &settings, &place, &chosen.iter().map(|c| Some(c.text.clone())).collect::<Vec<_>>())
    }

    /// A name of a folder like `wanted` that no other run has.
    fn unique(&mut self, wanted: &str) -> String {
        let short: String = wanted.trim_start_matches(['.', '-']).chars().take(LONGEST_LABEL).collect();
        let short = if short.is_empty() { "run".to_owned() } else { short };
        let mut label = short.clone();
        let mut copy = 2;
        while !self.labels.insert(label.clone()) {
            label = format!("{short}-{copy}");
            copy += 1;
        }
        label
    }

    fn single(&mut self, run: &SingleRun, index: usize) -> Result<Point, SceneError> {
        let place = format!("{}.runs[{index}]", self.section);
        let label = &run.label;
        let wrong = |why: &str, remedy: &str| {
            Err(self.source.error(&format!("{place}.label"), format!("is {label:?}, which {why}"), remedy))
        };
        if !is_folder_name(label) {
            let why = "becomes a folder; allowed: letters, digits, '-', '_' and '.'";
            return wrong(why, "give the run a plain name");
        }
        if !self.labels.insert(label.clone()) {
            return wrong("another run has already", "give each run its own name");
        }
        let settings = run.set.settings(&format!("{place}.set"));
        let point = self.point(label.clone(), &settings, &place, &vec![None; self.vary.len()])?;
        Ok(Point { at: run.at, ..point })
    }

    /// A run of these settings. `known` has the texts of the columns that were chosen from a list.
    fn point(
        &self,
        label: String,
        settings: &[Setting],
        place: &str,
        known: &[Option<String>],
    ) -> Result<Point, SceneError> {
        let source = self.source;
        let settings: Vec<Setting> = self.base.iter().chain(settings).cloned().collect();
        let settings = settings.as_slice();
        let mut set: Vec<String> = settings
            .iter()
            .filter(|setting| ![RESOLUTION, THREADS].contains(&setting.key.as_str()))
            .map(ToString::to_string)
            .collect();
        let mut made = self.checked(&set, settings, &label, place)?;
        if let Some(wanted) = last(settings, RESOLUTION) {
            let number = wanted.value.as_float().or(wanted.value.as_integer().map(|whole| whole as f64));
            let number = number.ok_or_else(|| format!("is {}, which is no number", wanted.value));
            let remedy = "give D/Δx of the smallest grain, or vary domain.cells itself";
            let grid = number.and_then(|number| scaled(&made, number));
            set.extend(grid.map_err(|what| source.error(&wanted.place, what, remedy))?);
            made = self.checked(&set, settings, &label, place)?;
        }
        let threads = last(settings, THREADS).map(|setting| threads(setting, source)).transpose()?;
        let written: toml::Table = made.source.text.parse().unwrap_or_default();
        let values = (0..self.columns.len())
            .map(|column| match known.get(column).cloned().flatten() {
                Some(text) => text,
                None => self.value(column, &made, &written, threads),
            })
            .collect();
        Ok(Point { label, values, set, threads, scene: self.path.to_owned(), at: None })
    }

    /// The scene with these overrides; an error stands at the entry that made it.
    fn checked(
        &self,
        set: &[String],
        settings: &[Setting],
        label: &str,
        place: &str,
    ) -> Result<CheckedScene, SceneError> {
        let source = &self.scene.source;
        let named = SceneSource { file: source.file.clone(), text: source.text.clone() };
        named.with_overrides(set).and_then(CheckedScene::new).map_err(|error| {
            let cause = settings.iter().find(|setting| {
                let akin = error.key.starts_with(&setting.key) || setting.key.starts_with(&error.key);
                (akin && !error.key.is_empty()) || error.message.contains(&format!("`{}=", setting.key))
            });
            let place = cause.map_or(place, |setting| setting.place.as_str());
            let key = if error.key.is_empty() { String::new() } else { format!("{} ", error.key) };
            let message = format!("makes the run {label}, in which {key}{}", error.message);
            self.source.error(place, message, &error.remedy)
        })
    }

    /// What a run that was not chosen from the list has in a column.
    fn value(
        &self,
        column: usize,
        made: &CheckedScene,
        written: &toml::Table,
        threads: Option<usize>,
    ) -> String {
        let key = &self.columns[column].key;
        match key.as_str() {
            // Six digits: radii rounded in the scene do not show.
            RESOLUTION => resolution::of(made).map_or_else(String::new, |n| rounded(n, 6).to_string()),
            THREADS => threads.map_or_else(String::new, |threads| threads.to_string()),
            _ => {
                let same = |setting: &Setting| look_up(written, &setting.key) == Some(&setting.value);
                let bundles =
                    self.choices.get(column).into_iter().flatten().filter(|choice| choice.is_bundle);
                let mut matching = bundles.filter(|choice| choice.settings.iter().all(same));
                let bundle = matching.next().map(|choice| choice.text.clone());
                bundle.unwrap_or_else(|| look_up(written, key).map_or_else(String::new, text))
            }
        }
    }
}

fn last<'a>(settings: &'a [Setting], key: &str) -> Option<&'a Setting> {
    settings.iter().rev().find(|setting| setting.key == key)
}

fn threads(setting: &Setting, source: &SceneSource) -> Result<usize, SceneError> {
    let count = setting.value.as_integer().and_then(|count| usize::try_from(count).ok()).filter(|n| *n > 0);
    count.ok_or_else(|| {
        let message = format!("is {}; allowed: a whole number of threads, 1 and more", setting.value);
        source.error(&setting.place, message, "give the threads of each solver")
    })
}

/// What stands at a dotted key.
fn look_up<'a>(table: &'a toml::Table, key: &str) -> Option<&'a toml::Value> {
    let mut parts = key.split(['.', '[', ']']).filter(|part| !part.is_empty());
    let mut value = table.get(parts.next()?)?;
    for part in parts {
        value = match value {
            toml::Value::Table(table) => table.get(part)?,
            toml::Value::Array(items) => items.get(part.parse::<usize>().ok()?)?,
            _ => return None,
        };
    }
    Some(value)
}

/// Begin of a value's part of a label: the last word of the key; bundles speak for themselves.
fn short(vary: &Vary) -> String {
    let tail = vary.key.as_deref().map(|key| key.rsplit('.').next().unwrap_or(key));
    tail.map_or_else(String::new, |tail| format!("{}-", plain(tail)))
}

/// May a folder or file have this name?
pub(super) fn is_folder_name(name: &str) -> bool {
    bedload_scene::is_file_name(name) && name == plain(name)
}

/// Text as a part of a folder's name.
fn plain(text: &str) -> String {
    let keep = |c: char| if c.is_ascii_alphanumeric() || "-_.".contains(c) { c } else { '-' };
    text.chars().map(keep).collect::<String>().trim_matches('-').to_owned()
}
