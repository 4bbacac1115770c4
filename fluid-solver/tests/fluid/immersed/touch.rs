//! What a contact does to the fluid: energy, restart, threads and ranks in the windows of a touch.

use crate::flow::common::kinetic_energy;
use crate::immersed::newton::{Newton, Run, scene};
use crate::immersed::ranks::shared;
use crate::immersed::restart::{folder, messages};
use protocol::participant::Participant;
use std::path::Path;

/// Restitution of the dry contact.
const DRY: f64 = 0.97;

/// A sphere of D = 1 that is thrown at a floor, its gap `gap` to start with.
fn thrown(gap: f64, density: f64, viscosity: f64, cfl: f64) -> Run {
    let mut run = Run::new(&format!(
        "until = 100.0
        [domain]
        geometry = \"axisymmetric\"
        lower = [0.0, 0.0]
        upper = [3.0, 5.0]
        cells = [30, 50]
        boundary = {{ r_upper = \"free-slip\", z_lower = \"no-slip\", z_upper = \"free-slip\" }}
        [medium]
        density = 1.0
        viscosity = {viscosity}
        [[grains]]
        position = [0.0, 0.0, {}]
        velocity = [0.0, 0.0, -1.0]
        radius = 0.5
        density = {density}
        [fluid]
        time = {{ cfl = {cfl} }}
        ",
        0.5 + gap
    ));
    run.newton.floor = Some(DRY);
    run
}

/// Energy of the grain and the fluid around it, over ρ: the fluid in its place does not count.
fn energy(run: &Run, density: f64) -> f64 {
    let solver = run.fluid.two().expect("r-z");
    let volume = std::f64::consts::PI / 6.0;
    kinetic_energy(solver.grid(), &solver.stepper().state().velocity)
        + 0.5 * (density - 1.0) * volume * run.fall().powi(2)
}

/// From the window before the touch on the energy of grain and fluid falls, and the sphere is never faster
/// than the dry contact made it, wherever in its window it touches.
#[test]
fn a_touch_gives_no_energy() {
    // The first windows of a light sphere that is thrown swing: it has short ones.
    for (density, viscosity, cfl) in
        [(2.6, 0.002, 0.5), (8.0, 0.02, 0.5), (2.6, 0.002, 0.1), (0.5, 0.01, 0.1)]
    {
        for phase in 0..3 {
            let mut run = thrown(0.1 + 0.017 * f64::from(phase), density, viscosity, cfl);
            let (mut before, mut speed) = (energy(&run, density), 0.0);
            while run.fall() < 0.0 {
                (before, speed) = (energy(&run, density), -run.fall());
                run.windows(1);
                assert!(run.time < 10.0, "{density} {cfl} {phase}: it arrives");
            }
            let touched = run.time;
            let mut most: f64 = 0.0;
            while run.time < touched + 0.3 {
                let now = energy(&run, density);
                assert!(now < before, "{density} {cfl} {phase}: {now} {before}");
                most = most.max(run.fall());
                before = now;
                run.windows(1);
            }
            assert!(most < DRY * speed, "{density} {cfl} {phase}: {most} {speed}");
        }
    }
}

/// Speed of a sphere that comes back to a gap of 0.2 D.
fn comes_back(mut run: Run) -> f64 {
    let mut last = (0.0, 0.0);
    while run.fall() < 0.0 || run.newton.motions[0].position[2] < 0.7 {
        last = (run.newton.motions[0].position[2], run.fall());
        run.windows(1);
        assert!(run.time < 10.0, "it comes back");
    }
    let part = (0.7 - last.0) / (run.newton.motions[0].position[2] - last.0);
    last.1 + part * (run.fall() - last.1)
}

/// A sphere of St = 27 that is thrown in space beside one that stays behind; `way` is its gap to start with.
fn beside_another(way: f64, cfl: f64) -> Run {
    let mut run = Run::new(&format!(
        "until = 100.0
        [domain]
        geometry = \"space\"
        lower = [0.0, 0.0, 0.0]
        upper = [4.0, 2.0, 3.0]
        cells = [40, 20, 30]
        boundary = {{ x = \"periodic\", y = \"periodic\", z = \"no-slip\" }}
        [medium]
        density = 1.0
        viscosity = 0.033
        [[grains]]
        position = [1.0, 1.02, {}]
        velocity = [0.0, 0.0, -1.0]
        radius = 0.5
        density = 8.0
        [[grains]]
        position = [3.03, 1.0, 1.8]
        velocity = [0.0, 0.0, 0.1]
        radius = 0.5
        density = 8.0
        [fluid]
        time = {{ cfl = {cfl} }}
        ",
        0.5 + way
    ));
    run.newton.floor = Some(DRY);
    run
}

/// The step is short before a touch and begins anew after it: viscosity takes what it should.
#[test]
fn a_rebound_hardly_depends_on_the_step() {
    let alone = |way, cfl| thrown(way, 8.0, 0.033, cfl);
    let scenes: [&dyn Fn(f64, f64) -> Run; 2] = [&alone, &beside_another];
    for scene in scenes {
        let short = comes_back(scene(0.6, 0.05));
        for phase in 0..4 {
            let long = comes_back(scene(0.6 + 0.012 * f64::from(phase), 0.5));
            println!("speed {long:.4} with long steps, {short:.4} with short ones");
            assert!((long / short - 1.0).abs() < 0.02, "{phase}: {long} {short}");
        }
    }
}

/// Two spheres in space that hit each other aslant, one of which hits the floor.
const SPACE: &str = "until = 1.0
    gravity = [0.0, 0.0, -1.0]
    [domain]
    geometry = \"space\"
    lower = [0.0, 0.0, 0.0]
    upper = [2.0, 2.0, 3.0]
    cells = [16, 16, 24]
    boundary = { x = \"periodic\", y = \"periodic\", z = \"no-slip\" }
    [medium]
    density = 1.0
    viscosity = 0.01
    [[grains]]
    position = [0.7, 1.0, 0.55]
    velocity = [0.2, 0.0, -1.0]
    radius = 0.5
    density = 2.0
    [[grains]]
    position = [1.1, 1.2, 2.3]
    velocity = [0.0, 0.0, -0.3]
    radius = 0.5
    density = 3.0
    ";

/// Up to the end of the window in which the first sphere is thrown back.
fn touch(run: &mut Run) {
    run.newton.floor = Some(DRY);
    let mut windows = 0;
    while run.fall() < 0.0 {
        run.windows(1);
        windows += 1;
        assert!(windows < 50, "it arrives");
    }
}

#[test]
fn the_window_after_a_touch_is_the_same_after_a_restore_and_a_checkpoint() {
    for keys in ["time = { scheme = \"ab2\" }", "time = { scheme = \"rk3\" }"] {
        let text = format!("{SPACE}\n[fluid]\n{keys}");
        let folder = folder("touch");
        let mut run = Run::new(&text);
        touch(&mut run);
        run.fluid.save();
        run.fluid.write_checkpoint(&folder).expect("writes");
        let mut kept = Newton::new(&scene(&text));
        kept.take_over(&run.newton);
        let at = (run.time, run.step, run.dt);
        let first = messages(&mut run, 4);
        run.fluid.restore();
        let mut other = Run::new(&text);
        other.fluid.read_checkpoint(&folder).expect("reads");
        for mut run in [run, other] {
            run.newton.floor = Some(DRY);
            run.newton.take_over(&kept);
            (run.time, run.step, run.dt) = at;
            assert_eq!(first, messages(&mut run, 4), "{keys}");
        }
        std::fs::remove_dir_all(&folder).expect("removes");
    }
}

#[test]
fn ranks_and_threads_change_no_bit_of_a_touch() {
    for keys in ["time = { scheme = \"ab2\" }", "time = { scheme = \"rk3\", viscosity = \"implicit\" }"] {
        let text = format!("{SPACE}\n[fluid]\nlauncher = [\"mpirun\", \"-np\", \"1\"]\n{keys}");
        let through = |run: &mut Run| {
            touch(run);
            messages(run, 3)
        };
        let one = through(&mut Run::new(&text));
        for size in [2, 3] {
            assert_eq!(one, shared(&text, size, Path::new("unused"), through), "{size} ranks, {keys}");
        }
        let pool = rayon::ThreadPoolBuilder::new().num_threads(3).build().expect("a pool");
        assert_eq!(one, pool.install(|| through(&mut Run::new(&text))), "{keys}");
    }
}
