//! The runs of a plan: what each is told besides its varied keys, and what became of it.

use std::path::Path;

use bedload_output::{RunStatus, Series, Summary};
use bedload_program::RunOptions;

use super::section::{ANY, Limit, MapPlan, Stability};
use super::table::Row;
use super::verdict::{self, Finding, Verdict};
use crate::bounds::{Bound, Level, NAMES};
use crate::failure::Failure;
use crate::prepare::Prepared;
use crate::study::folder::content;
use crate::study::runs::at_a_time;
use crate::study::{Outcome, Point, Reuse, Task, cell, run_all};

/// Characters of a note that are kept: an error names its cause first.
const NOTE: usize = 160;

/// Makes the runs that are not there yet, and judges all.
pub(super) fn rows(plan: &MapPlan, scene: &Path, out: &Path, jobs: usize) -> Result<Vec<Row>, Failure> {
    let points = &plan.sweep.points;
    let tasks: Vec<Task> = points.iter().map(|point| task(point, scene, out)).collect();
    let outcomes = run_all(&tasks, jobs, Reuse::AlsoFailed)?;
    let judged: Vec<(&Point, Finding)> = points
        .iter()
        .zip(&tasks)
        .zip(&outcomes)
        .map(|((point, task), outcome)| Ok((point, finding(&plan.section, task, outcome)?)))
        .collect::<Result<_, Failure>>()?;
    let one = |(point, finding): &(&Point, Finding)| row(point, finding, &plan.section, scene);
    // Each asks the solvers for their facts, which are processes: several at a time, too.
    let fault = || Err(Failure::Run("not every run was planned: report this as a fault".into()));
    at_a_time(jobs, &judged, one).into_iter().map(|row| row.unwrap_or_else(fault)).collect()
}

fn task(point: &Point, scene: &Path, out: &Path) -> Task {
    // Small runs: more threads only wait for each other.
    let mut task = point.task(scene, &out.join("runs"), 1);
    task.set.extend(imposed());
    task
}

/// Keys that every run is given: no bound stops it, every window is in the series, and nothing is logged.
#[must_use]
pub fn imposed() -> [String; 3] {
    let names: Vec<String> = NAMES.iter().map(|name| format!("{name:?}")).collect();
    [
        format!("coupling.force=[{}]", names.join(", ")),
        "observe.every=0.0".to_owned(),
        "coupling.record=false".to_owned(),
    ]
}

/// What became of a run.
fn finding(section: &Stability, task: &Task, outcome: &Outcome) -> Result<Finding, Failure> {
    let path = task.folder.join("series.csv");
    match outcome {
        Outcome::Failed(why) => {
            // A run that left no summary was no run: the scene is wrong, or a solver is missing.
            let summary = Summary::read(&task.folder.join("summary.json")).ok();
            if summary
                .is_none_or(|summary| !matches!(summary.status, RunStatus::Failed | RunStatus::Unstable))
            {
                return Err(Failure::Input(format!("the run {} could not be made: {why}", task.name)));
            }
            let series = if path.is_file() { Series::read(&path)? } else { Series::default() };
            let growth = verdict::growth(series.column(&section.signal).unwrap_or_default());
            Ok(Finding {
                verdict: Verdict::Failed,
                growth,
                note: cell(&why.chars().take(NOTE).collect::<String>()),
            })
        }
        Outcome::Done(_) => {
            let series = Series::read(&path)?;
            let signal = series.column(&section.signal).ok_or_else(|| {
                let there = series.names().join(", ");
                content(&path)(format!("has no column {}; there are {there}", section.signal))
            })?;
            let mut found = verdict::judge(signal, section.scale);
            let first = section
                .limits
                .iter()
                .filter_map(|limit| violation(limit, &series))
                .min_by_key(|(row, _)| *row);
            if let Some((row, note)) = first {
                // What follows (a grain flung out of the box, say) means nothing.
                let growth = verdict::growth(&signal[..=row]);
                found = Finding { verdict: Verdict::Failed, growth, note };
            }
            Ok(found)
        }
    }
}

/// The first row in which a run leaves what is possible, and how.
fn violation(limit: &Limit, series: &Series) -> Option<(usize, String)> {
    let column = series.column(&limit.column)?;
    let outside = |value: f64| {
        limit.least.is_some_and(|least| value < least) || limit.most.is_some_and(|most| value > most)
    };
    let mut times = series.time().iter().zip(column).enumerate();
    let (row, (time, value)) = times.find(|(_, (t, value))| **t >= limit.from && outside(**value))?;
    let bound = |end: Option<f64>, word: &str| end.map_or(String::new(), |end| format!(" {word} {end}"));
    let (least, most) = (bound(limit.least, "at least"), bound(limit.most, "at most"));
    Some((row, format!("{} = {value:.4} at t = {time:.4}; possible is{least}{most}", limit.column)))
}

fn row(point: &Point, finding: &Finding, section: &Stability, scene: &Path) -> Result<Row, Failure> {
    // With the bounds forced: a plan that may avoid one by other means (another scheme) is not the run's.
    let overrides = point.set.iter().cloned().chain(imposed()).collect();
    let options = RunOptions { overrides, ..RunOptions::of_scene(scene) };
    let label = &point.label;
    let plan = |failure| Failure::Input(format!("the run {label} cannot be planned: {failure}"));
    let bounds = Prepared::new(&options).map_err(plan)?.plan.bounds;
    let (margin, refused) = judged(&bounds, &section.bound);
    Ok(Row {
        values: point.values.clone(),
        verdict: finding.verdict,
        growth: finding.growth,
        margin,
        label: point.label.clone(),
        note: finding.note.clone(),
        refused,
    })
}

/// Margin of the bound `name` (`any`: the least of those that refuse), and whether it refuses the plan,
/// whatever the scene forces.
#[must_use]
pub fn judged(bounds: &[Bound], name: &str) -> (f64, bool) {
    let counts = |bound: &&Bound| if name == ANY { bound.level == Level::Refuse } else { bound.name == name };
    let margin = bounds.iter().filter(counts).map(|bound| bound.margin).reduce(f64::min);
    let refused = bounds.iter().filter(counts).any(|bound| bound.refuses(&[]));
    (margin.unwrap_or(f64::NAN), refused)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bounds::Side;

    #[test]
    fn a_limit_counts_from_its_time_on() {
        let series = Series::parse("t,v\n0.5,9\n1.0,1\n1.5,3\n").unwrap();
        let limit = |least, most, from| Limit { column: "v".into(), least, most, from };
        assert_eq!(violation(&limit(None, Some(5.0), 1.0), &series), None);
        let (row, note) = violation(&limit(None, Some(2.0), 1.0), &series).unwrap();
        assert_eq!(row, 2);
        assert!(note.contains("v = 3.0000 at t = 1.5000") && note.contains("at most 2"), "{note}");
        assert_eq!(violation(&limit(Some(1.5), None, 0.6), &series).unwrap().0, 1);
    }

    #[test]
    fn the_least_margin_counts_and_only_the_named_bound_refuses() {
        let bound = |name, value: f64| Bound::new(name, "x", value, Side::AtMost, 1.0);
        let bounds = vec![bound("cfl", 0.5), bound("resolution", 2.0).warning(), bound("overlap", 0.8)];
        assert_eq!(judged(&bounds, "any"), (1.25, false));
        assert_eq!(judged(&bounds, "resolution"), (0.5, false));
        assert!(judged(&bounds, "memory").0.is_nan());
        let broken = vec![bound("cfl", 4.0)];
        assert_eq!((judged(&broken, "any"), judged(&broken, "cfl")), ((0.25, true), (0.25, true)));
        assert!(!judged(&broken, "overlap").1, "another bound is not this map's business");
    }
}
