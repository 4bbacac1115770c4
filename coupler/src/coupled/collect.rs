//! What the solvers send, put where it belongs.

use std::time::{Duration, Instant};

use protocol::channel::Event;
use protocol::message::{Header, Record, State, Status};
use protocol::participant::{ExchangeError, Role, Window};

use super::diagnosis::alive;
use super::link::{Collected, CoupledLink, slot_of};
use crate::failure::Failure;
use crate::message_checks;

/// Writing files may take longer than a window.
pub(crate) const FILES_TAKE: u32 = 6;

/// Longest time for the last report of a window that the other solver has done, after a failure.
const PATIENCE: Duration = Duration::from_millis(200);

impl CoupledLink<'_> {
    /// The next event. After a failure those that belong to windows that were done, so that these
    /// count, then the failure.
    pub(super) fn next(&mut self) -> Result<Event, Failure> {
        loop {
            let event = if self.broken.is_none() { self.wait() } else { self.await_rest() };
            match event {
                Ok(Some(Event::Status(role, status))) if status.state == State::Failed as u64 => {
                    self.note_failure(role, &status);
                }
                Ok(Some(event)) => return Ok(event),
                result => match (self.broken.take(), result) {
                    (Some(error), _) => return Err(self.diagnose(error)),
                    (None, result) => self.broken = result.err(),
                },
            }
        }
    }

    /// What is there after a failure. A window that one solver has reported is nearly done: the other
    /// gets a moment for its report, which it may be about to send.
    fn await_rest(&mut self) -> Result<Option<Event>, ExchangeError> {
        let begin = Instant::now();
        loop {
            let event = self.link.try_next()?;
            let stopped = matches!(self.broken, Some(ExchangeError::Stopped));
            let nearly = self.ordered.front().is_some_and(|(_, window)| {
                let [fluid, dem] = &self.slots[slot_of(window.step)].reports;
                fluid.is_some() != dem.is_some()
            });
            if event.is_some() || stopped || !nearly || begin.elapsed() >= PATIENCE {
                return Ok(event);
            }
            std::thread::sleep(Duration::from_millis(1));
        }
    }

    /// Waits for an event; children and interrupts are looked at meanwhile.
    fn wait(&mut self) -> Result<Option<Event>, ExchangeError> {
        let slow = self.ordered.iter().any(|(_, window)| window.output) || self.ordered.is_empty();
        let limit = if slow { self.deadline * FILES_TAKE } else { self.deadline };
        let Self { link, supervisor, interrupts, stopping, .. } = self;
        let step = link.step();
        link.next(limit, &mut || alive(supervisor, interrupts, *stopping, step)).map(Some)
    }

    /// Puts a message where it belongs: the window under way, or one ordered ahead.
    pub(super) fn take(&mut self, event: Event) -> Result<(), Failure> {
        match event {
            Event::Loads(lent) => {
                let due = self.due(|slot| slot.loads.is_none());
                let slot = self.slot_for(due, lent.header(), lent.records())?;
                slot.loads = Some(*lent.header());
                lent.records().clone_into(&mut slot.force);
            }
            Event::Kinematics(lent) => {
                let due = self.due(|slot| slot.kinematics.is_none());
                let slot = self.slot_for(due, lent.header(), lent.records())?;
                slot.kinematics = Some(*lent.header());
                lent.records().clone_into(&mut slot.motion);
            }
            Event::Status(role, status) => {
                self.expect(role, &status, State::Done)?;
                let due = self.due(|slot| slot.reports[role as usize].is_none());
                message_checks::report_of(due, role, &status, self.scene.grains.len(), self.substeps)?;
                self.slots[slot_of(status.step)].reports[role as usize] = Some(status);
                if role == Role::Dem {
                    self.substeps = status.substeps;
                }
            }
        }
        Ok(())
    }

    /// Where a message goes, if it is of the window that is due.
    fn slot_for<R: Record>(
        &mut self,
        due: Option<Window>,
        header: &Header,
        records: &[R],
    ) -> Result<&mut Collected, Failure> {
        message_checks::belongs(due.as_ref(), header, records, self.scene.grains.len())?;
        Ok(&mut self.slots[slot_of(header.step)])
    }

    /// The oldest window on its way in whose slot something is due.
    fn due(&self, is_due: impl Fn(&Collected) -> bool) -> Option<Window> {
        let windows = self.ordered.iter().map(|(_, window)| *window);
        windows.into_iter().find(|window| is_due(&self.slots[slot_of(window.step)]))
    }

    /// Keeps a report, and refuses one that is not `wanted`.
    fn expect(&mut self, role: Role, status: &Status, wanted: State) -> Result<(), Failure> {
        self.last[role as usize] = *status;
        if status.state == wanted as u64 {
            return Ok(());
        }
        Err(Failure::Run(format!(
            "the {role} solver answered with state {} of window {} in window {}, where {wanted:?} was due",
            status.state,
            status.step,
            self.link.step()
        )))
    }

    /// Waits for one report of each solver.
    pub(super) fn collect(&mut self, wanted: State) -> Result<(), Failure> {
        let mut reported = [false; 2];
        while reported != [true; 2] {
            match self.next()? {
                Event::Status(role, status) => {
                    self.expect(role, &status, wanted)?;
                    reported[role as usize] = true;
                }
                Event::Loads(_) | Event::Kinematics(_) => {
                    return Err(Failure::Run("a solver sent data of a window that was not ordered".into()));
                }
            }
        }
        Ok(())
    }
}
