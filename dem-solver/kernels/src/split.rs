//! What acted on chosen grains, sub-step by sub-step.

use crate::motion::Vec3;

/// One grain over one sub-step. Forces are means over it, as the integrator weighs them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SplitRow {
    /// Sub-step of the window, from 0.
    pub substep: u32,
    /// Its end, s.
    pub time: f64,
    /// Length, s.
    pub dt: f64,
    /// Grain.
    pub grain: usize,
    /// Centre at the end, m.
    pub position: Vec3,
    /// Velocity at the end, m/s.
    pub velocity: Vec3,
    /// Velocity gained over the length of the sub-step, m/s².
    pub acceleration: Vec3,
    /// Contact force, N.
    pub contact: Vec3,
    /// Modelled lubrication force, N.
    pub lubrication: Vec3,
}

/// A chosen grain, in the sub-step under way.
#[derive(Clone, Debug, Default, PartialEq)]
struct Chosen {
    grain: usize,
    /// Velocity at the start, m/s.
    start: Vec3,
    contact: Vec3,
    lubrication: Vec3,
}

/// The rows of a window.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Split {
    chosen: Vec<Chosen>,
    rows: Vec<SplitRow>,
}

impl Split {
    /// Notes `grains` in the next windows; none at all: nothing is noted, and it costs nothing.
    pub(crate) fn choose(&mut self, grains: &[usize]) {
        self.chosen.clear();
        self.chosen.extend(grains.iter().map(|&grain| Chosen { grain, ..Chosen::default() }));
        self.rows.clear();
    }

    /// The rows of the last window, in the order of the sub-steps.
    #[must_use]
    pub fn rows(&self) -> &[SplitRow] {
        &self.rows
    }

    /// A window begins, in which grains move with `velocity`, m/s.
    pub(crate) fn begin(&mut self, velocity: &[Vec3]) {
        self.rows.clear();
        for chosen in &mut self.chosen {
            *chosen = Chosen { grain: chosen.grain, start: velocity[chosen.grain], ..Chosen::default() };
        }
    }

    /// Adds contact forces with their weight in the sub-step.
    pub(crate) fn add_contact(&mut self, forces: &[Vec3], weight: f64) {
        self.chosen.iter_mut().for_each(|chosen| chosen.contact += forces[chosen.grain] * weight);
    }

    /// Adds the lubrication forces of the sub-step.
    pub(crate) fn add_lubrication(&mut self, forces: &[Vec3]) {
        self.chosen.iter_mut().for_each(|chosen| chosen.lubrication += forces[chosen.grain]);
    }

    /// The sub-step of length `dt` that ends at `time` is done; `now` are all positions and velocities.
    pub(crate) fn end_substep(&mut self, now: (&[Vec3], &[Vec3]), substep: u32, time: f64, dt: f64) {
        for chosen in &mut self.chosen {
            let Chosen { grain, start, contact, lubrication } = *chosen;
            let (position, velocity) = (now.0[grain], now.1[grain]);
            let acceleration = (velocity - start) / dt;
            self.rows.push(SplitRow {
                substep,
                time,
                dt,
                grain,
                position,
                velocity,
                acceleration,
                contact,
                lubrication,
            });
            *chosen = Chosen { grain, start: velocity, ..Chosen::default() };
        }
    }
}
