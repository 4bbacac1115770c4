//! A run with one solver under test: this process is the coupler and the other solver.

use std::collections::VecDeque;
use std::num::NonZeroUsize;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use bedload_output::OutputFolder;
use protocol::channel::{ConductorLink, Event, Rendezvous};
use protocol::message::{Command, Header, Kinematics, Loads, Order, Record, State, Status};
use protocol::participant::{ExchangeError, Role};
use protocol::scene::Grain;

use super::actor::{self, Lines, Part};
use crate::prepare::Prepared;
use crate::session::serve_arguments;
use crate::supervise::{Exit, Supervisor, Words};

/// Longest time for a solver to leave once it has to.
pub(super) const LEAVE: Duration = Duration::from_secs(10);

/// Longest time to join in a role that nobody said the command takes, s.
const PROBE: f64 = 5.0;

/// Who is tested, and on what.
pub(super) struct Stand {
    pub(super) role: Role,
    pub(super) command: Vec<String>,
    pub(super) prepared: Prepared,
    pub(super) folder: OutputFolder,
    /// Whether the role was not named, and has to be found out.
    pub(super) probing: bool,
    /// Whether the scene is the built-in one, of which more is known.
    pub(super) plain: bool,
}

/// What is special about a run.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Setting<'a> {
    pub(super) part: Part,
    pub(super) repeatable: bool,
    /// Longest time for an answer, s; by default that of the scene.
    pub(super) deadline: Option<f64>,
    pub(super) checkpoint: Option<&'a Path>,
    /// What the fluid sends, in place of half the weights.
    pub(super) loads: Option<&'a [Loads]>,
}

/// What a solver sent in one window, and what it said after it.
#[derive(Clone, Debug)]
pub(super) struct Turn {
    pub(super) header: Header,
    pub(super) records: Lines,
    pub(super) done: Status,
}

impl Stand {
    /// Window `step` at its place in time, of the planned length times `share`.
    pub(super) fn window(&self, step: u64, time: f64, share: f64, substeps: u64) -> Command {
        let dt = share * self.prepared.plan.steps.dt_fluid;
        Command { order: Order::Advance as u64, step, time, dt, substeps, ..Command::default() }
    }

    /// The first windows: of unequal lengths, with one sub-step, with many.
    pub(super) fn windows(&self, count: usize) -> Vec<Command> {
        const SHAPES: [(f64, u64); 6] = [(1.0, 8), (1.0, 8), (0.5, 1), (0.25, 3), (0.7, 20), (1.0, 7)];
        let mut time = 0.0;
        (0u64..)
            .zip(SHAPES.into_iter().cycle().take(count))
            .map(|(step, (share, substeps))| {
                let command = self.window(step, time, share, substeps);
                time += command.dt;
                command
            })
            .collect()
    }

    /// What the other side sends: loads of half the weight, upwards; or grains at rest where they began.
    fn lines(&self) -> Lines {
        let scene = &self.prepared.scene;
        match self.role {
            Role::Dem => Lines::Loads(
                scene
                    .grains
                    .iter()
                    .map(|grain| Loads {
                        force: scene.scene.gravity.map(|g| -0.5 * g * grain.mass()),
                        ..Loads::default()
                    })
                    .collect(),
            ),
            Role::Fluid => Lines::Kinematics(
                self.at_start().into_iter().map(|grain| Kinematics { velocity: [0.0; 3], ..grain }).collect(),
            ),
        }
    }

    /// The grains as they begin.
    pub(super) fn at_start(&self) -> Vec<Kinematics> {
        let begin = |grain: &Grain| Kinematics {
            position: grain.position,
            orientation: grain.orientation,
            velocity: grain.velocity,
            ..Kinematics::default()
        };
        self.prepared.scene.grains.iter().map(begin).collect()
    }

    /// A run of the scene's grains with the scene's limits.
    pub(super) fn rendezvous(&self, setting: Setting<'_>) -> Result<Rendezvous, String> {
        let coupling = &self.prepared.coupling;
        let mut rendezvous = Rendezvous::new(self.prepared.scene.grains.len()).map_err(text)?;
        rendezvous.repeatable = setting.repeatable;
        rendezvous.join_s =
            if self.probing { coupling.startup_deadline.min(PROBE) } else { coupling.startup_deadline };
        rendezvous.deadline_s = setting.deadline.unwrap_or(coupling.deadline);
        Ok(rendezvous)
    }

    /// Starts the solver under test as `bedload run` would.
    pub(super) fn start(
        &self,
        rendezvous: &Rendezvous,
        checkpoint: Option<&Path>,
    ) -> Result<Supervisor, String> {
        let others = self.prepared.has_others();
        let scene = if others { self.folder.scene_in_full() } else { self.folder.scene() };
        let arguments =
            serve_arguments(&scene, &self.folder, rendezvous, Some(NonZeroUsize::MIN), checkpoint);
        let mut supervisor = Supervisor::default();
        supervisor
            .start(self.role, &self.command, &arguments, Words::Quiet)
            .map_err(|error| format!("cannot start `{}`: {error}", self.command.join(" ")))?;
        Ok(supervisor)
    }

    /// Waits until the solver has left, at most `limit`.
    pub(super) fn leaves(&self, supervisor: &Supervisor, limit: Duration) -> Result<Exit, String> {
        if !supervisor.wait_all(limit) {
            return Err(format!("was still there after {:.1} s", limit.as_secs_f64()));
        }
        supervisor.exits().pop().ok_or_else(|| "is gone, and nobody knows how".into())
    }
}

/// A run under way.
pub(super) struct Stage<'a> {
    stand: &'a Stand,
    /// None once the coupler has left.
    link: Option<ConductorLink>,
    supervisor: Supervisor,
    actor: Option<JoinHandle<()>>,
    over: Arc<AtomicBool>,
    limit: Duration,
    /// Messages and reports of the solver that no window has claimed yet, and reports of the actor.
    sent: VecDeque<(Header, Lines)>,
    said: VecDeque<Status>,
    others: u64,
    /// What the solver said when it was ready.
    pub(super) ready: Status,
    /// Time that it took to join.
    pub(super) joined: Duration,
}

impl<'a> Stage<'a> {
    /// Founds a run, starts the solver and waits until it is ready.
    pub(super) fn open(stand: &'a Stand, setting: Setting<'_>) -> Result<Self, String> {
        let begin = Instant::now();
        let rendezvous = stand.rendezvous(setting)?;
        let link = ConductorLink::create(&rendezvous).map_err(text)?;
        let over = Arc::new(AtomicBool::new(false));
        let supervisor = stand.start(&rendezvous, setting.checkpoint)?;
        let lines = setting.loads.map_or_else(|| stand.lines(), |loads| Lines::Loads(loads.to_vec()));
        let actor = actor::enter(&rendezvous, lines, setting.part, &over, stand.folder.root());
        let mut stage = Self {
            stand,
            link: Some(link),
            supervisor,
            actor: Some(actor),
            over,
            limit: Duration::from_secs_f64(rendezvous.deadline_s),
            sent: VecDeque::new(),
            said: VecDeque::new(),
            others: 0,
            ready: Status::default(),
            joined: Duration::ZERO,
        };
        let Self { link, supervisor, .. } = &mut stage;
        let link = link.as_mut().ok_or("the coupler has left")?;
        let said = link.wait_ready(&mut || there(supervisor, stand.role, 0));
        let said = said.map_err(|error| stage.why(&error))?;
        let own = said.into_iter().find(|(role, _)| *role == stand.role);
        stage.ready = own.ok_or("never said Ready")?.1;
        stage.joined = begin.elapsed();
        Ok(stage)
    }

    /// An error with how the solver left and what it said last, if it has left.
    fn why(&self, error: &ExchangeError) -> String {
        // one that goes needs a moment to be gone
        self.supervisor.wait_all(Duration::from_millis(100));
        let words = self.supervisor.last_words(self.stand.role);
        let how = match self.supervisor.exits().pop() {
            Some(exit) => how(&exit),
            None => return error.to_string(),
        };
        if words.is_empty() {
            format!("{error}: {how}")
        } else {
            format!("{error}: {how}, its last words: {words}")
        }
    }

    /// Gives an order.
    pub(super) fn order(&mut self, command: Command) -> Result<(), String> {
        let link = self.link.as_mut().ok_or("the coupler has left")?;
        link.order(command).map_err(text)
    }

    /// Waits for the next thing that happens, and keeps it. A solver that was ordered ahead may be a window further
    /// than the other one.
    fn listen(&mut self, step: u64) -> Result<(), String> {
        let Self { link, supervisor, stand, limit, .. } = self;
        let link = link.as_mut().ok_or("the coupler has left")?;
        let event = link.next(*limit, &mut || there(supervisor, stand.role, step));
        match event.map_err(|error| self.why(&error))? {
            Event::Loads(lent) if self.stand.role == Role::Fluid => {
                self.sent.push_back((*lent.header(), Lines::Loads(lent.records().to_vec())));
            }
            Event::Kinematics(lent) if self.stand.role == Role::Dem => {
                self.sent.push_back((*lent.header(), Lines::Kinematics(lent.records().to_vec())));
            }
            Event::Status(role, status) if role == self.stand.role => self.said.push_back(status),
            Event::Status(..) => self.others += 1,
            Event::Loads(_) | Event::Kinematics(_) => {}
        }
        Ok(())
    }

    /// The next report of the solver under test.
    pub(super) fn report(&mut self, step: u64) -> Result<Status, String> {
        loop {
            match self.said.pop_front() {
                Some(status) => return Ok(status),
                None => self.listen(step)?,
            }
        }
    }

    /// What the solver sends and says of the window that `command` ordered, which is the first one without an answer.
    pub(super) fn turn(&mut self, command: &Command) -> Result<Turn, String> {
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
    pub(super) fn save(&mut self, step: u64) -> Result<Status, String> {
        self.order(Command { order: Order::Checkpoint as u64, step, ..Command::default() })?;
        while self.others == 0 {
            self.listen(step)?;
        }
        self.others -= 1;
        self.report(step)
    }

    /// Orders a window and waits for all that belongs to it.
    pub(super) fn play(&mut self, command: Command) -> Result<Turn, String> {
        self.order(command)?;
        self.turn(&command)
    }

    /// `Stop` between windows: the solver must say `Stopped` and leave with 0.
    pub(super) fn stop(&mut self) -> Result<(), String> {
        if self.sent.is_empty() {
            self.stop_unfinished()
        } else {
            Err("sent its records more than once in a window".into())
        }
    }

    /// `Stop` at any time.
    pub(super) fn stop_unfinished(&mut self) -> Result<(), String> {
        self.order(Command { order: Order::Stop as u64, ..Command::default() })?;
        self.over.store(true, Ordering::SeqCst);
        let said = self.report(0)?;
        if said.state != State::Stopped as u64 {
            return Err(format!("answered Stop with state {} (Stopped is 4): {}", said.state, said.text()));
        }
        let exit = self.stand.leaves(&self.supervisor, LEAVE)?;
        if exit.code() == Some(0) {
            Ok(())
        } else {
            Err(format!("after Stop it {}, 0 was expected", how(&exit)))
        }
    }

    /// The coupler leaves without a word.
    pub(super) fn abandon(&mut self) {
        self.link = None;
    }

    /// Waits until the solver has left.
    pub(super) fn leaves(&self, limit: Duration) -> Result<Exit, String> {
        self.stand.leaves(&self.supervisor, limit)
    }
}

impl Drop for Stage<'_> {
    fn drop(&mut self) {
        self.over.store(true, Ordering::SeqCst);
        self.link = None;
        self.supervisor.end(Duration::from_millis(300));
        if let Some(actor) = self.actor.take() {
            // It sees that coupler and solver have gone; a panic in it shows as its silence.
            let _ = actor.join();
        }
    }
}

/// How it left.
pub(super) fn how(exit: &Exit) -> String {
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
    pub(super) fn words(&self) -> Vec<Vec<u64>> {
        match &self.records {
            Lines::Loads(records) => records.iter().map(Record::words).collect(),
            Lines::Kinematics(records) => records.iter().map(Record::words).collect(),
        }
    }

    /// Name of the word `index` of a record.
    pub(super) fn field(&self, index: usize) -> String {
        match &self.records {
            Lines::Loads(_) => Loads::field_of_word(index),
            Lines::Kinematics(_) => Kinematics::field_of_word(index),
        }
    }
}

pub(super) fn text(error: impl std::fmt::Display) -> String {
    error.to_string()
}
