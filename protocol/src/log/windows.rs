//! A log as windows: what a replay needs.

use super::error::LogError;
use super::reader::{LogReader, Message};
use crate::message::{Command, Header, Kinematics, Loads, Order};
use crate::participant::Window;

/// One try of one window: the order and both messages.
#[derive(Clone, Debug, PartialEq)]
pub struct LoggedWindow {
    /// The `Advance` or `Repeat`.
    pub command: Command,
    /// Fluid → DEM; none where no fluid takes part, or where a fluid alone was not observed.
    pub loads: Option<(Header, Vec<Loads>)>,
    /// DEM → fluid; none where no DEM takes part, or where a DEM alone was not observed.
    pub kinematics: Option<(Header, Vec<Kinematics>)>,
    /// Whether an `Accept` was logged for it.
    pub accepted: bool,
}

impl LoggedWindow {
    /// The window as a participant sees it.
    pub fn window(&self) -> Window {
        self.command.into()
    }

    /// Whether it is another try of the window before it.
    pub fn is_repeat(&self) -> bool {
        self.command.order == Order::Repeat as u64
    }
}

/// Streams complete windows; a window that breaks off at the end of the log is left out and named
/// by [`Windows::unfinished`].
pub struct Windows {
    reader: LogReader,
    open: Option<LoggedWindow>,
    /// An error behind the last complete window.
    failure: Option<LogError>,
    unfinished: Option<(u64, u64)>,
    /// Read ahead by [`Windows::peek`].
    ahead: Option<Result<LoggedWindow, LogError>>,
}

impl LogReader {
    /// The windows of this log.
    pub fn windows(self) -> Windows {
        Windows { reader: self, open: None, failure: None, unfinished: None, ahead: None }
    }
}

impl Windows {
    /// Step and attempt of a window that breaks off at the end, once the end was met.
    pub fn unfinished(&self) -> Option<(u64, u64)> {
        self.unfinished
    }

    /// The window after this one, if there is one and it can be read.
    pub fn peek(&mut self) -> Option<&LoggedWindow> {
        if self.ahead.is_none() {
            self.ahead = self.fetch();
        }
        self.ahead.as_ref()?.as_ref().ok()
    }

    /// Puts a message where it belongs; gives the window that it ends. The reader has checked that
    /// messages belong to the window under way.
    fn place(&mut self, message: Message) -> Option<LoggedWindow> {
        match (message, &mut self.open) {
            (Message::Command(command), open) => match Order::try_from(command.order) {
                Ok(Order::Advance | Order::Repeat) => {
                    let next = LoggedWindow { command, loads: None, kinematics: None, accepted: false };
                    return open.replace(next);
                }
                Ok(Order::Accept) => open.iter_mut().for_each(|window| window.accepted = true),
                _ => {}
            },
            (Message::Loads(header, loads), Some(window)) => window.loads = Some((header, loads)),
            (Message::Kinematics(header, grains), Some(window)) => window.kinematics = Some((header, grains)),
            _ => {}
        }
        None
    }

    /// The window under way when the log ends: given if complete.
    fn close(&mut self) -> Option<LoggedWindow> {
        let window = self.open.take()?;
        if self.reader.is_complete() {
            return Some(window);
        }
        self.unfinished = Some((window.command.step, window.command.attempt));
        None
    }

    fn fetch(&mut self) -> Option<Result<LoggedWindow, LogError>> {
        loop {
            if let Some(error) = self.failure.take() {
                return Some(Err(error));
            }
            match self.reader.next() {
                Some(Ok(entry)) => {
                    if let Some(window) = self.place(entry.message) {
                        return Some(Ok(window));
                    }
                }
                Some(Err(error)) => {
                    self.failure = Some(error);
                    if let Some(window) = self.close() {
                        return Some(Ok(window));
                    }
                }
                None => return self.close().map(Ok),
            }
        }
    }
}

impl Iterator for Windows {
    type Item = Result<LoggedWindow, LogError>;

    fn next(&mut self) -> Option<Self::Item> {
        self.ahead.take().or_else(|| self.fetch())
    }
}
