//! `fields/substeps_*.csv`: what acts on chosen grains in each sub-step of a window.

use std::fmt::Write as _;

use bedload_scene::{Axis, Geometry, ObservedSubsteps, OverTime};

use crate::grains::Grains;
use crate::motion::Vec3;
use crate::report::GrainLoad;
use crate::solver::Dem;
use crate::split::SplitRow;

/// What is written, and what was known of the grains when the window began.
#[derive(Clone, Debug)]
pub(crate) struct Substeps {
    asked: ObservedSubsteps,
    geometry: Geometry,
    /// Chosen grains that are there.
    grains: Vec<usize>,
    /// Mean acceleration of each over the window before, m/s².
    before: Vec<Vec3>,
}

impl Substeps {
    pub(crate) fn new(asked: &ObservedSubsteps, geometry: Geometry) -> Self {
        Self { asked: asked.clone(), geometry, grains: Vec::new(), before: Vec::new() }
    }

    /// The window from `start` to `end`, s, begins: says whether it is one that is asked for.
    pub(crate) fn begin(&mut self, dem: &mut Dem, start: f64, end: f64) -> bool {
        self.grains.clear();
        if self.asked.has(start, end) {
            self.grains.extend(self.asked.grains.iter().filter(|grain| **grain < dem.grains.len()));
        }
        self.before.clear();
        self.before.extend(self.grains.iter().map(|&grain| dem.grains.acceleration[grain]));
        dem.split(&self.grains);
        !self.grains.is_empty()
    }

    /// The table of the window that was done under `loads` and `gravity`. Along free axes of a free grain m
    /// dv/dt is the sum of the forces, with the weight m g: the force of the virtual mass m_a is m_a (A_prev
    /// − dv/dt).
    pub(crate) fn table(&self, dem: &Dem, gravity: &OverTime<[f64; 3]>, loads: &[GrainLoad]) -> String {
        // what stands on the axis of symmetry moves along it alone
        let axes = || self.geometry.axes().iter().filter(|axis| **axis != Axis::R);
        let mut text = String::from("substep,t,grain");
        for name in NAMES {
            for axis in axes() {
                let _ = write!(text, ",{name}_{}", axis.name());
            }
        }
        text.push('\n');
        for (place, row) in dem.observations().split.rows().iter().enumerate() {
            let place = place % self.grains.len();
            let mean = gravity.mean(row.time - row.dt, row.time).into();
            let values = values(row, &dem.grains, mean, loads[row.grain], self.before[place]);
            let _ = write!(text, "{},{},{}", row.substep, row.time, row.grain);
            for value in values {
                for axis in axes() {
                    let _ = write!(text, ",{}", value[axis.component()]);
                }
            }
            text.push('\n');
        }
        text
    }
}

/// Columns, each for the components that the geometry leaves free.
const NAMES: [&str; 8] = [
    "position",
    "velocity",
    "acceleration",
    "contact_force",
    "lubrication_force",
    "fluid_force",
    "virtual_mass_force",
    "weight",
];

/// The values of [`NAMES`].
fn values(row: &SplitRow, grains: &Grains, gravity: Vec3, load: GrainLoad, before: Vec3) -> [Vec3; 8] {
    let virtual_mass = (before - row.acceleration) * load.added_mass;
    [
        row.position,
        row.velocity,
        row.acceleration,
        row.contact,
        row.lubrication,
        load.force,
        virtual_mass,
        gravity * grains.mass[row.grain],
    ]
}
