//! A solver under test, and what it is asked for.

use bedload_scene::Grain;
use protocol::log::Records;
use protocol::message::{Command, Kinematics, Loads, Order};
use protocol::participant::Role;

use crate::solo_run::{Setting, Setup, SoloRun};

/// Who is tested, and on what.
pub(super) struct Bench {
    pub(super) setup: Setup,
    /// Planned length of a window, s.
    pub(super) dt: f64,
    /// Whether the scene is the built-in one, of which more is known.
    pub(super) plain: bool,
}

impl Bench {
    /// A run of the solver, which is ready.
    pub(super) fn open(&self, setting: Setting<'_>) -> Result<SoloRun<'_>, String> {
        SoloRun::open(&self.setup, self.lines(), setting)
    }

    /// Window `step` at its place in time, of the planned length times `share`.
    pub(super) fn window(&self, step: u64, time: f64, share: f64, substeps: u64) -> Command {
        let dt = share * self.dt;
        Command { order: Order::Advance as u64, step, time, dt, substeps, ..Command::default() }
    }

    /// The first windows: of unequal lengths, with one sub-step, with many.
    pub(super) fn windows(&self, count: usize) -> Vec<Command> {
        const SHAPES: [(f64, u64); 6] = [(1.0, 8), (1.0, 8), (0.5, 1), (0.25, 3), (0.7, 20), (1.0, 7)];
        let mut time = 0.0;
        (0u64..)
            .zip(SHAPES.into_iter().cycle().take(count))
            .map(|(step, (share, substeps))| {
                let command = self.window(step, time, share, substeps);
                time += command.dt;
                command
            })
            .collect()
    }

    /// What the other side sends: loads of half the weight, upwards; or grains at rest where they began.
    fn lines(&self) -> Records {
        let scene = &self.setup.scene;
        match self.setup.role {
            Role::Dem => Records::Loads(
                scene
                    .grains
                    .iter()
                    .map(|grain| Loads {
                        force: scene.scene.gravity.start().map(|g| -0.5 * g * grain.mass()),
                        ..Loads::default()
                    })
                    .collect(),
            ),
            Role::Fluid => Records::Kinematics(
                self.at_start().into_iter().map(|grain| Kinematics { velocity: [0.0; 3], ..grain }).collect(),
            ),
        }
    }

    /// The grains as they begin.
    pub(super) fn at_start(&self) -> Vec<Kinematics> {
        let begin = |grain: &Grain| Kinematics {
            position: grain.position,
            orientation: grain.orientation,
            velocity: grain.velocity.start(),
            ..Kinematics::default()
        };
        self.setup.scene.grains.iter().map(begin).collect()
    }
}
