//! The runs of a map: what each sets besides its varied keys, and what became of it.

use bedload_output::{RunStatus, Series, Summary};

use super::classify::{self, Class, Finding};
use crate::folder::content;
use crate::runs::{Outcome, Task, at_a_time};
use crate::section::{ANY, Limit, Section};
use crate::study::Study;
use crate::table::{Row, Table, cell};
use coupler::bounds::{Bound, Level, NAMES};
use coupler::failure::Failure;
use coupler::prepare::Prepared;

/// Characters of a note that are kept: an error names its cause first.
const NOTE: usize = 160;

/// Classifies every run of the table, and holds the bound against it; `runs` are in the order of the rows.
pub(crate) fn classify(
    study: &Study,
    table: &mut Table,
    runs: &[(Task, Outcome)],
    jobs: usize,
) -> Result<(), Failure> {
    // Each asks the solvers for their facts, which are processes: several at a time, too.
    let one = |(row, (task, outcome)): &(Row, &(Task, Outcome))| {
        // With the bounds forced: a plan that may avoid one by other means (another scheme) is not the run's.
        let plan = task.options().and_then(|options| Prepared::new(&options));
        if let (Err(Failure::Scene(_) | Failure::Input(_)), Outcome::Failed(why)) = (&plan, outcome) {
            return Ok(Row { class: Some(Class::Failed), refused: true, note: note(why), ..row.clone() });
        }
        let unplanned =
            |failure| Failure::Input(format!("the run {} cannot be planned: {failure}", task.name));
        let bounds = plan.map_err(unplanned)?.plan.bounds;
        let found = finding(&study.section, task, outcome)?;
        let (margin, refused) = held(&bounds, &study.section.bound);
        let margin = Some(margin).filter(|margin| !margin.is_nan());
        let growth = Some(found.growth).filter(|growth| !growth.is_nan());
        let note = found.note;
        Ok(Row { class: Some(found.class), growth, margin, refused, note, ..row.clone() })
    };
    let fault = || Err(Failure::Run("not every run was planned: report this as a fault".into()));
    let rows: Vec<(Row, &(Task, Outcome))> = table.rows.iter().cloned().zip(runs).collect();
    let rows = at_a_time(jobs, &rows, one).into_iter().map(|row| row.unwrap_or_else(fault));
    table.rows = rows.collect::<Result<_, _>>()?;
    // Refused at its start, a run has no margin; where all are, the scene is at fault.
    match table.rows.first() {
        Some(Row { label, note, .. }) if table.rows.iter().all(|row| row.refused && row.margin.is_none()) => {
            Err(Failure::Input(format!("every run is refused at its start; {label}: {note}")))
        }
        _ => Ok(()),
    }
}

/// Why a run failed, for the table.
fn note(why: &str) -> String {
    cell(&why.chars().take(NOTE).collect::<String>())
}

/// Keys that every run sets: no bound stops it, every window is in the series, and nothing is logged.
pub fn imposed() -> [String; 3] {
    let names: Vec<String> = NAMES.iter().map(|name| format!("{name:?}")).collect();
    [
        format!("coupling.force=[{}]", names.join(", ")),
        "observe.every=0.0".to_owned(),
        "coupling.record=false".to_owned(),
    ]
}

/// What became of a run.
fn finding(section: &Section, task: &Task, outcome: &Outcome) -> Result<Finding, Failure> {
    let path = task.folder.join("series.csv");
    match outcome {
        Outcome::Failed(why) => {
            // A run that left no summary was no run: a solver is missing, say.
            let summary = Summary::read(&task.folder.join("summary.json")).ok();
            if summary
                .is_none_or(|summary| !matches!(summary.status, RunStatus::Failed | RunStatus::Unstable))
            {
                return Err(Failure::Input(format!("the run {} could not be made: {why}", task.name)));
            }
            let series = if path.is_file() { Series::read(&path)? } else { Series::default() };
            let growth = classify::growth(series.column(&section.signal).unwrap_or_default());
            Ok(Finding { class: Class::Failed, growth, note: note(why) })
        }
        Outcome::Done(_) => {
            let series = Series::read(&path)?;
            let signal = series.column(&section.signal).ok_or_else(|| {
                let there = series.names().join(", ");
                content(&path)(format!("has no column {}; there are {there}", section.signal))
            })?;
            let mut found = classify::classify(signal, section.scale);
            let first = section
                .limits
                .iter()
                .filter_map(|limit| violation(limit, &series))
                .min_by_key(|(row, _)| *row);
            if let Some((row, note)) = first {
                // What follows (a grain flung out of the box, say) means nothing.
                let growth = classify::growth(&signal[..=row]);
                found = Finding { class: Class::Failed, growth, note };
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

/// Margin of the bound `name` (`any`: the least of those that refuse), and whether it refuses the plan,
/// whatever the scene forces.
pub fn held(bounds: &[Bound], name: &str) -> (f64, bool) {
    let counts = |bound: &&Bound| if name == ANY { bound.level == Level::Refuse } else { bound.name == name };
    let margin = bounds.iter().filter(counts).map(|bound| bound.margin).reduce(f64::min);
    let refused = bounds.iter().filter(counts).any(|bound| bound.refuses(&[]));
    (margin.unwrap_or(f64::NAN), refused)
}

#[cfg(test)]
mod tests {
    use super::*;
    use coupler::bounds::Side;

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
        assert_eq!(held(&bounds, "any"), (1.25, false));
        assert_eq!(held(&bounds, "resolution"), (0.5, false));
        assert!(held(&bounds, "memory").0.is_nan());
        let broken = vec![bound("cfl", 4.0)];
        assert_eq!((held(&broken, "any"), held(&broken, "cfl")), ((0.25, true), (0.25, true)));
        assert!(!held(&broken, "overlap").1, "another bound is not this map's business");
    }
}
