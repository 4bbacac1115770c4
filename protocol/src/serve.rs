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

use crate::channel::{Rendezvous, SharedMemory, Wire};
use crate::memory::peak_rss_bytes;
use crate::message::{Order, State, Status};
use crate::participant::{ExchangeError, Participant, SolverError, Window, WindowReport};

/// Reading the peak memory costs some 20 µs, so it is read this often at most.
const MEMORY_EVERY: Duration = Duration::from_secs(1);

/// Folder of the checkpoint at the start of window `step`. Each gets its own, so that a run killed
/// while writing one still has the one before.
#[must_use]
pub fn checkpoint_folder(out_dir: &Path, step: u64) -> PathBuf {
    out_dir.join("checkpoint").join(format!("{step:010}"))
}

/// What `bedload` starts a solver with: `COMMAND… serve SCENE --connect TOKEN --out DIR [--checkpoint DIR]`.
///
/// A solver with more options of its own takes them from its own command line, and calls [`serve()`].
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
    /// As [`Participant::read_checkpoint`], [`SharedMemory::join`] and [`serve()`].
    pub fn serve<P>(&self, participant: &mut P) -> Result<(), SolverError>
    where
        P: Participant,
        P::Incoming: Wire,
        P::Outgoing: Wire,
    {
        if let Some(folder) = &self.checkpoint {
            participant.read_checkpoint(folder)?;
        }
        let mut link = SharedMemory::join(&self.rendezvous, P::ROLE, participant.grains())?;
        serve(participant, &mut link, &self.out)
    }
}

/// Says `Ready`, then obeys the coupler until it says `Stop`.
///
/// # Errors
/// [`SolverError`] if the participant fails (the coupler is told why), if the peer or the coupler
/// dies or hangs, or if an order makes no sense.
pub fn serve<P>(
    participant: &mut P,
    link: &mut SharedMemory<P::Incoming, P::Outgoing>,
    out_dir: &Path,
) -> Result<(), SolverError>
where
    P: Participant,
    P::Incoming: Wire,
    P::Outgoing: Wire,
{
    let mut served = Served::new(out_dir, link.rendezvous().repeatable);
    let outcome = served.run(participant, link);
    match outcome {
        Ok(()) | Err(SolverError::Exchange(ExchangeError::Stopped)) => {
            served.memory = peak_rss_bytes();
            link.report(served.status(State::Stopped, participant, link))?;
            Ok(())
        }
        Err(error) => {
            let mut status = served.status(State::Failed, participant, link);
            status.set_text(&error.to_string());
            // The error counts, not whether the coupler still hears it.
            let _ = link.report(status);
            Err(error)
        }
    }
}

/// What the loop keeps between commands.
struct Served {
    out_dir: PathBuf,
    repeatable: bool,
    last: Option<Window>,
    /// Step and attempt of the command in work, for the answer.
    about: (u64, u64),
    report: WindowReport,
    substeps: u64,
    memory: u64,
    measured: Instant,
}

impl Served {
    fn new(out_dir: &Path, repeatable: bool) -> Self {
        Self {
            out_dir: out_dir.to_owned(),
            repeatable,
            last: None,
            about: (0, 0),
            report: WindowReport { dt_limit: f64::INFINITY, residual: 0.0, substeps: 0 },
            substeps: 0,
            memory: peak_rss_bytes(),
            measured: Instant::now(),
        }
    }

    fn run<P>(
        &mut self,
        participant: &mut P,
        link: &mut SharedMemory<P::Incoming, P::Outgoing>,
    ) -> Result<(), SolverError>
    where
        P: Participant,
        P::Incoming: Wire,
        P::Outgoing: Wire,
    {
        let mut ready = self.status(State::Ready, participant, link);
        ready.set_text(&Rendezvous::greeting());
        link.report(ready)?;
        loop {
            let command = link.next_command()?;
            self.about = (command.step, command.attempt);
            let order = Order::try_from(command.order)
                .map_err(|error| ExchangeError::Order { what: error.to_string() })?;
            match order {
                Order::Advance => self.advance(participant, link, command.into())?,
                Order::Repeat => self.repeat(participant, link, command.into())?,
                Order::Accept => self.accept(participant)?,
                Order::Checkpoint => self.checkpoint(participant, link)?,
                Order::Stop => return Ok(()),
            }
        }
    }

    fn advance<P>(
        &mut self,
        participant: &mut P,
        link: &mut SharedMemory<P::Incoming, P::Outgoing>,
        window: Window,
    ) -> Result<(), SolverError>
    where
        P: Participant,
        P::Incoming: Wire,
        P::Outgoing: Wire,
    {
        if self.repeatable {
            participant.save();
        }
        self.window(participant, link, window)?;
        if window.output && !self.repeatable {
            participant.write_fields(&window)?;
        }
        Ok(())
    }

    fn repeat<P>(
        &mut self,
        participant: &mut P,
        link: &mut SharedMemory<P::Incoming, P::Outgoing>,
        window: Window,
    ) -> Result<(), SolverError>
    where
        P: Participant,
        P::Incoming: Wire,
        P::Outgoing: Wire,
    {
        let last = self.last.map(|last| last.step);
        if !self.repeatable || last != Some(window.step) {
            return Err(SolverError::Exchange(ExchangeError::Order {
                what: format!(
                    "Repeat of window {} after window {last:?} in a run with repeatable = {}",
                    window.step, self.repeatable
                ),
            }));
        }
        participant.restore();
        self.window(participant, link, window)
    }

    fn window<P>(
        &mut self,
        participant: &mut P,
        link: &mut SharedMemory<P::Incoming, P::Outgoing>,
        window: Window,
    ) -> Result<(), SolverError>
    where
        P: Participant,
        P::Incoming: Wire,
        P::Outgoing: Wire,
    {
        self.report = participant.advance(&window, link)?;
        self.substeps += self.report.substeps;
        self.last = Some(window);
        link.report(self.status(State::Done, participant, link))?;
        if self.measured.elapsed() >= MEMORY_EVERY {
            self.memory = peak_rss_bytes();
            self.measured = Instant::now();
        }
        Ok(())
    }

    fn accept<P: Participant>(&mut self, participant: &mut P) -> Result<(), SolverError> {
        match self.last {
            Some(window) if window.output && self.repeatable => participant.write_fields(&window),
            _ => Ok(()),
        }
    }

    fn checkpoint<P>(
        &mut self,
        participant: &mut P,
        link: &mut SharedMemory<P::Incoming, P::Outgoing>,
    ) -> Result<(), SolverError>
    where
        P: Participant,
        P::Incoming: Wire,
        P::Outgoing: Wire,
    {
        let folder = checkpoint_folder(&self.out_dir, self.about.0);
        std::fs::create_dir_all(&folder)
            .map_err(|source| SolverError::File { path: folder.display().to_string(), source })?;
        participant.write_checkpoint(&folder)?;
        link.report(self.status(State::Saved, participant, link))?;
        Ok(())
    }

    fn status<P>(
        &self,
        state: State,
        participant: &P,
        link: &SharedMemory<P::Incoming, P::Outgoing>,
    ) -> Status
    where
        P: Participant,
        P::Incoming: Wire,
        P::Outgoing: Wire,
    {
        Status {
            state: state as u64,
            step: self.about.0,
            attempt: self.about.1,
            dt_limit: self.report.dt_limit,
            solver_s: participant.solver_seconds(),
            exchange_s: link.exchange_seconds(),
            residual: self.report.residual,
            peak_rss: self.memory,
            process: u64::from(std::process::id()),
            grains: participant.grains() as u64,
            substeps: self.substeps,
            pressure_gradient: participant.pressure_gradient(),
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
