//! A toy fluid and a toy DEM that exchange as real solvers do, and logs made of their runs.

use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, Sender, channel};

use protocol::log::{Manifest, Recorder, RecorderOptions};
use protocol::message::{Header, Kinematics, Loads, Order, Record, State, Status};
use protocol::participant::{Exchange, ExchangeError, Participant, Role, SolverError, Window, WindowReport};

pub(crate) const GRAINS: usize = 3;
pub(crate) const DT: f64 = 1e-3;

/// A file of this test run that no other test uses.
pub(crate) fn path(name: &str) -> PathBuf {
    Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("{}-{name}", std::process::id()))
}

pub(crate) fn manifest() -> Manifest {
    let radii = vec![1e-3, 1e-3, 2e-3];
    Manifest::new("three settling grains", "title = \"toy\"\n", radii, DT, 1.0)
}

/// Stokes drag on each grain from a fluid that is dragged along.
#[derive(Clone)]
pub(crate) struct ToyFluid {
    u: Vec<f64>,
    v: Vec<f64>,
    kept: Option<Box<ToyFluid>>,
}

/// Grains that fall, with drag.
#[derive(Clone)]
pub(crate) struct ToyDem {
    grains: Vec<Kinematics>,
    kept: Option<Box<ToyDem>>,
}

impl ToyFluid {
    pub(crate) fn new() -> Self {
        Self { u: vec![0.0; GRAINS], v: vec![0.0; GRAINS], kept: None }
    }
}

impl ToyDem {
    pub(crate) fn new() -> Self {
        let grain = |i: usize| Kinematics {
            position: [i as f64, 0.0, 1.0 + i as f64 / 3.0],
            orientation: [1.0, 0.0, 0.0, 0.0],
            ..Kinematics::default()
        };
        Self { grains: (0..GRAINS).map(grain).collect(), kept: None }
    }
}

/// What the two toys share of the trait.
macro_rules! toy_state {
    () => {
        fn grains(&self) -> usize {
            GRAINS
        }
        fn save(&mut self) {
            self.kept = None;
            self.kept = Some(Box::new(self.clone()));
        }
        fn restore(&mut self) {
            let kept = self.kept.clone().expect("save comes before restore");
            *self = Self { kept: Some(kept.clone()), ..*kept };
        }
        fn write_checkpoint(&self, _: &Path) -> Result<(), SolverError> {
            Ok(())
        }
        fn write_fields(&mut self, _: &Window) -> Result<(), SolverError> {
            Ok(())
        }
        fn solver_seconds(&self) -> f64 {
            0.0
        }
    };
}

impl Participant for ToyFluid {
    type Incoming = Kinematics;
    type Outgoing = Loads;
    const ROLE: Role = Role::Fluid;

    fn advance(
        &mut self,
        window: &Window,
        exchange: &mut dyn Exchange<Kinematics, Loads>,
    ) -> Result<WindowReport, SolverError> {
        for (u, v) in self.u.iter_mut().zip(&self.v) {
            *u += window.dt * 3.0 * (v - *u);
        }
        let (u, v) = (&self.u, &self.v);
        exchange.send(window.header(), &mut |out| {
            for ((loads, u), v) in out.iter_mut().zip(u).zip(v) {
                *loads = Loads { force: [0.0, 0.0, 0.5 * (u - v)], ..Loads::default() };
            }
        })?;
        let v = &mut self.v;
        exchange.receive(window, &mut |_, grains| {
            v.clear();
            v.extend(grains.iter().map(|grain| grain.velocity[2]));
        })?;
        Ok(WindowReport { dt_limit: 2.0 * DT, residual: 0.0, substeps: 0 })
    }

    fn read_checkpoint(&mut self, _: &Path) -> Result<(), SolverError> {
        Ok(())
    }
    toy_state!();
}

impl Participant for ToyDem {
    type Incoming = Loads;
    type Outgoing = Kinematics;
    const ROLE: Role = Role::Dem;

    fn advance(
        &mut self,
        window: &Window,
        exchange: &mut dyn Exchange<Loads, Kinematics>,
    ) -> Result<WindowReport, SolverError> {
        let grains = &mut self.grains;
        exchange.receive(window, &mut |_, loads| {
            let dt = window.dt / window.substeps as f64;
            for _ in 0..window.substeps {
                for (grain, load) in grains.iter_mut().zip(loads) {
                    grain.velocity[2] += dt * (load.force[2] - 9.81);
                    grain.position[2] += dt * grain.velocity[2];
                    grain.gap = grain.position[2];
                }
            }
        })?;
        let header = Header { substeps: window.substeps, smallest_gap: 0.1, ..window.header() };
        let grains = &self.grains;
        exchange.send(header, &mut |out| out.copy_from_slice(grains))?;
        Ok(WindowReport { dt_limit: f64::INFINITY, residual: 0.0, substeps: window.substeps })
    }

    /// Checkpoints of the toy are whole runs: it does the windows before again.
    fn read_checkpoint(&mut self, _: &Path) -> Result<(), SolverError> {
        Ok(())
    }
    toy_state!();
}

type Taken<'a, R> = Box<dyn Fn(&Header, &[R]) + Send + 'a>;

/// One end of an exchange between two threads.
struct Pipe<'a, In, Out> {
    to: Sender<(Header, Vec<Out>)>,
    from: Receiver<(Header, Vec<In>)>,
    record: Taken<'a, Out>,
}

impl<In: Record, Out: Record> Exchange<In, Out> for Pipe<'_, In, Out> {
    fn send(&mut self, header: Header, fill: &mut dyn FnMut(&mut [Out])) -> Result<(), ExchangeError> {
        let mut records = vec![Out::default(); GRAINS];
        fill(&mut records);
        (self.record)(&header, &records);
        self.to.send((header, records)).map_err(|_| ExchangeError::Stopped)
    }

    fn receive(&mut self, _: &Window, read: &mut dyn FnMut(&Header, &[In])) -> Result<(), ExchangeError> {
        let (header, records) = self.from.recv().map_err(|_| ExchangeError::Stopped)?;
        read(&header, &records);
        Ok(())
    }
}

fn done(window: &Window, dt_limit: f64) -> Status {
    let (step, attempt, grains) = (window.step, window.attempt, GRAINS as u64);
    Status { state: State::Done as u64, step, attempt, dt_limit, grains, ..Status::default() }
}

/// Runs both toys over one window and records it.
pub(crate) fn run_window(fluid: &mut ToyFluid, dem: &mut ToyDem, window: &Window, recorder: &Recorder) {
    let (to_dem, from_fluid) = channel();
    let (to_fluid, from_dem) = channel();
    std::thread::scope(|scope| {
        let mut pipe = Pipe {
            to: to_dem,
            from: from_dem,
            record: Box::new(|h, r| recorder.record_loads(h, r).expect("loads")),
        };
        scope.spawn(move || fluid.advance(window, &mut pipe).expect("fluid"));
        let mut pipe = Pipe {
            to: to_fluid,
            from: from_fluid,
            record: Box::new(|h, r| recorder.record_kinematics(h, r).expect("kinematics")),
        };
        scope.spawn(move || dem.advance(window, &mut pipe).expect("dem"));
    });
    recorder.record_status(Role::Fluid, &done(window, 2.0 * DT)).expect("status");
    recorder.record_status(Role::Dem, &done(window, f64::INFINITY)).expect("status");
}

pub(crate) fn window(step: u64, attempt: u64) -> Window {
    Window { step, attempt, time: step as f64 * DT, dt: DT, substeps: 5, output: false }
}

/// A log of a coupled run; windows in `repeated` are done twice.
pub(crate) fn coupled_log(path: &Path, windows: u64, repeated: &[u64]) {
    coupled_log_with(path, windows, repeated, &manifest(), RecorderOptions::default());
}

pub(crate) fn coupled_log_with(
    path: &Path,
    windows: u64,
    repeated: &[u64],
    manifest: &Manifest,
    options: RecorderOptions,
) {
    let recorder = Recorder::create(path, manifest, options).expect("create");
    let (mut fluid, mut dem) = (ToyFluid::new(), ToyDem::new());
    for step in 0..windows {
        fluid.save();
        dem.save();
        let mut now = window(step, 0);
        recorder.record_command(&now.command(Order::Advance)).expect("advance");
        run_window(&mut fluid, &mut dem, &now, &recorder);
        if repeated.contains(&step) {
            fluid.restore();
            dem.restore();
            now = window(step, 1);
            recorder.record_command(&now.command(Order::Repeat)).expect("repeat");
            run_window(&mut fluid, &mut dem, &now, &recorder);
        }
        recorder.record_command(&now.command(Order::Accept)).expect("accept");
    }
    recorder.record_command(&window(windows, 0).command(Order::Stop)).expect("stop");
    recorder.finish().expect("finish");
}

/// A small generator with a fixed seed (xorshift64*, Vigna 2016).
pub(crate) struct Random(pub(crate) u64);

impl Random {
    pub(crate) fn next(&mut self) -> u64 {
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        self.0.wrapping_mul(0x2545_F491_4F6C_DD1D)
    }

    /// Any bits, so also NaN, infinities and subnormal numbers.
    pub(crate) fn f64(&mut self) -> f64 {
        f64::from_bits(self.next())
    }

    pub(crate) fn vector(&mut self) -> [f64; 3] {
        [self.f64(), self.f64(), self.f64()]
    }
}
