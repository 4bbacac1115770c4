//! The order of messages that a log must have, checked while recording and again while reading.
//!
//! Windows count up by one from the manifest's first step; a `Repeat` counts the attempt up. Every window but
//! the last has its loads and its kinematics once each where both solvers take part; a solver that ran alone
//! has its message, once at most, in the windows that were observed. A gap means that something was lost, so
//! it is an error, never a warning.

use super::error::SequenceError;
use super::manifest::Manifest;
use crate::message::{Command, Header, Order, Status};
use crate::participant::Role;

#[derive(Clone, Copy, Debug)]
struct Open {
    step: u64,
    attempt: u64,
    loads: bool,
    kinematics: bool,
}

/// Follows a stream of messages and refuses the first that does not fit.
#[derive(Clone, Debug)]
pub struct Sequence {
    first_step: u64,
    grains: usize,
    fluid: bool,
    dem: bool,
    open: Option<Open>,
    clock: u64,
    /// Behind lost messages, until a window begins.
    lost: bool,
}

impl Sequence {
    /// For the run of `manifest`.
    pub fn new(manifest: &Manifest) -> Self {
        Self {
            first_step: manifest.first_step,
            grains: manifest.grains(),
            fluid: manifest.has(Role::Fluid),
            dem: manifest.has(Role::Dem),
            open: None,
            clock: 0,
            lost: false,
        }
    }

    /// Messages were lost: any window may be next.
    pub(crate) fn lose(&mut self) {
        (self.open, self.lost) = (None, true);
    }

    /// Simulated time of the next message, ns: the start of its window, never falling.
    pub fn clock(&self) -> u64 {
        self.clock
    }

    /// Window and attempt under way.
    pub fn window(&self) -> Option<(u64, u64)> {
        self.open.map(|open| (open.step, open.attempt))
    }

    /// Whether the window under way has all its messages.
    pub fn is_complete(&self) -> bool {
        self.missing().is_none()
    }

    fn missing(&self) -> Option<(Open, &'static str)> {
        // Alone, a solver is not observed in every window.
        let open = self.open.filter(|_| self.fluid && self.dem)?;
        match (open.loads, open.kinematics) {
            (false, _) => Some((open, "loads")),
            (_, false) => Some((open, "kinematics")),
            _ => None,
        }
    }

    /// Takes an order.
    ///
    /// # Errors
    /// [`SequenceError`] if a window is missing, unfinished, or time runs backwards.
    pub fn command(&mut self, command: &Command) -> Result<(), SequenceError> {
        let step = command.step;
        let order = Order::try_from(command.order)
            .map_err(|error| SequenceError::Order { step, what: error.to_string() })?;
        match order {
            Order::Accept | Order::Checkpoint | Order::Stop if self.lost => Ok(()),
            Order::Advance | Order::Repeat => self.begin(order, command),
            Order::Accept | Order::Checkpoint | Order::Stop => self.remark(order, command),
        }
    }

    fn begin(&mut self, order: Order, command: &Command) -> Result<(), SequenceError> {
        let Command { step, attempt, .. } = *command;
        if u32::try_from(step).is_err() {
            return Err(SequenceError::TooMany { step });
        }
        if let Some((open, what)) = self.missing() {
            let Open { step, attempt, .. } = open;
            return Err(SequenceError::Missing { step, attempt, what });
        }
        let expected = match (order, self.open) {
            (Order::Repeat, Some(open)) => (open.step, open.attempt + 1),
            (_, Some(open)) => (open.step + 1, 0),
            (_, None) if self.lost => (step, attempt),
            (_, None) => (self.first_step, 0),
        };
        if (step, attempt) != expected || (order == Order::Repeat && self.open.is_none() && !self.lost) {
            let expected = format!("{} attempt {}", expected.0, expected.1);
            return Err(SequenceError::Gap { step, attempt, expected });
        }
        self.tick(step, command.time)?;
        self.open = Some(Open { step, attempt, loads: false, kinematics: false });
        self.lost = false;
        Ok(())
    }

    /// Moves the clock to the start of a window.
    fn tick(&mut self, step: u64, time: f64) -> Result<(), SequenceError> {
        let now = nanoseconds(time);
        // The coupler may sum dt in another order than t + dt: one nanosecond is rounding. Beyond its end the
        // clock stands.
        if !time.is_finite() || now.saturating_add(1) < self.clock {
            return Err(SequenceError::Time { step, time: time.to_string() });
        }
        self.clock = self.clock.max(now);
        Ok(())
    }

    /// `Accept`, `Checkpoint`, `Stop`: about the window under way or the next.
    fn remark(&mut self, order: Order, command: &Command) -> Result<(), SequenceError> {
        let (low, high) = match (order, self.open) {
            (Order::Accept, Some(open)) => (open.step, open.step),
            (_, Some(open)) => (open.step, open.step + 1),
            (_, None) => (0, self.first_step),
        };
        if (low..=high).contains(&command.step) {
            return Ok(());
        }
        Err(SequenceError::Order {
            step: command.step,
            what: format!("{order:?} must name a window from {low} to {high}"),
        })
    }

    /// Takes loads of `found` grains.
    ///
    /// # Errors
    /// [`SequenceError`] if they are of another window, come twice, or the count differs.
    pub fn loads(&mut self, header: &Header, found: usize) -> Result<(), SequenceError> {
        self.slice("loads", header, found, |open| &mut open.loads)
    }

    /// Takes kinematics of `found` grains.
    ///
    /// # Errors
    /// As [`Sequence::loads`].
    pub fn kinematics(&mut self, header: &Header, found: usize) -> Result<(), SequenceError> {
        self.slice("kinematics", header, found, |open| &mut open.kinematics)
    }

    fn slice(
        &mut self,
        what: &'static str,
        header: &Header,
        found: usize,
        seen: fn(&mut Open) -> &mut bool,
    ) -> Result<(), SequenceError> {
        let Header { step, attempt, .. } = *header;
        let stray = |where_: String| SequenceError::Stray { what, step, attempt, where_ };
        let Some(open) = &mut self.open else {
            if self.lost {
                return Ok(());
            }
            return Err(stray("stand before the first window".to_owned()));
        };
        if (step, attempt) != (open.step, open.attempt) {
            let (at, attempt) = (open.step, open.attempt);
            return Err(stray(format!("stand in window {at} attempt {attempt}")));
        }
        if found != self.grains {
            let expected = self.grains;
            return Err(SequenceError::Grains { what, step, found, expected });
        }
        if std::mem::replace(seen(open), true) {
            return Err(stray("come twice".to_owned()));
        }
        Ok(())
    }

    /// Takes an answer of a solver.
    ///
    /// # Errors
    /// [`SequenceError::Stray`] if it is about a window not ordered yet.
    pub fn status(&mut self, status: &Status) -> Result<(), SequenceError> {
        let last = self.open.map_or(self.first_step, |open| open.step);
        if self.lost || status.step <= last {
            return Ok(());
        }
        Err(SequenceError::Stray {
            what: "status",
            step: status.step,
            attempt: status.attempt,
            where_: format!("stands in window {last}"),
        })
    }
}

/// Seconds as whole nanoseconds, the clock of an MCAP file; what is not a time is 0.
pub fn nanoseconds(seconds: f64) -> u64 {
    // `as` saturates and turns NaN and negative values into 0.
    (seconds * 1e9).round() as u64
}
