//! Two toy solvers whose every number is known, and their faults.

use std::path::{Path, PathBuf};
use std::time::Duration;

use protocol::channel::Rendezvous;
use protocol::message::{Kinematics, Loads};
use protocol::participant::{Exchange, Participant, Role, SolverError, Window, WindowReport};
use protocol::serve::Invitation;

/// What a toy solver does wrong, and in which window.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Fault {
    /// Never comes back.
    Hang(u64),
    /// Sends its message again and again.
    Flood(u64),
    /// Gives up with a text.
    GiveUp(u64),
}

impl Fault {
    pub(crate) fn write(self) -> String {
        match self {
            Self::Hang(step) => format!("hang {step}"),
            Self::Flood(step) => format!("flood {step}"),
            Self::GiveUp(step) => format!("give-up {step}"),
        }
    }

    fn read(text: &str) -> Option<Self> {
        let (kind, step) = text.split_once(' ')?;
        let step = step.parse().ok()?;
        match kind {
            "hang" => Some(Self::Hang(step)),
            "flood" => Some(Self::Flood(step)),
            "give-up" => Some(Self::GiveUp(step)),
            _ => None,
        }
    }
}

/// Force on grain `index` in a try of a window.
pub(crate) fn force(step: u64, attempt: u64, index: usize) -> [f64; 3] {
    [step as f64, attempt as f64, index as f64 + 0.5]
}

/// Either toy: `clock` is its state, the sum of the windows' lengths.
#[derive(Debug, Default)]
pub(crate) struct Toy {
    grains: usize,
    clock: f64,
    saved: f64,
    fault: Option<Fault>,
}

impl Toy {
    fn misbehave(&self, window: &Window) -> Result<(), SolverError> {
        match self.fault {
            Some(Fault::Hang(step)) if step == window.step => loop {
                std::thread::sleep(Duration::from_secs(60));
            },
            Some(Fault::GiveUp(step)) if step == window.step => {
                Err(SolverError::Failed("velocity of grain 3 is NaN".into()))
            }
            _ => Ok(()),
        }
    }

    fn report(&self, substeps: u64) -> WindowReport {
        WindowReport { dt_limit: 0.25, residual: self.clock, substeps }
    }
}

fn differs(what: String) -> SolverError {
    SolverError::Failed(what)
}

#[derive(Debug)]
pub(crate) struct ToyFluid(pub(crate) Toy);
#[derive(Debug)]
pub(crate) struct ToyDem(pub(crate) Toy);

macro_rules! state_of_toy {
    () => {
        fn grains(&self) -> usize {
            self.0.grains
        }
        fn save(&mut self) {
            self.0.saved = self.0.clock;
        }
        fn restore(&mut self) {
            self.0.clock = self.0.saved;
        }
        fn write_checkpoint(&self, folder: &Path) -> Result<(), SolverError> {
            let path = folder.join(Self::ROLE.to_string());
            std::fs::write(&path, self.0.clock.to_string())
                .map_err(|source| SolverError::File { path: path.display().to_string(), source })
        }
        fn read_checkpoint(&mut self, folder: &Path) -> Result<(), SolverError> {
            let path = folder.join(Self::ROLE.to_string());
            let text = std::fs::read_to_string(&path)
                .map_err(|source| SolverError::File { path: path.display().to_string(), source })?;
            self.0.clock = text.parse().map_err(|_| differs(text))?;
            Ok(())
        }
        fn write_fields(&mut self, _: &Window) -> Result<(), SolverError> {
            Ok(())
        }
        fn solver_seconds(&self) -> f64 {
            self.0.clock
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
        self.0.misbehave(window)?;
        let times = if self.0.fault == Some(Fault::Flood(window.step)) { 1000 } else { 1 };
        for _ in 0..times {
            exchange.send(window.header(), &mut |loads| {
                for (index, load) in loads.iter_mut().enumerate() {
                    load.force = force(window.step, window.attempt, index);
                }
            })?;
        }
        self.0.clock += window.dt;
        let clock = self.0.clock;
        let mut wrong = None;
        exchange.receive(window, &mut |_, grains| {
            wrong = grains.iter().enumerate().position(|(index, grain)| {
                grain.velocity != force(window.step, window.attempt, index) || grain.position != [clock; 3]
            });
        })?;
        match wrong {
            None => Ok(self.0.report(0)),
            Some(grain) => Err(differs(format!("grain {grain} came back changed"))),
        }
    }

    state_of_toy!();
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
        self.0.misbehave(window)?;
        let mut forces = Vec::new();
        exchange.receive(window, &mut |_, loads| {
            forces = loads.iter().map(|load| load.force).collect();
        })?;
        self.0.clock += window.dt;
        let clock = self.0.clock;
        let mut header = window.header();
        header.substeps = window.substeps;
        exchange.send(header, &mut |grains| {
            for (grain, force) in grains.iter_mut().zip(&forces) {
                grain.velocity = *force;
                grain.position = [clock; 3];
            }
        })?;
        Ok(self.0.report(window.substeps))
    }

    state_of_toy!();
}

/// Plays `role` in the run of the environment.
pub(crate) fn play(role: &str, out_dir: &Path) -> Result<(), SolverError> {
    let rendezvous = Rendezvous::from_environment()?.expect("a token");
    let fault = std::env::var("TOY_FAULT").ok().as_deref().and_then(Fault::read);
    let toy = Toy { grains: rendezvous.grains, fault, ..Toy::default() };
    let (scene, out) = (PathBuf::new(), out_dir.to_owned());
    let invitation = Invitation { scene, rendezvous, out, checkpoint: None };
    match role {
        "fluid" => invitation.serve(&mut ToyFluid(toy)),
        "dem" => invitation.serve(&mut ToyDem(toy)),
        other => panic!("no role {other}"),
    }
}
