//! What is observed of a window, and by whom.

use protocol::message::{Header, Kinematics, Loads};
use protocol::participant::Window;

/// What a run sees of the exchange.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Sides {
    /// Loads of the fluid.
    pub loads: bool,
    /// Motion of the grains.
    pub motion: bool,
    /// Contacts, lubrication and sub-steps of a DEM.
    pub contact: bool,
}

impl Sides {
    /// Fluid and DEM.
    pub fn coupled() -> Self {
        Self { loads: true, motion: true, contact: true }
    }

    /// DEM without fluid.
    pub fn dry() -> Self {
        Self { loads: false, motion: true, contact: true }
    }

    /// Fluid without DEM, about grains whose motion is given (`motion`: it is passed on, too).
    pub fn fluid_alone(motion: bool) -> Self {
        Self { loads: true, motion, contact: false }
    }
}

/// A scalar column whose values the solvers give, such as a pressure gradient.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Extra {
    /// Name of the column.
    pub name: String,
    /// Unit, `-` if it has none.
    pub unit: String,
    /// When its values are of.
    pub when: When,
}

/// When the value of a row is of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum When {
    /// The end of the window.
    End,
    /// The whole window: a mean, a sum or an extreme over it.
    Window,
}

/// An accepted window as observed. A slice may be empty where [`Sides`] says so.
#[derive(Clone, Copy, Debug)]
pub struct Sample<'a> {
    /// The window.
    pub window: &'a Window,
    /// Loads of the window, one per grain.
    pub loads: &'a [Loads],
    /// Header of the kinematics ([`Window::header`] without a DEM).
    pub header: &'a Header,
    /// Motion at the end of the window, one per grain.
    pub kinematics: &'a [Kinematics],
    /// Values of the [`Extra`] columns, in their order.
    pub extras: &'a [f64],
}

impl Sample<'_> {
    /// End of the window, s: the instant that `kinematics` are of.
    pub fn time(&self) -> f64 {
        self.window.time + self.window.dt
    }

    /// Is the grain still to be inserted, where the first `present` are there from the start?
    pub(crate) fn lacks(&self, grain: usize, present: usize) -> bool {
        grain >= present && self.kinematics.get(grain).is_some_and(|motion| !motion.is_there())
    }
}
