//! Save, restore, repeat gives identical bits; results do not depend on the neighbour list.
use crate::common::{cloud, dem, floor, law, repeats, spec};
use dem_solver::lubrication::settings::LubricationSettings;
use dem_solver::{DemSpec, GrainLoad, Integrator, Lubrication, RestoreError, Vec3, Wall};

fn busy(integrator: Integrator, n: usize) -> DemSpec {
    let mut law = law(0.7, 0.02);
    law.friction = 0.4;
    let mut set_up = spec(cloud(n, 11), law);
    let side = 4.4;
    set_up.walls = vec![
        floor(),
        Wall { velocity: [0.1, 0.0, -0.05].into(), ..Wall::new([0.0, 0.0, side + 0.5], [0.0, 0.0, -1.0]) },
    ];
    set_up.periods = [Some((0.0, side)), Some((-0.3, side)), None];
    set_up.gravity = [0.0, 0.0, -5.0].into();
    set_up.integrator = integrator;
    if integrator != Integrator::Rk3 {
        set_up.viscosity = 0.01;
        set_up.lubrication =
            Lubrication::AsPrinted(LubricationSettings { cut_off: 0.2, ..LubricationSettings::new(1e-3) });
    }
    set_up
}

fn loads(n: usize) -> Vec<GrainLoad> {
    (0..n)
        .map(|i| GrainLoad {
            force: Vec3::new(0.01 * i as f64, 0.0, 0.1),
            torque: Vec3::y() * 1e-3,
            added_mass: 0.2,
            added_inertia: 0.01,
        })
        .collect()
}

#[test]
fn restored_runs_repeat_bit_for_bit() {
    for integrator in [Integrator::SymplecticEuler, Integrator::VelocityVerlet, Integrator::Rk3] {
        let set_up = busy(integrator, 60);
        let loads = loads(60);
        let mut solver = dem(&set_up);
        for _ in 0..400 {
            solver.advance(2e-3, 5, &loads).expect("advances");
        }
        let what = format!("{integrator:?}");
        let saved =
            repeats(&what, &set_up, &mut solver, |solver| solver.advance(2e-3, 5, &loads).expect("advances"));
        assert!(saved.contacts.len() > 5, "{what}: {} contacts", saved.contacts.len());
    }
}

/// Skin, and so the moments of building the list, change the cost and no bit of the result.
#[test]
fn the_skin_changes_no_bit() {
    let run = |skin: f64| {
        let mut set_up = busy(Integrator::SymplecticEuler, 60);
        set_up.skin = Some(skin);
        let mut solver = dem(&set_up);
        for _ in 0..300 {
            solver.advance(2e-3, 5, &loads(60)).expect("advances");
        }
        (solver.save(), solver.list_builds())
    };
    let (a, many) = run(0.01);
    let (b, few) = run(0.5);
    assert!(many > 2 * few, "{many} and {few} builds");
    assert!(a == b, "the skin changed the result");
}

#[test]
fn a_state_of_another_scene_is_refused() {
    let mut solver = dem(&busy(Integrator::SymplecticEuler, 30));
    let before = solver.save();
    let other = dem(&busy(Integrator::SymplecticEuler, 29)).save();
    assert!(matches!(solver.restore(&other), Err(RestoreError::Length { needed: 30, found: 29, .. })));
    let mut broken = before.clone();
    broken.velocity[3][1] = f64::NAN;
    assert_eq!(solver.restore(&broken), Err(RestoreError::NotFinite { quantity: "velocity", grain: 3 }));
    let mut broken = before.clone();
    broken.contacts.push(dem_solver::state::SavedContact { first: 5, second: 77, spring: [0.0; 3] });
    assert!(matches!(solver.restore(&broken), Err(RestoreError::Contact { .. })));
    assert_eq!(solver.save(), before);
}
