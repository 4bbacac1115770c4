//! What a DEM does with grains, beside what is exact: fall, bounce, rest, collision, spin. Each on a scene of
//! its own, without a film, with the loads that the case wants.

use protocol::log::Records;
use protocol::message::{Kinematics, Loads};

use super::bench::Bench;
use super::cases::check_turn;
use crate::solo_run::{Setting, SoloRun};

/// A case with its scene.
pub(super) struct Trial {
    pub(super) name: &'static str,
    pub(super) about: &'static str,
    /// What stands in place of the grains and the contact of [`SCENE`].
    grains: &'static str,
    gravity: f64,
    restitution: f64,
    /// Torque on every grain about z, N m.
    torque: f64,
    windows: usize,
    check: fn(&Course) -> Result<String, String>,
}

/// The grains after each window.
struct Course {
    times: Vec<f64>,
    motion: Vec<Vec<Kinematics>>,
}

/// Speed at which grains are thrown, m/s.
const SPEED: f64 = 0.1;
/// Mass of a grain: 2 kg/m³, radius 0.5 m.
const MASS: f64 = 2.0 * std::f64::consts::PI / 6.0;
/// Its moment of inertia about the centre, kg m².
const INERTIA: f64 = 0.4 * MASS * 0.25;
/// The torque of `spin`, N m.
const TORQUE: f64 = 0.02;
/// Sub-steps of a window, which is half a contact time long.
const SUBSTEPS: u64 = 20;

#[rustfmt::skip]
pub(super) const TRIALS: [Trial; 5] = [
    Trial { name: "fall", about: "thrown upright in a vacuum: v = v0 + g t within 1e-9, x = x0 + v0 t \
        + g t^2/2 within 2 %",
        grains: "position = [2.0, 1.5, 2.0]\nvelocity = [0.1, 0.0, 0.2]", gravity: -1.0, restitution: 1.0, torque: 0.0,
        windows: 20, check: fall },
    Trial { name: "bounce", about: "elastic, on the floor: it leaves as fast as it came, within 2 %, on its line",
        grains: "position = [2.0, 1.5, 0.53]\nvelocity = [0.0, 0.0, -0.1]", gravity: 0.0, restitution: 1.0, torque: 0.0,
        windows: 60, check: bounce },
    Trial { name: "rest", about: "laid on the floor it comes to rest: slower than 1e-3 g t_c, sunk by less \
        than 1 % of its radius",
        grains: "position = [2.0, 1.5, 0.5]", gravity: -1.0, restitution: 0.3, torque: 0.0, windows: 100, check: rest },
    Trial { name: "collision", about: "elastic, of two equal grains head on: they exchange their velocities \
        within 2 %, momentum within 1e-9",
        grains: "position = [1.45, 1.5, 1.5]\nvelocity = [0.1, 0.0, 0.0]\nradius = 0.5\ndensity = 2.0\n\n[[grains]]\n\
            position = [2.5, 1.5, 1.5]\nvelocity = [-0.1, 0.0, 0.0]", gravity: 0.0, restitution: 1.0, torque: 0.0,
        windows: 60, check: collision },
    Trial { name: "spin", about: "under a constant torque: omega = T t/I within 1e-9, turned by T t^2/(2 I) within 2 %",
        grains: "position = [2.0, 1.5, 1.5]", gravity: 0.0, restitution: 1.0, torque: TORQUE, windows: 20,
        check: spin },
];

impl Trial {
    pub(super) fn scene(&self) -> String {
        include_str!("trial.toml")
            .replace("NAME", self.name)
            .replace("# GRAINS", self.grains)
            .replace("\"GRAVITY\"", &format!("{:?}", self.gravity))
            .replace("\"RESTITUTION\"", &format!("{:?}", self.restitution))
    }

    /// Plays it on a bench that was made of its scene.
    pub(super) fn play(&self, bench: &Bench) -> Result<String, String> {
        let count = bench.setup.scene.grains.len();
        let loads = vec![Loads { torque: [0.0, 0.0, self.torque], ..Loads::default() }; count];
        let mut run = SoloRun::open(&bench.setup, Records::Loads(loads), Setting::default())?;
        let mut course = Course { times: vec![0.0], motion: vec![bench.at_start()] };
        let mut time = 0.0;
        for step in 0..self.windows as u64 {
            let command = bench.window(step, time, 1.0, SUBSTEPS);
            time += command.dt;
            let turn = run.play(command)?;
            check_turn(&command, &turn)?;
            let Records::Kinematics(records) = turn.records else { return Err("sent no kinematics".into()) };
            course.times.push(time);
            course.motion.push(records);
        }
        run.stop()?;
        (self.check)(&course)
    }
}

impl Course {
    fn first(&self) -> &[Kinematics] {
        &self.motion[0]
    }

    fn last(&self) -> &[Kinematics] {
        self.motion.last().map_or(&[], Vec::as_slice)
    }

    fn time(&self) -> f64 {
        self.times.last().copied().unwrap_or(0.0)
    }
}

/// Refuses a value further than `within` from what it should be.
fn near(what: &str, value: f64, expected: f64, within: f64) -> Result<(), String> {
    if (value - expected).abs() <= within {
        return Ok(());
    }
    Err(format!("{what} is {value:e}; {expected:e} was expected, within {within:.1e}"))
}

fn fall(course: &Course) -> Result<String, String> {
    let (from, to, t) = (&course.first()[0], &course.last()[0], course.time());
    let g = [0.0, 0.0, -1.0];
    for (c, g) in g.into_iter().enumerate() {
        let v = from.velocity[c] + g * t;
        near(&format!("velocity[{c}] after {t} s"), to.velocity[c], v, 1e-9)?;
        let way = from.velocity[c] * t + 0.5 * g * t * t;
        let scale = from.velocity[c].abs() * t + 0.5 * f64::abs(g) * t * t;
        near(
            &format!("the way along axis {c} after {t} s"),
            to.position[c] - from.position[c],
            way,
            0.02 * scale + 1e-12,
        )?;
    }
    let missed = to.position[2] - from.position[2] - (from.velocity[2] * t - 0.5 * t * t);
    Ok(format!("after {t:.2} s {missed:+.1e} m from where it should be"))
}

fn bounce(course: &Course) -> Result<String, String> {
    let (from, to) = (&course.first()[0], &course.last()[0]);
    let lowest = course.motion.iter().map(|grains| grains[0].position[2]).fold(f64::INFINITY, f64::min);
    if to.velocity[2] <= 0.0 {
        return Err(format!(
            "it still falls, {:e} m/s, {:e} m above the floor at the lowest",
            to.velocity[2],
            lowest - 0.5
        ));
    }
    near("the velocity after the bounce", to.velocity[2], SPEED, 0.02 * SPEED)?;
    for c in 0..2 {
        near(&format!("position[{c}]"), to.position[c], from.position[c], 1e-9)?;
    }
    Ok(format!("{:+.1e} of its speed", to.velocity[2] / SPEED - 1.0))
}

fn rest(course: &Course) -> Result<String, String> {
    let to = &course.last()[0];
    let speed = to.velocity.iter().map(|v| v * v).sum::<f64>().sqrt();
    near("its speed", speed, 0.0, 1e-3 * 0.02)?;
    near("its height", to.position[2], 0.5, 0.005)?;
    Ok(format!("{speed:.0e} m/s, sunk by {:.1e} m", 0.5 - to.position[2]))
}

fn collision(course: &Course) -> Result<String, String> {
    let [a, b] = course.last() else { return Err("there are not two grains".into()) };
    near("velocity[0] of grain 0", a.velocity[0], -SPEED, 0.02 * SPEED)?;
    near("velocity[0] of grain 1", b.velocity[0], SPEED, 0.02 * SPEED)?;
    for c in 0..3 {
        near(&format!("the sum of velocity[{c}]"), a.velocity[c] + b.velocity[c], 0.0, 1e-9 * SPEED)?;
    }
    Ok(format!("{:+.1e} of their speed", b.velocity[0] / SPEED - 1.0))
}

fn spin(course: &Course) -> Result<String, String> {
    let (to, t) = (&course.last()[0], course.time());
    let spun = TORQUE * t / INERTIA;
    near("spin[2]", to.spin[2], spun, 1e-9 * spun)?;
    let turned = 2.0 * f64::atan2(to.orientation[3], to.orientation[0]);
    let expected = 0.5 * TORQUE * t * t / INERTIA;
    near(
        "the angle that it turned by, rad,",
        turned,
        expected,
        0.02 * expected + 0.5 * spun * t / (SUBSTEPS as f64 * course.times.len() as f64),
    )?;
    Ok(format!("turned by {turned:.4} of {expected:.4} rad"))
}
