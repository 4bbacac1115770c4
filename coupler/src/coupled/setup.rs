//! From the plan of a coupled run to solvers that are ready.

use std::ffi::OsString;
use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};
use std::time::Duration;

use bedload_output::OutputFolder;
use bedload_program::{Interrupts, RunOptions, Setup};
use protocol::channel::{CouplerLink, Rendezvous, Waiting};
use protocol::participant::{ExchangeError, Role};
use protocol::scheme::Scheme;

use super::diagnosis::{alive, explain};
use super::link::CoupledLink;
use super::schedule::{CoupledSchedule, CoupledState};
use crate::descriptors;
use crate::failure::Failure;
use crate::prepare::Prepared;
use crate::solvers::Solver;
use crate::supervise::{StderrMode, Supervisor};

/// Makes the page of a finished run from its output folder.
pub type Report = fn(&Path) -> Result<PathBuf, Failure>;

/// Makes the report; a failure there costs no result.
pub(crate) fn draw(folder: &Path, report: Report) {
    match report(folder) {
        Ok(page) => protocol::detail!("bedload: wrote {}", page.display()),
        Err(error) => protocol::say!("bedload: warning: no report.html: {error}"),
    }
}

pub(crate) struct Coupled<'a> {
    pub(crate) options: &'a RunOptions,
    pub(crate) prepared: &'a Prepared,
    pub(crate) folder: &'a OutputFolder,
    pub(crate) interrupts: Interrupts,
    pub(crate) report: Report,
}

impl<'a> Setup for Coupled<'a> {
    type Link = CoupledLink<'a>;
    type Schedule = CoupledSchedule<'a>;

    fn write_scene(&self) -> Result<(), Failure> {
        write_scene(self.prepared, self.folder)
    }

    /// Starts the solvers and waits until they are ready.
    fn start(
        &self,
        from: Option<(PathBuf, CoupledState)>,
    ) -> Result<(CoupledLink<'a>, CoupledSchedule<'a>), Failure> {
        let Self { options, prepared, folder, interrupts, .. } = self;
        let exchange = |error: ExchangeError| match error {
            ExchangeError::NoRoom(text) => Failure::Full(text),
            other => Failure::Run(other.to_string()),
        };
        descriptors::allow(descriptors::COUPLED_RUN).map_err(Failure::Run)?;
        let rendezvous = rendezvous(prepared).map_err(exchange)?;
        let mut link = CouplerLink::create(&rendezvous).map_err(exchange)?;
        let mut supervisor = Supervisor::default();
        let (checkpoint, state) = from.unzip();
        start_solvers(options, prepared, folder, &mut supervisor, &link, checkpoint.as_deref())?;
        let ready = link.wait_ready(&mut || alive(&supervisor, interrupts, false, 0)).map_err(|error| {
            // A solver that ends needs a moment to be gone.
            supervisor.wait_all(Duration::from_millis(200));
            let failure = explain(&error, None, &supervisor);
            supervisor.end(Duration::from_millis(300));
            failure
        })?;
        let of_dem = ready.iter().find(|(role, _)| *role == Role::Dem);
        let substeps = of_dem.map_or(0, |(_, status)| status.substeps);
        let deadline = Duration::from_secs_f64(prepared.coupling.deadline);
        let link =
            CoupledLink::new(supervisor, link, &prepared.scene, deadline, interrupts.clone(), substeps);
        Ok((link, CoupledSchedule::new(prepared, state)))
    }

    fn summarised(&self, folder: &Path) {
        draw(folder, self.report);
    }
}

/// Writes the scene as the solvers read it, and the plan.
pub(crate) fn write_scene(prepared: &Prepared, folder: &OutputFolder) -> Result<(), Failure> {
    // The solvers read the scheme that the plan chose.
    let coupling = prepared.resolved_coupling()?;
    // What a solver did not resolve stays as the user wrote it.
    let fluid = prepared.fluid.as_ref().map(|fluid| &fluid.facts.resolved);
    let dem = prepared.dem.as_ref().map(|dem| &dem.facts.resolved);
    let [fluid, dem] = [fluid, dem].map(|section| section.filter(|section| !section.is_empty()));
    let sections = [fluid, dem, Some(&coupling)];
    folder.write_scene(&prepared.scene, sections)?;
    if prepared.has_others() {
        folder.write_scene_in_full(&prepared.scene, sections)?;
    }
    let plan =
        serde_json::to_string_pretty(&prepared.plan).map_err(|error| Failure::Run(error.to_string()))?;
    Ok(bedload_output::atomic_write(&folder.plan(), plan.as_bytes())?)
}

fn rendezvous(prepared: &Prepared) -> Result<Rendezvous, ExchangeError> {
    let coupling = &prepared.coupling;
    let mut rendezvous = Rendezvous::new(prepared.scene.grains.len())?;
    rendezvous.ahead = crate::scheme::AHEAD;
    rendezvous.repeatable = prepared.plan.scheme == Some(Scheme::Iterated);
    rendezvous.join_s = coupling.startup_deadline;
    // The coupler finds out first which solver hangs; the solvers give up last.
    rendezvous.deadline_s = 2.0 * coupling.deadline + 1.0;
    rendezvous.waiting = if coupling.spin { Waiting::Spin } else { Waiting::Event };
    Ok(rendezvous)
}

fn start_solvers(
    options: &RunOptions,
    prepared: &Prepared,
    folder: &OutputFolder,
    supervisor: &mut Supervisor,
    link: &CouplerLink,
    checkpoint: Option<&Path>,
) -> Result<(), Failure> {
    for solver in prepared.solvers().into_iter().flatten() {
        let scene = if solver.is_ours() { folder.scene() } else { folder.scene_in_full() };
        let arguments = serve_arguments(&scene, folder, link.rendezvous(), options.threads, checkpoint);
        start(supervisor, solver, &arguments, StderrMode::Kept)?;
    }
    Ok(())
}

/// Arguments of a solver that takes part in a run (interface: `serve`).
pub(crate) fn serve_arguments(
    scene: &Path,
    folder: &OutputFolder,
    rendezvous: &Rendezvous,
    threads: Option<NonZeroUsize>,
    checkpoint: Option<&Path>,
) -> Vec<OsString> {
    let mut arguments: Vec<OsString> = vec!["serve".into(), scene.into()];
    for (option, value) in [
        ("--connect", Some(rendezvous.token().into())),
        ("--out", Some(folder.root().into())),
        ("--threads", threads.map(|threads| threads.to_string().into())),
        ("--checkpoint", checkpoint.map(OsString::from)),
    ] {
        arguments.extend(value.into_iter().flat_map(|value: OsString| [option.into(), value]));
    }
    arguments
}

pub(crate) fn start(
    supervisor: &mut Supervisor,
    solver: &Solver,
    arguments: &[OsString],
    words: StderrMode,
) -> Result<(), Failure> {
    let command = solver.run_command();
    supervisor.start(solver.role, &command, arguments, words).map_err(|error| {
        Failure::Peer(format!("cannot start the {} solver `{}`: {error}", solver.role, command.join(" ")))
    })
}
