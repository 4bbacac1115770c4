//! The runs of the cases.

use super::Validate;
use super::case::{Case, Run};
use crate::failure::Failure;
use crate::study::folder::make;
use crate::study::{self as sweep, Keep, Task};

/// What became of a run.
#[derive(Clone, Debug)]
pub(super) enum Outcome {
    /// It left a result.
    Done(Box<bedload_output::Summary>),
    /// It left none, and why.
    Failed(String),
    /// `--quick` left it out.
    LeftOut,
}

impl From<sweep::Outcome> for Outcome {
    fn from(outcome: sweep::Outcome) -> Self {
        match outcome {
            sweep::Outcome::Done(summary) => Self::Done(summary),
            sweep::Outcome::Failed(why) => Self::Failed(why),
        }
    }
}

/// Runs every chosen run of every case; outcomes by case, in the order of its runs.
pub(super) fn run_all(cases: &[Case], options: &Validate) -> Result<Vec<Vec<Outcome>>, Failure> {
    let chosen: Vec<(usize, usize)> = cases
        .iter()
        .enumerate()
        .flat_map(|(c, case)| (0..case.runs.len()).map(move |r| (c, r)))
        .filter(|(c, r)| !options.quick || cases[*c].runs[*r].quick)
        .collect();
    for case in cases {
        let folder = options.out.join(&case.name);
        make(&folder)?;
    }
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let jobs = options.jobs.map_or(cores, usize::from).clamp(1, chosen.len().max(1));
    let threads = (cores / jobs).max(1);
    let task = |&(c, r): &(usize, usize)| task(&cases[c], &cases[c].runs[r], options, threads);
    let made = sweep::run_all(&chosen.iter().map(task).collect::<Vec<_>>(), jobs, Keep::Completed)?;
    let mut outcomes: Vec<Vec<Outcome>> =
        cases.iter().map(|case| vec![Outcome::LeftOut; case.runs.len()]).collect();
    for ((c, r), outcome) in chosen.into_iter().zip(made) {
        outcomes[c][r] = outcome.into();
    }
    Ok(outcomes)
}

fn task(case: &Case, run: &Run, options: &Validate, threads: usize) -> Task {
    Task {
        name: format!("{}/{}", case.name, run.label),
        scene: case.scene(run),
        set: run.set.clone(),
        folder: options.out.join(&case.name).join(&run.label),
        threads,
    }
}
