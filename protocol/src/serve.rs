//! The loop of a solver in a coupled run: it obeys the coupler's commands until `Stop`.
//!
//! | order | the solver does | and answers |
//! |---|---|---|
//! | `Advance` | saves its state if the run is repeatable, does the window | `Done` |
//! | `Repeat` | restores that state, does the window with the new values | `Done` |
//! | `Accept` | writes the fields of the last window if that was asked for | nothing |
//! | `Checkpoint` | writes a checkpoint ([`checkpoint_folder`]) | `Saved` |
//! | `Stop` | leaves | `Stopped` |
//!
//! In a run that is not repeatable nothing is saved, and fields are written right after their window.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use crate::channel::{Connection, Rendezvous, Wire};
use crate::memory::peak_rss_bytes;
use crate::message::{Order, State, Status};
use crate::participant::{ExchangeError, Participant, SolverError, Window, WindowReport};

/// Reading the peak memory costs some 20 µs, so it is read this often at most.
const MEMORY_EVERY: Duration = Duration::from_secs(1);

/// Folder of the checkpoint at the start of window `step`. Each gets its own, so that a run killed
/// while writing one still has the one before.
pub fn checkpoint_folder(out_dir: &Path, step: u64) -> PathBuf {
    out_dir.join("checkpoint").join(format!("{step:010}"))
}

/// What `bedload` starts a solver with: `COMMAND… serve SCENE --connect TOKEN --out DIR [--checkpoint DIR]`.
///
/// A solver with more options of its own takes them from its own command line, and calls [`serve()`].
///
/// ```no_run
/// use protocol::channel::Wire;
/// use protocol::participant::{Participant, SolverError};
/// use protocol::serve::Invitation;
///
/// /// The whole `main` of a solver, given what reads its scene.
/// fn main_of<P>(read: impl Fn(&std::path::Path) -> Result<P, SolverError>) -> Result<(), SolverError>
/// where
///     P: Participant,
///     P::Incoming: Wire<Answer = P::Outgoing>,
/// {
///     let invitation = Invitation::from_arguments(std::env::args().skip(1))?;
///     invitation.serve(&mut read(&invitation.scene)?)
/// }
/// ```
#[derive(Clone, Debug)]
pub struct Invitation {
    /// The scene, resolved.
    pub scene: PathBuf,
    /// Where to meet the others.
    pub rendezvous: Rendezvous,
    /// Folder for its files.
    pub out: PathBuf,
    /// Checkpoint folder to start from.
    pub checkpoint: Option<PathBuf>,
}

impl Invitation {
    /// Reads the words of the command line; those that it does not know it passes over.
    ///
    /// # Errors
    /// [`ExchangeError::Transport`] if one is missing, and as [`Rendezvous::parse`].
    pub fn from_arguments(words: impl IntoIterator<Item = String>) -> Result<Self, ExchangeError> {
        let words: Vec<String> = words.into_iter().collect();
        let after = |name: &str| words.windows(2).find(|pair| pair[0] == name).map(|pair| &pair[1]);
        let [Some(scene), Some(token), Some(out)] = ["serve", "--connect", "--out"].map(after) else {
            let what = "is started by bedload, with: serve SCENE --connect TOKEN --out DIR";
            return Err(ExchangeError::Transport(what.into()));
        };
        let rendezvous = Rendezvous::parse(token)?;
        let checkpoint = after("--checkpoint").map(PathBuf::from);
        Ok(Self { scene: scene.into(), rendezvous, out: out.into(), checkpoint })
    }

    /// Goes to the checkpoint if there is one, joins the run and obeys until the coupler says `Stop`.
    ///
    /// # Errors
    /// As [`Participant::read_checkpoint`], [`Wire::join`] and [`serve()`].
    pub fn serve<P>(&self, participant: &mut P) -> Result<(), SolverError>
    where
        P: Participant,
        P::Incoming: Wire<Answer = P::Outgoing>,
    {
        if let Some(folder) = &self.checkpoint {
            participant.read_checkpoint(folder)?;
        }
        let mut link = P::Incoming::join(&self.rendezvous, P::ROLE, participant.grains())?;
        serve(participant, &mut *link, &self.out)
    }
}

/// Says `Ready`, then obeys the coupler until it says `Stop`.
///
/// # Errors
/// [`SolverError`] if the participant fails (the coupler is told why), if the peer or the coupler
/// dies or hangs, or if an order makes no sense.
pub fn serve<P>(
    participant: &mut P,
    link: &mut dyn Connection<P::Incoming, P::Outgoing>,
    out_dir: &Path,
) -> Result<(), SolverError>
where
    P: Participant,
{
    let repeatable = link.rendezvous().repeatable;
    let mut served = Served {
        participant,
        link,
        out_dir,
        repeatable,
        last: None,
        about: (0, 0),
        report: WindowReport { dt_limit: f64::INFINITY, residual: 0.0, substeps: 0 },
        substeps: 0,
        memory: peak_rss_bytes(),
        measured: Instant::now(),
        totals: Vec::new(),
    };
    match served.run() {
        Ok(()) | Err(SolverError::Exchange(ExchangeError::Stopped)) => {
            served.memory = peak_rss_bytes();
            served.answer(State::Stopped)
        }
        Err(error) => {
            // The error counts, not whether the coupler still hears it.
            let _ = served.say(State::Failed, &error.to_string());
            Err(error)
        }
    }
}

/// What the loop keeps between commands.
struct Served<'a, P: Participant> {
    participant: &'a mut P,
    link: &'a mut dyn Connection<P::Incoming, P::Outgoing>,
    out_dir: &'a Path,
    repeatable: bool,
    last: Option<Window>,
    /// Step and attempt of the command in work, for the answer.
    about: (u64, u64),
    report: WindowReport,
    substeps: u64,
    memory: u64,
    measured: Instant,
    /// What `observe.totals` asks for, of the last window.
    totals: Vec<f64>,
}

impl<P: Participant> Served<'_, P> {
    fn run(&mut self) -> Result<(), SolverError> {
        self.say(State::Ready, &Rendezvous::greeting())?;
        loop {
            let command = self.link.next_command()?;
            self.about = (command.step, command.attempt);
            match Order::try_from(command.order).map_err(|error| ExchangeError::Order(error.to_string()))? {
                Order::Advance => self.advance(command.into())?,
                Order::Repeat => self.repeat(command.into())?,
                Order::Accept => self.accept()?,
                Order::Checkpoint => self.checkpoint()?,
                Order::Stop => return Ok(()),
            }
        }
    }

    fn advance(&mut self, window: Window) -> Result<(), SolverError> {
        if self.repeatable {
            self.participant.save();
        }
        self.window(window)?;
        if window.output && !self.repeatable {
            self.participant.write_fields(&window)?;
        }
        Ok(())
    }

    fn repeat(&mut self, window: Window) -> Result<(), SolverError> {
        let last = self.last.map(|last| last.step);
        if !self.repeatable || last != Some(window.step) {
            let what = format!(
                "Repeat of window {} after window {last:?} in a run with repeatable = {}",
                window.step, self.repeatable
            );
            return Err(ExchangeError::Order(what).into());
        }
        self.participant.restore();
        self.window(window)
    }

    fn window(&mut self, window: Window) -> Result<(), SolverError> {
        self.report = self.participant.advance(&window, self.link)?;
        self.substeps += self.report.substeps;
        self.last = Some(window);
        self.totals.clear();
        self.participant.totals(&mut self.totals);
        let mut status = self.status(State::Done);
        if !self.totals.is_empty() {
            status.set_numbers(&self.totals);
        }
        self.link.report(status)?;
        if self.measured.elapsed() >= MEMORY_EVERY {
            self.memory = peak_rss_bytes();
            self.measured = Instant::now();
        }
        Ok(())
    }

    fn accept(&mut self) -> Result<(), SolverError> {
        match self.last {
            Some(window) if window.output && self.repeatable => self.participant.write_fields(&window),
            _ => Ok(()),
        }
    }

    fn checkpoint(&mut self) -> Result<(), SolverError> {
        let folder = checkpoint_folder(self.out_dir, self.about.0);
        std::fs::create_dir_all(&folder)
            .map_err(|source| SolverError::File { path: folder.display().to_string(), source })?;
        self.participant.write_checkpoint(&folder)?;
        self.answer(State::Saved)
    }

    fn answer(&mut self, state: State) -> Result<(), SolverError> {
        Ok(self.link.report(self.status(state))?)
    }

    /// An answer with a text.
    fn say(&mut self, state: State, text: &str) -> Result<(), SolverError> {
        let mut status = self.status(state);
        status.set_text(text);
        Ok(self.link.report(status)?)
    }

    fn status(&self, state: State) -> Status {
        Status {
            state: state as u64,
            step: self.about.0,
            attempt: self.about.1,
            dt_limit: self.report.dt_limit,
            solver_s: self.participant.solver_seconds(),
            exchange_s: self.link.exchange_seconds(),
            residual: self.report.residual,
            peak_rss: self.memory,
            process: u64::from(std::process::id()),
            grains: self.participant.grains() as u64,
            substeps: self.substeps,
            pressure_gradient: self.participant.pressure_gradient(),
            ..Status::default()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn peak_memory_follows_a_large_block() {
        let before = peak_rss_bytes();
        let block = vec![1u8; 64 << 20];
        assert_eq!(block.iter().map(|byte| u64::from(*byte)).sum::<u64>(), 64 << 20);
        assert!(before > 0 && peak_rss_bytes() >= before.max(64 << 20));
    }
}
