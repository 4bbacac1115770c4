//! What a run is made of: plain data, checked once.

use crate::grain::{Grain, Shape};
use crate::laws::table::ContactLaw;
use crate::laws::walls::Wall;
use crate::lubrication::law::{LineResolution, LubricationModel};
use crate::lubrication::settings::Lubrication;
use bedload_outline::Outline;
use bedload_over_time::OverTime;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// What does the sub-steps: a scene leaves it to the program.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Engine {
    /// `Bulk` for 256 grains and more where the run allows it, else `General`.
    #[default]
    Auto,
    /// All laws, lubrication and integrators.
    General,
    /// For many grains: linear contacts and symplectic Euler only, several times as fast.
    Bulk,
}

/// Time integration of the sub-step.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Integrator {
    /// v ← v + dt a(x), x ← x + dt v: one force evaluation, first order, no energy drift.
    #[default]
    SymplecticEuler,
    /// Half kick, drift, half kick: second order; one evaluation, and one more per window.
    VelocityVerlet,
    /// Runge–Kutta of third order (Shu & Osher 1988): for smooth problems; three evaluations.
    Rk3,
}

/// How the bulk engine does its work: nothing here changes a bit of the result.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct BulkSettings {
    /// Threads; 0: one.
    pub threads: usize,
    /// Sub-steps that follow one another through the blocks; 0: chosen by the size of the run.
    pub depth: u32,
    /// Width of the lists beyond contact, m; none: chosen from the motion.
    pub skin: Option<f64>,
    /// Leave the widest vectors of the machine unused.
    pub plain: bool,
}

/// A whole run: grains, walls, models.
#[derive(Clone, Debug, PartialEq)]
pub struct DemSpec {
    /// Grains.
    pub grains: Vec<Grain>,
    /// Shape of all grains that have no outline of their own.
    pub shape: Shape,
    /// Outlines of the bodies that are not round ([`Grain::outline`]).
    pub outlines: Vec<Outline>,
    /// Walls.
    pub walls: Vec<Wall>,
    /// Lower end and length of the period per axis, m; none where the axis is not periodic.
    pub periods: [Option<(f64, f64)>; 3],
    /// Gravity, m/s².
    pub gravity: OverTime<[f64; 3]>,
    /// Law of contact.
    pub contact: ContactLaw,
    /// Model of lubrication.
    pub lubrication: Lubrication,
    /// What the flow resolves of the films of discs.
    pub line_resolution: LineResolution,
    /// Viscosity μ of the fluid, Pa s; used by lubrication and by the drag within a window.
    pub viscosity: f64,
    /// Density ρ of the fluid, kg/m³; zero: no drag within a window.
    pub fluid_density: f64,
    /// Time integration.
    pub integrator: Integrator,
    /// Sub-step that contacts are resolved with, s: without loads a window of one such sub-step is like one
    /// of many. 0 where all windows of one sub-step are flights.
    pub contact_step: f64,
    /// Width of the neighbour list beyond the range of forces, m; a tenth of the mean diameter if
    /// absent. It changes the cost, never the result.
    pub skin: Option<f64>,
    /// What does the sub-steps.
    pub engine: Engine,
    /// How the bulk engine does its work.
    pub bulk: BulkSettings,
    /// Whether forces, gaps and impact speeds per grain are wanted; the general engine has them anyway.
    pub observations: bool,
    /// Whether an account of dissipated energy is kept (`general::energy`); not by the bulk engine.
    pub energy: bool,
    /// Whether forces on chosen grains may be noted in each sub-step ([`crate::solver::Dem::split`]); not by
    /// the bulk engine.
    pub split: bool,
    /// Whether orientations are wanted: nothing depends on them. The general engine has them anyway.
    pub orientation: bool,
}

impl DemSpec {
    /// Grains and one law; no wall, gravity, lubrication or period.
    #[must_use]
    pub fn new(grains: Vec<Grain>, contact: ContactLaw) -> Self {
        Self {
            grains,
            shape: Shape::Sphere,
            outlines: Vec::new(),
            walls: Vec::new(),
            periods: [None; 3],
            gravity: OverTime::default(),
            contact,
            lubrication: Lubrication::None,
            line_resolution: LineResolution::MASK,
            viscosity: 0.0,
            fluid_density: 0.0,
            integrator: Integrator::default(),
            contact_step: 0.0,
            skin: None,
            engine: Engine::default(),
            bulk: BulkSettings::default(),
            observations: true,
            orientation: true,
            energy: false,
            split: false,
        }
    }

    /// Whether any body is not round.
    #[must_use]
    pub fn has_bodies(&self) -> bool {
        self.grains.iter().any(|grain| grain.outline.is_some())
    }

    /// Radius of the largest grain, m.
    #[must_use]
    pub fn largest_radius(&self) -> f64 {
        self.grains.iter().map(|grain| grain.radius).fold(0.0, f64::max)
    }

    /// Largest gap at which a force acts, m: beyond it gaps are not watched.
    #[must_use]
    pub fn range(&self) -> f64 {
        let lubrication = self.lubrication_model().map_or(0.0, |model| model.reach(self.largest_radius()));
        lubrication.max(self.contact.range())
    }

    /// Skin of the neighbour list, m.
    #[must_use]
    pub fn skin(&self) -> f64 {
        let mean =
            self.grains.iter().map(|grain| grain.radius).sum::<f64>() / self.grains.len().max(1) as f64;
        self.skin.unwrap_or(0.2 * mean)
    }

    /// Model of lubrication with its shape resolved, and its settings.
    #[must_use]
    pub fn lubrication_model(&self) -> Option<LubricationModel> {
        let settings = self.lubrication.settings()?;
        Some(LubricationModel {
            shape: self.shape,
            roughness: settings.roughness,
            cut_off: settings.cut_off,
            longest: settings.longest.unwrap_or(f64::INFINITY),
            resolved_length: settings.resolved_length.unwrap_or(f64::INFINITY),
            line: self.line_resolution,
            // Beds of discs tremble with it at steps that they bear without (docs/decisions/line-film.md).
            tangential: self.lubrication.is_tangential()
                && (self.shape == Shape::Sphere || settings.tangential == Some(true)),
            viscosity: self.viscosity,
        })
    }
}
