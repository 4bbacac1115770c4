//! The other side of a solver under test: a solver in this process that does as the case wants.

use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;
use std::time::Duration;

use protocol::channel::{Rendezvous, SharedMemory, Wire};
use protocol::message::{Header, Kinematics, Loads};
use protocol::participant::{Exchange, ExchangeError, Participant, Role, SolverError, Window, WindowReport};
use protocol::serve::serve;

/// What it does in a window.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum Deed {
    /// Exchanges as it should.
    #[default]
    Play,
    /// Lives, and sends nothing.
    Silent,
    /// Leaves the run.
    Leave,
    /// Sends a value that is not a number.
    NotFinite,
}

/// What it does from which window on; before, it plays.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Part {
    pub(super) deed: Deed,
    pub(super) from: u64,
}

/// What it sends, whatever it receives.
#[derive(Clone, Debug)]
pub(super) enum Lines {
    /// It is the fluid.
    Loads(Vec<Loads>),
    /// It is the DEM.
    Kinematics(Vec<Kinematics>),
}

/// Lets the actor join in a thread of its own. `over` ends its silence.
pub(super) fn enter(
    rendezvous: &Rendezvous,
    lines: Lines,
    part: Part,
    over: &Arc<AtomicBool>,
    out: &Path,
) -> JoinHandle<()> {
    let (rendezvous, over, out) = (rendezvous.clone(), over.clone(), out.to_owned());
    // How it fares shows in the run, which is observed.
    std::thread::spawn(move || {
        let _ = match lines {
            Lines::Loads(sends) => act::<AsFluid>(&rendezvous, sends, part, over, &out),
            Lines::Kinematics(sends) => act::<AsDem>(&rendezvous, sends, part, over, &out),
        };
    })
}

fn act<S: Side>(
    rendezvous: &Rendezvous,
    sends: Vec<S::Out>,
    part: Part,
    over: Arc<AtomicBool>,
    out: &Path,
) -> Result<(), SolverError> {
    let mut link = SharedMemory::<S::In, S::Out>::join(rendezvous, S::ROLE, sends.len())?;
    serve(&mut Actor::<S> { sends, part, over }, &mut link, out)
}

/// A side of the exchange.
trait Side {
    type In: Wire;
    type Out: Wire;
    const ROLE: Role;
    fn spoil(record: &mut Self::Out);
}

struct AsFluid;

impl Side for AsFluid {
    type In = Kinematics;
    type Out = Loads;
    const ROLE: Role = Role::Fluid;
    fn spoil(record: &mut Loads) {
        record.force[2] = f64::NAN;
    }
}

struct AsDem;

impl Side for AsDem {
    type In = Loads;
    type Out = Kinematics;
    const ROLE: Role = Role::Dem;
    fn spoil(record: &mut Kinematics) {
        record.velocity[2] = f64::NAN;
    }
}

struct Actor<S: Side> {
    sends: Vec<S::Out>,
    part: Part,
    over: Arc<AtomicBool>,
}

impl<S: Side> Actor<S> {
    fn send(
        &self,
        header: Header,
        deed: Deed,
        exchange: &mut dyn Exchange<S::In, S::Out>,
    ) -> Result<(), ExchangeError> {
        exchange.send(header, &mut |out| {
            out.copy_from_slice(&self.sends);
            if deed == Deed::NotFinite {
                out.iter_mut().take(1).for_each(S::spoil);
            }
        })
    }
}

impl<S: Side> Participant for Actor<S> {
    type Incoming = S::In;
    type Outgoing = S::Out;
    const ROLE: Role = S::ROLE;

    fn grains(&self) -> usize {
        self.sends.len()
    }

    fn advance(
        &mut self,
        window: &Window,
        exchange: &mut dyn Exchange<S::In, S::Out>,
    ) -> Result<WindowReport, SolverError> {
        let deed = if window.step >= self.part.from { self.part.deed } else { Deed::Play };
        match deed {
            Deed::Leave => return Err(SolverError::Failed("leaves, as the case wants it".into())),
            Deed::Silent => {
                while !self.over.load(Ordering::SeqCst) {
                    std::thread::sleep(Duration::from_millis(5));
                }
                return Err(ExchangeError::Stopped.into());
            }
            Deed::Play | Deed::NotFinite => {}
        }
        let substeps = if S::ROLE == Role::Dem { window.substeps } else { 0 };
        let header = Header { substeps, ..window.header() };
        if S::ROLE == Role::Fluid {
            self.send(header, deed, exchange)?;
            exchange.receive(window, &mut |_, _| {})?;
        } else {
            exchange.receive(window, &mut |_, _| {})?;
            self.send(header, deed, exchange)?;
        }
        Ok(WindowReport { dt_limit: f64::INFINITY, residual: 0.0, substeps })
    }

    fn save(&mut self) {}

    fn restore(&mut self) {}

    fn write_checkpoint(&self, _: &Path) -> Result<(), SolverError> {
        Ok(())
    }

    fn read_checkpoint(&mut self, _: &Path) -> Result<(), SolverError> {
        Ok(())
    }

    fn write_fields(&mut self, _: &Window) -> Result<(), SolverError> {
        Ok(())
    }

    fn solver_seconds(&self) -> f64 {
        0.0
    }
}
