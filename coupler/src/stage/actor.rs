//! The other side of a solver: one in this process that sends what it is told, and does as the case wants.

use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::Receiver;
use std::thread::JoinHandle;
use std::time::Duration;

use protocol::channel::{Rendezvous, SharedMemory, Wire};
use protocol::log::{Logged, Records};
use protocol::message::{Header, Kinematics, Loads};
use protocol::participant::{Exchange, ExchangeError, Participant, Role, SolverError, Window, WindowReport};
use protocol::serve::serve;

/// What it does in a window.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum Deed {
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
pub(crate) struct Part {
    pub(crate) deed: Deed,
    pub(crate) from: u64,
}

/// All that the actor is told.
pub(super) struct Script {
    /// What it sends at first.
    pub(super) lines: Records,
    /// What it sends instead, at most one for each window that is ordered.
    pub(super) prompted: Receiver<Records>,
    /// What it does.
    pub(super) part: Part,
    /// Ends its silence.
    pub(super) over: Arc<AtomicBool>,
}

/// Lets the actor join in a thread of its own.
pub(super) fn enter(rendezvous: &Rendezvous, script: Script, out: &Path) -> JoinHandle<()> {
    let (rendezvous, out) = (rendezvous.clone(), out.to_owned());
    // How it fares shows in the run, which is observed.
    std::thread::spawn(move || {
        let _ = match script.lines {
            Records::Loads(_) => act::<AsFluid>(&rendezvous, script, &out),
            Records::Kinematics(_) => act::<AsDem>(&rendezvous, script, &out),
        };
    })
}

fn act<S: Side>(rendezvous: &Rendezvous, script: Script, out: &Path) -> Result<(), SolverError> {
    let Script { lines, prompted, part, over } = script;
    let sends = S::Out::of(lines);
    let mut link = SharedMemory::<S::In, S::Out>::join(rendezvous, S::ROLE, sends.len())?;
    serve(&mut Actor::<S> { sends, prompted, part, over }, &mut link, out)
}

/// A side of the exchange.
trait Side {
    type In: Wire;
    type Out: Wire + Logged;
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
    prompted: Receiver<Records>,
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
            for (out, line) in out.iter_mut().zip(&self.sends) {
                *out = *line;
            }
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
        if let Ok(lines) = self.prompted.try_recv() {
            self.sends = S::Out::of(lines);
        }
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
