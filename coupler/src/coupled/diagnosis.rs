//! Why a run ends early: which process failed first, and its error text.

use std::time::{Duration, Instant};

use protocol::channel::Event;
use protocol::message::{State, Status};
use protocol::participant::{ExchangeError, Role};

use super::link::CoupledLink;
use crate::supervise::{Exit, Supervisor, wait_for};
use bedload_program::{Failure, Interrupts};

impl CoupledLink<'_> {
    /// Keeps the error of the solver that failed first: the other one fails too, because its peer is gone.
    pub(super) fn note_failure(&mut self, role: Role, status: &Status) {
        let (peer, text) = (role.to_string(), status.text());
        self.broken.get_or_insert_with(|| ExchangeError::Failed { peer: peer.clone(), text: text.clone() });
        if self.failed.as_ref().is_none_or(|(_, text)| is_about_a_peer(text)) {
            self.failed = Some((peer, text));
        }
    }

    /// Finds the failure that led to an error of the exchange.
    pub(super) fn diagnose(&mut self, error: ExchangeError) -> Failure {
        let patience = Instant::now();
        // A dead peer makes the others give up too: the first to go is the cause.
        while self.failed.is_none() && patience.elapsed() < Duration::from_millis(200) {
            while let Ok(Some(event)) = self.link.try_next() {
                if let Event::Status(role, status) = event
                    && status.state == State::Failed as u64
                {
                    self.note_failure(role, &status);
                }
            }
            if self.supervisor.any_exit() || matches!(error, ExchangeError::Deadline { .. }) {
                break;
            }
            std::thread::sleep(Duration::from_millis(5));
        }
        self.await_dead();
        if self.failed.is_some() {
            // Its exit code says what kind of failure it was.
            self.supervisor.wait_any(Duration::from_millis(200));
        }
        explain(&error, self.failed.take(), &self.supervisor)
    }

    /// Where a solver says that the other one died, waits for what the system says of that one: the launcher
    /// of several ranks outlives them by a moment, and knows which of them died first.
    fn await_dead(&self) {
        let Some((reporter, text)) = &self.failed else { return };
        if text.contains(DIED) {
            let is_other = |exit: &Exit| exit.role.to_string() != *reporter;
            wait_for(LAUNCHER, || self.supervisor.exits().iter().any(is_other));
        }
    }
}

/// How long a launcher may take to end when one of its processes has died.
const LAUNCHER: Duration = Duration::from_secs(3);

/// With which code a solver ends that found no room for a file.
const NO_ROOM: i32 = 5;

/// What a solver says of the other one that is gone.
const DIED: &str = " died during window ";

/// Looks after children and interrupts while the coupler waits.
pub(super) fn alive(
    supervisor: &Supervisor,
    interrupts: &Interrupts,
    stopping: bool,
    step: u64,
) -> Result<(), ExchangeError> {
    if interrupts.count() >= 2 {
        return Err(ExchangeError::Stopped);
    }
    if !supervisor.any_exit() {
        return Ok(());
    }
    let bad = |exit: &Exit| !(stopping && exit.code() == Some(0));
    match supervisor.exits().into_iter().find(bad) {
        Some(exit) => Err(ExchangeError::PeerDied { peer: exit.role.to_string(), step }),
        None => Ok(()),
    }
}

/// The cause as the user should read it, with the exit code that it stands for.
pub(super) fn explain(
    error: &ExchangeError,
    failed: Option<(String, String)>,
    supervisor: &Supervisor,
) -> Failure {
    if matches!(error, ExchangeError::Stopped) {
        return Failure::Interrupted("killed by a second signal; the last checkpoint stands".into());
    }
    if matches!(error, ExchangeError::Deadline { .. } | ExchangeError::NotJoined { .. }) {
        return Failure::Peer(error.to_string());
    }
    let exits = supervisor.exits();
    let killed = exits.iter().find(|exit| exit.was_killed());
    if let Some(exit) = killed {
        return Failure::Peer(with_words(&format!("{exit} ({error})"), supervisor, exit.role));
    }
    // Who tells of the other's death is not the one that died.
    let first = exits.iter().find(|exit| {
        failed
            .as_ref()
            .is_none_or(|(reporter, text)| !text.contains(DIED) || exit.role.to_string() != *reporter)
    });
    let own = failed.filter(|(_, text)| !is_about_a_peer(text));
    match (own, first.or(exits.first())) {
        (Some((peer, text)), _) => {
            let words = format!("the {peer} solver failed: {text}");
            let full = |exit: &Exit| exit.role.to_string() == peer && exit.code() == Some(NO_ROOM);
            if exits.iter().any(full) { Failure::Full(words) } else { Failure::Run(words) }
        }
        (None, Some(exit)) => {
            let text = with_words(&exit.to_string(), supervisor, exit.role);
            match exit.code() {
                Some(1) => Failure::Run(text),
                Some(2) => Failure::Input(text),
                Some(NO_ROOM) => Failure::Full(text),
                _ => Failure::Peer(text),
            }
        }
        (None, None) => match error {
            ExchangeError::PeerDied { .. } | ExchangeError::Failed { .. } => Failure::Peer(error.to_string()),
            ExchangeError::NoRoom(text) => Failure::Full(text.clone()),
            _ => Failure::Run(error.to_string()),
        },
    }
}

/// A solver that failed because the other one went: its words name the consequence, not the cause.
fn is_about_a_peer(text: &str) -> bool {
    text.contains(DIED) || text.contains(" did not answer within ")
}

fn with_words(what: &str, supervisor: &Supervisor, role: Role) -> String {
    // The thread that reads stderr may be a moment behind the exit.
    std::thread::sleep(Duration::from_millis(20));
    match supervisor.last_words(role) {
        words if words.is_empty() => format!("{what}; it left no words"),
        words => format!("{what}; its last words:\n{words}"),
    }
}
