//! A DEM of a dozen lines: `(m_p + m_a) a = m_p g + F + m_a A_prev`, likewise for the spin, and a floor that
//! throws grains back where one is asked for.

use bedload_scene::{CheckedScene, Freedom, Geometry, Motion, SceneSource};
use fluid_solver::methods::calibrated::calibration::Calibration;
use fluid_solver::participant::Fluid;
use fluid_solver::ranks::Ranks;
use fluid_solver::solver::Solver;
use protocol::message::{Header, Kinematics, Loads};
use protocol::participant::{Exchange, ExchangeError, Participant, SolverError, Window, WindowReport};
use std::path::Path;

/// Checks a scene written as text.
pub(crate) fn scene(text: &str) -> CheckedScene {
    try_scene(text).unwrap_or_else(|error| panic!("{error}: {}", error.remedy))
}

/// The same, as a result.
pub(crate) fn try_scene(text: &str) -> Result<CheckedScene, bedload_scene::SceneError> {
    CheckedScene::new(SceneSource { file: "test.toml".into(), text: text.into() })
}

struct Body {
    radius: f64,
    mass: f64,
    inertia: f64,
    /// Whether its orientation is followed: that of a body of the plane that is not round.
    turns: bool,
    free: [bool; 6],
}

/// How the grains move within a window.
#[derive(Clone, Copy, PartialEq)]
pub(crate) enum Drift {
    /// With the mean of old and new velocity.
    Mean,
    /// With the old velocity: exactly where the fluid predicts them.
    Old,
}

/// Grains that obey Newton, in place of a DEM.
pub(crate) struct Newton {
    bodies: Vec<Body>,
    gravity: [f64; 3],
    pub(crate) drift: Drift,
    /// Restitution of a wall at z = 0.
    pub(crate) floor: Option<f64>,
    pub(crate) motions: Vec<Kinematics>,
    pub(crate) loads: Vec<Loads>,
    accelerations: Vec<[f64; 6]>,
}

impl Newton {
    pub(crate) fn new(scene: &CheckedScene) -> Self {
        let freedoms = [Freedom::X, Freedom::Y, Freedom::Z, Freedom::SpinX, Freedom::SpinY, Freedom::SpinZ];
        let geometry: Geometry = scene.scene.domain.geometry;
        let bodies = scene.grains.iter().map(|grain| Body {
            radius: grain.radius,
            mass: grain.mass(),
            inertia: grain.gyration() * grain.mass(),
            turns: !grain.shape.is_round(),
            free: freedoms.map(|f| grain.is_free(f, geometry)),
        });
        let motions = scene.grains.iter().map(|grain| Kinematics {
            position: grain.position,
            orientation: grain.orientation,
            velocity: if grain.motion == Motion::Fixed { [0.0; 3] } else { grain.velocity.start() },
            spin: grain.spin.start(),
            ..Kinematics::default()
        });
        Self {
            bodies: bodies.collect(),
            gravity: scene.scene.gravity.start(),
            drift: Drift::Mean,
            floor: None,
            motions: motions.collect(),
            loads: vec![Loads::default(); scene.grains.len()],
            accelerations: vec![[0.0; 6]; scene.grains.len()],
        }
    }

    fn step(&mut self, dt: f64) {
        let grains = self.bodies.iter().zip(&mut self.motions).zip(&self.loads).zip(&mut self.accelerations);
        for (((body, motion), loads), before) in grains {
            let (old, spin) = (motion.velocity, motion.spin[1]);
            for c in 0..3 {
                let (ma, ia) = (loads.added_mass, loads.added_inertia);
                let push = body.mass * self.gravity[c] + loads.force[c] + ma * before[c];
                let twist = loads.torque[c] + ia * before[c + 3];
                let linear = if body.free[c] { push / (body.mass + ma) } else { 0.0 };
                let angular = if body.free[c + 3] { twist / (body.inertia + ia) } else { 0.0 };
                motion.velocity[c] += dt * linear;
                motion.spin[c] += dt * angular;
                (before[c], before[c + 3]) = (linear, angular);
                let new = if self.drift == Drift::Old { old[c] } else { motion.velocity[c] };
                motion.position[c] += 0.5 * dt * (old[c] + new);
            }
            let below = body.radius - motion.position[2];
            if let Some(restitution) = self.floor.filter(|_| below > 0.0 && motion.velocity[2] < 0.0) {
                motion.velocity[2] *= -restitution;
                motion.position[2] += (1.0 + restitution) * below;
                before[2] = (motion.velocity[2] - old[2]) / dt;
            }
            if body.turns {
                let turned = 0.5 * dt * (spin + motion.spin[1]);
                let half = motion.orientation[2].atan2(motion.orientation[0]) + 0.5 * turned;
                motion.orientation = [half.cos(), 0.0, half.sin(), 0.0];
            }
        }
    }
}

impl Exchange<Kinematics, Loads> for Newton {
    fn send(&mut self, _: Header, fill: &mut dyn FnMut(&mut [Loads])) -> Result<(), ExchangeError> {
        fill(&mut self.loads);
        Ok(())
    }

    fn receive(
        &mut self,
        window: &Window,
        read: &mut dyn FnMut(&Header, &[Kinematics]),
    ) -> Result<(), ExchangeError> {
        self.step(window.dt);
        read(&window.header(), &self.motions);
        Ok(())
    }
}

/// A fluid, its grains and the clock.
pub(crate) struct Run {
    pub(crate) fluid: Fluid,
    pub(crate) newton: Newton,
    pub(crate) time: f64,
    pub(crate) step: u64,
    pub(crate) dt: f64,
    pub(crate) last: Option<WindowReport>,
}

impl Run {
    pub(crate) fn new(text: &str) -> Self {
        Self::with_ranks(text, &Ranks::alone(), Path::new("unused"))
    }

    /// With a fluid that `ranks` share, of which this is the first.
    pub(crate) fn with_ranks(text: &str, ranks: &Ranks, folder: &Path) -> Self {
        let scene = scene(text);
        let fluid = Fluid::with_ranks(&scene, folder, ranks).unwrap_or_else(|e| panic!("{e}"));
        Self::of(fluid, &scene)
    }

    /// With single parts of the calibrated method switched.
    pub(crate) fn calibrated(text: &str, calibration: Calibration) -> Self {
        let scene = scene(text);
        let fluid = Fluid::with_calibration(&scene, Path::new("unused"), calibration);
        Self::of(fluid.unwrap_or_else(|e| panic!("{e}")), &scene)
    }

    fn of(fluid: Fluid, scene: &CheckedScene) -> Self {
        let plan = fluid.two().map(Solver::plan).or(fluid.three().map(Solver::plan));
        let dt = plan.expect("two axes or three").first;
        Self { fluid, newton: Newton::new(scene), time: 0.0, step: 0, dt, last: None }
    }

    /// One window of the proposed length.
    pub(crate) fn window(&mut self) -> Result<WindowReport, SolverError> {
        let window =
            Window { step: self.step, attempt: 0, time: self.time, dt: self.dt, substeps: 1, output: false };
        let report = self.fluid.advance(&window, &mut self.newton)?;
        self.time += self.dt;
        self.step += 1;
        self.dt = report.dt_limit;
        self.last = Some(report);
        Ok(report)
    }

    /// Windows up to time `until`.
    pub(crate) fn until(&mut self, until: f64) -> &mut Self {
        while self.time < until * (1.0 - 1e-12) {
            self.window().unwrap_or_else(|error| panic!("{error}"));
        }
        self
    }

    /// `count` windows.
    pub(crate) fn windows(&mut self, count: usize) -> &mut Self {
        for _ in 0..count {
            self.window().unwrap_or_else(|error| panic!("{error}"));
        }
        self
    }

    /// Velocity of grain 0 along z.
    pub(crate) fn fall(&self) -> f64 {
        self.newton.motions[0].velocity[2]
    }
}

impl Newton {
    /// Goes on from where `other` stands.
    pub(crate) fn take_over(&mut self, other: &Self) {
        self.motions.clone_from(&other.motions);
        self.loads.clone_from(&other.loads);
        self.accelerations.clone_from(&other.accelerations);
    }
}
