//! Grains in space that share cells: touching, squeezed together, at a wall, across a periodic face.

use crate::immersed::newton::{Drift, Run};
use fluid_solver::measure::momentum;
use fluid_solver::methods::calibrated::calibration::{Calibration, ForceTransport};

const BOX: &str = "until = 1.0
    [domain]
    geometry = \"space\"
    lower = [0.0, 0.0, 0.0]
    upper = [2.0, 2.0, 2.0]
    cells = [32, 32, 32]
    [medium]
    density = 1.0
    viscosity = 0.05
    [fluid]
    time = { dt = 0.01 }
    ";

/// Where the carried force waits for the next step.
const TRANSPORTS: [ForceTransport; 2] = [ForceTransport::Eulerian, ForceTransport::Advected];

/// Position and velocity.
type Placed = ([f64; 3], [f64; 3]);

/// Grains of radius ¼ (8 cells across) in a box, at `position` with `velocity`, that nothing turns aside.
fn run(faces: &str, force_transport: ForceTransport, grains: &[Placed]) -> Run {
    let mut scene = BOX.to_owned();
    for (position, velocity) in grains {
        scene += &format!(
            "[[grains]]\nposition = {position:?}\nvelocity = {velocity:?}\nradius = 0.25\ndensity = 2.0\n\
             motion = \"prescribed\"\n"
        );
    }
    let calibration = Calibration {
        force_transport,
        without_local_solve: force_transport == ForceTransport::Advected,
        without_virtual_mass: true,
        ..Calibration::default()
    };
    let mut run = Run::calibrated(&format!("{scene}\n[domain.boundary]\n{faces}\n"), calibration);
    run.newton.drift = Drift::Old;
    run
}

/// Largest speed along any axis.
fn fastest(run: &Run) -> f64 {
    let velocity = &run.fluid.three().expect("space").stepper().state().velocity;
    velocity.iter().flatten().fold(0.0, |m, u| m.max(u.abs()))
}

const PERIODIC: &str = "x = \"periodic\"\ny = \"periodic\"\nz = \"periodic\"";

/// However the masks overlap, the fluid loses what the grains receive, to round-off, and no velocity is
/// far above theirs.
#[test]
fn loads_are_the_momentum_given_however_grains_share_cells() {
    let h = 0.25 * 3f64.sqrt();
    let cases: [(&str, Vec<Placed>); 5] = [
        ("one, across a face and an edge", vec![([0.03, 1.98, 1.0], [0.5, 0.25, -0.5])]),
        ("two that touch and part", vec![([0.75, 1.0, 1.0], [-0.5; 3]), ([1.25, 1.0, 1.0], [0.5, 0.0, 0.0])]),
        (
            "three that touch",
            vec![
                ([0.75, 1.0, 1.0], [-0.5, 0.0, 0.0]),
                ([1.25, 1.0, 1.0], [0.5, 0.0, 0.0]),
                ([1.0, 1.0 + h, 1.0], [0.0, 0.5, 0.1]),
            ],
        ),
        (
            "two squeezed to 0.04 D and on",
            vec![([0.76, 1.0, 1.0], [0.5, 0.0, 0.0]), ([1.24, 1.0, 1.0], [-0.5, 0.0, 0.0])],
        ),
        (
            "two that touch across a periodic face",
            vec![([0.1, 1.0, 1.0], [0.3, 0.0, 0.5]), ([1.6, 1.0, 1.0], [-0.3, 0.2, 0.0])],
        ),
    ];
    for (name, transport, grains) in TRANSPORTS
        .iter()
        .flat_map(|transport| cases.iter().map(move |(name, grains)| (name, *transport, grains)))
    {
        let mut run = run(PERIODIC, transport, grains);
        let total = |run: &Run, d: usize| {
            let solver = run.fluid.three().expect("space");
            momentum(solver.grid(), d, &solver.stepper().state().velocity[d])
        };
        for step in 0..10 {
            let before = [0, 1, 2].map(|d| total(&run, d));
            run.windows(1);
            for (d, before) in before.into_iter().enumerate() {
                let given: f64 = run.newton.loads.iter().map(|load| -0.01 * load.force[d]).sum();
                let found = total(&run, d) - before;
                assert!(
                    (found - given).abs() < 1e-13,
                    "{name}, {transport:?}, step {step}, axis {d}: {found:e}, given {given:e}"
                );
            }
        }
        let fastest = fastest(&run);
        println!("{name}, {transport:?}: largest speed {fastest:.3}");
        assert!(fastest < 2.8 * 0.5 * 3f64.sqrt(), "{name}, {transport:?}: {fastest}");
    }
}

/// A grain that touches the floor and moves along it or away from it.
#[test]
fn a_grain_at_a_wall_moves_the_fluid_no_faster_than_itself() {
    let velocities = [[0.5, 0.0, 0.0], [0.0, 0.0, 0.5]];
    for (velocity, transport) in
        velocities.into_iter().flat_map(|velocity| TRANSPORTS.map(|transport| (velocity, transport)))
    {
        let faces = "x = \"periodic\"\ny = \"periodic\"\nz = \"no-slip\"";
        let mut run = run(faces, transport, &[([1.0, 1.0, 0.25], velocity)]);
        run.windows(10);
        let fastest = fastest(&run);
        let force = run.newton.loads[0].force;
        println!("{velocity:?}: largest speed {fastest:.3}, force {force:?}");
        assert!(fastest < 1.4, "{velocity:?}: {fastest}");
        // the fluid resists, and on the line of motion only
        let along = if velocity[0] > 0.0 { 0 } else { 2 };
        assert!(force[along] < 0.0 && force[1].abs() < 1e-9 * force[along].abs(), "{velocity:?}: {force:?}");
    }
}
