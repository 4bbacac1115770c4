//! The loop over windows, one for every way to run: coupled, alone, replayed.
//!
//! A window: order it, wait for what was exchanged, log, examine, observe. Between windows: checkpoints,
//! signals, the end. [`Link`] says where the solvers are, [`Schedule`] which windows there are and whether
//! they are final.

use std::time::Instant;

use bedload_output::{Cost, Observer, Sample, Summary};
use protocol::message::{Command, Kinematics, Order};
use protocol::participant::Window;

use crate::checkpoint::{self, LastMotion, LoopState};
use crate::failure::Failure;
use crate::heartbeat::Heartbeat;
use crate::interrupts::Interrupts;
use crate::job::Job;
use crate::link::{Attempt, End, Link, Schedule};
use crate::log::Log;
use crate::progress::Progress;

pub(crate) struct RunLoop<'a, L, S> {
    link: L,
    schedule: S,
    interrupts: &'a Interrupts,
    heartbeat: Heartbeat,
    /// None in a replay, which only compares.
    output: Option<Output<'a>>,
    /// Window before which the run ends, where that is not its end in time.
    last: Option<u64>,
}

/// What a run leaves in its folder.
struct Output<'a> {
    job: &'a Job<'a>,
    observer: Observer,
    log: Option<Log>,
    progress: Progress,
    /// Costs before a resume.
    before: Cost,
    saved: Instant,
    /// End of the last window that was done here, s.
    reached: Option<f64>,
    /// What the checkpoint says, where none was.
    resumed: Option<LastMotion>,
}

impl<'a, L: Link, S: Schedule> RunLoop<'a, L, S> {
    /// A loop that leaves nothing in a folder.
    pub(crate) fn new(link: L, schedule: S, interrupts: &'a Interrupts) -> Self {
        Self { link, schedule, interrupts, heartbeat: Heartbeat::new(), output: None, last: None }
    }

    /// The loop of a run, from its start or from a checkpoint; with `last`, up to that window and without a
    /// log.
    pub(crate) fn with_output(
        link: L,
        schedule: S,
        job: &'a Job<'a>,
        from: Option<(bedload_output::ObserverState, Cost, Option<LastMotion>)>,
        last: Option<u64>,
    ) -> Result<Self, Failure> {
        let log = match (last, &job.log) {
            (None, Some(kind)) => Log::begin(kind, job, schedule.step(), schedule.time())?,
            _ => None,
        };
        let (folder, scene) = (job.folder, job.scene);
        let (observer, before, resumed) = match from {
            None => (Observer::create(folder, scene, job.sides)?, Cost::default(), None),
            Some((state, before, motion)) => {
                let last = motion.as_ref().map(|(_, motion)| motion.as_slice());
                (Observer::resume(folder, scene, job.sides, state, last)?, before, motion)
            }
        };
        let until = scene.scene.until;
        let progress = Progress::new(job.program, schedule.time(), until, scene.scene.stop_when.is_some());
        let (saved, reached) = (Instant::now(), None);
        let output = Output { job, observer, log, progress, before, saved, reached, resumed };
        Ok(Self { output: Some(output), last, ..Self::new(link, schedule, job.interrupts) })
    }

    /// Windows that are done, those before a resume included.
    pub(crate) fn done(&self) -> u64 {
        self.output.as_ref().map_or(0, |output| output.observer.tally().windows)
    }

    /// The link and the schedule, after the run.
    pub(crate) fn into_parts(self) -> (L, S) {
        (self.link, self.schedule)
    }

    /// Runs to the end, or to an interrupt.
    pub(crate) fn advance(&mut self) -> Result<End, Failure> {
        loop {
            let interrupted = self.interrupts.count() > 0;
            if !interrupted && !self.is_checkpoint_due() {
                self.order_windows()?;
            }
            if let Some(command) = self.link.await_window()? {
                self.window(&command)?;
                continue;
            }
            let end = match (self.schedule.is_over(), self.is_at_last()) {
                (true, _) => Some(End::Reached),
                (false, true) => Some(End::Rewound),
                (false, false) => interrupted.then_some(End::Interrupted),
            };
            self.checkpoint(end)?;
            if let Some(end) = end {
                self.link.stop(self.schedule.step(), self.schedule.time())?;
                return Ok(end);
            }
        }
    }

    fn is_at_last(&self) -> bool {
        self.last.is_some_and(|last| self.schedule.step() >= last)
    }

    fn is_checkpoint_due(&self) -> bool {
        self.output.as_ref().is_some_and(|output| {
            let every = output.job.checkpoint_every;
            every > 0.0 && output.saved.elapsed().as_secs_f64() >= every
        })
    }

    /// Orders every window that the schedule gives.
    fn order_windows(&mut self) -> Result<(), Failure> {
        while self.link.takes_orders()
            && !self.schedule.is_over()
            && !self.is_at_last()
            && let Some(ordered) = self.schedule.next_window()?
        {
            self.link.order(ordered);
        }
        Ok(())
    }

    /// A window that is done, from the log to the plan that it allows.
    fn window(&mut self, command: &Command) -> Result<(), Failure> {
        self.heartbeat.beat();
        let window = Window::from(*command);
        let log = self.output.as_ref().and_then(|output| output.log.as_ref());
        let messages = self.link.messages();
        // Before it is examined: what ends a run is worth seeing.
        if let Some(log) = log {
            log.record(command, &messages)?;
        }
        match self.schedule.examine(&window, &messages)? {
            Attempt::Repeat(next) => {
                self.link.order(next);
                return Ok(());
            }
            Attempt::Accept => {
                let accept = Command { order: Order::Accept as u64, ..*command };
                self.link.accept(accept)?;
                if let Some(log) = log {
                    log.record_command(&accept)?;
                }
            }
            Attempt::Final => {}
        }
        let messages = self.link.messages();
        self.schedule.accept(&window, &messages)?;
        let Some(output) = &mut self.output else { return Ok(()) };
        output.observer.record(&Sample {
            window: &window,
            loads: messages.loads,
            header: &messages.header(),
            kinematics: messages.kinematics,
            extras: messages.extras,
        })?;
        output.reached = Some(window.time + window.dt);
        let (schedule, observer) = (&self.schedule, &output.observer);
        output.progress.print(window.time + window.dt, || schedule.progress(&window, &messages, observer));
        Ok(())
    }

    /// Solvers and loop write what decides the next window. Nothing is on its way. At an `end` the last
    /// motion is written, too.
    fn checkpoint(&mut self, end: Option<End>) -> Result<(), Failure> {
        self.heartbeat.beat();
        let Some(output) = &mut self.output else { return Ok(()) };
        let step = self.schedule.step();
        output.job.folder.check_place()?;
        self.link.checkpoint(step, self.schedule.time())?;
        let cost = output.cost(&self.link);
        let state = LoopState { observer: output.observer.state()?, cost, schedule: self.schedule.state() };
        let (folder, identity) = (output.job.folder, output.job.scene.state_sha256());
        if let (Some(_), Some(motion)) = (end, output.last_motion(&self.link)) {
            checkpoint::write_motion(folder, step, &identity, motion)?;
        }
        checkpoint::complete(folder, step, &identity, &state)?;
        output.saved = Instant::now();
        protocol::detail!("{}: checkpoint of step {step}", output.job.program);
        Ok(())
    }

    /// Ends the solvers, finishes log and series, and fills the summary.
    pub(crate) fn close(mut self, summary: &mut Summary, end: Option<End>) -> Result<(), Failure> {
        self.heartbeat.beat();
        let Some(mut output) = self.output.take() else { return Ok(()) };
        output.progress.finish();
        self.link.leave(end.is_some());
        summary.cost = output.cost(&self.link);
        let logged = output.log.take().map_or(Ok(()), Log::finish);
        let job = output.job;
        output.observer.finish(summary, job.contact_time)?;
        if end.is_some()
            && let Some(motion) = output.last_motion(&self.link)
        {
            self.link.write_grains(job.scene, job.folder, motion)?;
        }
        self.link.finish(job.scene, job.folder, summary, end)?;
        self.schedule.measure(summary);
        summary.remark(&job.scene.scene.metrics);
        Ok(logged?)
    }
}

impl Output<'_> {
    /// Time and motion at the end of the last window; none where no grain was ever moved.
    fn last_motion<'b>(&'b self, link: &'b impl Link) -> Option<(f64, &'b [Kinematics])> {
        let here = self.reached.map(|time| (time, link.messages().kinematics));
        let motion = here.or(self.resumed.as_ref().map(|(time, motion)| (*time, motion.as_slice())));
        motion.filter(|(_, motion)| !motion.is_empty())
    }

    /// Costs so far, those before a resume included.
    fn cost(&self, link: &impl Link) -> Cost {
        let (before, now) = (&self.before, link.cost());
        let record_s = self.log.as_ref().map_or(0.0, Log::seconds);
        Cost {
            wall_s: before.wall_s + self.job.begin.elapsed().as_secs_f64(),
            fluid_cpu_s: before.fluid_cpu_s + now.fluid_cpu_s,
            dem_cpu_s: before.dem_cpu_s + now.dem_cpu_s,
            coupler_cpu_s: before.coupler_cpu_s + now.coupler_cpu_s,
            exchange_s: before.exchange_s + now.exchange_s,
            record_s: before.record_s + record_s,
            ..now
        }
    }
}
