//! A value that alternates from window to window, and a fluid alone that does so or outgrows its speeds.
//!
//! What fails by its windows alternates with them: the second difference d_n = (v_n − 2 v_{n−1} + v_{n−2})/4
//! changes its sign in every window. Of a fluid alone the loads on held grains are looked at: what carries
//! the force on grains from window to window fails so. The largest speed of a field is no such value: beside
//! a cylinder it alternates by 1.6 % for long after a sudden start with AB2, and the drag is right.

use bedload_scene::CheckedScene;
use bedload_scene::speeds::Speeds;
use protocol::message::Loads;
use protocol::participant::Window;
use serde::{Deserialize, Serialize};

use crate::unstable::Found;

/// Windows in a row whose d must alternate. Noise does so by chance with 0.73 a window, once in 2·10⁷
/// windows.
const ROW: u32 = 54;
/// Fewer suffice where d has grown by …
const GROWING_ROW: u32 = 16;
/// … this factor since the row began, and …
const GROWN: f64 = 8.0;
/// … goes on growing: the mean of ln |d_n/d_{n−1}| over the last windows, of which none counts for more than
/// a doubling.
const GROWTH: f64 = 0.08;
/// A jump by more than this factor begins a new row: a contact, which rings and is no growth. What grows so
/// fast is soon faster than anything.
const JUMP: f64 = 4.0;
/// Windows over which that mean forgets.
const FORGETS: f64 = 8.0;
/// Alternation counts whose energy is above the square of this part of the energy that all free grains would
/// have at the largest smooth speed so far. Of one grain: 1 % of that speed, as in a map.
const PART: f64 = 0.01;
/// Alternation that falls to this part of its largest value dies away.
const DECAYED: f64 = 0.3679;

/// One value window by window: a component of a velocity or of a load, a speed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Channel {
    last: [f64; 2],
    difference: f64,
    /// Windows in a row with d of alternating sign.
    row: u32,
    /// |d| when the row began, its largest since.
    first: f64,
    largest: f64,
    /// How fast it grows, 1/window.
    growth: f64,
}

impl Channel {
    /// Takes the value of window number `windows`, from 1; returns its smooth part.
    pub fn take(&mut self, value: f64, windows: u64) -> f64 {
        let [before, last] = self.last;
        self.last = [last, value];
        if windows < 3 {
            return 0.0;
        }
        let difference = (value - 2.0 * last + before) / 4.0;
        let alternates = difference * self.difference < 0.0;
        let (size, before) = (difference.abs(), self.difference.abs());
        let goes_on = (0.5 * before..=JUMP * before).contains(&size);
        if alternates && goes_on {
            self.row += 1;
            self.largest = self.largest.max(size);
            let grew = (size / before).min(2.0).ln();
            self.growth += (grew - self.growth) / FORGETS;
        } else {
            *self = Self { row: 0, first: size, largest: size, growth: 0.0, ..*self };
        }
        self.difference = difference;
        ((value + 2.0 * last + before) / 4.0).abs()
    }

    /// Size of its alternation: |d| of the last window.
    pub fn size(&self) -> f64 {
        self.difference.abs()
    }

    /// Does it alternate: growth that goes on, or what stays?
    pub fn alternates(&self) -> bool {
        let grows = self.row >= GROWING_ROW && self.size() >= GROWN * self.first && self.growth >= GROWTH;
        grows || (self.row >= ROW && self.size() >= DECAYED * self.largest)
    }

    /// What is said of `what` that alternates in `window`, as a part of `scale`, which is `whole`.
    pub fn found(&self, what: &str, window: &Window, (scale, whole): (f64, &str)) -> Found {
        let began = window.step.saturating_sub(u64::from(self.row));
        let grows = if self.growth >= GROWTH { "and grows, " } else { "" };
        let part = 100.0 * self.size() / scale;
        Found {
            text: format!(
                "{what} alternates from window to window since window {began}, {grows}by {part:.1} % of {whole}"
            ),
            window: began,
        }
    }
}

/// Takes the weight, the channels and the values of each grain in window number `windows`. Returns the
/// channel that alternates most, with the places of its grain and of its value, where Σ weight · d² of all
/// that do so counts beside `scale`, the largest smooth value so far, of a grain of weight `whole`; and that
/// scale, which then takes in this window.
pub fn strongest<'a, const N: usize>(
    grains: impl Iterator<Item = (f64, &'a mut [Channel; N], [f64; N])>,
    windows: u64,
    scale: &mut f64,
    whole: f64,
) -> (Option<(Channel, usize, usize)>, f64) {
    let before = *scale;
    let (mut sum, mut largest) = (0.0, None);
    for (grain, (weight, channels, values)) in grains.enumerate() {
        for (place, (channel, value)) in channels.iter_mut().zip(values).enumerate() {
            *scale = scale.max(channel.take(value, windows));
            if channel.alternates() {
                sum += weight * channel.size().powi(2);
                if largest.is_none_or(|(other, ..): (Channel, _, _)| channel.size() > other.size()) {
                    largest = Some((*channel, grain, place));
                }
            }
        }
    }
    (largest.filter(|_| sum >= whole * (PART * before).powi(2)), before)
}

/// Speeds of a fluid above this many times the largest that the scene leads to, or that it had in its first
/// window, are not physical; a jet through a gap of one of some hundred cells is.
const BEYOND: f64 = 1000.0;

/// What was seen so far of a fluid alone: part of a checkpoint.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct FlowSeen {
    windows: u64,
    /// Largest speed after the first window, m/s.
    first: f64,
    /// Largest smooth force so far, N.
    scale: f64,
    forces: Vec<[Channel; 3]>,
}

/// Watches a fluid alone, window by window.
pub(crate) struct Flow {
    /// Largest speed that the scene leads to, m/s.
    expected: f64,
    seen: FlowSeen,
}

impl Flow {
    /// Of a scene, from what was seen before.
    pub(crate) fn new(scene: &CheckedScene, seen: FlowSeen) -> Self {
        Self { expected: Speeds::of(scene).largest(), seen }
    }

    pub(crate) fn seen(&self) -> &FlowSeen {
        &self.seen
    }

    /// Takes loads and largest speed, m/s, of a window; says what is wrong.
    pub(crate) fn take(&mut self, window: &Window, loads: &[Loads], speed: f64) -> Option<Found> {
        let FlowSeen { windows, first, scale, forces } = &mut self.seen;
        *windows += 1;
        if *windows == 1 {
            *first = speed;
            forces.resize(loads.len(), Default::default());
        }
        let limit = BEYOND * self.expected.max(*first);
        if limit > 0.0 && speed > limit {
            let text = format!(
                "the fluid moves at {speed:.3e} m/s, more than {BEYOND} times what the scene leads to ({:.3e} m/s)",
                limit / BEYOND
            );
            return Some(Found { text, window: window.step });
        }
        let forces = forces.iter_mut().zip(loads).map(|(channels, load)| (1.0, channels, load.force));
        let (largest, scale) = strongest(forces, *windows, scale, loads.len() as f64);
        largest.map(|(channel, grain, axis)| {
            let what = format!("force_{} of grain {grain}", ["x", "y", "z"][axis]);
            channel.found(&what, window, (scale, "the largest force"))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use bedload_scene::SceneSource;

    /// What ends a fluid past one held grain, of which force and largest speed are functions of the window.
    fn ends(force: impl Fn(u64) -> f64, speed: impl Fn(u64) -> f64) -> Option<String> {
        let text = "until = 1e9\n[domain]\ngeometry = \"space\"\nlower = [0, 0, 0]\nupper = [4, 4, 4]\n\
                    cells = [32, 32, 32]\nboundary = { x = \"periodic\", y = \"periodic\", z = \"periodic\" }\n\
                    [medium]\ndensity = 1.0\nviscosity = 1.0\n\
                    initial = { type = \"uniform\", velocity = [1.0, 0.0, 0.0] }\n\
                    [[grains]]\nposition = [2, 2, 2]\nradius = 0.5\ndensity = 1.0\nmotion = \"fixed\"\n";
        let scene = CheckedScene::new(SceneSource { file: "s.toml".into(), text: text.into() }).unwrap();
        let mut flow = Flow::new(&scene, FlowSeen::default());
        (0..500).find_map(|step| {
            let window = Window { step, attempt: 0, time: step as f64, dt: 1.0, substeps: 1, output: false };
            if step == 200 {
                flow = Flow::new(&scene, flow.seen().clone());
            }
            let loads = [Loads { force: [force(step), 0.0, 0.0], ..Loads::default() }];
            flow.take(&window, &loads, speed(step)).map(|found| found.text)
        })
    }

    fn sign(n: u64) -> f64 {
        if n.is_multiple_of(2) { 1.0 } else { -1.0 }
    }

    #[test]
    fn what_alternates_or_outgrows_the_scene_ends_a_fluid_alone() {
        let decays = |n: u64| 1.0 + (-(n as f64) / 30.0).exp();
        let says =
            |found: Option<String>, what: &str| assert!(found.clone().unwrap().contains(what), "{found:?}");
        says(ends(|n| decays(n) + 0.05 * sign(n), decays), "force_x of grain 0 alternates");
        says(ends(|n| decays(n) + 1e-9 * 1.15_f64.powf(n as f64) * sign(n), decays), "and grows");
        says(ends(decays, |n| 1.2_f64.powf(n as f64)), "more than 1000 times");
    }

    #[test]
    fn flows_that_ring_die_away_or_jet_go_on() {
        let decays = |n: u64| 1.0 + (-(n as f64) / 30.0).exp();
        assert_eq!(ends(|n| decays(n) + 0.4 * 0.95_f64.powf(n as f64) * sign(n), decays), None);
        assert_eq!(ends(|n| decays(n) + 0.005 * sign(n), decays), None);
        assert_eq!(ends(decays, |n| decays(n) + 0.05 * sign(n)), None);
        assert_eq!(ends(|n| (std::f64::consts::TAU * n as f64 / 5.0).sin(), |_| 1.0), None);
        // 300 times the speed of the scene from the first window on: a narrow gap.
        assert_eq!(ends(decays, |n| 300.0 * decays(n)), None);
    }
}
