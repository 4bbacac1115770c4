//! A run that alternates from window to window, or outgrows every physical speed, is no result.
//!
//! An exchange of forces once per window fails by alternating
//! ([`alternation`](bedload_program::alternation)): the second difference of a velocity changes its sign in
//! every window. Nothing physical does so for long: a
//! contact or a vortex lasts many windows, and one that a window is too long for rings and dies away. What
//! counts is therefore growth that goes on, or alternation that stays, and of it the energy: among many
//! grains one that rings in a contact is no failure of the exchange. Only what was exchanged is looked at, so
//! that this holds for any solver. The same difference classifies a run of a map when it is over.

use bedload_program::alternation::{Channel, strongest};
pub(crate) use bedload_program::unstable::NAME;
use bedload_program::unstable::{Found, SpeedLimit};
use bedload_scene::{CheckedScene, Motion};
use protocol::message::Kinematics;
use protocol::participant::Window;
use serde::{Deserialize, Serialize};

use crate::number::AXES;

/// What was seen so far: part of a checkpoint. A run that is resumed when its grains rest would else take the
/// last digits of their speeds for the largest speed so far, and their alternation for one that counts.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Seen {
    channels: Vec<[Channel; 6]>,
    windows: u64,
    /// Largest smooth speed so far.
    scale: f64,
}

/// Watches the motion of free grains, window by window.
#[derive(Clone, Debug)]
pub(crate) struct Alternation {
    /// Number, radius and mass of each.
    free: Vec<(usize, f64, f64)>,
    mass: f64,
    seen: Seen,
    limit: SpeedLimit,
}

impl Alternation {
    pub(crate) fn new(scene: &CheckedScene) -> Self {
        let free = scene.grains.iter().enumerate().filter(|(_, grain)| grain.motion == Motion::Free);
        let free: Vec<_> = free.map(|(index, grain)| (index, grain.radius, grain.mass())).collect();
        Self {
            seen: Seen { channels: vec![[Channel::default(); 6]; free.len()], windows: 0, scale: 0.0 },
            mass: free.iter().map(|(_, _, mass)| mass).sum(),
            free,
            limit: SpeedLimit::new(scene),
        }
    }

    pub(crate) fn seen(&self) -> &Seen {
        &self.seen
    }

    /// Goes on from what was seen before a checkpoint of the same scene.
    pub(crate) fn resume(&mut self, seen: Seen) {
        self.seen = seen;
    }

    /// Takes the motion at the end of a window; says what is wrong.
    pub(crate) fn take(&mut self, window: &Window, motion: &[Kinematics]) -> Option<Found> {
        let Seen { channels, windows, scale } = &mut self.seen;
        *windows += 1;
        let beyond =
            self.free.iter().find_map(|(grain, ..)| self.limit.judge(*grain, &motion[*grain], window));
        let grains = self.free.iter().zip(channels).map(|((grain, radius, mass), channels)| {
            let Kinematics { velocity: [x, y, z], spin, .. } = motion[*grain];
            let [a, b, c] = spin.map(|spin| radius * spin);
            (*mass, channels, [x, y, z, a, b, c])
        });
        let (largest, scale) = strongest(grains, *windows, scale, self.mass);
        beyond.or_else(|| {
            let (channel, place, value) = largest?;
            let what = ["velocity", "spin"][value / 3];
            let what = format!("{what}_{} of grain {}", AXES[value % 3], self.free[place].0);
            Some(channel.found(&what, window, (scale, "the largest speed")))
        })
    }
}

/// What a user can do.
pub(crate) const REMEDY: &str = "lower the fluid's dt, use coupling.scheme = \"iterated\" or heavier grains \
    (docs/stability.md); to go on all the same: --set 'coupling.force=[\"unstable\"]'";

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_scenes::scene;

    const BOX: &str = "until = 1e9\n[domain]\ngeometry = \"space\"\nlower = [0, 0, 0]\nupper = [4, 4, 4]\n\
                       boundary = { x = \"periodic\", y = \"periodic\", z = \"periodic\" }\n";

    fn window(step: u64) -> Window {
        Window { step, attempt: 0, time: step as f64, dt: 1.0, substeps: 1, output: false }
    }

    /// The window that ends a signal of the velocity along z.
    fn ends(signal: impl Fn(u64) -> f64) -> Option<u64> {
        ends_resumed(signal, u64::MAX)
    }

    /// The same for a run that goes on from a checkpoint before window `resumed`.
    fn ends_resumed(signal: impl Fn(u64) -> f64, resumed: u64) -> Option<u64> {
        let grain = "[[grains]]\nposition = [2, 2, 2]\nradius = 0.5\ndensity = 1.0\nvelocity = [0, 0, 1.0]\n";
        let scene = scene(format!("{BOX}{grain}"));
        let mut watch = Alternation::new(&scene);
        (0..2000).find(|step| {
            if *step == resumed {
                let seen = watch.seen().clone();
                watch = Alternation::new(&scene);
                watch.resume(seen);
            }
            let moved = Kinematics { velocity: [0.0, 0.0, signal(*step)], ..Kinematics::default() };
            watch.take(&window(*step), &[moved]).is_some()
        })
    }

    fn sign(n: u64) -> f64 {
        if n.is_multiple_of(2) { 1.0 } else { -1.0 }
    }

    #[test]
    fn what_grows_or_stays_from_window_to_window_ends_a_run() {
        let falls = |n: u64| -1.0 + (-(n as f64) / 20.0).exp();
        assert!(ends(falls).is_none());
        assert!(ends(|n| falls(n) + 1e-9 * 1.2_f64.powf(n as f64) * sign(n)).is_some_and(|at| at < 120));
        assert!(ends(|n| falls(n) + 0.05 * sign(n)).is_some_and(|at| at < 80));
        // Faster than anything: 20 times the unit speed that the grain is given.
        assert_eq!(ends(|n| 1.1_f64.powf(n as f64)), Some(32));
    }

    #[test]
    fn a_grain_at_rest_stays_at_rest_after_a_resume() {
        let at_rest = |n: u64| 1e-14 * 1.2_f64.powi((n % 40) as i32) * sign(n);
        let moved = |n: u64| if n < 100 { -1.0 } else { at_rest(n) };
        assert!(ends(moved).is_none());
        assert!(ends(at_rest).is_some(), "without the largest speed so far it would count");
        assert_eq!(ends_resumed(moved, 200), None);
    }

    #[test]
    fn what_dies_away_or_is_physical_does_not() {
        // A start that rings, contacts every few windows, a vibration of 5 windows, noise.
        assert!(ends(|n| -1.0 + 0.3 * 0.95_f64.powf(n as f64) * sign(n)).is_none());
        assert!(ends(|n| if n % 7 < 3 { 1.0 } else { -1.0 }).is_none());
        assert!(ends(|n| (std::f64::consts::TAU * n as f64 / 5.0).sin()).is_none());
        let mut state = 1_u64;
        let noise: Vec<f64> = (0..2000)
            .map(|_| {
                state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
                (state >> 33) as f64 / f64::from(u32::MAX >> 1) - 0.5
            })
            .collect();
        assert!(ends(|n| noise[n as usize]).is_none());
    }

    #[test]
    fn a_contact_that_begins_to_ring_does_not_however_small_what_was_before() {
        // Alternation of rounding for 10 windows, then a contact rings at 5 % and decays within 40 windows.
        let ring = |n: u64| if n < 110 { 1e-9 } else { 0.05 * (-((n - 110) as f64) / 40.0).exp() };
        assert!(ends(|n| if n < 100 { -1.0 } else { -1.0 + ring(n) * sign(n) }).is_none());
    }

    #[test]
    fn among_many_grains_the_energy_counts() {
        // One of 100 rings for ever at 5 % of the largest speed: no failure. All do: one. One at 20 %: one.
        let of_100 = |part: f64, ringing: usize| {
            let mut text = String::from(BOX);
            for number in 0..100 {
                let (i, k) = (number % 10, number / 10);
                text += &format!(
                    "[[grains]]\nposition = [{}, 2, {}]\nradius = 0.1\ndensity = 1.0\nvelocity = [0, 0, 1.0]\n",
                    0.2 + 0.4 * f64::from(i),
                    0.2 + 0.4 * f64::from(k)
                );
            }
            let mut watch = Alternation::new(&scene(text));
            (0..200).any(|step| {
                let moved: Vec<Kinematics> = (0..100)
                    .map(|grain| {
                        let ring = if grain < ringing { part * sign(step) } else { 0.0 };
                        Kinematics { velocity: [0.0, 0.0, 1.0 + ring], ..Kinematics::default() }
                    })
                    .collect();
                watch.take(&window(step), &moved).is_some()
            })
        };
        assert!(!of_100(0.05, 1) && of_100(0.05, 100) && of_100(0.2, 1));
        assert!(of_100(0.05, 10) && !of_100(0.02, 10));
    }
}
