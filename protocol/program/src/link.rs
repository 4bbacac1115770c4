//! What the run loop needs of the solvers, wherever they work, and of the plan of windows.

use bedload_output::{Cost, Observer, OutputFolder, Summary};
use bedload_scene::CheckedScene;
use protocol::log::Records;
use protocol::message::{Command, Header, Kinematics, Loads, Order, Status};
use protocol::participant::Window;
use serde::Serialize;
use serde::de::DeserializeOwned;

use crate::failure::Failure;

/// An order about one window.
#[derive(Clone, Debug)]
pub struct Ordered {
    /// `Advance` or `Repeat`.
    pub command: Command,
    /// Will the window be repeated? Then its start is kept.
    pub keep: bool,
    /// Message of the absent solver, where the schedule knows it: from a log.
    pub given: Option<(Header, Records)>,
}

impl From<Window> for Ordered {
    fn from(window: Window) -> Self {
        Self { command: window.command(Order::Advance), keep: false, given: None }
    }
}

/// What was exchanged in a window that is done.
#[derive(Clone, Copy, Debug, Default)]
pub struct Messages<'a> {
    /// Loads, one per grain; empty where no fluid sent or played any.
    pub loads: &'a [Loads],
    /// Kinematics, one per grain.
    pub kinematics: &'a [Kinematics],
    /// Header of the loads; none where no fluid takes part.
    pub loads_header: Option<&'a Header>,
    /// Header of the kinematics; none where no DEM takes part.
    pub kinematics_header: Option<&'a Header>,
    /// Reports of the fluid and of the DEM, where they are processes of their own.
    pub reports: Option<[&'a Status; 2]>,
    /// Largest window that the solvers would accept next, s.
    pub dt_limit: f64,
    /// Residual that the DEM reports of the window, or a fluid alone.
    pub residual: f64,
    /// Values of the columns that only a solver knows ([`bedload_output::Sample::extras`]).
    pub extras: &'a [f64],
    /// Largest speed of a fluid that runs alone, m/s.
    pub speed: Option<f64>,
}

impl Messages<'_> {
    /// Header of the kinematics; without a DEM that of the loads.
    pub fn header(&self) -> Header {
        self.kinematics_header.or(self.loads_header).copied().unwrap_or_default()
    }
}

/// How a run ended, besides by failure.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum End {
    /// At its end.
    Reached,
    /// Before the window that failed earlier: only its checkpoint was wanted.
    Rewound,
    /// By Ctrl-C or SIGTERM, in order.
    Interrupted,
}

/// The solvers of a run: other processes, reached by shared memory, or a solver in this process.
pub trait Link {
    /// Orders a window. What goes wrong shows when it is waited for.
    fn order(&mut self, ordered: Ordered);

    /// May another window be ordered?
    fn takes_orders(&self) -> bool {
        true
    }

    /// Waits for the oldest ordered window; none where none is on its way.
    ///
    /// # Errors
    /// [`Failure`] if a solver failed, died or hangs.
    fn await_window(&mut self) -> Result<Option<Command>, Failure>;

    /// What was exchanged in the window that was waited for last.
    fn messages(&self) -> Messages<'_>;

    /// The window that was waited for last is accepted: solvers that can repeat it are notified.
    ///
    /// # Errors
    /// As [`Link::await_window`].
    fn accept(&mut self, _command: Command) -> Result<(), Failure> {
        Ok(())
    }

    /// Each solver writes its file of the checkpoint at the start of window `step`, at `time`.
    ///
    /// # Errors
    /// As [`Link::await_window`], and where the disk refuses.
    fn checkpoint(&mut self, step: u64, time: f64) -> Result<(), Failure>;

    /// Stops the solvers between windows.
    ///
    /// # Errors
    /// As [`Link::await_window`].
    fn stop(&mut self, _step: u64, _time: f64) -> Result<(), Failure> {
        Ok(())
    }

    /// Waits until solvers that were stopped have left; others are ended.
    fn leave(&mut self, _in_order: bool) {}

    /// CPU times, exchange time and memory of this process and its solvers so far.
    fn cost(&self) -> Cost {
        Cost::default()
    }

    /// Writes `grains.csv` where the link has the grains of the whole run: `motion` at the time, s, that its
    /// last window ended.
    ///
    /// # Errors
    /// [`Failure`] if the file cannot be written.
    fn write_grains(
        &self,
        _scene: &CheckedScene,
        _folder: &OutputFolder,
        _motion: (f64, &[Kinematics]),
    ) -> Result<(), Failure> {
        Ok(())
    }

    /// Writes and measures what only the link can at the end of a run.
    ///
    /// # Errors
    /// [`Failure`] if a file cannot be written.
    fn finish(
        &mut self,
        _scene: &CheckedScene,
        _folder: &OutputFolder,
        _summary: &mut Summary,
        _end: Option<End>,
    ) -> Result<(), Failure> {
        Ok(())
    }
}

/// What happens with an attempt at a window.
#[derive(Clone, Debug)]
pub enum Attempt {
    /// The window is done again.
    Repeat(Ordered),
    /// The window is final, and the solvers, which can repeat windows, are notified.
    Accept,
    /// The window is final.
    Final,
}

/// Which windows a run has, and whether one that is done is final.
pub trait Schedule {
    /// Everything of it that decides what comes next; part of a checkpoint.
    type State: Serialize + DeserializeOwned;

    /// For a checkpoint: asked only while no window is on its way.
    fn state(&self) -> Self::State;

    /// Number of the next window.
    fn step(&self) -> u64;

    /// Its start, s.
    fn time(&self) -> f64;

    /// Is the end reached?
    fn is_over(&self) -> bool;

    /// The next window, if it may be ordered now.
    ///
    /// # Errors
    /// [`Failure`] if it cannot be read.
    fn next_window(&mut self) -> Result<Option<Ordered>, Failure>;

    /// Examines an attempt at a window.
    ///
    /// # Errors
    /// [`Failure`] if what was sent breaks the contract.
    fn examine(&mut self, _window: &Window, _messages: &Messages<'_>) -> Result<Attempt, Failure> {
        Ok(Attempt::Final)
    }

    /// Examines a window that is final, and learns from it for the next ones.
    ///
    /// # Errors
    /// [`Failure`] if it breaks a bound of the run.
    fn accept(&mut self, window: &Window, messages: &Messages<'_>) -> Result<(), Failure>;

    /// How far the run is, after a window.
    fn progress(&self, _window: &Window, _messages: &Messages<'_>, _observer: &Observer) -> String {
        String::new()
    }

    /// Adds its counts to the metrics of a run that ends.
    fn measure(&self, _summary: &mut Summary) {}
}
