//! The general engine on vectors: contacts have the bits of the scalar loop, films those of any vector width.
use crate::common::{cloud, contacts, dem, floor, law, repeats, spec};
use dem_solver::lubrication::settings::LubricationSettings;
use dem_solver::{
    BulkSettings, Dem, DemSpec, Dissipated, Engine, Freedom, Integrator, Lubrication, Motion, State, Wall,
};

/// Grains that fall and shear between walls, some fixed and some driven.
fn busy(n: usize) -> DemSpec {
    let mut rough = law(0.6, 0.03);
    rough.friction = 0.4;
    let mut grains = cloud(n, 5);
    for (k, grain) in grains.iter_mut().enumerate() {
        if k % 37 == 0 {
            grain.motion = Motion::Fixed;
        } else if k % 41 == 0 {
            grain.motion =
                Motion::Prescribed { velocity: [0.2, 0.0, 0.05].into(), spin: [0.0, 1.0, 0.0].into() };
        }
    }
    let mut set_up = spec(grains, rough);
    set_up.walls = vec![
        floor(),
        Wall { velocity: [0.3, 0.0, -0.4].into(), ..Wall::new([0.0, 0.0, 8.0], [0.0, 0.0, -1.0]) },
    ];
    set_up.periods = [None, Some((-0.3, 7.9)), None];
    set_up.gravity = [1.0, 0.0, -9.0].into();
    set_up.engine = Engine::General;
    set_up
}

/// The same with films of spheres that approach and slide.
fn immersed(n: usize) -> DemSpec {
    let mut set_up = busy(n);
    let mut settings = LubricationSettings::new(1e-3);
    settings.resolved_length = Some(0.1);
    settings.tangential = Some(true);
    set_up.lubrication = Lubrication::Complement(settings);
    set_up.viscosity = 0.05;
    set_up
}

/// Both in the same bits after every window.
fn alike(what: &str, a: &DemSpec, b: &DemSpec) {
    let (mut one, mut other) = (dem(a), dem(b));
    let mut met = 0;
    for window in 0..20 {
        let report = one.advance(2e-3, 10, &[]).expect("advances");
        assert_eq!(report, other.advance(2e-3, 10, &[]).expect("advances"), "{what}, window {window}");
        // an account of energy is no part of the motion
        let state = |solver: &Dem| State { dissipated: Dissipated::default(), ..solver.save() };
        assert!(state(&one) == state(&other), "{what}: window {window} ends in other bits");
        assert!(one.observations() == other.observations(), "{what}: window {window} saw other things");
        met += contacts(&one);
    }
    assert!(met > 150, "{what}: {met} contacts");
}

#[test]
fn lanes_have_the_bits_of_the_scalar_loop() {
    for integrator in [Integrator::SymplecticEuler, Integrator::VelocityVerlet] {
        let lanes = DemSpec { integrator, ..busy(300) };
        // an account of energy takes the scalar loop
        let scalar = DemSpec { energy: true, ..lanes.clone() };
        alike(&format!("{integrator:?}"), &lanes, &scalar);
    }
}

fn plain(set_up: &DemSpec) -> DemSpec {
    DemSpec { bulk: BulkSettings { plain: true, ..set_up.bulk }, ..set_up.clone() }
}

#[test]
fn the_vector_width_changes_no_bit() {
    let mut verlet = immersed(300);
    verlet.integrator = Integrator::VelocityVerlet;
    let mut locked = immersed(300);
    for (k, grain) in locked.grains.iter_mut().enumerate() {
        if k % 4 == 0 {
            grain.free = Freedom::PLANE;
        }
    }
    for (what, set_up) in
        [("Euler", immersed(300)), ("Verlet", verlet), ("locks", locked), ("dry", busy(300))]
    {
        alike(what, &set_up, &plain(&set_up));
    }
}

/// Neither the skin nor a restart changes a bit: packs follow from what acts, not from the lists.
#[test]
fn films_do_not_know_when_lists_were_built() {
    let set_up = immersed(200);
    alike("skin", &set_up, &DemSpec { skin: Some(0.02), ..set_up.clone() });
    let mut solver = dem(&set_up);
    let advance = |solver: &mut Dem| solver.advance(2e-3, 10, &[]).expect("advances");
    for _ in 0..5 {
        advance(&mut solver);
    }
    repeats("immersed", &set_up, &mut solver, advance);
}

/// More sweeps than any bed needs end in one solution, from which the usual number is not far; films keep
/// momentum.
#[test]
fn films_converge_and_keep_momentum() {
    let free = |sweeps: u32| {
        let mut set_up = immersed(200);
        set_up.walls.clear();
        set_up.gravity = [0.0; 3].into();
        set_up.grains.iter_mut().for_each(|grain| grain.motion = Motion::Free);
        if let Lubrication::Complement(settings) = &mut set_up.lubrication {
            (settings.sweeps, settings.tangential) = (sweeps, Some(false));
        }
        set_up
    };
    let (mut usual, mut many) = (dem(&free(8)), dem(&free(400)));
    let momentum = |solver: &Dem| {
        (0..200).map(|i| solver.grains.velocity[i] * solver.grains.mass[i]).sum::<dem_solver::Vec3>()
    };
    let before = momentum(&usual);
    usual.advance(2e-3, 10, &[]).expect("advances");
    many.advance(2e-3, 10, &[]).expect("advances");
    assert!((momentum(&usual) - before).norm() < 1e-12, "{}", momentum(&usual) - before);
    let apart = |i: usize| (usual.grains.velocity[i] - many.grains.velocity[i]).norm();
    let worst = (0..200).map(apart).fold(0.0, f64::max);
    println!("{worst:e} m/s apart");
    assert!(worst < 1e-6, "{worst:e} m/s apart");
}
