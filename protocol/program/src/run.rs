//! A run from its output folder to its summary, the same for a coupled run and a solver alone.

use std::path::{Path, PathBuf};

use bedload_output::{OutputFolder, RunStatus, Summary};
use bedload_scene::Motion;

use crate::checkpoint::{self, LoopState};
use crate::failure::Failure;
use crate::job::Job;
use crate::link::{End, Link, Schedule};
use crate::run_loop::RunLoop;

/// Version in `summary.json`.
pub const VERSION: &str = env!("CARGO_PKG_VERSION");

/// How the solvers of a run are started.
pub trait Setup {
    /// Where the solvers are.
    type Link: Link;
    /// Which windows they do.
    type Schedule: Schedule;

    /// Writes the scene, and what else describes the run, into its folder.
    ///
    /// # Errors
    /// [`Failure`] if the disk refuses.
    fn write_scene(&self) -> Result<(), Failure>;

    /// Starts the solvers, from a checkpoint folder with the state of the schedule in it, or from the scene.
    ///
    /// # Errors
    /// [`Failure`] if a solver does not start.
    #[allow(clippy::type_complexity)] // a pair
    fn start(
        &self,
        from: Option<(PathBuf, <Self::Schedule as Schedule>::State)>,
    ) -> Result<(Self::Link, Self::Schedule), Failure>;

    /// Called when the summary stands in the folder.
    fn summarised(&self, _folder: &Path) {}
}

/// The checkpoint that a run goes on from.
type From<S> = (PathBuf, LoopState<<<S as Setup>::Schedule as Schedule>::State>);

/// Runs a scene, from its start or from a checkpoint, to its end. After a failure of a solver, or of the
/// exchange, the folder holds a checkpoint of the window before.
///
/// # Errors
/// [`Failure`]; once the solvers were to start it also stands in `summary.json`.
pub fn run<S: Setup>(job: &Job<'_>, setup: &S) -> Result<(), Failure> {
    let (scene, folder) = (job.scene, job.folder);
    let mut from: Option<From<S>> = None;
    if job.resume {
        let (path, state): From<S> = checkpoint::latest(folder, &scene.state_sha256())?;
        // A run of another scene, or of one that ends earlier, is refused before it is called finished.
        scene.goes_on_from(state.observer.tally.simulated)?;
        if folder.is_finished_to(scene.scene.until) {
            let (program, root) = (job.program, folder.root().display());
            protocol::tell!(
                "{program}: {root} is finished: nothing to do; --until with a later time goes on"
            );
            return Ok(());
        }
        folder.remove_summary()?;
        from = Some((path, state));
    }
    setup.write_scene()?;
    let mut summary = Summary::new(scene, VERSION);
    let mut done = None;
    let outcome = once(job, setup, from, None, &mut summary, &mut done).and_then(|end| match end {
        End::Reached | End::Rewound => Ok(()),
        End::Interrupted => {
            Err(Failure::Interrupted(format!("go on with --resume --out {}", folder.root().display())))
        }
    });
    if summary.cost.wall_s == 0.0 {
        summary.cost.wall_s = job.begin.elapsed().as_secs_f64();
    }
    let free = scene.grains.iter().filter(|grain| grain.motion == Motion::Free).count();
    summary.set_unit_costs(free as u64);
    if let Err(gone) = folder.check_place() {
        // What stands at its path now is none of this run's business, nor is a checkpoint in it.
        return outcome.and(Err(gone.into()));
    }
    let failed = matches!(outcome, Err(Failure::Run(_) | Failure::Unstable(_)));
    let outcome = summarise(folder, &mut summary, outcome);
    setup.summarised(folder.root());
    if let (true, Some(step)) = (failed, done) {
        match rewind(job, setup, step) {
            Ok(at) => protocol::say!("{}: {at}", job.program),
            Err(failure) => {
                let program = job.program;
                protocol::say!("{program}: no checkpoint of the step before the failure: {failure}");
            }
        }
    }
    if let Err(Failure::Full(_)) = outcome
        && checkpoint::latest::<<S::Schedule as Schedule>::State>(folder, &scene.state_sha256()).is_ok()
    {
        protocol::say!("{}: --resume goes on from the last checkpoint, once there is room", job.program);
    }
    outcome
}

/// Writes how a run ended into `summary.json`.
///
/// # Errors
/// The failure of the run, or else that of the file.
pub fn summarise(
    folder: &OutputFolder,
    summary: &mut Summary,
    outcome: Result<(), Failure>,
) -> Result<(), Failure> {
    match &outcome {
        Ok(()) => summary.status = RunStatus::Completed,
        Err(Failure::Interrupted(_)) => summary.status = RunStatus::Interrupted,
        Err(failure @ Failure::Unstable(_)) => summary.end(RunStatus::Unstable, failure),
        Err(failure) => summary.fail(failure),
    }
    let written = summary.write(&folder.summary());
    outcome.and_then(|()| Ok(written?))
}

/// Starts the solvers and advances them, up to window `last` if one is given. `done`: windows done, once any
/// could be.
fn once<S: Setup>(
    job: &Job<'_>,
    setup: &S,
    from: Option<From<S>>,
    last: Option<u64>,
    summary: &mut Summary,
    done: &mut Option<u64>,
) -> Result<End, Failure> {
    let (start, output) = match from {
        None => (None, None),
        Some((path, state)) => {
            let motion = checkpoint::read_motion(&path, &job.scene.state_sha256())?;
            (Some((path, state.schedule)), Some((state.observer, state.cost, motion)))
        }
    };
    let (link, schedule) = setup.start(start)?;
    let mut run = RunLoop::with_output(link, schedule, job, output, last)?;
    let outcome = run.advance();
    *done = Some(run.done());
    let closed = run.close(summary, outcome.as_ref().ok().copied());
    let end = outcome?;
    closed?;
    Ok(end)
}

/// After a failure in window `step`: a checkpoint at its start, and a line about it.
///
/// A solver that fails in the middle of a window has lost the state at its start, and a copy in every window
/// would cost every run. The windows before are done again instead, bit for bit, from the last whole
/// checkpoint or from the start: at most `coupling.checkpoint_every` of work, and only after a failure.
fn rewind<S: Setup>(job: &Job<'_>, setup: &S, step: u64) -> Result<String, Failure> {
    let from: Option<From<S>> = checkpoint::latest(job.folder, &job.scene.state_sha256()).ok();
    let start = from.as_ref().map_or(0, |(_, state)| state.observer.tally.windows);
    if from.is_some() && start == step {
        return Ok(format!("the checkpoint stands at step {step}, before the failure"));
    }
    let program = job.program;
    protocol::tell!("{program}: doing steps {start} to {step} again for a checkpoint before the failure");
    // What was measured stands in the summary of the run that failed.
    let mut summary = Summary::new(job.scene, VERSION);
    match once(job, setup, from, Some(step), &mut summary, &mut None)? {
        End::Interrupted => Err(Failure::Interrupted("the last regular checkpoint stands".into())),
        End::Reached | End::Rewound => {
            let folder = job.folder.checkpoint();
            Ok(format!("checkpoint of step {step}, before the failure, in {}", folder.display()))
        }
    }
}
