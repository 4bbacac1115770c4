//! What the first rank tells the others to do, and its exchange: what it receives the others get from it.
//!
//! The first rank is the participant of the run: it takes the orders, exchanges with the DEM and writes.
//! Before it does anything that needs the others it says so, and they do the same with their planes
//! ([`crate::follow`]).

use crate::ranks::Ranks;
use protocol::log::codec;
use protocol::message::{Header, Kinematics, Loads};
use protocol::participant::{Exchange, ExchangeError, SolverError, Window};
use pulp::bytemuck;
use serde::{Deserialize, Serialize};
use std::path::PathBuf;

/// An order of the first rank.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) enum Order {
    /// Build the fluid of a scene: its file, its text, the folder.
    Build(String, String, PathBuf),
    /// Do a window, with so many threads.
    Advance(Window, usize),
    Save,
    Restore,
    WriteCheckpoint(PathBuf),
    ReadCheckpoint(PathBuf),
    WriteFields(Window),
    MeanVelocity(usize),
    Speed,
    /// Bring the fields to the first rank, see [`crate::solver::Solver::show`].
    Show,
    /// Let the fluid go.
    Leave,
    /// The program ends.
    Quit,
}

/// Tells the other ranks, if there are any and this is the first; an error if one of them is gone.
pub(crate) fn tell(ranks: &Ranks, order: &Order) -> Result<(), SolverError> {
    if ranks.is_alone() || !ranks.is_first() {
        return Ok(());
    }
    let mut bytes = Vec::new();
    codec::encode(order, &mut bytes).map_err(|error| SolverError::Failed(error.to_string()))?;
    ranks.broadcast(bytes).map(drop)
}

/// The first rank says that the program ends; an error if a rank is gone.
pub fn dismiss(ranks: &Ranks) -> Result<(), SolverError> {
    tell(ranks, &Order::Quit)
}

/// Numbers of a motion: all that the fluid reads of it.
pub(crate) const NUMBERS: usize = 9;

fn numbers(record: &Kinematics) -> [f64; NUMBERS] {
    let ([x, y, z], [u, v, w], [p, q, r]) = (record.position, record.velocity, record.spin);
    [x, y, z, u, v, w, p, q, r]
}

/// The motion of those numbers.
pub(crate) fn record([x, y, z, u, v, w, p, q, r]: &[f64; NUMBERS]) -> Kinematics {
    Kinematics { position: [*x, *y, *z], velocity: [*u, *v, *w], spin: [*p, *q, *r], ..Kinematics::default() }
}

/// The exchange of the first rank: what it receives the others get from it.
pub(crate) struct Leader<'a> {
    pub(crate) inner: &'a mut dyn Exchange<Kinematics, Loads>,
    pub(crate) ranks: &'a Ranks,
}

impl Exchange<Kinematics, Loads> for Leader<'_> {
    fn send(&mut self, header: Header, fill: &mut dyn FnMut(&mut [Loads])) -> Result<(), ExchangeError> {
        let sent = self.inner.send(header, fill);
        if sent.is_err() {
            // The others wait for the motion: there will be none. The error counts, not what they hear.
            let _ = self.ranks.broadcast(Vec::new());
        }
        sent
    }

    fn receive(
        &mut self,
        window: &Window,
        read: &mut dyn FnMut(&Header, &[Kinematics]),
    ) -> Result<(), ExchangeError> {
        let mut motions: Vec<[f64; NUMBERS]> = Vec::new();
        let received = self.inner.receive(window, &mut |header, records| {
            motions.push([0.0; NUMBERS]);
            motions.extend(records.iter().map(numbers));
            read(header, records);
        });
        if received.is_err() {
            motions.clear();
        }
        let told = self.ranks.broadcast(bytemuck::cast_slice(&motions).to_vec());
        received?;
        told.map(drop).map_err(|error| ExchangeError::Transport(error.to_string()))
    }
}
