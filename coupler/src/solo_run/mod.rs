//! A run with one solver at work: this process is the coupler and the other solver.
//!
//! `bedload conformance` tests a solver so, `bedload replay` drives one from a log.

mod fake_peer;

use std::collections::VecDeque;
use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Sender, channel};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use bedload_output::OutputFolder;
use bedload_scene::CheckedScene;
use protocol::channel::{CouplerLink, Event, Rendezvous};
use protocol::log::Records;
use protocol::message::{Command, Header, Kinematics, Loads, Order, Record, State, Status};
use protocol::participant::{ExchangeError, Role};

use crate::config::Coupling;
use crate::coupled::serve_arguments;
use crate::descriptors;
use crate::supervise::{Exit, StderrMode, Supervisor};

use fake_peer::Instructions;
pub(crate) use fake_peer::{Fault, FaultFrom};

/// Longest time for a solver to leave once it has to.
pub(crate) const LEAVE: Duration = Duration::from_secs(10);

/// Who is at work, and on what.
pub(crate) struct Setup {
    pub(crate) role: Role,
    /// Executable and leading arguments.
    pub(crate) command: Vec<String>,
    pub(crate) scene: CheckedScene,
    pub(crate) coupling: Coupling,
    pub(crate) folder: OutputFolder,
    /// The scene's file in there that it is given.
    pub(crate) file: PathBuf,
    /// Longest time for it to join, s.
    pub(crate) join_s: f64,
}

/// What is special about a run.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Setting<'a> {
    pub(crate) fault: FaultFrom,
    pub(crate) repeatable: bool,
    /// Longest time for an answer, s; by default that of the scene.
    pub(crate) deadline: Option<f64>,
    pub(crate) checkpoint: Option<&'a Path>,
}

/// What a solver sent in one window, and what it said after it.
#[derive(Clone, Debug)]
pub(crate) struct Turn {
    pub(crate) header: Header,
    pub(crate) records: Records,
    pub(crate) done: Status,
}

impl Setup {
    /// A run of the scene's grains with the scene's limits.
    pub(crate) fn rendezvous(&self, setting: Setting<'_>) -> Result<Rendezvous, String> {
        descriptors::allow(descriptors::COUPLED_RUN)?;
        let mut rendezvous = Rendezvous::new(self.scene.grains.len()).map_err(text)?;
        rendezvous.repeatable = setting.repeatable;
        rendezvous.join_s = self.join_s;
        rendezvous.deadline_s = setting.deadline.unwrap_or(self.coupling.deadline);
        Ok(rendezvous)
    }

    /// Starts the solver as `bedload run` would.
    pub(crate) fn start(
        &self,
        rendezvous: &Rendezvous,
        checkpoint: Option<&Path>,
    ) -> Result<Supervisor, String> {
        let arguments =
            serve_arguments(&self.file, &self.folder, rendezvous, Some(NonZeroUsize::MIN), checkpoint);
        let mut supervisor = Supervisor::default();
        supervisor
            .start(self.role, &self.command, &arguments, StderrMode::Quiet)
            .map_err(|error| format!("cannot start `{}`: {error}", self.command.join(" ")))?;
        Ok(supervisor)
    }
}

pub(crate) struct SoloRun<'a> {
    setup: &'a Setup,
    /// None once the coupler has left.
    link: Option<CouplerLink>,
    pub(crate) supervisor: Supervisor,
    peer: Option<JoinHandle<()>>,
    replacements: Sender<Records>,
    over: Arc<AtomicBool>,
    limit: Duration,
    /// Messages and reports of the solver that no window has claimed yet, and reports of the peer.
    sent: VecDeque<(Header, Records)>,
    said: VecDeque<Status>,
    others: u64,
    /// What the solver said when it was ready.
    pub(crate) ready: Status,
    pub(crate) joined: Duration,
}

impl<'a> SoloRun<'a> {
    /// Founds a run, starts the solver and waits until it is ready. The other side sends `records` until
    /// [`SoloRun::replace`] gives it others.
    pub(crate) fn open(setup: &'a Setup, records: Records, setting: Setting<'_>) -> Result<Self, String> {
        let begin = Instant::now();
        let rendezvous = setup.rendezvous(setting)?;
        let link = CouplerLink::create(&rendezvous).map_err(text)?;
        let over = Arc::new(AtomicBool::new(false));
        let supervisor = setup.start(&rendezvous, setting.checkpoint)?;
        let (replacements, replaced) = channel();
        let instructions = Instructions { records, replaced, fault: setting.fault, over: over.clone() };
        let peer = fake_peer::start(&rendezvous, instructions, setup.folder.root());
        let mut run = Self {
            setup,
            link: Some(link),
            supervisor,
            peer: Some(peer),
            replacements,
            over,
            limit: Duration::from_secs_f64(rendezvous.deadline_s),
            sent: VecDeque::new(),
            said: VecDeque::new(),
            others: 0,
            ready: Status::default(),
            joined: Duration::ZERO,
        };
        let Self { link, supervisor, .. } = &mut run;
        let link = link.as_mut().ok_or("the coupler has left")?;
        let said = link.wait_ready(&mut || there(supervisor, setup.role, 0));
        let said = said.map_err(|error| run.why(&error))?;
        let own = said.into_iter().find(|(role, _)| *role == setup.role);
        run.ready = own.ok_or("never said Ready")?.1;
        run.joined = begin.elapsed();
        Ok(run)
    }

    /// An error with how the solver left and what it said last, if it has left.
    fn why(&self, error: &ExchangeError) -> String {
        // one that goes needs a moment to be gone
        self.supervisor.wait_all(Duration::from_millis(100));
        let Some(exit) = self.supervisor.exits().pop() else { return error.to_string() };
        match self.supervisor.last_words(self.setup.role) {
            words if words.is_empty() => format!("{error}: {}", how(&exit)),
            words => format!("{error}: {}, its last words: {words}", how(&exit)),
        }
    }

    /// Gives the other side what it sends from the window on that is ordered next.
    pub(crate) fn replace(&self, records: Records) {
        // An peer that has left shows as its silence.
        let _ = self.replacements.send(records);
    }

    pub(crate) fn order(&mut self, command: Command) -> Result<(), String> {
        let link = self.link.as_mut().ok_or("the coupler has left")?;
        link.order(command).map_err(text)
    }

    /// Waits for the next thing that happens, and keeps it. A solver that was ordered ahead may be a window
    /// further than the other one.
    fn listen(&mut self, step: u64) -> Result<(), String> {
        let Self { link, supervisor, setup, limit, .. } = self;
        let link = link.as_mut().ok_or("the coupler has left")?;
        let event = link.next(*limit, &mut || there(supervisor, setup.role, step));
        match event.map_err(|error| self.why(&error))? {
            Event::Loads(lent) if self.setup.role == Role::Fluid => {
                self.sent.push_back((*lent.header(), Records::Loads(lent.records().to_vec())));
            }
            Event::Kinematics(lent) if self.setup.role == Role::Dem => {
                self.sent.push_back((*lent.header(), Records::Kinematics(lent.records().to_vec())));
            }
            Event::Status(role, status) if role == self.setup.role => self.said.push_back(status),
            Event::Status(..) => self.others += 1,
            Event::Loads(_) | Event::Kinematics(_) => {}
        }
        Ok(())
    }

    /// The next report of the solver under test.
    pub(crate) fn report(&mut self, step: u64) -> Result<Status, String> {
        loop {
            match self.said.pop_front() {
                Some(status) => return Ok(status),
                None => self.listen(step)?,
            }
        }
    }

    /// What the solver sends and says of the window that `command` ordered, which is the first one without an
    /// answer.
    pub(crate) fn turn(&mut self, command: &Command) -> Result<Turn, String> {
        loop {
            if let Some(failed) = self.said.iter().find(|status| status.state == State::Failed as u64) {
                return Err(format!("failed in window {}: {}", command.step, failed.text()));
            }
            if self.others > 0 && !self.sent.is_empty() && !self.said.is_empty() {
                break;
            }
            self.listen(command.step)?;
        }
        self.others -= 1;
        let ((header, records), done) =
            self.sent.pop_front().zip(self.said.pop_front()).ok_or("sent nothing")?;
        Ok(Turn { header, records, done })
    }

    /// `Checkpoint` before window `step`; returns what the solver answers.
    pub(crate) fn save(&mut self, step: u64) -> Result<Status, String> {
        self.order(Command { order: Order::Checkpoint as u64, step, ..Command::default() })?;
        while self.others == 0 {
            self.listen(step)?;
        }
        self.others -= 1;
        self.report(step)
    }

    pub(crate) fn has_failed(&self) -> bool {
        self.said.iter().any(|status| status.state == State::Failed as u64)
    }

    /// Orders a window and waits for all that belongs to it.
    pub(crate) fn play(&mut self, command: Command) -> Result<Turn, String> {
        self.order(command)?;
        self.turn(&command)
    }

    /// `Stop` between windows: the solver must say `Stopped` and leave with 0.
    pub(crate) fn stop(&mut self) -> Result<(), String> {
        if !self.sent.is_empty() {
            return Err("sent its records more than once in a window".into());
        }
        self.stop_unfinished()
    }

    /// `Stop` at any time.
    pub(crate) fn stop_unfinished(&mut self) -> Result<(), String> {
        self.order(Command { order: Order::Stop as u64, ..Command::default() })?;
        self.over.store(true, Ordering::SeqCst);
        let said = self.report(0)?;
        if said.state != State::Stopped as u64 {
            return Err(format!("answered Stop with state {} (Stopped is 4): {}", said.state, said.text()));
        }
        let exit = self.supervisor.leaves(LEAVE)?;
        match exit.code() {
            Some(0) => Ok(()),
            _ => Err(format!("after Stop it {}, 0 was expected", how(&exit))),
        }
    }

    /// The coupler leaves without a word.
    pub(crate) fn abandon(&mut self) {
        self.link = None;
    }
}

impl Drop for SoloRun<'_> {
    fn drop(&mut self) {
        self.over.store(true, Ordering::SeqCst);
        self.link = None;
        self.supervisor.end(Duration::from_millis(300));
        if let Some(peer) = self.peer.take() {
            // It sees that coupler and solver have gone; a panic in it shows as its silence.
            let _ = peer.join();
        }
    }
}

pub(crate) fn how(exit: &Exit) -> String {
    match exit.status {
        Some(status) => status.to_string(),
        None => "gone".into(),
    }
}

/// An error once the solver has left with another code than 0.
fn there(supervisor: &Supervisor, role: Role, step: u64) -> Result<(), ExchangeError> {
    let bad = supervisor.any_exit() && supervisor.exits().iter().any(|exit| exit.code() != Some(0));
    if bad { Err(ExchangeError::PeerDied { peer: role.to_string(), step }) } else { Ok(()) }
}

impl Turn {
    /// The records as words, to compare bit by bit.
    pub(crate) fn words(&self) -> Vec<Vec<u64>> {
        match &self.records {
            Records::Loads(records) => records.iter().map(Record::words).collect(),
            Records::Kinematics(records) => records.iter().map(Record::words).collect(),
        }
    }

    /// Name of the word `index` of a record.
    pub(crate) fn field(&self, index: usize) -> String {
        match &self.records {
            Records::Loads(_) => Loads::field_of_word(index),
            Records::Kinematics(_) => Kinematics::field_of_word(index),
        }
    }
}

pub(crate) fn text(error: impl std::fmt::Display) -> String {
    error.to_string()
}
