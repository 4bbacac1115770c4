//! The log of a run, in parts: `exchange.mcap`, and `exchange.<n>.mcap` for each resume.

use bedload_output::OutputError;
use protocol::checkpoints;
use protocol::log::{FRAMES, LogError, MOST_PLOTTED, MOST_SPHERES, Manifest, Recorder, RecorderOptions};
use protocol::message::{Command, Kinematics, Loads};
use protocol::participant::{Role, Window};
use protocol::serve::checkpoint_folder;

use crate::failure::Failure;
use crate::job::{Job, LogKind};
use crate::link::Messages;

/// Bytes of messages in the log of a solver alone, about, before compression: a run that would have more is
/// recorded less often.
const MOST_BYTES: f64 = 256e6;

/// Bytes of one message of a solver alone; beyond that nothing is recorded.
const MOST_MESSAGE: usize = 16 << 20;

/// Bytes of the rest of a window, coupled (orders, headers, both answers) and alone.
const WINDOW: [f64; 2] = [1700.0, 200.0];
/// Bytes of a grain in a frame for viewers, measured: a sphere (111 to 143), while they are drawn, a point,
/// and what is plotted of the first grains.
const FRAME: [f64; 3] = [125.0, 32.0, 84.0];

/// Size of the log of a run of so many windows, bytes, before compression; of few grains it packs to an
/// eighth, of many hardly. `alone` is the solver that runs alone.
pub fn log_bytes(alone: Option<Role>, grains: usize, windows: f64) -> f64 {
    let (loads, kinematics) = (size_of::<Loads>(), size_of::<Kinematics>());
    let (record, most) = match alone {
        None => (loads + kinematics, f64::INFINITY),
        Some(Role::Fluid) => (loads, MOST_BYTES),
        Some(Role::Dem) => (kinematics, MOST_BYTES),
    };
    let bytes = (record * grains) as f64;
    if alone.is_some() && (grains == 0 || record * grains > MOST_MESSAGE) {
        return 0.0;
    }
    let messages = if bytes > 0.0 { windows.min((most / bytes).ceil()) } else { 0.0 };
    let spheres = if grains <= MOST_SPHERES { FRAME[0] } else { 0.0 };
    let frames = if alone == Some(Role::Fluid) { 0.0 } else { messages.min(FRAMES) };
    let rest = windows * WINDOW[usize::from(alone.is_some())];
    let plotted = FRAME[2] * grains.min(MOST_PLOTTED) as f64;
    messages * bytes + rest + frames * (grains as f64 * (spheres + FRAME[1]) + plotted)
}

/// The log of a run under way.
pub(crate) struct Log {
    recorder: Recorder,
    /// Which windows have messages, where not all have.
    due: Option<Due>,
}

/// Which windows have a message: a function of the window alone, so that a log does not depend on the
/// machine.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Due {
    /// Time between messages, s; 0: every window.
    period: f64,
    /// End of the run, s.
    until: f64,
}

impl Due {
    /// At each observation of `every` seconds, or so many of them apart that all messages of `bytes` bytes
    /// have room.
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

impl Log {
    /// Begins the next part of the log of a run whose scene stands in its folder, with window `step` at
    /// `time`. None where no grain has a message, or where one would be too large, which is said.
    pub(crate) fn begin(
        kind: &LogKind,
        job: &Job<'_>,
        step: u64,
        time: f64,
    ) -> Result<Option<Self>, Failure> {
        let (scene, folder) = (job.scene, job.folder);
        let path = folder.scene();
        let text = protocol::input_file::read_text(&path)
            .map_err(OutputError::file("read the scene for the log,", &path))?;
        let radii: Vec<f64> = scene.grains.iter().map(|grain| grain.radius).collect();
        let (grains, until) = (radii.len(), scene.scene.until);
        let mut manifest = Manifest::new(&scene.scene.title, &text, radii, job.dt, until);
        (manifest.first_step, manifest.first_time) = (step, time);
        let mut due = None;
        match kind {
            LogKind::Coupled { fluid, dem } => {
                manifest.fluid_command.clone_from(fluid);
                manifest.dem_command.clone_from(dem);
            }
            LogKind::Alone(role) => {
                let (record, absent) = match role {
                    Role::Fluid => (size_of::<Loads>(), &mut manifest.dem_command),
                    Role::Dem => (size_of::<Kinematics>(), &mut manifest.fluid_command),
                };
                absent.clear();
                let bytes = record * grains;
                if bytes > MOST_MESSAGE {
                    protocol::tell!(
                        "{}: note: no exchange.mcap: a message of {grains} grains is beyond 16 MiB",
                        job.program
                    );
                }
                if bytes == 0 || bytes > MOST_MESSAGE {
                    return Ok(None);
                }
                due = Some(Due::new(scene.scene.observe.every, until, bytes));
            }
        }
        if step > 0 {
            let begin = checkpoint_folder(folder.root(), step);
            checkpoints::keep(&begin).map_err(OutputError::file("keep the checkpoint", &begin))?;
        }
        let file = folder.log_part(folder.next_log_part());
        Ok(Some(Self { recorder: Recorder::create(&file, &manifest, RecorderOptions::default())?, due }))
    }

    /// Takes an attempt at a window.
    pub(crate) fn record(&self, command: &Command, messages: &Messages<'_>) -> Result<(), LogError> {
        self.recorder.record_command(command)?;
        if self.due.is_some_and(|due| !due.is_due(&Window::from(*command))) {
            return Ok(());
        }
        if let Some(header) = messages.loads_header {
            self.recorder.record_loads(header, messages.loads)?;
        }
        if let Some(header) = messages.kinematics_header {
            self.recorder.record_kinematics(header, messages.kinematics)?;
        }
        if let Some([fluid, dem]) = messages.reports {
            self.recorder.record_status(Role::Fluid, fluid)?;
            self.recorder.record_status(Role::Dem, dem)?;
        }
        Ok(())
    }

    /// Takes an order that no message follows.
    pub(crate) fn record_command(&self, command: &Command) -> Result<(), LogError> {
        self.recorder.record_command(command)
    }

    /// Wall time of recording so far, s.
    pub(crate) fn seconds(&self) -> f64 {
        let spent = self.recorder.statistics();
        spent.call_s + spent.write_s
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
    fn the_size_of_a_log_is_known_before_the_run() {
        // 300 grains, 0.6 s in windows of 0.2 ms: 72 kB a window.
        let size = log_bytes(None, 300, 3000.0);
        assert!((2.4e8..3.0e8).contains(&size), "{size}");
        assert!((2.56e8..3.2e8).contains(&log_bytes(Some(Role::Dem), 10_000, 1e4)));
        assert_eq!(log_bytes(Some(Role::Dem), 1_000_000, 1e4), 0.0);
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
