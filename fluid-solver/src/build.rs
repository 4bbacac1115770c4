//! From a checked scene to a grid, the stepper's options and the grains' shapes.

use crate::axis::AxisSpec;
use crate::boundary::{Boundary, Profile};
use crate::config::{Choices, SchemeKey};
use crate::coupling;
use crate::division::{Division, DivisionError};
use crate::drive::Drive;
use crate::field::{State, set_component};
use crate::grid::{Geometry, Grid, GridSpec};
use crate::immersed::body::{along_axes, laboratory};
use crate::methods::needs::Needs;
use crate::ranks::Ranks;
use crate::scene_grains::geometry;
use crate::scheme::{Options, Scheme, Viscous};
use bedload_scene::{
    CheckedScene, Face, InflowProfile, InitialVelocity, Medium, OverTime, SceneError, WallKind,
};

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
    let boundaries = boundaries(scene, 0.0);
    Grid::new(&GridSpec { geometry, axes, boundaries }).map_err(|error| {
        scene.source.error(
            if domain.stretching.is_some() { "domain.stretching" } else { "domain" },
            error.to_string(),
            "change the grid as the message says",
        )
    })
}

/// The faces of a scene as they are at `time`, s.
pub(crate) fn boundaries<const D: usize>(scene: &CheckedScene, time: f64) -> [[Boundary<D>; 2]; D] {
    let (domain, geometry) = (&scene.scene.domain, geometry(scene));
    std::array::from_fn(|a| {
        let faces = domain.boundary(a).expect("the scene's faces were checked");
        let lower = faces.lower.as_ref().map_or(Boundary::Axis, |face| boundary(geometry, face, time));
        [lower, boundary(geometry, &faces.upper, time)]
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
    if !several && !choices.blocks {
        return Ok(grid);
    }
    let grid = grid.divided(ranks.clone()).map_err(|error| {
        let key = match error {
            DivisionError::Open => "domain.boundary",
            DivisionError::Axes => "domain.geometry",
            DivisionError::Planes(_) | DivisionError::Ranks { .. } => "domain.cells",
        };
        let remedy = "start as many ranks as are possible, or one process without fluid.launcher";
        scene.source.error(key, error.to_string(), remedy)
    })?;
    if several {
        let slabs = Division::slabs(grid.cells[D - 1], ranks.size());
        refuse_for_ranks(scene, choices, slabs.map_or(0, |[least, _]| least))?;
    }
    Ok(grid)
}

/// Planes that a rank must have for the local solve of viscosity to fetch what it needs from its neighbours.
const LOCAL: usize = 5;

/// Refuses what several ranks cannot do yet, of which the one that has fewest has `least` planes.
pub fn refuse_for_ranks(scene: &CheckedScene, choices: &Choices, least: usize) -> Result<(), SceneError> {
    let scheme = coupling::read(scene, choices.method)?.0;
    if scheme == protocol::scheme::Scheme::Iterated {
        return Err(scene.source.error(
            "coupling.scheme",
            "is \"iterated\", which several ranks of the fluid cannot do yet",
            "take \"semi-implicit\", or start one rank",
        ));
    }
    if Needs::of(scene, choices, scheme).local_solve && least < LOCAL {
        return Err(scene.source.error(
            "domain.cells",
            format!("leaves a rank with {least} planes; grains that move in space need {LOCAL} planes for each rank"),
            "start fewer ranks, or give more cells along the last axis",
        ));
    }
    Ok(())
}

fn boundary<const D: usize>(geometry: Geometry, face: &Face, time: f64) -> Boundary<D> {
    let velocity = along_axes(geometry, face.velocity.at(time));
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
    Options {
        viscosity: medium.kinematic_viscosity(),
        scheme: match choices.scheme {
            SchemeKey::Rk3 => Scheme::RungeKutta3,
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
    let gravity = if scene.scene.domain.is_periodic(axis) { scene.scene.gravity.start()[c] } else { 0.0 };
    medium.body_force.start()[c] + gravity - medium.pressure_gradient.start()[c] / medium.density
}

/// What of that, of the walls and of the inflows changes over time.
pub fn drive_over_time(scene: &CheckedScene, medium: &Medium) -> Drive {
    let domain = &scene.scene.domain;
    let faces = (0..domain.dimensions()).filter_map(|axis| Some((axis, domain.boundary(axis)?)));
    let sides = faces.flat_map(|(axis, faces)| {
        [(axis, 0, faces.lower), (axis, 1, Some(faces.upper))].into_iter().filter_map(|(axis, side, face)| {
            let face = face.filter(|face| face.velocity.varies())?;
            Some((axis, side, face.velocity))
        })
    });
    let periodic: [bool; 3] = domain.periods().map(|period| period.is_some());
    let fall = |g: &[f64; 3]| std::array::from_fn(|c| if periodic[c] { g[c] } else { 0.0 });
    let per_mass = |gradient: &[f64; 3]| gradient.map(|slope| -slope / medium.density);
    let parts =
        [medium.body_force.clone(), scene.scene.gravity.map(fall), medium.pressure_gradient.map(per_mass)];
    let constant = !parts.iter().any(OverTime::varies);
    Drive { faces: sides.collect(), force: if constant { Vec::new() } else { parts.into() } }
}

/// Sets the velocity at t = 0.
pub fn set_initial<const D: usize>(scene: &CheckedScene, grid: &Grid<D>, state: &mut State<D>) {
    let Some(medium) = &scene.scene.medium else { return };
    if matches!(medium.initial, InitialVelocity::Rest | InitialVelocity::Run { .. }) {
        // A run gives it as a whole: see `crate::initial`.
        return;
    }
    for d in 0..D {
        set_component(grid, d, &mut state.velocity[d], |x| {
            let mut at = [0.0; 3];
            (0..D).for_each(|a| at[laboratory(grid.geometry, a)] = x[a]);
            medium.initial.at(&scene.scene.domain, at)[0][laboratory(grid.geometry, d)]
        });
    }
}
