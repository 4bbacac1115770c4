//! A solver as seen by a run: `hello → advance* → stop`, with `save`/`restore` for repeated windows
//! and checkpoints.
//!
//! One state machine, three drivers: shared memory in a coupled run ([`crate::channel`]), a log in a
//! replay, a plain loop when the solver runs alone. The driver hands the solver an [`Exchange`]; the
//! solver sends and receives in the order its method needs, once each way per window.

use std::path::Path;
use std::time::Duration;

use crate::message::{Command, Header, Order, Record};

/// Which side of the exchange a solver is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Role {
    /// Sends loads, receives kinematics.
    Fluid,
    /// Sends kinematics, receives loads.
    Dem,
}

impl std::fmt::Display for Role {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Fluid => "fluid",
            Self::Dem => "dem",
        })
    }
}

/// A window of time that the coupler orders.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Window {
    /// Number, from 0.
    pub step: u64,
    /// Try of this window.
    pub attempt: u64,
    /// Start, s.
    pub time: f64,
    /// Length, s.
    pub dt: f64,
    /// DEM sub-steps to do, exactly.
    pub substeps: u64,
    /// Write fields after this window.
    pub output: bool,
}

impl Window {
    /// The header of a message of this window; the DEM fills in the last three fields.
    pub fn header(&self) -> Header {
        Header { step: self.step, attempt: self.attempt, time: self.time, dt: self.dt, ..Header::default() }
    }

    /// The command that gives an order about this window.
    pub fn command(&self, order: Order) -> Command {
        Command {
            order: order as u64,
            step: self.step,
            attempt: self.attempt,
            time: self.time,
            dt: self.dt,
            substeps: self.substeps,
            output: u64::from(self.output),
        }
    }
}

impl From<Command> for Window {
    fn from(command: Command) -> Self {
        Self {
            step: command.step,
            attempt: command.attempt,
            time: command.time,
            dt: command.dt,
            substeps: command.substeps,
            output: command.output != 0,
        }
    }
}

/// What a solver says after a window.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WindowReport {
    /// Largest window it would accept next, s (infinite if it does not care).
    pub dt_limit: f64,
    /// Fluid: largest divergence after projection, 1/s; DEM: largest overlap over radius.
    pub residual: f64,
    /// DEM: sub-steps done in the window; fluid: 0.
    pub substeps: u64,
}

/// Why an exchange did not happen.
#[derive(Debug, thiserror::Error)]
#[allow(missing_docs, reason = "the messages say what the fields are")]
pub enum ExchangeError {
    /// The peer process is gone.
    #[error("{peer} died during window {step}")]
    PeerDied { peer: String, step: u64 },
    /// The peer lives but did not answer.
    #[error(
        "{peer} did not answer within {seconds} s in window {step}: it hangs, or raise [coupling] deadline"
    )]
    Deadline { peer: String, step: u64, seconds: f64 },
    /// A solver did not take part in time.
    #[error(
        "{peer} did not join within {seconds} s: it hangs, or does not know the protocol; one that is only \
         slow to start needs a longer [coupling] startup_deadline"
    )]
    NotJoined { peer: String, seconds: f64 },
    /// A message of another window, or of another number of grains.
    #[error("message out of order: {0}")]
    Order(String),
    /// The peer was built against another protocol or layout, or reads another scene.
    #[error(
        "{peer} has {what} {theirs}, we have {ours}: rebuild both from one version and start both from one scene"
    )]
    Mismatch { peer: String, what: String, theirs: String, ours: String },
    /// The peer gave up and said why.
    #[error("{peer} failed: {text}")]
    Failed { peer: String, text: String },
    /// There is no room for the shared memory.
    #[error("{0}")]
    NoRoom(String),
    /// The run is being stopped.
    #[error("the run was stopped")]
    Stopped,
    /// The transport failed.
    #[error("{0}")]
    Transport(String),
}

impl ExchangeError {
    /// `peer` has not answered in window `step` within `limit`.
    pub(crate) fn late(peer: impl ToString, step: u64, limit: Duration) -> Self {
        Self::Deadline { peer: peer.to_string(), step, seconds: limit.as_secs_f64() }
    }
}

/// Why a solver cannot go on.
#[derive(Debug, thiserror::Error)]
#[allow(missing_docs, reason = "the messages say what the fields are")]
pub enum SolverError {
    /// The state or the method failed: not finite, out of bounds, refused by the solver.
    #[error("{0}")]
    Failed(String),
    /// The exchange failed.
    #[error(transparent)]
    Exchange(#[from] ExchangeError),
    /// A file could not be written or read.
    #[error("{path}: {source}")]
    File { path: String, source: std::io::Error },
}

/// One exchange each way per window, zero-copy where the transport allows it.
pub trait Exchange<In: Record, Out: Record> {
    /// Sends one record per grain; `fill` writes them in place.
    ///
    /// # Errors
    /// [`ExchangeError`] if no peer takes it in time.
    fn send(&mut self, header: Header, fill: &mut dyn FnMut(&mut [Out])) -> Result<(), ExchangeError>;

    /// Waits for the peer's records of this window and lends them to `read`.
    ///
    /// # Errors
    /// [`ExchangeError`] if the peer died, hangs, or sends another window or count.
    fn receive(&mut self, window: &Window, read: &mut dyn FnMut(&Header, &[In]))
    -> Result<(), ExchangeError>;
}

/// A solver that can take part in a run.
pub trait Participant {
    /// What it receives each window.
    type Incoming: Record;
    /// What it sends each window.
    type Outgoing: Record;
    /// Its side.
    const ROLE: Role;

    /// Number of grains it knows, all motions included.
    fn grains(&self) -> usize;

    /// Does one window, exchanging once each way.
    ///
    /// # Errors
    /// [`SolverError`] if it cannot; the state is then unspecified until [`Participant::restore`].
    fn advance(
        &mut self,
        window: &Window,
        exchange: &mut dyn Exchange<Self::Incoming, Self::Outgoing>,
    ) -> Result<WindowReport, SolverError>;

    /// Keeps everything that decides the next window, in memory.
    fn save(&mut self);

    /// Goes back to the last [`Participant::save`].
    fn restore(&mut self);

    /// Writes everything that decides the next window to `folder` (one file, named by the role).
    ///
    /// # Errors
    /// [`SolverError::File`].
    fn write_checkpoint(&self, folder: &Path) -> Result<(), SolverError>;

    /// Reads what [`Participant::write_checkpoint`] wrote.
    ///
    /// # Errors
    /// [`SolverError`] if the file is missing, truncated, or of another scene.
    fn read_checkpoint(&mut self, folder: &Path) -> Result<(), SolverError>;

    /// Writes fields for viewers, if it has any.
    ///
    /// # Errors
    /// [`SolverError::File`].
    fn write_fields(&mut self, _window: &Window) -> Result<(), SolverError> {
        Ok(())
    }

    /// CPU seconds of solver work so far (no waiting, output or log); 0 where nobody counts.
    fn solver_seconds(&self) -> f64 {
        0.0
    }

    /// Mean pressure gradient that held a flow rate in the last window, Pa/m; 0 where none is held.
    fn pressure_gradient(&self) -> f64 {
        0.0
    }

    /// Adds the values that the scene's `observe.totals` asks of it, of the state after the last window, in
    /// the order that docs/coupling.md says. None where none is asked for.
    fn totals(&self, _out: &mut Vec<f64>) {}
}
