//! The fictitious-domain method of Yu & Shao (2007): rigid motion imposed at points of the bodies by
//! distributed Lagrange multipliers, in the form that knows no difference of densities
//! (docs/equations-immersed.md, section 9).
//!
//! Loads, order of the window and messages are those of the calibrated method; the force is on points that
//! move with the bodies, not on the grid. The points have the area of their body exactly, so that no
//! displaced mass is left over.

pub mod body_points;
mod outlines;
mod points;
mod stencil;

use super::grains::Grains;
use super::immersed_boundary::{ImmersedBoundary, OnWalls};
use super::loads::GrainLoads;
use crate::grid::Grid;
use crate::immersed::body::Shape;
use crate::step::Stepper;
use bedload_scene::{CheckedScene, Domain, Face, Geometry, Motion, SceneError, WallKind};
use body_points::BodyPoints;
use protocol::message::Loads;
use protocol::participant::Window;

/// Fewest cells across a body.
const FEWEST_ACROSS: f64 = 4.0;

/// Part of its reach by which a face may cut a grain.
const SLIGHT: f64 = 1e-3;

/// The method on the points of all bodies.
pub struct FictitiousDomain<const D: usize> {
    points: BodyPoints<D>,
    loads: GrainLoads,
}

impl<const D: usize> FictitiousDomain<D> {
    /// For bodies of the given shapes.
    pub(super) fn new(grid: &Grid<D>, shapes: &[Shape], loads: GrainLoads) -> Self {
        Self { points: BodyPoints::new(grid, shapes), loads }
    }
}

impl<const D: usize> ImmersedBoundary<D> for FictitiousDomain<D> {
    fn place(&mut self, fluid: &Stepper<D>, grains: &mut Grains<D>, window: &Window) {
        grains.predict(window.dt);
        if !grains.predicted.is_empty() {
            self.points.place(fluid.grid(), &grains.predicted);
            self.points.spread(fluid.grid(), &mut grains.force);
        }
    }

    fn step(&mut self, fluid: &mut Stepper<D>, grains: &mut Grains<D>, dt: f64) {
        fluid.step(dt, grains.force());
    }

    fn measure(&mut self, fluid: &mut Stepper<D>, grains: &mut Grains<D>, dt: f64) {
        if grains.predicted.is_empty() {
            return;
        }
        let velocity = &fluid.state().velocity;
        self.loads.set_forces(self.points.forces(fluid.grid(), &grains.predicted, dt, velocity));
        self.loads.measure(fluid, grains);
        self.loads.measure_virtual_mass(grains, false);
    }

    fn loads(&self, grains: &Grains<D>, out: &mut [Loads]) {
        self.loads.write(grains.immersed.shapes(), out);
    }

    fn leak(&self, grains: &Grains<D>) -> Option<(f64, usize)> {
        self.loads.leak(grains)
    }

    /// The points stay where they were expected; the motion is the one that came back.
    fn impose(&mut self, fluid: &mut Stepper<D>, grains: &mut Grains<D>, dt: f64) {
        let numbers = [dt, grains.model.viscosity];
        self.points.impose(&grains.memory.motions, numbers, &mut fluid.state_mut().velocity);
    }

    fn resume(&mut self, _: &Stepper<D>, grains: &mut Grains<D>) {
        self.loads.resume(grains);
    }

    fn force_on_walls(&self, grid: &Grid<D>, _: f64) -> Option<OnWalls<D>> {
        Some(self.points.held_by_walls(grid))
    }

    fn points(&self) -> Option<&[Vec<f64>; D]> {
        Some(&self.points.multipliers)
    }

    fn points_mut(&mut self) -> Option<&mut [Vec<f64>; D]> {
        Some(&mut self.points.multipliers)
    }
}

/// Refuses a scene in which the method cannot work.
pub(crate) fn check(scene: &CheckedScene) -> Result<(), SceneError> {
    let (source, domain) = (&scene.source, &scene.scene.domain);
    if domain.geometry != Geometry::Plane {
        return Err(source.error(
            "fluid.method",
            "is \"fictitious-domain\", which is for discs and other bodies of the plane",
            "take fluid.method = \"calibrated\", or domain.geometry = \"plane\"",
        ));
    }
    source.refuse_if(
        domain.stretching.is_some(),
        "domain.stretching",
        "makes cells of several sizes; the fictitious-domain method needs equal ones",
        "leave it out, or take fluid.method = \"calibrated\"",
    )?;
    let (x, z) = (domain.spacing(0), domain.spacing(1));
    if (x / z - 1.0).abs() > 1e-9 {
        return Err(source.error(
            "domain.cells",
            format!(
                "makes cells of {x} m by {z} m; the fictitious-domain method needs equal cells, square ones"
            ),
            "choose cells so that (upper − lower)/cells is the same along x and z",
        ));
    }
    let spacing = x.min(z);
    let thin = |grain: &bedload_scene::Grain| grain.thickness() < FEWEST_ACROSS * spacing;
    if let Some(grain) = scene.grains.iter().position(thin) {
        let across = scene.grains[grain].thickness();
        return Err(source.error(
            "domain.cells",
            format!(
                "makes grain {grain} {:.1} cells across; the fictitious-domain method needs {FEWEST_ACROSS}",
                across / spacing
            ),
            &format!("give more cells: {} m each, or less", across / FEWEST_ACROSS),
        ));
    }
    if let Some(grain) = scene.grains.iter().position(|grain| is_cut(domain, grain)) {
        return Err(source.error(
            &format!("grains[{grain}].position"),
            "is so near a no-slip or free-slip face that it cuts the grain; allowed with fluid.method = \
             \"fictitious-domain\": whole grains, as points behind a wall hold the fluid before it",
            "move the grain in, or take fluid.method = \"calibrated\"",
        ));
    }
    Ok(())
}

/// Whether a no-slip or free-slip face cuts a grain that stays or is driven there.
fn is_cut(domain: &Domain, grain: &bedload_scene::Grain) -> bool {
    let cut = |(axis, up): (usize, [f64; 3])| {
        let [down, up] = [up.map(|part| -part), up].map(|way| (1.0 - SLIGHT) * grain.reach_along(way));
        let (at, faces) = (grain.position[domain.geometry.component(axis)], domain.boundary(axis));
        let holds = |face: Option<&Face>| {
            face.is_some_and(|face| matches!(face.kind, WallKind::NoSlip | WallKind::FreeSlip))
        };
        let lower = holds(faces.as_ref().and_then(|faces| faces.lower.as_ref()));
        let upper = holds(faces.as_ref().map(|faces| &faces.upper));
        lower && at - down < domain.lower[axis] || upper && at + up > domain.upper[axis]
    };
    grain.motion != Motion::Free && [(0, [1.0, 0.0, 0.0]), (1, [0.0, 0.0, 1.0])].into_iter().any(cut)
}
