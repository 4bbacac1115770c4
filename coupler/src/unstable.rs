//! A run that alternates from window to window, or outgrows every physical speed, is no result.
//!
//! An exchange of forces once per window fails by alternating: the second difference of a velocity, d_n =
//! (v_n − 2 v_{n−1} + v_{n−2})/4, changes its sign in every window. Nothing physical does so for long: a
//! contact or a vortex lasts many windows, and one that a window is too long for is over in a few. Only what
//! was exchanged is looked at, so that this holds for any solver. The same difference classifies a run of a
//! map when it is over.

use bedload_scene::{CheckedScene, Motion};
use protocol::message::Kinematics;
use protocol::participant::Window;
use serde::{Deserialize, Serialize};

use crate::number::{Short, norm};
use crate::speeds::Speeds;

/// Name in `coupling.force`.
pub(crate) const NAME: &str = "unstable";

/// Windows in a row whose d must alternate. Noise does so by chance with 0.73 a window, once in 2·10⁷
/// windows.
const ROW: u32 = 54;
/// Fewer suffice where d has grown …
const GROWING_ROW: u32 = 16;
/// … by this factor from the first third of them, without a window of less than half the one before …
const GROWN: f64 = 8.0;
/// Alternation above this part of the largest smooth speed so far counts: as in a map.
const PART: f64 = 0.01;
/// Alternation that falls to this part of its largest value dies away.
const DECAYED: f64 = 0.3679;
/// Speeds above this many times the largest that the scene leads to are not physical.
const BEYOND: f64 = 20.0;

/// One component of a velocity, or of a spin times the radius.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
struct Channel {
    last: [f64; 2],
    difference: f64,
    /// Windows in a row with d of alternating sign.
    row: u32,
    /// |d| when the row began, its largest since.
    first: f64,
    largest: f64,
}

/// What began where.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Found {
    pub(crate) text: String,
    /// Window in which it began.
    pub(crate) window: u64,
}

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
    free: Vec<(usize, f64)>,
    seen: Seen,
    /// Beyond it no speed is physical.
    limit: f64,
}

impl Alternation {
    /// For the free grains of a scene.
    pub(crate) fn new(scene: &CheckedScene) -> Self {
        let free = scene.grains.iter().enumerate().filter(|(_, grain)| grain.motion == Motion::Free);
        let free: Vec<(usize, f64)> = free.map(|(index, grain)| (index, grain.radius)).collect();
        let speeds = Speeds::of(scene);
        let expected = speeds.flow + speeds.grain;
        Self {
            seen: Seen { channels: vec![[Channel::default(); 6]; free.len()], windows: 0, scale: 0.0 },
            free,
            // A scene in which nothing is expected to move has no such limit.
            limit: if expected > 0.0 { BEYOND * expected } else { f64::INFINITY },
        }
    }

    /// What was seen so far.
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
        let (mut smooth, mut found) = (*scale, None);
        for ((grain, radius), channels) in self.free.iter().zip(channels) {
            let Kinematics { velocity, spin, .. } = motion[*grain];
            let speed = norm(&velocity);
            if speed > self.limit && found.is_none() {
                found = Some(Found {
                    text: format!(
                        "grain {grain} moves at {} m/s in window {}, more than {BEYOND} times what forces and flow lead to ({} m/s)",
                        Short(speed),
                        window.step,
                        Short(self.limit / BEYOND)
                    ),
                    window: window.step,
                });
            }
            let values = velocity.into_iter().chain(spin.map(|spin| radius * spin));
            for (place, (channel, value)) in channels.iter_mut().zip(values).enumerate() {
                smooth = smooth.max(channel.take(value, *windows));
                if channel.is_unstable(*scale) && found.is_none() {
                    found = Some(channel.found(*grain, place, window, *scale));
                }
            }
        }
        *scale = smooth;
        found
    }
}

impl Channel {
    /// Returns the smooth part.
    fn take(&mut self, value: f64, windows: u64) -> f64 {
        let [before, last] = self.last;
        self.last = [last, value];
        if windows < 3 {
            return 0.0;
        }
        let difference = (value - 2.0 * last + before) / 4.0;
        let alternates = difference * self.difference < 0.0;
        let fell = difference.abs() < 0.5 * self.difference.abs();
        if alternates && !fell {
            self.row += 1;
            self.largest = self.largest.max(difference.abs());
        } else {
            *self = Self { row: 0, first: difference.abs(), largest: difference.abs(), ..*self };
        }
        self.difference = difference;
        ((value + 2.0 * last + before) / 4.0).abs()
    }

    fn is_unstable(&self, scale: f64) -> bool {
        let size = self.difference.abs();
        if size < PART * scale || size < DECAYED * self.largest {
            return false;
        }
        self.row >= ROW || (self.row >= GROWING_ROW && size >= GROWN * self.first)
    }

    fn found(&self, grain: usize, place: usize, window: &Window, scale: f64) -> Found {
        let what = ["velocity", "spin"][place / 3];
        let axis = ["x", "y", "z"][place % 3];
        let began = window.step.saturating_sub(u64::from(self.row));
        let grows = if self.difference.abs() >= GROWN * self.first { "and grows, " } else { "" };
        Found {
            text: format!(
                "{what}_{axis} of grain {grain} alternates from window to window since window {began}, {grows}by {:.1} % of the \
                 largest speed",
                100.0 * self.difference.abs() / scale
            ),
            window: began,
        }
    }
}

/// What a user can do.
pub(crate) const REMEDY: &str = "lower the fluid's dt, use coupling.scheme = \"iterated\" or heavier grains (docs/stability.md); to go on all the same: --set \
     'coupling.force=[\"unstable\"]'";

#[cfg(test)]
mod tests {
    use super::*;
    use bedload_scene::SceneSource;

    /// The window that ends a signal of the velocity along z.
    fn ends(signal: impl Fn(u64) -> f64) -> Option<u64> {
        ends_resumed(signal, u64::MAX)
    }

    /// The same for a run that goes on from a checkpoint before window `resumed`.
    fn ends_resumed(signal: impl Fn(u64) -> f64, resumed: u64) -> Option<u64> {
        let text = "until = 1e9\n[domain]\ngeometry = \"space\"\nlower = [0, 0, 0]\nupper = [4, 4, 4]\n\
                    boundary = { x = \"periodic\", y = \"periodic\", z = \"periodic\" }\n\
                    grains = [{ position = [2, 2, 2], radius = 0.5, density = 1.0, velocity = [0, 0, 1.0] }]\n";
        let text =
            format!("{}\n{}", &text[text.find("grains").unwrap()..], &text[..text.find("grains").unwrap()]);
        let scene = CheckedScene::new(SceneSource { file: "s.toml".into(), text }).unwrap();
        let mut watch = Alternation::new(&scene);
        (0..2000).find(|step| {
            if *step == resumed {
                let seen = watch.seen().clone();
                watch = Alternation::new(&scene);
                watch.resume(seen);
            }
            let window =
                Window { step: *step, attempt: 0, time: *step as f64, dt: 1.0, substeps: 1, output: false };
            let moved = Kinematics { velocity: [0.0, 0.0, signal(*step)], ..Kinematics::default() };
            watch.take(&window, &[moved]).is_some()
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
}
