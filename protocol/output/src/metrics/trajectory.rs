//! What the metrics need of one grain's way, kept as it goes: settling, contacts, bounces.
//!
//! Plain numbers and options only, so that it goes into any checkpoint.

use serde::{Deserialize, Serialize};

use super::line::interpolate;

/// One grain over one window, as the metrics see it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Passage {
    /// Speed along the settling direction at the end, m/s.
    pub(super) speed: f64,
    /// Gap at the end, m.
    pub(super) gap: f64,
    /// Place along gravity at the end, m; none where gravity is along no axis.
    pub(super) depth: Option<f64>,
    /// Does a contact force act?
    pub(super) touching: bool,
    /// Normal speed at the last begin of a contact within the window, m/s; 0 if none.
    pub(super) impact: f64,
    /// Normal speed at the last end of a contact within the window, m/s; 0 if none.
    pub(super) rebound: f64,
    /// Time at the end, s.
    pub(super) time: f64,
}

/// Part of a place by which a way and a gap along it differ by rounding.
const ROUNDING: f64 = 1e-9;

/// A grain's way so far.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize, Serialize)]
pub struct Trajectory {
    /// Windows seen.
    pub windows: u64,
    /// Speed along the settling direction at the end of the last window, m/s.
    pub speed: f64,
    /// Gap at the end of the last window, m; none before the first.
    pub gap: Option<f64>,
    /// V_T: largest settling speed before the first contact, m/s.
    pub terminal: f64,
    /// Contacts that began.
    pub contacts: u64,
    /// Did a contact force act in the last window?
    pub touching: bool,
    /// V_C: normal speed at the first touch, m/s; none if the DEM does not report it.
    pub impact: Option<f64>,
    /// V_R: normal speed at the end of the first contact, m/s.
    pub rebound: Option<f64>,
    /// Where the surface of the last touch lies along gravity, less the radius, m.
    pub floor: Option<f64>,
    /// Height over what it touched at the end of the last window, m.
    pub height: Option<f64>,
    /// Largest height between the first and the second contact, m.
    pub first_height: f64,
    /// Largest height between the second and the third contact, m.
    pub second_height: f64,
    /// End of the window of the first touch, s.
    pub first_touch: Option<f64>,
    /// End of the window of the largest height between the first and the second contact, s.
    pub first_top: Option<f64>,
    /// End of the window of the second touch, s.
    pub second_touch: Option<f64>,
}

impl Trajectory {
    /// At t = 0, with the initial settling speed, m/s.
    pub fn new(speed: f64) -> Self {
        Self { speed, terminal: speed.max(0.0), ..Self::default() }
    }

    /// Whether the grain still rises after contact number `contact`, whose largest height is `height`, m.
    pub(super) fn rises(&self, contact: u64, height: f64) -> bool {
        self.contacts == contact && self.speed < 0.0 && self.height == Some(height)
    }

    /// Height over what it touched last, m: the gap, or the way along gravity where something else is nearer,
    /// such as a lid or a wall beside it.
    fn height(&self, passage: &Passage) -> f64 {
        let way =
            self.floor.zip(passage.depth).map(|(floor, depth)| (floor - depth, floor.abs().max(depth.abs())));
        match way {
            Some((way, size)) if way - passage.gap > ROUNDING * size => way,
            _ => passage.gap,
        }
    }

    /// Adds a window. A contact begins where the DEM reports an impact speed or, with a DEM that
    /// does not, where a contact force appears.
    pub(super) fn record(&mut self, passage: &Passage) {
        let begins = passage.impact > 0.0 || (passage.touching && !self.touching);
        let earlier = self.contacts;
        if begins {
            if self.contacts == 0 {
                self.impact = (passage.impact > 0.0).then_some(passage.impact);
            }
            self.contacts += 1;
            match self.contacts {
                1 => self.first_touch = Some(passage.time),
                2 => self.second_touch = Some(passage.time),
                _ => {}
            }
            self.floor = passage.depth.map(|depth| depth + passage.gap).filter(|floor| floor.is_finite());
        }
        if self.contacts == 0 {
            self.terminal = self.terminal.max(passage.speed);
        }
        // The end of the first contact may share a window with the begin of the second.
        let first = earlier <= 1 && self.contacts >= 1;
        if first && self.rebound.is_none() && passage.rebound > 0.0 {
            self.rebound = Some(passage.rebound);
        }
        let height = self.height(passage);
        match self.contacts {
            1 if height.is_finite() && height > self.first_height => {
                (self.first_height, self.first_top) = (height, Some(passage.time));
            }
            2 if height.is_finite() => self.second_height = self.second_height.max(height),
            _ => {}
        }
        self.windows += 1;
        self.speed = passage.speed;
        // No neighbour in reach is an infinite gap, which JSON cannot hold.
        (self.gap, self.height) = (Some(passage.gap.min(f64::MAX)), Some(height.min(f64::MAX)));
        self.touching = passage.touching || passage.impact > 0.0;
    }
}

/// Speeds at which a grain passes a stated gap: inward before the first contact (the last time),
/// outward between the first and the second (the first time), m/s.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize, Serialize)]
pub struct Crossing {
    /// Inward.
    pub inward: Option<f64>,
    /// Outward.
    pub outward: Option<f64>,
}

impl Crossing {
    /// Adds a window; `before` is the trajectory up to its start, `after` up to its end.
    ///
    /// The speed at the gap is interpolated linearly in the gap between the ends of the windows.
    /// Where the grain touches within the window, the touch (gap 0, V_C or V_R) is one of the ends.
    pub(super) fn record(&mut self, at: f64, before: &Trajectory, passage: &Passage, after: &Trajectory) {
        let Some(gap) = before.gap else { return };
        let touched = after.contacts > before.contacts;
        if before.contacts == 0 && gap > at {
            let end = match (touched, after.impact) {
                (true, Some(impact)) => (0.0, impact),
                _ => (passage.gap.min(f64::MAX), passage.speed),
            };
            if end.0 <= at {
                self.inward = Some(interpolate(at, (gap, before.speed), end));
            }
        }
        // The speed of settling is negative on the way out.
        if after.contacts == 1 && self.outward.is_none() && passage.gap >= at {
            let released = before.rebound.is_none().then_some(after.rebound).flatten();
            let start = match released {
                Some(rebound) => (0.0, rebound),
                None => (gap, -before.speed),
            };
            if start.0 < at {
                self.outward =
                    Some(interpolate(at, start, (passage.gap.min(f64::MAX), -passage.speed)).max(0.0));
            }
        }
    }
}
