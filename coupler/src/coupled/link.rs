//! The solvers of a coupled run, behind shared memory.

use std::collections::VecDeque;
use std::time::Duration;

use bedload_output::{Cost, GrainRow, OutputFolder, atomic_write, grains_table, totals};
use bedload_program::{Failure, Interrupts, Link, Messages, Ordered};
use bedload_scene::{CheckedScene, Grain, Motion};
use protocol::channel::CouplerLink;
use protocol::memory::peak_rss_bytes;
use protocol::message::{Command, Header, Kinematics, Loads, Order, State, Status};
use protocol::participant::{ExchangeError, Window};

use crate::scheme::AHEAD;
use crate::supervise::Supervisor;

/// What has come of a window on its way. Copies, because the fluid may send the loads of the next
/// window before the DEM has reported this one.
#[derive(Debug, Default)]
pub(super) struct Collected {
    pub(super) loads: Option<Header>,
    pub(super) kinematics: Option<Header>,
    /// Of the fluid and of the DEM.
    pub(super) reports: [Option<Status>; 2],
    /// Loads, one per grain, once there is a header of them.
    pub(super) force: Vec<Loads>,
    pub(super) motion: Vec<Kinematics>,
}

impl Collected {
    fn begin(&mut self) {
        (self.loads, self.kinematics, self.reports) = (None, None, [None; 2]);
    }

    /// Headers and reports, once all four are there.
    fn whole(&self) -> Option<Whole> {
        let [fluid, dem] = self.reports;
        Some(Whole { loads: self.loads?, kinematics: self.kinematics?, fluid: fluid?, dem: dem? })
    }
}

/// Headers and reports of a window that is done.
struct Whole {
    loads: Header,
    kinematics: Header,
    fluid: Status,
    dem: Status,
}

/// Both solvers as processes.
pub(crate) struct CoupledLink<'a> {
    // Children go before the link, so that the coupler is the last to leave the run and removes it.
    pub(super) supervisor: Supervisor,
    pub(super) link: CouplerLink,
    pub(super) scene: &'a CheckedScene,
    /// Longest time for an answer within a window.
    pub(super) deadline: Duration,
    pub(super) interrupts: Interrupts,
    pub(super) ordered: VecDeque<(Command, Window)>,
    /// One slot for each window on its way; a window has the slot of its number modulo their count.
    pub(super) slots: Vec<Collected>,
    /// The window that was done last: its slot, and what came of it.
    latest: Option<(usize, Whole)>,
    /// Last reports of the fluid and of the DEM.
    pub(super) last: [Status; 2],
    /// Sub-steps that the DEM has reported.
    pub(super) substeps: u64,
    pub(super) stopping: bool,
    /// What ends the run, once everything sent before it has been read.
    pub(super) broken: Option<ExchangeError>,
    /// Solver that reported its failure, and the text.
    pub(super) failed: Option<(String, String)>,
    /// Numbers that the fluid and the DEM give for `observe.totals`.
    totals: [usize; 2],
    extras: Vec<f64>,
}

impl<'a> CoupledLink<'a> {
    /// Takes over solvers that have said `Ready`, a DEM with a count of `substeps`.
    pub(super) fn new(
        supervisor: Supervisor,
        link: CouplerLink,
        scene: &'a CheckedScene,
        deadline: Duration,
        interrupts: Interrupts,
        substeps: u64,
    ) -> Self {
        Self {
            supervisor,
            link,
            scene,
            deadline,
            interrupts,
            ordered: VecDeque::new(),
            slots: (0..AHEAD).map(|_| Collected::default()).collect(),
            latest: None,
            last: [Status::default(); 2],
            substeps,
            stopping: false,
            broken: None,
            failed: None,
            totals: [totals::fluid_values(scene).len(), totals::dem_values(scene).len()],
            extras: Vec::new(),
        }
    }

    fn command(&mut self, command: Command) -> Result<(), Failure> {
        self.link.order(command).map_err(|error| self.diagnose(error))
    }

    /// Gives an order between windows, and waits for the answer of both solvers.
    fn order_between(&mut self, order: Order, step: u64, time: f64, answer: State) -> Result<(), Failure> {
        self.command(Command { order: order as u64, step, time, ..Command::default() })?;
        self.collect(answer)
    }
}

impl Link for CoupledLink<'_> {
    fn order(&mut self, Ordered { command, .. }: Ordered) {
        self.slots[slot_of(command.step)].begin();
        self.ordered.push_back((command, command.into()));
        self.broken = self.link.order(command).err();
    }

    fn takes_orders(&self) -> bool {
        self.broken.is_none()
    }

    fn await_window(&mut self) -> Result<Option<Command>, Failure> {
        if let Some(error) = self.broken.take_if(|_| self.ordered.is_empty()) {
            return Err(self.diagnose(error));
        }
        let Some((command, _)) = self.ordered.front().copied() else { return Ok(None) };
        let slot = slot_of(command.step);
        let whole = loop {
            if let Some(whole) = self.slots[slot].whole() {
                break whole;
            }
            let event = self.next()?;
            self.take(event)?;
        };
        self.ordered.pop_front();
        self.extras.clear();
        let medium = self.scene.scene.medium.as_ref();
        self.extras.extend(medium.and_then(|m| m.flow_rate.as_ref()).map(|_| whole.fluid.pressure_gradient));
        whole.fluid.numbers(self.totals[0], &mut self.extras);
        whole.dem.numbers(self.totals[1], &mut self.extras);
        self.latest = Some((slot, whole));
        Ok(Some(command))
    }

    fn messages(&self) -> Messages<'_> {
        let Some((slot, whole)) = &self.latest else { return Messages::default() };
        let Collected { force, motion, .. } = &self.slots[*slot];
        Messages {
            loads: force,
            kinematics: motion,
            loads_header: Some(&whole.loads),
            kinematics_header: Some(&whole.kinematics),
            reports: Some([&whole.fluid, &whole.dem]),
            dt_limit: whole.fluid.dt_limit.min(whole.dem.dt_limit),
            residual: whole.dem.residual,
            extras: &self.extras,
            speed: None,
        }
    }

    fn accept(&mut self, command: Command) -> Result<(), Failure> {
        self.command(command)
    }

    fn checkpoint(&mut self, step: u64, time: f64) -> Result<(), Failure> {
        self.order_between(Order::Checkpoint, step, time, State::Saved)
    }

    fn stop(&mut self, step: u64, time: f64) -> Result<(), Failure> {
        self.stopping = true;
        self.order_between(Order::Stop, step, time, State::Stopped)
    }

    fn leave(&mut self, in_order: bool) {
        let grace = Duration::from_millis(if in_order { 2000 } else { 300 });
        if !(in_order && self.supervisor.wait_all(grace)) {
            self.supervisor.end(grace);
        }
    }

    fn cost(&self) -> Cost {
        let [fluid, dem] = &self.last;
        let mut cost = Cost {
            fluid_cpu_s: fluid.solver_s,
            dem_cpu_s: dem.solver_s,
            coupler_cpu_s: own_cpu_seconds(),
            exchange_s: fluid.exchange_s + dem.exchange_s,
            ..Cost::default()
        };
        cost.peak_rss_bytes.fluid = Some(fluid.peak_rss);
        cost.peak_rss_bytes.dem = Some(dem.peak_rss);
        cost.peak_rss_bytes.coupler = Some(peak_rss_bytes());
        cost
    }

    /// The grains after the last window, whoever moved them.
    fn write_grains(
        &self,
        scene: &CheckedScene,
        folder: &OutputFolder,
        (time, motion): (f64, &[Kinematics]),
    ) -> Result<(), Failure> {
        let domain = &scene.scene.domain;
        let row = |(id, (grain, now)): (usize, (&Grain, &Kinematics))| GrainRow {
            id,
            position: now.position,
            radius: grain.radius,
            density: grain.density,
            velocity: now.velocity,
            spin: now.spin,
            free: grain.motion == Motion::Free,
            round: grain.shape.is_round(),
        };
        let grains = scene.grains.iter().zip(motion).enumerate();
        let rows: Vec<GrainRow> =
            grains.filter(|(_, (_, now))| domain.holds(&now.position)).map(row).collect();
        Ok(atomic_write(&folder.grains(), grains_table(time, &rows).as_bytes())?)
    }
}

/// Slot of a window among those on their way.
pub(super) fn slot_of(step: u64) -> usize {
    (step % AHEAD as u64) as usize
}

/// CPU time of this process, user and system, s.
fn own_cpu_seconds() -> f64 {
    let now = rustix::time::clock_gettime(rustix::time::ClockId::ProcessCPUTime);
    now.tv_sec as f64 + 1e-9 * now.tv_nsec as f64
}
