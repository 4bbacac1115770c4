//! Speeds and energies that nothing in a scene leads to: such a run is no result.

use bedload_scene::speeds::{Speeds, norm};
use bedload_scene::{Appearing, CheckedScene, Grain, Motion, OverTime};
use protocol::message::{Kinematics, Loads};
use protocol::participant::Window;
use serde::{Deserialize, Serialize};

/// Name in `coupling.force`.
pub const NAME: &str = "unstable";

/// Speeds above this many times the largest that the scene leads to are not physical.
const BEYOND: f64 = 20.0;
/// Energy that grains gain counts from this many times what they had, and can have stored in contacts, on.
const GAINED: f64 = 2.0;
/// Below this part of it what they have now is what they had.
const NOISE: f64 = 0.1;
/// Contact times from one look at the gain to the next: what contacts had stored is out by then.
const LOOK: f64 = 10.0;
/// Looks in a row at which the gain must have grown …
const LOOKS: u32 = 4;
/// … by this factor each. What a crowd of pressed grains gives back grows in proportion to time at most: by a
/// third from the third look to the fourth.
const GREW: f64 = 1.5;
/// Looks in a row after which a gain counts that stays.
const STAYS: u32 = 30;

/// What is wrong, and where it began.
#[derive(Clone, Debug, PartialEq)]
pub struct Found {
    /// For the message.
    pub text: String,
    /// Window in which it began.
    pub window: u64,
}

impl Found {
    /// The message of a run that ends in `window`, with what a user can do.
    pub fn message(&self, window: &Window, remedy: &str) -> String {
        let Self { text, window: began } = self;
        let Window { step, time, .. } = window;
        format!("unstable from window {began} on (noticed in window {step}, t = {time} s): {text}; {remedy}")
    }
}

/// The largest speed of a grain that is physical, m/s.
#[derive(Clone, Debug)]
pub struct SpeedLimit {
    most: f64,
    appearing: Appearing,
}

impl SpeedLimit {
    /// Of a scene; none where nothing is expected to move.
    pub fn new(scene: &CheckedScene) -> Self {
        let speeds = Speeds::of(scene);
        // Grains at rest may find room to fall by their own size, and what contacts bore is let go.
        let largest = scene.grains.iter().map(|grain| grain.radius).fold(0.0, f64::max);
        let gravity = scene.scene.largest_gravity();
        let let_go = (2.0 * gravity * largest).sqrt();
        let expected = speeds.flow + speeds.grain.max(speeds.approach).max(let_go);
        let most = if expected > 0.0 { BEYOND * expected } else { f64::INFINITY };
        Self { most, appearing: Appearing::of(&scene.scene.walls) }
    }

    /// Counts `speed`, m/s, with which a grain starts, too.
    fn admit(&mut self, speed: f64) {
        self.most = self.most.max(BEYOND * speed);
    }

    /// Judges the speed of a grain at the end of a window.
    pub fn judge(&self, grain: usize, motion: &Kinematics, window: &Window) -> Option<Found> {
        let speed = norm(&motion.velocity);
        (speed > self.most).then(|| Found {
            text: format!(
                "grain {grain} moves at {speed:.3e} m/s in window {}, more than {BEYOND} times what forces and flow \
                 lead to ({:.3e} m/s){}",
                window.step,
                self.most / BEYOND,
                self.appearing.words(window.time + window.dt)
            ),
            window: window.step,
        })
    }
}

#[derive(Clone, Copy, Debug)]
struct Free {
    grain: usize,
    mass: f64,
    /// Moment of inertia, kg m².
    inertia: f64,
}

/// What was seen so far: part of a checkpoint.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Seen {
    /// Energy gained since it was least, beyond the work of the loads and of gravity, J.
    gain: f64,
    /// Largest kinetic energy before that, J.
    had: f64,
    /// Time, s, and gain, J, of the last look.
    looked: (f64, f64),
    /// Looks in a row at which it counted, at which it had grown, too, and the window of the first.
    above: u32,
    grown: u32,
    began: u64,
    /// Largest speed at the end of the first window of a run that starts from the state of another, m/s.
    start: f64,
}

/// Watches the energy of free grains that only contacts, loads and gravity act on: contacts take energy away,
/// or give back what they had stored. Too long a sub-step makes some.
pub(crate) struct Energy {
    free: Vec<Free>,
    gravity: OverTime<[f64; 3]>,
    /// Length along each component that is periodic, m.
    periods: [Option<f64>; 3],
    /// Least energy that contacts may have stored: Σ m g R, J.
    stored: f64,
    /// Time from look to look, s.
    every: f64,
    limit: SpeedLimit,
    /// Does the run start from the state of another, with its velocities?
    goes_on: bool,
    /// Does the scene move anything that grains touch: a wall, a prescribed grain?
    driven: bool,
    /// Kinetic energy and motion at the end of the last window; none at the start and after a resume.
    last: Option<(f64, Vec<Kinematics>)>,
    seen: Seen,
}

impl Energy {
    /// For the free grains of a scene whose contacts last `contact_time`, s.
    pub(crate) fn new(scene: &CheckedScene, contact_time: f64, seen: Seen) -> Self {
        let shared = &scene.scene;
        let free = || scene.grains.iter().enumerate().filter(|(_, grain)| grain.motion == Motion::Free);
        let of = |(index, grain): (usize, &Grain)| {
            let mass = grain.mass();
            Free { grain: index, mass, inertia: mass * grain.gyration() }
        };
        let g = shared.largest_gravity();
        let mut limit = SpeedLimit::new(scene);
        limit.admit(seen.start);
        Self {
            free: free().map(of).collect(),
            gravity: shared.gravity.clone(),
            periods: shared.domain.periods().map(|period| period.map(|(_, length)| length)),
            stored: free().map(|(_, grain)| grain.mass() * g * grain.radius).sum(),
            every: LOOK * contact_time,
            limit,
            goes_on: shared.dem.contains_key("initial_state"),
            driven: scene.contact_walls().iter().any(|wall| wall.moves())
                || scene.grains.iter().any(|grain| grain.motion == Motion::Prescribed),
            last: None,
            seen,
        }
    }

    pub(crate) fn seen(&self) -> Seen {
        self.seen
    }

    /// Takes what acted in a window and the motion at its end; says what is wrong.
    pub(crate) fn take(&mut self, window: &Window, loads: &[Loads], motion: &[Kinematics]) -> Option<Found> {
        let there = |free: &&Free| motion.get(free.grain).is_some_and(Kinematics::is_there);
        let gravity = self.gravity.mean(window.time, window.time + window.dt);
        let (mut kinetic, mut given) = (0.0, 0.0);
        if self.goes_on && window.step == 0 {
            let speeds = self.free.iter().filter(there).map(|free| norm(&motion[free.grain].velocity));
            self.seen.start = speeds.fold(0.0, f64::max);
            self.limit.admit(self.seen.start);
        }
        for free in self.free.iter().filter(there) {
            let now = &motion[free.grain];
            let found = self.limit.judge(free.grain, now, window);
            if found.is_some() {
                return found;
            }
            let energy = now.kinetic_energy(free.mass, free.inertia);
            kinetic += energy;
            given += match &self.last {
                Some((_, before)) if before[free.grain].is_there() => {
                    let load = loads.get(free.grain).map_or([0.0; 3], |load| load.force);
                    self.work(free, (gravity, load), [&before[free.grain], now], window.dt)
                }
                // An inserted grain brings its energy with it.
                _ => energy,
            };
        }
        if self.driven {
            return None;
        }
        let (found, mut kept) = match self.last.take() {
            None => (None, Vec::new()),
            Some((energy, kept)) => {
                let gain = (self.seen.gain + kinetic - energy - given).max(0.0);
                (self.seen.take(window, gain, kinetic, self.stored, self.every), kept)
            }
        };
        kept.clear();
        kept.extend_from_slice(motion);
        self.last = Some((kinetic, kept));
        let wall = || self.limit.appearing.words(window.time + window.dt);
        found.map(|found| Found { text: found.text + &wall(), ..found })
    }

    /// Work of gravity and load on a grain in a window, J.
    fn work(
        &self,
        free: &Free,
        (gravity, load): ([f64; 3], [f64; 3]),
        [before, now]: [&Kinematics; 2],
        dt: f64,
    ) -> f64 {
        let along = |c: usize| {
            let way = now.position[c] - before.position[c];
            // Images: the one nearest to where its velocities lead.
            let period = self.periods[c].map_or(0.0, |period| {
                let led = 0.5 * (before.velocity[c] + now.velocity[c]) * dt;
                period * ((led - way) / period).round()
            });
            (free.mass * gravity[c] + load[c]) * (way + period)
        };
        (0..3).map(along).sum()
    }
}

impl Seen {
    fn take(&mut self, window: &Window, gain: f64, kinetic: f64, stored: f64, every: f64) -> Option<Found> {
        self.gain = gain;
        let end = window.time + window.dt;
        // At the start pressed grains may set free what they had stored.
        if end <= every || gain <= NOISE * (self.had + stored) {
            self.had = self.had.max(kinetic);
        }
        let all = self.had + stored;
        if gain <= GAINED * all {
            (self.above, self.grown, self.looked) = (0, 0, (end, gain));
            return None;
        }
        let (time, before) = self.looked;
        if end - time < every {
            return None;
        }
        if self.above == 0 {
            self.began = window.step;
        }
        self.above += 1;
        self.grown = if gain >= GREW * before { self.grown + 1 } else { 0 };
        self.looked = (end, gain);
        (self.grown >= LOOKS || self.above >= STAYS).then(|| Found {
            text: format!(
                "the grains have gained {gain:.3e} J beyond what gravity and loads gave, where they and their \
                 contacts had {all:.3e} J: contacts give more energy than they take"
            ),
            window: self.began,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The window that ends grains of 1 J, of which contacts may have stored 0.1 J, whose energy gained is
    /// `gain` of the window; two of them in ten contact times.
    fn ends(gain: impl Fn(u64) -> f64) -> Option<u64> {
        let mut seen = Seen::default();
        (0..500).find(|step| {
            let window =
                Window { step: *step, attempt: 0, time: *step as f64, dt: 1.0, substeps: 1, output: false };
            let gained = gain(*step);
            seen.take(&window, gained, 1.0 + gained, 0.1, 2.0).is_some()
        })
    }

    #[test]
    fn energy_that_grows_or_stays_ends_a_run() {
        assert!(ends(|n| 1e-6 * 1.3_f64.powf(n as f64)).is_some_and(|at| at < 75));
        assert!(ends(|n| if n < 10 { 0.0 } else { 3.0 }).is_some_and(|at| (65..75).contains(&at)));
    }

    #[test]
    fn what_contacts_give_back_does_not() {
        // A bounce that lasts for windows, noise, and a crowd that was pressed together and flies apart.
        assert_eq!(ends(|n| [0.0, 0.5, 1.0, 0.4][n as usize % 4]), None);
        assert_eq!(ends(|n| 1e-3 * f64::from(n.is_multiple_of(3))), None);
        assert_eq!(ends(|n| 0.9 * n.min(3) as f64), None);
        assert_eq!(ends(|n| if (50..100).contains(&n) { 0.05 * (n - 49) as f64 } else { 0.0 }), None);
    }
}
