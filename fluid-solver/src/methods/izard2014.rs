//! Direct forcing and loads of Izard, Bonometti & Lacaze (2014), as printed.
//!
//! ```text
//! f = α (U − V)/dt,  u = V + dt f             (7)     V: the velocity before it is projected, α: the mask, eqs 8–10
//! F = −ρ ρ_p/(ρ_p − ρ) ∫ f dV                 (5, 6)  the buoyancy is in F, and lost where a grain rests
//! F = −ρ ∫ f dV + m_f (dU/dt − g)                     along what the fluid does not move
//! ```
//! (5, 6) put Newton's law in for dU/dt, which a grain that is held or driven does not obey: the last line is
//! what they come from. m_f: mass of the displaced fluid. The fluid takes its whole step with the motion
//! known, so that the loads of a window meet the motion of its start: `explicit` order.
//!
//! f enters before the last projection, so that the pressure of the last stage answers the whole window's f:
//! with three stages three times over. Its mean over the window takes that of the stage before for the
//! others.

use super::grains::Grains;
use super::immersed_boundary::ImmersedBoundary;
use super::limits::{self, Limits};
use super::loads;
use crate::immersed::Wrench;
use crate::scene_grains;
use crate::step::Stepper;
use bedload_scene::{CheckedScene, Medium, Motion};
use protocol::facts::{Measure, Side, SolverBound};
use protocol::message::Loads;
use protocol::participant::Window;

/// Smallest |ρ_p/ρ − 1| of a free grain.
const LEAST_DIFFERENCE: f64 = 1e-6;

/// The method as printed.
pub struct Izard2014 {
    /// Density of the fluid, kg/m³.
    density: f64,
    /// Of each grain: the motions along x, y, z and about them that obey Newton's law.
    free: Vec<[bool; 6]>,
    /// ∫ f dV of each grain.
    forces: Vec<Wrench>,
    /// Part of each that is beyond faces of the box, where it is held or driven.
    outside: Vec<f64>,
    /// Mean of p/ρ over the window, m²/s².
    pressure: Vec<f64>,
}

impl Izard2014 {
    /// For the grains of a scene in a fluid of density `density`, kg/m³.
    pub fn new(scene: &CheckedScene, density: f64) -> Self {
        let free = scene_grains::freedoms(scene);
        let (forces, outside) = (vec![Wrench::default(); free.len()], vec![0.0; free.len()]);
        Self { density, forces, outside, free, pressure: Vec::new() }
    }
}

impl<const D: usize> ImmersedBoundary<D> for Izard2014 {
    fn place(&mut self, _: &Stepper<D>, _: &mut Grains<D>, _: &Window) {}

    fn step(&mut self, fluid: &mut Stepper<D>, grains: &mut Grains<D>, dt: f64) {
        fluid.advance_without_projection(dt, None);
        self.pressure.clone_from(&fluid.state().pressure);
        let last = fluid.projection_left() / dt;
        let moving = grains.immersed.shapes().iter().zip(&grains.memory.motions);
        for ((outside, free), (shape, motion)) in self.outside.iter_mut().zip(&self.free).zip(moving) {
            *outside = if *free == [false; 6] { loads::outside(fluid.grid(), shape, motion) } else { 0.0 };
        }
        let Grains { immersed, model, memory, .. } = grains;
        let (grid, state) = fluid.parts_mut();
        self.forces.copy_from_slice(immersed.forces((grid, model, &memory.motions), &state.velocity, None));
        immersed.impose_direct((grid, model, &memory.motions), &mut state.velocity);
        fluid.project();
        for (mean, p) in self.pressure.iter_mut().zip(&fluid.state().pressure) {
            *mean = (1.0 - last) * *mean + last * p;
        }
    }

    fn measure(&mut self, _: &mut Stepper<D>, _: &mut Grains<D>, _: f64) {}

    fn loads(&self, grains: &Grains<D>, out: &mut [Loads]) {
        let rho = self.density;
        for (i, (loads, shape)) in out.iter_mut().zip(grains.immersed.shapes()).enumerate() {
            let (f, a) = (&self.forces[i], grains.memory.acceleration(i));
            let scale = rho * shape.density / (shape.density - rho);
            let mass = rho * shape.volume * (1.0 - self.outside[i]);
            let inertia = mass * shape.gyration;
            *loads = Loads::default();
            for c in 0..3 {
                // From zero, so that no load is −0.
                let held = (0.0 - rho * f.force[c]) + mass * (a.force[c] - grains.gravity[c]);
                loads.force[c] = if self.free[i][c] { 0.0 - scale * f.force[c] } else { held };
                let held = (0.0 - rho * f.torque[c]) + inertia * a.torque[c];
                loads.torque[c] = if self.free[i][3 + c] { 0.0 - scale * f.torque[c] } else { held };
            }
        }
    }

    fn impose(&mut self, _: &mut Stepper<D>, _: &mut Grains<D>, _: f64) {}

    fn resume(&mut self, _: &Stepper<D>, _: &mut Grains<D>) {}

    fn mean_pressure(&self) -> Option<&[f64]> {
        Some(&self.pressure).filter(|pressure| !pressure.is_empty()).map(Vec::as_slice)
    }
}

/// The first free grain that is as dense as the fluid, for which the loads divide by zero.
pub(crate) fn neutral_grain(scene: &CheckedScene, density: f64) -> Option<usize> {
    let near = |grain: f64| (grain / density - 1.0).abs() < LEAST_DIFFERENCE;
    scene.grains.iter().position(|grain| grain.motion == Motion::Free && near(grain.density))
}

/// Lowest density ratios.
const LIMITS: Limits = Limits {
    alone: [
        ([2.0, 2.0, 2.0, 2.0, 1.5], "docs/maps/light-axisymmetric.csv"),
        ([2.0; 5], "docs/maps/light-space.csv"),
        ([2.0; 5], "docs/maps/light-plane.csv"),
    ],
    together: None,
    at_walls: None,
    bodies: None,
};

/// Largest ν dt/Δx² at which a sphere settled no faster than 1.2 times Stokes' speed.
/// docs/maps/direct-forcing.csv
const VISCOUS: f64 = 2.0;

/// `viscous`: ν/Δx², 1/s.
pub(super) fn bounds(scene: &CheckedScene, medium: &Medium, viscous: f64) -> Vec<SolverBound> {
    let remedy = "use fluid.method = \"calibrated\", heavier grains, or a smaller dt";
    let mut bounds = limits::density_ratio(scene, medium, &LIMITS, None, remedy);
    if scene.grains.is_empty() {
        return bounds;
    }
    let bound =
        |name, limit| SolverBound::new(name, "ν dt/Δx²", (viscous, Measure::Window), Side::AtMost, limit);
    let remedy = "use fluid.method = \"calibrated\", or a smaller dt";
    bounds.push(bound("direct-forcing", VISCOUS).because(
        "direct forcing (eq. 7) fails: viscosity undoes it within the step",
        "docs/maps/direct-forcing.csv",
        remedy,
    ));
    bounds.push(bound("direct-forcing-accuracy", 1.0).warning().because(
        "direct forcing (eq. 7) is wrong by tens of per cent in the settling speed",
        "docs/numerics.md, Forcing and viscosity (Ar = 9: +40 %, Ar = 0.9: +90 %)",
        remedy,
    ));
    // With no other grain and no wall nothing rests.
    let rests = scene.grains.len() > 1 || !scene.contact_walls().is_empty();
    let ratios = limits::free_grains(scene).map(|grain| grain.density / medium.density);
    let factor = ratios.map(|ratio| if ratio > 1.0 { ratio / (ratio - 1.0) } else { f64::INFINITY });
    if let Some(factor) = factor.reduce(f64::max).filter(|_| rests) {
        let value = (factor, Measure::One);
        bounds.push(
            SolverBound::new("resting-weight", "ρ_r/(ρ_r−1)", value, Side::AtMost, 1.05).warning().because(
                "a resting grain presses this many times its submerged weight, because the printed loads \
                 lose the buoyancy",
                "docs/numerics.md, Weight of a resting grain",
                "use fluid.method = \"calibrated\" where contact forces matter",
            ),
        );
    }
    bounds
}
