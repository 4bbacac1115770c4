//! The runs of a chart: planned, made, measured.

use std::path::{Path, PathBuf};

use bedload_output::{Summary, atomic_write};
use bedload_scene::{CheckedScene, SceneError};

use super::config::{Chart, Curve, Reference};
use super::reference;
use super::table::{Row, Spread, Table, columns};
use crate::folder::{self, cannot};
use crate::{self as sweep, Outcome, Point, Reuse, Sweep, Task};
use coupler::failure::Failure;

/// The runs that the section asks for.
pub(super) fn plan(scene: &CheckedScene, chart: &Chart) -> Result<Sweep, SceneError> {
    let sweep = Sweep::new(scene, "chart", &chart.set, &chart.vary, &chart.runs)?;
    let labels = || sweep.points.iter().map(|point| point.label.as_str());
    match &chart.baseline {
        Some(baseline) if !labels().any(|label| label == baseline) => Err(scene.source.error(
            "chart.baseline",
            format!(
                "is {baseline:?}, but no run has that label; there are {}",
                labels().collect::<Vec<_>>().join(", ")
            ),
            "name the run that has the paper's own setting, or leave the key out",
        )),
        _ => Ok(sweep),
    }
}

/// Makes all runs, each as often as it is timed, and measures them.
pub(super) fn make(
    sweep: &Sweep,
    chart: &Chart,
    scene: &Path,
    out: &Path,
    jobs: usize,
) -> Result<Table, Failure> {
    let mut tasks: Vec<Task> = Vec::new();
    // All runs once, then all again: what slows the machine for a while meets every setting.
    for repeat in 1..=chart.repeat {
        tasks.extend(sweep.points.iter().map(|point| task(point, chart, scene, out, repeat)));
    }
    for task in &tasks {
        if let Ok(None) = task.finished(Reuse::AlsoFailed) {
            note_beside(task, jobs)?;
        }
    }
    let outcomes = sweep::run_all(&tasks, jobs, Reuse::AlsoFailed)?;
    let curve = match &chart.reference {
        Some(Reference::Curve(curve)) => Some((curve, folder::read(&curve.file)?)),
        _ => None,
    };
    let count = sweep.points.len();
    let row = |number: usize| {
        let of = || (number..tasks.len()).step_by(count);
        let made: Vec<(&Task, &Outcome)> = of().map(|place| (&tasks[place], &outcomes[place])).collect();
        row(&sweep.points[number], chart, &made, curve.as_ref())
    };
    let keys = sweep.columns.iter().map(|column| column.key.clone()).collect();
    Ok(Table { keys, columns: columns(&chart.metrics()), rows: (0..count).map(row).collect() })
}

/// A run, once; the first time in `runs/`, again in `runs-2/` and so on.
fn task(point: &Point, chart: &Chart, scene: &Path, out: &Path, repeat: usize) -> Task {
    let (folder, again) = match repeat {
        1 => ("runs".to_owned(), String::new()),
        _ => (format!("runs-{repeat}"), format!(" ({repeat})")),
    };
    let task = point.task(scene, &out.join(folder), chart.threads);
    Task { name: task.name + &again, ..task }
}

/// `FOLDER.beside`: how many runs at most share the machine with this one.
fn beside_file(task: &Task) -> PathBuf {
    let mut path = std::ffi::OsString::from(&task.folder);
    path.push(".beside");
    path.into()
}

/// Leaves word for later charts of the same folder, which do not repeat the run, that others ran beside it.
fn note_beside(task: &Task, jobs: usize) -> Result<(), Failure> {
    let path = beside_file(task);
    if jobs > 1 {
        if let Some(folder) = path.parent() {
            folder::make(folder)?;
        }
        atomic_write(&path, (jobs - 1).to_string().as_bytes())?;
    } else if path.exists() {
        std::fs::remove_file(&path).map_err(cannot("remove", &path))?;
    }
    Ok(())
}

fn beside(task: &Task) -> usize {
    std::fs::read_to_string(beside_file(task)).ok().and_then(|text| text.trim().parse().ok()).unwrap_or(0)
}

/// What a point's runs gave.
fn row<'a>(
    point: &Point,
    chart: &Chart,
    made: &[(&'a Task, &'a Outcome)],
    curve: Option<&(&Curve, String)>,
) -> Row {
    let summary = |(task, outcome): &(&'a Task, &'a Outcome)| Some((*task, outcome.summary()?));
    let done: Vec<(&Task, &Summary)> = made.iter().filter_map(summary).collect();
    let metrics = chart.metrics();
    let mut row = Row {
        values: point.values.clone(),
        label: point.label.clone(),
        cpu: Spread::of(done.iter().map(|(_, summary)| cpu(summary)).collect()),
        wall: Spread::of(done.iter().map(|(_, summary)| summary.cost.wall_s).collect()),
        error: None,
        pareto: false,
        measured: vec![None; metrics.len()],
        repeats: done.len(),
        beside: made.iter().map(|(task, _)| beside(task)).max().unwrap_or(0),
        note: String::new(),
    };
    for (_, outcome) in made {
        if let Outcome::Failed(why) = outcome {
            row.add_note(why);
        }
    }
    let Some((task, first)) = done.first() else { return row };
    for (place, name) in metrics.iter().enumerate() {
        match first.metrics.get(*name) {
            None => row.add_note(&format!("the run has no metric {name}")),
            Some(metric) => {
                row.measured[place] = metric.value;
                if let Some(note) = &metric.note {
                    row.add_note(note);
                }
            }
        }
    }
    // Repeats are timed, not measured: their results are the same bits, or something is broken.
    let values = |summary: &Summary| -> Vec<Option<u64>> {
        let value = |name: &&str| summary.metrics.get(*name)?.value.map(f64::to_bits);
        metrics.iter().map(value).collect()
    };
    if done.iter().any(|(_, summary)| values(summary) != values(first)) {
        row.add_note("repeats of the run gave other values: it does not repeat bit for bit");
    }
    if let Some((curve, text)) = curve {
        match reference::misfit(curve, text, &task.folder) {
            Ok(error) => row.error = Some(error),
            Err(why) => row.add_note(&why),
        }
    }
    row
}

/// CPU time of all that took part, s.
fn cpu(summary: &Summary) -> f64 {
    summary.cost.fluid_cpu_s + summary.cost.dem_cpu_s + summary.cost.coupler_cpu_s
}
