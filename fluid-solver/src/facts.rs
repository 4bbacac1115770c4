//! What the fluid says of itself before a run (`bedload-fluid check`).

use crate::build;
use crate::config::{FluidSection, SchemeKey};
use crate::plan::Plan;
use crate::scheme::Viscous;
use protocol::facts::FluidFacts;
use protocol::scene::{CheckedScene, SceneError};

/// Facts of the scene's fluid, without laying out its fields.
///
/// # Errors
/// [`SceneError`] naming the key that this solver cannot follow, or more memory than there is.
pub fn facts(scene: &CheckedScene) -> Result<FluidFacts, SceneError> {
    match scene.scene.domain.dimensions() {
        2 => of::<2>(scene),
        _ => of::<3>(scene),
    }
}

fn of<const D: usize>(scene: &CheckedScene) -> Result<FluidFacts, SceneError> {
    let section = FluidSection::read(scene)?;
    let choices = section.choices();
    let medium = scene.scene.medium.as_ref().expect("FluidSection::read demands a medium");
    let memory = memory::<D>(scene);
    check_memory(scene, memory)?;
    let grid = build::grid::<D>(scene)?;
    let plan = Plan::new(scene, medium, &choices, &grid)?;
    let implicit = plan.viscous == Viscous::Implicit;
    let cells = grid.cell_count() as u64;
    let resolved = toml::Table::try_from(section.resolved()).map_err(|error| {
        scene.source.error("fluid", format!("cannot be written out: {error}"), "report this as a fault")
    })?;
    let mut notices = Vec::new();
    let number = medium.kinematic_viscosity() * plan.first() / (plan.spacing * plan.spacing);
    if !scene.grains.is_empty() && number > 2.0 {
        notices.push(format!(
            "ν dt/Δx² = {number:.2} is above 2: in dense beds the force on the grains then settles over \
             hundreds of steps"
        ));
    }
    for (grain, g) in scene.grains.iter().enumerate() {
        if 2.0 * g.radius < 5.0 * plan.spacing {
            notices.push(format!(
                "grain {grain} is {:.1} cells across: its drag is resolved from about 8 cells on",
                2.0 * g.radius / plan.spacing
            ));
            break;
        }
    }
    Ok(FluidFacts {
        cells,
        memory,
        dt: plan.first(),
        adaptive: plan.fixed.is_none(),
        cfl: choices.time.cfl,
        cfl_limit: choices.time.scheme.cfl_limit(),
        spacing: plan.spacing,
        implicit_viscosity: implicit,
        loads: choices.form,
        virtual_mass: choices.virtual_mass,
        forcing: choices.method,
        step_cost: cells as f64 * cost::<D>(choices.time.scheme, implicit, cells),
        notices,
        resolved,
    })
}

/// Bytes of all fields: state and its saved copy, working memory, and what grains add.
fn memory<const D: usize>(scene: &CheckedScene) -> u64 {
    let points: f64 = scene.scene.domain.cells.iter().map(|n| (n + 2) as f64).product();
    let axes = D as f64;
    let fluid = 2.0 * (2.0 * axes + 1.0) + axes + 1.0;
    let grains = if scene.grains.is_empty() { 0.0 } else { 4.0 * axes };
    (8.0 * points * (fluid + grains)) as u64
}

/// Refuses what does not fit this machine, if that is known.
fn check_memory(scene: &CheckedScene, memory: u64) -> Result<(), SceneError> {
    let Some(total) = machine_memory() else { return Ok(()) };
    if memory <= total {
        return Ok(());
    }
    let gib = |bytes: u64| bytes as f64 / f64::from(1 << 30);
    Err(scene.source.error(
        "domain.cells",
        format!(
            "asks for {:?} cells, about {:.1} GiB; this machine has {:.1} GiB",
            scene.scene.domain.cells,
            gib(memory),
            gib(total)
        ),
        "coarsen the grid, shrink the box, or use a plane or axisymmetric geometry",
    ))
}

/// Memory of the machine, bytes, where the system tells it.
fn machine_memory() -> Option<u64> {
    let text = std::fs::read_to_string("/proc/meminfo").ok()?;
    let line = text.lines().find_map(|line| line.strip_prefix("MemTotal:"))?;
    let kib: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(kib * 1024)
}

/// Nanoseconds per cell and stage (one projection each) on two axes at 1e4, 1e5 and 1e6 cells:
/// implicit and explicit viscosity, the mean of r–z and the plane (20 % apart at 1e6). One core, measured (`docs/performance.md`).
const PLANE: [[f64; 3]; 2] = [[25.0, 36.0, 55.0], [15.0, 18.0, 30.0]];

/// The same in space, measured at 64³ cells only.
const SPACE: [f64; 2] = [110.0, 58.0];

/// Seconds per cell and step on one core of the machine of `docs/performance.md`: the caches make
/// it depend on the number of cells.
fn cost<const D: usize>(scheme: SchemeKey, implicit: bool, cells: u64) -> f64 {
    let kind = usize::from(!implicit);
    let stage = if D == 2 {
        let decades = ((cells as f64).log10() - 4.0).clamp(0.0, 2.0);
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
    1e-9 * stage * stages
}
