//! When a window of the iterated scheme has converged: the motion that an attempt led to is that of the one
//! before.

use bedload_scene::CheckedScene;
use protocol::message::Kinematics;
use protocol::participant::Window;
use protocol::scheme::Iterations;
use serde::{Deserialize, Serialize};

use crate::number::norm;

/// Share of |g| dt that counts as speed: grains at rest have none of their own. In windows longer than D²/ν
/// the whole of it is far above any speed that a grain reaches.
const OF_WEIGHT: f64 = 0.3;

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct Tally {
    pub(crate) windows: u64,
    pub(crate) attempts: u64,
    /// Windows accepted without having converged.
    pub(crate) unconverged: u64,
}

/// What to do after an attempt.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Convergence {
    Repeat,
    Converged,
    /// The window is accepted because no attempt is left; the last relative change.
    Unconverged(f64),
}

/// Watches the attempts at a window.
#[derive(Clone, Debug)]
pub(crate) struct ConvergenceMonitor {
    rule: Iterations,
    gravity: f64,
    radii: Vec<f64>,
    /// Motion after the last attempt at this window; empty before the first.
    last: Vec<Moving>,
    expected: Vec<Moving>,
    state: MonitorState,
}

/// Velocity and spin of a grain, m/s and rad/s.
type Moving = [[f64; 3]; 2];

fn moving(motion: &Kinematics) -> Moving {
    [motion.velocity, motion.spin]
}

/// What of the windows before decides the next one; part of a checkpoint.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct MonitorState {
    tally: Tally,
    /// Motion at the start of the last window and at its end, where the next one is compared with it.
    past: [Vec<Moving>; 2],
    /// Its length, s.
    dt: f64,
}

impl ConvergenceMonitor {
    pub(crate) fn new(scene: &CheckedScene, rule: Iterations, state: MonitorState) -> Self {
        Self {
            rule,
            gravity: scene.scene.largest_gravity(),
            radii: scene.grains.iter().map(|grain| grain.radius).collect(),
            last: Vec::new(),
            expected: Vec::new(),
            state,
        }
    }

    pub(crate) fn state(&self) -> &MonitorState {
        &self.state
    }

    pub(crate) fn tally(&self) -> Tally {
        self.state.tally
    }

    /// Largest difference of a velocity, or of radius times spin, from `other`, over the largest speed and a
    /// share of what gravity gives in a window; infinite where there is no other. Grains at rest without
    /// gravity differ by nothing.
    fn change(&self, dt: f64, motion: &[Kinematics], other: &[Moving]) -> f64 {
        if other.is_empty() {
            return f64::INFINITY;
        }
        let (mut change, mut speed) = (0.0f64, 0.0f64);
        for ((now, other), radius) in motion.iter().zip(other).zip(&self.radii) {
            let differ = |a: [f64; 3], b: [f64; 3]| norm(&std::array::from_fn(|c| a[c] - b[c]));
            change = change.max(differ(now.velocity, other[0]));
            change = change.max(radius * differ(now.spin, other[1]));
            speed = speed.max(norm(&now.velocity)).max(radius * norm(&now.spin));
        }
        if change == 0.0 { 0.0 } else { change / (speed + OF_WEIGHT * self.gravity * dt) }
    }

    /// Assesses the attempt that led to `motion`; one that was `wrong` for another reason is not accepted
    /// while another can be made.
    pub(crate) fn assess(&mut self, window: &Window, motion: &[Kinematics], wrong: bool) -> Convergence {
        if window.attempt == 0 {
            self.last.clear();
        }
        let change = self.change(window.dt, motion, &self.last);
        let convergence = if !wrong && (change <= self.rule.tolerance || self.is_expected(window, motion)) {
            Convergence::Converged
        } else if window.attempt + 1 >= self.rule.max_iterations {
            if change <= self.rule.tolerance {
                Convergence::Converged
            } else {
                Convergence::Unconverged(change)
            }
        } else {
            Convergence::Repeat
        };
        self.last.clear();
        self.last.extend(motion.iter().map(moving));
        let tally = &mut self.state.tally;
        tally.attempts += 1;
        tally.windows += u64::from(convergence != Convergence::Repeat);
        tally.unconverged += u64::from(matches!(convergence, Convergence::Unconverged(_)));
        if convergence != Convergence::Repeat && self.rule.repeat_above > 0.0 {
            self.state.past.swap(0, 1);
            self.state.past[1].clone_from(&self.last);
            self.state.dt = window.dt;
        }
        convergence
    }

    /// Whether a first attempt leads to where velocities and spins go on to change as in the window before.
    fn is_expected(&mut self, window: &Window, motion: &[Kinematics]) -> bool {
        if window.attempt > 0 || self.rule.repeat_above == 0.0 {
            return false;
        }
        let MonitorState { past: [from, to], dt, .. } = &self.state;
        let later = 1.0 + window.dt / dt;
        self.expected.clear();
        self.expected.extend(from.iter().zip(to).map(|(from, to)| {
            std::array::from_fn(|k| std::array::from_fn(|c| from[k][c] + later * (to[k][c] - from[k][c])))
        }));
        self.change(window.dt, motion, &self.expected) <= self.rule.repeat_above
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_scenes::scene;

    const SCENE: &str = r#"
until = 1.0
gravity = [0.0, 0.0, -2.0]
[domain]
geometry = "space"
lower = [0.0, 0.0, 0.0]
upper = [4.0, 4.0, 4.0]
cells = [8, 8, 8]
boundary = { x = "periodic", y = "periodic", z = "no-slip" }
[medium]
density = 1.0
viscosity = 0.01
[[grains]]
position = [2.0, 2.0, 2.0]
radius = 0.5
density = 4.0
"#;

    fn watch(max_iterations: u64) -> ConvergenceMonitor {
        let rule = Iterations { tolerance: 1e-3, max_iterations, ..Iterations::default() };
        ConvergenceMonitor::new(&scene(SCENE), rule, MonitorState::default())
    }

    fn window(attempt: u64) -> Window {
        Window { step: 3, attempt, time: 0.3, dt: 0.5, substeps: 1, output: false }
    }

    fn moving(speed: f64, spin: f64) -> [Kinematics; 1] {
        [Kinematics { velocity: [0.0, speed, 0.0], spin: [spin, 0.0, 0.0], ..Kinematics::default() }]
    }

    #[test]
    fn a_window_takes_two_attempts_and_the_scale_is_speed_and_weight() {
        let mut watch = watch(5);
        assert_eq!(watch.assess(&window(0), &moving(3.0, 0.0), false), Convergence::Repeat);
        // |ΔU| = 3.4e-3 of 3 + 0.3 |g| dt = 3.3: just too much; then 3.2e-3.
        assert_eq!(watch.assess(&window(1), &moving(3.0034, 0.0), false), Convergence::Repeat);
        assert_eq!(watch.assess(&window(2), &moving(3.0002, 0.0), false), Convergence::Converged);
        // Spin counts with the radius.
        assert_eq!(watch.assess(&window(0), &moving(0.0, 0.0), false), Convergence::Repeat);
        assert_eq!(watch.assess(&window(1), &moving(0.0, 0.0007), false), Convergence::Repeat);
        assert_eq!(watch.assess(&window(2), &moving(0.0, 0.0002), false), Convergence::Converged);
        assert_eq!(watch.tally(), Tally { windows: 2, attempts: 6, unconverged: 0 });
        // What does not move any more, but was wrong, does not stand.
        assert_eq!(watch.assess(&window(0), &moving(1.0, 0.0), false), Convergence::Repeat);
        assert_eq!(watch.assess(&window(1), &moving(1.0, 0.0), true), Convergence::Repeat);
        assert_eq!(watch.assess(&window(2), &moving(1.0, 0.0), false), Convergence::Converged);
    }

    #[test]
    fn a_window_that_goes_as_expected_stands_at_once() {
        let mut watch = watch(5);
        watch.rule.repeat_above = 0.01;
        let mut go = |step: u64, dt: f64, speed: f64, wrong: bool| {
            let mut attempts = 0;
            loop {
                let window = Window { step, attempt: attempts, time: 0.0, dt, substeps: 1, output: false };
                attempts += 1;
                if watch.assess(&window, &moving(speed, 0.0), wrong && attempts == 1) != Convergence::Repeat {
                    return (attempts, watch.state().clone());
                }
            }
        };
        // Nothing is expected of the first two.
        assert_eq!(go(0, 0.5, 1.0, false).0, 2);
        assert_eq!(go(1, 0.5, 2.0, false).0, 2);
        // 3 is expected, over 3 + 0.3 |g| dt; then, in twice the time, 5.
        assert_eq!(go(2, 0.5, 3.03, false).0, 1);
        assert_eq!(go(3, 1.0, 5.1, false).0, 1);
        // A bounce, and the window after it, are not.
        assert_eq!(go(4, 0.5, -3.0, false).0, 2);
        assert_eq!(go(5, 0.5, -3.0, false).0, 2);
        assert_eq!(go(6, 0.5, -3.0, false).0, 1);
        // What is wrong does not stand.
        let (attempts, state) = go(7, 0.5, -3.0, true);
        assert_eq!(attempts, 2);
        assert_eq!(state.tally, Tally { windows: 8, attempts: 13, unconverged: 0 });
        assert_eq!(state.past[1], [[[0.0, -3.0, 0.0], [0.0; 3]]]);
    }

    #[test]
    fn rest_does_not_hang_and_the_last_attempt_is_counted() {
        let mut watch = watch(3);
        watch.gravity = 0.0;
        assert_eq!(watch.assess(&window(0), &moving(0.0, 0.0), false), Convergence::Repeat);
        assert_eq!(watch.assess(&window(1), &moving(0.0, 0.0), false), Convergence::Converged);
        assert_eq!(watch.assess(&window(0), &moving(1.0, 0.0), false), Convergence::Repeat);
        assert_eq!(watch.assess(&window(1), &moving(-1.0, 0.0), false), Convergence::Repeat);
        assert_eq!(watch.assess(&window(2), &moving(1.0, 0.0), false), Convergence::Unconverged(2.0));
        assert_eq!(watch.tally(), Tally { windows: 2, attempts: 5, unconverged: 1 });
    }
}
