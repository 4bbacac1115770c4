//! What a scene is measured by on each of its grids.

use bedload_scene::speeds::drive;
use bedload_scene::{CheckedScene, InitialVelocity, MetricKind, Motion, SUPERFICIAL};

use crate::number::AXES;

/// Most grains that are measured one by one.
const ONE_BY_ONE: usize = 2;

/// Largest |ρ_p/ρ − 1| of a grain that goes with the fluid.
const NEUTRAL: f64 = 0.01;

/// Most held grains whose force is measured: those that have columns by default.
const HELD: usize = 16;

/// `metrics=…` for a scene that names none; none where what its solvers measure by themselves is all there
/// is.
///
/// Free grains that gravity moves: the largest speed before a contact and, of what comes back from a wall,
/// how high. More of them, or moved by the flow: their kinetic energy, the mean over the second half. Held
/// ones: the last force along the flow.
pub(super) fn metrics(scene: &CheckedScene) -> Option<String> {
    if !scene.scene.metrics.is_empty() {
        return None;
    }
    let of = |motion: fn(&Motion) -> bool| {
        let grains = scene.grains.iter().enumerate();
        grains.filter(move |(_, grain)| motion(&grain.motion)).map(|(place, _)| place)
    };
    let free: Vec<usize> = of(|motion| *motion == Motion::Free).collect();
    // What is as heavy as the fluid hardly settles: its speed would be compared with nothing.
    let density = scene.scene.medium.as_ref().map_or(0.0, |medium| medium.density);
    let settles = |place: &usize| (scene.grains[*place].density / density - 1.0).abs() > NEUTRAL;
    let mut list = Vec::new();
    if free.is_empty() {
        let axis = AXES[direction(scene)?];
        let force = |place| {
            format!("{{name=\"force-{place}\",kind=\"final\",column=\"hydrodynamic_force_{axis}[{place}]\"}}")
        };
        list.extend(of(|motion| *motion != Motion::Free).filter(|place| *place < HELD).map(force));
    } else if free.len() <= ONE_BY_ONE && !scene.scene.gravity.is_zero() && free.iter().all(settles) {
        for place in free {
            list.push(format!("{{name=\"speed-{place}\",kind=\"reynolds\",grain={place}}}"));
            if !scene.contact_walls().is_empty() {
                list.push(format!("{{name=\"rebound-{place}\",kind=\"rebound-height\",grain={place}}}"));
            }
        }
    } else {
        let from = 0.5 * scene.scene.until;
        list.push(format!("{{name=\"energy\",kind=\"mean\",column=\"kinetic_energy\",from={from:?}}}"));
    }
    (!list.is_empty()).then(|| format!("metrics=[{}]", list.join(",")))
}

/// Names of what is compared from grid to grid: the scene's metrics but for those that are differences from a
/// published table, of which no relative error can be asked; where no grain is free also the superficial
/// velocity, if the scene names no metric.
pub(super) fn names(scene: &CheckedScene, named: bool) -> Vec<String> {
    let is_difference = |kind: &MetricKind| {
        matches!(
            kind,
            MetricKind::SeriesDifference { .. }
                | MetricKind::VelocityDifference { .. }
                | MetricKind::ObliqueError { .. }
                | MetricKind::DepositProfileDifference(_)
                | MetricKind::HaffMisfit(_)
        )
    };
    let metrics = scene.scene.metrics.iter().filter(|metric| !is_difference(&metric.kind));
    let alone = !named && !scene.has_free_grains();
    // Over planes across an axis that is not periodic there is none.
    let periods = scene.scene.domain.periods();
    let flow = direction(scene)
        .filter(|axis| alone && periods[*axis].is_some())
        .map(|axis| format!("{SUPERFICIAL}{}", AXES[axis]));
    metrics.map(|metric| metric.name.clone()).chain(flow).collect()
}

/// Component along which the scene moves its fluid the most: by a flow rate that is held, a drive, faces and
/// grains that move, or a flow at the start, the first that it has; none where nothing does.
fn direction(scene: &CheckedScene) -> Option<usize> {
    let medium = scene.scene.medium.as_ref()?;
    let (domain, until) = (&scene.scene.domain, scene.scene.until);
    let mut held = [0.0; 3];
    if let Some(flow) = &medium.flow_rate {
        held[flow.axis.component()] = flow.mean_velocity.peak(until);
    }
    let start = match medium.initial {
        InitialVelocity::Uniform { velocity } => velocity,
        _ => [0.0; 3],
    };
    let boundaries = (0..domain.dimensions()).filter_map(|axis| domain.boundary(axis));
    let faces = boundaries
        .flat_map(|both| [both.lower, Some(both.upper)])
        .flatten()
        .map(|face| face.velocity.peak(until));
    let grains = scene
        .grains
        .iter()
        .filter(|grain| grain.motion != Motion::Free)
        .map(|grain| grain.velocity.peak(until));
    let all = [held, drive(&scene.scene)].into_iter().chain(faces).chain(grains).chain([start]);
    let moves = all.into_iter().find(|of| *of != [0.0; 3])?;
    (0..3).max_by(|a, b| moves[*a].abs().total_cmp(&moves[*b].abs()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_scenes;

    fn scene(gravity: f64, more: &str) -> CheckedScene {
        test_scenes::scene(format!(
            "until = 2.0\ngravity = [0.0, 0.0, {gravity:?}]\n[domain]\ngeometry = \"space\"\n\
             lower = [0.0, 0.0, 0.0]\nupper = [4.0, 4.0, 4.0]\ncells = [24, 24, 24]\n\
             boundary = {{ x = \"periodic\", y = \"periodic\", z = \"no-slip\" }}\n\
             [medium]\ndensity = 1.0\nviscosity = 1.0\n{more}"
        ))
    }

    fn grains(count: usize, more: &str) -> String {
        let grain = |k: usize| {
            format!("[[grains]]\nposition = [1.0, 1.0, {}.0]\nradius = 0.4\ndensity = 2.0\n{more}", k + 1)
        };
        (0..count).map(grain).collect()
    }

    /// What is as heavy as the fluid goes with it; a lid drives no flow through a section.
    #[test]
    fn a_neutral_grain_has_its_energy_compared_and_a_cavity_nothing() {
        let neutral = grains(1, "").replace("density = 2.0", "density = 1.001");
        assert_eq!(measured(-1.0, &neutral), ["energy"]);
        let cavity = |x: &str| {
            let lid = "z_upper = { type = \"no-slip\", velocity = [1.0, 0.0, 0.0] }";
            test_scenes::scene(format!(
                "until = 2.0\n[domain]\ngeometry = \"plane\"\nlower = [0.0, 0.0]\nupper = [1.0, 1.0]\n\
                 cells = [16, 16]\nboundary = {{ x = \"{x}\", z_lower = \"no-slip\", {lid} }}\n[medium]\n\
                 density = 1.0\nviscosity = 1.0\n"
            ))
        };
        assert_eq!(names(&cavity("no-slip"), false), Vec::<String>::new());
        assert_eq!(names(&cavity("periodic"), false), ["superficial_velocity_x"]);
    }

    /// What is compared, with the metrics that are added.
    fn measured(gravity: f64, more: &str) -> Vec<String> {
        let plain = scene(gravity, more);
        let added: Vec<String> = metrics(&plain).into_iter().collect();
        let with = CheckedScene::new(plain.source.clone().with_overrides(&added).unwrap()).unwrap();
        names(&with, !plain.scene.metrics.is_empty())
    }

    #[test]
    fn each_kind_of_scene_is_measured_by_what_it_is_about() {
        assert_eq!(measured(-9.81, &grains(2, "")), ["speed-0", "rebound-0", "speed-1", "rebound-1"]);
        assert_eq!(measured(-9.81, &grains(3, "")), ["energy"]);
        assert_eq!(measured(0.0, &grains(1, "")), ["energy"]);
        let driven = "body_force = [1.0, 2.0, 0.0]\n";
        let held = format!("{driven}{}", grains(2, "motion = \"fixed\"\n"));
        assert_eq!(measured(0.0, &held), ["force-0", "force-1", "superficial_velocity_y"]);
        assert_eq!(measured(0.0, driven), ["superficial_velocity_y"]);
        let towed = grains(1, "motion = \"prescribed\"\nvelocity = [1.0, 0.0, 0.0]\n");
        assert_eq!(measured(0.0, &towed), ["force-0", "superficial_velocity_x"]);
        assert!(measured(0.0, "").is_empty());
        let named = "[[metrics]]\nname = \"own\"\nkind = \"final\"\ncolumn = \"hydrodynamic_force_x[0]\"\n";
        assert_eq!(measured(0.0, &format!("{held}{named}")), ["own"]);
    }
}
