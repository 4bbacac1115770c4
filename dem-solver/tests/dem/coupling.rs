//! Loads of a fluid: virtual mass, buoyancy, rest.
use crate::common::{dem, effective, floor, law, spec};
use dem_solver::{Grain, GrainLoad, Vec3};
use std::f64::consts::PI;

const R: f64 = 0.5;

fn volume() -> f64 {
    4.0 / 3.0 * PI * R.powi(3)
}

/// Buoyancy of a fluid of density 1 under gravity −1 along z, with virtual mass ½.
fn buoyancy() -> GrainLoad {
    GrainLoad { force: Vec3::new(0.0, 0.0, volume()), added_mass: 0.5 * volume(), ..GrainLoad::default() }
}

/// dU/dt = (ρ_r − 1)/(ρ_r + ½) g on the first window; with the virtual mass' own history added by
/// A_prev, (ρ_r − 1)/ρ_r g once it has settled, as a fluid that sends buoyancy alone would give.
#[test]
fn release_starts_with_the_virtual_mass() {
    for density in [0.01, 0.5, 1.02, 2.0, 8.0] {
        let mut set_up = spec(vec![Grain::new([0.0; 3], R, density)], law(0.9, 1e-3));
        set_up.gravity = [0.0, 0.0, -1.0].into();
        let mut solver = dem(&set_up);
        solver.advance(0.01, 7, &[buoyancy()]).expect("advances");
        let first = (density - 1.0) / (density + 0.5);
        let found = -solver.grains.acceleration[0].z;
        assert!((found - first).abs() < 1e-14 * (1.0 + first.abs()), "{density}: {found} instead of {first}");
        // A_{n+1} (ρ + ½) = (ρ − 1) + ½ A_n
        let mut expected = first;
        for _ in 0..30 {
            solver.advance(0.01, 3, &[buoyancy()]).expect("advances");
            expected = (density - 1.0 + 0.5 * expected) / (density + 0.5);
            let found = -solver.grains.acceleration[0].z;
            assert!(
                (found - expected).abs() < 1e-11 * (1.0 + expected.abs()),
                "{density}: {found} instead of {expected}"
            );
        }
    }
}

#[test]
fn virtual_inertia_acts_on_the_spin() {
    let mut solver = dem(&spec(vec![Grain::new([0.0; 3], R, 2.0)], law(0.9, 1e-3)));
    let inertia = solver.grains.inertia[0];
    let load =
        GrainLoad { torque: Vec3::new(0.0, 3.0, 0.0), added_inertia: 0.25 * inertia, ..GrainLoad::default() };
    solver.advance(0.1, 5, &[load]).expect("advances");
    let first = 3.0 / (1.25 * inertia);
    assert!((solver.grains.spin[0].y / 0.1 - first).abs() < 1e-12 * first);
    solver.advance(0.1, 5, &[load]).expect("advances");
    let second = (3.0 + 0.25 * inertia * first) / (1.25 * inertia);
    assert!((solver.grains.spin_acceleration[0].y - second).abs() < 1e-12 * second);
}

/// At rest the contact bears weight less the fluid's force, to round-off, and nothing creeps.
#[test]
fn resting_grain_bears_its_submerged_weight() {
    for density in [1.1, 2.0, 8.0] {
        for added in [0.0, 0.5] {
            let mut set_up = spec(vec![Grain::new([0.0, 0.0, R], R, density)], law(0.3, 0.05));
            set_up.walls.push(floor());
            set_up.gravity = [0.0, 0.0, -1.0].into();
            let mut solver = dem(&set_up);
            let load = GrainLoad { added_mass: added * volume(), ..buoyancy() };
            for _ in 0..400 {
                solver.advance(0.05, 50, &[load]).expect("advances");
            }
            let weight = (density - 1.0) * volume();
            let bears = solver.observations().mean_contact[0].z;
            assert!(
                (bears / weight - 1.0).abs() < 1e-10,
                "ρ_r {density}, C_v {added}: {}",
                bears / weight - 1.0
            );
            solver.advance(1e-3, 1, &[load]).expect("advances");
            let last = solver.observations().mean_contact[0].z;
            assert!((last / weight - 1.0).abs() < 1e-10);
            assert!(solver.grains.velocity[0].norm() < 1e-12 && solver.grains.acceleration[0].norm() < 1e-10);
        }
    }
}

/// The contact time stays t_c with a virtual mass: m* is what the contact really accelerates.
#[test]
fn virtual_mass_keeps_contact_time_and_restitution() {
    let law = law(0.7, 1e-3);
    for added in [0.0, 0.5, 5.0] {
        let mut grain = Grain::new([0.0, 0.0, R], R, 1.0);
        grain.velocity = [0.0, 0.0, -1e-3];
        let mut set_up = spec(vec![grain], law);
        set_up.walls.push(floor());
        let mut solver = dem(&set_up);
        let load = GrainLoad { added_mass: added * volume(), ..GrainLoad::default() };
        let report = solver.advance(4e-3, 40_000, &[load]).expect("advances");
        let e = solver.grains.velocity[0].z / 1e-3;
        assert!((e - effective(&law).0).abs() < 1e-3, "C_v {added}: {e}");
        // largest overlap of the damped oscillation: v/√(k/m*) exp(−(r) atan(1/r)), independent of C_v
        let pair = law.pair();
        let r = 0.5 * pair.damping / (pair.stiffness - 0.25 * pair.damping * pair.damping).sqrt();
        let deepest = 1e-3 / pair.stiffness.sqrt() * (-r * (1.0 / r).atan()).exp();
        assert!(
            (report.largest_overlap / deepest - 1.0).abs() < 1e-3,
            "C_v {added}: {}",
            report.largest_overlap / deepest
        );
    }
}

/// Mean forces are impulses: m ΔU = (weight + load + mean contact + mean film) dt over every window.
#[test]
fn mean_forces_close_the_momentum_balance() {
    use dem_solver::{Integrator, Lubrication, lubrication::settings::LubricationSettings};
    for integrator in [Integrator::SymplecticEuler, Integrator::VelocityVerlet] {
        let mut grain = Grain::new([0.0, 0.0, R + 0.05], R, 3.0);
        grain.velocity = [0.2, 0.0, -1.0];
        let mut law = law(0.8, 1e-2);
        law.friction = 0.3;
        let mut set_up = spec(vec![grain], law);
        set_up.walls.push(floor());
        set_up.gravity = [0.0, 0.0, -1.0].into();
        set_up.viscosity = 0.02;
        set_up.lubrication = Lubrication::AsPrinted(LubricationSettings::new(1e-3));
        set_up.integrator = integrator;
        let mut solver = dem(&set_up);
        let load = GrainLoad { added_mass: 0.0, ..buoyancy() };
        let (mut touched, mut lubricated) = (false, false);
        for _ in 0..40 {
            let before = solver.grains.velocity[0];
            solver.advance(5e-3, 20, &[load]).expect("advances");
            let seen = solver.observations();
            let force = Vec3::new(0.0, 0.0, -3.0 * volume())
                + load.force
                + seen.mean_contact[0]
                + seen.mean_lubrication[0];
            let gained = (solver.grains.velocity[0] - before) * solver.grains.mass[0];
            touched |= seen.mean_contact[0].z > 0.0;
            lubricated |= seen.mean_lubrication[0].z.abs() > 0.0;
            assert!((gained - force * 5e-3).norm() < 1e-12, "{integrator:?}: {gained} {force}");
        }
        assert!(touched && lubricated);
    }
}

/// Windows of one sub-step, as the coupler plans them where nothing can touch: a flight is the parabola, not
/// ½ g dt² a window below it; a grain that rests on the floor in such windows stays where it is, at rest.
#[test]
fn windows_of_one_sub_step_keep_the_parabola() {
    let mut set_up = spec(vec![Grain::new([0.0, 0.0, 9.0], R, 2.0)], law(0.9, 1e-2));
    set_up.gravity = [0.0, 0.0, -1.0].into();
    set_up.walls.push(floor());
    let mut solver = dem(&set_up);
    for _ in 0..40 {
        solver.advance(0.1, 1, &[]).expect("advances");
    }
    assert!((solver.grains.position[0].z - (9.0 - 8.0)).abs() < 1e-13, "{}", solver.grains.position[0].z);
    assert!((solver.grains.velocity[0].z + 4.0).abs() < 1e-14);
    let mass = 2.0 * volume();
    let stiffness = mass * (PI.powi(2) + 0.9f64.ln().powi(2)) / 1e-4;
    set_up.grains[0].position[2] = R - mass / stiffness;
    let mut solver = dem(&set_up);
    for _ in 0..100 {
        solver.advance(1e-3, 1, &[]).expect("advances");
    }
    let off = solver.grains.position[0].z - set_up.grains[0].position[2];
    assert!(off.abs() < 1e-12 && solver.grains.velocity[0].z.abs() < 1e-12, "{off:e}");
}
