//! `bedload ensemble`: a scene, or a chain of scenes that start from each other, once per seed; mean and
//! standard error of every metric, column and profile.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use bedload_output::{MetricValue, Series, Summary, atomic_write};
use bedload_program::{RunOptions, until_as_set};
use bedload_scene::SceneSource;
use clap::Args;
use serde::Deserialize;

use super::commands::Options;
use super::folder::{self, content, cores};
use super::plot::{Axis, Look, Plot, Series as Line, colour, panels};
use super::runs::{Outcome, Reuse, Task, run_chains};
use super::table::{cell, interpolated};
use coupler::failure::Failure;
use coupler::number::{Short, number};

/// From one run to the next each seed grows by this: seeds 1, 2, 3 of groups of one scene never meet.
const STRIDE: i64 = 1000;

/// Instants of a column in the table, at most.
const MOST_INSTANTS: usize = 250;

/// Profiles of a run: a table by the place in its first column.
const PROFILES: [&str; 2] = ["planes", "profile"];

/// Lists of a scene whose entries are drawn at random.
const RANDOM: [&str; 3] = ["rough_walls", "groups", "insertions"];

/// What to run.
#[derive(Clone, Debug, Args)]
pub struct Ensemble {
    /// Scene files (TOML): one, or a chain in which each starts from the one before, such as
    /// settling.toml flow.toml, where flow.toml reads out/settling/grains.csv
    #[arg(required = true)]
    pub scenes: Vec<PathBuf>,
    /// Runs; run k, from 0, adds 1000 k to every seed of groups, insertions and rough walls
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(2..=1000))]
    pub seeds: u16,
    /// Override any key of the last scene, or with NAME:KEY=VALUE of the scene NAME.toml; may be repeated
    #[arg(long = "set", value_name = "KEY=VALUE")]
    pub overrides: Vec<String>,
    /// End of the last scene, s, instead of its `until`
    #[arg(long, value_name = "T", allow_negative_numbers = true)]
    pub until: Option<f64>,
}

/// A scene of the chain.
struct Stage<'a> {
    path: &'a Path,
    /// Name of the file without its ending, also of the folder.
    name: String,
    set: Vec<String>,
    source: SceneSource,
}

/// What a figure is called.
#[derive(Deserialize)]
struct Titled {
    #[serde(default)]
    title: String,
}

/// A quantity over the runs.
struct Row {
    part: &'static str,
    name: String,
    at: Option<f64>,
    spread: Spread,
}

/// Mean over runs and its standard error.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Spread {
    runs: usize,
    mean: f64,
    /// None of one run.
    error: Option<f64>,
    least: f64,
    largest: f64,
}

impl Spread {
    /// Of the values that are finite; none of none.
    fn of(values: impl Iterator<Item = f64>) -> Option<Self> {
        let values: Vec<f64> = values.filter(|value| value.is_finite()).collect();
        let runs = values.len();
        let count = runs as f64;
        // About the first: equal values have no error.
        let first = *values.first()?;
        let mean = first + values.iter().map(|value| value - first).sum::<f64>() / count;
        let square: f64 = values.iter().map(|value| (value - mean).powi(2)).sum();
        Some(Self {
            runs,
            mean,
            error: (runs > 1).then(|| (square / (count - 1.0) / count).sqrt()),
            least: values.iter().copied().fold(f64::INFINITY, f64::min),
            largest: values.iter().copied().fold(f64::NEG_INFINITY, f64::max),
        })
    }
}

/// Makes the runs that are missing, `ensemble.csv` and `ensemble.svg`, and prints the metrics.
///
/// # Errors
/// [`Failure::Input`] and [`Failure::Scene`] where the runs cannot be laid out, [`Failure::Run`] with the
/// seeds that failed: the table is then of the others.
pub fn ensemble(asked: &Ensemble, options: &Options) -> Result<(), Failure> {
    let stages = stages(asked)?;
    let Some(last) = stages.last() else { return Err(Failure::Input("no scene was named".into())) };
    let out = options.folder(&format!("{}-ensemble", last.name));
    let whole = std::path::absolute(&out).map_err(folder::cannot("find", &out))?;
    let seeds = usize::from(asked.seeds);
    let jobs = options.jobs.map_or(cores(), usize::from).clamp(1, seeds);
    let threads = (cores() / jobs).max(1);
    let chains: Vec<Vec<Task>> =
        (0..seeds).map(|seed| chain(&stages, seed, &whole, threads)).collect::<Result<_, _>>()?;
    // A fault of the first scene with every seed is one of the command, not of eight runs; where grains find
    // no room it is one of a seed.
    let read = |chain: &Vec<Task>| {
        let Task { scene, set, .. } = &chain[0];
        RunOptions { overrides: set.clone(), ..RunOptions::of_scene(scene) }.read_scene().map(drop)
    };
    if let Err(error) = read(&chains[0])
        && chains[1..].iter().all(|chain| read(chain).is_err())
    {
        return Err(error.into());
    }
    let title = last.source.section::<Titled>()?.title;
    let _claim = folder::open(&out, &last.source)?;
    let slices: Vec<&[Task]> = chains.iter().map(Vec::as_slice).collect();
    let outcomes = run_chains(&slices, jobs, Reuse::Completed, options.commit)?;
    let (mut done, mut failed) = (Vec::new(), Vec::new());
    for ((seed, chain), outcome) in chains.iter().enumerate().zip(outcomes) {
        match (outcome, chain.last()) {
            (Outcome::Done(summary), Some(task)) => done.push((task.folder.as_path(), *summary)),
            (Outcome::Failed(why), _) => failed.push(format!("seed-{seed}: {why}")),
            _ => {}
        }
    }
    if !done.is_empty() {
        let rows = rows(&done)?;
        atomic_write(&out.join("ensemble.csv"), table(&rows).as_bytes())?;
        let title = format!("{title}: mean over {} seeds and its standard error", done.len());
        let drawn = figure(&title, &rows);
        if let Some(svg) = &drawn {
            atomic_write(&out.join("ensemble.svg"), svg.as_bytes())?;
        }
        let drawn = drawn.map_or_else(String::new, |_| format!("\n{}", out.join("ensemble.svg").display()));
        protocol::show!("{}{}{drawn}", words(&rows, &done[0].1), out.join("ensemble.csv").display());
    }
    if failed.is_empty() {
        return Ok(());
    }
    if done.is_empty() {
        ["ensemble.csv", "ensemble.svg"].iter().try_for_each(|name| folder::remove(&out.join(name)))?;
    }
    let count = failed.len();
    let rest = if done.is_empty() { "; there is no table" } else { "; the table is of the others" };
    Err(Failure::Run(format!("{count} of {seeds} seeds failed{rest}: {}", failed.join("; "))))
}

/// The scenes with what is set in each.
fn stages(asked: &Ensemble) -> Result<Vec<Stage<'_>>, Failure> {
    let name = |path: &Path| path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let names: Vec<String> = asked.scenes.iter().map(|path| name(path)).collect();
    if let Some(place) = (0..names.len()).find(|place| names[..*place].contains(&names[*place])) {
        let what = format!("two scenes have the name {}: give each file a name of its own", names[place]);
        return Err(Failure::Input(what));
    }
    let mut sets = vec![Vec::new(); names.len()];
    for text in &asked.overrides {
        // A value may have a colon, a key has none.
        let key = text.split_once('=').map_or(text.as_str(), |(key, _)| key);
        let (place, text) = match key.split_once(':') {
            None => (names.len().saturating_sub(1), text.as_str()),
            Some((name, _)) => match names.iter().position(|known| known == name) {
                Some(place) => (place, &text[name.len() + 1..]),
                None => {
                    let known = names.join(", ");
                    let what = format!("--set {text}: no scene is called {name}; the scenes are: {known}");
                    return Err(Failure::Input(what));
                }
            },
        };
        sets[place].push(text.to_owned());
    }
    if let Some(set) = sets.last_mut() {
        set.extend(asked.until.map(until_as_set));
    }
    let mut stages = Vec::new();
    for ((path, name), set) in asked.scenes.iter().zip(names).zip(sets) {
        let source = SceneSource::read(path, &set)?;
        // Named as it is: overrides stand behind the name else.
        let source = SceneSource { file: path.display().to_string(), ..source };
        stages.push(Stage { path, name, set, source });
    }
    if stages.iter().all(|stage| seeds(&stage.source, 1).is_empty()) {
        let what = "no scene has anything random, so that all runs would be alike: an ensemble needs [[groups]], \
                    [[insertions]], or [[rough_walls]] with a radius_spread";
        return Err(Failure::Input(what.into()));
    }
    Ok(stages)
}

/// The runs of a seed, counted from 0.
fn chain(stages: &[Stage<'_>], seed: usize, out: &Path, threads: usize) -> Result<Vec<Task>, Failure> {
    let folder = |name: &str| out.join(format!("seed-{seed}")).join(name);
    let task = |(place, stage): (usize, &Stage<'_>)| {
        let links = links(&stages[..place], stage, &folder)?;
        Ok(Task {
            name: format!("seed-{seed}/{}", stage.name),
            scene: stage.path.to_owned(),
            set: [stage.set.clone(), seeds(&stage.source, seed), links].concat(),
            folder: folder(&stage.name),
            threads,
        })
    };
    stages.iter().enumerate().map(task).collect()
}

/// What sets the seeds of a scene in run `seed`; nothing in run 0, which is the scene as it is written.
fn seeds(source: &SceneSource, seed: usize) -> Vec<String> {
    let scene: toml::Table = source.text.parse().unwrap_or_default();
    let mut set = Vec::new();
    for list in RANDOM {
        let entries = scene.get(list).and_then(toml::Value::as_array).into_iter().flatten();
        // A rough wall has its radii at random, where they differ.
        let is_random = |entry: &toml::Value| {
            let is_zero =
                |spread: &toml::Value| spread.as_float() == Some(0.0) || spread.as_integer() == Some(0);
            list != "rough_walls" || entry.get("radius_spread").is_some_and(|spread| !is_zero(spread))
        };
        for (place, entry) in entries.enumerate().filter(|(_, entry)| seed > 0 && is_random(entry)) {
            let written = entry.get("seed").and_then(toml::Value::as_integer).unwrap_or(0);
            // Past the largest they go on from 0.
            let more = STRIDE.wrapping_mul(seed as i64);
            set.push(format!("{list}[{place}].seed={}", written.wrapping_add(more) & i64::MAX));
        }
    }
    set
}

/// What makes a scene start from the runs of `earlier` scenes: files in a folder that has the name of one.
fn links(
    earlier: &[Stage<'_>],
    stage: &Stage<'_>,
    folder: &impl Fn(&str) -> PathBuf,
) -> Result<Vec<String>, Failure> {
    let mut set = Vec::new();
    let mut table = 0;
    for (key, path) in stage.source.files() {
        let (key, run, file) = match key {
            "grain_files[].file" => {
                table += 1;
                (format!("grain_files[{}].file", table - 1), path.parent(), path.file_name())
            }
            "dem.initial_state" | "medium.initial.folder" => (key.to_owned(), Some(path.as_path()), None),
            _ => continue,
        };
        let name = run.and_then(Path::file_name).unwrap_or_default();
        if let Some(known) = earlier.iter().find(|known| name == known.name.as_str()) {
            let of_seed = file.map_or(folder(&known.name), |file| folder(&known.name).join(file));
            set.push(format!("{key}={}", toml::Value::from(of_seed.to_string_lossy().into_owned())));
        }
    }
    let Some(before) = earlier.last().filter(|_| set.is_empty()) else { return Ok(set) };
    let (file, name) = (stage.path.display(), &before.name);
    Err(Failure::Input(format!(
        "{file} starts from no scene before it: let grain_files.file, dem.initial_state or \
         medium.initial.folder name a folder {name}, such as \"out/{name}/grains.csv\""
    )))
}

/// All that the runs have in common.
fn rows(done: &[(&Path, Summary)]) -> Result<Vec<Row>, Failure> {
    let mut metrics: BTreeMap<&str, Vec<f64>> = BTreeMap::new();
    for (name, metric) in done.iter().flat_map(|(_, summary)| &summary.metrics) {
        metrics.entry(name).or_default().extend(metric.value);
    }
    let row = |(name, values): (&str, Vec<f64>)| {
        let spread = Spread::of(values.into_iter())?;
        Some(Row { part: "metric", name: name.to_owned(), at: None, spread })
    };
    let mut rows: Vec<Row> = metrics.into_iter().filter_map(row).collect();
    let read = |name: &str| -> Result<Vec<Series>, Failure> {
        let files = done.iter().map(|(folder, _)| folder.join(format!("{name}.csv")));
        // A profile may begin after the end of a seed.
        let (there, missing): (Vec<PathBuf>, Vec<PathBuf>) = files.partition(|path| path.exists());
        if let Some(path) = missing.first().filter(|_| name == "series" && !there.is_empty()) {
            let what = "is missing, and other seeds have it: remove its folder, and the run is made again";
            return Err(Failure::Input(format!("{} {what}", path.display())));
        }
        there.iter().map(|path| without_remarks(path)).collect()
    };
    let series = read("series")?;
    // Those of the run with the fewest rows, as far as all runs go.
    let ends = |series: &Series| Some((*series.time().first()?, *series.time().last()?));
    let spans: Vec<(f64, f64)> = series.iter().filter_map(ends).collect();
    let from = spans.iter().map(|span| span.0).fold(f64::NEG_INFINITY, f64::max);
    let to = spans.iter().map(|span| span.1).fold(f64::INFINITY, f64::min);
    let few = series.iter().min_by_key(|series| series.len()).map_or(&[][..], Series::time);
    let times: Vec<f64> = few.iter().copied().filter(|time| (from..=to).contains(time)).collect();
    let every = times.len().div_ceil(MOST_INSTANTS).max(1);
    let times: Vec<f64> = times.into_iter().step_by(every).collect();
    columns("series", &series, &times, &mut rows);
    for part in PROFILES {
        let profiles = read(part)?;
        let places = profiles.first().and_then(|first| first.column(first.names().first()?));
        columns(part, &profiles, places.unwrap_or(&[]), &mut rows);
    }
    Ok(rows)
}

/// A table whose first lines may be remarks.
fn without_remarks(path: &Path) -> Result<Series, Failure> {
    let text = folder::read(path)?;
    let lines = text.split_inclusive('\n').filter(|line| !line.starts_with('#'));
    Series::parse(&lines.collect::<String>()).map_err(content(path))
}

/// Adds every column of the tables at `places` of their first one, on straight lines between their rows.
fn columns(part: &'static str, tables: &[Series], places: &[f64], rows: &mut Vec<Row>) {
    let Some((along, names)) = tables.first().and_then(|first| first.names().split_first()) else { return };
    for name in names {
        let points = |table: &Series| -> Option<Vec<(f64, f64)>> {
            Some(table.column(along)?.iter().copied().zip(table.column(name)?.iter().copied()).collect())
        };
        let all: Vec<Vec<(f64, f64)>> = tables.iter().filter_map(points).collect();
        for at in places {
            if let Some(spread) = Spread::of(all.iter().filter_map(|points| interpolated(points, *at))) {
                rows.push(Row { part, name: name.clone(), at: Some(*at), spread });
            }
        }
    }
}

/// `ensemble.csv`.
fn table(rows: &[Row]) -> String {
    let text = |value: Option<f64>| value.map_or_else(String::new, |value| value.to_string());
    let line = |Row { part, name, at, spread }: &Row| {
        let Spread { runs, mean, error, least, largest } = spread;
        let (name, at, error) = (cell(name), text(*at), text(*error));
        format!("{part},{name},{at},{runs},{mean},{error},{least},{largest}\n")
    };
    let header = "part,name,at,runs,mean,standard_error,least,largest\n";
    std::iter::once(header.to_owned()).chain(rows.iter().map(line)).collect()
}

/// The metrics for the terminal; of one that no run has, why the first has none.
fn words(rows: &[Row], first: &Summary) -> String {
    let line = |(name, metric): (&String, &MetricValue)| {
        let found = rows.iter().find(|row| row.part == "metric" && row.name == *name);
        let Some(Row { spread, .. }) = found else {
            return format!("{name}: none ({})\n", metric.note.as_deref().unwrap_or("no run has a value"));
        };
        let error = spread.error.map_or_else(String::new, |error| format!(" ± {}", Short(error)));
        let unit = if metric.unit == "-" { String::new() } else { format!(" {}", metric.unit) };
        format!("{name}: {}{error}{unit} ({} runs)\n", Short(spread.mean), spread.runs)
    };
    first.metrics.iter().map(line).collect()
}

/// A panel for each column that is about no single grain, and for each of a profile: the mean, in a band of
/// its standard error. Steps and widths are no results.
fn figure(title: &str, rows: &[Row]) -> Option<String> {
    let unlike = ["dt", "width", "substeps"];
    let drawn = rows.iter().filter(|row| row.part != "metric" && !row.name.contains('['));
    let drawn = drawn.filter(|row| !unlike.contains(&row.name.as_str()));
    let key = |row: &&Row| (row.part, row.name.clone());
    let plot = |((part, name), rows): ((&str, String), Vec<&&Row>)| Plot {
        size: (380.0, 260.0),
        title: name,
        x: Axis { label: if part == "series" { "t, s" } else { "at, m" }.to_owned(), ..Axis::default() },
        y: Axis { format: Some(number), ..Axis::default() },
        series: vec![Line {
            name: "mean ± standard error".to_owned(),
            colour: colour(0),
            points: rows.iter().filter_map(|row| Some((row.at?, row.spread.mean))).collect(),
            look: Look::Band { half: rows.iter().map(|row| row.spread.error.unwrap_or(0.0)).collect() },
        }],
        legend: Some(160.0),
        ..Plot::default()
    };
    let drawn: Vec<&Row> = drawn.collect();
    let mut groups = super::table::grouped(&drawn, key);
    // In a plane nothing moves along y.
    groups.retain(|(_, rows)| rows.iter().any(|row| row.spread.least != 0.0 || row.spread.largest != 0.0));
    let plots: Vec<Plot> = groups.into_iter().map(plot).collect();
    (!plots.is_empty()).then(|| panels(title, &plots, 3))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_standard_error_is_the_deviation_over_the_root_of_the_count() {
        let spread = Spread::of([1.0, f64::NAN, 2.0, 3.0, 6.0].into_iter()).unwrap();
        assert_eq!((spread.runs, spread.mean, spread.least, spread.largest), (4, 3.0, 1.0, 6.0));
        assert!((spread.error.unwrap() - (14.0f64 / 3.0 / 4.0).sqrt()).abs() < 1e-15);
        assert_eq!(Spread::of([0.1; 3].into_iter()).unwrap().error, Some(0.0));
        assert_eq!(Spread::of([2.0].into_iter()).unwrap().error, None);
        assert_eq!(Spread::of([f64::NAN].into_iter()), None);
    }

    #[test]
    fn each_seed_of_a_scene_grows_and_the_first_run_is_the_scene_itself() {
        let text = "groups = [{ seed = 1 }, {}, { seed = 9223372036854775807 }]\n[[insertions]]\nseed = 7\n\
                    [[rough_walls]]\nradius_spread = 0.1\n[[rough_walls]]\nradius_spread = 0.0\n\
                    [[rough_walls]]\nradius_spread = 0\n";
        let source = SceneSource { file: "s.toml".into(), text: text.into() };
        assert!(seeds(&source, 0).is_empty());
        let third = ["rough_walls[0].seed=2000", "groups[0].seed=2001", "groups[1].seed=2000"];
        assert_eq!(seeds(&source, 2)[..3], third);
        assert_eq!(seeds(&source, 2)[3..], ["groups[2].seed=1999", "insertions[0].seed=2007"]);
    }

    #[test]
    fn tables_of_other_instants_meet_on_straight_lines() {
        let tables = ["t,v\n0,0\n2,4\n", "t,v\n0,2\n1,2\n2,NaN\n"].map(|text| Series::parse(text).unwrap());
        let mut rows = Vec::new();
        columns("series", &tables, &[0.0, 1.0, 2.0], &mut rows);
        let found: Vec<(f64, usize)> = rows.iter().map(|row| (row.spread.mean, row.spread.runs)).collect();
        assert_eq!(found, [(1.0, 2), (2.0, 2), (4.0, 1)]);
        assert!(table(&rows).ends_with("series,v,2,1,4,,4,4\n"));
    }
}
