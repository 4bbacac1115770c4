//! Coarse-graining against the identities it must keep: the virial, and the weight above.
use crate::common::{cloud, dem, floor, law, spec};
use dem_solver::LinearSpringDashpot;
use dem_solver::contacts::Contact;
use dem_solver::output::coarse_grain::coarse_grain;
use dem_solver::output::partition::{Grid, Partition, Slabs};
use dem_solver::{Dem, Grain, Motion, Shape, Vec3, Wall};
use nalgebra::Matrix3;

fn virial(contacts: &[Contact]) -> Matrix3<f64> {
    contacts.iter().map(|c| c.force * (c.end - c.start).transpose()).sum()
}

/// A compressed cloud in a box, with a few held grains.
fn crowd() -> Dem {
    let mut grains = cloud(125, 3);
    for grain in grains.iter_mut().step_by(17) {
        (grain.motion, grain.velocity, grain.spin) = (Motion::Fixed, [0.0; 3], [0.0; 3]);
    }
    let mut set_up = spec(grains, LinearSpringDashpot::new(0.7, 0.2, 0.5));
    for axis in 0..3 {
        let (mut low, mut high) = (Wall::new([0.0; 3], [0.0; 3]), Wall::new([5.5; 3], [0.0; 3]));
        (low.normal[axis], high.normal[axis]) = (1.0, -1.0);
        set_up.walls.extend([low, high]);
    }
    let mut run = dem(&set_up);
    run.advance(0.3, 600, &[]).expect("advances");
    run
}

#[test]
fn the_integral_of_the_contact_stress_is_the_virial_sum() {
    let run = crowd();
    let contacts = run.contact_list(&[]);
    let held = contacts.iter().filter(|contact| contact.held).count();
    assert!(held > 5 && contacts.len() > held + 20, "{held} of {}", contacts.len());
    let total = virial(&contacts);
    let slabs = |axis| {
        Partition::Slabs(Slabs {
            axis,
            lower: -1.0,
            width: 0.37,
            count: 21,
            area: 5.5 * 5.5,
            period: None,
            shape: Shape::Sphere,
        })
    };
    let (cells, beyond) = ([10; 3], [[0; 2]; 3]);
    let grid = Grid { lower: [-0.5; 3], spacing: [0.65; 3], cells, beyond, width: 0.5, periods: [None; 3] };
    for partition in [slabs(0), slabs(1), slabs(2), Partition::Grid(grid)] {
        let cells = coarse_grain(&run.grains, Shape::Sphere, &contacts, &partition, |_| true);
        let stress: Matrix3<f64> = cells.iter().map(|cell| cell.contact * partition.volume()).sum();
        assert!((stress - total).norm() < 1e-12 * total.norm(), "{stress} {total}");
        let free = || (0..run.grains.len()).filter(|&i| run.grains.motion[i] == Motion::Free);
        let mass: f64 = cells.iter().map(|cell| cell.density * partition.volume()).sum();
        let expected: f64 = free().map(|i| run.grains.mass[i]).sum();
        assert!((mass / expected - 1.0).abs() < 1e-13);
        let volume: f64 = cells.iter().map(|cell| cell.solid * partition.volume()).sum();
        assert!((volume / expected - 1.0).abs() < 1e-13, "density 1");
        let momentum: Vec3 = cells.iter().map(|c| c.velocity * (c.density * partition.volume())).sum();
        let expected: Vec3 = free().map(|i| run.grains.velocity[i] * run.grains.mass[i]).sum();
        assert!((momentum - expected).norm() < 1e-12);
        // energy of the motion within the cells is less than that of all motion
        let inner: f64 = cells.iter().map(|cell| 0.5 * cell.kinetic.trace() * partition.volume()).sum();
        let all: f64 = free().map(|i| 0.5 * run.grains.mass[i] * run.grains.velocity[i].norm_squared()).sum();
        assert!(inner > 0.0 && inner < all, "{inner} {all}");
    }
}

#[test]
fn contact_forces_are_those_of_the_solver() {
    let mut run = crowd();
    let contacts = run.contact_list(&[]);
    let mut sums = vec![Vec3::zeros(); run.grains.len()];
    for contact in &contacts {
        sums[contact.grain] += contact.force;
        if !contact.held {
            let partner = (0..run.grains.len())
                .find(|&j| (run.grains.position[j] - contact.start).norm() < 1e-12)
                .expect("the line ends in a grain");
            sums[partner] -= contact.force;
        }
    }
    let (before, velocity) = (run.save(), run.grains.velocity.clone());
    assert_eq!(before, run.save(), "looking changes nothing");
    // so short a step that springs do not change: the change of velocity is the force
    let dt = 1e-9;
    run.advance(dt, 1, &[]).expect("advances");
    for (i, sum) in sums.iter().enumerate().filter(|(i, _)| run.grains.motion[*i] == Motion::Free) {
        let force = (run.grains.velocity[i] - velocity[i]) * (run.grains.mass[i] / dt);
        assert!((force - sum).norm() < 1e-5 * (1.0 + sum.norm()), "grain {i}: {force} {sum}");
    }
}

#[test]
fn a_stack_bears_the_weight_above() {
    let (n, r, g) = (8, 0.5, 10.0);
    let grains: Vec<Grain> =
        (0..n).map(|k| Grain::new([0.0, 0.0, r + 2.0 * r * f64::from(k)], r, 3.0)).collect();
    let mass = 3.0 * 4.0 / 3.0 * std::f64::consts::PI * r.powi(3);
    let mut set_up = spec(grains, law(0.3, 0.01));
    set_up.gravity = [0.0, 0.0, -g].into();
    set_up.walls.push(floor());
    let mut stack = dem(&set_up);
    stack.advance(8.0, 40_000, &[]).expect("advances");
    let energy = stack.kinetic_energy() / (mass * g * r);
    assert!(energy < 1e-12, "{energy}");
    let contacts = stack.contact_list(&[]);
    let slabs =
        Slabs { axis: 2, lower: 0.0, width: 0.05, count: 170, area: 2.0, period: None, shape: Shape::Sphere };
    let cells = coarse_grain(&stack.grains, Shape::Sphere, &contacts, &Partition::Slabs(slabs), |_| true);
    for (slab, cell) in cells.iter().enumerate() {
        let (low, high) = (0.05 * slab as f64, 0.05 * (slab + 1) as f64);
        let centres = || stack.grains.position.iter().map(|x| x.z);
        if centres().any(|z| z > low && z < high) {
            continue;
        }
        let above = centres().filter(|z| *z >= high).count() as f64;
        let expected = above * mass * g / 2.0;
        assert!(
            (cell.contact[(2, 2)] - expected).abs() < 1e-6 * mass * g,
            "slab {slab}: {cell:?} {expected}"
        );
    }
}
