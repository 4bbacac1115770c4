//! The first state of a run from the last one of another, with the springs between grains.

use std::path::Path;

use crate::motion::{Motion, Vec3};
use crate::solver::Dem;
use crate::state::State;
use bedload_scene::table::{Table, number};
use bedload_scene::{CheckedScene, SceneError};
use protocol::checkpoint;
use protocol::checkpoints;
use protocol::facts::DemFacts;

/// Brings `dem` to the state in the output folder `folder`, at time zero. Contacts with walls start anew: the
/// other scene's walls may be others. With a fluid the scene must have the grains where that run left them,
/// since the fluid starts with them there; the state then adds the springs between them.
pub(crate) fn load(dem: &mut Dem, folder: &Path, scene: &CheckedScene) -> Result<(), SceneError> {
    let refuse = |why: String, remedy: &str| Err(scene.source.error("dem.initial_state", why, remedy));
    let read = checkpoint::read_any::<State>(&checkpoints::newest_of_run(folder), "dem");
    let mut state = match read {
        Ok((_, state)) => state,
        Err(error) => {
            return refuse(
                error.to_string(),
                "name the output folder of a finished run; paths count from the scene's folder",
            );
        }
    };
    let expected = dem.grains.len();
    let table = table(folder);
    if state.position.len() != expected
        && let Some(kept) = table.as_ref().map(ids).filter(|kept| kept.len() == expected)
    {
        state = state.of_grains(&kept);
    }
    if state.position.len() != expected {
        return refuse(
            format!("holds {} grains, this scene {expected}", state.position.len()),
            "start from a run of the same grains, or use [[grain_files]] with its grains.csv",
        );
    }
    if let Some(fault) = table.and_then(|table| unpaired(scene, &table)) {
        return refuse(fault, "keep the rows of that run's grains.csv in the order of their ids");
    }
    if scene.scene.medium.is_some()
        && let Some(fault) = other_start(dem, &state)
    {
        return refuse(fault, "take the grains from that run: [[grain_files]] with its grains.csv");
    }
    hold(dem, &mut state);
    (state.time, state.substeps, state.windows, state.dissipated) = (0.0, 0, 0, Default::default());
    state.rolling.truncate(state.contacts.len());
    let mut at_walls = vec![false; expected];
    let touching = state.wall_contacts.iter().map(|contact| contact.first);
    touching
        .chain(state.body_wall_contacts.iter().map(|point| point.first))
        .for_each(|i| at_walls[i as usize] = true);
    state.wall_contacts.clear();
    state.servos.clear();
    state.body_wall_contacts.clear();
    if let Err(fault) = dem.restore(&state) {
        return refuse(fault.to_string(), "start from a run with the same grains and contact law");
    }
    if let Some(fault) = misplaced(dem, scene, &at_walls) {
        return refuse(fault, "let the other run settle, or make this box and its walls fit");
    }
    Ok(())
}

/// Gives grains of which this scene says how they move that motion, and keeps what it holds at rest.
fn hold(dem: &Dem, state: &mut State) {
    let g = &dem.grains;
    let free = |v: [f64; 3], along: Vec3| Vec3::from(v).component_mul(&along);
    for i in 0..g.len() {
        let (along, about) = (g.translation[i], g.rotation[i]);
        let (velocity, spin) = match &g.motion[i] {
            Motion::Free => (free(state.velocity[i], along), free(state.spin[i], about)),
            led => led.velocity_at(0.0),
        };
        (state.velocity[i], state.spin[i]) = (velocity.into(), spin.into());
        state.acceleration[i] = free(state.acceleration[i], along).into();
        state.spin_acceleration[i] = free(state.spin_acceleration[i], about).into();
    }
}

/// The grains that the run left in the box; none where it was killed.
fn table(folder: &Path) -> Option<Table> {
    Table::parse(&protocol::input_file::read_text(&folder.join("grains.csv")).ok()?).ok()
}

/// Their numbers in that run, ascending; empty where the table has other rows.
fn ids(table: &Table) -> Vec<usize> {
    let Some(id) = table.find("id") else { return Vec::new() };
    let ids: Option<Vec<usize>> = table.rows.iter().map(|row| Some(number(row, id)? as usize)).collect();
    ids.filter(|ids| ids.is_sorted()).unwrap_or_default()
}

/// A grain that is another one in the state: with another radius or density, by the table that the run left.
fn unpaired(scene: &CheckedScene, table: &Table) -> Option<String> {
    let own = &scene.grains;
    let (kept, of_all) = (ids(table), table.rows.len() == own.len());
    let (id, radius, density) = (table.find("id")?, table.find("radius")?, table.find("density")?);
    let differs = |a: f64, b: f64| (a - b).abs() > 1e-9 * b.abs();
    let (i, r, d) = table.rows.iter().find_map(|row| {
        // Where grains had left the box, those that stayed are numbered anew.
        let i = number(row, id).map(|id| id as usize)?;
        let i = if of_all { kept.binary_search(&i).unwrap_or(i) } else { i };
        let i = Some(i).filter(|i| *i < own.len())?;
        let (r, d) = (number(row, radius)?, number(row, density)?);
        (differs(own[i].radius, r) || differs(own[i].density, d)).then_some((i, r, d))
    })?;
    Some(format!(
        "has grain {i} of radius {r} m and density {d} kg/m³; grain {i} of this scene has {} m and {} kg/m³",
        own[i].radius, own[i].density
    ))
}

/// A grain that the scene, by which the fluid starts, has at another place than the state, or a free one that
/// it lets move or lie in another way.
fn other_start(dem: &Dem, state: &State) -> Option<String> {
    let g = &dem.grains;
    if let Some(i) = (0..g.len()).find(|&i| Vec3::from(state.position[i]) != g.position[i]) {
        return Some(format!(
            "has grain {i} at another place than this scene, where the fluid starts with it"
        ));
    }
    let free = || (0..g.len()).filter(|i| g.motion[*i] == Motion::Free);
    for (what, unit, here, there) in
        [("velocity", "m/s", &g.velocity, &state.velocity), ("spin", "rad/s", &g.spin, &state.spin)]
    {
        if let Some(i) = free().find(|i| here[*i] != Vec3::from(there[*i])) {
            let here = <[f64; 3]>::from(here[i]);
            return Some(format!(
                "has grain {i} with {what} {:?} {unit}, this scene, by which the fluid starts, with {here:?}",
                there[i]
            ));
        }
    }
    let turned = |i: &usize| {
        let q = g.orientation[*i];
        let along: f64 = [q.w, q.i, q.j, q.k].iter().zip(&state.orientation[*i]).map(|(a, b)| a * b).sum();
        !g.is_round(*i) && along.abs() < 1.0 - 1e-12
    };
    free()
        .find(turned)
        .map(|i| format!("has body {i} turned otherwise than this scene, by which the fluid starts"))
}

/// A grain outside the box, or in a wall, or two in each other. Those `at_walls` touched one in the other
/// run, and may be as deep in it as contacts are soft.
fn misplaced(dem: &Dem, scene: &CheckedScene, at_walls: &[bool]) -> Option<String> {
    let mut places = dem.grains.position.iter().map(|x| <[f64; 3]>::from(*x)).enumerate();
    if let Some((i, x)) = places.find(|(_, x)| !scene.scene.domain.holds(x)) {
        return Some(format!("puts grain {i} at {x:?}, outside the box"));
    }
    // The scene has judged the overlaps of a coupled run; a dry one goes on with any.
    let most = |i: usize| dem.grains.half_width[i] * if at_walls[i] { 1.0 } else { DemFacts::MOST_OVERLAP };
    let mut at_walls = dem.overlaps_with_walls().filter(|_| scene.scene.medium.is_none());
    if let Some((i, overlap)) = at_walls.find(|(i, overlap)| *overlap > most(*i)) {
        let (x, most) = (<[f64; 3]>::from(dem.grains.position[i]), most(i));
        return Some(format!("puts grain {i} at {x:?}, {overlap} m into a wall; allowed: {most} m"));
    }
    let (i, j, overlap) = dem.overlapping(1.0)?;
    Some(format!("lets grains {i} and {j} overlap by {overlap} m; allowed: the smaller radius (half width)"))
}
