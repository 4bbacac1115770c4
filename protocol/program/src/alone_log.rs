//! The log of a solver that runs alone: the order of every window, and what the solver sent at each observation.

use bedload_output::OutputFolder;
use bedload_scene::CheckedScene;
use protocol::log::{LogError, Manifest, Recorder, RecorderOptions};
use protocol::message::{Command, Header, Kinematics, Loads, Order};
use protocol::participant::{Role, Window};

use crate::error::ProgramError;

/// Bytes of messages in a log, about, before compression: a run that would have more is recorded less often.
const MOST_BYTES: f64 = 256e6;

/// Bytes of one message; beyond that nothing is recorded.
const MOST_MESSAGE: usize = 16 << 20;

/// The log of a solver alone.
pub(crate) struct AloneLog {
    recorder: Recorder,
    role: Role,
    due: Due,
}

/// Which windows have a message: a function of the window alone, so that a log does not depend on the machine.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Due {
    /// Time between messages, s; 0: every window.
    period: f64,
    /// End of the run, s.
    until: f64,
}

impl Due {
    /// At each observation of `every` seconds, or so many of them apart that all messages of `bytes` bytes have room.
    fn new(every: f64, until: f64, bytes: usize) -> Self {
        let apart = until * bytes as f64 / MOST_BYTES;
        let period = match every > 0.0 {
            true if apart.is_finite() => every * (apart / every).ceil().max(1.0),
            true => every,
            false => apart,
        };
        Self { period: if period.is_finite() { period } else { 0.0 }, until }
    }

    fn is_due(&self, window: &Window) -> bool {
        let end = window.time + window.dt;
        let passed = |time: f64| (time / self.period * (1.0 + 1e-12)).floor();
        self.period <= 0.0 || end >= self.until || passed(end) > passed(window.time)
    }
}

impl AloneLog {
    /// Begins the next part of the log in `folder`, whose scene stands there, with window `step` at `time`. None
    /// where a message would be too large, which is said, or no grain has one.
    pub(crate) fn begin(
        program: &str,
        role: Role,
        scene: &CheckedScene,
        folder: &OutputFolder,
        dt: f64,
        (step, time): (u64, f64),
    ) -> Result<Option<Self>, ProgramError> {
        let record = if role == Role::Dem { size_of::<Kinematics>() } else { size_of::<Loads>() };
        let bytes = record * scene.grains.len();
        if bytes > MOST_MESSAGE {
            let grains = scene.grains.len();
            protocol::say!(
                "{program}: note: no exchange.mcap: a message of {grains} grains is beyond 16 MiB"
            );
        }
        if bytes == 0 || bytes > MOST_MESSAGE {
            return Ok(None);
        }
        let path = folder.scene();
        let text = std::fs::read_to_string(&path)
            .map_err(bedload_output::OutputError::file("read the scene for the log,", &path))?;
        let radii = scene.grains.iter().map(|grain| grain.radius).collect();
        let until = scene.scene.until;
        let mut manifest = Manifest::new(&scene.scene.title, &text, radii, dt, until);
        (manifest.first_step, manifest.first_time) = (step, time);
        match role {
            Role::Fluid => manifest.dem_command.clear(),
            Role::Dem => manifest.fluid_command.clear(),
        }
        let file = folder.log_part(folder.next_log_part());
        let recorder = Recorder::create(&file, &manifest, RecorderOptions::default())?;
        Ok(Some(Self { recorder, role, due: Due::new(scene.scene.observe.every, until, bytes) }))
    }

    /// Takes a window that is done.
    pub(crate) fn record(
        &self,
        window: &Window,
        header: &Header,
        loads: &[Loads],
        kinematics: &[Kinematics],
    ) -> Result<(), LogError> {
        self.recorder.record_command(&Command {
            order: Order::Advance as u64,
            step: window.step,
            attempt: window.attempt,
            time: window.time,
            dt: window.dt,
            substeps: window.substeps,
            output: u64::from(window.output),
        })?;
        match self.role {
            _ if !self.due.is_due(window) => Ok(()),
            Role::Fluid => self.recorder.record_loads(header, loads),
            Role::Dem => self.recorder.record_kinematics(header, kinematics),
        }
    }

    /// Writes what is queued, and the end mark.
    pub(crate) fn finish(self) -> Result<(), LogError> {
        self.recorder.finish().map(drop)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn count(due: Due, dt: f64, windows: u64) -> usize {
        let window =
            |step: u64| Window { step, attempt: 0, time: step as f64 * dt, dt, substeps: 1, output: false };
        (0..windows).filter(|step| due.is_due(&window(*step))).count()
    }

    #[test]
    fn observations_are_recorded_as_long_as_they_have_room() {
        assert_eq!(count(Due::new(0.5, 100.0, 1000), 0.125, 800), 200);
        assert_eq!(count(Due::new(0.0, 100.0, 1000), 0.125, 800), 800);
        // 25.6 MB each: ten of them, whatever is observed; the last window is one of them.
        assert_eq!(count(Due::new(0.5, 100.0, 25_600_000), 0.125, 800), 10);
        assert_eq!(count(Due::new(0.0, 100.0, 25_600_000), 0.125, 800), 10);
        assert_eq!(Due::new(0.0, f64::INFINITY, 10).period, 0.0);
    }
}
