//! The other solver, played by a log.

use serde::Serialize;

use super::difference::{At, Comparison, Difference, FieldDifference};
use super::windows::LoggedWindow;
use crate::message::{Header, Kinematics, Loads, Record};
use crate::participant::{Exchange, ExchangeError, Window};

/// A record that stands in the windows of a log.
pub trait Logged: Record + Serialize {
    /// Name of the messages.
    const MESSAGES: &'static str;

    /// The message of this kind in a window.
    fn of(window: &LoggedWindow) -> Option<&(Header, Vec<Self>)>;

    /// Gives a window a message of this kind.
    fn put(window: &mut LoggedWindow, message: (Header, Vec<Self>));
}

impl Logged for Loads {
    const MESSAGES: &'static str = "loads";
    fn of(window: &LoggedWindow) -> Option<&(Header, Vec<Self>)> {
        window.loads.as_ref()
    }
    fn put(window: &mut LoggedWindow, message: (Header, Vec<Self>)) {
        window.loads = Some(message);
    }
}

impl Logged for Kinematics {
    const MESSAGES: &'static str = "kinematics";
    fn of(window: &LoggedWindow) -> Option<&(Header, Vec<Self>)> {
        window.kinematics.as_ref()
    }
    fn put(window: &mut LoggedWindow, message: (Header, Vec<Self>)) {
        window.kinematics = Some(message);
    }
}

/// Gives a participant the logged messages of one window after the other, and compares what it
/// sends with what was logged.
#[derive(Debug)]
pub struct LogExchange<Out> {
    window: Option<LoggedWindow>,
    verify: bool,
    sent: bool,
    received: bool,
    buffer: Vec<Out>,
    comparison: Comparison,
}

impl<Out: Logged> LogExchange<Out> {
    /// For a participant that knows `grains` grains. With `verify`, the first difference ends the
    /// exchange; without, differences are counted.
    #[must_use]
    pub fn new(grains: usize, verify: bool) -> Self {
        Self {
            window: None,
            verify,
            sent: false,
            received: false,
            buffer: vec![Out::default(); grains],
            comparison: Comparison::default(),
        }
    }

    /// The window that the participant does next.
    pub fn load(&mut self, window: LoggedWindow) {
        self.window = Some(window);
        (self.sent, self.received) = (false, false);
    }

    /// Whether the participant exchanged once each way since [`LogExchange::load`].
    #[must_use]
    pub fn is_done(&self) -> bool {
        self.sent && self.received
    }

    /// First difference met.
    #[must_use]
    pub fn first_difference(&self) -> Option<&Difference> {
        self.comparison.first()
    }

    /// Messages compared.
    #[must_use]
    pub fn compared(&self) -> u64 {
        self.comparison.windows()
    }

    /// How far each field is off, over all windows; empty with `verify`.
    #[must_use]
    pub fn fields(&self) -> std::collections::BTreeMap<String, FieldDifference> {
        self.comparison.fields()
    }
}

fn nothing_loaded() -> ExchangeError {
    let what = "no window of the log is loaded".to_owned();
    ExchangeError::Order { what }
}

impl<In: Logged, Out: Logged> Exchange<In, Out> for LogExchange<Out> {
    fn send(&mut self, header: Header, fill: &mut dyn FnMut(&mut [Out])) -> Result<(), ExchangeError> {
        if std::mem::replace(&mut self.sent, true) {
            let what = format!("{} sent twice in window {}", Out::MESSAGES, header.step);
            return Err(ExchangeError::Order { what });
        }
        fill(&mut self.buffer);
        let window = self.window.as_ref().ok_or_else(nothing_loaded)?;
        let (step, attempt) = (window.command.step, window.command.attempt);
        // Nothing was logged for a solver that took no part: nothing to compare with.
        let Some((theirs, logged)) = Out::of(window) else { return Ok(()) };
        let (comparison, buffer) = (&mut self.comparison, &self.buffer);
        comparison.count_window();
        comparison.compare(At { step, attempt, grain: None }, theirs, &header, !self.verify);
        for (grain, (theirs, ours)) in logged.iter().zip(buffer).enumerate() {
            let at = At { step, attempt, grain: Some(grain) };
            comparison.compare(at, theirs, ours, !self.verify);
            if self.verify && comparison.first().is_some() {
                break;
            }
        }
        match self.verify && comparison.first().is_some() {
            true => Err(ExchangeError::Stopped),
            false => Ok(()),
        }
    }

    fn receive(
        &mut self,
        window: &Window,
        read: &mut dyn FnMut(&Header, &[In]),
    ) -> Result<(), ExchangeError> {
        if std::mem::replace(&mut self.received, true) {
            let what = format!("{} asked for twice in window {}", In::MESSAGES, window.step);
            return Err(ExchangeError::Order { what });
        }
        let logged = self.window.as_ref().ok_or_else(nothing_loaded)?;
        let (step, attempt) = (logged.command.step, logged.command.attempt);
        if (window.step, window.attempt) != (step, attempt) {
            let (asked, try_) = (window.step, window.attempt);
            let what =
                format!("window {asked} attempt {try_} asked for, the log is at {step} attempt {attempt}");
            return Err(ExchangeError::Order { what });
        }
        let Some((header, records)) = In::of(logged) else {
            let what = format!("the log has no {}: that solver took no part", In::MESSAGES);
            return Err(ExchangeError::Order { what });
        };
        read(header, records);
        Ok(())
    }
}
