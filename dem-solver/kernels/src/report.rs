//! What goes into a window and what comes out of it.

use crate::motion::Vec3;
use crate::split::Split;
use serde::{Deserialize, Serialize};

/// What the fluid does to one grain over a window: constant over its sub-steps.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub struct GrainLoad {
    /// Mean force of the fluid, buoyancy included, N.
    pub force: Vec3,
    /// Mean torque about the centre, N m.
    pub torque: Vec3,
    /// Virtual mass C_v m_f, kg.
    pub added_mass: f64,
    /// Virtual moment of inertia, kg m².
    pub added_inertia: f64,
}

/// Where a state stopped being finite.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NonFinite {
    /// Index of the grain.
    pub grain: usize,
    /// `position`, `velocity`, `spin` or `orientation`.
    pub quantity: &'static str,
}

impl std::fmt::Display for NonFinite {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} of grain {} is not finite", self.quantity, self.grain)
    }
}

/// Outcome of a window.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WindowReport {
    /// Sub-steps done: as many as asked, unless the state stopped being finite.
    pub n_sub_done: u32,
    /// Smallest gap of any grain to another or to a wall, m: over all sub-steps within the watched
    /// range, and at the end of the window. Infinite if there is nothing else. Negative: overlap.
    pub smallest_gap: f64,
    /// Largest overlap over all sub-steps, m; zero without contact.
    pub largest_overlap: f64,
    /// First grain whose state is not finite; the window stopped there.
    pub first_non_finite: Option<NonFinite>,
    /// First free grain whose centre is behind a wall by more than its diameter at the end of the window.
    pub lost: Option<usize>,
}

/// Outcome of the sub-steps of a window.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Outcome {
    /// Sub-steps done.
    pub(crate) done: u32,
    pub(crate) finite: bool,
}

/// Energy taken by contacts since the start, J (per unit length for discs).
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Dissipated {
    /// By dashpots along the normal.
    pub normal: f64,
    /// By dashpots along the tangent.
    pub tangential: f64,
    /// By sliding.
    pub sliding: f64,
}

impl Dissipated {
    /// Sum of all.
    #[must_use]
    pub fn total(&self) -> f64 {
        self.normal + self.tangential + self.sliding
    }
}

/// Observations of one window, per grain and per wall.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Observations {
    /// Mean contact force over the window, N.
    pub mean_contact: Vec<Vec3>,
    /// Mean modelled lubrication force over the window, N.
    pub mean_lubrication: Vec<Vec3>,
    /// Mean force of contacts on each wall over the window, N.
    pub wall_contact: Vec<Vec3>,
    /// Mean force of modelled films on each wall over the window, N; the bulk engine has none.
    pub wall_lubrication: Vec<Vec3>,
    /// Smallest gap over the window within the watched range and at its end, m; infinite if nothing
    /// was near.
    pub smallest_gap: Vec<f64>,
    /// Gap at the end of the window, m: exact for walls and, in the general engine, in scenes of up to 64
    /// grains; else infinite beyond the watched range, which in the bulk engine ends at a touch. At any
    /// distance: [`crate::Dem::gap_of`].
    pub gap_end: Vec<f64>,
    /// Approach speed at the last beginning of a contact within the window, m/s; 0 if none.
    pub impact_speed: Vec<f64>,
    /// Separation speed at the last end of a contact within the window, m/s; 0 if none.
    pub rebound_speed: Vec<f64>,
    /// What acted on chosen grains in each sub-step; the bulk engine notes none.
    pub split: Split,
}

impl Observations {
    /// Room for `n` grains.
    #[must_use]
    pub fn new(n: usize) -> Self {
        Self {
            mean_contact: vec![Vec3::zeros(); n],
            mean_lubrication: vec![Vec3::zeros(); n],
            smallest_gap: vec![f64::INFINITY; n],
            gap_end: vec![f64::INFINITY; n],
            impact_speed: vec![0.0; n],
            rebound_speed: vec![0.0; n],
            ..Self::default()
        }
    }

    /// Forgets the last window; the next one has this number of walls.
    pub(crate) fn begin(&mut self, walls: usize) {
        for forces in [&mut self.wall_contact, &mut self.wall_lubrication] {
            forces.clear();
            forces.resize(walls, Vec3::zeros());
        }
        self.mean_contact.fill(Vec3::zeros());
        self.mean_lubrication.fill(Vec3::zeros());
        self.smallest_gap.fill(f64::INFINITY);
        self.gap_end.fill(f64::INFINITY);
        self.impact_speed.fill(0.0);
        self.rebound_speed.fill(0.0);
    }

    /// Records the beginning or the end of a contact of `first` with another grain or a wall, with the gap
    /// rate at that moment; `bears`: whether it bore a force before, and does now.
    #[inline(always)]
    pub(crate) fn note_event(&mut self, bears: (bool, bool), rate: f64, first: usize, second: Option<usize>) {
        if bears.0 != bears.1 {
            let Self { impact_speed, rebound_speed, .. } = self;
            let (speeds, speed) = if bears.1 { (impact_speed, -rate) } else { (rebound_speed, rate) };
            for grain in [Some(first), second].into_iter().flatten() {
                speeds[grain] = speed.max(0.0);
            }
        }
    }
}
