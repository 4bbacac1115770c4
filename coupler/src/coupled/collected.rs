//! What has come of a window.

use protocol::message::{Header, Kinematics, Loads, Status};

/// What has come of a window on its way. Copies, because the fluid may send the loads of the next
/// window before the DEM has reported this one.
#[derive(Debug, Default)]
pub(super) struct Collected {
    pub(super) loads: Option<Header>,
    pub(super) kinematics: Option<Header>,
    pub(super) fluid: Option<Status>,
    pub(super) dem: Option<Status>,
    /// Loads, one per grain, once there is a header of them.
    pub(super) force: Vec<Loads>,
    pub(super) motion: Vec<Kinematics>,
}

impl Collected {
    pub(super) fn begin(&mut self) {
        self.loads = None;
        self.kinematics = None;
        self.fluid = None;
        self.dem = None;
    }

    /// Headers and reports, once all four are there.
    pub(super) fn whole(&self) -> Option<Whole> {
        Some(Whole { loads: self.loads?, kinematics: self.kinematics?, fluid: self.fluid?, dem: self.dem? })
    }
}

/// Headers and reports of a window that is done.
pub(super) struct Whole {
    pub(super) loads: Header,
    pub(super) kinematics: Header,
    pub(super) fluid: Status,
    pub(super) dem: Status,
}
