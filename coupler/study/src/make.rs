//! The runs of studies, made, and what each left.

use std::path::{Path, PathBuf};

use bedload_output::Summary;

use super::kind::Kind;
use super::runs::{self, Outcome, Reuse, Task};
use super::study::Study;
use super::sweep::Point;
use super::table::{Row, Spread, Table, value_columns};
use super::{chart, stability};
use coupler::failure::Failure;

#[derive(Clone, Copy, Debug)]
pub(super) struct How {
    /// Runs at a time.
    pub(super) jobs: usize,
    /// Threads of each solver, at least.
    pub(super) threads: usize,
    pub(super) commit: &'static str,
}

/// A study whose runs were made.
#[derive(Clone, Debug)]
pub(super) struct Made<'a> {
    pub(super) study: &'a Study,
    /// Folder of the runs' output folders.
    pub(super) folder: PathBuf,
    /// Every run with what became of it, all points once, then all again where they are repeated.
    runs: Vec<(Task, Outcome)>,
}

/// Makes the runs of all these studies, each in its folder, that are not finished there.
pub(super) fn make<'a>(studies: &[(&'a Study, PathBuf)], how: How) -> Result<Vec<Made<'a>>, Failure> {
    let planned: Vec<Vec<Task>> = studies.iter().map(|(study, out)| tasks(study, out, how.threads)).collect();
    let all: Vec<Task> = planned.iter().flatten().cloned().collect();
    // That a setting fails is a result, but of a case: every run of a case belongs to it.
    let cases = studies.iter().any(|(study, _)| study.kind == Kind::Case);
    let reuse = if cases { Reuse::Completed } else { Reuse::AlsoFailed };
    let mut outcomes = runs::run_all(&all, how.jobs, reuse, how.commit)?.into_iter();
    let made = |((study, out), tasks): (&(&'a Study, PathBuf), Vec<Task>)| {
        let runs = tasks.into_iter().zip(&mut outcomes).collect();
        Made { study, folder: folder(study, out), runs }
    };
    Ok(studies.iter().zip(planned).map(made).collect())
}

/// Folder of the output folders: that of a case itself, else `runs` in the study's.
fn folder(study: &Study, out: &Path) -> PathBuf {
    if study.kind == Kind::Case { out.to_owned() } else { out.join("runs") }
}

/// All points, once and then again: what slows the machine for a while meets every setting. The second
/// time the folder is `runs-2` and so on.
fn tasks(study: &Study, out: &Path, threads: usize) -> Vec<Task> {
    let task = |repeat: usize, point: &Point| {
        let first = folder(study, out);
        let folder = if repeat == 1 { first } else { out.join(format!("runs-{repeat}")) };
        let task = point.task(&folder, study.section.threads.max(threads));
        let again = if repeat == 1 { String::new() } else { format!(" ({repeat})") };
        let of_case =
            if study.kind == Kind::Case { format!("{}/", study.section.name) } else { String::new() };
        let imposed =
            if study.kind == Kind::Stability { stability::runs::imposed().to_vec() } else { Vec::new() };
        Task { name: format!("{of_case}{}{again}", task.name), set: [task.set, imposed].concat(), ..task }
    };
    (1..=study.section.repeat)
        .flat_map(|repeat| study.points.iter().map(move |point| task(repeat, point)))
        .collect()
}

impl<'a> Made<'a> {
    /// A study whose runs came to this.
    #[cfg(test)]
    pub(super) fn of(study: &'a Study, outcomes: Vec<Outcome>) -> Self {
        let tasks = tasks(study, Path::new("out"), 1);
        Self { study, folder: "out".into(), runs: tasks.into_iter().zip(outcomes).collect() }
    }

    /// Every point with what became of its first run.
    pub(super) fn runs(&self) -> impl Iterator<Item = (&'a Point, &Outcome)> {
        self.study.points.iter().zip(self.runs.iter().map(|(_, outcome)| outcome))
    }

    /// Points whose run left a result.
    pub(super) fn results(&self) -> impl Iterator<Item = (&'a Point, &Summary)> {
        self.runs().filter_map(|(point, outcome)| Some((point, outcome.summary()?)))
    }

    pub(super) fn result(&self, label: &str) -> Option<&Summary> {
        self.results().find(|(point, _)| point.label == label).map(|(_, summary)| summary)
    }

    pub(super) fn table(&self, jobs: usize) -> Result<Table, Failure> {
        let study = self.study;
        let rows = (0..study.points.len()).map(|number| self.row(number)).collect();
        let keys = study.columns.iter().map(|column| column.key.clone()).collect();
        let metrics = value_columns(study.kind, &study.section.metrics());
        let mut table = Table { kind: study.kind, keys, metrics, rows };
        match study.kind {
            Kind::Chart => chart::errors(study, &mut table),
            Kind::Stability => stability::runs::classify(study, &mut table, &self.runs, jobs)?,
            Kind::Case => {}
        }
        Ok(table)
    }

    /// What the runs of a point have in common: costs, values of metrics, where they were made.
    fn row(&self, number: usize) -> Row {
        let (study, point) = (self.study, &self.study.points[number]);
        let made: Vec<&(Task, Outcome)> = self.runs.iter().skip(number).step_by(study.points.len()).collect();
        let done: Vec<&Summary> = made.iter().filter_map(|(_, outcome)| outcome.summary()).collect();
        let metrics = study.section.metrics();
        let origin = made.first().map(|(task, _)| task.origin()).unwrap_or_default();
        let mut row = Row {
            values: point.values.clone(),
            label: point.label.clone(),
            cpu: Spread::of(done.iter().map(|summary| cpu(summary)).collect()),
            wall: Spread::of(done.iter().map(|summary| summary.cost.wall_s).collect()),
            measured: vec![None; metrics.len()],
            repeats: done.len(),
            beside: made.iter().map(|(task, _)| task.origin().beside).max().unwrap_or(0),
            commit: origin.commit,
            machine: origin.machine,
            ..Row::default()
        };
        for (_, outcome) in &made {
            if let Outcome::Failed(why) = outcome {
                row.add_note(why);
            }
        }
        let Some(first) = done.first() else { return row };
        for (place, name) in metrics.iter().enumerate() {
            match first.metrics.get(*name) {
                // Scenes of a case have different metrics.
                None if study.kind == Kind::Case => {}
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
        if done.iter().any(|summary| values(summary) != values(first)) {
            row.add_note("repeats of the run gave other values: it does not repeat bit for bit");
        }
        row
    }
}

/// CPU time of all that took part, s.
fn cpu(summary: &Summary) -> f64 {
    summary.cost.fluid_cpu_s + summary.cost.dem_cpu_s + summary.cost.coupler_cpu_s
}
