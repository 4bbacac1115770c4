//! The partner of a solver under test: a thread of this process that sends given records, and fails as a case
//! asks.

use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::Receiver;
use std::thread::JoinHandle;
use std::time::Duration;

use protocol::channel::{Rendezvous, Wire};
use protocol::log::{Logged, Records};
use protocol::message::{Header, Kinematics, Loads};
use protocol::participant::{Exchange, ExchangeError, Participant, Role, SolverError, Window, WindowReport};
use protocol::serve::serve;

/// What it does in a window.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum Fault {
    /// Exchanges as it should.
    #[default]
    None,
    /// Lives, and sends nothing.
    Silent,
    /// Leaves the run.
    Leave,
    /// Sends a value that is not a number.
    NotFinite,
}

/// A fault and the window from which on it shows; before, the peer exchanges as it should.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct FaultFrom {
    pub(crate) fault: Fault,
    pub(crate) from: u64,
}

/// What the peer sends, and how it fails.
pub(super) struct Instructions {
    /// What it sends at first.
    pub(super) records: Records,
    /// What it sends instead, at most one for each window that is ordered.
    pub(super) replaced: Receiver<Records>,
    /// What it does.
    pub(super) fault: FaultFrom,
    /// Ends its silence.
    pub(super) over: Arc<AtomicBool>,
}

/// Starts the peer, which joins the run in a thread of its own.
pub(super) fn start(rendezvous: &Rendezvous, instructions: Instructions, out: &Path) -> JoinHandle<()> {
    let (rendezvous, out) = (rendezvous.clone(), out.to_owned());
    // An error of the peer shows in the run, which is observed.
    std::thread::spawn(move || {
        let _ = match instructions.records {
            Records::Loads(_) => serve_with::<Kinematics>(&rendezvous, instructions, &out),
            Records::Kinematics(_) => serve_with::<Loads>(&rendezvous, instructions, &out),
        };
    })
}

fn serve_with<In: Incoming>(
    rendezvous: &Rendezvous,
    instructions: Instructions,
    out: &Path,
) -> Result<(), SolverError> {
    let Instructions { records, replaced, fault, over } = instructions;
    let sends = In::Answer::of(records);
    let mut link = In::join(rendezvous, In::PEER, sends.len())?;
    serve(&mut FakePeer::<In> { sends, replaced, fault, over }, &mut *link, out)
}

/// What the peer receives; it sends the answer to it.
trait Incoming: Wire<Answer: Logged> {
    /// Role of the peer.
    const PEER: Role;
    /// Makes a value of an answer no number.
    fn spoil(record: &mut Self::Answer);
}

impl Incoming for Kinematics {
    const PEER: Role = Role::Fluid;
    fn spoil(record: &mut Loads) {
        record.force[2] = f64::NAN;
    }
}

impl Incoming for Loads {
    const PEER: Role = Role::Dem;
    fn spoil(record: &mut Kinematics) {
        record.velocity[2] = f64::NAN;
    }
}

struct FakePeer<In: Incoming> {
    sends: Vec<In::Answer>,
    replaced: Receiver<Records>,
    fault: FaultFrom,
    over: Arc<AtomicBool>,
}

impl<In: Incoming> FakePeer<In> {
    fn send(
        &self,
        header: Header,
        fault: Fault,
        exchange: &mut dyn Exchange<In, In::Answer>,
    ) -> Result<(), ExchangeError> {
        exchange.send(header, &mut |out| {
            for (out, record) in out.iter_mut().zip(&self.sends) {
                *out = *record;
            }
            if fault == Fault::NotFinite {
                out.iter_mut().take(1).for_each(In::spoil);
            }
        })
    }
}

impl<In: Incoming> Participant for FakePeer<In> {
    type Incoming = In;
    type Outgoing = In::Answer;
    const ROLE: Role = In::PEER;

    fn grains(&self) -> usize {
        self.sends.len()
    }

    fn advance(
        &mut self,
        window: &Window,
        exchange: &mut dyn Exchange<In, In::Answer>,
    ) -> Result<WindowReport, SolverError> {
        if let Ok(records) = self.replaced.try_recv() {
            self.sends = In::Answer::of(records);
        }
        let fault = if window.step >= self.fault.from { self.fault.fault } else { Fault::None };
        match fault {
            Fault::Leave => return Err(SolverError::Failed("leaves, as the case wants it".into())),
            Fault::Silent => {
                while !self.over.load(Ordering::SeqCst) {
                    std::thread::sleep(Duration::from_millis(5));
                }
                return Err(ExchangeError::Stopped.into());
            }
            Fault::None | Fault::NotFinite => {}
        }
        let substeps = if In::PEER == Role::Dem { window.substeps } else { 0 };
        let header = Header { substeps, ..window.header() };
        if In::PEER == Role::Fluid {
            self.send(header, fault, exchange)?;
            exchange.receive(window, &mut |_, _| {})?;
        } else {
            exchange.receive(window, &mut |_, _| {})?;
            self.send(header, fault, exchange)?;
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
