//! What a solver must know to join a run, as one JSON token.

use std::path::{Path, PathBuf};
use std::time::Duration;

use serde::{Deserialize, Serialize};

use super::names;
use super::watch::Member;
use crate::message::{PROTOCOL_VERSION, layout_hash};
use crate::participant::{ExchangeError, Role};

/// Environment variable in which the coupler hands the token to the solvers it starts; the argument
/// `--connect TOKEN` says the same.
pub const CONNECT_VARIABLE: &str = "BEDLOAD_CONNECT";

/// How a process waits for a message.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Waiting {
    /// Yields the core for [`Rendezvous::spin_us`], then sleeps until the sender's event.
    #[default]
    Event,
    /// Never sleeps. Only sensible with a core for each process.
    Spin,
}

impl Waiting {
    /// `self`, but never [`Waiting::Spin`] on a machine with fewer cores than `processes`: a
    /// spinning process would take the core of the one it waits for.
    #[must_use]
    pub fn on_this_machine(self, processes: usize) -> Self {
        let cores = std::thread::available_parallelism().map_or(1, usize::from);
        if cores < processes { Self::Event } else { self }
    }
}

/// Everything a process must know to join one run. The coupler makes it, [`Rendezvous::token`]
/// writes it as JSON, [`Rendezvous::parse`] reads it back.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Rendezvous {
    /// [`PROTOCOL_VERSION`] of the coupler.
    pub protocol: u64,
    /// [`layout_hash`] of the coupler, 16 hexadecimal digits.
    pub layout: String,
    /// Name of the run, unique on the machine: lower-case letters and digits.
    pub run: String,
    /// iceoryx2's `global.prefix`: begins the name of every shared-memory segment of the run.
    pub prefix: String,
    /// iceoryx2's `global.root-path`, a folder of this run alone; `run.lock` in it is held shared by
    /// every process that takes part.
    pub root: PathBuf,
    /// Number of grains: the length of every slice of loads and kinematics.
    pub grains: usize,
    /// Solvers that take part.
    pub roles: Vec<Role>,
    /// Windows may be ordered again (`Repeat`), so a solver saves its state before each `Advance`.
    pub repeatable: bool,
    /// Most commands that may be on their way at once; 1: each window waits for the last one.
    pub ahead: usize,
    /// Longest time for every solver to start and join, s.
    pub join_s: f64,
    /// Longest time for a peer to answer within a window, s.
    pub deadline_s: f64,
    /// How to wait.
    pub waiting: Waiting,
    /// How long to yield before sleeping, µs.
    pub spin_us: u64,
}

impl Rendezvous {
    /// A new run of `grains` grains with both solvers, events, no repeated windows, 4 commands
    /// ahead, 30 s to join and 60 s to answer. Change the fields before anything is created.
    ///
    /// # Errors
    /// [`ExchangeError::Transport`] if the user's folder cannot be named.
    pub fn new(grains: usize) -> Result<Self, ExchangeError> {
        let run = names::fresh_run_name();
        Ok(Self {
            protocol: PROTOCOL_VERSION,
            layout: format!("{:016x}", layout_hash()),
            prefix: names::prefix_of(&run),
            root: names::user_folder()?.join(&run),
            run,
            grains,
            roles: vec![Role::Fluid, Role::Dem],
            repeatable: false,
            ahead: 4,
            join_s: 30.0,
            deadline_s: 60.0,
            waiting: Waiting::Event,
            spin_us: 50,
        })
    }

    /// The token: one line of JSON.
    pub fn token(&self) -> String {
        serde_json::to_string(self).unwrap_or_default()
    }

    /// Reads a token.
    ///
    /// # Errors
    /// [`ExchangeError::Transport`] if it is not one, [`ExchangeError::Mismatch`] if it was written
    /// by a coupler of another protocol or layout.
    pub fn parse(token: &str) -> Result<Self, ExchangeError> {
        let read: Self = serde_json::from_str(token).map_err(|error| {
            ExchangeError::Transport(format!(
                "the connection token is not of protocol {PROTOCOL_VERSION}: {error}; \
                 it must be the one that bedload passes by --connect or {CONNECT_VARIABLE}"
            ))
        })?;
        compare(Member::Coupler, "protocol", read.protocol, PROTOCOL_VERSION)?;
        compare(Member::Coupler, "layout", &read.layout, &format!("{:016x}", layout_hash()))?;
        read.check()?;
        Ok(read)
    }

    /// Reads the token from [`CONNECT_VARIABLE`]; none if it is not set.
    ///
    /// # Errors
    /// As [`Rendezvous::parse`].
    pub fn from_environment() -> Result<Option<Self>, ExchangeError> {
        std::env::var(CONNECT_VARIABLE).ok().map(|token| Self::parse(&token)).transpose()
    }

    /// Refuses values that no run can have.
    pub(crate) fn check(&self) -> Result<(), ExchangeError> {
        let plain = |name: &str| {
            !name.is_empty() && name.bytes().all(|byte| byte.is_ascii_lowercase() || byte.is_ascii_digit())
        };
        let wrong = |what: String| Err(ExchangeError::Transport(what));
        if !plain(&self.run) || self.prefix != names::prefix_of(&self.run) {
            return wrong(format!(
                "run {:?} with prefix {:?}: a run is named by lower-case letters and digits, and its prefix by the run",
                self.run, self.prefix
            ));
        }
        if self.root.file_name() != Some(Path::new(&self.run).as_os_str()) {
            return wrong(format!("folder {} is not that of run {}", self.root.display(), self.run));
        }
        if self.roles.is_empty() || self.roles.len() > 2 || self.ahead == 0 {
            return wrong(format!(
                "{} solvers and {} commands ahead: 1 or 2 solvers and at least 1 command are allowed",
                self.roles.len(),
                self.ahead
            ));
        }
        for (name, seconds) in [("join_s", self.join_s), ("deadline_s", self.deadline_s)] {
            if !(seconds > 0.0 && seconds <= 1e9) {
                return wrong(format!("{name} = {seconds}: allowed are 0 < {name} <= 1e9"));
            }
        }
        Ok(())
    }

    /// The other solver, if it takes part.
    pub fn peer_of(&self, role: Role) -> Option<Role> {
        self.roles.iter().copied().find(|other| *other != role)
    }

    pub(crate) fn deadline(&self) -> Duration {
        Duration::from_secs_f64(self.deadline_s)
    }

    pub(crate) fn join(&self) -> Duration {
        Duration::from_secs_f64(self.join_s)
    }

    /// What a solver puts into the text of its `Ready`, so that the coupler knows its build too.
    pub fn greeting() -> String {
        format!("bedload {PROTOCOL_VERSION} {:016x}", layout_hash())
    }
}

/// Refuses what `peer` has otherwise than we do.
pub(super) fn compare<T: PartialEq + ToString>(
    peer: Member,
    what: &str,
    theirs: T,
    ours: T,
) -> Result<(), ExchangeError> {
    if theirs == ours {
        return Ok(());
    }
    Err(ExchangeError::Mismatch {
        peer: peer.to_string(),
        what: what.to_owned(),
        theirs: theirs.to_string(),
        ours: ours.to_string(),
    })
}
