//! The runs of the cases.

use std::num::NonZeroUsize;
use std::path::PathBuf;

use bedload_output::Summary;

use super::case::{Case, Run};
use crate::folder::{cores, make};
use crate::runs::{self, Outcome, Reuse, Task};
use coupler::failure::Failure;

/// What to validate, and how.
#[derive(Clone, Debug, Default)]
pub struct Validate {
    /// Names or files of cases; none: all there are.
    pub cases: Vec<String>,
    /// Only quick runs of quick cases.
    pub quick: bool,
    /// Runs at a time; by default as many as there are cores.
    pub jobs: Option<NonZeroUsize>,
    /// Folder of the runs, the page `validation.md` and `figures/`.
    pub out: PathBuf,
}

/// A case whose runs were made.
#[derive(Clone, Debug)]
pub(super) struct Made<'a> {
    pub(super) case: &'a Case,
    /// What became of each of its runs; none: `--quick` left it out.
    pub(super) outcomes: Vec<Option<Outcome>>,
    /// Folder of the runs' output folders.
    pub(super) folder: PathBuf,
}

impl<'a> Made<'a> {
    /// Every run with what became of it.
    pub(super) fn runs(&self) -> impl Iterator<Item = (&'a Run, Option<&Outcome>)> {
        self.case.runs.iter().zip(self.outcomes.iter().map(Option::as_ref))
    }

    /// Result of a run, if it left one.
    pub(super) fn result(&self, label: &str) -> Option<&Summary> {
        self.results().find(|(run, _)| run.label == label).map(|(_, summary)| summary)
    }

    /// Runs that left a result.
    pub(super) fn results(&self) -> impl Iterator<Item = (&'a Run, &Summary)> {
        self.runs().filter_map(|(run, outcome)| Some((run, outcome?.summary()?)))
    }
}

/// Runs every chosen run of every case.
pub(super) fn run_all<'a>(cases: &'a [Case], options: &Validate) -> Result<Vec<Made<'a>>, Failure> {
    let chosen: Vec<(usize, usize)> = cases
        .iter()
        .enumerate()
        .flat_map(|(c, case)| (0..case.runs.len()).map(move |r| (c, r)))
        .filter(|(c, r)| !options.quick || cases[*c].runs[*r].quick)
        .collect();
    for case in cases {
        make(&options.out.join(&case.name))?;
    }
    let jobs = options.jobs.map_or_else(cores, usize::from).clamp(1, chosen.len().max(1));
    let threads = (cores() / jobs).max(1);
    let task = |&(c, r): &(usize, usize)| task(&cases[c], &cases[c].runs[r], options, threads);
    let outcomes = runs::run_all(&chosen.iter().map(task).collect::<Vec<_>>(), jobs, Reuse::Completed)?;
    let folder = |case: &Case| options.out.join(&case.name);
    let made = |case| Made { case, outcomes: vec![None; case.runs.len()], folder: folder(case) };
    let mut all: Vec<Made<'_>> = cases.iter().map(made).collect();
    for ((c, r), outcome) in chosen.into_iter().zip(outcomes) {
        all[c].outcomes[r] = Some(outcome);
    }
    Ok(all)
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
