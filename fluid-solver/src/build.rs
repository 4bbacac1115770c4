//! From a checked scene to a grid, the stepper's options and the grains' shapes.

use crate::axis::AxisSpec;
use crate::boundary::{Boundary, Profile};
use crate::config::{Choices, DivisionKey, ForceTransport, MaskRadius, ProjectionsKey, SchemeKey};
use crate::division::{Division, DivisionError};
use crate::field::{State, set_component};
use crate::grid::{Geometry, Grid, GridSpec};
use crate::immersed::body::{Motion, Shape, along_axes, laboratory};
use crate::immersed::brinkman::largest_viscous_number;
use crate::immersed::mask_model::Mask;
use crate::ranks::Ranks;
use crate::scheme::{Options, Projections, Scheme, Viscous};
use bedload_scene::{CheckedScene, Face, InflowProfile, InitialVelocity, Medium, SceneError, WallKind};
use protocol::facts::{Forcing, LoadsForm};
use protocol::scheme as coupling;
use std::sync::Arc;

/// Geometry of the scene in this crate's words.
pub fn geometry(scene: &CheckedScene) -> Geometry {
    match scene.scene.domain.geometry {
        bedload_scene::Geometry::Plane => Geometry::Plane,
        bedload_scene::Geometry::Axisymmetric => Geometry::Axisymmetric,
        bedload_scene::Geometry::Space => Geometry::Space,
    }
}

/// The grid of a scene with `D` axes.
///
/// # Errors
/// What the direct solver cannot treat (two stretched axes, say).
pub fn grid<const D: usize>(scene: &CheckedScene) -> Result<Grid<D>, SceneError> {
    let domain = &scene.scene.domain;
    let geometry = geometry(scene);
    let axes = std::array::from_fn(|a| {
        let (start, end, cells) = (domain.lower[a], domain.upper[a], domain.cells[a]);
        match domain.stretching.filter(|s| s.axis == domain.geometry.axes()[a]) {
            None => AxisSpec::Uniform { start, end, cells },
            Some(s) => AxisSpec::Growing { start, core_end: s.uniform_to, width: s.spacing, end, cells },
        }
    });
    let boundaries = std::array::from_fn(|a| {
        let faces = domain.boundary(a).expect("the scene's faces were checked");
        let lower = faces.lower.map_or(Boundary::Axis, |face| boundary(geometry, &face));
        [lower, boundary(geometry, &faces.upper)]
    });
    Grid::new(&GridSpec { geometry, axes, boundaries }).map_err(|error| {
        scene.source.error(
            if domain.stretching.is_some() { "domain.stretching" } else { "domain" },
            error.to_string(),
            "change the grid as the message says",
        )
    })
}

/// The grid of a scene as `ranks` share it.
///
/// # Errors
/// Also what cannot be divided, and what ranks cannot do yet.
pub fn divided<const D: usize>(
    scene: &CheckedScene,
    choices: &Choices,
    ranks: &Ranks,
) -> Result<Grid<D>, SceneError> {
    let grid = grid(scene)?;
    let several = !ranks.is_alone();
    match choices.division {
        None | Some(DivisionKey::Whole) if !several => return Ok(grid),
        Some(DivisionKey::Whole) => {
            return Err(scene.source.error(
                "fluid.division",
                format!("is \"whole\", which {} ranks cannot share", ranks.size()),
                "set fluid.division = \"blocks\", or leave it out",
            ));
        }
        _ => {}
    }
    let grid = grid.divided(ranks.clone()).map_err(|error| {
        let key = match error {
            DivisionError::Open => "domain.boundary",
            DivisionError::Axes => "domain.geometry",
            DivisionError::Planes { .. } | DivisionError::Ranks { .. } => "domain.cells",
        };
        let remedy = "start as many ranks as are possible, or one with fluid.division = \"whole\"";
        scene.source.error(key, error.to_string(), remedy)
    })?;
    if several {
        let slabs = Division::slabs(grid.cells[D - 1], ranks.size());
        refuse(scene, choices, slabs.map_or(0, |[least, _]| least))?;
    }
    Ok(grid)
}

/// Planes that a rank must have for the local solve of viscosity to fetch what it needs from its neighbours.
const LOCAL: usize = 5;

/// Refuses what several ranks cannot do yet, of which the one that has fewest has `least` planes.
///
/// # Errors
/// With the key.
pub fn refuse(scene: &CheckedScene, choices: &Choices, least: usize) -> Result<(), SceneError> {
    let scheme = crate::coupling::read(scene, choices.form)?.0;
    if scheme == coupling::Scheme::Iterated {
        return Err(scene.source.error(
            "coupling.scheme",
            "is \"iterated\", which several ranks of the fluid cannot do yet",
            "take \"semi-implicit\" or \"overlapped\", or start one rank",
        ));
    }
    if transport(scene, choices, scheme).is_some() && tells_viscosity(choices) && least < LOCAL {
        return Err(scene.source.error(
            "fluid.immersed.viscous_sweeps",
            format!("asks for a local solve, for which each rank must have {LOCAL} planes; one has {least}"),
            "start fewer ranks, or set fluid.immersed.viscous_sweeps = 0",
        ));
    }
    Ok(())
}

fn boundary<const D: usize>(geometry: Geometry, face: &Face) -> Boundary<D> {
    let velocity = along_axes(geometry, face.velocity);
    match face.kind {
        WallKind::Periodic => Boundary::Periodic,
        WallKind::FreeSlip => Boundary::FreeSlip,
        WallKind::NoSlip => Boundary::NoSlip { velocity },
        WallKind::Inflow => {
            let profile = match face.profile {
                InflowProfile::Uniform => Profile::Uniform,
                InflowProfile::Parabolic => Profile::Parabolic,
            };
            Boundary::Inflow { velocity, profile }
        }
        WallKind::Outflow => Boundary::Outflow,
    }
}

/// The stepper's options, `viscous` being decided by [`crate::plan`].
pub fn options<const D: usize>(
    scene: &CheckedScene,
    medium: &Medium,
    choices: &Choices,
    viscous: Viscous,
) -> Options<D> {
    let geometry = geometry(scene);
    let projections = match choices.time.projections {
        ProjectionsKey::EachStage => Projections::EveryStage,
        ProjectionsKey::Once => Projections::OncePerStep,
    };
    Options {
        viscosity: medium.kinematic_viscosity(),
        scheme: match choices.time.scheme {
            SchemeKey::Rk3 => Scheme::RungeKutta3 { projections },
            SchemeKey::Ab2 => Scheme::AdamsBashforth2,
        },
        viscous,
        convection: choices.time.convection,
        body_force: std::array::from_fn(|a| drive(scene, medium, a, laboratory(geometry, a))),
    }
}

/// What drives the fluid along grid axis `axis`, m/s²: body force, mean pressure gradient, and
/// gravity where the axis is periodic, so that no pressure can balance it.
fn drive(scene: &CheckedScene, medium: &Medium, axis: usize, c: usize) -> f64 {
    let gravity = if scene.scene.domain.is_periodic(axis) { scene.scene.gravity[c] } else { 0.0 };
    medium.body_force[c] + gravity - medium.pressure_gradient[c] / medium.density
}

/// Which grains the fluid moves.
pub fn free(scene: &CheckedScene) -> Vec<bool> {
    scene.grains.iter().map(|grain| grain.motion == bedload_scene::Motion::Free).collect()
}

/// Shapes of the grains, in message order.
pub fn shapes(scene: &CheckedScene) -> Vec<Shape> {
    let shape = |grain: &bedload_scene::Grain| Shape {
        radius: grain.radius,
        mask_radius: grain.radius,
        outline: grain.outline().map(Arc::new),
        density: grain.density,
        volume: grain.volume(),
        gyration: grain.gyration(),
    };
    scene.grains.iter().map(shape).collect()
}

/// Motion of the grains at t = 0.
pub fn motions(scene: &CheckedScene) -> Vec<Motion> {
    let geometry = geometry(scene);
    let motion = |grain: &bedload_scene::Grain| {
        let mut velocity = grain.velocity;
        if let Some(swing) = &grain.oscillation {
            for (v, amplitude) in velocity.iter_mut().zip(swing.amplitude) {
                *v += amplitude * swing.phase.sin();
            }
        }
        let from = protocol::message::Kinematics {
            position: grain.position,
            velocity,
            spin: grain.spin,
            orientation: grain.orientation,
            ..Default::default()
        };
        let motion = Motion::received(geometry, &from);
        match grain.motion {
            bedload_scene::Motion::Fixed => Motion { velocity: [0.0; 3], spin: [0.0; 3], ..motion },
            _ => motion,
        }
    };
    scene.grains.iter().map(motion).collect()
}

/// Whether no grain ever moves.
fn stands(scene: &CheckedScene) -> bool {
    scene.grains.iter().all(|grain| grain.motion == bedload_scene::Motion::Fixed)
}

/// Whether the carried force goes with the grains, in every step or where it would lag;
/// [`crate::config::FluidSection::read`] has seen that it can where the scene asks for it. By itself it does
/// among spheres in space of which two or more move, or that fill more than a twentieth of their box, unless windows
/// are repeated.
pub fn transport(scene: &CheckedScene, choices: &Choices, coupling: coupling::Scheme) -> Option<Transport> {
    let can = choices.method == Forcing::Carried
        && choices.mask == Mask::ParameterFree
        && coupling.carries(choices.form, true)
        && choices.form == LoadsForm::YuShaoFixedPoint;
    let moving = scene.grains.iter().filter(|grain| grain.motion != bedload_scene::Motion::Fixed).count();
    match choices.force_transport {
        ForceTransport::Advected => (moving > 0).then_some(Transport::Always),
        ForceTransport::Auto
            if can && geometry(scene) == Geometry::Space && (moving > 1 || moving > 0 && is_full(scene)) =>
        {
            Some(Transport::WhereItLags)
        }
        _ => None,
    }
}

/// Whether viscosity may be told of a change of the advected force in its own step.
pub fn tells_viscosity(choices: &Choices) -> bool {
    choices.viscous_sweeps != Some(0)
}

/// Longest step that every free grain bears with the local solve, s.
pub fn longest_local_step(scene: &CheckedScene, medium: &Medium) -> f64 {
    let free = scene.grains.iter().filter(|grain| grain.motion == bedload_scene::Motion::Free);
    let longest = |grain: &bedload_scene::Grain| {
        let diameter = 2.0 * grain.radius;
        largest_viscous_number(grain.density / medium.density) * diameter * diameter
            / medium.kinematic_viscosity()
    };
    free.map(longest).fold(f64::INFINITY, f64::min)
}

/// Solid fraction from which on one moving sphere is a bed with its images.
const FULL: f64 = 0.05;

fn is_full(scene: &CheckedScene) -> bool {
    let domain = &scene.scene.domain;
    let size: f64 = domain.lower.iter().zip(&domain.upper).map(|(lower, upper)| upper - lower).product();
    scene.grains.iter().map(bedload_scene::Grain::volume).sum::<f64>() > FULL * size
}

/// When the carried force goes with the grains.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Transport {
    /// In every step.
    Always,
    /// In steps in which it would lag.
    WhereItLags,
}

/// Whether masks have the radius that the flow feels.
pub fn corrects_radius(scene: &CheckedScene, choices: &Choices) -> bool {
    match choices.mask_radius {
        MaskRadius::Nominal => false,
        MaskRadius::Corrected => true,
        MaskRadius::Auto => {
            choices.method == Forcing::Carried
                && choices.mask == Mask::ParameterFree
                && geometry(scene) == Geometry::Space
        }
    }
}

/// Whether it is worth keeping what the grains hold of the grid until they move: it is asked for again at the
/// same place where the force goes with the grains, and where none ever moves.
pub fn keeps(scene: &CheckedScene, choices: &Choices, transport: Option<Transport>) -> bool {
    if choices.method == Forcing::FictitiousDomain {
        return false;
    }
    transport.is_some() || stands(scene)
}

/// Sets the velocity at t = 0.
pub fn set_initial<const D: usize>(scene: &CheckedScene, grid: &Grid<D>, state: &mut State<D>) {
    let Some(medium) = &scene.scene.medium else { return };
    let axes = scene.scene.domain.geometry.axes();
    match medium.initial {
        // A run gives it as a whole: see `crate::initial`.
        InitialVelocity::Rest | InitialVelocity::Run { .. } => {}
        InitialVelocity::Uniform { velocity } => {
            for d in 0..D {
                let value = velocity[laboratory(grid.geometry, d)];
                set_component(grid, d, &mut state.velocity[d], |_| value);
            }
        }
        InitialVelocity::Shear { direction, gradient, rate, origin } => {
            let place = |axis| axes.iter().position(|a| *a == axis);
            if let (Some(d), Some(g)) = (place(direction), place(gradient)) {
                set_component(grid, d, &mut state.velocity[d], |x| rate * (x[g] - origin));
            }
        }
        InitialVelocity::TaylorGreen { amplitude } => {
            // In space (x, z) too; the wave fills the box along both.
            let last = D - 1;
            let k = |a: usize| std::f64::consts::TAU / grid.axes[a].length();
            let (kx, kz) = (k(0), k(last));
            set_component(grid, 0, &mut state.velocity[0], |x| {
                amplitude * (kx * x[0]).sin() * (kz * x[last]).cos()
            });
            set_component(grid, last, &mut state.velocity[last], |x| {
                -amplitude * kx / kz * (kx * x[0]).cos() * (kz * x[last]).sin()
            });
        }
    }
}
