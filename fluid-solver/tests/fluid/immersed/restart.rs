//! Same bits after a restore, after a checkpoint, and for any number of threads.

use crate::immersed::newton::{Run, scene};
use fluid_solver::methods::calibrated::calibration::{Calibration, ForceTransport};
use fluid_solver::participant::Fluid;
use fluid_solver::scheme::Viscous;
use protocol::message::Record;
use protocol::participant::Participant;
use std::path::PathBuf;

const PLANE: &str = "until = 1.0
    gravity = [0.0, 0.0, -1.0]
    [domain]
    geometry = \"plane\"
    lower = [0.0, 0.0]
    upper = [2.0, 3.0]
    cells = [32, 48]
    boundary = { x = \"periodic\", z = \"no-slip\" }
    [medium]
    density = 1.0
    viscosity = 0.05
    [[grains]]
    position = [0.1, 0.0, 2.0]
    spin = [0.0, 1.0, 0.0]
    radius = 0.25
    density = 2.0
    [[grains]]
    position = [0.55, 0.0, 1.6] # near the other one: virtual masses by the gap
    radius = 0.25
    density = 1.1
    ";

fn fluid(keys: &str) -> String {
    format!("{PLANE}\n[fluid]\n{keys}")
}

/// The force goes with the grains in every step, and viscosity does not feel its change.
pub(crate) const ADVECTED: Calibration =
    Calibration { force_transport: ForceTransport::Advected, without_local_solve: true, ..AUTO };

/// It does.
const TOLD: Calibration = Calibration { without_local_solve: false, ..ADVECTED };

const AUTO: Calibration = Calibration {
    force_transport: ForceTransport::Auto,
    nominal_radius: false,
    without_local_solve: false,
    plain_convection: false,
    without_virtual_mass: false,
    without_displaced_mass: false,
};

const FORMS: [(&str, Calibration); 7] = [
    ("", AUTO),
    ("time = { scheme = \"ab2\" }", AUTO),
    ("method = \"izard-2014\"", AUTO),
    ("", ADVECTED),
    ("", TOLD),
    ("", Calibration { nominal_radius: true, ..AUTO }),
    ("method = \"fictitious-domain\"", AUTO),
];

/// Everything that crosses, as bits.
pub(crate) fn messages(run: &mut Run, windows: usize) -> Vec<u64> {
    let mut words = Vec::new();
    for _ in 0..windows {
        run.windows(1);
        words.push(run.dt.to_bits());
        for loads in &run.newton.loads {
            words.extend(loads.words());
        }
    }
    words
}

/// A copy of the grains' side, to go back with the fluid.
fn grains(run: &Run) -> crate::immersed::newton::Newton {
    let mut copy = crate::immersed::newton::Newton::new(&scene(PLANE));
    copy.take_over(&run.newton);
    copy
}

#[test]
fn a_restored_window_gives_the_same_bits() {
    for (keys, calibration) in FORMS {
        let mut run = Run::calibrated(&fluid(keys), calibration);
        run.windows(7);
        run.fluid.save();
        let kept = grains(&run);
        let (time, step, dt) = (run.time, run.step, run.dt);
        let first = messages(&mut run, 6);
        run.fluid.restore();
        (run.time, run.step, run.dt) = (time, step, dt);
        run.newton.take_over(&kept);
        assert_eq!(first, messages(&mut run, 6), "{keys} {calibration:?}");
    }
}

pub(crate) fn folder(name: &str) -> PathBuf {
    std::env::temp_dir().join(format!("bedload-fluid-{name}-{}", std::process::id()))
}

#[test]
fn a_checkpoint_gives_the_same_bits_and_refuses_what_does_not_fit() {
    for (case, (keys, calibration)) in FORMS.into_iter().enumerate() {
        let folder = folder(&format!("checkpoint-{case}"));
        let mut run = Run::calibrated(&fluid(keys), calibration);
        run.windows(7);
        run.fluid.write_checkpoint(&folder).expect("writes");
        let kept = grains(&run);
        let (time, step, dt) = (run.time, run.step, run.dt);
        let first = messages(&mut run, 6);

        let mut other = Run::calibrated(&fluid(keys), calibration);
        other.fluid.read_checkpoint(&folder).expect("reads");
        (other.time, other.step, other.dt) = (time, step, dt);
        other.newton.take_over(&kept);
        assert_eq!(first, messages(&mut other, 6), "{keys}");

        let text = fluid(keys)
            .replace("2.0\n    cells", "2.0\n    # another\n    cells")
            .replace("density = 1.1", "density = 1.2");
        let mut foreign = Fluid::new(&scene(&text), &folder).expect("a scene");
        let error = foreign.read_checkpoint(&folder).expect_err("another scene").to_string();
        assert!(error.contains("another scene"), "{error}");
        let file = protocol::checkpoint::path(&folder, "fluid");
        let bytes = std::fs::read(&file).expect("there");
        std::fs::write(&file, &bytes[..bytes.len() / 2]).expect("writes");
        let error = other.fluid.read_checkpoint(&folder).expect_err("truncated").to_string();
        assert!(error.contains("truncated"), "{error}");
        std::fs::remove_dir_all(&folder).expect("removes");
        assert!(other.fluid.read_checkpoint(&folder).is_err(), "missing");
    }
}

#[test]
fn the_number_of_threads_changes_no_bit() {
    const TEXT: &str = "until = 1.0
        gravity = [0.3, 0.0, -1.0]
        [domain]
        geometry = \"space\"
        lower = [0.0, 0.0, 0.0]
        upper = [3.0, 2.0, 3.0]
        cells = [48, 32, 48]
        boundary = { x = \"periodic\", y = \"periodic\", z = \"no-slip\" }
        [medium]
        density = 1.0
        viscosity = 0.05
        [[groups]]
        count = 6
        lower = [0.0, 0.0, 0.2]
        upper = [3.0, 2.0, 2.8]
        radius = 0.4
        density = 2.0
        seed = 4
        [fluid]
        time = { scheme = \"ab2\" }
        ";
    let eulerian = Calibration { force_transport: ForceTransport::Eulerian, ..AUTO };
    for (text, transport) in [eulerian, ADVECTED, AUTO].into_iter().flat_map(|t| [(TEXT, t), (PLANE, t)]) {
        let run = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
            pool.install(|| messages(&mut Run::calibrated(text, transport), 5))
        };
        let one = run(1);
        assert_eq!(one, run(2), "{transport:?}");
        assert_eq!(one, run(4), "{transport:?}");
    }
}

/// The speed that is expected up to a later end asks for explicit viscosity where the run was implicit; the
/// run that goes on stays so, with the bits of one that was never ended.
#[test]
fn a_later_end_keeps_the_treatment_of_viscosity() {
    let folder = folder("later-end");
    let text = |until: f64| {
        PLANE
            .replace("until = 1.0", &format!("until = {until:?}"))
            .replace("[0.0, 0.0, -1.0]", "[2.0, 0.0, -1.0]")
            + "[fluid]\ntime = { scheme = \"ab2\" }\n"
    };
    let viscous =
        |run: &Run| run.fluid.two().map(|solver| solver.stepper().options().viscous).expect("two axes");
    let mut run = Run::new(&text(0.5));
    let mut later = Run::new(&text(40.0));
    assert_eq!([viscous(&run), viscous(&later)], [Viscous::Implicit, Viscous::Explicit]);
    run.windows(7);
    run.fluid.write_checkpoint(&folder).expect("writes");
    (later.time, later.step, later.dt) = (run.time, run.step, run.dt);
    later.newton.take_over(&grains(&run));
    later.fluid.read_checkpoint(&folder).expect("reads");
    assert_eq!(viscous(&later), Viscous::Implicit);
    // The step may be another: an expected speed bounds it, too.
    let dt = run.dt;
    for window in 0..6 {
        let [one, other] = [&mut run, &mut later].map(|run| {
            run.dt = dt;
            run.windows(1);
            run.fluid.two().expect("two axes").stepper().state().velocity.clone()
        });
        assert!(one == other, "window {window}");
    }
    std::fs::remove_dir_all(&folder).expect("removes");
}
