//! What the fluid says of itself before a run (`bedload-fluid check`).

use crate::config::{FluidSection, SchemeKey};
use crate::division::Division;
use crate::grid::Grid;
use crate::helmholtz;
use crate::initial;
use crate::launcher::{self, Launch};
use crate::memory::{self, Demand, Share};
use crate::methods::calibrated::calibration::Calibration;
use crate::methods::fictitious::body_points;
use crate::methods::method::Method;
use crate::methods::needs::Needs;
use crate::plan::Plan;
use crate::ranks::Ranks;
use crate::scheme::Viscous;
use crate::transform;
use crate::{bounds, build};
use bedload_scene::{CheckedScene, Grain, SceneError};
use protocol::facts::FluidFacts;
use protocol::scheme::Scheme;
use std::f64::consts::PI;

/// Facts of the scene's fluid, without laying out its fields: as its launcher would start it, if it has one.
///
/// # Errors
/// [`SceneError`] naming the key that this solver cannot follow, or more memory than there is.
pub fn facts(scene: &CheckedScene) -> Result<FluidFacts, SceneError> {
    let ranks = Ranks::of_process();
    of_ranks(scene, Some(&ranks).filter(|ranks| !ranks.is_alone()))
}

/// The same for `ranks` that have been started; without, for those that the scene's launcher would start.
pub fn of_ranks(scene: &CheckedScene, ranks: Option<&Ranks>) -> Result<FluidFacts, SceneError> {
    match scene.scene.domain.dimensions() {
        2 => of::<2>(scene, ranks),
        _ => of::<3>(scene, ranks),
    }
}

/// Whose memory is asked for, and a notice where the launcher does not tell.
fn share<const D: usize>(
    scene: &CheckedScene,
    section: &FluidSection,
    ranks: Option<&Ranks>,
    grid: &Grid<D>,
) -> Result<(Share, Option<String>), SceneError> {
    let launch = match (ranks, &section.launcher) {
        (Some(ranks), _) => {
            let size = ranks.size();
            Launch { ranks: size, on_each: launcher::on_this_machine().unwrap_or(size) }
        }
        (None, None) => return Ok((Share::WHOLE, None)),
        (None, Some(words)) => match launcher::read(words) {
            Some(launch) => launch,
            None => {
                let notice = "fluid.launcher does not say how many ranks it starts (-np N): the memory is that of one \
                              process, which has the whole grid";
                return Ok((Share::WHOLE, Some(notice.into())));
            }
        },
    };
    if launch.ranks < 2 {
        return Ok((Share::WHOLE, None));
    }
    let [least, most] = Division::slabs(grid.cells[D - 1], launch.ranks).map_err(|error| {
        scene.source.error("fluid.launcher", error.to_string(), "start as many ranks as are possible")
    })?;
    build::refuse_for_ranks(scene, &section.choices(Calibration::default()), least)?;
    let notice = (launch.on_each < launch.ranks).then(|| {
        let Launch { ranks, on_each } = launch;
        format!("the memory is that of {on_each} of {ranks} ranks, as many as are on one machine")
    });
    let edges = helmholtz::most_edges(grid.cells[D - 1], launch.ranks);
    Ok((Share { ranks: launch.on_each, planes: most, edges }, notice))
}

/// Bytes that are kept of what the grains hold of the grid: the mask ratio of all cells of each component.
fn kept_bytes<const D: usize>(scene: &CheckedScene, spacing: f64) -> u64 {
    let cells = |grain: &Grain| {
        // measured at ten cells across: the surface is felt two cells beyond it, and whole vectors of eight
        // are six more
        let across = 2.0 * grain.radius / spacing + 4.4;
        let (rows, row) = if D == 2 { (across, PI / 4.0) } else { (PI / 4.0 * across * across, 2.0 / 3.0) };
        rows * (row * across + 6.0)
    };
    (8 * D) as u64 * scene.grains.iter().map(cells).sum::<f64>() as u64
}

/// What convection near grains keeps, bytes: terms of every cell that it reaches, and planes of each thread.
fn near_bytes<const D: usize>(scene: &CheckedScene, grid: &Grid<D>, spacing: f64) -> u64 {
    let cells = cells_near::<D>(scene, spacing, 4.5) as u64;
    let (planes, threads) = if D == 3 { (27, rayon::current_num_threads()) } else { (8, 1) };
    let plane = (grid.cells[0] + 28) * (grid.cells[1] + 5);
    (8 * D + 1) as u64 * cells.min(grid.cell_count() as u64) + (8 * planes * threads * plane) as u64
}

fn of<const D: usize>(scene: &CheckedScene, ranks: Option<&Ranks>) -> Result<FluidFacts, SceneError> {
    let section = FluidSection::read(scene)?;
    let choices = section.choices(Calibration::default());
    check_for_dem(scene, choices.method)?;
    let stress = scene.scene.observe.planes.as_ref().is_some_and(|planes| planes.stress);
    if stress && choices.method != Method::Calibrated {
        return Err(scene.source.error(
            "observe.planes.stress",
            "asks for the force on the fluid in every cell, which this fluid.method does not keep".to_owned(),
            "take fluid.method = \"calibrated\", or leave the key out",
        ));
    }
    let medium = scene.scene.medium.as_ref().expect("FluidSection::read demands a medium");
    let grid = build::divided::<D>(scene, &choices, ranks.unwrap_or(&Ranks::alone()))?;
    let start = initial::read(scene, &choices, &grid)?;
    let plan = Plan::new(scene, medium, &choices, &grid, start.as_ref())?;
    let start = start.map_or(0, |start| start.bytes());
    // A table that cannot be read is told before the run, not after it.
    crate::lines::of(scene)?;
    let implicit = plan.viscous == Viscous::Implicit;
    let (scheme, iterations) = crate::coupling::read(scene, choices.method)?;
    let needs = Needs::of(scene, &choices, scheme);
    let held = if needs.points {
        body_points::bytes::<D>(scene, plan.spacing)
    } else if needs.mask_ratios {
        kept_bytes::<D>(scene, plan.spacing)
    } else {
        0
    };
    let repeated = scheme == Scheme::Iterated;
    let (share, shared) = share(scene, &section, ranks, &grid)?;
    let memory = memory::estimate(
        &grid,
        Demand {
            needs,
            implicit,
            repeated,
            held,
            near: if needs.near_convection { near_bytes(scene, &grid, plan.spacing) } else { 0 },
            start,
        },
        share,
    );
    memory::check(scene, memory, protocol::memory::available().as_ref())?;
    let cells = grid.cell_count() as u64;
    let resolved = toml::Table::try_from(&section).map_err(|error| {
        scene.source.error("fluid", format!("cannot be written out: {error}"), "report this as a fault")
    })?;
    let mut notices = slow_axes(scene, &grid);
    notices.extend(shared);
    let number = medium.kinematic_viscosity() * plan.expected / (plan.spacing * plan.spacing);
    if !scene.grains.is_empty() && number > 2.0 {
        notices.push(format!(
            "ν dt/Δx² = {number:.2} is above 2: in dense beds and where grains all but close a channel the \
             force on them then settles over hundreds of steps and more"
        ));
    }
    if let Some(grain) = scene.grains.iter().position(|grain| grain.thickness() < 5.0 * plan.spacing) {
        notices.push(format!(
            "grain {grain} is {:.1} cells across: its drag is resolved from about 8 cells on",
            scene.grains[grain].thickness() / plan.spacing
        ));
    }
    Ok(FluidFacts {
        cells,
        memory,
        dt: plan.expected,
        first_dt: plan.first,
        adaptive: plan.fixed.is_none(),
        cfl: choices.time.cfl,
        cfl_limit: choices.scheme.cfl_limit(),
        spacing: plan.spacing,
        schemes: choices.method.schemes().to_vec(),
        for_dem: for_dem(choices.method),
        foreign: false,
        values_over_time: true,
        bounds: bounds::of(scene, medium, &choices, &iterations, &plan),
        field_bytes: field_bytes(&grid),
        checkpoint_bytes: checkpoint_bytes(&grid, needs.force, scene.grains.len()),
        step_cost: cost::<D>(scene, choices.scheme, implicit, plan.spacing, cells as f64),
        notices,
        resolved,
    })
}

/// Bytes of the file of an instant: velocity, pressure, vorticity and solid fraction of each cell, and the
/// faces.
fn field_bytes<const D: usize>(grid: &Grid<D>) -> u64 {
    let faces: usize = grid.cells.iter().map(|cells| cells + 1).sum();
    (1600 + 64 * grid.cell_count() + 8 * faces) as u64
}

/// Bytes of a checkpoint: velocity, its history, pressure and the force that is carried, and what is kept of
/// grains.
fn checkpoint_bytes<const D: usize>(grid: &Grid<D>, carried: bool, grains: usize) -> u64 {
    let fields = 2 * D + 1 + if carried { D } else { 0 };
    (500 + 8 * fields * grid.len() + 360 * grains) as u64
}

/// How the method resolves films of lines, for a DEM that adds the rest of them
/// (docs/decisions/line-film.md): with masks it is the DEM's default.
fn for_dem(method: Method) -> toml::Table {
    let mut keys = toml::Table::new();
    if method == Method::FictitiousDomain {
        keys.insert("line_film".into(), "points".into());
    }
    keys
}

/// Refuses a scene that tells the DEM otherwise.
fn check_for_dem(scene: &CheckedScene, method: Method) -> Result<(), SceneError> {
    let wanted = if method == Method::FictitiousDomain { "points" } else { "mask" };
    let told = scene.scene.dem.get("line_film").and_then(toml::Value::as_str);
    scene.source.refuse_if(
        told.is_some_and(|told| told != wanted),
        "dem.line_film",
        format_args!("is {:?}, but fluid.method resolves films as {wanted:?}", told.unwrap_or_default()),
        "leave it out: the fluid's method decides it",
    )
}

/// A notice for each transformed axis whose number of cells the fast transforms cannot take.
fn slow_axes<const D: usize>(scene: &CheckedScene, grid: &Grid<D>) -> Vec<String> {
    let letter = |axis: usize| format!("{:?}", scene.scene.domain.geometry.axes()[axis]).to_lowercase();
    let notice = |axis: usize| {
        let cells = grid.cells[axis];
        let [below, above] = transform::fast_lengths(cells, grid.periodic(axis));
        let below = if below > 0 { format!("{below} or ") } else { String::new() };
        format!(
            "axis {} has {cells} cells, which only the slow transforms can take: {below}{above} would be \
             fast",
            letter(axis)
        )
    };
    let slow = |axis: &usize| !transform::is_fast(grid.cells[*axis], grid.periodic(*axis));
    transformed_axes(grid).into_iter().filter(slow).map(notice).collect()
}

/// Axes along which [`crate::helmholtz`] transforms: all but the one that it sweeps.
fn transformed_axes<const D: usize>(grid: &Grid<D>) -> Vec<usize> {
    let swept = match grid.swept_axis() {
        Some(axis) => Some(axis),
        None if D == 3 => Some(2).filter(|a| !grid.periodic(*a)),
        // Along x only where z is transformed for being the only periodic one.
        None if !grid.periodic(0) => Some(0),
        None => Some(1).filter(|a| !grid.periodic(*a)),
    };
    (0..D).filter(|a| Some(*a) != swept).collect()
}

/// Nanoseconds per cell and stage (one projection each) on two axes at 1e4, 1e5 and 1e6 cells: implicit and
/// explicit viscosity, the mean of r–z and the plane. One core, by `examples/step_cost.rs`; of explicit
/// viscosity only 1e5 cells were measured, the others go as with implicit viscosity.
const PLANE: [[f64; 3]; 2] = [[14.0, 18.0, 32.0], [10.0, 11.0, 18.0]];

/// The same in space.
const SPACE: [f64; 2] = [45.0, 17.0];

/// Nanoseconds per step and cell within three cells of a grain: 97 with 100 discs of 16 cells, 131 with 200
/// spheres of 10, 140 in a dense bed of spheres of 6 whose force goes with them, on busy cores.
const NEAR_GRAINS: f64 = 100.0;

/// Seconds per step on one core of the machine of `docs/performance.md`: the caches make it depend on the
/// number of cells.
fn cost<const D: usize>(
    scene: &CheckedScene,
    scheme: SchemeKey,
    implicit: bool,
    spacing: f64,
    cells: f64,
) -> f64 {
    let kind = usize::from(!implicit);
    let stage = if D == 2 {
        let decades = (cells.log10() - 4.0).clamp(0.0, 2.0);
        let below = (decades as usize).min(1);
        let [low, high] = [PLANE[kind][below], PLANE[kind][below + 1]];
        low + (high - low) * (decades - below as f64)
    } else {
        SPACE[kind]
    };
    let stages = match scheme {
        SchemeKey::Rk3 => 3.0,
        SchemeKey::Ab2 => 1.0,
    };
    1e-9 * (cells * stage * stages + NEAR_GRAINS * cells_near::<D>(scene, spacing, 3.0))
}

/// Cells of all grains and of a layer `wide` (cells) about each.
fn cells_near<const D: usize>(scene: &CheckedScene, spacing: f64, wide: f64) -> f64 {
    let ball = if D == 2 { PI / 4.0 } else { PI / 6.0 };
    let of = |grain: &Grain| ball * (2.0 * grain.radius / spacing + 2.0 * wide).powi(D as i32);
    scene.grains.iter().map(of).sum()
}
