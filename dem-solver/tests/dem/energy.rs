//! The account of energy closes: kinetic, elastic, gravitational and dissipated energy add up to what there
//! was, to an error that falls with the sub-step.
use crate::common::{cloud, dem, floor, law, spec};
use dem_solver::laws::rolling::Rolling;
use dem_solver::{ContactLaw, Dem, DemSpec, Dissipated, Engine, Grain, Integrator, SpecError, Wall};

/// Grains apart in a periodic box, friction, dashpots both ways; t_c = 0.05, speeds of order 1.
fn gas() -> DemSpec {
    let mut law = law(0.8, 0.05);
    (law.friction, law.damping_ratio) = (0.3, 0.5);
    let mut set_up = spec(cloud(64, 7), law);
    for grain in &mut set_up.grains {
        grain.position = grain.position.map(|x| 1.2 * x);
    }
    set_up.periods = [Some((0.0, 5.28)); 3];
    set_up.energy = true;
    set_up
}

/// A cloud that falls from rest on a floor; D = g = 1.
fn bed() -> DemSpec {
    let mut set_up = gas();
    for grain in &mut set_up.grains {
        (grain.velocity, grain.spin) = ([0.0; 3], [0.0; 3]);
        grain.position[2] += 0.5;
    }
    (set_up.walls, set_up.gravity) = (vec![floor()], [0.0, 0.0, -1.0].into());
    set_up.periods[2] = None;
    set_up
}

/// The same, whose floor vanishes under it, with another one below.
fn gate() -> DemSpec {
    let mut set_up = bed();
    let below = Wall::new([0.0, 0.0, -1.0], [0.0, 0.0, 1.0]);
    set_up.walls = vec![Wall { until: Some(2.0), ..floor() }, below];
    set_up
}

fn total(solver: &Dem) -> f64 {
    let lost = solver.dissipated().expect("an account");
    solver.kinetic_energy() + solver.elastic_energy() + solver.potential_energy() + lost.total()
}

/// Largest error of the balance over `time`, looked at 40 times, over the energy that there was; and what
/// was taken. `n` sub-steps per t_c.
fn imbalance(mut set_up: DemSpec, integrator: Integrator, time: f64, n: u32) -> (f64, Dissipated) {
    set_up.integrator = integrator;
    let mut solver = dem(&set_up);
    let start = total(&solver);
    let scale = if set_up.gravity == [0.0; 3] { start } else { solver.potential_energy() };
    let mut worst = 0.0f64;
    let window = time / 40.0;
    for _ in 0..40 {
        let steps = (window / 0.05 * f64::from(n)).round() as u32;
        solver.advance(window, steps, &[]).expect("advances");
        worst = worst.max((total(&solver) - start).abs() / scale);
    }
    (worst, solver.dissipated().expect("an account"))
}

/// Verlet: second order, and 1e-6 of the initial energy at the finest step.
#[test]
fn the_balance_closes_at_second_order_with_verlet() {
    for (name, set_up, time) in [("gas", gas(), 4.0), ("bed", bed(), 4.0), ("gate", gate(), 4.0)] {
        let runs = [50, 200, 800, 3200].map(|n| {
            let (error, lost) = imbalance(set_up.clone(), Integrator::VelocityVerlet, time, n);
            println!("{name}, t_c/{n}: {error:.2e}, taken {lost:?}");
            assert!(lost.normal > 0.0 && lost.tangential > 0.0 && lost.sliding > 0.0, "{lost:?}");
            error
        });
        let order = (runs[0] / runs[3]).log2() / 6.0;
        println!("{name}: order {order:.2}");
        assert!(order > 1.5 && runs[3] < 1e-6, "{name}: order {order}, {runs:?}");
    }
}

/// Symplectic Euler: its velocities are those half a sub-step earlier, which an instant's balance sees at
/// first order.
#[test]
fn the_balance_closes_at_first_order_with_symplectic_euler() {
    for (name, set_up, time) in [("gas", gas(), 4.0), ("bed", bed(), 4.0), ("gate", gate(), 4.0)] {
        let runs = [50, 100, 200, 400].map(|n| {
            let (error, lost) = imbalance(set_up.clone(), Integrator::SymplecticEuler, time, n);
            println!("{name}, t_c/{n}: {error:.2e}, taken {lost:?}");
            error
        });
        let order = (runs[0] / runs[3]).log2() / 3.0;
        println!("{name}: order {order:.2}");
        assert!(order > 0.9 && runs[3] < 3e-4, "{name}: order {order}, {runs:?}");
    }
}

/// What is restored goes on with its account, and to the same bits.
#[test]
fn a_restored_run_keeps_its_account() {
    for integrator in [Integrator::SymplecticEuler, Integrator::VelocityVerlet] {
        let mut set_up = bed();
        set_up.integrator = integrator;
        let mut solver = dem(&set_up);
        solver.advance(2.0, 2000, &[]).expect("advances");
        let saved = solver.save();
        let mut other = dem(&set_up);
        other.restore(&saved).expect("its own state");
        for each in [&mut solver, &mut other] {
            each.advance(0.5, 500, &[]).expect("advances");
        }
        assert!(solver.dissipated().expect("an account").total() > saved.dissipated.total());
        assert_eq!(solver.save(), other.save());
    }
}

/// A sphere that slides on a floor: friction takes μ m g along its way and no dashpot anything, however
/// strong it is; without friction nothing is taken, and no spring is stretched.
#[test]
fn a_dashpot_takes_nothing_from_what_slides() {
    for friction in [0.0, 0.2] {
        let mut grain = Grain::new([0.0, 0.0, 0.5 - 1e-6], 0.5, 1.0);
        grain.velocity = [3.0, 0.0, 0.0];
        let mut law = law(0.5, 1e-2);
        (law.friction, law.damping_ratio) = (friction, 1.0);
        let mut set_up = spec(vec![grain], law);
        (set_up.walls, set_up.gravity, set_up.energy) = (vec![floor()], [0.0, 0.0, -1.0].into(), true);
        let mut solver = dem(&set_up);
        let start = total(&solver);
        // A contact that begins or ends brings an error of the first order in the sub-step.
        solver.advance(1.0, 100_000, &[]).expect("advances");
        let (lost, g) = (solver.dissipated().expect("an account"), &solver.grains);
        // v falls by μ g t, the spin grows by μ g t m R/I: the surface still slips.
        let (v, spin) = (g.velocity[0].x, 0.5 * g.spin[0].norm());
        let taken = g.mass[0] * (0.5 * (9.0 - v * v) - 0.2 * spin * spin);
        let scale = 4.5 * g.mass[0];
        assert!(v > spin && (lost.sliding - taken).abs() < 2e-3 * scale, "{lost:?}, {taken}");
        assert!(lost.tangential.abs() < 2e-3 * scale && solver.elastic_energy() < 2e-3 * scale, "{lost:?}");
        assert!((total(&solver) - start).abs() < 2e-3 * scale, "{} of {start}", total(&solver));
    }
}

/// An account that would not close is refused.
#[test]
fn laws_without_an_account_are_refused() {
    let refused = |set_up: &DemSpec| matches!(set_up.validate(), Err(SpecError::Combination(_)));
    assert!(!refused(&gas()));
    assert!(refused(&DemSpec { integrator: Integrator::Rk3, ..gas() }));
    let ContactLaw::LinearSpringDashpot(mut law) = gas().contact else { unreachable!() };
    law.rolling = Some(Rolling { friction: 0.1, damping: 0.3 });
    assert!(refused(&DemSpec { contact: ContactLaw::LinearSpringDashpot(law), ..gas() }));
    assert!(DemSpec { engine: Engine::Bulk, ..gas() }.validate().is_err());
}
